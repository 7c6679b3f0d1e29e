"""Reading workbooks: recognising sheets, tolerance, diagnostics with cells."""

from __future__ import annotations

from pathlib import Path
from textwrap import dedent

import pytest

from rrp_sheets.formulas.limits import LONGEST_TEXT
from rrp_sheets.model.workbook import FALSE_WORDS, TRUE_WORDS, Address
from rrp_sheets.workbook import Reading, read

HEAD = """
| Input streams | Connector | Formula | Output stream | On | Priority | Notes |
|---|---|---|---|---|---|---|
"""


@pytest.fixture
def markdown(tmp_path: Path):  # type: ignore[no-untyped-def]
    """Read a Markdown workbook given as text."""

    def load(text: str) -> Reading:
        path = tmp_path / "x.md"
        path.write_text(dedent(text), encoding="utf-8")
        return read(path)

    return load


def codes(reading: Reading) -> list[tuple[str, str]]:
    return reading.report.flatten(["code", "cell"])


def test_a_whole_workbook(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        f"""
        # Title, ignored
        ## Tracking
        {HEAD.strip().replace(chr(10), chr(10) + " " * 8)}
        | Red ball, Face、Foot<br>Chest | map | IF(a\\|b; 1; 2) | Distance | | 2.5 | as typed |
        | | | | | | | |
        | # a comment | map | x | Y | | | |
        | Distance | filter | distance < 1 | | no | | |
        | | subscribe | | Head tracker | yes | -1 | |

        ## Devices
        | Stream | Device | Eye colour | Notes |
        |---|---|---|---|
        | Head tracker | Tracker | blue | x |
        ## Helpers
        | Name | Inputs | Formula |
        |---|---|---|
        | add | a, b | =a+b |
        | # old | a | a |
        ## Scene
        | Time (s) | Thing | Does | Value |
        |---|---|---|---|
        | Ask done + 2 | Red ball | appears | at 1, 0, 0.4 |
        ## Gestures
        | Name | Time (s) | HeadYaw | L Hand |
        |---|---|---|---|
        | Nod | 0.5 | 30° | |
        ## A test
        | Time (ms) | Stream | Send | Expect |
        |---|---|---|---|
        | 0 | Red ball | distance=0.3 | any |
        ## Protocol
        | Field | Value |
        |---|---|
        | Title | Our “own” |
        | Site code | B7 |
        """
    )
    w = reading.workbook
    assert codes(reading) == []
    assert reading.format == "markdown"
    (behaviour,) = w.behaviours
    assert behaviour.name == "Tracking"
    assert behaviour.address == Address("Tracking", 1, 1)
    first, second, third = behaviour.rows
    assert [c.text for c in first.inputs] == ["Red ball", "Face", "Foot", "Chest"]
    assert {str(c.address) for c in first.inputs} == {"Tracking!A2"}
    assert (first.formula.text, first.priority, first.notes) == ("IF(a|b; 1; 2)", 2.5, "as typed")
    assert (second.number, second.on, second.output.text, str(second.output.address)) == (5, False, "", "Tracking!D5")
    assert (third.inputs, third.on, third.priority) == ((), True, -1.0)
    assert {k: c.text for k, c in w.devices[0].settings.items()} == {"eyecolour": "blue"}
    assert [(h.name.text, [i.text for i in h.inputs], h.formula.text) for h in w.helpers] == [
        ("add", ["a", "b"], "a+b")
    ]
    assert w.helpers[0].formula.original == "=a+b"
    assert w.scene is not None
    assert w.scene[0].time.text == "Ask done + 2"
    assert {k: c.text for k, c in w.gestures[0].joints.items()} == {"headyaw": "30°"}
    assert (w.tests[0].name, w.tests[0].rows[0].expect.text) == ("A test", "any")
    assert w.protocol.text("Site code") == "B7"
    assert w.protocol.names["sitecode"] == "Site code"
    assert w.protocol.robot == "nao"
    assert w.sheets == ("Tracking", "Devices", "Helpers", "Scene", "Gestures", "A test", "Protocol")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("typed", "formula"),
    [
        ("=x>1", "x>1"),
        ("'=x>1", "x>1"),
        ("'x", "x"),
        ("'a' & 'b'", "'a' & 'b'"),
        ("\u00a0ball.x\u2009>\u30003 ", "ball.x > 3"),
        ("ｂａｌｌ．ｘ＞３", "ball.x>3"),
        ("“near” & ‘far’", "\"near\" & 'far'"),
        ("“don’t”", '"don’t"'),
        ('„so"', '"so"'),
        ('"これは何？"', '"これは何？"'),
        ('“say "hi"”', '"say ""hi"""'),
        ('"She said “hi”"', '"She said “hi”"'),
        ("x − 1", "x − 1"),
    ],
)
def test_formula_cells_are_cleaned_but_their_texts_are_kept(markdown, typed: str, formula: str) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f"## A{HEAD}| x | map | {typed} | Y | | | |\n")
    (row,) = reading.workbook.behaviours[0].rows
    assert row.formula.text == formula
    assert row.formula.original == typed.strip()


@pytest.mark.parametrize(
    "header",
    [
        "from | OPERATOR | parameter formula | to",
        "Inputs|Connector|Formula|OUTPUT_stream",
        "入力ストリーム | コネクター | 式 | 出力ストリーム",
    ],
)
def test_synonyms_of_headers(markdown, header: str) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f"## A\n| {header} |\n|---|---|---|---|\n| x | map | 1 | Y |")
    assert codes(reading) == []
    assert reading.workbook.behaviours[0].rows[0].output.text == "Y"


@pytest.mark.parametrize(
    ("sheet", "header", "found"),
    [
        ("A", "Input streams | Conector | Formula | Output stream", [("SHEET002", "B1")]),
        ("A", "Input streams | Connector | Formula", [("SHEET004", "A1")]),
        ("Devices", "Stream | Devise", [("SHEET001", ""), ("SHEET002", "B1")]),
        ("Mine", "Stream | Devise", [("SHEET001", ""), ("SHEET003", "B1")]),
        ("Mine", "Stream | Length", [("SHEET001", "")]),
        ("Mine", "Word | Means", [("SHEET001", "")]),
        ("A", "Input streams|Connector|Formula|Output stream|Formula", [("SHEET005", "E1")]),
        ("A", "Input streams|Connector|Formula|Output stream|From", [("SHEET005", "E1")]),
        ("A", "Input streams|Connector|Formula|Output stream|Mine|Mine", []),
        ("Devices", "Stream|Device|Joint|joint", [("SHEET001", ""), ("SHEET005", "D1")]),
        # further columns for people
        ("A", "入力|コネクタ|式|出力|メモ|備考", []),
        ("A", "Input streams|Connector|Formula|Output stream|Comment|メモ", []),
        ("Devices", "Stream|Device|Notes|備考", [("SHEET001", "")]),
        # Japanese headers that tables of the user's own have too
        ("表", "番号|入力|出力|式", [("SHEET001", "")]),
        ("表", "入力|出力|数式|接続", [("SHEET001", "")]),
        ("表", "ストリーム|送信|期待", [("SHEET001", "")]),
        ("表", "名前|入力|式", [("SHEET001", "")]),
        ("表", "名前|入力値|式", [("SHEET001", "")]),
        ("表", "時刻（秒）|対象|動作|値", [("SHEET001", "")]),
        ("A", "入力|コネクタ|式", [("SHEET004", "A1")]),
        ("A", "入力|Connector|式|出力", []),
        ("Helpers", "名前|入力|式", [("SHEET001", "")]),
    ],
)
def test_headers(markdown, sheet: str, header: str, found: list[tuple[str, str]]) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f"## {sheet}\n| {header} |\n|---|---|---|---|\n| x | map | 1 | Y | z | z |")
    assert [c for c in codes(reading) if c[0] != "SHEET017"] == found


def test_a_second_column_for_people_is_no_setting(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        "## Devices\n| Stream | Device | メモ | Joint | 備考 |\n|---|---|---|---|---|\n"
        "| Neck | Joint position | a | HeadYaw | b |\n| | | | | c |"
    )
    (device,) = reading.workbook.devices
    assert {k: cell.text for k, cell in device.settings.items()} == {"joint": "HeadYaw"}


def test_header_row_may_stand_below_a_title(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        "## A\n| My protocol | | | |\n|---|---|---|---|\n| | | | |\n"
        "| From | Connector | Formula | To |\n| x | map | 1 | Y |"
    )
    (behaviour,) = reading.workbook.behaviours
    assert (behaviour.address.row, behaviour.rows[0].number) == (3, 4)


def test_on_and_priority(markdown) -> None:  # type: ignore[no-untyped-def]
    words = ["FALSE", "Off", "0", "no", "maybe", "1", "ON", ""]
    rows = "".join(f"| x | map | 1 | Y{i} | {word} | {word} | |\n" for i, word in enumerate(words))
    reading = markdown(f"## A{HEAD}{rows}")
    assert [r.on for r in reading.workbook.behaviours[0].rows] == [False] * 4 + [True] * 4
    assert [c for c in codes(reading) if c[0] == "SHEET011"] == [("SHEET011", "E6")]
    assert [c[1] for c in codes(reading) if c[0] == "SHEET012"] == ["F2", "F3", "F5", "F6", "F8"]


def test_on_in_other_languages_and_spellings(markdown) -> None:  # type: ignore[no-untyped-def]
    off = [
        "FALSCH",
        "Faux",
        "falso",
        "ONWAAR",
        "いいえ",
        "オフ",
        "ｵﾌ",
        "ＦＡＬＳＥ",
        "０",
        "nein",
        "否",
        "ЛОЖЬ",
        "yanlış",
        "Ｎｏ",
        "'FALSE",
        "FAL\u200bSE",
        *"×✕✗",
    ]
    on = [*"○〇◯✓", "WAHR", "vrai", "はい", "オン", "ＴＲＵＥ", "１", "oui", "sí", "SÍ", "Si\u0301", "ДА", "是"]
    rows = "".join(f"| x | map | 1 | Y{i} | {word} | | |\n" for i, word in enumerate([*off, *on]))
    reading = markdown(f"## A{HEAD}{rows}")
    assert [r.on for r in reading.workbook.behaviours[0].rows] == [False] * len(off) + [True] * len(on)
    assert codes(reading) == []
    assert not TRUE_WORDS & FALSE_WORDS


def test_error_values_are_no_comments(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f"## A{HEAD}| #NAME? | map | #REF! | Y | | | |\n| # note | | | | | | |\n")
    assert codes(reading) == [("SHEET007", "A2"), ("SHEET007", "C2")]


def test_tables_are_read_when_a_formula_names_them(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        f"## A{HEAD}| x | map | INDEX(bodyParts; x) | Y | | | |\n"
        "## Body parts\n| Zone | Ask |\n|---|---|\n| Head | Where? |\n| Foot | |\n| | |\n| later | no |\n"
        "## Unused\n| Zone | Ask |\n|---|---|\n| Head | x |\n"
    )
    assert reading.workbook.tables == {"bodyparts": (("Zone", "Ask"), ("Head", "Where?"), ("Foot", ""))}
    assert codes(reading) == []


def test_findings_about_tables(markdown) -> None:  # type: ignore[no-untyped-def]
    long = "".join("| a |\n" for _ in range(1_001))
    reading = markdown(f"## A{HEAD}| x | map | ROWS(Parts) + ROWS(Bare) | Y | | | |\n## Parts\n| P |\n|---|\n{long}"
                       "## Bare\n| P |\n|---|\n")  # fmt: skip
    assert codes(reading) == [("SHEET019", "A1002"), ("SHEET020", "A1")]
    assert len(reading.workbook.tables["parts"]) == 1_001


def test_a_text_of_a_table_is_cut_where_texts_of_formulas_end_and_the_finding_names_its_cell(markdown) -> None:  # type: ignore[no-untyped-def]
    fits, long = "a" * LONGEST_TEXT, "ä" * (LONGEST_TEXT + 200)
    reading = markdown(
        f"## A{HEAD}| x | map | PICK(Parts[Ask]) | Y | | | |\n## Parts\n| Zone | Ask |\n|---|---|\n"
        f"| Head | {fits} |\n| Hand | {long} |\n## Unused\n| Notes |\n|---|\n| {long} |\n"
    )
    assert reading.report.flatten(["code", "sheet", "cell"]) == [("SHEET016", "Parts", "B3")]
    (finding,) = reading.report
    assert "2,200" in finding.message and "2,000" in finding.message
    assert [row[1] for row in reading.workbook.tables["parts"]] == ["Ask", fits, "ä" * LONGEST_TEXT]


def test_other_findings(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        f"## A{HEAD}| x | map | a | b | c | | | Y |\n\n| second | table |\n"
        f"## a{HEAD}"
        "## Protocol\n| Field | Value |\n|---|---|\n| Seed | 1 |\n| seed | 2 |\n| | 3 |\n"
        "## Gestures\n| Name | Time (s) |\n|---|---|\n| | 1 |\n| Nod | |\n"
        "## T\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n| | X | | any |\n| 0 | | zone=“Head” | |\n"
    )
    assert reading.report.flatten(["code", "sheet", "cell"]) == [
        ("SHEET011", "A", "E2"), ("SHEET017", "A", "H2"), ("SHEET014", "a", ""),
        ("SHEET015", "Protocol", "A3"), ("SHEET013", "Protocol", "A4"),
        ("SHEET013", "Gestures", "A2"), ("SHEET013", "Gestures", "B3"),
        ("SHEET013", "T", "A2"), ("SHEET013", "T", "B3"), ("SHEET018", "A", ""),
    ]  # fmt: skip


def test_values_of_tests(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(
        f"## A{HEAD}## T\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n"
        "| 0 | X | zone=“Head”; x=１ | Don’t stop！ |\n"
    )
    (row,) = reading.workbook.tests[0].rows
    assert (row.send.text, row.expect.text) == ('zone="Head"; x=1', "Don’t stop！")


def test_braces_of_the_user_do_no_harm(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f'## {{x}}{HEAD}| {{0}} | map | f"{{x}}" | Y | {{on}} | {{!r}} | |\n')
    assert codes(reading) == [("SHEET011", "E2"), ("SHEET012", "F2")]
    assert "{on}" in next(iter(reading.report)).message


def test_long_texts_are_cut_and_told(markdown) -> None:  # type: ignore[no-untyped-def]
    reading = markdown(f"## A{HEAD}| x | map | {'x' * 40_000} | Y | | | |\n")
    assert codes(reading) == [("SHEET016", "C2")]


def test_the_digest_is_of_the_content(tmp_path: Path) -> None:
    text = f"## A{HEAD}| x | map | é | Y | | | |\n"
    digests = set()
    for i, data in enumerate([text.encode(), b"\xef\xbb\xbf" + text.encode(), text.replace("\n", "\r\n").encode()]):
        path = tmp_path / f"{i}.md"
        path.write_bytes(data)
        digests.add(read(path).digest)
    assert len(digests) == 1
    assert len(digests.pop()) == 64
