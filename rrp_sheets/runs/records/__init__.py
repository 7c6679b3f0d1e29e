"""Recorded runs as people look at them: facts, log, curves, marbles, a table; all read in a bounded time."""
