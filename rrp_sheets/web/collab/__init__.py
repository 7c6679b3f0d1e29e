"""Workbooks that several people edit at once: sessions, cell locks and event streams."""
