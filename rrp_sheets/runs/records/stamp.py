"""The stamp of a run, from its record; every export carries it."""

from __future__ import annotations

from pathlib import Path

from rrp_sheets.model.stamp import Stamp
from rrp_sheets.runs.records.metadata import RunMetadata, facts_of

__all__ = ["Stamp", "stamp_of", "stamp_of_facts"]


def stamp_of(place: Path) -> Stamp:
    """The stamp of a run's folder; what its record does not say is blank. Never raises."""
    return stamp_of_facts(facts_of(place))


def stamp_of_facts(facts: RunMetadata) -> Stamp:
    """The stamp of a run that was looked at already."""
    return Stamp(
        workbook=facts.workbook, digest=facts.digest, program=facts.program, mode=facts.mode, seed=facts.seed,
        participant=facts.participant, condition=facts.condition, operator=facts.operator,
        began=facts.began.isoformat(timespec="milliseconds") if facts.began else "",
        ended=facts.ended if facts.readable else "", run=facts.run, language=facts.language,
    )  # fmt: skip
