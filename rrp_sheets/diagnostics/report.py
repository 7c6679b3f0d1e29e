"""Findings of a check and their fixes, in a report from which those that only follow from others are removed."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from hashlib import blake2s
from typing import Any

from rrp_sheets.diagnostics.catalogue import CODES, Severity
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.model.names import count_typos, key
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_, LazyMessage, places_in, translate

Detail = str | int | float | None
"""Value of a detail: what the user typed, a number, or a `LazyMessage` of the program; all can be written as JSON."""
HIDE_CELL = ("SHEET006", "SHEET007", "SHEET016")
"""Causes that hide all other findings of the same cell: its text is not what the user meant."""
HIDE_ROW = ("SHEET017",)
"""Causes that hide all other findings of the same row: its cells stand in wrong columns."""
_WRONG_INPUTS = ("CONN003", "CONN004", "CONN009")
"""Causes that hide findings of the row's formula: its inputs are not the ones that were meant."""
_LOST_OUTPUT = ("GRAPH002", "GRAPH004", "GRAPH007", "GRAPH008", "GRAPH013", "GRAPH016", "SHEET017", "SHEET021")
"""The row gives nothing under a name of its own: whoever wants that name misses it."""
_MISSING = ("GRAPH001", "GRAPH006", "GRAPH011")
_UNDECLARED = ("GRAPH001", "GRAPH006", "GRAPH007", "GRAPH009", "DEV008")
_UNKNOWN_HELPER = ("FORM001", "FORM004", "FORM005", "FORM014")
_UNREAD_SHEETS = {"devices": _UNDECLARED, "helpers": _UNKNOWN_HELPER}
"""Hidden everywhere, by the kind of the sheet that cannot be read wholly."""
_MISSED_BEHAVIOUR = ("PROT004", "DEV010")
_UNNAMED = {"DEV005": _UNDECLARED, "FORM016": _UNKNOWN_HELPER, "FORM024": ("FORM007", "FORM017")}
"""A row of Devices or Helpers, or a column of a table, without a name: whoever wants it misses it."""
_WRONG_SCENE_ROWS = ("SCENE001", "SCENE002", "SCENE003", "SCENE004", "SCENE007", "SCENE008", "SCENE012")
AFTER_SCENE_ROWS = ("SCENE005", "SCENE009", "SCENE010")
"""Hidden by wrong rows of the Scene, as they depend on the things in the room, which are not known then."""
_ERRORS_OF_ROWS = ("CONN", "GRAPH", "FORM", "DEV", "SHEET", "PROT001", "PROT004")
_AFTER_ERRORS = ("TEST002", "TEST011", "SCENE006", "SCENE007", "DEV009")
"""Hidden by errors of rows, those of formulas excepted: streams that tests and the scene name may be missing."""
_RANKS = {severity: rank for rank, severity in enumerate(Severity)}
MORE_LATER = N_("Some checks need the errors fixed first, so more problems may appear.")
"""Said beside findings of which `checks_wait` is true."""
_AFTER_WARNINGS = {"DEV007": ("SCENE006",), "GRAPH014": ("TEST011",)}
"""Hidden by warnings. No error is among these: a warning must not hide that a workbook has errors. Lints of rows that
depend on a warning are left out in `checks/lints`, which knows those rows."""


@dataclass(frozen=True, slots=True)
class Put:
    """Put a text into a cell; an empty text clears it. If `was` is given, the cell must still hold that text."""

    address: Address
    text: str
    was: str | None = None


@dataclass(frozen=True, slots=True)
class Insert:
    """Insert a row before another one; `cells` are the texts by column, counted from 1."""

    sheet: str
    before: int
    cells: tuple[tuple[int, str], ...]


@dataclass(frozen=True, slots=True)
class Replace:
    """Write one word or name in a cell in another way: `redBal` → `redBall`."""

    address: Address
    old: str
    new: str


@dataclass(frozen=True, slots=True)
class Delete:
    """Delete a row."""

    sheet: str
    row: int


FixEdit = Put | Insert | Replace | Delete


@dataclass(frozen=True, slots=True)
class Fix:
    """A fix of a finding."""

    id: str  # names it among the fixes of its finding, in any language: lower-case words with hyphens
    title: str  # what it does, in the user's words
    edits: tuple[FixEdit, ...]  # one after the other; each counts rows as the one before left them
    safe: bool = False  # whether it is surely what was meant, so that it needs no decision
    fill: Address | None = None  # the cell, as the edits leave it, that the user fills in then


_MISSPELT = {"FORM003": "typed", "FORM007": "field", "SHEET002": "header", "CONN008": "text"}
"""The detail that holds what is misspelt; of other codes it is `name`."""
_TELLING = re.compile(r"\d|(?<![^\W_])[^\W_](?![^\W_])")
"""Digits and single letters; names that differ in these are two names: `Step 1` and `Step 2`, `Ball x` and `Ball y`."""


def meant(guess: str | None, otherwise: str, quoted: bool = False) -> dict[str, Any]:
    """Return the details `remedy` and `guess` for a name that is not known; `otherwise` is the remedy without a guess.

    With `quoted` the guess is put into quotes.

    >>> meant("Red ball", "Choose a device.")
    {'remedy': 'Did you mean Red ball?', 'guess': 'Red ball'}
    """
    if not guess:
        return {"remedy": otherwise}
    remedy = N_("Did you mean “{guess}”?", guess=guess) if quoted else N_("Did you mean {guess}?", guess=guess)
    return {"remedy": remedy, "guess": guess}


def proposed(code: str, address: Address | None, details: Mapping[str, object]) -> tuple[Fix, ...]:
    """Return the fix `correct-spelling`, which writes the detail `guess`, as a tuple; empty without a guess."""
    wrong, guess = details.get(_MISSPELT.get(code, "name")), details.get("guess")
    if address is None or not (isinstance(wrong, str) and isinstance(guess, str) and wrong and guess):
        return ()
    title = N_("Write {value}", value=guess)
    safe = code == "CONN008" or surely(wrong, guess)
    return (Fix("correct-spelling", title, (Replace(address, wrong, guess),), safe),)


def surely(wrong: str, guess: str, most: int = 0) -> bool:
    """Return whether a guess is surely meant: no digit or single letter differs, and there are few typing errors.

    That is at most one, or one for every four letters; or `most`, where that is given.

    >>> surely("Red bal", "Red ball"), surely("Sce", "Score"), surely("Step 2", "Step 1")
    (True, False, False)
    """
    if _TELLING.findall(wrong.casefold()) != _TELLING.findall(guess.casefold()):
        return False
    return count_typos(wrong, guess) <= (most or max(1, len(key(wrong)) // 4))


@dataclass(frozen=True, slots=True)
class Diagnostic:
    """One finding. Its texts are made of the catalogue's templates and the details, when they are asked for."""

    code: str  # the catalogue's code
    address: Address | None  # the cell it belongs to; None for the whole file
    # the values that fill the templates, by name; a text of the program is a `LazyMessage`
    details: Mapping[str, Detail] = field(default_factory=dict, hash=False)
    span: tuple[int, int] | None = None  # first and last+1 character within the cell's text, where known
    fixes: tuple[Fix, ...] = field(default=(), compare=False)  # what would remove it, to choose from

    @property
    def severity(self) -> Severity:
        """The severity of its code."""
        return CODES[self.code].severity

    @property
    def message(self) -> LazyMessage:
        """The problem, in the user's words; `texts.translate` translates it."""
        return CODES[self.code].text("message", self.details)

    @property
    def remedy(self) -> LazyMessage:
        """The advice for removing it; `texts.translate` translates it."""
        return CODES[self.code].text("remedy", self.details)

    @property
    def id(self) -> str:
        """The name by which a page asks for a fix of it: a short digest of code, address and details."""
        said = json.dumps([self.code, str(self.address or ""), self.details], sort_keys=True)
        return blake2s(said.encode(), digest_size=8).hexdigest()

    def as_dict(self, language: str = "en") -> dict[str, Any]:
        """Return the finding as `check --json` prints it, with its texts in a language (`en`, `ja`)."""
        return {
            "code": self.code, "severity": self.severity.value,
            "sheet": self.address.sheet if self.address else "", "cell": self.address.cell if self.address else "",
            "message": translate(self.message, language), "remedy": translate(self.remedy, language),
            "span": list(self.span) if self.span else None,
            "fixes": [{"id": f.id, "title": translate(f.title, language), "safe": f.safe} for f in self.fixes],
            "details": places_in(self.details, language),
        }  # fmt: skip


def is_of_rows(finding: Diagnostic) -> bool:
    """Return whether a finding is an error by which rows, or what they use, cannot be understood."""
    return finding.severity is Severity.ERROR and finding.code.startswith(_ERRORS_OF_ROWS)


def checks_wait(findings: Iterable[Diagnostic]) -> bool:
    """Return whether checks wait until errors among the findings are fixed, so that more may be found then."""
    return any(is_of_rows(d) or d.code in _WRONG_SCENE_ROWS for d in findings)


class UnreadableWorkbook(UnreadableFile):
    """A workbook that cannot be read at all; `finding` says why."""

    def __init__(self, finding: Diagnostic) -> None:
        super().__init__(finding.code, finding.message, finding.remedy)
        self.finding = finding


class Report:
    """The diagnostics of one workbook, errors first, in the order of its sheets and cells.

    >>> report = Report(); _ = report.add("FILE001", None, name="x.xlsx", hint=""); report.flatten(["code", "cell"])
    [('FILE001', '')]
    """

    def __init__(self, diagnostics: Iterable[Diagnostic] = ()) -> None:
        self._found: dict[Diagnostic, None] = dict.fromkeys(diagnostics)  # in order, each once
        self._sheets: dict[str, int] = {}

    def order_by(self, sheets: Iterable[str]) -> None:
        """Set the order of sheets in which findings are sorted."""
        self._sheets = {name: i for i, name in enumerate(sheets)}

    def add(
        self, code: str, address: Address | None, *, span: tuple[int, int] | None = None,
        fixes: Iterable[Fix] = (), **details: object,
    ) -> Diagnostic:  # fmt: skip
        """Add a finding; `details` fill the catalogue's texts. Raises TypeError when one that they need is missing."""
        if missing := CODES[code].parameters - details.keys():
            raise TypeError(f"{code} needs {', '.join(sorted(missing))}.")
        given = {name: v if isinstance(v, Detail) else str(v) for name, v in details.items()}
        diagnostic = Diagnostic(code, address, given, span, tuple(fixes) or proposed(code, address, given))
        self._found[diagnostic] = None
        return diagnostic

    def extend(self, other: Iterable[Diagnostic]) -> None:
        """Add the findings of another report."""
        self._found.update(dict.fromkeys(other))

    def judge_fixes(self, judge: Callable[[Diagnostic, Fix], Fix]) -> None:
        """Replace each fix by what `judge` returns, which decides with the whole workbook whether it is safe."""
        for d in [d for d in self._found if d.fixes]:
            del self._found[d]
            self._found[replace(d, fixes=tuple(judge(d, fix) for fix in d.fixes))] = None

    def offer(self, finding: Diagnostic, fixes: Iterable[Fix]) -> None:
        """Give a finding other fixes to choose from."""
        del self._found[finding]
        self._found[replace(finding, fixes=tuple(fixes))] = None

    def drop_followers(self) -> None:
        """Drop the findings that only follow from another one; no fix of one that may follow stays safe."""
        causes = _Causes(self._found)
        self._found = {d: None for d in self._found if not causes.explain(d)}
        self.judge_fixes(lambda d, fix: replace(fix, safe=fix.safe and not causes.may_follow(d)))

    def _place(self, d: Diagnostic) -> tuple[int, int, str, int, int, str]:
        rank = _RANKS[d.severity]
        if d.address is None:
            return (rank, -1, "", 0, 0, d.code)
        a = d.address
        return (rank, self._sheets.get(a.sheet, len(self._sheets)), a.sheet, a.row, a.column, d.code)

    def __iter__(self) -> Iterator[Diagnostic]:
        return iter(sorted(self._found, key=self._place))

    def __len__(self) -> int:
        return len(self._found)

    @property
    def errors(self) -> list[Diagnostic]:
        """The findings that keep the workbook from running."""
        return [d for d in self if d.severity is Severity.ERROR]

    def flatten(self, fields: Iterable[str]) -> list[tuple[Any, ...]]:
        """Return the named entries of every finding, for tests: `report.flatten(["code", "cell"])`."""
        fields = list(fields)
        return [tuple(d.as_dict()[f] for f in fields) for d in self]


class _Causes:
    """Findings that explain others, indexed by cell, row and sheet, as there may be thousands."""

    def __init__(self, found: Iterable[Diagnostic]) -> None:
        self.cells: set[Address] = set()
        self.rows: set[tuple[str, int]] = set()
        self.input_rows: set[tuple[str, int]] = set()
        self.names: set[tuple[str, str]] = set()  # keys of streams that are missing in a sheet
        self.lost: dict[str, set[int]] = {}  # by sheet: rows that give nothing under a name of their own
        self.wanted: dict[str, list[int]] = {}  # by sheet: rows of missing streams that are not just misspelt
        self.formulas: set[str] = set()  # sheets with formulas that lack a name
        self.anywhere: set[str] = set()
        for d in found:
            if is_of_rows(d) and not d.code.startswith("FORM"):
                self.anywhere.update(_AFTER_ERRORS)
            self.anywhere.update(_AFTER_WARNINGS.get(d.code, ()))
            if d.address is not None:
                self._add(d.code, d.address)
                if d.code == "GRAPH001":
                    self.names.add((d.address.sheet, key(str(d.details["name"]))))
                    if not _is_misspelt(d):
                        self.wanted.setdefault(d.address.sheet, []).append(d.address.row)
        self.first = {sheet: min(rows) for sheet, rows in self.lost.items()}
        self.too_few = {  # sheets where more streams are missing than the lost rows can explain
            sheet for sheet, first in self.first.items()
            if sum(row > first for row in self.wanted.get(sheet, ())) > len(self.lost[sheet])
        }  # fmt: skip

    def _add(self, code: str, at: Address) -> None:
        if code in HIDE_CELL:
            self.cells.add(at)
        if code in HIDE_ROW:
            self.rows.add((at.sheet, at.row))
        if code in _WRONG_INPUTS:
            self.input_rows.add((at.sheet, at.row))
        if code in _LOST_OUTPUT or code in HIDE_CELL:
            self.lost.setdefault(at.sheet, set()).add(at.row)
        if code == "SHEET004" or code in HIDE_CELL:
            self.anywhere.update(_UNREAD_SHEETS.get(key(at.sheet), ()))
        if code == "SHEET004":
            self.anywhere.update(_MISSED_BEHAVIOUR)
        self.anywhere.update(_UNNAMED.get(code, ()))
        if code == "FORM004":
            self.formulas.add(at.sheet)
        if code in _WRONG_SCENE_ROWS:
            self.anywhere.update(AFTER_SCENE_ROWS)

    def explain(self, d: Diagnostic) -> bool:
        if d.code in self.anywhere:
            return True
        if d.address is None or d.code in HIDE_CELL or d.code in HIDE_ROW:
            return False
        row = (d.address.sheet, d.address.row)
        return (
            d.address in self.cells
            or row in self.rows
            or (row in self.input_rows and d.code.startswith("FORM"))
            or (d.address.sheet in self.lost and d.code in _MISSING and not self._stands_alone(d, d.address))
            or (d.code == "FORM004" and (d.address.sheet, key(str(d.details["name"]))) in self.names)
            or (d.code == "GRAPH011" and d.address.sheet in self.formulas)
        )

    def _stands_alone(self, d: Diagnostic, at: Address) -> bool:
        """Return whether a missing input does not follow from rows that give nothing.

        It follows when it stands below one of those, is no misspelt name, and each of those explains one name at most.
        """
        follows = at.row > self.first[at.sheet] and not _is_misspelt(d) and at.sheet not in self.too_few
        return d.code == "GRAPH001" and not follows

    def may_follow(self, d: Diagnostic) -> bool:
        """Return whether a missing name may be one that a row of the sheet has lost, and not a misspelt one."""
        return d.code in _MISSING and d.address is not None and d.address.sheet in self.lost


def _is_misspelt(d: Diagnostic) -> bool:
    name, guess = d.details.get("name"), d.details.get("guess")
    return isinstance(name, str) and isinstance(guess, str) and surely(name, guess, most=1)
