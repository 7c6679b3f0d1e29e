"""New workbooks, copies of the tutorial, and conversions between formats, with a robot's names in the drop-downs."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.workbook import column_letters
from rrp_sheets.resources import bundled
from rrp_sheets.robots import Robot
from rrp_sheets.scene.scene_words import thing_names, verb_names
from rrp_sheets.texts import N_, listed, os_reason
from rrp_sheets.workbook.files import write_atomically

if TYPE_CHECKING:
    from rrp_sheets.workbook import Reading
    from rrp_sheets.workbook.maker import Offers

MADE = ("guided", "empty")
_MOST_NAMED = 5  # cells


def offers(robot: Robot) -> Offers:
    """Return the names that a workbook for this robot offers in its drop-downs."""
    from rrp_sheets.workbook.maker import Offers

    everyday_first = sorted(connectors(), key=lambda connector: connector.advanced)
    joints = tuple(j.name for j in robot.joints.values())
    choices: dict[str, tuple[str, ...]] = {"Joint": (*joints, *robot.data["groups"])}
    for device in robot.devices.values():
        for setting in device.settings.values():
            if setting.kind == "choice" and key(setting.name) not in {key(c) for c in choices}:
                choices[setting.name] = setting.choices
            elif setting.kind == "gesture":
                choices[setting.name] = tuple(robot.gestures)
    choices |= {"Thing": tuple(thing_names()), "Does": tuple(verb_names())}
    names = tuple(dict.fromkeys(c.name for c in everyday_first))
    return Offers(names, tuple(robot.device_names("sensor")), tuple(robot.device_names("actuator")), choices)


def make_new(path: Path, robot: Robot, template: str = "guided", language: str = "en") -> Path:
    """Make a workbook from a template; raise SheetsError when the file exists or there is no such template."""
    from rrp_sheets.workbook.template import new_workbook, refuse_name

    if key(template) in MADE:
        return new_workbook(path, offers(robot), robot=robot.name, language=language, empty=key(template) == "empty")
    books = {key(p.stem): p for p in sorted(bundled("workbooks").glob("*.xlsx"))}
    if key(template) not in books:
        names = [*MADE, *(p.stem for p in books.values())]
        guess = nearest(template, names)
        others = N_("The templates are: {names}.", names=listed(names))
        hint = N_("Did you mean {guess}?", guess=guess) if guess else others
        raise SheetsError(N_("There is no template “{name}”.", name=template), hint)
    refuse_name(path)
    write_atomically(path, books[key(template)].read_bytes(), replace=False)
    return path


def as_xlsx(reading: Reading, robot: Robot, target: Path, *, replace: bool = True) -> Path:
    """Write a workbook of any format as a styled .xlsx."""
    from rrp_sheets.workbook import to_sheets
    from rrp_sheets.workbook.files import make_workbook

    return make_workbook(to_sheets(reading), target, offers(robot), replace=replace)


def convert(path: Path, robot: Robot, target: Path, *, replace: bool = True) -> Path:
    """Write a workbook in the format that the target's name tells, or else as a folder of CSV files.

    The sheet Lists with the drop-downs' entries exists only in .xlsx, where the program makes it, unless a formula
    names it.

    Raises:
        SheetsError: when both are .xlsx, two sheets have one name, or the target cannot be written.
    """
    from rrp_sheets.workbook import read
    from rrp_sheets.workbook.files import WORKBOOK_SUFFIXES, read_sheets, write_sheets
    from rrp_sheets.workbook.reading import to_rows

    suffix = target.suffix.casefold()
    if suffix == ".xlsx":
        if path.suffix.casefold() == ".xlsx" and not path.is_dir():
            message = N_("Both are .xlsx workbooks; there is nothing to convert.")
            raise SheetsError(message, N_("Copy the file instead."))
        reading = read(path)
        _refuse_twins(reading.workbook.sheets)
        return as_xlsx(reading, robot, target, replace=replace)
    reading, raw, offered = read(path), read_sheets(path), offers(robot)
    _refuse_twins(reading.workbook.sheets)
    named = reading.workbook.tables
    sheets = {n: rows for n, rows in to_rows(raw).items() if key(n) in named or not offered.made(n, rows)}
    if suffix in (".csv", ".xls", ".ods", ".xlsm", ".pdf", ".txt", ".tsv"):
        remedy = N_("Name a folder (without ending) for CSV files, or a file that ends with one of: {suffixes}.",
                    suffixes=listed(WORKBOOK_SUFFIXES))  # fmt: skip
        raise SheetsError(N_("“{name}” is not a format that can be written.", name=target.name), remedy)
    return write_sheets(sheets, target, replace=replace)


def not_kept(path: Path, target: Path) -> list[str]:
    """Return what a conversion of a workbook to texts leaves out that people have written or set, in words."""
    from rrp_sheets.workbook.comments import read_threads
    from rrp_sheets.workbook.files import open_book
    from rrp_sheets.workbook.looks import read_looks, style_looks
    from rrp_sheets.workbook.raw import Extent
    from rrp_sheets.workbook.schema import recognise
    from rrp_sheets.workbook.xlsx import XlsxBook

    book, _ = open_book(path)
    if target.suffix.casefold() == ".xlsx" or not isinstance(book, XlsxBook):
        return []
    found, styles = list[str](), style_looks(book)
    commented = [
        f"{name}!{column_letters(column)}{row}"
        for index, name in enumerate(book.names)
        for row, column in sorted(read_threads(book, index))
    ]
    if commented:
        n, some = len(commented), listed(commented[:_MOST_NAMED]) + (" …" if len(commented) > _MOST_NAMED else "")
        one = N_("A cell has comments that are not in the copy, because a text file has no place for them: {cells}.")
        several = N_("{n} cells have comments that are not in the copy, because a text file has no place for them: "
                     "{cells}.")  # fmt: skip
        found.append(N_(one if n == 1 else several, n=n, cells=some))
    headers = [recognise(book.sheet(index, Extent.HEAD)).row for index in range(len(book.names))]
    if any(
        row > head
        for index, head in enumerate(headers)
        for row, _ in (read_looks(book, index, styles).cells if head else ())
    ):
        found.append(N_("Bold, colours and line breaks of cells are not in the copy."))
    return found


def _refuse_twins(names: Sequence[str]) -> None:
    """Raise SheetsError when two sheets have the same name: only one of them would be written."""
    twins = [name for name in dict.fromkeys(names) if names.count(name) > 1]
    if twins:
        raise SheetsError(N_("Two sheets are called “{name}”.", name=twins[0]), N_("Rename one of them."))


TUTORIAL = "tutorial.xlsx"  # ten lessons, each with a test that holds when it is done; everyone works in a copy
_COPY = re.compile(r"tutorial(?: \(\d+\))?\.xlsx")
_MOST = 1_000  # copies in one folder


def latest_tutorial(folder: Path) -> Path | None:
    """Return the newest copy in a folder, None when there is none; raise SheetsError when it cannot be read."""
    try:
        found = [(path.stat().st_mtime_ns, path) for path in folder.iterdir() if _COPY.fullmatch(path.name)]
    except OSError as error:
        message = N_("The folder {folder} cannot be read: {why}.", folder=str(folder), why=os_reason(error))
        raise SheetsError(message, N_("Take another folder.")) from error
    return max(found)[1] if found else None


def begin_tutorial(folder: Path, language: str = "en") -> Path:
    """Make a fresh copy in a language, in a folder beside those that are there.

    Raises SheetsError when it cannot be written.
    """
    fresh = bundled("templates", "workbooks", "tutorial.ja.xlsx" if language == "ja" else TUTORIAL).read_bytes()
    for count in range(1, _MOST):
        path = folder / (TUTORIAL if count == 1 else f"tutorial ({count}).xlsx")
        if not path.exists():
            write_atomically(path, fresh, replace=False)
            return path
    message = N_("There are too many copies of the tutorial in this folder.")
    raise SheetsError(message, N_("Delete those that are done."))
