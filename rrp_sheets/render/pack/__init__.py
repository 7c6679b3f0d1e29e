"""The ethics pack: the information that an ethics board asks for, as data and as an accessible PDF."""

from rrp_sheets.render.pack.front import Print
from rrp_sheets.render.pack.make import make_pack
from rrp_sheets.render.pack.model import Changes, Pack, TestSheetResult, VersionDifference

__all__ = ["Changes", "Pack", "Print", "TestSheetResult", "VersionDifference", "make_pack"]
