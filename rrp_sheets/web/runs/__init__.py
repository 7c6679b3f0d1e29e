"""Recorded runs in the browser: access to them and data of their pages."""
