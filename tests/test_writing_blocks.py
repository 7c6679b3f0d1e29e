"""Edits of sheets whose rows lie in many blocks, with formulas that stand for several cells."""

from __future__ import annotations

import io
import zipfile
from typing import Any

import openpyxl
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lossless import edited, parts
from lxml import etree
from openpyxl.worksheet.formula import ArrayFormula

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook.edits import DeleteRows, Edit, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.patch import package_edit

PART = "xl/worksheets/sheet1.xml"
ARRAY, SHARED = "array", "shared"
Rows = dict[int, dict[int, str]]
"""What the cells hold, by row and column: a number, or the kind of the formula there."""


def workbook(rows: Rows) -> bytes:
    """Numbers in A, array formulas in B and C, in D one formula that is shared by all rows that have it."""
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.title = "T"
    for n, row in rows.items():
        for column, held in row.items():
            if held == ARRAY:
                sheet.cell(n, column, ArrayFormula(f"B{n}:C{n}", f"=A{n}*2"))
            else:
                sheet.cell(n, column, f"=A{n}+1" if held == SHARED else float(held))
    data = io.BytesIO()
    book.save(data)
    root = etree.fromstring(parts(data.getvalue())[PART])
    shared = [f for f in root.iter("{*}f") if f.get("t") is None]
    for f in shared:
        f.attrib.update({"t": "shared", "si": "0"} | ({"ref": "D1:D99"} if f is shared[0] else {}))
        f.text = f.text if f is shared[0] else None
    return repacked(data.getvalue(), etree.tostring(root))


def repacked(data: bytes, sheet: bytes) -> bytes:
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as package:
        for name, content in (parts(data) | {PART: sheet}).items():
            package.writestr(name, content)
    return out.getvalue()


def read(data: bytes) -> Rows:
    """The rows as they are told by the part, each formula as what it was made from."""
    found: Rows = {}
    last = 0
    for row in etree.fromstring(parts(data)[PART]).iter("{*}row"):
        n = int(row.get("r", ""))
        assert n > last
        last = n
        for cell in row.iterchildren("{*}c"):
            assert cell.get("r", "").lstrip("ABCD") == str(n)
            f = cell.find("{*}f")
            held = "".join(map(str, cell.itertext()))
            if f is not None and f.get("t") == "array":
                assert (f.get("ref"), f.text) == (f"B{n}:C{n}", f"A{n}*2")
                held = ARRAY
            elif f is not None:
                assert f.text == f"A{n}+1" or f.get("t") == "shared"
                held = SHARED
            if held:
                found.setdefault(n, {})[" ABCD".index(cell.get("r", "")[0])] = held
    return found


def after(rows: Rows, one: Edit) -> Rows:
    """The rows after an edit."""
    if isinstance(one, SetCell):
        cells = {c: held for c, held in rows.get(one.row, {}).items() if c != one.column}
        cells |= {} if one.value is None else {one.column: f"{one.value:g}"}
        return {n: row for n, row in {**rows, one.row: cells}.items() if row}
    return {new: row for n, row in rows.items() if (new := one.mapped(n)) is not None}


ROW = st.builds(
    lambda number, array, shared: {1: str(number)} | ({2: ARRAY} if array else {}) | ({4: SHARED} if shared else {}),
    st.integers(1, 99), st.booleans(), st.booleans(),
)  # fmt: skip
NUMBER, COUNT = st.integers(1, 30), st.integers(1, 9)
EDIT: Any = st.one_of(
    st.builds(SetCell, st.just("T"), NUMBER, st.sampled_from([1, 3, 4]), st.sampled_from([None, 1000.0, 1001.0])),
    st.builds(InsertRows, st.just("T"), NUMBER, COUNT),
    st.builds(DeleteRows, st.just("T"), NUMBER, COUNT),
    st.builds(MoveRows, st.just("T"), NUMBER, COUNT, NUMBER),
)


@pytest.mark.slow
@pytest.mark.parametrize("size", [1, 4])
@settings(max_examples=60, deadline=None)
@given(rows=st.dictionaries(st.integers(1, 25), ROW, max_size=20), edits=st.lists(EDIT, max_size=6))
def test_edits_across_blocks(size: int, rows: Rows, edits: list[Edit]) -> None:
    wanted = rows
    for n, one in enumerate(edits):
        if isinstance(one, SetCell) and one.column == 3 and ARRAY in wanted.get(one.row, {}).values():
            with pytest.MonkeyPatch.context() as patched, pytest.raises(SheetsError, match="array formula"):
                patched.setattr(package_edit, "_BLOCK_ROWS", size)
                edited(workbook(rows), edits[: n + 1])
            edits = edits[:n]
            break
        wanted = after(wanted, one)
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(package_edit, "_BLOCK_ROWS", size)
        new = edited(workbook(rows), edits)
    assert read(new) == wanted
    openpyxl.load_workbook(io.BytesIO(new))


def test_an_array_formula_is_known_after_rows_were_inserted_above() -> None:
    with pytest.raises(SheetsError, match="an array formula that fills B9:C9"):
        edited(workbook({8: {1: "1", 2: ARRAY}}), [InsertRows("T", 5), SetCell("T", 9, 3, "x")])


def test_shared_formulas_follow_one_insertion_after_another() -> None:
    new = edited(workbook({n: {1: "1", 4: SHARED} for n in (6, 7, 8)}), [InsertRows("T", 5), InsertRows("T", 8)])
    assert [f.text for f in etree.fromstring(parts(new)[PART]).iter("{*}f")] == ["A7+1", "A9+1", "A10+1"]
