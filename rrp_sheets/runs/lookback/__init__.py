"""Looking back at a recorded run: what every row and stream had at any time, what was seen, how the robot stood.

A long run is told in pieces. All of it is read in the clerk's process (`runs/records/query_worker.py`), as a record may come
from anywhere.
"""

from rrp_sheets.runs.lookback.answers import answer

__all__ = ["answer"]
