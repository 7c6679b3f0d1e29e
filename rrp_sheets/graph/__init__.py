"""Rows as a graph: which stream feeds which row, in which order the rows settle."""

from rrp_sheets.graph.model import BehaviourGraph, Graph, Step, Stream, StreamKind

__all__ = ["BehaviourGraph", "Graph", "Step", "Stream", "StreamKind"]
