"""Results of a replay as data, which JSON can hold."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import Any

from rrp_sheets.model.run_files import RecordedEvent, Stamp
from rrp_sheets.replay.differences import Count, Difference
from rrp_sheets.texts import told

SCHEMA = 1  # of the JSON; grows when an entry changes its meaning or goes


@dataclass(frozen=True)
class Spoken:
    """An actuator stream whose values are spoken: a text of its own, or what it is given."""

    text: str = ""


@dataclass(frozen=True)
class Replayed:
    """A recorded run beside its replay.

    Attributes:
        run: the name of its folder.
        workbook: the file that ran.
        other: the file that was replayed instead; empty when it is the one that ran.
        engine: of the replay, `frame` or `event loop`.
        seconds: how much of the run was replayed.
        compared: how many recorded events, errors and words of the engine were compared.
        differences: all of them, in the order of time.
        counts: by stream and row.
        ending: how the replay ended otherwise than the run, in words; empty when it did not.
        remarks: what is to be known of the record and the workbook, in words.
        unknown: what a replay cannot know in this session, in words.
        stamp: of the run.
        actuators: names of the actuator streams, as the trace has them.
        spoken: those of them whose values the robot says.
        recorded: what was compared, in order.
        came: what came instead, in order; streams as the record calls them.
    """

    run: str
    workbook: str
    other: str
    engine: str
    seconds: float
    compared: int
    differences: tuple[Difference, ...]
    counts: tuple[Count, ...]
    ending: str = ""
    remarks: tuple[str, ...] = ()
    unknown: tuple[str, ...] = ()
    stamp: Stamp = field(default_factory=Stamp)
    actuators: tuple[str, ...] = ()
    spoken: Mapping[str, Spoken] = field(default_factory=dict)
    recorded: Iterable[RecordedEvent] = field(default=(), repr=False, compare=False)
    came: Iterable[RecordedEvent] = field(default=(), repr=False, compare=False)

    @property
    def language(self) -> str:
        """Language of the account: that of the workbook that ran."""
        return self.stamp.language

    @property
    def same(self) -> bool:
        """True when nothing differs."""
        return not self.differences and not self.ending

    @property
    def first(self) -> Difference | None:
        """Earliest difference; None when there is none."""
        return self.differences[0] if self.differences else None

    def of(self, kind: str) -> Sequence[Difference]:
        """Return the differences of a kind: `missing`, `extra`, `value`, `time`, `row`, `order`."""
        return [d for d in self.differences if d.kind == kind]

    def as_dict(self, most: int | None = None) -> dict[str, Any]:
        """Return the replay as `replay --json` prints it; with at most so many differences."""
        shown = self.differences[:most]
        return {
            "schema": SCHEMA,
            "same": self.same,
            "run": self.run, "workbook": self.workbook, "other": self.other, "engine": self.engine,
            "seconds": self.seconds, "compared": self.compared, "ending": told(self.ending, self.language),
            "remarks": [told(r, self.language) for r in self.remarks],
            "unknown": [told(u, self.language) for u in self.unknown], "stamp": asdict(self.stamp),
            "actuators": list(self.actuators), "spoken": {n: s.text for n, s in self.spoken.items()},
            "counts": [asdict(c) for c in self.counts],
            "difference_count": len(self.differences),
            "differences": [asdict(d) for d in shown],
        }  # fmt: skip
