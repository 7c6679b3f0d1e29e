"""Main of every worker process: `python -m rrp_sheets.workers TASK LIMITS LINK [SHARED …]`.

TASK is the dotted name of a function, which is imported here only; LIMITS are the rest of a `Task`, as JSON; LINK and
SHARED are numbers of open files.
"""

from __future__ import annotations

import json
import sys

from rrp_sheets.workers.worker_loop import do_task

if __name__ == "__main__":
    do_task(sys.argv[1], json.loads(sys.argv[2]), *map(int, sys.argv[3:]))
