"""The Scene sheet: its words, the actions that its rows give, and the scene of a workbook without one."""
