"""Findings in Japanese: none of the program's own words stays English."""

from __future__ import annotations

import io
import json
import pickle
import re
import sys
from contextlib import redirect_stderr, redirect_stdout, suppress
from dataclasses import replace
from types import SimpleNamespace

import openpyxl
import pytest
from play import check
from test_mistakes import base, markdown_of, mistakes

from rrp_sheets import api, texts
from rrp_sheets.cli.main import main
from rrp_sheets.diagnostics import CODES, Diagnostic, Report
from rrp_sheets.diagnostics.catalogue import completed, load_page
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.run_files import Stamp
from rrp_sheets.model.workbook import Address
from rrp_sheets.render.marble_diagram import Group, Lane, Marble, MarbleDiagram
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.render.plots import Curve, PlotNote, draw_plots
from rrp_sheets.replay.output import account
from rrp_sheets.replay.report import as_text, each_line, in_words, unknown
from rrp_sheets.replay.result import Count, Difference, Replayed
from rrp_sheets.services.printing import gather
from rrp_sheets.texts import N_, LazyMessage, capital, listed, sentences, small, translate
from rrp_sheets.workbook import read
from rrp_sheets.workers.codec import pack, unpack

ENGLISH = re.compile(r"[A-Za-z]+ (a|an|the|is|are|of|to|in|it|that|this|for|no|not|has|and|or|with)\b", re.IGNORECASE)
TO_TYPE = re.compile(r"ends with the run|x for x in list|what in text|`[^`]*`")  # what is written so in a cell


def books() -> list[str]:
    """Every mistake of `mistakes.md`, and every wrong example of a diagnostic's page."""
    found = []
    for name, where, text, *_ in mistakes():
        typed = [part.strip() for part in text.split("<br>")]
        found.append(markdown_of({**base(name), **dict(zip(where.split("<br>"), typed, strict=True))}))
    pages = [page for page in map(load_page, CODES) if page.wrong]
    return found + [completed(page.wrong) for page in pages]


@pytest.fixture(scope="module")
def checked():
    """All findings of these books, and which of their messages were put into an f-string meanwhile."""
    flattened = []

    def formatted(self: LazyMessage, specification: str) -> str:
        caller = sys._getframe(1).f_code
        if caller.co_filename != texts.__file__ and " " in self:  # a single word may be a name, too
            flattened.append((caller.co_filename, caller.co_name, str(self)))
        return str.__format__(self, specification)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(LazyMessage, "__format__", formatted, raising=False)
        assert f"{N_('two words')}" and flattened.pop()
        findings = [d for book in books() for d in check(book).report]
        for finding in findings:
            finding.as_dict("ja")
    return findings, flattened


def without_typed(said: object) -> object:
    """A message whose places hold no more what the user typed, so that only the program's words are left."""
    if isinstance(said, LazyMessage):
        places = {n: without_typed(v) for n, v in said.places.items()}
        return LazyMessage(said.template, msgctxt=said.context, **places)
    return 0 if isinstance(said, int | float) else ""


@pytest.mark.slow
def test_nothing_of_the_programs_words_stays_english(checked):
    findings, _ = checked
    assert len({d.code for d in findings}) > 100
    for d in findings:
        for said in (d.message, d.remedy):
            japanese = TO_TYPE.sub("", translate(without_typed(said), "ja"))
            assert not ENGLISH.search(japanese), (d.code, translate(said, "ja"))


def test_what_was_typed_is_never_translated():
    report = Report()
    finding = report.add("GRAPH011", Address("Look", 2, 4), name="a number")
    assert (
        translate(finding.message, "ja") == "ストリーム「a number」を使うものがないため、この行には効果がありません。"
    )
    hostile = report.add(
        "GRAPH001", None, name="{name.__class__} <script>", remedy=N_("Did you mean {guess}?", guess="{0}")
    )
    assert "「{name.__class__} <script>」" in translate(hostile.message, "ja") and "「{0}」" in translate(
        hostile.remedy, "ja"
    )


def test_a_message_is_the_english_text_and_survives_being_sent():
    finding = Report().add("LINT004", Address("Look", 3, 4), other=N_("row {number}", number=5))
    assert "This row and row 5 can speak" in finding.message
    sent = unpack(Diagnostic, json.loads(json.dumps(pack(finding))))
    assert sent == finding and translate(sent.message, "ja").startswith("この行と5行目は同時に話す")
    kept = pickle.loads(pickle.dumps(finding.message))
    assert translate(kept, "ja") == translate(finding.message, "ja")


def test_a_refused_file_crosses_processes_as_its_finding(tmp_path):
    path = tmp_path / "broken.xlsx"
    path.write_bytes(b"PK\3\4 cut off")
    with pytest.raises(UnreadableWorkbook) as caught:
        read(path)
    sent = unpack(SheetsError, json.loads(json.dumps(pack(caught.value))))
    assert isinstance(sent, UnreadableWorkbook) and sent.finding == caught.value.finding
    assert str(sent) == str(caught.value) and sent.code == "FILE008"
    assert (
        translate(sent.finding.message, "ja")
        == "「broken.xlsx」は壊れています（途中で切れているか、全体がそろっていません）。"
    )


def test_details_are_values_by_name_in_the_reader_s_language():
    details = {"name": "a number", "remedy": N_("Did you mean {guess}?", guess="Score"), "guess": "Score"}
    finding = Report().add("GRAPH001", Address("T", 2, 1), span=None, fixes=(), **details)
    assert json.loads(json.dumps(finding.as_dict()))["details"] == details
    assert finding.as_dict("ja")["details"] == details | {"remedy": "「Score」のことですか。"}
    other = Report().add("GRAPH001", Address("T", 2, 1), span=None, fixes=(), **details | {"name": "a text"})
    assert finding.id != other.id and finding.id == unpack(Diagnostic, pack(finding)).id
    with pytest.raises(TypeError, match="GRAPH001 needs remedy"):
        Report().add("GRAPH001", None, name="X")


def test_messages_are_joined_and_begin_sentences():
    rows = [N_("row {number}", number=n) for n in (3, 5, 8)]
    assert (
        listed(rows, "and") == "row 3, row 5 and row 8"
        and translate(listed(rows, "and"), "ja") == "3行目、5行目と8行目"
    )
    many = listed([N_("row {number}", number=n) for n in range(2_000)], "and")
    assert many.startswith("row 0, row 1, row 2, ") and many.endswith(", row 1998 and row 1999")
    found = Report().add("LINT004", Address("Look", 3, 4), other=many)  # some hundred would be too deep one in another
    again = unpack(Diagnostic, json.loads(json.dumps(pack(found))))
    assert again == found and "、".join(f"{n}行目" for n in range(1_999)) + "と1999行目" in translate(
        again.message, "ja"
    )
    assert (
        capital(rows[0]) == "Row 3"
        and translate(capital(rows[0]), "ja") == "3行目"
        and small(capital(rows[0])) == "row 3"
    )
    both = sentences(N_("It has {names}.", names="x, y"), "", N_("Leave the cell blank."))
    assert (
        both == "It has x, y. Leave the cell blank." and translate(both, "ja") == "項目：x, y。セルを空にしてください。"
    )


BOOK = """## Protocol
| Field | Value |
|---|---|
| Language | {language} |

## Look
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red bal | map | redBal.distance | Near |
"""


@pytest.fixture(scope="module")
def japanese(tmp_path_factory):
    path = tmp_path_factory.mktemp("japanese") / "挨拶.md"
    path.write_text(BOOK.format(language="日本語"), encoding="utf-8")
    return path


def said_by(*arguments: object) -> str:
    out = io.StringIO()
    with redirect_stdout(out), redirect_stderr(out), pytest.MonkeyPatch.context() as patch, suppress(SystemExit):
        patch.setattr(sys, "argv", ["rrp-sheets", *map(str, arguments)])
        main()
    return out.getvalue()


def test_a_japanese_protocol_is_checked_in_japanese(japanese):
    text = said_by("check", japanese)
    assert "エラー GRAPH001 Look!A2: ストリーム「Red bal」を出す行はなく" in text and "エラー1件。" in text
    assert "「Red ball」のことですか。" in text and "No row produces" not in text
    assert "No row produces the stream “Red bal”" in said_by("check", japanese, "--language", "en")
    (found,) = json.loads(said_by("check", japanese, "--json"))["findings"]
    assert found["message"].startswith("ストリーム「Red bal」") and found["fixes"][0]["title"] == "Red ball と書く"
    assert "ストリーム「Red bal」" in said_by("explain", japanese)
    assert "「ない.md」というファイルはありません。" in said_by("check", "ない.md", "--language", "ja")


def test_the_marked_copy_and_the_pack_say_it_in_japanese(japanese):
    copy = japanese.with_name("copy.xlsx")
    said_by("check", japanese, "--report", copy)
    book = openpyxl.load_workbook(copy)
    texts = [str(c.value) for sheet in book for row in sheet.iter_rows() for c in row if c.value]
    assert (
        any("エラー GRAPH001: ストリーム「Red bal」" in t for t in texts) and "対処" in texts and "エラー1件" in texts
    )
    (finding,) = gather(japanese, draft=True).pack.findings
    assert finding.text.startswith("ストリーム「Red bal」") and "のことですか" in finding.remedy


TESTED = """## Protocol
| Field | Value |
|---|---|
| Language | Japanese |

## Look
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | 1 / redBall.distance | |
| | filter | value > 2 | Near |

## Test
| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | distance=0 | |
| 1000 | Red ball | distance=0.5 | |
| 1200 | Near | | 3 |
"""


@pytest.fixture(scope="module")
def tested(tmp_path_factory):
    path = tmp_path_factory.mktemp("tested") / "試験.md"
    path.write_text(TESTED, encoding="utf-8")
    return path


@pytest.mark.parametrize("command", ["print", "marbles", "test", "run"])
def test_every_command_says_in_japanese_what_is_wrong_with_a_japanese_workbook(command, japanese):
    text = said_by(command, japanese)
    assert "エラー GRAPH001 Look!A2: ストリーム「Red bal」を出す行はなく" in text
    assert not ENGLISH.search(text), text


RUN = """## Protocol
| Field | Value |
|---|---|
| Title | 挨拶 |
| Language | 日本語 |

## Devices
| Stream | Device | Every | Text |
|---|---|---|---|
| 開始 | Timer | 0.5 s | |
| 終わり | Timer | 1 s | |
| 声 | Say parameter | | こんにちは。 |

## 試し
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| 開始 | map | 1 / 0 | 割り算 |
| 割り算 | subscribe | | Print |
| 開始 | subscribe | | 声 |
| 終わり | subscribe | | End run |
"""


def test_a_run_of_a_japanese_workbook_is_told_in_japanese(tmp_path):
    book = tmp_path / "挨拶.md"
    book.write_text(RUN, encoding="utf-8")
    text = said_by("run", book, "--fast", "--for", "5 s", "--out", tmp_path / "out")
    for words in (
        "挨拶：4行、5秒間。", "試し!2のエラー：", "発話『こんにちは。』", "実行が終わりました",
        "行試し!5が実行を終えました。", "件の命令", "すべての出来事",
    ):  # fmt: skip
        assert words in text, text
    assert not ENGLISH.search(text.replace("Timer (", "")), text


def test_cells_are_set_in_the_language_of_the_workbook(japanese, tmp_path):
    book = tmp_path / "挨拶.md"
    book.write_text(japanese.read_text(encoding="utf-8"), encoding="utf-8")
    text = said_by("set", book, "Look!D2", "近い")
    assert "Look!D2：『Near』 → 『近い』" in text and "エラー GRAPH001 Look!A2" in text and "エラー1件" in text
    assert not ENGLISH.search(text), text


def test_errors_are_told_in_the_language_of_the_command_and_of_no_command_before(japanese, tmp_path):
    refused = said_by("explain", japanese, "--behaviour", "Ahead")
    assert refused.startswith("エラー：") and not ENGLISH.search(refused), refused
    occupied = tmp_path / "x.pdf"
    occupied.mkdir()
    refused = said_by("print", japanese, "--draft", "-o", occupied)
    assert refused.startswith("エラー：") and not ENGLISH.search(refused), refused
    assert said_by("check", "none.md").startswith("Error: There is no file")


def test_tests_of_a_japanese_workbook_are_told_and_drawn_in_japanese(tested, tmp_path):
    text = said_by("test", tested, "--marbles", tmp_path / "tests.svg")
    assert "1件のテストのうち1件が不合格です" in text and not ENGLISH.search(text), text
    drawn = said_by("marbles", tested, "-o", tmp_path / "marbles.svg")
    assert "marbles.svg" in drawn and not ENGLISH.search(drawn)
    for name in ("tests.svg", "marbles.svg"):
        picture = (tmp_path / name).read_text(encoding="utf-8")
        assert "センサー" in picture and "2行目" in picture
        assert "division" not in picture and not re.search(r"\brow \d", picture)


def test_times_and_quotes_of_a_replay_are_japanese():
    ends = SimpleNamespace(dropped=0, usual=[("Say", name, 1.5) for name in "abcde"], unknown=[])
    recorded = SimpleNamespace(ended="cut", last_us=2_500_000, engine="frame")
    said = [translate(line, "ja") for line in unknown(recorded, {}, "", ends)]
    assert "2.5秒" in said[0] and "“a” 1.5秒、“b” 1.5秒、“c” 1.5秒、“d” 1.5秒、…" in said[-1]
    extra = Difference("extra", "event", "Near", 0, 0, "", "", None, 1)
    found = Replayed("r1", "x.xlsx", "", "frame", 1.0, 1, (extra,), ())
    (line,) = each_line(found)
    assert translate(line.text, "ja").startswith("『Near』")


KINDS = ("missing", "extra", "value", "time", "row", "order")


@pytest.mark.parametrize("other", ["", "別.xlsx"])
def test_a_replay_is_told_in_the_language_of_the_workbook_that_ran(other):
    streams = ("Say", "Head tracker", "Look!Near")
    differences = tuple(
        Difference(kind, "event", s, n * 5_000_000, n * 5_000_000 + 100_000, "Look!3", "Look!4", "やあ", "ええ")
        for n, (kind, s) in enumerate((kind, s) for kind in KINDS for s in streams)
    )
    counts = tuple(Count(s, "Look!3", "Look!4", 9, 9, 3) for s in streams)
    found = Replayed(
        "r1", "挨拶.xlsx", other, "frame", 90.0, 27, differences, counts, stamp=Stamp(language="ja"),
        actuators=streams[:2], spoken={"Say": ""}, remarks=(N_("{row} gets", row=in_words("Look!3")),),
    )  # fmt: skip
    text = as_text(found)
    assert "Lookの4行目" in text and "『ええ』" in text and "ロボット：" in text
    assert not ENGLISH.search(text) and not re.search(r"\b(would|was|came|events?|row)\b", text), text
    page = account(found)
    assert page["verdict"].startswith("違います：") and page["remarks"] == ["Lookの3行目は"]
    english = as_text(replace(found, stamp=Stamp()))
    assert "Look row 4" in english and not re.search("[ぁ-ん]", english.replace("やあ", "").replace("ええ", ""))


def test_pictures_of_a_run_speak_its_language():
    curve = Curve("Red ball.x", "sensor", "rad", [(0.0, 1.0), (1.0, 2.0)], 2, other=[(0.0, 2.0)])
    plots, _, _ = draw_plots("挨拶", [curve], [PlotNote(0.5, 0.5, "said", "やあ")], 2.0, more="", language="ja")
    assert all(word in plots for word in ("発話", "センサー", "単位：rad", "時間（秒）")) and "Time (s)" not in plots
    lane = Lane("a", "Red ball", "sensor", (Marble(1_000, 1), Marble(2_000, 2)))
    (page,) = draw_marbles([MarbleDiagram("挨拶", (Group((), lane),), 0, 5_000_000, language="ja")])
    assert "命令の終わり" in page.svg and page.alt.startswith("挨拶のマーブル図") and "done" not in page.svg


def test_no_message_of_a_finding_is_put_into_an_f_string(checked):
    _, flattened = checked
    assert flattened == []


def test_changes_of_settings_and_sheets_are_printed_in_japanese(tmp_path):
    old, new = tmp_path / "old.md", tmp_path / "new.md"
    rows = "| Inputs | Connector | Formula | Output |\n| --- | --- | --- | --- |\n| Tick | map | 1 | {0} |\n"
    devices = "| Stream | Device | Every |\n| --- | --- | --- |\n| Tick | Timer | {0} |\n"
    one = "## A\n\n" + rows.format("X") + "\n## Devices\n\n"
    old.write_text(one + devices.format("2 s"), encoding="utf-8")
    new.write_text(one + devices.format("3 s") + "\n## B\n\n" + rows.format("Y"), encoding="utf-8")
    changes = gather(new, against=old, language="ja").pack.changes
    assert changes is not None
    told = " ".join(f"{c.before} {c.after}" for c in changes.effects)
    assert "間隔" in told and "1行" in told and "row" not in told


def test_settings_of_an_added_device_are_named_in_japanese(tmp_path):
    old, new = tmp_path / "old.md", tmp_path / "new.md"
    old.write_text(BOOK.format(language="en"), encoding="utf-8")
    devices = "\n## Devices\n\n| Stream | Device | Every |\n| --- | --- | --- |\n| Tick | Timer | 2 s |\n"
    new.write_text(BOOK.format(language="en") + devices, encoding="utf-8")
    (added,) = [change.after for change in api.diff(old, new).changes if change.part == "device"]
    assert added == "Timer, Every 2 s" and translate(added, "ja") == "Timer、Every（間隔） 2 s"
