"""Tests in the grid: run in a process of their own after each edit, and shown beside the sheet and in its rows."""
