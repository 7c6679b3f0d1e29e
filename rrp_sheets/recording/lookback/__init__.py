"""Data for looking back at a recorded run: values of all rows and streams, camera pictures, poses of the robot.

A long run is sent in pieces. A process of its own (`services/query_worker.py`) reads it, as records are untrusted.
"""

from rrp_sheets.recording.lookback.answers import answer

__all__ = ["answer"]
