"""Workbooks with what openpyxl would lose on saving, and a look at which parts of a package differ."""

from __future__ import annotations

import io
import zipfile
from collections.abc import Callable, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import pytest
import xlsxwriter
from PIL import Image

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.edits import Edit
from rrp_sheets.workbook.files import edit, read_sheets

HEADERS = ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes", "Mine"]
ROWS = [
    ["Red ball", "map", "redBall.distance", "Distance", "", "first", 1.5],
    ["Distance", "filter", "distance < 0.5", "Near", "", "second", 2],
    ["Near", "subscribe", "", "Head tracker", "", "third", 3],
    ["Distance", "map", "distance * 2", "Double", "", "fourth", 4],
    ["Double", "filter", "double > 1", "Far", "", "fifth", 5],
    ["Far", "subscribe", "", "Eye brightness", "", "sixth", 6],
]
SHEET = "Tracking"


def make(path: Path, feature: Callable[[Any, Any], None] = lambda book, sheet: None, **options: Any) -> Path:
    """A workbook whose first sheet is a behaviour; `feature(book, sheet)` adds to it."""
    book = xlsxwriter.Workbook(str(path), options)
    sheet = book.add_worksheet(SHEET)
    text = book.add_format({"num_format": "@", "text_wrap": True})
    sheet.set_column("A:F", 18, text)
    sheet.write_row(0, 0, HEADERS)
    for number, row in enumerate(ROWS, 1):
        sheet.write_row(number, 0, row)
    mine = book.add_worksheet("Mine")
    mine.write_column(0, 0, [10, 20, 30])
    feature(book, sheet)
    book.close()
    return path


def edited(data: bytes, edits: Sequence[Edit]) -> bytes:
    """A file's bytes after edits."""
    with TemporaryDirectory() as folder:
        path = Path(folder) / "x.xlsx"
        path.write_bytes(data)
        edit(path, edits)
        return path.read_bytes()


def picture() -> io.BytesIO:
    """A small PNG."""
    data = io.BytesIO()
    Image.new("RGB", (8, 8), "red").save(data, "PNG")
    data.seek(0)
    return data


def _chart(book: Any, sheet: Any) -> None:
    chart = book.add_chart({"type": "line"})
    chart.add_series({"values": "=Mine!$A$1:$A$3", "name": "Mine"})
    sheet.insert_chart("J2", chart)


def _chart_sheet(book: Any, sheet: Any) -> None:
    chart = book.add_chart({"type": "column"})
    chart.add_series({"values": "=Tracking!$G$2:$G$7"})
    book.add_chartsheet("Picture").set_chart(chart)


def _comments(book: Any, sheet: Any) -> None:
    sheet.write_comment("C3", "on the filter", {"author": "A"})
    sheet.write_comment("C5", "on the map", {"author": "B", "visible": True})


def _validations(book: Any, sheet: Any) -> None:
    sheet.data_validation("B2:B50", {"validate": "list", "source": ["map", "filter"], "input_title": "What"})
    sheet.data_validation("A2:A50", {"validate": "list", "source": "=Mine!$A$1:$A$3"})


def _formats(book: Any, sheet: Any) -> None:
    sheet.conditional_format("G2:G50", {"type": "data_bar", "data_bar_2010": True, "bar_solid": True})
    sheet.conditional_format("A2:A50", {"type": "formula", "criteria": "=LEN($A2)>5", "format": book.add_format()})
    sheet.conditional_format("G2:G50", {"type": "icon_set", "icon_style": "3_arrows"})


def _rich(book: Any, sheet: Any) -> None:
    bold = book.add_format({"bold": True})
    sheet.write_rich_string("F6", "some ", bold, "bold", " words")
    book.get_worksheet_by_name("Mine").write_rich_string("B2", bold, "bold", " words")


def _outline(book: Any, sheet: Any) -> None:
    sheet.set_row(4, 30, None, {"level": 1, "hidden": False})
    sheet.set_row(5, 40, book.add_format({"bg_color": "yellow"}), {"level": 1})
    sheet.freeze_panes(1, 2)
    sheet.autofilter("A1:G7")
    sheet.repeat_rows(0)
    sheet.print_area("A1:G7")
    sheet.set_h_pagebreaks([3])


def _links(book: Any, sheet: Any) -> None:
    sheet.write_url("F3", "https://example.org/a?b=1&c=2", string="second")
    sheet.write_url("F5", "internal:Mine!A1", string="fourth")


def _formulas(book: Any, sheet: Any) -> None:
    for row in range(2, 8):
        sheet.write_formula(f"H{row}", f"=G{row}*2", None, 0)
    mine = book.get_worksheet_by_name("Mine")
    mine.write_formula("B1", "=SUM(Tracking!G2:G7)", None, 21.5)
    mine.write_dynamic_array_formula("D1", "=SORT(A1:A3)")
    sheet.write_dynamic_array_formula("J1:J1", "=LEN(SEQUENCE(1))")
    book.define_name("All", "=Tracking!$G$2:$G$7")


def _table(book: Any, sheet: Any) -> None:
    mine = book.get_worksheet_by_name("Mine")
    mine.add_table("F1:G4", {"name": "Parts", "columns": [{"header": "Part"}, {"header": "Step"}]})
    sheet.add_table("A1:G7", {"name": "Behaviour", "columns": [{"header": h} for h in HEADERS]})


def _protected(book: Any, sheet: Any) -> None:
    sheet.protect("secret", {"sort": True})
    sheet.unprotect_range("A2:D9", "people")
    sheet.ignore_errors({"number_stored_as_text": "A1:XFD1048576"})


FEATURES: dict[str, Callable[[Any, Any], None]] = {
    "plain": lambda book, sheet: None,
    "chart": _chart,
    "chart sheet": _chart_sheet,
    "shapes": lambda book, sheet: sheet.insert_textbox("J2", "a text box", {"textlink": "=Mine!$A$1"}),
    "buttons": lambda book, sheet: (sheet.insert_button("J2", {"caption": "Press"}), sheet.write_comment("F4", "x")),
    "checkboxes": lambda book, sheet: sheet.insert_checkbox("K4", True),
    "sparklines": lambda book, sheet: sheet.add_sparkline("I2", {"range": "Mine!A1:A3"}),
    "images": lambda book, sheet: sheet.insert_image("J2", "red.png", {"image_data": picture()}),
    "picture in a cell": lambda book, sheet: sheet.embed_image("I6", "red.png", {"image_data": picture()}),
    "background": lambda book, sheet: sheet.set_background(picture()),
    "header picture": lambda book, sheet: sheet.set_header(
        "&L&G", {"image_left": "red.png", "image_data_left": picture()}
    ),
    "validations": _validations,
    "conditional formats": _formats,
    "rich text": _rich,
    "comments": _comments,
    "outline": _outline,
    "links": _links,
    "formulas": _formulas,
    "tables": _table,
    "protection": _protected,
    "properties": lambda book, sheet: (
        book.set_custom_property("Ethics", "2026-7"), book.set_properties({"title": "T", "comments": "C"})
    ),
}  # fmt: skip


def parts(path: Path | bytes) -> dict[str, bytes]:
    """The parts of a package by name, in their order."""
    with zipfile.ZipFile(io.BytesIO(path) if isinstance(path, bytes) else path) as package:
        return {entry.filename: package.read(entry) for entry in package.infolist()}


def repack(path: Path, change: dict[str, bytes | Callable[[bytes], bytes]], **options: Any) -> Path:
    """Write the package with parts changed or added."""
    old = parts(path)
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as package:
        for name, data in old.items():
            new = change.pop(name, data)
            package.writestr(name, new(data) if callable(new) else new)
        for name, new in change.items():
            assert isinstance(new, bytes)
            package.writestr(name, new)
    return path


def add_part(path: Path, name: str, data: bytes, content_type: str, source: str, kind: str) -> None:
    """Add a part to a package: its content type, and its relation from the part `source`."""
    folder, _, leaf = source.rpartition("/")
    rels = f"{folder}/_rels/{leaf}.rels"
    there = parts(path)
    target = "/" + name
    relation = f'<Relationship Id="rIdExtra{len(there)}" Type="{kind}" Target="{target}"/>'.encode()
    empty = b'<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"></Relationships>'
    repack(
        path,
        {
            name: data,
            rels: there.get(rels, empty).replace(b"</Relationships>", relation + b"</Relationships>"),
            "[Content_Types].xml": there["[Content_Types].xml"].replace(
                b"</Types>", f'<Override PartName="/{name}" ContentType="{content_type}"/></Types>'.encode()
            ),
        },
    )


def cell(path: Path, row: int, column: int, sheet: int = 0) -> str:
    """Text that was typed into a cell of the file."""
    found = read_sheets(path)[sheet].cells.get((row, column))
    return found.typed if found else ""


def refused(path: Path, *edits: Edit) -> SheetsError:
    """Why edits are refused, with a remedy; the file stays as it was."""
    before = path.read_bytes()
    with pytest.raises(SheetsError) as told:
        edit(path, edits)
    assert path.read_bytes() == before
    assert told.value.remedy
    return told.value
