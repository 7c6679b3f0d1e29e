"""The command line: thin; everything it does is in `rrp_sheets.api`."""
