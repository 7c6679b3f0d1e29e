"""Limits of the size of a workbook. It may come from anyone, so everything has a bound."""

from __future__ import annotations

FILE_BYTES = 5_000_000
INFLATED_BYTES = 40_000_000
PART_BYTES = 20_000_000
RATIO = 150
RATIO_FROM_BYTES = 100_000
"""Smaller parts may be compressed better than RATIO: 200 equal formatted rows are honest and harmless."""
PARTS = 200
SHEETS = 60

ROWS = 10_000
COLUMNS = 200
CELLS = 100_000
MERGED_CELLS = 20_000
CELL_ELEMENTS = 400_000
"""Cells of a sheet including the formatted blank ones, which are skipped but take time."""
TEXT_CELLS = 1_000_000
"""Cells of a CSV or Markdown file, blank ones included."""
SHARED_STRINGS = 300_000

HEADER_ROWS = 20
HEAD_CELLS = HEADER_ROWS * COLUMNS
TABLE_ROWS = 1_000
TABLE_COLUMNS = 30
TABLE_TEXT = 2_000
"""Letters in a cell of a table, as many as a text of a formula may have."""
CELL_CHARACTERS = 32_767
TEXT_CHARACTERS = 3_000_000
"""Of all sheets of ours together."""
NAMES = 50
"""Names in one cell."""
FINDINGS = 1_000
"""After so many, reading tells of no more: nobody reads them, and a hostile file could hold a million."""

XML_ELEMENTS = 1_500_000
"""Of all parts that are read; takes about a second."""
XML_DEPTH = 100
XML_TOKEN_BYTES = 1_000_000
"""The longest text or tag."""
