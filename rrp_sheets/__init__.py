"""RRP Sheets: robot behaviours as rows of a spreadsheet.

The facade is :mod:`rrp_sheets.api`; nothing is imported here, so that the command line starts quickly.
"""

__version__ = "0.2.0"
