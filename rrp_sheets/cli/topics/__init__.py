"""What `rrp-sheets help` says, one module for every kind of topic; each gives text without knowing of the terminal."""
