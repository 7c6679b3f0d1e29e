"""Data for looking back at a recorded run: values of all rows and streams, camera pictures, poses of the robot.

A long run is sent in pieces. A process of its own (`runs/records/query_worker.py`) reads it, as records are untrusted.
"""

from rrp_sheets.runs.lookback.answers import answer

__all__ = ["answer"]
