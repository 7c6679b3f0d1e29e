"""Replays of recorded runs: with their own workbook, where everything must be the same, or with another one."""

from rrp_sheets.replay.replaying import replay
from rrp_sheets.replay.result import Replayed

__all__ = ["Replayed", "replay"]
