"""Looking back at a recorded run: what every row and stream had at any time, what was seen, how the robot stood.

A long run is told in pieces. A process of its own (`runs/records/query_worker.py`) reads it, as a record may come from
anywhere.
"""

from rrp_sheets.runs.lookback.answers import answer

__all__ = ["answer"]
