"""Tests in the grid: run in a worker process after each edit, and shown beside the sheet and in its rows."""
