"""Browser interface: the server, the pages and the grid for the workbooks of a folder."""
