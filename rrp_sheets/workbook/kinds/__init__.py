"""Readers of every kind of sheet: from its rows to the model."""
