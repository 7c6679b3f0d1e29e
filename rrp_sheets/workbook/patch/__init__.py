"""Changing an existing .xlsx inside its package: only what must change is written anew, byte by byte."""
