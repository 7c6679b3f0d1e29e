"""Contents of a workbook as dataclasses, built by the format backends and read by everything else; words for truth.

One list of words for true and false serves the reader, the settings of devices, and the grid, which gets it as data.
"""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping
from dataclasses import dataclass, field

from rrp_sheets.model.durations import parse_duration
from rrp_sheets.model.names import key


@dataclass(frozen=True, slots=True)
class Row:
    """One row of a behaviour as it stands in the sheet."""

    number: int  # the row's number in the sheet
    # one cell per input stream (all with the address of the one cell); empty means "the row above"
    inputs: tuple[Cell, ...]
    inputs_cell: Cell  # the whole input cell
    connector: Cell
    formula: Cell
    output: Cell
    on: bool = True  # False when switched off
    priority: float = 0.0  # larger wins; blank is 0
    # texts on which the robot does not act, such as the notes, by the standard header of their column
    remarks: Mapping[str, str] = field(default_factory=dict)

    @property
    def notes(self) -> str:
        """The text of the column Notes."""
        return self.remarks.get("Notes", "")


@dataclass(frozen=True, slots=True)
class Behaviour:
    """One sheet of rows. Comment rows and fully blank rows are not among them.

    `headings` are the texts of the comment rows above a row, by the row's number; they do not change what rows do.
    """

    name: str
    rows: tuple[Row, ...]
    address: Address  # the header row; its column is that of the Input streams header
    headings: Mapping[int, str] = field(default_factory=dict, compare=False, repr=False)


@dataclass(frozen=True, slots=True)
class Device:
    """A row of the Devices sheet: a stream, the device behind it, and a cell for every setting's column, by key.

    The headers are those of the settings' columns as they are spelt, by key.
    """

    stream: Cell
    device: Cell
    settings: Mapping[str, Cell]
    headers: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True, slots=True)
class DeviceSheet:
    """The Devices sheet: where rows and columns can be added."""

    address: Address  # of the header of the column Stream
    columns: Mapping[str, int]  # the numbers of `stream`, `device` and the settings, by key
    free: int  # the number of the first column to the right of all that is filled
    last: int  # the number of the last row that holds anything


@dataclass(frozen=True, slots=True)
class Helper:
    """A row of the Helpers sheet; without inputs it is a named constant. `remarks` are as in `Row`."""

    name: Cell
    inputs: tuple[Cell, ...]
    formula: Cell
    remarks: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True, slots=True)
class SceneRow:
    """A row of the Scene sheet, its words not yet understood."""

    time: Cell
    thing: Cell
    does: Cell
    value: Cell


@dataclass(frozen=True, slots=True)
class GestureRow:
    """A keyframe of the Gestures sheet: joint values by the joint's key, and the columns' headers as spelt, by key."""

    name: Cell
    time: Cell
    joints: Mapping[str, Cell]
    headers: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True, slots=True)
class TestRow:
    """A row of a test sheet; `remarks` are as in `Row`."""

    time: Cell
    stream: Cell
    send: Cell
    expect: Cell
    remarks: Mapping[str, str] = field(default_factory=dict)

    @property
    def notes(self) -> str:
        """The text of the column Notes: what the row is about."""
        return self.remarks.get("Notes", "")


@dataclass(frozen=True, slots=True)
class TestSheet:
    """The cases of one sheet, with what is sent and what must come out."""

    name: str
    rows: tuple[TestRow, ...]


@dataclass(frozen=True, slots=True)
class RiskRow:
    """A row of the Risks sheet; `remarks` are as in `Row`."""

    risk: Cell
    whom: Cell
    likely: Cell
    reduces: Cell
    ends: Cell
    remarks: Mapping[str, str] = field(default_factory=dict, compare=False)


@dataclass(frozen=True, slots=True)
class RiskSheet:
    """The Risks sheet: its rows, and where more can be added."""

    address: Address  # of the header of the column Risk
    rows: tuple[RiskRow, ...]
    columns: Mapping[str, int]  # the number of each standard column, 0 where it is missing
    last: int  # the number of the last row that holds anything


@dataclass(frozen=True, slots=True)
class Protocol:
    """The Protocol sheet: values by the field's key, with the fields' names as spelt, in their order."""

    fields: Mapping[str, Cell] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    end: Address | None = None  # where the next field's name would stand; None without such a sheet

    def text(self, name: str, default: str = "") -> str:
        """The value of a field, or the default when it is missing or blank."""
        cell = self.fields.get(key(name))
        return cell.text if cell else default

    def seconds(self, name: str) -> float | None:
        """A duration field in seconds, or None."""
        us = parse_duration(self.text(name), bare="s")
        return None if us is None else us / 1e6

    @property
    def robot(self) -> str:
        """The robot's folder name; `nao` unless said otherwise."""
        return self.text("Robot", "nao").casefold()


@dataclass(frozen=True, slots=True)
class Workbook:
    """Everything that the sheets of ours say."""

    source: str  # the file or folder it was read from, as text for messages
    behaviours: tuple[Behaviour, ...]  # in the order of the sheets
    devices: tuple[Device, ...] = ()
    helpers: tuple[Helper, ...] = ()
    protocol: Protocol = field(default_factory=Protocol)
    scene: tuple[SceneRow, ...] | None = None
    gestures: tuple[GestureRow, ...] = ()
    tests: tuple[TestSheet, ...] = ()
    # cells of sheets that are the user's own, by the sheet's key (only those that formulas name)
    tables: Mapping[str, tuple[tuple[str, ...], ...]] = field(default_factory=dict)
    sheets: tuple[str, ...] = ()  # the names of all sheets, ours or not, in order
    risks: RiskSheet | None = None
    device_sheet: DeviceSheet | None = field(default=None, compare=False)
    language: str = "en"  # that of the headers of its sheets, in which the robot speaks unless Devices says otherwise


def column_letters(column: int) -> str:
    """The letters of a column, counted from 1.

    >>> column_letters(1), column_letters(28)
    ('A', 'AB')
    """
    letters = ""
    while column > 0:
        column, rest = divmod(column - 1, 26)
        letters = chr(65 + rest) + letters
    return letters


@dataclass(frozen=True, slots=True, order=True)
class Address:
    """A cell's place: sheet name, row and column counted from 1.

    >>> str(Address("Tracking", 7, 3))
    'Tracking!C7'
    """

    sheet: str
    row: int = 0
    column: int = 0

    @property
    def cell(self) -> str:
        """`C7`; empty for a whole sheet."""
        return f"{column_letters(self.column)}{self.row}" if self.row else ""

    def __str__(self) -> str:
        return f"{self.sheet}!{self.cell}" if self.row else self.sheet


@dataclass(frozen=True, slots=True)
class Cell:
    """A cell's cleaned text (what the program works with), its place, and what the user typed."""

    text: str
    address: Address
    original: str = ""

    def __bool__(self) -> bool:
        return bool(self.text)

    def __str__(self) -> str:
        return self.text

    @property
    def typed(self) -> str:
        """The words that the user typed where the text has standard ones for them: `赤いボール` for `Red ball`."""
        return self.text if self.original.isascii() else self.original.strip()


_INVISIBLE = re.compile("[\u00ad\u200b-\u200f\u2060\ufeff]")
_TRUE = """
    true yes on 1 wahr ja ein an vrai oui verdadero sí si vero sì verdadeiro sim waar aan sant sann sand tosi kyllä
    prawda tak pravda ano igaz igen doğru evet истина да αληθησ ναι はい オン 真 有効 是 开 開 예 참 ○ 〇 ◯ ✓ ✔
"""
_FALSE = """
    false no off 0 falsch nein aus faux non falso não nao onwaar nee uit falskt falsk nej nei usann epätosi ei fałsz nie
    nepravda ne hamis nem yanlış yanliş hayır hayir ложь нет ψευδησ όχι いいえ オフ 偽 無効 否 关 關 아니요 거짓
    × ✕ ✖ ✗ ✘
"""


def _folded(text: str) -> str:
    """A cell's text as it is compared; `isOff` in grid.js does the same."""
    return _INVISIBLE.sub("", unicodedata.normalize("NFKC", text)).strip().removeprefix("'").strip().casefold()


TRUE_WORDS = frozenset(_folded(word) for word in _TRUE.split())
FALSE_WORDS = frozenset(_folded(word) for word in _FALSE.split())


def truth_of(text: str) -> bool | None:
    """Return whether a cell says true or false; None when it says neither.

    >>> truth_of("Yes"), truth_of(" ＦＡＬＳＥ"), truth_of("いいえ"), truth_of("maybe"), truth_of("")
    (True, False, False, None, None)
    """
    word = _folded(text)
    return True if word in TRUE_WORDS else False if word in FALSE_WORDS else None
