"""A bundle: a zip with a workbook and all that another machine, or next year, needs to run it again."""
