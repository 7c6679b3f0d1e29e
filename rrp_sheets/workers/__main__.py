"""Main of every worker process: `python -m rrp_sheets.workers TASK LIMITS LINK [SHARED …]`.

TASK is the dotted name of a function, which is imported here only; LIMITS are the rest of a `Task`, as JSON; LINK and
SHARED are numbers of open files.
"""

from __future__ import annotations

import json
import sys

from rrp_sheets.workers.worker_loop import begin, named


def main() -> None:
    """Set the process up, and do its task until the connection closes."""
    task, limits, link, *shared = sys.argv[1:]
    connection = begin(int(link), *json.loads(limits))
    named(task)(connection, *map(int, shared))


if __name__ == "__main__":
    main()
