"""Mistakes of beginners: one finding, at its cell, with a remedy that mends it (the table is in mistakes.md)."""

from __future__ import annotations

import datetime as dt
import re
from collections.abc import Iterator
from dataclasses import replace
from functools import cache
from pathlib import Path

import openpyxl
import pytest
from play import check
from test_workbooks import NAMES, THERAPY

from rrp_sheets import api
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.report import Delete, Fix, Insert, Put
from rrp_sheets.model.workbook import column_letters

HERE = Path(__file__).parent
SOURCES = HERE.parent / "workbooks" / "source"
CELL = re.compile(r"(.+)!([A-Z]+)(\d+)")
Cells = dict[str, str]
"""A workbook as its cells' texts by address (`Tracking!C2`)."""


def split(line: str) -> list[str]:
    return [cell.strip() for cell in line.strip().strip("|").split("|")]


def cells_of(markdown: str) -> Cells:
    """The cells of a Markdown workbook."""
    cells: Cells = {}
    sheet, row = "", 0
    for line in markdown.split("\n"):
        if line.startswith("## "):
            sheet, row = line[3:].strip(), 0
        elif line.startswith("|") and not re.fullmatch(r"[|\s-]+", line):
            row += 1
            cells |= {f"{sheet}!{column_letters(c)}{row}": text for c, text in enumerate(split(line), 1)}
    return cells


def markdown_of(cells: Cells) -> str:
    """The Markdown workbook of some cells."""
    sheets: dict[str, dict[tuple[int, int], str]] = {}
    for address, text in cells.items():
        sheet, letters, row = CELL.fullmatch(address).groups()
        column = sum((ord(c) - 64) * 26**i for i, c in enumerate(reversed(letters)))
        sheets.setdefault(sheet, {})[int(row), column] = text
    lines = []
    for sheet, grid in sheets.items():
        right, bottom = max(c for _, c in grid), max(r for r, _ in grid)
        lines.append(f"\n## {sheet}")
        for r in range(1, bottom + 1):
            lines.append(f"| {' | '.join(grid.get((r, c), '') for c in range(1, right + 1))} |")
            if r == 1:
                lines.append("|" + "---|" * right)
    return "\n".join(lines) + "\n"


def mistakes() -> list[tuple[str, ...]]:
    text = (HERE / "mistakes.md").read_text(encoding="utf-8").partition("\n# quiz\n")[0]
    return [tuple(split(line)) for line in text.split("\n") if re.match(r"\| (?!Workbook )\w", line)]


@cache
def base(name: str) -> Cells:
    if name == "quiz":
        return cells_of((HERE / "mistakes.md").read_text(encoding="utf-8").partition("\n# quiz\n")[2])
    return cells_of((SOURCES / f"{name}.md").read_text(encoding="utf-8"))


def found(cells: Cells) -> list[tuple[str, str, str]]:
    findings = list(check(markdown_of(cells)).report)
    for finding in findings:
        assert disagreeing(finding) == [], finding
    return [(d.code, str(d.address or ""), d.remedy) for d in findings]


TIME = re.compile(r"(?<![\w.])(\d+(?:\.\d+)?) ?(ms|s|min|seconds?|minutes?)\b")
NUMBER = re.compile(r"(?<![\w.])\d+(?:\.\d+)?(?![\w.]*\w)")


def disagreeing(finding: Diagnostic) -> list[str]:
    """The times of its words that none of its fixes writes, and the numbers of a button that its own fix does not write."""
    wrong = []
    texts = {fix.title: " ".join(_written(fix)) for fix in finding.fixes}
    for title, text in texts.items():
        wrong += [n for n in NUMBER.findall(title) if n not in text]
    proposed = {_time(*t) for text in texts.values() for t in TIME.findall(text)}
    named = {_time(*t) for t in TIME.findall(finding.remedy)}
    return [*wrong, *(sorted(named) if proposed and named and not proposed & named else [])]


def _written(fix: Fix) -> Iterator[str]:
    for edit in fix.edits:
        if isinstance(edit, Insert):
            yield from (text for _, text in edit.cells)
        else:
            yield "" if isinstance(edit, Delete) else edit.text if isinstance(edit, Put) else edit.new


def _time(number: str, unit: str) -> str:
    return f"{float(number):g} {'min' if unit[:3] == 'min' else unit if unit == 'ms' else 's'}"


# What following a remedy looks like when it asks for something to be done, and does not say what to type.
DOES = {
    "delete": lambda typed, mended: not any(mended),
    "blank": lambda typed, mended: not any(mended),
    "commas": lambda typed, mended: "," in mended[0] and "," not in typed[0],
    "comma": lambda typed, mended: "," in mended[0] and "," not in typed[0],
    "once": lambda typed, mended: len(set(mended[0].split(", "))) == len(mended[0].split(", ")),
    "another name": lambda typed, mended: mended[0] not in typed,
    "another input": lambda typed, mended: mended[0] not in typed,
    "remove rounds": lambda typed, mended: typed[0].replace(", Rounds", "") == mended[0],
    "rename": lambda typed, mended: mended[0] not in typed,
    "letters": lambda typed, mended: mended[0].isalpha(),
    "closing bracket": lambda typed, mended: mended[0].count(")") == typed[0].count(")") + 1,
    "quote": lambda typed, mended: mended[0] == typed[0] + '"',
    "what belongs there": lambda typed, mended: mended[0].startswith(typed[0]),
    "remove “print done”": lambda typed, mended: "done" not in mended[0],
    "quotation marks": lambda typed, mended: mended[0].count('"') == 2,
    "delete this word": lambda typed, mended: typed[-1].startswith(mended[0]),
    "leave out": lambda typed, mended: typed[-1].startswith(mended[0]),
    "leave the unit out": lambda typed, mended: typed[0].startswith(mended[0]),
    "choose one": lambda typed, mended: bool(mended[0]),
    "fill in the column": lambda typed, mended: bool(mended[0]),
    "formula": lambda typed, mended: bool(mended[0]),
    "name": lambda typed, mended: bool(mended[0]),
    "inputs": lambda typed, mended: bool(mended[0]),
    "the column expect": lambda typed, mended: mended == ["", typed[0]],
    "an output stream": lambda typed, mended: bool(mended[0]),
    "exclude each other": lambda typed, mended: mended[0] != typed[0],
    "two rows": lambda typed, mended: len(mended) > 3,
    "devices": lambda typed, mended: bool(mended[0]),
    "add this value to the sensor": lambda typed, mended: typed[0] in mended[0],
    "the program proposes": lambda typed, mended: bool(mended[0]),
    "blank cell": lambda typed, mended: bool(mended[0]),
    "these fields": lambda typed, mended: bool(mended[0]),  # or nobody takes part
    "write the text in english": lambda typed, mended: mended[0].isascii() and not typed[0].isascii(),
    "ladder": lambda typed, mended: mended[0] == typed[0].replace(",", "."),
    "within the range": lambda typed, mended: abs(float(mended[0])) < 2.09 < float(typed[0]),
    "not use the others": lambda typed, mended: "praise(" not in mended[0],
}


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted({m[0] for m in mistakes()}))
def test_the_workbooks_are_in_order(name):
    assert found(base(name)) == []


@pytest.mark.slow
@pytest.mark.parametrize("mistake", mistakes(), ids=lambda m: f"{m[0]} {m[1]} {m[2]} {m[3]}"[:90])
def test_one_mistake_one_finding_and_a_remedy_that_mends_it(mistake):
    name, where, text, finding, says, mended = mistake
    typed = [part.strip() for part in text.split("<br>")]
    wrong = {**base(name), **dict(zip(where.split("<br>"), typed, strict=True))}
    code, _, address = finding.partition(" ")
    told = found(wrong)
    assert [d[:2] for d in told] == [(code, address)]
    remedy = told[0][2]
    assert says.casefold() in remedy.casefold(), remedy
    fix = {cell.strip(): now.strip() for cell, _, now in (part.partition("=") for part in mended.split("<br>"))}
    follows = DOES.get(says.casefold())
    assert follows(typed, list(fix.values())) if follows else any(says in now for now in fix.values())
    assert found({**wrong, **fix}) == []


def test_there_are_enough_and_no_mistake_stands_there_twice():
    assert len(mistakes()) >= 60 and len({m[:3] for m in mistakes()}) == len(mistakes())


FINE = [
    ("Tracking!A3", "DISTANCE"),
    ("Tracking!A2", "red_ball"),
    ("Tracking!A2", "ＲｅｄＢａｌｌ"),
    ("Tracking!A2", "'Red ball"),
    ("Tracking!B3", "FILTER"),
    ("Tracking!B4", " Subscribe "),
    ("Tracking!C3", "=distance >= 0.8"),
    ("Tracking!C3", "Distance ≥ 0.8"),
    ("Tracking!C3", "distance >= .8"),
    ("Tracking!C2", "value.distance"),
    ("Tracking!C2", "red_ball.Distance"),
    ("Tracking!C2", "redBall[“distance”]"),
    ("Tracking!D4", "HeadTracker"),
    ("Tracking!D4", "head tracker"),
    ("Tracking!A1", "inputs"),
    ("Tracking!E1", "Comment"),
    ("Tracking!E1", "My own column"),
    ("Protocol!B8", "NAO"),
    ("Protocol!B9", "30 Hz"),
    ("Scene!A2", "0.5 s"),
    ("Scene!C2", "appear"),
    ("Scene!B3", "red ball"),
]


@pytest.mark.slow
@pytest.mark.parametrize(("cell", "text"), FINE)
def test_what_is_typed_differently_but_is_fine(cell, text):
    book = base("simple-tracking")
    assert cell in book
    assert found({**book, cell: text}) == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "cell", "excel", "again"),
    [
        ("simple-tracking", "Tracking!C3", dt.datetime(2026, 8, 1), "distance >= 0.8"),
        ("simple-tracking", "Tracking!D3", dt.date(2026, 5, 1), "Far ball"),
        ("simple-tracking", "Tracking!A4", dt.date(2026, 5, 1), "Far ball"),
        ("greeter", "Greet!C2", dt.time(10, 0), "10 s"),
        ("greeter", "Devices!C2", dt.date(2026, 5, 1), "Hello"),
        ("simple-tracking", "Scene!A2", dt.time(0, 30), "0.5"),
        ("simple-tracking", "Scene!D2", dt.date(2026, 3, 1), "at 1, 0, 0.4"),
    ],
)
def test_what_excel_turned_into_a_date(name, cell, excel, again, tmp_path):
    book = openpyxl.load_workbook(SOURCES.parent / f"{name}.xlsx")
    sheet, _, at = cell.partition("!")
    for value, expected in ((excel, [("SHEET006", cell)]), (again, [])):
        book[sheet][at] = value
        book[sheet][at].number_format = "@" if value is again else "yyyy-mm-dd"
        book.save(tmp_path / "x.xlsx")
        assert [(d.code, str(d.address)) for d in api.check(tmp_path / "x.xlsx").report] == expected


# ---- every cell of the workbooks, spoilt in several ways

BOOKS = tuple(sorted(set(NAMES)))
SPOILT = {
    "deleted": lambda text: "",
    "cut": lambda text: text[:-1],
    "a letter more": lambda text: text + "x",
    "a word more": lambda text: text + " foo",
    "two letters exchanged": lambda text: text[:1] + text[2:3] + text[1:2] + text[3:],
    "comma": lambda text: re.sub(r"(\d)\.(\d)", r"\1,\2", text),
    "a quote less": lambda text: text.replace('"', "", 1),
}
HARMLESS = {
    "wide": lambda text: "".join(chr(ord(c) + 0xFEE0) if c.isascii() and c.isalpha() else c for c in text),
    "spaces": lambda text: f"  {text}\u00a0 ",
}
EVERY = 23  # of all cells and ways; together about 300 workbooks


@cache
def spoilt(*, harmless: bool = False, books: tuple[str, ...] = BOOKS) -> list[tuple[str, str, str, str]]:
    ways, changed = HARMLESS if harmless else SPOILT, []
    for name in books:
        for cell, text in base(name).items():
            changed += [(name, cell, way, spoil(text)) for way, spoil in ways.items() if text and spoil(text) != text]
    return changed[::EVERY]


@cache
def own(name: str) -> set[tuple[str, str]]:
    """The findings of a workbook as it is."""
    return {d[:2] for d in found(base(name))}


def followed(name: str, cell: str, text: str) -> list[tuple[str, str]]:
    """The findings of a changed workbook besides its own."""
    return [d[:2] for d in found({**base(name), cell: text}) if d[:2] not in own(name)]


@pytest.mark.parametrize("name", BOOKS)
def test_a_spoilt_cell_gives_one_finding_at_most(name):
    for book, cell, _, text in spoilt():
        if book == name and (cell, text) != ("Devices!C1", ""):  # every device that needs the column misses it
            told = followed(book, cell, text)
            assert len(told) <= 1, (cell, text, told)


@pytest.mark.soak
@pytest.mark.parametrize("name", THERAPY)
def test_a_spoilt_cell_of_a_larger_workbook_is_told_with_remedies(name):
    """There one cell of a table may be wrong for several rows, and a formula may have several unknown names: each is told."""
    for _, cell, _, text in spoilt(books=(name,)):
        told = [d for d in found({**base(name), cell: text}) if d[1]]
        assert len(set(told)) == len(told) and all(d[2] for d in told), (cell, text)


@pytest.mark.slow
@pytest.mark.parametrize("name", BOOKS)
def test_other_spellings_of_a_cell_are_no_mistake(name):
    for book, cell, _, text in spoilt(harmless=True):
        if book == name and '"' not in text:  # within a text letters are letters
            assert followed(book, cell, text) == []


def test_words_and_buttons_of_every_finding_with_a_proposed_time_agree():
    flood = {"Tracking!A7": "Red ball", "Tracking!B7": "subscribe", "Tracking!C7": '"A ball!"', "Tracking!D7": "Say"}
    (finding,) = check(markdown_of({**base("simple-tracking"), **flood})).report
    assert "such as 10 s," in finding.remedy and finding.fixes[0].title.endswith("once in 10 s at most (throttle)")
    assert disagreeing(finding) == []
    assert disagreeing(replace(finding, details={**finding.details, "period": "3 s"})) == ["3 s"]
    button = replace(finding.fixes[0], title="Let it speak once in 30 seconds")
    assert disagreeing(replace(finding, fixes=(button,))) == ["30"]
