"""Replays of recorded runs: with their own workbook, where everything must be the same, or with another one."""

from rrp_sheets.runs.replay.differences import Count, Difference
from rrp_sheets.runs.replay.replaying import replay
from rrp_sheets.runs.replay.result import Replayed

__all__ = ["Count", "Difference", "Replayed", "replay"]
