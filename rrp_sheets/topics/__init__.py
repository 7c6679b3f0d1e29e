"""What `rrp-sheets help` and the help of the grid say, one module for every kind of topic."""
