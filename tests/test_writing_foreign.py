"""Any edits of workbooks of other programs: untouched parts stay byte for byte, touched ones are C14N-equal outside."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from examples import example_count
from hypothesis import given, settings
from hypothesis import strategies as st
from lossless import SHEET, edited, make, parts, repack
from lxml import etree
from test_writing_lossless import COMMENTS, PART, SAMPLES

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.edits import BringSheet, DeleteRows, DeleteSheet, InsertRows, MoveRows, RenameSheet, SetCell
from rrp_sheets.workbook.files import edit, read_sheets

ODD = b"""<?xml version='1.0' encoding='utf-8' standalone="no"?>
<?app keep this?><!-- before --><worksheet xmlns="http://schemas.openxmlformats.org/spreadsheetml/2006/main"
  xmlns:mc="http://schemas.openxmlformats.org/markup-compatibility/2006" mc:Ignorable="x14ac xr" xmlns:unused="urn:u"
  xmlns:x14ac="http://schemas.microsoft.com/office/spreadsheetml/2009/9/ac" xmlns:xr="urn:revision" xr:uid='{"1"}'>
 <mc:AlternateContent><mc:Choice Requires="x14ac"><row r="2"/></mc:Choice><mc:Fallback/></mc:AlternateContent>
 <sheetFormatPr x14ac:dyDescent="0.25" defaultRowHeight='15'></sheetFormatPr>
 <sheetData>
  <!-- rows: <row r="9"> --><?app rows?>
  <row r="1" x14ac:dyDescent="0.3"><c t="inlineStr" r="A1"><is><t>Input streams</t></is></c>
   <c r="B1" t="inlineStr"><is><t>Connector</t></is></c><c r="C1" t="inlineStr"><is><t>Formula</t></is></c>
   <c r="D1" t="inlineStr"><is><t>Output stream</t></is></c></row>
  <row r="2" xr:uid="{2}" ht="20" customHeight="1"><c r="A2" t="inlineStr"><is><t xml:space="preserve"> Red ball </t></is>
   </c><!-- here --><c r="C2" t="inlineStr"><is><r><rPr><b/></rPr><t><![CDATA[a < b & c]]></t></r></is></c></row>
  <row><c><v>1</v></c><c t="str"><v>two&#13;&#x9;</v></c></row>
  <?app between?>
  <row r="5" spans="1:7"><c r="C5"><v>3</v><extLst><ext uri="{x}"><unused:a unused:b="&lt;&quot;"/></ext></extLst></c></row>
 </sheetData>
 <pageMargins left="0.7" right="0.7" top="0.75" bottom="0.75" header="0.3" footer="0.3"/>
 <extLst><ext uri="{x}" xmlns:x14="http://schemas.microsoft.com/office/spreadsheetml/2009/9/main">
  <x14:conditionalFormattings> <![CDATA[]]></x14:conditionalFormattings></ext></extLst>
</worksheet><!-- after --><?app end?>
"""


def odd(path: Path) -> Path:
    return repack(make(path), {PART: ODD})


def long(path: Path) -> Path:
    """More rows than are parsed at once."""

    def more(data: bytes) -> bytes:
        rows = "".join(f'<row r="{n}"><c r="A{n}" t="str"><v>{n}</v></c></row>\n' for n in range(8, 900))
        return data.replace(b"</sheetData>", f"{rows}</sheetData>".encode())

    return repack(make(path), {PART: more})


def nameless(path: Path) -> Path:
    """Rows and cells that only count, among them some that say their numbers."""
    path = long(path)
    return repack(path, {PART: lambda data: re.sub(rb' r="[A-Z]*(?!(?:2|700)")[0-9]+"', b"", data)})


ALL: dict[str, Callable[[Path], Path]] = {**SAMPLES, "odd": odd, "long": long, "nameless": nameless}


@cache
def sample(name: str) -> bytes:
    with TemporaryDirectory() as folder:
        return ALL[name](Path(folder) / f"{name}.xlsx").read_bytes()


def canonical(element: etree._Element) -> bytes:
    return etree.tostring(element, method="c14n", with_tail=False)


def rows(sheet: bytes) -> dict[int, bytes]:
    """The rows in their canonical form by number, without numbers and formulas, which follow the rows."""
    found, number = {}, 0
    for row in etree.fromstring(sheet).find("{*}sheetData").iterchildren("{*}row"):
        before, number = number, int(row.get("r", number + 1))
        assert number > before
        for e in row.iter("{*}row", "{*}c", "{*}f"):
            e.attrib.pop("r", None)
            if etree.QName(e).localname == "f":
                e.text = ""
        found[number] = canonical(row)
    return found


def around(part: bytes) -> bytes:
    """A part in its canonical form, without rows and without what follows them."""
    root = etree.fromstring(part)
    for e in list(root.iter("{*}row", "{*}hyperlinks", "{*}comment", "{*}threadedComment")):
        e.tail, e.tag = "", "gone"
        e.getparent().remove(e)
    for e in root.iter("{*}dimension", "{*}conditionalFormatting", "{*}dataValidation", "{*}table", "{*}autoFilter"):
        e.attrib.pop("ref", None)
        e.attrib.pop("sqref", None)
    for e in root.iter("{*}formula", "{*}formula1", "{*}formula2", "{*}f", "{*}sqref", "{*}definedName"):
        e.text = ""
    for e in root.iter("{*}sheetData"):
        e.text = ""
        for inside in e:
            inside.tail = ""
    for e in root.iter("{*}Override", "{*}Relationship", "{*}calcPr"):
        e.attrib.pop("fullCalcOnLoad", None)
        if "calcChain" in "".join(e.attrib.values()) or not e.attrib:
            e.getparent().remove(e)
    return etree.tostring(root.getroottree(), method="c14n")


DECLARATION = re.compile(rb"(?:\s*<\?xml\s.*?\?>\s*)?")
NUMBER = st.one_of(st.integers(2, 9), st.integers(250, 260))
COUNT = st.integers(1, 300)
EDITS = st.lists(
    st.one_of(
        st.builds(
            SetCell, st.just(SHEET), NUMBER, st.integers(1, 9), st.sampled_from([None, "x < y", " a\n", 2.5, True])
        ),
        st.builds(InsertRows, st.just(SHEET), NUMBER, COUNT),
        st.builds(DeleteRows, st.just(SHEET), NUMBER, COUNT),
        st.builds(MoveRows, st.just(SHEET), NUMBER, st.integers(1, 4), NUMBER),
    ),
    max_size=6,
)


@pytest.mark.slow
@settings(max_examples=example_count(150), deadline=None)
@given(name=st.sampled_from(list(ALL)), edits=EDITS)
def test_all_but_the_edit_stays(name: str, edits: list) -> None:
    before = now = sample(name)
    places = {n: n for n in rows(parts(before)[PART])}  # of the rows that are as they were: number now, number before
    for one in edits:
        try:
            now = edited(now, [one])
        except SheetsError as error:
            assert "torn" in error.message or "would then mean" in error.message or "Excel table" in error.message
            continue
        if isinstance(one, SetCell):
            places.pop(one.row, None)
        else:
            places = {new: old for n, old in places.items() if (new := one.mapped(n)) is not None}
    old, new = parts(before), parts(now)
    assert set(old) - set(new) <= {"xl/calcChain.xml"} and not set(new) - set(old)
    touched = {n for n in new if new[n] != old[n]}
    follow = {PART, "xl/workbook.xml", "[Content_Types].xml", "xl/_rels/workbook.xml.rels"}
    assert all(n in follow or COMMENTS.match(n) or n.startswith("xl/tables/") for n in touched)
    for part in touched:
        if part.endswith(".xml") or part.endswith(".rels"):
            assert around(new[part]) == around(old[part])
            assert DECLARATION.match(new[part])[0] == DECLARATION.match(old[part])[0]
    were, are = rows(old[PART]), rows(new[PART])
    assert {n: are.get(n) for n in places} == {n: were[o] for n, o in places.items()}


@settings(max_examples=30, deadline=None)
@given(name=st.sampled_from(list(ALL)), sheet=st.sampled_from([SHEET, "Mine"]))
def test_a_new_name_changes_only_what_names_the_sheet(name: str, sheet: str) -> None:
    there = edited(sample(name), [RenameSheet(sheet, "It's < new")])
    assert any(b"new" in data for part, data in parts(there).items() if part == "xl/workbook.xml")
    back = parts(edited(there, [RenameSheet("It's < new", sheet)]))
    for part, data in parts(sample(name)).items():
        if data != back[part]:
            assert part.endswith(".xml")
            a, b = etree.fromstring(data), etree.fromstring(back[part])
            for calc in [*a.iter("{*}calcPr"), *b.iter("{*}calcPr")]:
                calc.attrib.pop("fullCalcOnLoad", None)
            assert canonical(a).replace(b"<calcPr></calcPr>", b"") == canonical(b).replace(b"<calcPr></calcPr>", b"")


def test_rows_that_count_on_follow_the_rows_before_them(tmp_path: Path) -> None:
    path = nameless(tmp_path / "x.xlsx")
    gap = b'<row r="260"><c><v>1</v></c></row><row><c><v>2</v></c></row>'
    repack(
        path,
        {
            PART: lambda data: re.sub(
                rb"(?s)(<sheetData>(?:.*?</row>){256}).*</sheetData>", rb"\1" + gap + rb"</sheetData>", data
            )
        },
    )
    edit(path, [MoveRows(SHEET, 260, 1, before=8), SetCell(SHEET, 300, 1, "end")])
    sheet = read_sheets(path)[0]
    assert [sheet.cells[at, 1].text for at in (8, 9, 257, 261, 300)] == ["1", "8", "256", "2", "end"]


def test_everything_of_a_strange_sheet_is_kept(tmp_path: Path) -> None:
    path = odd(tmp_path / "x.xlsx")
    edit(path, [SetCell(SHEET, 5, 4, "new")])
    data = parts(path)[PART]
    assert data.startswith(b"""<?xml version='1.0' encoding='utf-8' standalone="no"?>\n<?app keep this?>""")
    for kept in (
        b"<!-- before -->", b'mc:Ignorable="x14ac xr"', b'xmlns:unused="urn:u"', b"<!-- rows: <row r=\"9\"> --><?app rows?>",
        b"<![CDATA[a < b & c]]>", b'<t xml:space="preserve"> Red ball </t>', b"<v>two&#13;&#x9;</v>", b"<?app between?>",
        b'<unused:a unused:b="&lt;&quot;"/>', b'<c t="inlineStr" r="A1">', b"<!-- after -->", b"<?app end?>",
    ):  # fmt: skip
        assert kept.replace(b"&#x9;", b"\t") in data.replace(b"&#x9;", b"\t"), kept
    assert b'<c r="D5" t="inlineStr"><is><t>new</t></is></c>' in data
    edit(path, [MoveRows(SHEET, 3, 1, before=6)])
    data = parts(path)[PART]
    assert data.count(b"<?app") == 4 and b'<row r="5"><c><v>1</v></c>' in data and b'<c r="C4"><v>3</v>' in data


@pytest.mark.parametrize("encoding", ["utf-16", "iso-8859-1", "utf-8-sig"])
def test_the_encoding_is_kept(tmp_path: Path, encoding: str) -> None:
    def encoded(data: bytes) -> bytes:
        name = encoding.removesuffix("-sig")
        text = data.decode().replace("UTF-8", name, 1).replace("<sheetData>", "<sheetData><!-- \xe9 -->")
        return text.encode(encoding)

    path = repack(make(tmp_path / "x.xlsx"), {PART: encoded})
    before = parts(path)[PART]
    edit(path, [SetCell(SHEET, 3, 1, "\u3042 \xe9")])
    after = parts(path)[PART]
    assert (
        after[:60] == before[:60] and "<!-- \xe9 -->".encode(encoding.removesuffix("-sig")).lstrip(b"\xff\xfe") in after
    )
    assert etree.fromstring(after).xpath("string(//*[local-name()='c'][@r='A3'])") == "\u3042 \xe9"


@pytest.mark.parametrize(
    "bomb",
    [
        b'<!DOCTYPE worksheet [<!ENTITY a "b">]>',
        b"<?x " + b"y" * 70_000 + b'?><!-- <a> --><!DOCTYPE worksheet [<!ENTITY a "b">]>',
        b'<!DOCTYPE worksheet SYSTEM "file:///etc/passwd">',
    ],
)
@pytest.mark.parametrize("part", ["xl/worksheets/sheet2.xml", "xl/workbook.xml", "xl/styles.xml"])
def test_no_part_may_declare_entities(tmp_path: Path, bomb: bytes, part: str) -> None:
    path = repack(make(tmp_path / "x.xlsx"), {part: lambda data: data.replace(b"?>\n", b"?>\n" + bomb, 1)})
    data = path.read_bytes()
    with pytest.raises(SheetsError):
        edit(path, [SetCell("Mine", 1, 1, "x"), DeleteSheet("Mine")])
    assert path.read_bytes() == data


@pytest.mark.parametrize(
    "inside",
    [
        b"<x>" * limits.XML_DEPTH + b"</x>" * limits.XML_DEPTH,
        b"<x/>" * (limits.XML_ELEMENTS + 1),
        b"<!--" * 100_000,
        b"<x",
        b"&nothing;",
        b"<c/></row><c/><row>",
        b"\x00",
    ],
    ids=["deep", "many", "comments", "cut off", "entity", "cells", "control"],
)
def test_what_cannot_be_changed_safely_is_refused(tmp_path: Path, inside: bytes) -> None:
    def broken(data: bytes) -> bytes:
        return data.replace(b'<row r="2"', b'<row r="2" x="' + b'"><c>' + inside + b'</c></row><row r="3"', 1)

    data = make(tmp_path / "x.xlsx").read_bytes()
    path = tmp_path / "y.xlsx"
    path.write_bytes(data)
    repack(path, {PART: broken})
    before = path.read_bytes()
    with pytest.raises(SheetsError):
        edit(path, [InsertRows(SHEET, 2)])
    assert path.read_bytes() == before


@pytest.mark.parametrize("raw", ['<sheet name="Mine"', '<sheet name="Mine" r:id="rId2"/>', "<!DOCTYPE a><sheet/>", ""])
def test_a_damaged_memory_of_a_sheet_is_refused(tmp_path: Path, raw: str) -> None:
    path = make(tmp_path / "x.xlsx")
    (kept,) = edit(path, [DeleteSheet("Mine")]).kept
    memory = json.loads(zlib.decompress(base64.b64decode(kept)))
    for piece in memory["pieces"]:
        piece[3] = raw if piece[1] == ["workbook", "sheets"] else piece[3]
    damaged = base64.b64encode(zlib.compress(json.dumps(memory).encode())).decode()
    before = path.read_bytes()
    with pytest.raises(SheetsError):
        edit(path, [BringSheet("Mine", damaged)])
    assert path.read_bytes() == before
    assert edit(path, [BringSheet("Mine", kept)]).changed
