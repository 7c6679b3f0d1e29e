"""The screens of what was recorded and kept: runs, versions, comparisons, and the page that is printed."""
