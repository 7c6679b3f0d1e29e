"""Changing an existing .xlsx inside its package: only the parts that must change are written anew."""
