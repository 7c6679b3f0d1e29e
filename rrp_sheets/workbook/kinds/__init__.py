"""One small module for every kind of sheet: from its rows to the model."""
