"""Parts of a behaviour that its panel can show instead of all: the rows below a heading, or those around a row."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from rrp_sheets.graph import BehaviourGraph, Step
from rrp_sheets.texts import N_

AROUND = "around"
HOPS = 2  # streams from the row in the middle to one that is shown with it
MOST_AROUND = 40  # rows that are shown around one
FEWEST = 8  # rows of a behaviour that is worth dividing


def parts(steps: Sequence[Step], headings: Mapping[int, str]) -> tuple[tuple[str, str], ...]:
    """Return what can be shown of a behaviour, each with its name and its title; nothing for a short one.

    `headings` are the comments above rows, by the row's number. A request adds the row to the part around one.
    """
    if len(steps) < FEWEST:
        return ()
    below = [(f"below-{n}", title) for n, title in sorted(headings.items()) if any(s.number >= n for s in steps)]
    return (("", N_("All rows")), (AROUND, N_("Around this row")), *below)


def part_of(behaviour: BehaviourGraph, headings: Mapping[int, str], asked: str) -> tuple[Step, ...]:
    """Return the rows of a part: `below-9` (a heading), `around-5` (a row); all rows for any other name."""
    kind, _, digits = asked.partition("-")
    number = int(digits) if digits.isdecimal() and len(digits) < 8 else 0
    if kind == "below" and number in headings:
        following = min((n for n in headings if n > number), default=10**8)
        return tuple(s for s in behaviour.steps if number <= s.number < following)
    return _around(behaviour.steps, number) if kind == AROUND and behaviour.steps else behaviour.steps


def _around(steps: Sequence[Step], number: int) -> tuple[Step, ...]:
    by_stream: dict[str, list[Step]] = {}
    for step in steps:
        for stream in {*step.inputs, step.output}:
            by_stream.setdefault(stream, []).append(step)
    middle = min(steps, key=lambda s: abs(s.number - number))
    found, last = {middle.number}, [middle]
    for _ in range(HOPS):
        near = [s for step in last for stream in (*step.inputs, step.output) for s in by_stream[stream]]
        last = list({s.number: s for s in near if s.number not in found}.values())[: MOST_AROUND - len(found)]
        found |= {s.number for s in last}
    return tuple(s for s in steps if s.number in found)
