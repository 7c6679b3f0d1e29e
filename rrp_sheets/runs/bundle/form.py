"""What stands where in a bundle.

Unpacked by hand it is a folder to work in: sounds, robot and runs beside the workbook.
"""

from __future__ import annotations

SUFFIX = ".zip"
LIST = "versions.json"
README = "README.txt"
PAPER = "protocol.pdf"
RUNS = "runs"
ROBOTS = "robots"
KIND = "rrp-sheets bundle"
SCHEMA = 1  # grows when an entry of the list changes its meaning or goes
MOST_FILES = 2_000
MOST_BYTES = 2_000_000_000
