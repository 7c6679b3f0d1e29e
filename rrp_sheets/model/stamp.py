"""Origin of an export, told in the export itself: which workbook ran, by which program, in which session."""

from __future__ import annotations

from dataclasses import dataclass, fields

PROGRAM = "RRP Sheets"
SHORT = 12  # hexadecimal digits of a hash that is read by people
_NAMES = {
    "run": "Run", "workbook": "Workbook", "digest": "Workbook SHA-256", "program": "Program", "mode": "Mode",
    "seed": "Seed", "participant": "Participant", "condition": "Condition", "operator": "Operator", "began": "Began",
    "ended": "Ended",
}  # fmt: skip
_WHOLE = ("time", "stopped", "end run")
"""Ends of a run that are not failures."""


_COLUMNS = {"digest": "workbook_sha256"}


@dataclass(frozen=True, slots=True)
class Stamp:
    """Origin of an export; what is not known, or does not apply, is blank.

    Attributes:
        run: the name of the run's folder; blank for an export of a workbook that has not run.
        workbook: its file.
        digest: SHA-256 of that file, in hexadecimal.
        program: the program's version, `0.2.0`.
        mode: `simulated`, `pilot`, `real`.
        language: of the words of a picture; it is no part of the stamp.
        began: the wall clock at time 0 by ISO 8601, `2026-11-21T20:54:55.120+00:00`.
        ended: how the run ended, as its record says: `time`, `stopped`, `end run`, `broken`, `cut`, `going`.
    """

    workbook: str = ""
    digest: str = ""
    program: str = ""
    mode: str = ""
    seed: str = ""
    participant: str = ""
    condition: str = ""
    operator: str = ""
    began: str = ""
    ended: str = ""
    run: str = ""
    language: str = "en"

    @staticmethod
    def names() -> list[str]:
        """Return the shown names of the fields, in the order of `values`."""
        return list(_NAMES.values())

    def values(self) -> list[str]:
        """The texts, in the order of `names`; the version has the program's name with it."""
        told = {f.name: str(getattr(self, f.name)) for f in fields(self)}
        told["program"] = told["program"] and f"{PROGRAM} {told['program']}"
        return [told[name] for name in _NAMES]

    @staticmethod
    def columns() -> list[str]:
        """The columns of a table that say where its rows come from, in the order of `row`."""
        return [*(_COLUMNS.get(name, name) for name in _NAMES), "complete"]

    def row(self) -> dict[str, str | int | bool | None]:
        """The cells of those columns; what is not known is None.

        >>> told = Stamp("greeter.xlsx", seed="7", ended="broken").row()
        >>> told["seed"], told["ended"], told["complete"], told["operator"]
        (7, 'broken', False, None)
        """
        texts = dict(zip(self.columns(), self.values(), strict=False))
        found: dict[str, str | int | bool | None] = {name: text or None for name, text in texts.items()}
        if self.seed.isascii() and self.seed.isdigit():
            found["seed"] = int(self.seed)
        return found | {"complete": self.ended in _WHOLE if self.ended else None}

    def pairs(self) -> list[tuple[str, str]]:
        """Names and texts of what is known: for properties of a file, and for a page about the run.

        >>> Stamp("greeter.xlsx", seed="7").pairs()
        [('Workbook', 'greeter.xlsx'), ('Seed', '7')]
        """
        return [(name, text) for name, text in zip(self.names(), self.values(), strict=True) if text]

    def line(self) -> str:
        """One line for the foot of a page or picture.

        >>> Stamp("greeter.xlsx", "37c20efdee336143", "0.2.0", "pilot", "7", "P07", began="2026-11-21 20:54:55").line()
        'greeter.xlsx · 37c20efdee33 · RRP Sheets 0.2.0 · pilot: never data · seed 7 · P07 · began 2026-11-21 20:54:55'
        """
        mode = "pilot: never data" if self.mode == "pilot" else self.mode
        parts = (
            self.workbook, self.digest[:SHORT], self.program and f"{PROGRAM} {self.program}", mode,
            self.seed and f"seed {self.seed}", self.participant, self.condition,
            self.operator and f"operator {self.operator}", self.began and f"began {self.began}",
        )  # fmt: skip
        return " · ".join(filter(None, parts))
