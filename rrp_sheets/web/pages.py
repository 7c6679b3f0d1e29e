"""What the templates get, field by field. `template` is the file in templates/web/ that shows it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar


@dataclass(frozen=True, slots=True)
class Count:
    """So many problems of one severity, in words; `kind` is error, warning or none."""

    kind: str
    text: str


@dataclass(frozen=True, slots=True)
class Card:
    """A workbook on the shelf.

    Attributes:
        about: the Protocol's purpose.
        size: `2 behaviours, 14 rows`.
        picture: whether its first behaviour can be drawn.
    """

    name: str
    title: str
    about: str
    size: str
    changed: str
    counts: tuple[Count, ...]
    picture: bool


@dataclass(frozen=True, slots=True)
class Unreadable:
    """A file on the shelf that is no workbook, and why."""

    name: str
    message: str
    remedy: str


@dataclass(frozen=True, slots=True)
class ShelfPage:
    """The workbooks of the folder.

    Attributes:
        others: Markdown files without any sheet of ours.
        left_out: how many files were not looked at.
    """

    template: ClassVar[str] = "shelf.html"
    folder: str
    cards: tuple[Card, ...]
    unreadable: tuple[Unreadable, ...]
    others: tuple[str, ...] = ()
    left_out: int = 0


@dataclass(frozen=True, slots=True)
class Problem:
    """A finding of the check.

    Attributes:
        number: its place in the list, and on its flag in the diagram.
        severity: error, warning or info; also the word that is shown.
        place: `Tracking!C7`; empty for the whole file.
        cell: `C7`.
        anchor: the id of the row, or else of the sheet, on the page; empty where neither is shown.
    """

    number: int
    severity: str
    code: str
    place: str
    cell: str
    anchor: str
    message: str
    remedy: str


@dataclass(frozen=True, slots=True)
class Name:
    """A stream's name in a cell; `kind` is sensor, stream, actuator, or empty where it is none of them."""

    text: str
    kind: str


@dataclass(frozen=True, slots=True)
class CellView:
    """A cell as shown.

    Attributes:
        kind: on, names, connector, formula, notes or plain.
        names: the streams, of a cell that holds streams.
        hint: said quietly in a blank cell that means something.
        icon: of a connector.
        problems: those of this cell.
    """

    kind: str
    text: str = ""
    names: tuple[Name, ...] = ()
    hint: str = ""
    icon: str = ""
    problems: tuple[Problem, ...] = ()


@dataclass(frozen=True, slots=True)
class RowView:
    """A row as shown, with all its problems again for the line below it; `anchor` is its id on the page."""

    anchor: str
    number: int
    cells: tuple[CellView, ...]
    off: bool = False
    comment: bool = False
    problems: tuple[Problem, ...] = ()


@dataclass(frozen=True, slots=True)
class Piece:
    """A piece of a text; `code` where it is a formula."""

    text: str
    code: bool = False


@dataclass(frozen=True, slots=True)
class Sentence:
    """What a row does, in words; `active` is False when it is switched off or nothing feeds it."""

    number: int
    pieces: tuple[Piece, ...]
    active: bool


@dataclass(frozen=True, slots=True)
class Words:
    """What a behaviour does, in words: all of it, what it takes in and acts on, and row by row."""

    paragraph: tuple[Piece, ...]
    sensors: tuple[str, ...]
    actuators: tuple[str, ...]
    rows: tuple[Sentence, ...]


@dataclass(frozen=True, slots=True)
class SheetView:
    """A sheet as a table.

    Attributes:
        anchor: its id on the page.
        kind: `Behaviour`, `Devices`, …
        problems: those of the sheet as a whole or of cells that are not shown.
        left_out: how many rows are not shown.
        picture: the behaviour's number in the addresses of diagrams; 0 for none.
        words: what it does; None of a sheet that is no behaviour, is too long, or cannot be understood yet.
        too_long: for a picture and words.
    """

    anchor: str
    name: str
    kind: str
    headers: tuple[str, ...]
    rows: tuple[RowView, ...]
    problems: tuple[Problem, ...] = ()
    left_out: int = 0
    picture: int = 0
    words: Words | None = None
    too_long: bool = False


@dataclass(frozen=True, slots=True)
class Command:
    """A command line and what it does."""

    line: str
    about: str


@dataclass(frozen=True, slots=True)
class WorkbookPage:
    """One workbook. `own` are the names of the sheets that are left alone; `program` is what edits the file."""

    template: ClassVar[str] = "workbook.html"
    name: str
    title: str
    changed: str
    program: str
    counts: tuple[Count, ...]
    behaviours: tuple[SheetView, ...]
    sheets: tuple[SheetView, ...]
    own: tuple[str, ...]
    problems: tuple[Problem, ...]
    problems_left_out: int
    commands: tuple[Command, ...]


@dataclass(frozen=True, slots=True)
class MessagePage:
    """Something did not go as wished, for someone who may see the rest."""

    template: ClassVar[str] = "message.html"
    title: str
    message: str
    remedy: str
    reload: bool = False


@dataclass(frozen=True, slots=True)
class RefusedPage:
    """For a visitor without the token: tells nothing about the folder, and needs no other file."""

    template: ClassVar[str] = "refused.html"
    title: str
    message: str
    remedy: str


Page = ShelfPage | WorkbookPage | MessagePage | RefusedPage
