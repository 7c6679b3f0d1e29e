"""Worker processes that print protocols and pack bundles."""
