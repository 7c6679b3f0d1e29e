"""Texts of `rrp-sheets help` and of the help of the grid, one module for every kind of topic."""
