"""Pasted cells: what other programs put on the clipboard, and blocks with header rows, which say where the cells go."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from chromium import becomes
from grid_books import EMPTY, HEADER, ROWS, Books, Shared
from playwright.sync_api import expect

from rrp_sheets.model.names import key
from rrp_sheets.workbook.files import read_sheets
from rrp_sheets.workbook.schema import SHEETS as KINDS

OURS = "The header row was not pasted: the sheet has one."
BY_NAME = "Each cell was pasted into the column with the same name."
UNKNOWN = "Columns that this sheet does not have were left out: Who."
BALL = ["", "Red ball", "map", "redBall.distance", "Distance", "new"]


EXCEL = """<html xmlns:o="urn:schemas-microsoft-com:office:office"><head><meta name=Generator content="Microsoft Excel 15">
<style><!--table {{mso-displayed-decimal-separator:"\\.";}} .xl65 {{white-space:normal;}}--></style></head><body>
<!--StartFragment--><table border=0 style='border-collapse:collapse'><col width=64>
 <tr height=20 style='height:15.0pt'><td class=xl65 style='width:48pt'>Red
  ball</td><td>map</td><td>{formula}</td></tr><!--EndFragment--></table></body></html>"""
SHEETS_HTML = """<google-sheets-html-origin><style type="text/css"><!--td {{border: 1px solid #cccccc;}}--></style>
<table xmlns="http://www.w3.org/1999/xhtml" dir="ltr" data-sheets-root="1"><colgroup><col width="100"/></colgroup><tbody>
<tr><td data-sheets-value='{{"1":2}}'>a</td><td>{formula}</td></tr></tbody></table></google-sheets-html-origin>"""
MAIL = """<div dir="ltr"><table><tbody><tr><td><p>Face</p></td><td><div>map</div></td><td><span>&ldquo;Hi&nbsp;all&rdquo;</span></td>
</tr><tr><td colspan="2">Say</td><td><p>1</p><p>2<br>3</p></td></tr></tbody></table></div>"""
CLIPBOARDS = {  # text, HTML, cells
    "a quoted text alone": ('"Hello"', "", [['"Hello"']]),
    "no text between quotes": ('a\t""\n', "", [["a", '""']]),
    "quoted texts side by side": ('"a"\t"b"\n"c"\t1\n', "", [['"a"', '"b"'], ['"c"', "1"]]),
    "texts joined": ('"a" & x & "b"\t"" & y', "", [['"a" & x & "b"', '"" & y']]),
    "smart quotes": ("“Hello”\t‘a’", "", [["“Hello”", "‘a’"]]),
    "a quote that is not closed": ('"Hello\tb', "", [['"Hello', "b"]]),
    "quotes that a spreadsheet doubled": ('"""Hello"""\t"say ""hi"""', "", [['"Hello"', 'say "hi"']]),
    "line breaks and tabs": ('"1\n2"\t"a\tb"\r\n', "", [["1\n2", "a\tb"]]),
    "Excel": ('Red ball\tmap\t"Hello"\r\n', EXCEL.format(formula='"Hello"'), [["Red ball", "map", '"Hello"']]),
    "Excel, a text with doubled quotes": (
        'Red ball\tmap\t"say ""hi"""\r\n', EXCEL.format(formula='"say ""hi"""'), [["Red ball", "map", '"say ""hi"""']]
    ),
    "Sheets, with two spaces": ('a\t"x  y"', SHEETS_HTML.format(formula='"x  y"'), [["a", '"x  y"']]),
    "Sheets, with a line break": ('a\t"1\n2"', SHEETS_HTML.format(formula="1<br/>2"), [["a", "1\n2"]]),
    "a mail, whose text has lines only": ("Face\nmap\n“Hi all”\nSay\n1\n2\n3", MAIL, [
        ["Face", "map", "“Hi all”"], ["Say", "", "1\n2\n3"],
    ]),
    "joined cells": ("", "<table><tr><td rowspan=2>a<td>b<tr><td>c</table>", [["a", "b"], ["", "c"]]),
    "a table with a text around it": ('x\t"y"', "<p>See:</p><table><tr><td>y</table>", [["x", '"y"']]),
    "Markdown": ('| Face | map | "Hello" |\n|---|---|---|\n| a \\| b | `x<1` | 1<br>2 |\n', "", [
        ["Face", "map", '"Hello"'], ["a | b", "x<1", "1\n2"],
    ]),
    "dashes in a Markdown table": ("| Face | map |\n|---|---|\n| - | - |\n", "", [["Face", "map"], ["-", "-"]]),
    "a rule alone": ("|---|", "", [["|---|"]]),
    "a part of a Markdown table": ('| Face | map |\nand more', "", [["| Face | map |"], ["and more"]]),
}  # fmt: skip


def test_what_programs_put_on_the_clipboard_becomes_their_cells(shelf: Books) -> None:
    found = shelf.open().page.evaluate(  # read once: no state of the page
        """async given => {
            const { cellsOf } = await import("/static/grid/clipboard.js");
            return given.map(([text, html]) => cellsOf({ text, html }));
        }""",
        [[text, html] for text, html, _ in CLIPBOARDS.values()],
    )
    assert dict(zip(CLIPBOARDS, found, strict=True)) == {name: cells for name, (*_, cells) in CLIPBOARDS.items()}


def test_quotes_of_formulas_arrive_in_cells_and_in_the_editor(shelf: Books) -> None:
    grid = shelf.open()
    grid.page.evaluate(
        "text => navigator.clipboard.writeText(text)", 'Distance\tmap\t"Hello"\tTold\nTold\tmap\t“Hello”\tSaid'
    )
    grid.go("B5")
    grid.press("Control+v")
    grid.expect("D6", "“Hello”")
    assert [row[2] for row in grid.rows()[3:]] == ['"Hello"', '"Hello"']
    for keys in ["Control+c"], ["ContextMenu"]:  # by the key, and by the menu
        grid.go("D5")
        grid.press(*keys)
        if keys == ["ContextMenu"]:
            grid.page.get_by_role("menuitem", name="Copy").click()
        grid.status("One cell copied.")
        becomes(lambda: grid.page.evaluate("navigator.clipboard.readText()"), '"""Hello"""')
        grid.go("D7")
        grid.page.keyboard.type("x & ")
        grid.press("Control+v", "Control+Enter")
        becomes(lambda: grid.text("D7"), 'x & "Hello"')
        grid.go("D8")
        grid.press("Control+v")
        becomes(lambda: grid.text("D8"), '"Hello"')
        grid.go("D7")
        grid.press("Shift+ArrowDown", "Delete")
        becomes(lambda: (grid.text("D7"), grid.text("D8")), ("", ""))


def paste(grid: Shared, address: str, *lines: list[str]) -> None:
    text = "\n".join("\t".join(line) for line in lines)
    grid.page.evaluate("text => navigator.clipboard.writeText(text)", text)
    grid.go(address)
    grid.press("Control+v")


def rows(grid: Shared, sheet: str = "T") -> list[list[str]]:
    """Rows of the file below the header, without blank ones."""
    grid.saved()
    found = next(s for s in read_sheets(grid.path) if s.name == sheet)
    width = max(column for _, column in found.cells)
    lines = [[cells[c].typed if c in cells else "" for c in range(1, width + 1)] for _, cells in found.rows().items()]
    return [line for line in lines[1:] if any(line)]


BLOCKS = {
    "at the top": ([HEADER, *ROWS], OURS, ROWS),
    "within it, by synonyms": (
        [
            ROWS[0],
            ["on", "INPUT_STREAMS", "Ｏｐｅｒａｔｏｒ", "Parameter formula", "To", "Comment"],
            ROWS[1],
            HEADER,
            ROWS[2],
        ],
        "2 header rows were not pasted: the sheet has one.",
        ROWS,
    ),
    "in Japanese": (
        [["出力ストリーム", "入力ストリーム", "コネクタ", "数式"], ["Distance", "Red ball", "map", "redBall.distance"]],
        f"{OURS} {BY_NAME}",
        [["", "Red ball", "map", "redBall.distance", "Distance", ""]],
    ),
    "without a column and with an unknown one": (
        [["Output stream", "Connector", "Input streams", "Who"], ["Distance", "map", "Red ball", "Aya"]],
        f"{OURS} {BY_NAME} {UNKNOWN}",
        [["", "Red ball", "map", "", "Distance", ""]],
    ),
}


@pytest.mark.slow
def test_header_rows_of_a_pasted_block_are_left_out(shelf: Books) -> None:
    grid = shelf.open(EMPTY)
    for what, (block, told, wanted) in BLOCKS.items():
        paste(grid, "A2", *block)
        warned = ".is-warning" if UNKNOWN in told else ":not(.is-warning)"
        expect(grid.page.locator(f"#status{warned}"), what).to_have_text(told)
        expect(grid.cell(f"B{len(wanted) + 1}"), what).to_have_attribute("data-v", wanted[-1][1])
        assert rows(grid) == wanted, what
        grid.press("Control+z")
        expect(grid.cell("B2"), what).not_to_have_attribute("data-v", "Red ball")
        assert rows(grid) == [], what


@pytest.mark.slow
def test_cells_go_to_the_columns_that_the_pasted_header_row_names(shelf: Books) -> None:
    grid = shelf.open({"T": [HEADER, ["", "", "", "", "", "stays"]]})
    paste(grid, "D2", ["Output", "Who", "From", "Connector", "Formula"],
          ["Distance", "Aya", "Red ball", "map", "redBall.distance"])  # fmt: skip
    expect(grid.page.locator("#status.is-warning")).to_have_text(f"{OURS} {BY_NAME} {UNKNOWN}")
    grid.expect("E2", "Distance")
    assert rows(grid) == [["", "Red ball", "map", "redBall.distance", "Distance", "stays"]]


@pytest.mark.slow
def test_a_pasted_part_with_its_headers_is_known_and_a_header_row_alone_changes_nothing(shelf: Books) -> None:
    grid = shelf.open()
    paste(grid, "C5", HEADER[2:4], ["map", "1 + 1"])
    expect(grid.page.locator("#status")).to_have_text(OURS)
    grid.expect("D5", "1 + 1")
    paste(grid, "D6", ["Formula"], ["2 + 2"])
    grid.expect("D6", "2 + 2")
    paste(grid, "A2", HEADER)
    expect(grid.page.locator("#status")).to_have_text(OURS)
    assert rows(grid) == [*ROWS, ["", "", "map", "1 + 1", "", ""], ["", "", "", "2 + 2", "", ""]]


@pytest.mark.slow
def test_what_only_looks_like_a_header_row_is_pasted(shelf: Books) -> None:
    grid = shelf.open(EMPTY)
    block = [
        ["", "Input", "map", "1", "Output", "Notes"],
        ["", "", "", "", "Output", ""],
        ["", "Connector", "", "", "", "the"],
    ]
    paste(grid, "A2", *block)
    grid.expect("B4", "Connector")
    paste(grid, "F5", ["Notes"])  # a single text is what somebody means
    grid.expect("F5", "Notes")
    assert rows(grid) == [*block, ["", "", "", "", "", "Notes"]]


SHEETS = {
    "T": [HEADER, *ROWS],
    "Try": [["Time (ms)", "Stream", "Send", "Expect", "Notes"], ["0", "Distance", "1", "", "a"]],
    "Scene": [["Time (s)", "Thing", "Does", "Value", "Notes"], ["1", "Red ball", "appears", "at 1, 0.2, 0.4", "a"]],
    "Helpers": [["Name", "Inputs", "Formula", "Notes"], ["near", "a", "a + 1", "a"]],
    "Devices": [["Stream", "Device", "Colour", "Notes"], ["Ball", "Red ball", "red", "a"]],
    "Gestures": [["Name", "Time (s)", "Head yaw", "Notes"], ["Nod", "1", "10", "a"]],
    "Protocol": [["Field", "Value", "Notes"], ["Title", "My study", "a"]],
    "Risks": [["Risk", "For whom", "How likely", "What reduces it", "Who ends the session when", "Notes"],
              ["falls", "child", "Unlikely", "it sits", "we, at once", "a"]],
    "Parts": [["Part", "Step"], ["arm", "1"]],
}  # fmt: skip


@pytest.fixture(scope="module")
def of_every_kind(shelf: Books) -> Path:
    """A workbook with a sheet of every kind; each is changed by one test at most."""
    return shelf.file({**SHEETS, "T": [HEADER, ["", "Red ball", "map", "ROWS(parts)", "Distance", ""]]})


def test_the_sheets_of_every_kind_are_tried_here() -> None:
    assert len(SHEETS) == len(KINDS) + 1  # and a table of the user's own


@pytest.mark.slow
@pytest.mark.parametrize("sheet", SHEETS)
def test_every_kind_of_sheet_tells_the_page_how_its_headers_are_spelt(
    shelf: Books, of_every_kind: Path, sheet: str
) -> None:
    """By that alone the page knows a header row."""
    text = shelf.page.request.get(f"{shelf.url}/book/{of_every_kind.name}/sheet/{sheet}").text()
    columns = [spellings.split() for spellings in re.findall(r'data-spellings="([^"]*)"', text)]
    for header, spellings in zip(SHEETS[sheet][0], columns, strict=True):
        assert key(header) in spellings
    known = [spelling for spellings in columns for spelling in spellings]
    assert len(set(known)) == len(known)


@pytest.mark.slow
@pytest.mark.parametrize("sheet", ["Gestures", "Parts"])
def test_header_rows_are_left_out_on_other_kinds_of_sheets(shelf: Books, of_every_kind: Path, sheet: str) -> None:
    header, *_, line = SHEETS[sheet]
    grid = shelf.open(path=of_every_kind, sheet=sheet)
    before = rows(grid, sheet)
    paste(grid, f"A{len(before) + 2}", header[::-1], line[::-1])
    expect(grid.page.locator("#status")).to_have_text(f"{OURS} {BY_NAME}")
    grid.expect(f"A{len(before) + 2}", line[0])
    assert rows(grid, sheet) == [*before, line]
