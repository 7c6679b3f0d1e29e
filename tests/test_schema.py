"""The schema of the sheets' columns: an entry is all that a column needs to be read, offered, shown and compared."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

import openpyxl
import pytest

from rrp_sheets import api
from rrp_sheets.compare.as_text import say
from rrp_sheets.documents.grid import make_grid
from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.topics import text_on
from rrp_sheets.web.row_renderer import RowRenderer
from rrp_sheets.workbook import read
from rrp_sheets.workbook.schema import BEHAVIOUR, CELLS, SHEETS, CellChoice, Column, recognise
from rrp_sheets.workbook.template import beginning

ROWS = """
## Tracking
| Input streams | Connector | Formula | Output stream | Looked after by |
|---|---|---|---|---|
| Red ball | map | redBall.distance | Distance | Aya |
| Distance | subscribe | | Print | |
| | | | | Kai |
"""
OWNER = Column(
    "Owner", width=14, prompt="Who looks after this row.", synonyms=("Looked after by",), help="keys", offers="Owners",
    choices=(CellChoice("Aya", "of the clinic"), CellChoice("Kai")), required=False, effect=False,
)  # fmt: skip


@pytest.fixture
def owner(monkeypatch: pytest.MonkeyPatch) -> None:
    """A further column of behaviours, as if it stood in the schema."""
    columns = (*BEHAVIOUR.columns, OWNER)
    spellings = {**BEHAVIOUR.spellings, "owner": "Owner", "lookedafterby": "Owner"}
    for name, value in (("columns", columns), ("optional", (*BEHAVIOUR.optional, OWNER)), ("spellings", spellings)):
        monkeypatch.setitem(BEHAVIOUR.__dict__, name, value)


@pytest.fixture
def book(tmp_path: Path, owner: None) -> Path:
    path = tmp_path / "book.md"
    path.write_text(ROWS, encoding="utf-8")
    return path


def test_added_column_is_read_and_makes_no_row_alone(book: Path) -> None:
    first, second = read(book).workbook.behaviours[0].rows
    assert (first.remarks, second.remarks) == ({"Owner": "Aya"}, {})


def test_added_column_survives_conversions(book: Path, tmp_path: Path) -> None:
    xlsx = api.convert(book, tmp_path / "book.xlsx")
    csv = api.convert(xlsx, tmp_path / "folder")
    again = api.convert(csv, tmp_path / "again.md")
    for path in (xlsx, csv, again):
        assert [row.remarks for row in read(path).workbook.behaviours[0].rows] == [{"Owner": "Aya"}, {}]


@pytest.mark.usefixtures("owner")
def test_new_sheet_offers_an_added_column() -> None:
    assert beginning("behaviour") == [[*(c.name for c in BEHAVIOUR.columns if c.offered)]]
    assert "Owner" in beginning("behaviour")[0]


def test_new_workbook_has_width_prompt_and_list_of_an_added_column(book: Path, tmp_path: Path) -> None:
    made = openpyxl.load_workbook(api.convert(book, tmp_path / "book.xlsx"))
    sheet = made["Tracking"]
    rule = next(v for v in sheet.data_validations.dataValidation if v.promptTitle == "Owner")
    assert (sheet.column_dimensions["E"].width, rule.prompt) == (14, "Who looks after this row.")
    assert (rule.type, rule.formula1) == ("list", "List_owners")
    lists = {column[0].value: [cell.value for cell in column[1:3]] for column in made["Lists"].columns}
    assert lists["Owners"] == ["Aya", "Kai"]


def test_grid_gets_width_help_and_suggestions_of_an_added_column(book: Path) -> None:
    (sheet,) = read(book).sheets
    head = RowRenderer(make_grid(sheet, recognise(sheet), "behaviour")).heads()[-1]
    assert head.spellings == ("lookedafterby", "owner")
    assert (head.column.cells.pixels, head.column.help) == (CELLS["text"].pixels, "keys")
    assert asdict(head.column.choices[0]) == {"text": "Aya", "help": "of the clinic"}


@pytest.mark.usefixtures("owner")
def test_help_lists_an_added_column() -> None:
    assert "On, Notes, Priority, Owner" in " ".join(as_text(text_on("sheets")).split())


def test_changed_cell_of_an_added_column_leaves_the_behaviour_the_same(book: Path, tmp_path: Path) -> None:
    other = tmp_path / "other.md"
    other.write_text(ROWS.replace("| Aya |", "| Kai |"), encoding="utf-8")
    found = api.diff(book, other)
    assert found.same
    assert [say(change) for change in found.changes] == ["Tracking row 2: owner Aya → Kai"]


@pytest.mark.parametrize("kind", SHEETS)
def test_help_of_every_column_exists(kind: str) -> None:
    for topic in {column.help for column in SHEETS[kind].columns} - {""}:
        assert list(text_on(topic))


@pytest.mark.parametrize("kind", SHEETS)
def test_headers_of_a_kind_are_told_apart(kind: str) -> None:
    columns = SHEETS[kind].columns
    assert len(SHEETS[kind].spellings) == sum(1 + len(column.synonyms) for column in columns)
