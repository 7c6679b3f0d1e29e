"""Recorded runs: lists, metadata, log, curves, marbles, tables, exports, deletion; all read in a bounded time."""
