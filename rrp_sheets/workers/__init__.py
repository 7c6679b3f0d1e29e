"""Worker processes: their start and supervision, and the transport between them and their starters."""
