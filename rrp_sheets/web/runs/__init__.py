"""Recorded runs in the browser: access to them, data of their pages, and printed protocols."""
