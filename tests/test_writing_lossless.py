"""Edits leave everything else in an .xlsx as it was, byte for byte."""

from __future__ import annotations

import re
import shutil
import subprocess
from pathlib import Path
from xml.etree.ElementTree import canonicalize

import openpyxl
import pytest
from lossless import FEATURES, ROWS, SHEET, add_part, make, parts, repack

from rrp_sheets.workbook import read
from rrp_sheets.workbook.edits import DeleteRows, InsertRows, MoveRows, SetCell
from rrp_sheets.workbook.files import edit, read_sheets

PART = "xl/worksheets/sheet1.xml"
EDITS = [
    SetCell(SHEET, 3, 3, "distance < 0.25"),
    SetCell(SHEET, 6, 6, "=changed & new <b>"),
    SetCell(SHEET, 9, 1, "a new row"),
    MoveRows(SHEET, 5, 1, before=3),
]
COMMENTS = re.compile(r"xl/(comments|threadedComments/|drawings/vmlDrawing)")
THREADS = (
    b'<?xml version="1.0" encoding="UTF-8" standalone="yes"?>\n'
    b'<ThreadedComments xmlns="http://schemas.microsoft.com/office/spreadsheetml/2018/threadedcomments">'
    b'<threadedComment ref="C5" dT="2026-01-01T00:00:00.00" personId="{P}" id="{I}"><text>why?</text></threadedComment>'
    b"</ThreadedComments>"
)
PIVOT = (
    b'<pivotCacheDefinition xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main" refreshOnLoad="1">'
    b'<cacheSource type="worksheet"><worksheetSource ref="A1:G7" sheet="Tracking"/></cacheSource>'
    b'<cacheFields count="0"/></pivotCacheDefinition>'
)


def threaded(path: Path) -> Path:
    make(path, FEATURES["comments"])
    kind = "http://schemas.microsoft.com/office/2017/10/relationships/threadedComment"
    content = "application/vnd.ms-excel.threadedcomments+xml"
    add_part(path, "xl/threadedComments/threadedComment1.xml", THREADS, content, PART, kind)
    return path


def pivot(path: Path) -> Path:
    make(path)
    kind = "http://schemas.openxmlformats.org/officeDocument/2006/relationships/pivotCacheDefinition"
    content = "application/vnd.openxmlformats-officedocument.spreadsheetml.pivotCacheDefinition+xml"
    add_part(path, "xl/pivotCache/pivotCacheDefinition1.xml", PIVOT, content, "xl/workbook.xml", kind)
    return path


def prefixed(path: Path) -> Path:
    """Every element with a prefix, as some programs write it, with comments and CDATA between."""
    make(path)

    def rename(data: bytes) -> bytes:
        data = re.sub(rb"<(/?)(?=[a-z])", rb"<\1x:", data).replace(b"xmlns=", b"xmlns:x=")
        return data.replace(b"<x:sheetData>", b"<x:sheetData><!-- <row r='3'/> -->", 1)

    return repack(path, {PART: rename})


def alternate(path: Path) -> Path:
    """`mc:AlternateContent` beside the table, with elements that look like rows and cells."""
    make(path)
    extra = (
        b'<mc:AlternateContent xmlns:mc="http://schemas.openxmlformats.org/markup-compatibility/2006">'
        b'<mc:Choice Requires="x"><row r="3"><c r="C3"><f>A1</f></c></row></mc:Choice></mc:AlternateContent></worksheet>'
    )
    return repack(path, {PART: lambda data: data.replace(b"</worksheet>", extra)})


def office(path: Path) -> Path:
    """As Excel writes it: a calculation chain, `x14ac` attributes, a workbook that is not calculated on opening."""
    make(path, FEATURES["formulas"])
    kind = "http://schemas.openxmlformats.org/officeDocument/2006/relationships/calcChain"
    content = "application/vnd.openxmlformats-officedocument.spreadsheetml.calcChain+xml"
    chain = (
        b'<calcChain xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"><c r="H2" i="1"/></calcChain>'
    )
    add_part(path, "xl/calcChain.xml", chain, content, "xl/workbook.xml", kind)
    return repack(
        path,
        {
            "xl/workbook.xml": lambda data: data.replace(b' fullCalcOnLoad="1"', b""),
            PART: lambda data: data.replace(b"<row ", b'<row x14ac:dyDescent="0.25" ', 3).replace(
                b"<worksheet ", b'<worksheet xmlns:x14ac="http://schemas.microsoft.com/office/spreadsheetml/2009/9/ac" '
            ),
        },
    )


def strict(path: Path) -> Path:
    """Strict Open XML: other addresses of the namespaces."""
    make(path)
    old, new = b"http://schemas.openxmlformats.org/", b"http://purl.oclc.org/ooxml/"
    names = [n for n in parts(path) if n.startswith("xl/") and not n.startswith("xl/theme")]

    def rename(data: bytes) -> bytes:
        for word in (b"spreadsheetml/2006/main", b"officeDocument/2006/relationships"):
            data = data.replace(old + word, new + word.replace(b"/2006", b""))
        return data

    return repack(path, dict.fromkeys(names, rename))


def openpyxls(path: Path) -> Path:
    book = openpyxl.Workbook()
    book.active.title = SHEET
    book.active.append(["Input streams", "Connector", "Formula", "Output stream", "On", "Notes", "Mine"])
    for row in ROWS:
        book.active.append(row)
    book.create_sheet("Mine").append([1, 2])
    book.save(path)
    return path


SAMPLES = {
    **{name: (lambda path, f=feature: make(path, f)) for name, feature in FEATURES.items()},
    "threaded comments": threaded, "pivot": pivot, "prefixes": prefixed, "alternate content": alternate,
    "Excel": office, "strict": strict, "openpyxl": openpyxls,
    "constant memory": lambda path: make(path, constant_memory=True),
}  # fmt: skip


def expected() -> dict[tuple[int, int], str]:
    """The first sheet's texts after EDITS: row 5 has gone before row 3."""
    rows = {n: dict(enumerate(map(str, row), 1)) for n, row in enumerate(ROWS, 2)}
    rows[3][3], rows[6][6] = "distance < 0.25", "=changed & new <b>"
    placed = {1: {}, 2: rows[2], 3: rows[5], 4: rows[3], 5: rows[4], 6: rows[6], 7: rows[7], 9: {1: "a new row"}}
    return {(r, c): text for r, row in placed.items() for c, text in row.items() if text}


@pytest.fixture(params=SAMPLES)
def sample(request, tmp_path):
    return SAMPLES[request.param](tmp_path / f"{request.param}.xlsx")


@pytest.mark.slow
def test_all_other_parts_stay(sample):
    before = parts(sample)
    edit(sample, EDITS, expected_digest=read(sample).digest)
    after = parts(sample)
    assert [n for n in before if n in after] == list(after)
    gone = set(before) - set(after)
    assert gone <= {"xl/calcChain.xml"}
    allowed = {PART, *(n for n in before if COMMENTS.match(n))}
    if gone:
        allowed |= {"[Content_Types].xml", "xl/_rels/workbook.xml.rels"}
    if any(b"<f" in data for n, data in before.items() if n.startswith("xl/worksheets/sheet")):
        allowed.add("xl/workbook.xml")
    assert {n for n in after if after[n] != before[n]} <= allowed
    book = re.sub(rb' ?fullCalcOnLoad="1"', b"", after["xl/workbook.xml"])
    assert book == re.sub(rb' ?fullCalcOnLoad="1"', b"", before["xl/workbook.xml"])


@pytest.mark.slow
def test_the_sheet_outside_of_its_rows_stays(sample):
    def outside(data: bytes) -> str:
        text = canonicalize(data.decode(), with_comments=True)
        text = re.sub(r"<(x:)?sheetData>.*</(x:)?sheetData>", "", text, flags=re.DOTALL)
        return re.sub(r'(<(?:x:)?(?:dimension|hyperlink)[^>]* ref=)"[A-Z0-9:]+"', r"\1", text)

    before = outside(parts(sample)[PART])
    edit(sample, EDITS)
    assert outside(parts(sample)[PART]) == before


@pytest.mark.slow
def test_exactly_the_edited_cells_change(sample):
    other = read_sheets(sample)[1:]
    edit(sample, EDITS)
    after = read_sheets(sample)
    cells = {at: c.text for at, c in after[0].cells.items() if at[0] > 1 and at[1] <= 7}
    assert cells == expected()
    assert after[1:] == other


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:.*extension is not supported")
def test_openpyxl_reads_it(sample):
    if sample.stem in ("strict", "pivot"):
        return  # openpyxl reads neither strict files nor this hand-made cache
    edit(sample, EDITS)
    sheet = openpyxl.load_workbook(sample)[SHEET]
    assert [sheet["C4"].value, sheet["F6"].value, sheet["A9"].value] == [
        "distance < 0.25",
        "=changed & new <b>",
        "a new row",
    ]
    assert sheet["F6"].data_type != "f"


@pytest.mark.slow
def test_nothing_to_change_writes_nothing(sample):
    data = sample.read_bytes()
    assert not edit(sample, []).changed
    assert not edit(sample, [MoveRows(SHEET, 3, 2, before=4)]).changed
    assert sample.read_bytes() == data


def test_back_again_is_the_same_content(sample):
    """Inserting and deleting the same rows, and moving there and back, gives what there was."""
    before = read_sheets(sample)
    there = [InsertRows(SHEET, 8, 2), MoveRows(SHEET, 3, 2, before=7)]
    back = [MoveRows(SHEET, 5, 2, before=3), DeleteRows(SHEET, 8, 2)]
    edit(sample, there)
    assert read_sheets(sample)[0].cells != before[0].cells
    edit(sample, back)
    assert read_sheets(sample) == before


if shutil.which("soffice"):

    def converted(office: str, kind: str, *paths: Path) -> list[Path]:
        """Files of one folder as LibreOffice, started once, converts them."""
        folder = paths[0].parent
        command = ["soffice", office, "--headless", "--convert-to", kind]
        done = subprocess.run(
            [*command, "--outdir", str(folder / "out"), *map(str, paths)], capture_output=True, text=True
        )
        made = [folder / "out" / f"{path.stem}.{kind}" for path in paths]
        assert all(path.exists() for path in made), done.stderr
        return made

    @pytest.fixture(scope="module")
    def shown(tmp_path_factory, office):
        """The text that LibreOffice shows of each edited sample."""
        folder = tmp_path_factory.mktemp("shown")
        edited = [SAMPLES[name](folder / f"{name}.xlsx") for name in SHOWN]
        for sample in edited:
            edit(sample, EDITS)
        return {path.stem: path.read_text("utf-8") for path in converted(office, "csv", *edited)}

    SHOWN = ("plain", "comments", "formulas", "tables", "prefixes", "conditional formats")

    @pytest.mark.parametrize("name", SHOWN)
    def test_libreoffice_shows_the_new_values(name, shown):
        text = shown[name]
        rows = [line.split(",") for line in text.splitlines()]
        assert [row[0] for row in rows[:9]] == [
            "Input streams", "Red ball", "Distance", "Distance", "Near", "Double", "Far", "", "a new row",
        ]  # fmt: skip
        assert rows[3][2] == "distance < 0.25" and rows[5][5] == "=changed & new <b>"

    def test_what_libreoffice_wrote_can_be_edited(tmp_path, office):
        source = make(tmp_path / "a.xlsx", FEATURES["comments"])
        (sample,) = converted(office, "xlsx", source)
        before = parts(sample)
        edit(sample, EDITS)
        after = parts(sample)
        assert {n for n in after if after[n] != before.get(n)} <= {PART, *(n for n in before if COMMENTS.match(n))}
        cells = {at: c.text for at, c in read_sheets(sample)[0].cells.items() if at[0] > 1}
        assert cells == expected()
