"""Readers of every kind of sheet: from its cells to rows of the model; everything odd about a cell is reported."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import count, groupby, product, takewhile

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, Insert, Put
from rrp_sheets.model import japanese
from rrp_sheets.model import workbook as model
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Address, Cell
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import ERROR_VALUES, clean_name, clean_prose, clean_spaces, from_excel
from rrp_sheets.workbook.raw import Kind, RawCell, RawSheet
from rrp_sheets.workbook.schema import FIELDS, PLAIN, Recognised, SheetKind, field_key

_SEPARATORS = re.compile(r"[,、，\n]")
_BLANK = RawCell("")
_MOST_MERGES = 20
_TEXT = re.compile(r"""(?<![fF])(?:"(?:[^"]|"")*"|“[^“”]*”|(?<!\w)'(?:[^']|'')*')""")


@dataclass(frozen=True, slots=True)
class FilledRow:
    """A filled row of a table: its number and its raw cells by column."""

    number: int
    cells: Mapping[int, RawCell]


class OwnTable:
    """A sheet of ours, read whole; findings go into the report."""

    def __init__(self, sheet: RawSheet, recognised: Recognised, kind: SheetKind, report: Report) -> None:
        self.sheet, self.report = sheet, report
        self.header_row, self.columns, self.others = recognised.row, recognised.columns, recognised.others
        names = {c: k for c, header in self.others.items() if kind.other and (k := key(header)) not in kind.spellings}
        self.header_keys = {c: k for c, k in names.items() if k}  # of the columns with headers of their own
        self.ours = {*self.columns.values(), *names}
        self._optional = {self.columns.get(c.name, 0) for c in kind.optional}
        self._remarks = [c.name for c in kind.columns if not c.effect and c.name in self.columns]
        named = {**{column: name for name, column in self.columns.items()}, **self.others}
        self._cells = {column: kind.column(header).cells for column, header in named.items()}
        headers = sheet.cells
        for column, first in recognised.twice.items():
            text = clean_spaces(headers[self.header_row, column].text)
            first_cell = self.address(self.header_row, first).cell
            self.add("SHEET005", self.address(self.header_row, column), header=text, first=first_cell)

    def add(self, code: str, address: Address, *, fixes: Iterable[Fix] = (), **details: object) -> None:
        """Report a finding, unless there are too many already."""
        if len(self.report) < limits.FINDINGS:
            self.report.add(code, address, span=None, fixes=fixes, **details)

    def address(self, row: int, column: int) -> Address:
        """The address of a cell."""
        return Address(self.sheet.name, row, column)

    def lines(self) -> Iterator[FilledRow]:
        """The rows below the header that say something: not blank, no comment, more than notes."""
        says = self.ours - self._optional
        for number, cells in self.sheet.rows().items():
            filled = any(c in says and (cell.formula or clean_spaces(cell.text)) for c, cell in cells.items())
            if filled and number > self.header_row and not self._is_comment(cells):
                yield FilledRow(number, cells)

    def shown_lines(self) -> list[FilledRow]:
        """The same rows; warns of hidden ones."""
        lines = list(self.lines())
        self.report_hidden({line.number: line for line in lines})
        return lines

    def comments(self) -> Iterator[FilledRow]:
        """The comment rows below the header."""
        for number, cells in self.sheet.rows().items():
            if number > self.header_row and self._is_comment(cells):
                yield FilledRow(number, cells)

    def _is_comment(self, cells: Mapping[int, RawCell]) -> bool:
        """Return whether a row is a comment: its first cell, leaving out the user's own columns, begins with `#`."""
        for column, cell in cells.items():
            if column in self.ours or column not in self.others:
                text = clean_name(cell.text)
                if text:
                    return text.startswith("#") and cell.kind is Kind.TEXT and not is_error_value(text)
        return False

    def cell(self, line: FilledRow, header: str | int) -> Cell:
        """A cell of a column, told by its standard header or its number, cleaned as its kind wants."""
        column = self.columns.get(header, 0) if isinstance(header, str) else header
        address = self.address(line.number, column or 1)
        raw, cells = line.cells.get(column, _BLANK), self._cells.get(column, PLAIN.cells)
        if cells.as_typed:
            return Cell(cells.clean(raw.text), address, raw.typed)
        if raw.formula and (cells.from_excel or raw.kind is Kind.ERROR or not raw.text):  # typed with = by habit
            return self._checked(cells.clean(from_excel(raw.formula)), raw.typed, address)
        if raw.kind in (Kind.DATE, Kind.TIME):
            if raw.kind is Kind.TIME or not cells.dates:
                self.add("SHEET006", address, value=raw.text)
            return Cell(raw.text, address, raw.typed)
        return self._checked(cells.clean(raw.text), raw.typed, address)

    def needed(self, line: FilledRow, header: str, what: str) -> Cell:
        """A cell that must not be blank, and what to call it if it is."""
        cell = self.cell(line, header)
        if not cell:
            self.add("SHEET013", cell.address, what=what)
        return cell

    def remarks(self, line: FilledRow) -> dict[str, str]:
        """The texts of the columns on which the robot does not act, by the standard header."""
        return {header: text for header in self._remarks if (text := self.cell(line, header).text)}

    def names(self, cell: Cell) -> tuple[Cell, ...]:
        """The names in a cell, separated by commas or line breaks."""
        parts = [name for part in _SEPARATORS.split(cell.text) if (name := clean_spaces(part))]
        if len(parts) > limits.NAMES:
            self.add("SHEET021", cell.address, count=len(parts), limit=limits.NAMES)
        return tuple(Cell(name, cell.address, cell.original) for name in parts[: limits.NAMES])

    def _checked(self, text: str, original: str, address: Address) -> Cell:
        if len(text) > limits.CELL_CHARACTERS:
            self.add("SHEET016", address, count=len(text), limit=limits.CELL_CHARACTERS)
            text, original = text[: limits.CELL_CHARACTERS], original[: limits.CELL_CHARACTERS]
        elif is_error_value(text):
            self.add("SHEET007", address, value=text)
        return Cell(text, address, original)

    def report_hidden(self, lines: Mapping[int, object]) -> None:
        """Warn of active rows, given by their numbers, that cannot be seen."""
        if self.sheet.hidden and lines:
            self.add("SHEET010", Address(self.sheet.name), sheet=self.sheet.name)
        hidden = sorted(self.sheet.hidden_rows & lines.keys())
        for _, block in groupby(enumerate(hidden), lambda item: item[1] - item[0]):  # the same in consecutive rows
            numbers = [row for _, row in block]
            first, last = numbers[0], numbers[-1]
            one, several = N_("Row {n}", n=first), N_("Rows {first} to {last}", first=first, last=last)
            rows = one if first == last else several
            address = self.address(first, min(self.columns.values()))
            self.add("SHEET009", address, rows=rows, sheet=self.sheet.name)

    def report_merged(self) -> None:
        """Warn of merged cells that reach into the table."""
        last = max((row for row, _ in self.sheet.cells), default=0)
        reaching = [r for r in self.sheet.merged if r.bottom >= self.header_row and r.top <= last and r.area > 1]
        found = []
        for block in reaching:
            columns = sorted(c for c in self.ours if block.left <= c <= block.right)
            places = product(range(block.top, min(block.top + 1, block.bottom) + 1), columns)
            # the first cell that is one of ours and not the one with the content
            found += [(block, at) for at in places if at != (block.top, block.left)][:1]
        for block, at in found[:_MOST_MERGES]:
            first, end = self.address(block.top, block.left), self.address(block.bottom, block.right)
            self.add("SHEET008", self.address(*at), range=f"{first.cell}:{end.cell}", first=first.cell)


def is_error_value(text: str) -> bool:
    """Return whether a text is one of Excel's or LibreOffice's error values.

    >>> is_error_value("#NAME?"), is_error_value("Err:508"), is_error_value("# note")
    (True, True, False)
    """
    return text[:1] in ("#", "E") and (text.upper() in ERROR_VALUES or re.fullmatch(r"Err:\d{3}", text) is not None)


def read_behaviour(table: OwnTable) -> model.Behaviour:
    """The behaviour that a sheet describes."""
    rows = [_behaviour_row(table, line) for line in table.lines()]
    for line in table.comments():
        _report_buried(table, line)
    table.report_hidden({row.number: row for row in rows if row.on})
    header = table.address(table.header_row, table.columns["Input streams"])
    return model.Behaviour(table.sheet.name, tuple(rows), header, _headings(table, rows))


def _headings(table: OwnTable, rows: Sequence[model.Row]) -> dict[int, str]:
    """The comments above rows, by the number of the row that follows them."""
    comments = {line.number: _comment(line) for line in table.comments()}
    numbers = {row.number for row in rows}
    found: dict[int, str] = {}
    waiting: list[str] = []
    for number in sorted(numbers | comments.keys()):
        if number in numbers:
            if waiting:
                found[number] = " ".join(waiting)
            waiting = []
        elif comments[number]:
            waiting.append(comments[number])
    return found


def _comment(line: FilledRow) -> str:
    first = next((cell for cell in line.cells.values() if cell.text.strip().startswith("#")), None)
    return "" if first is None or first.kind is not Kind.TEXT else first.text.strip().lstrip("#").strip()


def _report_buried(table: OwnTable, line: FilledRow) -> None:
    """Warn of a row that was written into a comment; one after a lone `#` is switched off in this way on purpose."""
    on, inputs, connector, output = (
        table.columns.get(header, 0) for header in ("On", "Input streams", "Connector", "Output stream")
    )
    texts = {column: cell.typed for column, cell in line.cells.items() if cell.typed.strip()}
    comment = texts.get(on, "").strip()
    is_row = connector in texts and (inputs in texts or output in texts)
    if not (comment.startswith("#") and comment.strip("# ") and is_row):
        return
    columns = sorted(table.ours - {on})
    emptied = (Put(table.address(line.number, c), "", was=texts.get(c, "")) for c in columns)
    mine = tuple((c, texts[c]) for c in columns if c in texts)
    edits: tuple[Put | Insert, ...] = (*emptied, Insert(table.sheet.name, line.number + 1, mine))
    apart = Fix("own-row", N_("Put it into a row of its own"), edits)
    table.add("SHEET022", table.address(line.number, connector), fixes=(apart,), row=line.number)


def _behaviour_row(table: OwnTable, line: FilledRow) -> model.Row:
    inputs = table.cell(line, "Input streams")
    names = table.names(inputs)
    connector, formula, output = (table.cell(line, header) for header in ("Connector", "Formula", "Output stream"))
    switch = table.cell(line, "On")
    on = model.truth_of(switch.text)
    if on is None and switch:
        table.add("SHEET011", switch.address, value=switch.text)
    priority, remarks = _priority(table, line), table.remarks(line)
    return model.Row(
        line.number, names, inputs, connector=connector, formula=formula, output=output, on=on is not False,
        priority=priority, remarks=remarks,
    )  # fmt: skip


def _priority(table: OwnTable, line: FilledRow) -> float:
    cell = table.cell(line, "Priority")
    if not cell:
        return 0.0
    try:
        priority = float(cell.text)
    except ValueError:
        priority = math.nan
    if not math.isfinite(priority) or "_" in cell.text:
        table.add("SHEET012", cell.address, value=cell.text)
        return 0.0
    return priority


def read_helpers(table: OwnTable) -> tuple[model.Helper, ...]:
    """The rows of a Helpers sheet."""
    return tuple(
        model.Helper(
            table.cell(line, "Name"),
            table.names(table.cell(line, "Inputs")),
            table.cell(line, "Formula"),
            table.remarks(line),
        )
        for line in table.shown_lines()
    )


def read_devices(table: OwnTable) -> tuple[model.Device, ...]:
    """The rows of a Devices sheet; a blank cell stands for a setting left out."""
    keys = {c: _setting(k) for c, k in table.header_keys.items()}
    headers = {k: table.others[c] for c, k in keys.items()}
    devices = []
    for line in table.shown_lines():
        device = _in(table.cell(line, "Device"), partial(japanese.standard, japanese.DEVICES))
        settings = {
            k: _in(table.cell(line, c), partial(japanese.standard, japanese.CHOICES.get(k, {})))
            for c, k in sorted(keys.items())
        }
        devices.append(model.Device(table.cell(line, "Stream"), device, settings, headers))
    return tuple(devices)


def with_standard_moves(device: model.Device, own: Container[str]) -> model.Device:
    """Return a device with the robot's word for a Japanese gesture or posture; `own` are keys of the workbook's own."""
    name = device.settings.get("name")
    if not name or key(device.device.text) not in ("gesture", "posture") or key(name.text) in own:
        return device
    return replace(device, settings={**device.settings, "name": _in(name, partial(japanese.standard, japanese.MOVES))})


def place_of_devices(table: OwnTable) -> model.DeviceSheet:
    """The place of a Devices sheet, and of what can be added to it."""
    columns = {key(name): c for name, c in table.columns.items()}
    columns |= {_setting(k): c for c, k in table.header_keys.items()}
    free = max(column for _, column in table.sheet.cells) + 1
    last = max(table.sheet.rows(), default=table.header_row)
    return model.DeviceSheet(table.address(table.header_row, columns["stream"]), columns, free, last)


def _setting(header: str) -> str:
    """Return the key of a setting, of its header's key."""
    return key(japanese.standard(japanese.SETTINGS, header))


def _in(cell: Cell, standard: Callable[[str], str]) -> Cell:
    """Return a cell with the standard words for Japanese ones."""
    return cell if cell.text.isascii() else replace(cell, text=standard(cell.text))


def read_scene(table: OwnTable) -> tuple[model.SceneRow, ...]:
    """The rows of a Scene sheet; their words are understood later."""
    return tuple(_scene_row(*(table.cell(line, h) for h in SCENE_HEADERS)) for line in table.shown_lines())


SCENE_HEADERS = ("Time (s)", "Thing", "Does", "Value")


def _scene_row(time: Cell, thing: Cell, does: Cell, value: Cell) -> model.SceneRow:
    thing = _in(thing, japanese.standard_thing)
    does = _in(does, partial(japanese.standard, japanese.VERBS))
    if thing.text == "Operator" and does.text == japanese.VERBS["押す"]:
        does = replace(does, text=japanese.VERBS["ボタンを押す"])
    words = key(does.text) in japanese.FREE  # of people
    return model.SceneRow(time, thing, does, value if words else _in(value, japanese.standard_value))


def read_test(table: OwnTable) -> model.TestSheet:
    """The rows of a test sheet. Send and Expect are written like formulas (`zone="Head"`) or as plain texts."""
    rows = []
    for line in table.shown_lines():
        time, stream = table.needed(line, "Time (ms)", N_("time")), table.needed(line, "Stream", N_("stream"))
        send, expect = table.cell(line, "Send"), table.cell(line, "Expect")
        expect = _in(expect, partial(japanese.standard, japanese.EXPECTED))
        rows.append(model.TestRow(time, stream, send, expect, table.remarks(line)))
    return model.TestSheet(table.sheet.name, tuple(rows))


def read_gestures(table: OwnTable) -> tuple[model.GestureRow, ...]:
    """The keyframes of a Gestures sheet; a blank joint is not among a keyframe's joints."""
    keys = table.header_keys
    headers = {keys[c]: table.others[c].strip() for c in sorted(keys)}
    rows = []
    for line in table.shown_lines():
        name, time = table.needed(line, "Name", N_("name")), table.needed(line, "Time (s)", N_("time"))
        joints = {keys[c]: table.cell(line, c) for c in sorted(keys) if c in line.cells}
        rows.append(model.GestureRow(name, time, {k: cell for k, cell in joints.items() if cell}, headers))
    return tuple(rows)


def read_protocol(table: OwnTable, fields: dict[str, Cell], names: dict[str, str]) -> Address:
    """Add the fields of a Protocol sheet to `fields` (cells by key) and `names` (as spelt); dates may be values.

    Returns where the next field's name would stand.
    """
    for line in table.shown_lines():
        name = table.needed(line, "Field", N_("field name"))
        value = table.cell(line, "Value")
        k = field_key(name.text)
        if k in FIELDS:
            value = _in(value, FIELDS[k].standard)
        if name and k in fields:
            table.add("SHEET015", name.address, field=name.text, first=str(fields[k].address))
        elif name:
            fields[k], names[k] = value, name.text
    return table.address(max(table.sheet.rows(), default=table.header_row) + 1, table.columns["Field"])


def read_risks(table: OwnTable) -> model.RiskSheet:
    """The rows of a Risks sheet."""
    headers = ("Risk", "For whom", "How likely", "What reduces it", "Who ends the session when")
    columns = {header: table.columns.get(header, 0) for header in headers}
    rows = [
        model.RiskRow(table.cell(line, "Risk"), table.cell(line, "For whom"), table.cell(line, "How likely"),
                      table.cell(line, "What reduces it"), table.cell(line, "Who ends the session when"),
                      table.remarks(line))
        for line in table.shown_lines()
    ]  # fmt: skip
    last = max(table.sheet.rows(), default=table.header_row)
    return model.RiskSheet(table.address(table.header_row, columns["Risk"]), tuple(rows), columns, last)


READERS: Mapping[str, Callable[[OwnTable], Iterable[object]]] = {
    "behaviour": lambda table: [read_behaviour(table)], "devices": read_devices, "helpers": read_helpers,
    "scene": read_scene, "gestures": read_gestures, "test": lambda table: [read_test(table)],
    "risks": lambda table: [read_risks(table)],
}  # fmt: skip
"""Readers of what the sheets of a kind say, by its name; a Protocol sheet adds to what another one says."""


def words(texts: Iterable[str]) -> set[str]:
    """The keys of all words in formulas, without those in texts: a text that says “notes” names no sheet.

    >>> sorted(words(['INDEX(Parts; step) & "notes"']))
    ['index', 'parts', 'step']
    """
    return {key(word) for text in texts for word in _words(_TEXT.sub(" ", text))}


def _words(text: str) -> list[str]:
    # not by \w alone, which leaves out the vowel signs of many scripts
    between = {ord(c): " " for c in set(text) if not (c.isalnum() or c == "_" or f"a{c}".isidentifier())}
    return text.translate(between).split()


def is_named(sheet: str, named: set[str]) -> bool:
    """Return whether a sheet's name is one of the words, as it can be written in a formula."""
    return key(sheet) in named or key(argument_name(sheet)) in named


def read_table(sheet: RawSheet, report: Report) -> tuple[tuple[str, ...], ...]:
    """Header and rows to the first blank one, as texts; a blank cell is an empty text, a text too long is cut."""
    filled = {at: text for at, cell in sheet.cells.items() if (text := clean_prose(cell.text or cell.formula))}
    if not filled:
        report.add("SHEET020", Address(sheet.name), sheet=sheet.name)
        return ()
    top = min(row for row, _ in filled)
    header = sorted(column for row, column in filled if row == top)
    left, right = header[0], header[-1]
    if right - left >= limits.TABLE_COLUMNS:
        right = left + limits.TABLE_COLUMNS - 1
        limit, beyond = f"{limits.TABLE_COLUMNS:,}", Address(sheet.name, top, right + 1)
        report.add("SHEET019", beyond, sheet=sheet.name, limit=limit, what=N_("columns"))
    seen: set[str] = set()
    used = {column for row, column in filled if row == top + 1}
    for column in range(left, right + 1):  # formulas cannot reach one without a name, or with the name of another
        title = filled.get((top, column), "")
        if key(title) in seen:
            report.add("FORM023", Address(sheet.name, top, column), table=sheet.name, title=title)
        elif not key(title) and column in used:
            report.add("FORM024", Address(sheet.name, top, column), table=sheet.name)
        seen |= {key(title)} - {""}
    rows = []
    present = {row for row, column in filled if left <= column <= right}
    for row in takewhile(present.__contains__, count(top)):
        if row > top + limits.TABLE_ROWS:
            limit, beyond = f"{limits.TABLE_ROWS:,}", Address(sheet.name, row, left)
            report.add("SHEET019", beyond, sheet=sheet.name, limit=limit, what=N_("rows"))
            break
        rows.append(tuple(_text(sheet, (row, column), filled, report) for column in range(left, right + 1)))
    if len(rows) < 2:
        report.add("SHEET020", Address(sheet.name, top, left), sheet=sheet.name)
    return tuple(rows)


def _text(sheet: RawSheet, at: tuple[int, int], filled: dict[tuple[int, int], str], report: Report) -> str:
    text = filled.get(at, "")
    if len(text) > limits.TABLE_TEXT:
        report.add("SHEET016", Address(sheet.name, *at), count=f"{len(text):,}", limit=f"{limits.TABLE_TEXT:,}")
    return text[: limits.TABLE_TEXT]
