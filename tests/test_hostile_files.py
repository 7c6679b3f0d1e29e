"""Files from strangers: each class of facts/xlsx is refused or read within 2 s and 300 MB, and never a traceback."""

from __future__ import annotations

import io
import json
import subprocess
import sys
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest
from busy import Span, slowness

from rrp_sheets.diagnostics import CODES
from rrp_sheets.errors import UnreadableFile
from rrp_sheets.workbook import limits, read
from rrp_sheets.workbook.files import read_sheets

NS = 'xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"'
REL = "http://schemas.openxmlformats.org/officeDocument/2006/relationships"
PKG = "http://schemas.openxmlformats.org/package/2006"
XML = '<?xml version="1.0" encoding="UTF-8" standalone="yes"?>'
HEADERS = ("Input streams", "Connector", "Formula", "Output stream")


def inline(reference: str, text: str) -> str:
    return f'<c r="{reference}" t="inlineStr"><is><t>{text}</t></is></c>'


HEADER_ROW = '<row r="1">' + "".join(inline(f"{c}1", h) for c, h in zip("ABCD", HEADERS, strict=True)) + "</row>"
ROW_2 = (
    f'<row r="2">{inline("A2", "Red ball")}{inline("B2", "map")}{inline("C2", "redBall.x")}{inline("D2", "X")}</row>'
)


def sheet(rows: str = ROW_2, before: str = "", after: str = "", header: str = HEADER_ROW) -> str:
    return f"{XML}<worksheet {NS}>{before}<sheetData>{header}{rows}</sheetData>{after}</worksheet>"


def parts(sheet_xml: str | None = None, **more: str) -> dict[str, str]:
    """The parts of the smallest honest workbook; `more` by part name with `__` for `/`."""
    return {
        "[Content_Types].xml": f'{XML}<Types xmlns="{PKG}/content-types"><Default Extension="xml" '
        'ContentType="application/xml"/></Types>',
        "_rels/.rels": f'{XML}<Relationships xmlns="{PKG}/relationships"><Relationship Id="rId1" '
        f'Type="{REL}/officeDocument" Target="xl/workbook.xml"/></Relationships>',
        "xl/workbook.xml": f'{XML}<workbook {NS} xmlns:r="{REL}"><sheets><sheet name="Tracking" sheetId="1" '
        'r:id="rId1"/></sheets></workbook>',
        "xl/_rels/workbook.xml.rels": f'{XML}<Relationships xmlns="{PKG}/relationships"><Relationship Id="rId1" '
        f'Type="{REL}/worksheet" Target="worksheets/sheet1.xml"/><Relationship Id="rId2" Type="{REL}/sharedStrings" '
        'Target="sharedStrings.xml"/></Relationships>',
        "xl/sharedStrings.xml": f"{XML}<sst {NS}/>",
        "xl/worksheets/sheet1.xml": sheet() if sheet_xml is None else sheet_xml,
        **more,
    }


def zipped(contents: dict[str, str], level: int = 9) -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=level) as z:
        for name, text in contents.items():
            z.writestr(name, text)
    return buffer.getvalue()


def zipped_long(piece: bytes, times: int, name: str = "xl/worksheets/sheet1.xml") -> bytes:
    """As `zipped`, with a text of equal pieces in the sheet's second row: one is in memory at a time."""
    before, after = sheet(inline("A2", "|")).encode().split(b"|")
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED, compresslevel=1) as z:
        for other, text in parts().items():
            if other != name:
                z.writestr(other, text)
        with z.open(name, "w") as part:
            part.write(before)
            for _ in range(times):
                part.write(piece)
            part.write(after)
    return buffer.getvalue()


def relation(kind: str, target: str, mode: str = "") -> str:
    return (
        f'{XML}<Relationships xmlns="{PKG}/relationships"><Relationship Id="rId9" Type="{REL}/{kind}" '
        f'Target="{target}"{mode}/></Relationships>'
    )


def million_cells() -> bytes:
    import random

    numbers = random.Random(7).choices(range(10_000), k=900_000)  # not alike, so that the compression is honest
    cells = "".join(f"<c><v>{n}</v></c>" for n in numbers)
    rows = f'<row r="2">{cells}</row>'
    return zipped(parts(sheet(rows)), level=1)


def many_strings() -> bytes:
    import random

    pairs = [f"<si><t>{a}{b}</t></si>" for a in "abcdefgh" for b in "abcdefgh"]
    texts = "".join(random.Random(7).choices(pairs, k=400_000))  # equal ones would be caught by the compression alone
    rows = '<row r="2"><c r="A2" t="s"><v>399999</v></c></row>'
    return zipped(parts(sheet(rows), **{"xl/sharedStrings.xml": f"{XML}<sst {NS}>{texts}</sst>"}), level=1)


def overlapping_names() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as z, pytest.warns(UserWarning, match="Duplicate name"):
        for name, text in [*parts().items(), ("xl/worksheets/sheet1.xml", sheet())]:
            z.writestr(name, text)
    return buffer.getvalue()


def encrypted_zip() -> bytes:
    data = bytearray(zipped(parts()))
    for at in range(len(data) - 4):
        if data[at : at + 4] == b"PK\x01\x02":
            data[at + 8] |= 1
    return bytes(data)


def broken_middle() -> bytes:
    data = bytearray(zipped(parts()))
    at = data.rindex(b"<c r" if b"<c r" in data else b"PK\x01\x02", 0, data.index(b"PK\x01\x02") + 4)
    data[at - 60 : at - 20] = b"\0" * 40  # within the last part, the sheet
    return bytes(data)


def lying_size() -> bytes:
    data = bytearray(zipped(parts()))
    at = data.index(b"PK\x01\x02")
    data[at + 24 : at + 28] = (10).to_bytes(4, "little")
    return bytes(data)


DATE_CELLS = "".join('<c t="d"><v>2026-01-02</v></c>' for _ in range(4))
ERROR_CELLS = '<c/><c t="e"><v>#REF!</v></c>' * 3
QUOTES = "".join("\\“&quot;" if i * i % 101 % 3 else f"“&quot;{i}" for i in range(9_000))
PREFIXES = "_xlfn.SINGLE(" * 2_500
OLE = bytes.fromhex("d0cf11e0a1b11ae1") + bytes(600)
SPARE = {"xl/drawings/drawing1.xml": f'{XML}<a xmlns="x"/>'}
REFUSED: dict[str, tuple[str, Callable[[], bytes], str]] = {
    "empty": ("x.xlsx", lambda: b"", "FILE015"),
    "not a zip": ("x.xlsx", lambda: b"hello", "FILE002"),
    "plain text": ("x.txt", lambda: b"Input streams,Connector", "FILE002"),
    "truncated": ("x.xlsx", lambda: zipped(parts())[:-40], "FILE008"),
    "beginning only": ("x.xlsx", lambda: b"PK\x03\x04" + bytes(50), "FILE008"),
    "zip of something else": ("x.xlsx", lambda: zipped({"word/document.xml": "<a/>"}), "FILE002"),
    "old Excel": ("x.xls", lambda: OLE, "FILE003"),
    "encrypted": ("x.xlsx", lambda: OLE + "EncryptedPackage".encode("utf-16-le"), "FILE005"),
    "encrypted zip": ("x.xlsx", encrypted_zip, "FILE005"),
    "macros by name": ("x.xlsm", lambda: zipped(parts()), "FILE004"),
    "macros": ("x.xlsx", lambda: zipped(parts(**{"xl/vbaProject.bin": "x"})), "FILE004"),
    "macro content type": (
        "x.xlsx",
        lambda: zipped({**parts(), "[Content_Types].xml": "<Types a='application/vnd.ms-excel.sheet.macroEnabled'/>"}),
        "FILE004",
    ),
    "external link": ("x.xlsx", lambda: zipped(parts(**{"xl/externalLinks/externalLink1.xml": "<a/>"})), "FILE010"),
    "external link by relation": (
        "x.xlsx",
        lambda: zipped(parts(**{"xl/_rels/a.rels": relation("externalLink", "http://a.example/x")})),
        "FILE010",
    ),
    "linked picture": (
        "x.xlsx",
        lambda: zipped(parts(**{"xl/_rels/a.rels": relation("image", "http://a/x.png", ' TargetMode="External"')})),
        "FILE010",
    ),
    "data connection": ("x.xlsx", lambda: zipped(parts(**{"xl/connections.xml": "<a/>"})), "FILE010"),
    "embedded object": ("x.xlsx", lambda: zipped(parts(**{"xl/embeddings/oleObject1.bin": "x"})), "FILE011"),
    "ActiveX": ("x.xlsx", lambda: zipped(parts(**{"xl/activeX/activeX1.xml": "<a/>"})), "FILE011"),
    "too large": ("x.xlsx", lambda: b"PK" + bytes(5_000_001), "FILE006"),
    "too many parts": ("x.xlsx", lambda: zipped(parts(**{f"xl/media/{i}": "x" for i in range(200)})), "FILE007"),
    "300 MB text": ("x.xlsx", lambda: zipped_long(b"x" * 1_000_000, 300), "FILE007"),
    "19 MB text": (
        "x.xlsx",
        lambda: zipped(parts(sheet('<row r="2">' + inline("A2", "0123456789abcdef" * 1_200_000) + "</row>")), level=1),
        "FILE007",
    ),
    "one enormous tag": (
        "x.xlsx",
        lambda: zipped(parts("<worksheet " + " ".join(f"a{i}='{i * i}'" for i in range(200_000)) + "/>"), level=1),
        "FILE007",
    ),
    "deep": ("x.xlsx", lambda: zipped(parts(sheet(before="<a>" * 30_000)), level=1), "FILE007"),
    "a million equal cells": (
        "x.xlsx",
        lambda: zipped(parts(sheet('<row r="2">' + "<c><v>1</v></c>" * 1_000_000 + "</row>"))),
        "FILE007",
    ),
    "a million cells": ("x.xlsx", million_cells, "FILE013"),
    "400,000 texts": ("x.xlsx", many_strings, "FILE007"),
    "merge over the sheet": (
        "x.xlsx",
        lambda: zipped(parts(sheet(after='<mergeCells><mergeCell ref="A1:XFD1048576"/></mergeCells>'))),
        "FILE013",
    ),
    "10,001 rows": (
        "x.xlsx",
        lambda: zipped(parts(sheet("".join(f'<row r="{r}">{inline(f"A{r}", "x")}</row>' for r in range(2, 10_003))))),
        "FILE013",
    ),
    "absolute path": ("x.xlsx", lambda: zipped(parts(**{"/etc/passwd": "x"})), "FILE009"),
    "path above": ("x.xlsx", lambda: zipped(parts(**{"xl/../../x": "x"})), "FILE009"),
    "Windows path": ("x.xlsx", lambda: zipped(parts(**{"C:\\x": "x"})), "FILE009"),
    "two parts of one name": ("x.xlsx", overlapping_names, "FILE009"),
    "a part without a name": ("x.xlsx", lambda: zipped(parts(**{"evil": "x"})).replace(b"evil", b"\0vil"), "FILE009"),
    "names that differ in capitals": ("x.xlsx", lambda: zipped(parts(**{"xl/Workbook.xml": "x"})), "FILE009"),
    "document type": (
        "x.xlsx",
        lambda: zipped(parts(sheet().replace("<worksheet", '<!DOCTYPE a [<!ENTITY b "c">]><worksheet'))),
        "FILE009",
    ),
    "document type in UTF-16": (
        "x.xlsx",
        lambda: zipped({**parts(), "xl/x.xml": "<!DOCTYPE a><a/>".encode("utf-16").decode("latin-1")}),
        "FILE009",
    ),
    "odd encoding": ("x.xlsx", lambda: zipped(parts('<?xml version="1.0" encoding="utf-7"?><a/>')), "FILE009"),
    "broken XML": ("x.xlsx", lambda: zipped(parts(sheet().replace("</row>", "", 1))), "FILE008"),
    "broken in the middle": ("x.xlsx", broken_middle, "FILE008"),
    "a part longer than it says": ("x.xlsx", lying_size, "FILE008"),
    "sheet part missing": (
        "x.xlsx",
        lambda: zipped({n: t for n, t in parts().items() if "sheet1" not in n}),
        "FILE008",
    ),
    "text missing": (
        "x.xlsx",
        lambda: zipped(parts(sheet('<row r="2"><c r="A2" t="s"><v>5</v></c></row>'))),
        "FILE008",
    ),
    "no sheets": ("x.xlsx", lambda: zipped({**parts(), "xl/workbook.xml": f"<workbook {NS}/>"}), "FILE008"),
    "61 sheets": (
        "x.xlsx",
        lambda: zipped(
            {
                **parts(),
                "xl/workbook.xml": f'<workbook {NS} xmlns:r="{REL}"><sheets>'
                + "".join(f'<sheet name="S{i}" sheetId="{i}" r:id="rId1"/>' for i in range(61))
                + "</sheets></workbook>",
            }
        ),
        "FILE012",
    ),
    "binary CSV": ("x.csv", lambda: b"a\0b", "FILE014"),
    "undecodable CSV": ("x.csv", lambda: b"Gr\x81\x8d\xfc\xdfe,b", "FILE014"),
    "UTF-16 without end": ("x.csv", lambda: b"\xff\xfea", "FILE014"),
    "large CSV": ("x.csv", lambda: b"a,b\n" * 1_300_000, "FILE006"),
    "large Markdown": ("x.md", lambda: b"| a |\n" * 900_000, "FILE006"),
    "endless CSV cell": ("x.csv", lambda: b'"' + b"x" * 200_000, "FILE008"),
    "a million names": (
        "x.xlsx",
        lambda: zipped(
            parts(sheet("".join(f'<row r="{r}">{inline(f"A{r}", f"a{r}," * 90)}</row>' for r in range(2, 10_000)))), 1
        ),
        "FILE013",
    ),
    "Markdown without table": ("x.md", lambda: b"# Hello\n\nworld", "FILE017"),
    "empty Markdown": ("x.md", lambda: b"", "FILE015"),
    "long CSV": ("x.csv", lambda: (",".join(HEADERS) + "\n").encode() + b"a,b,c,d\n" * 10_001, "FILE013"),
    "short cells in Markdown": ("x.md", lambda: b"## A\n" + b"|" * 4_900_000, "FILE007"),
}
READ: dict[str, Callable[[], bytes]] = {
    "honest": lambda: zipped(parts()),
    "lying dimension": lambda: zipped(parts(sheet(before='<dimension ref="A1:XFD1048576"/>'))),
    "formatted cell at the very end": lambda: zipped(
        parts(sheet(ROW_2 + '<row r="1048576"><c r="XFD1048576" s="0"/></row>'))
    ),
    "filled cell at the very end": lambda: zipped(
        parts(sheet(ROW_2 + f'<row r="1048576">{inline("XFD1048576", "x")}</row>'))
    ),
    "hyperlink over the sheet": lambda: zipped(
        parts(
            sheet(after=f'<hyperlinks><hyperlink xmlns:r="{REL}" ref="A1:XFD1048576" r:id="rId9"/></hyperlinks>'),
            **{
                "xl/worksheets/_rels/sheet1.xml.rels": relation(
                    "hyperlink", "https://a.example/", ' TargetMode="External"'
                )
            },
        )
    ),
    "validation over the sheet": lambda: zipped(
        parts(sheet(after='<dataValidations><dataValidation sqref="A1:XFD1048576"/></dataValidations>'))
    ),
    "no references": lambda: zipped(parts(sheet(ROW_2.replace(' r="2"', "")))),
    "nonsense references": lambda: zipped(parts(sheet(ROW_2 + '<row r="x"><c r="ZZZZ9"><v>1e999</v></c></row>'))),
    "a date in every cell": lambda: zipped(
        parts(sheet(ROW_2 + "".join(f'<row r="{r}">{DATE_CELLS}</row>' for r in range(3, 10_000))))
    ),
    "an error in every cell": lambda: zipped(
        parts(sheet(ROW_2 + "".join(f'<row r="{r}">{ERROR_CELLS}</row>' for r in range(3, 10_000))))
    ),
    "names in every cell": lambda: zipped(
        parts(sheet(ROW_2 + "".join(f'<row r="{r}">{inline(f"A{r}", f"a{r}," * 48)}</row>' for r in range(3, 9_000)))),
        1,
    ),
    "quotes in every formula": lambda: zipped(
        parts(sheet(ROW_2 + "".join(f'<row r="{r}">{inline(f"C{r}", QUOTES)}</row>' for r in range(3, 90)))), 1
    ),
    "prefixes in every formula": lambda: zipped(
        parts(sheet(ROW_2 + "".join(f'<row r="{r}"><c r="C{r}"><f>{PREFIXES}</f></c></row>' for r in range(3, 90)))), 1
    ),
    "nonsense numbers": lambda: zipped(
        parts(sheet(ROW_2 + '<row r="3"><c r="F3"><v>nan</v></c><c r="G3" s="99"><v>1e400</v></c></row>'))
    ),
}


@pytest.mark.parametrize("case", REFUSED)
def test_refused(case: str, tmp_path: Path, measured: Callable[[Path], dict[str, object]]) -> None:
    name, make, code = REFUSED[case]
    path = tmp_path / name
    path.write_bytes(make())
    span, result = Span(), measured(path)
    assert result["outcome"] == code, result
    assert result["seconds"] < 2 or result["seconds"] < 2 * span.crowded() * slowness(), result
    assert result["megabytes"] < 300, result


@pytest.mark.parametrize(
    "case", [pytest.param(case, marks=[pytest.mark.slow] * case.startswith(("a date", "names"))) for case in READ]
)
def test_read_all_the_same(case: str, tmp_path: Path, measured: Callable[[Path], dict[str, object]]) -> None:
    path = tmp_path / "x.xlsx"
    path.write_bytes(READ[case]())
    span, result = Span(), measured(path)
    assert result["outcome"] == "read", result
    assert result["rows"] >= 1, result
    assert result["seconds"] < 2 or result["seconds"] < 2 * span.crowded() * slowness(), result
    assert result["megabytes"] < 300, result


WORKER = """
import json, os, resource, sys, time
from rrp_sheets.workbook import read
from rrp_sheets.errors import UnreadableFile
import defusedxml.expatreader, openpyxl.styles.numbers
for line in sys.stdin:
    child = os.fork()   # memory is measured per file
    if child:
        os.waitpid(child, 0)
        continue
    start, rows = time.process_time(), 0
    try:
        workbook = read(json.loads(line)).workbook
        outcome, rows = "read", sum(len(b.rows) for b in workbook.behaviours)
    except UnreadableFile as error:
        outcome = error.code
        assert error.message and error.remedy and "{" not in str(error), str(error)
    except BaseException as error:
        outcome = repr(error)
    print(json.dumps({"outcome": outcome, "rows": rows, "seconds": time.process_time() - start,
                      "megabytes": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024}), flush=True)
    os._exit(0)
"""


@pytest.fixture(scope="module")
def measured():  # type: ignore[no-untyped-def]
    """Read a file in a process of its own: outcome, seconds and peak memory."""
    with subprocess.Popen(
        [sys.executable, "-c", WORKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
        cwd=Path(__file__).parent.parent,
    ) as worker:  # fmt: skip

        def measure(path: Path) -> dict[str, object]:
            assert worker.stdin and worker.stdout
            worker.stdin.write(json.dumps(str(path)) + "\n")
            worker.stdin.flush()
            return json.loads(worker.stdout.readline())

        yield measure
        assert worker.stdin
        worker.stdin.close()


LOOKALIKE = '<c r="A1"/><c r="B1"/></row>'


@pytest.mark.parametrize(
    ("row", "cells"),
    [
        (f'<c r="A3" s="1"/><c r="B3" t="n" />{inline("C3", "x")}', {3: "x"}),
        ('<c r="A3" s="1"/><c r="B3"/><c t="inlineStr"><is><t>x</t></is></c><c s="1"/>', {3: "x"}),
        ('<c r="A3"/><c r="B3"/><c r="" t="inlineStr"><is><t>x</t></is></c>', {3: "x"}),
        (f'<c r="A3" t="inlineStr"><is><t><![CDATA[{LOOKALIKE}]]></t></is></c><c r="B3"/>', {1: LOOKALIKE}),
        (f'<!-- {LOOKALIKE} --><c r="A3"/><c r="B3"/>{inline("C3", "x")}', {3: "x"}),
    ],
    ids=["before a cell with a place", "before one without", "before a blank one", "in a marked text", "in a comment"],
)
def test_cells_that_have_only_a_colour(row: str, cells: dict[int, str], tmp_path: Path) -> None:
    (tmp_path / "x.xlsx").write_bytes(zipped(parts(sheet(f'{ROW_2}<row r="3">{row}</row>'))))
    found = read_sheets(tmp_path / "x.xlsx")[0].cells
    assert {column: cell.typed for (at, column), cell in found.items() if at == 3} == cells


def test_cells_that_have_only_a_colour_are_counted(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    rows = "".join(f'<row r="{n}"><c r="A{n}"/><c r="B{n}" s="1"/></row>' for n in range(3, 53))
    (tmp_path / "x.xlsx").write_bytes(zipped(parts(sheet(ROW_2 + rows))))
    monkeypatch.setattr(limits, "CELL_ELEMENTS", 108)  # with those of the header and of row 2
    assert len(read_sheets(tmp_path / "x.xlsx")[0].cells) == 8
    monkeypatch.setattr(limits, "CELL_ELEMENTS", 107)
    with pytest.raises(UnreadableFile, match="more than 107 cells"):
        read_sheets(tmp_path / "x.xlsx")


def test_missing_file(tmp_path: Path) -> None:
    with pytest.raises(UnreadableFile) as error:
        read(tmp_path / "no {such} file.xlsx")
    assert error.value.code == "FILE001"
    assert "no {such} file.xlsx" in error.value.message


def test_folder_without_sheets(tmp_path: Path) -> None:
    with pytest.raises(UnreadableFile) as error:
        read(tmp_path)
    assert error.value.code == "FILE017"


def test_folder_named_as_a_workbook(tmp_path: Path) -> None:
    (tmp_path / "x.xlsx").mkdir()
    with pytest.raises(UnreadableFile) as error:
        read(tmp_path / "x.xlsx")
    assert error.value.code == "FILE017"


def test_huge_folder(tmp_path: Path) -> None:
    for i in range(4):
        (tmp_path / f"{i}.csv").write_bytes(b"a,b\n" * 400_000)
    with pytest.raises(UnreadableFile) as error:
        read(tmp_path)
    assert error.value.code == "FILE006"


def test_every_file_code_is_tested() -> None:
    tested = {code for _, _, code in REFUSED.values()} | {"FILE001", "FILE016", "FILE017"}
    tested |= {"FILE018", "FILE019", "FILE020", "FILE021"}  # in test_worker, test_bundle_refused, test_writing_text
    assert {c for c in CODES if c.startswith("FILE")} == tested
