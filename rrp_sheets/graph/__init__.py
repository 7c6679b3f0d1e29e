"""Graph of a workbook's rows: which stream feeds which row, and the order in which the rows are evaluated."""

from rrp_sheets.graph.model import BehaviourGraph, Graph, Step, Stream, StreamKind

__all__ = ["BehaviourGraph", "Graph", "Step", "Stream", "StreamKind"]
