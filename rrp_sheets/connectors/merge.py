"""merge: every value of every input."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, merged

MERGE = Connector(
    name="merge",
    min_inputs=2,
    max_inputs=None,
    icon=('<path d="M1 2.2h2L6.6 6H11M1 9.8h2L6.6 6M8.9 3.9 11 6 8.9 8.1"/>'),
    words=("join", "concat", "either", "合わせる", "まとめる"),
    help="Passes on every value of all its inputs.",
    sentence="Any of {inputs_or} becomes {output}.",
    variants={
        "next": "Each value of {inputs_or} is passed on to {rows}.",
        "one": "Each {one} becomes {output}.",
        "one_next": "Each {one} is passed on to {rows}.",
    },
    legend="any of its inputs",
    build=merged,
    any_input=True,
    example=("1---2---", "--a---b-"),
)
