"""Bundles: zip files with a workbook and all that is needed to run it again elsewhere or later."""
