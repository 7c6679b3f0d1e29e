"""Pages of recorded runs, kept versions, comparisons, and the printed protocol."""
