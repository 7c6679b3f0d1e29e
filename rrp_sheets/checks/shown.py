"""Example values to be shown beside the rows."""

from __future__ import annotations

from rrp_sheets.checks.check import Checked
from rrp_sheets.checks.facts import Fact


def row_examples(checked: Checked) -> dict[str, Fact]:
    """Return the fact about each row's output, by the row's ref (`Tracking!4`), in the order of the sheets.

    Rows without an example are missing: those that are off or wrong, and those of which nothing can be said.
    """
    found: dict[str, Fact] = {}
    for behaviour in checked.graph.behaviours:
        for step in behaviour.steps:
            fact = checked.facts.get(step.ref if step.connector.is_sink else step.output)
            if step.row.on and fact is not None and fact.has_example:
                found[step.ref] = fact
    return found
