"""Workbooks under edit: grids whose rows keep their identity, a journal, undo, and the file kept up to date.

The web grid is one user of it; a notebook could be another. Everything here works without a browser.
"""

from rrp_sheets.documents.document import Document
from rrp_sheets.documents.grid import CellText, Changed, Refused

__all__ = ["CellText", "Changed", "Document", "Refused"]
