"""The workbooks of a folder in the browser. This version shows them; the grid that edits them comes later."""
