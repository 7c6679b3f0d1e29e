"""merge: every value of every input."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, merged

MERGE = Connector(
    name="merge",
    min_inputs=2,
    max_inputs=None,
    icon=('<path d="M1 2.2h2L6.6 6H11M1 9.8h2L6.6 6M8.9 3.9 11 6 8.9 8.1"/>'),
    help="All values of all its inputs, one after the other.",
    sentence="Whenever any of {inputs_or} comes, it goes on{onto}.",
    variants={"one": "{Input} goes on{onto}."},
    legend="any of its inputs",
    build=merged,
    any_input=True,
    example=("1---2---", "--a---b-"),
)
