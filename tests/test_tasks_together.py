"""Tasks beside writing rows: tables are brought from elsewhere, and people work together."""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest
from chromium import GridPage, becomes, eventually
from tasks import texts

from rrp_sheets.workbook.files import make_workbook, read_sheets

HEADER = ["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"]
FORMULAS = [
    '"near"\nif x < 0.8\nelse "far"', 'say("a")', 'a "quoted" word', "plain", "x = 1+1", "it's", "  spaces  ",
    "日本語\nüñ", '""', "007", "1,5; 2", "TRUE and so on",
]  # fmt: skip
NOTES = ["note", "two\nlines", 'he said "hi"\nand left', "", '"']
TABLE = [
    [
        f"Stream {i}" if i % 5 else "Red ball, Green ball", "map", FORMULAS[i % len(FORMULAS)], f"S {i}",
        "" if i % 3 else "no", NOTES[i % len(NOTES)],
    ]
    for i in range(40)
]  # fmt: skip
TSV = Path(__file__).parent / "golden" / "libreoffice-40-rows.tsv"


def two(browser: Any, url: str, folder: Path, name: str, rows: int) -> tuple[GridPage, GridPage]:
    """A workbook with so many rows, and two people who have it open."""
    made = [["Red ball", "map", f"{n}", f"S{n}", "", ""] for n in range(rows)]
    make_workbook({"T": [HEADER, *made]}, folder / name)
    first, second = (GridPage(browser, url, name, name=who) for who in ("Aya", "Mika"))
    return first, second


def cells(path: Path, column: int, sheet: str = "T") -> dict[int, str]:
    """The texts of a column in the file, by row."""
    (found,) = (s.cells for s in read_sheets(path) if s.name == sheet)
    return {row: cell.typed for (row, at), cell in found.items() if at == column and row > 1}


if shutil.which("soffice"):

    def test_the_table_of_the_next_test_is_what_libreoffice_makes_of_it(
        tmp_path: Path, golden: Any, office: str
    ) -> None:
        made = make_workbook({"T": TABLE}, tmp_path / "a.xlsx")
        kinds = ("ods", "csv:Text - txt - csv (StarCalc):9,34,76,1,,0,false,true,false")
        for source, kind in zip((made, tmp_path / "a.ods"), kinds, strict=True):
            command = ["soffice", office, "--headless", "--convert-to", kind, "--outdir", str(tmp_path), str(source)]
            subprocess.run(command, check=True, capture_output=True, timeout=300)
        golden(TSV.name, (tmp_path / "a.csv").read_bytes().decode("utf-8"))


@pytest.mark.slow
def test_forty_rows_of_libreoffice_are_pasted_and_copied_back_byte_by_byte(
    browser: Any, url: str, folder: Path
) -> None:
    make_workbook({"T": [HEADER, ["Red ball", "map", "1", "Here before", "", ""]]}, folder / "paste.xlsx")
    page = GridPage(browser, url, "paste.xlsx")
    text = TSV.read_bytes().decode("utf-8")
    page.page.evaluate("text => navigator.clipboard.writeText(text)", text)
    page.go("A3")
    page.press("Control+v")
    page.expect("D42", "S 39")
    page.saved()
    page.page.evaluate("navigator.clipboard.writeText('')")
    page.press("Control+c")
    becomes(lambda: page.page.evaluate("navigator.clipboard.readText()"), text)
    for column, wanted in enumerate(zip(*TABLE, strict=True), start=1):
        found = cells(folder / "paste.xlsx", column)
        assert [found.get(row, "") for row in range(3, 43)] == list(wanted)
    page.close()


@pytest.mark.slow
@pytest.mark.parametrize("count", [6, pytest.param(100, marks=pytest.mark.soak)])
def test_two_people_edit_many_cells_at_once(browser: Any, url: str, folder: Path, count: int) -> None:
    """In the same rows, the one the formulas and the other the notes; nobody waits for the other, nor for the server."""
    helpers = [["Name", "Inputs", "Formula", "Notes"], *([f"Number {n}", "", "0", ""] for n in range(count))]
    make_workbook({"T": [HEADER, ["Red ball", "map", "1", "S", "", ""]], "Helpers": helpers}, folder / "at once.xlsx")
    people = [GridPage(browser, url, "at once.xlsx", sheet="Helpers", name=who) for who in ("Aya", "Mika")]
    for page, column in zip(people, "CD", strict=True):
        page.go(f"{column}2")
    for n in range(count):
        for page, text in zip(people, (f"{n} + 1", f"note {n}"), strict=True):
            page.press(text[0])  # begins to write; that each further letter is a key of its own is tested elsewhere
            page.page.keyboard.insert_text(text[1:])
            page.press("Enter")
    for page in people:
        page.saved()
        page.expect(f"C{count + 1}", f"{count - 1} + 1")
        page.expect(f"D{count + 1}", f"note {count - 1}")
    shown = [texts(page.page) for page in people]
    assert shown[0] == shown[1] == [[f"Number {n}", f"{n} + 1", f"note {n}"] for n in range(count)]
    for column, wanted in ((3, "{} + 1"), (4, "note {}")):
        assert cells(folder / "at once.xlsx", column, "Helpers") == {n + 2: wanted.format(n) for n in range(count)}
    for page in people:
        page.close()


@pytest.mark.slow
def test_ones_edit_goes_on_while_another_inserts_and_deletes_rows_and_ones_undo_takes_back_ones_own_edits_only(
    browser: Any, url: str, folder: Path
) -> None:
    aya, mika = two(browser, url, folder, "rows.xlsx", 6)
    aya.go("F4")
    aya.page.keyboard.type("half")
    mika.go("B2")
    mika.press("Control++")
    for page in (aya, mika):
        page.page.wait_for_selector("tbody tr:nth-child(4) td:has-text('S2')")
    aya.page.keyboard.type(" a")
    mika.go("B3")
    mika.press("Control+-")
    aya.page.wait_for_selector("tbody tr:nth-child(3) td:has-text('S2')")
    aya.page.keyboard.type(" note")
    becomes(lambda: aya.page.locator("textarea").input_value(), "half a note")
    aya.press("Enter")
    mika.expect("F4", "half a note")
    aya.saved()
    assert cells(folder / "rows.xlsx", 6) == {4: "half a note"}
    assert [cells(folder / "rows.xlsx", 4)[row] for row in (3, 4)] == ["S1", "S2"]
    aya.go("F2")
    aya.write("a1")
    mika.expect("F2", "a1")
    mika.go("F3")
    mika.write("m1")
    aya.expect("F3", "m1")
    aya.go("F5")
    aya.write("a2")
    mika.expect("F5", "a2")
    mika.press("Control+z")  # hers is not the newest
    aya.page.wait_for_selector("tbody tr:nth-child(2) td.notes:not([data-v])", state="attached")
    eventually(lambda: aya.text("F2") == "a1" and aya.text("F5") == "a2")
    aya.press("Control+z", "Control+z")
    mika.page.wait_for_selector("tbody tr:nth-child(1) td.notes:not([data-v])", state="attached")
    aya.saved()
    assert {row: text for row, text in cells(folder / "rows.xlsx", 6).items() if text} == {4: "half a note"}
    mika.press("Control+y")
    aya.expect("F3", "m1")
    for page in (aya, mika):
        page.close()
