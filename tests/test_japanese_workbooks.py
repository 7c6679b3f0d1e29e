"""Workbooks written in Japanese words: headers, sheets, devices, scene, tests and Protocol read as the English ones."""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import openpyxl
import pytest
from test_print import pack_of
from typed import run

from rrp_sheets import api
from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.layout import checked, in_language, sheets_of
from rrp_sheets.help.site import files, page
from rrp_sheets.help.topics import text_on
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address, Cell, Device, Protocol
from rrp_sheets.recording.marbles import trace_scores
from rrp_sheets.resources import bundled
from rrp_sheets.robots import DeviceType, load_robot
from rrp_sheets.scene.scene_words import KINDS, kind_of
from rrp_sheets.texts import N_, translate
from rrp_sheets.web.analysis import no_analysis
from rrp_sheets.web.completions import vocabulary
from rrp_sheets.workbook import read, schema
from rrp_sheets.workbook.files import make_workbook, read_sheets, write_sheets
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.reading import to_rows
from rrp_sheets.workbook.schema import SHEETS, recognise
from rrp_sheets.workbook.template import beginning, in_japanese

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx") if not p.stem.endswith("-ja"))
TABLES = [
    japanese.DEVICES, japanese.SETTINGS, japanese.COLOURS, japanese.ZONES, japanese.THINGS, japanese.VERBS,
    japanese.VALUE, japanese.EXPECTED, japanese.MOVES, *japanese.CHOICES.values(),
    *(field.also for field in schema.FIELDS.values()),
]  # fmt: skip


def japanese_words(path: Path, *, every: int = 1) -> dict[str, list[list[str]]]:
    """The rows of a workbook with Japanese headers and words, or only those in every second cell, say."""
    english = to_rows(read_sheets(path))
    made = in_japanese(english, str)
    if every == 1:
        return made
    mixed = {}
    for (name, before), after in zip(english.items(), made.values(), strict=True):
        pairs = (enumerate(zip(*rows, strict=True)) for rows in zip(before, after, strict=True))
        mixed[name] = [[cells[(at + row) % every == 0] for at, cells in pair] for row, pair in enumerate(pairs)]
    return mixed


def plain(thing: Any) -> Any:
    """A workbook without the spelling of its cells, the names of its sheets and headers."""
    if isinstance(thing, Cell):
        return key(thing.text), thing.address.row, thing.address.column
    if isinstance(thing, Address):
        return thing.row, thing.column
    if isinstance(thing, Protocol):
        return {k: plain(cell) for k, cell in thing.fields.items()}
    if is_dataclass(thing):
        without = {"source", "sheets", "language"} | ({"headers"} if isinstance(thing, Device) else set())
        return {f.name: plain(getattr(thing, f.name)) for f in fields(thing) if f.name not in without}
    if isinstance(thing, Mapping):
        return {k: plain(one) for k, one in thing.items()}
    return [plain(one) for one in thing] if isinstance(thing, (list, tuple)) else thing


@pytest.mark.parametrize("every", [1, pytest.param(2, marks=pytest.mark.slow), pytest.param(3, marks=pytest.mark.slow)])
@pytest.mark.parametrize("name", WORKBOOKS)
def test_a_workbook_in_japanese_says_the_same(tmp_path: Path, name: str, every: int) -> None:
    path = bundled("workbooks") / f"{name}.xlsx"
    made = japanese_words(path, every=every)
    own = write_sheets(made, tmp_path / "own.md")
    first, second = read(path), read(own)
    assert str(made) != str(to_rows(read_sheets(path)))
    there = [plain(reading.workbook) for reading in (first, second)]
    for both in there:  # sheets of ours may be called otherwise; what rows say about them is the same
        both.pop("names", None)
    assert there[0] == there[1]
    assert [(f.code, f.address and f.address.cell) for f in first.report] == [
        (f.code, f.address and f.address.cell) for f in second.report
    ]


@pytest.mark.parametrize("name", ["simple-tracking", "greeter"])
def test_the_checks_and_tests_of_a_workbook_in_japanese_are_the_same(tmp_path: Path, name: str) -> None:
    path = bundled("workbooks") / f"{name}.xlsx"
    own = write_sheets(japanese_words(path), tmp_path / "own.md")
    first, second = api.check(path), api.check(own)
    assert [(f.code, f.address and f.address.cell) for f in first.report] == [
        (f.code, f.address and f.address.cell) for f in second.report
    ]
    assert first.scene == second.scene
    assert [c.passed for c in api.test(path)[1].cases] == [c.passed for c in api.test(own)[1].cases]


@pytest.mark.slow
def test_a_run_of_a_workbook_in_japanese_leaves_the_same_trace(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    path = bundled("workbooks") / "simple-tracking.xlsx"
    own = write_sheets(japanese_words(path), tmp_path / "own.md")
    traces = []
    for book in (path, own):
        code, said = run("run", book, "--fast", "--for", "3s", "--out", tmp_path / f"out-{book.suffix}")
        assert code == 0, said
        lines = (tmp_path / f"out-{book.suffix}" / "trace.jsonl").read_text(encoding="utf-8").splitlines()
        traces.append([line for line in lines if json.loads(line).get("type") not in ("header", "summary")])
    assert len(traces[0]) > 20 and traces[0] == traces[1]


MOVES = """## ふるまい

| 入力ストリーム | コネクター | 式 | 出力ストリーム |
|---|---|---|---|
| 触る | map | IF(触る.zone = "Head"; "うなずく"; "手を振る") | 動き |
| 動き | subscribe | | 身ぶり |
| 身ぶり done | subscribe | "座位" | Posture |
| 触る | subscribe | "赤" | Eye LED color |
| 触る | subscribe | "手を振る" | Print |
{rows}
## デバイス

| ストリーム | デバイス | 名前 |
|---|---|---|
| 身ぶり | 身ぶり | |
| 触る | 接触 | |
| 踊り | 身ぶり | 拍手 |

## テスト

| 時間（ミリ秒） | ストリーム | 送信 | 期待 |
|---|---|---|---|
| 0 | 触る | zone="Head" | |
| 0 | 身ぶり | | うなずく |
| 0 | Eye LED color | | <> "青" |
| 0 | Print | | 手を振る |
| 100 | 触る | zone="Chest" | |
| 100 | 身ぶり | | value = "手を振る" |
| 200 | 身ぶり done | completed=TRUE | |
| 200 | Posture | | "座位" |

## シーン

| 時間（秒） | 対象 | 動作 | 値 |
|---|---|---|---|
| 0.2 | 子ども | 触る | 胸 |
"""


def moves(folder: Path, rows: str = "", more: str = "") -> Path:
    book = folder / "moves.md"
    book.write_text(MOVES.format(rows=rows) + more, encoding="utf-8")
    return book


def test_rows_send_gestures_postures_and_colours_by_their_japanese_names(tmp_path: Path) -> None:
    book = moves(tmp_path)
    assert [d.code for d in api.check(book).report] == []
    assert [c.passed for c in api.test(book)[1].cases] == [True]
    pack = pack_of(book, language="ja")
    assert pack.acts[0].parts == "頭と右腕" and pack.makes[0].words == ("うなずく", "手を振る")


def test_a_trace_has_the_names_of_the_robot_whatever_the_rows_say(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    api.run(moves(tmp_path), api.RunSettings(seconds=6.0, fast=True, film=False, out=tmp_path / "out"))
    lines = map(json.loads, (tmp_path / "out" / "trace.jsonl").read_text(encoding="utf-8").splitlines())
    sent = {line["stream"]: line["value"] for line in lines if line.get("row") and "value" in line}
    assert sent == {
        "ふるまい!動き": "手を振る", "身ぶり": "Wave", "Eye LED color": "red", "Print": "手を振る", "Posture": "Sit",
    }  # fmt: skip


@pytest.mark.parametrize(("typed", "proposed"), [("手をふる", "手を振る"), ("Wafe", "Wave")])
def test_a_misspelt_gesture_gets_the_right_one_proposed(tmp_path: Path, typed: str, proposed: str) -> None:
    checked = api.check(moves(tmp_path, f'| 触る | subscribe | "{typed}" | Gesture |\n'))
    found = next(iter(checked.report))
    assert found.code == "LINT012" and f"did you mean {proposed}?" in str(found.message)


@pytest.mark.parametrize(
    ("compared", "fixed"),
    [("身ぶりdone.値", "Wave"), ("身ぶりdone.value", "Wave"), ("身ぶりdone.完了 and 身ぶりdone.値", "Wave")],
)
@pytest.mark.parametrize("connector", ["filter", "accumulate"])
def test_a_japanese_gesture_that_a_done_stream_never_has_is_replaced(
    tmp_path: Path, compared: str, fixed: str, connector: str
) -> None:
    row = f"| 身ぶり done | {connector} " + '| {} = "{}" | 終わり |\n| 終わり | subscribe | | Print |\n'
    found = [d for d in api.check(moves(tmp_path, row.format(compared, "手を振る"))).report if d.code == "LINT005"]
    assert [d.fixes[0].edits[0].text for d in found] == [f'{compared} = "{fixed}"']
    assert f"own name, “{fixed}”" in str(found[0].message)
    right = api.check(moves(tmp_path, row.format(compared, fixed)))
    assert not [d for d in right.report if d.code == "LINT005"]


def test_marbles_tell_what_a_run_has_reported_in_japanese(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    book = moves(tmp_path, '| 触る | subscribe | "手をふる" | Gesture |\n')
    api.run(book, api.RunSettings(seconds=3.0, fast=True, film=False, out=tmp_path / "out"))
    drawn = repr(trace_scores(tmp_path / "out", "ja"))
    assert "という身ぶりはありません。「手を振る」のことですか。" in drawn and "there is no gesture" not in drawn


def test_a_comparison_shows_the_scene_and_tests_as_the_sheets_have_them(tmp_path: Path) -> None:
    before, after = moves(tmp_path), tmp_path / "after.md"
    text = before.read_text(encoding="utf-8").replace("| 触る | 胸 |", "| さわる | 頭 |")
    after.write_text(text.replace("| うなずく |\n", "| なし |\n"), encoding="utf-8")
    told = [
        (c.what, c.before, c.after, c.effect) for c in api.diff(before, after).changes if c.part in ("scene", "test")
    ]
    assert set(told) == {
        ("does", "触る", "さわる", False), ("value", "胸", "頭", True), ("expect", "うなずく", "なし", False),
    }  # fmt: skip


def test_a_japanese_print_of_an_english_workbook_has_only_its_own_words_in_english() -> None:
    pack = pack_of(bundled("workbooks", "greeter.xlsx"), language="ja")
    cells = [cell for sheet in pack.sheets for row in sheet.rows for cell in row]
    for shown in ("顔（Face）", "頻度（Rate）：2 Hz", "入ってくる", "位置 1.1, 0.15", "Mia"):
        assert shown in cells
    assert not {"enters", "leaves", "at 1.1, 0.15"} & set(cells)
    assert "「リスク」シート" in [field.where for field in pack.missing]


def test_a_gesture_without_quotes_is_put_into_them(tmp_path: Path) -> None:
    found = next(iter(api.check(moves(tmp_path, "| 触る | subscribe | 手を振る | Gesture |\n")).report))
    assert found.code == "FORM001" and found.fixes[0].edits[0].text == '"手を振る"'


def test_a_gesture_of_the_workbook_comes_before_the_robots_of_that_name(tmp_path: Path) -> None:
    own = "\n## 身ぶり\n| 名前 | 時刻（秒） | HeadYaw |\n|---|---|---|\n| 拍手 | 1 | 0.3 |\n"
    for more, name in (("", "Clap"), (own, "拍手")):
        checked = api.check(moves(tmp_path, "| 触る | subscribe | | 踊り |\n", more))
        assert checked.graph.streams["踊り"].settings["name"] == name
        assert checked.robot.standard("Gesture", "拍手") == name


FIELDS = """## ふるまい

| 入力ストリーム | コネクター | 式 | 出力ストリーム |
|---|---|---|---|
| ボール | filter | ボール.距離 < 0.5 | 近い |
| 近い | throttle | 5 s | 今 |
| 今 | map | IF(今.色 = "red"; "赤い"; "赤くない") | 言葉 |
| 言葉 | subscribe | | 発話 |
| 発話 done | filter | 発話done.完了 | 終わり |
| 終わり | subscribe | | Print |

## デバイス

| ストリーム | デバイス |
|---|---|
| ボール | ボール |
| 発話 | 発話 |

## テスト

| 時間（ミリ秒） | ストリーム | 送信 | 期待 |
|---|---|---|---|
| 0 | ボール | 色="green"; 距離=0.6 | |
| 50 | 近い | | なし |
| 100 | ボール | 色="green"; 距離=0.4 | |
| 100 | 近い | | 色="green"; distance=0.4 |
| 100 | 発話 | | 赤くない |
| 200 | 発話 done | 完了=FALSE | |
| 300 | Print | | なし |
"""


def test_formulas_and_tests_name_fields_in_japanese(tmp_path: Path) -> None:
    book = tmp_path / "fields.md"
    book.write_text(FIELDS, encoding="utf-8")
    assert [d.code for d in api.check(book).report] == []
    assert [c.passed for c in api.test(book)[1].cases] == [True]
    said = api.explain(book, language="ja")[0]
    assert "その距離が0.5 m未満" in said and "「完了」が真であるとき" in said
    analysis = no_analysis()
    assert [one["text"] for one in vocabulary(analysis, language="ja")["records"]["ball"]["fields"]][-2:] == [
        "距離",
        "色",
    ]
    english = vocabulary(analysis)["records"]["ball"]["fields"][-1]
    assert english["text"] == "colour" and "色" in english["words"].split()


TOUCHED = """## ふるまい

| 入力ストリーム | コネクター | 式 | 出力ストリーム |
|---|---|---|---|
| 接触 | filter | {} | 触れた |
| 触れた | subscribe | "はい" | 発話 |

## デバイス

| ストリーム | デバイス |
|---|---|
| 接触 | 接触 |
| 発話 | 発話 |

## テスト

| 時間（ミリ秒） | ストリーム | 送信 | 期待 |
|---|---|---|---|
| 0 | 接触 | 場所="頭" | |
| 0 | 触れた | | 場所="頭" |
| 0 | 発話 | | はい |
| 100 | 接触 | 場所=左足 | |
| 100 | 発話 | | なし |
| 200 | 接触 | 場所="頭" | |
| 200 | 触れた | | 触れた.場所 = "頭" |

## シーン

| 時間（秒） | 対象 | 動作 | 値 |
|---|---|---|---|
| 0.2 | 子ども | 触る | 左足 長さ 0.1秒 |
| 0.5 | 子ども | 触る | 頭 |
"""


@pytest.mark.parametrize(
    "formula",
    [
        '接触.場所 = "頭"', '"頭" == 接触.zone', '接触.場所 in ("頭", "胸") and 接触.触れている', '接触.場所 = "Head"',
        'NOT(value.場所 <> "頭")', 'SWITCH(接触.場所; "頭"; TRUE; "左足"; FALSE)', 'IF(接触.場所="左足"; FALSE; TRUE)',
    ],
)  # fmt: skip
def test_formulas_and_tests_compare_values_of_sensors_in_japanese(tmp_path: Path, formula: str) -> None:
    book = tmp_path / "touched.md"
    book.write_text(TOUCHED.format(formula), encoding="utf-8")
    assert [d.code for d in api.check(book).report] == []
    assert [c.passed for c in api.test(book)[1].cases] == [True]


def test_a_row_waits_for_a_touch_that_it_names_in_japanese(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    book = tmp_path / "touched.md"
    book.write_text(TOUCHED.format('接触.場所 = "頭"'), encoding="utf-8")
    api.run(book, api.RunSettings(seconds=1.0, fast=True, film=False, out=tmp_path / "out"))
    lines = map(json.loads, (tmp_path / "out" / "trace.jsonl").read_text(encoding="utf-8").splitlines())
    passed = [line["value"]["zone"] for line in lines if line.get("stream") == "ふるまい!触れた" and "value" in line]
    assert passed and set(passed) == {"Head"}


def test_a_touch_of_another_part_is_told_of_what_bumpers_and_the_chest_button_have(tmp_path: Path) -> None:
    book = tmp_path / "touched.md"
    rows = '| {} | merge | | 両方 |\n| 両方 | filter | 両方.場所 = "頭" | 触れた |'
    for streams, codes in (("バンパー, 胸ボタン", ["LINT005"]), ("バンパー, 接触", [])):
        text = TOUCHED.replace("| 接触 | filter | {} | 触れた |", rows.format(streams)).partition("## テスト")[0]
        text += "| バンパー | バンパー |\n| 胸ボタン | 胸のボタン |\n"
        book.write_text(text.replace("\n\n| バンパー |", "\n| バンパー |"), encoding="utf-8")
        assert [d.code for d in api.check(book).report if d.code == "LINT005"] == codes


SPEAKS = {
    "ja": "| 入力ストリーム | コネクター | 式 | 出力ストリーム |\n|---|---|---|---|\n| Chest button | subscribe | \"はい\" | Say |\n| Bumper | subscribe | | 歌 |",
    "en": "| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n| Chest button | subscribe | \"Yes\" | Say |\n| Bumper | subscribe | | 歌 |",
}  # fmt: skip
SINGS = {
    "ja": "| ストリーム | デバイス | 文 | 言語 |\n|---|---|---|---|\n| 歌 | 決まった発話 | ら | {} |",
    "en": "| Stream | Device | Text | Language |\n|---|---|---|---|\n| 歌 | Say parameter | La | {} |",
}


@pytest.mark.parametrize("cell", ["", "ja", "en"])
@pytest.mark.parametrize("headers", ["ja", "en"])
def test_the_robot_speaks_the_language_of_the_headers_unless_devices_names_another(
    tmp_path: Path, headers: str, cell: str
) -> None:
    book = tmp_path / "book.md"
    book.write_text(f"## T\n{SPEAKS[headers]}\n\n## Devices\n{SINGS[headers].format(cell)}\n", encoding="utf-8")
    streams = api.check(book).graph.streams
    assert (streams["say"].settings["language"], streams["歌"].settings["language"]) == (headers, cell or headers)
    protocol = "\n## Protocol\n| Field | Value |\n|---|---|\n| Language | Japanese |\n| Time limit | 10 s |\n"
    book.write_text(book.read_text(encoding="utf-8") + protocol, encoding="utf-8")
    assert api.check(book).graph.streams["say"].settings["language"] == headers  # that of explanations is another


def test_the_japanese_workbook_that_comes_along_speaks_japanese(tmp_path: Path) -> None:
    new = api.new(tmp_path / "new.xlsx", template="say-ball-colour-ja")
    for book in (new, bundled("workbooks") / "say-ball-colour-ja.xlsx"):
        spoken = [s.settings["language"] for s in api.check(book).graph.streams.values() if "language" in s.settings]
        assert spoken and set(spoken) == {"ja"}


def test_the_voice_that_is_heard_and_printed_is_japanese(tmp_path: Path) -> None:
    pytest.importorskip("pybullet")
    scene = "## シーン\n| 時間（秒） | 対象 | 動作 | 値 |\n|---|---|---|---|\n| 0.2 | 子ども | 触る | 胸 |\n"
    said = {}
    for language in ("", "ja", "en"):
        book = tmp_path / f"book{language}.md"
        devices = f"## デバイス\n| ストリーム | デバイス | 言語 |\n|---|---|---|\n| Say | 話す | {language} |\n"
        book.write_text(
            f"## T\n{SPEAKS['ja'].rpartition('|')[0].rpartition('| Bumper')[0]}\n{devices}\n{scene}", encoding="utf-8"
        )
        api.run(book, api.RunSettings(seconds=1.0, fast=True, film=False, out=tmp_path / f"out{language}"))
        said[language] = (tmp_path / f"out{language}" / "say-001.wav").read_bytes()
    assert said[""] == said["ja"] != said["en"]
    assert [line.voice.partition("、")[0] for line in pack_of(tmp_path / "book.md", language="ja").says] == ["日本語"]


# ---- the words
def test_every_word_is_its_own_key_and_none_means_itself() -> None:
    for words in TABLES:
        assert {w for w in words if key(w) != w and not w.startswith("ボタンを")} == set()
        assert not set(words) & set(words.values())


def test_the_words_are_those_of_the_robot() -> None:
    robot = load_robot()
    assert {d for d in japanese.DEVICES.values() if robot.find(d) is None} == set()
    assert {key(d.title) for d in robot.devices.values()} <= {key(d) for d in japanese.DEVICES.values()}
    settings = {s.name: s for d in robot.devices.values() for s in d.settings.values()}
    assert set(settings) == set(japanese.SETTINGS.values())
    for name, setting in settings.items():
        if setting.choices:
            assert set(setting.choices) == set(japanese.CHOICES[key(name)].values()), name
    assert set(japanese.ZONES.values()) == set(robot.touch_zones)
    assert set(japanese.MOVES.values()) == {*robot.postures, *robot.gestures}


def test_the_words_are_those_of_the_scene() -> None:
    things = {t for kind in KINDS.values() for t in kind.things}
    assert set(japanese.THINGS.values()) == things
    assert {japanese.standard_thing(own) for own in japanese.THINGS} == things
    assert all(kind_of(japanese.standard_thing(f"{colour}のボール2")) for colour in japanese.COLOURS)
    verbs = [verb for kind in KINDS.values() for verb in kind.verbs]
    assert {verb.name for verb in verbs} <= set(japanese.VERBS.values())
    assert {n for verb in verbs for n in (verb.name, *verb.also)} >= set(japanese.VERBS.values())


def test_the_words_are_those_of_the_protocol() -> None:
    for field in schema.FIELDS.values():
        assert field.synonyms and field.name_in("ja") == field.synonyms[0]
        assert field.name == "Run" or set(field.also.values()) <= set(field.words)
        assert not field.also or field.name == "Run" or set(field.also.values()) == set(field.words)


@pytest.mark.parametrize("kind", SHEETS.values(), ids=str)
def test_every_header_of_ours_has_a_japanese_one(kind: schema.SheetKind) -> None:
    assert [c.name for c in kind.columns if all(s.isascii() for s in c.synonyms)] == []
    assert kind.called


@pytest.mark.parametrize(
    ("own", "meant"),
    [
        ("位置 1, 0.2, 0.4", "at 1, 0.2, 0.4"), ("位置1,0.2,0.4 大きさ10センチ", "at 1,0.2,0.4 size 10 cm"),
        ("行き先 0.5, 0, 0.4 所要時間 2秒", "to 0.5, 0, 0.4 in 2 s"), ("左手 長さ 0.5 秒", "Left hand for 0.5 s"),
        ("後ろから そっと", "from behind gently"), ("位置 1, 0 座って 名前 さくら 番号 2", "at 1, 0 seated name さくら id 2"),
        ("位置 0.5, 0 テーブルの上", "at 0.5, 0 on table"), ("40 %", "40 %"), ("20 % 所要時間 3秒", "20 % in 3 s"),
        ("名前 位置子", "name 位置子"), ("半径 0.3 周期 4秒 中心 0.8, 0, 0.4 水平", "radius 0.3 period 4 s around 0.8, 0, 0.4 flat"),
    ],
)  # fmt: skip
def test_values_of_the_scene(own: str, meant: str) -> None:
    assert japanese.standard_value(own) == meant


# ---- new workbooks
@pytest.fixture(scope="module")
def new(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A new workbook in Japanese, which stays as it is."""
    return api.new(tmp_path_factory.mktemp("new") / "own.xlsx", language="ja")


@pytest.mark.parametrize("template", ["guided", "empty"])
def test_a_new_workbook_in_japanese_checks_and_explains_itself(tmp_path: Path, template: str) -> None:
    path = tmp_path / "実験.xlsx"
    code, said = run("new", path, "--language", "ja", "--template", template)
    assert code == 0 and "作りました" in said
    checked = api.check(path)
    assert checked.run.language == "ja"
    assert template == "empty" or [f.code for f in checked.report] == []
    book = openpyxl.load_workbook(path)
    assert not [name for name in book.sheetnames if name.isascii()]
    heads = [c.value for name in book.sheetnames for c in book[name][1] if c.value]
    assert [head for head in heads if head.isascii()] == []
    rules = [rule for sheet in book for rule in sheet.data_validations.dataValidation]
    assert len(rules) > 20 and not [r.prompt for r in rules if r.prompt and r.prompt.isascii()]
    assert [r.promptTitle for r in rules if r.promptTitle and r.promptTitle.isascii()] == []
    assert "赤いボール" in [cell.value for column in book["リスト"].columns for cell in column]


def test_a_new_workbook_in_japanese_says_what_the_english_one_does(new: Path, tmp_path: Path) -> None:
    assert [c.passed for c in api.test(new)[1].cases] == [True]
    first, second = api.check(new), api.check(api.new(tmp_path / "other.xlsx"))
    assert first.scene == second.scene and first.run.time_limit_us == second.run.time_limit_us
    assert [len(b.rows) for b in first.workbook.behaviours] == [len(b.rows) for b in second.workbook.behaviours]
    assert set(first.workbook.protocol.fields) == set(second.workbook.protocol.fields)
    assert "頭で追う" in run("explain", new)[1]


def test_devices_that_need_no_setting_are_used_by_their_japanese_names(tmp_path: Path) -> None:
    rows = [["赤いボール", "map", "赤いボール.距離", "距離"], ["距離", "filter", "距離 < 0.5", "近い"],
            ["近い", "map", '"近いです"', "言葉"], ["言葉", "throttle", "5 s", "一言"], ["一言", "subscribe", "", "発話"],
            ["発話 done", "filter", "発話done.完了", "話した"]]  # fmt: skip
    header = ["入力ストリーム", "コネクター", "式", "出力ストリーム"]
    book = make_workbook({"挨拶": [header, *rows]}, tmp_path / "挨拶.xlsx")
    checked = api.check(book)
    assert [d.code for d in checked.report] == ["GRAPH011"]  # nothing uses the last one
    assert {s.device.type.name for s in checked.graph.streams.values() if s.device} >= {"RedBall", "SayInput"}


@pytest.mark.parametrize("template", ["guided", "empty"])
def test_a_new_workbook_has_the_same_cells_in_both_languages(tmp_path: Path, template: str) -> None:
    books = [api.new(tmp_path / f"{lang}.xlsx", template=template, language=lang) for lang in ("en", "ja")]
    mine, other = ([*to_rows(read_sheets(book)).values()][:-1] for book in books)  # the last has the drop-downs
    assert [[[bool(cell) for cell in row] for row in sheet] for sheet in mine] == [
        [[bool(cell) for cell in row] for row in sheet] for sheet in other
    ]
    assert template == "guided" or [len(sheet) for sheet in other[:3]] == [1, 1, 1]


def test_the_language_of_the_computer_is_that_of_a_new_workbook(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("LC_ALL", "ja_JP.UTF-8")
    run("new", tmp_path / "a.xlsx")
    run("new", tmp_path / "b.xlsx", "--language", "en")
    assert [read(tmp_path / f"{name}.xlsx").workbook.behaviours[0].name for name in "ab"] == ["頭で追う", "Tracking"]


def test_conversion_keeps_the_headers_and_the_drop_downs_in_japanese(new: Path, tmp_path: Path) -> None:
    there = api.convert(new, tmp_path / "a.md")
    assert "リスト" not in there.read_text(encoding="utf-8").replace("「リスト」", "").replace(
        "ドロップダウンリスト", ""
    )
    back = api.convert(there, tmp_path / "b.xlsx")
    assert to_rows(read_sheets(back)) == to_rows(read_sheets(new))


def test_findings_name_headers_and_words_as_the_workbook_has_them(new: Path, tmp_path: Path) -> None:
    path = Path(shutil.copy(new, tmp_path))
    run("set", path, "デバイス!C3", "首")
    run("set", path, "シーン!C2", "飛ぶ")
    said = run("check", path)[1]
    assert "首" in said and "飛ぶ" in said
    run("set", path, "シーン!D3", "行き先 どこか")
    assert "「行き先 どこか」は「動く」に合いません" in run("check", path, "--language", "ja")[1]
    assert not re.search(r"\bMode\b", said)


MISSPELT = """## 追う
| 入力ストリーム | コネクター | 式 | 出力ストリーム |
|---|---|---|---|
| 球 | subscribe | | 頭 |

## デバイス
| ストリーム | デバイス | 動かしかた |
|---|---|---|
| 球 | 赤いボル | |
| 頭 | 追跡 | 頭 |

## シーン
| 時間（秒） | 対象 | 動作 | 値 |
|---|---|---|---|
| 1 | 赤いボル | 現れる | |
| 2 | 赤いボール | 現われる | |
"""


def test_a_misspelt_japanese_word_gets_the_right_one_proposed(tmp_path: Path) -> None:
    path = tmp_path / "m.md"
    path.write_text(MISSPELT, encoding="utf-8")
    found = {d.code: (d.address and d.address.cell, d.details.get("guess")) for d in api.check(path).report}
    assert found == {
        "DEV001": ("B2", "赤いボール"), "DEV007": ("C3", None), "SCENE002": ("B2", "赤いボール"), "SCENE003": ("C3", "現れる"),
    }  # fmt: skip
    assert "「動かし方」のことですか" in run("check", path, "--language", "ja")[1]


@pytest.mark.parametrize("kind", [*SHEETS, "table"])
def test_new_sheets_have_japanese_headers(kind: str) -> None:
    rows = beginning(kind, language="ja")
    joints = {j.name for j in load_robot().joints.values()}
    assert [head for head in rows[0] if head.isascii() and head not in joints] == []
    assert not schema.title_of(kind, "ja").isascii() and schema.title_of(kind, "en").isascii()
    if kind != "table":
        assert len(recognise(text_sheet(schema.title_of(kind, "ja"), rows)).columns) >= len(beginning(kind)[0]) - len(
            joints
        )


def test_remedies_show_words_that_the_sheets_take() -> None:
    for kind in KINDS.values():
        for verb in kind.verbs:
            assert japanese.standard(japanese.VERBS, translate(N_(verb.name, msgctxt="scene"), "ja")) == verb.name
            if verb.name not in ("says", "presses", "is seen") and verb.example:
                assert japanese.standard_value(translate(N_(verb.example, msgctxt="scene"), "ja")) == verb.example
            for part in verb.parts:
                for word in {part.word, *part.choices} & set(japanese.VALUE.values()):
                    assert japanese.standard_value(translate(N_(word, msgctxt="scene"), "ja")) == word
    settings = [s for d in load_robot().devices.values() for s in d.settings.values()]
    for setting in settings:
        for choice in setting.choices:
            shown = translate(N_(choice, msgctxt="value"), "ja")
            assert japanese.standard(japanese.CHOICES[key(setting.name)], shown) == choice


def test_a_japanese_workbook_is_offered_japanese_words() -> None:
    words = vocabulary(no_analysis(), ["stream", "device", "mode"], "ja")
    assert words["devices"][0]["text"] == "赤いボール" and words["sensors"][0]["adds"]["device"] == "赤いボール"
    assert [one["text"] for one in words["takes"]["追跡"]["mode"]["choices"]] == ["頭", "全身", "腕の動き"]
    assert vocabulary(no_analysis(), ["stream", "device"])["devices"][0]["text"] == "Red ball"


def test_words_that_are_offered_for_the_scene_tests_and_protocol_are_those_that_are_read() -> None:
    words = vocabulary(no_analysis(), ["stream", "device", "name", "zone"], "ja")
    offered = [one["text"] for name in ("things", "expects", "fields") for one in words[name]]
    offered += [verb for acts in words["acts"].values() for verb, _ in acts]
    assert {text for text in offered if text.isascii()} == {">0.5", "blank"}
    for kind, acts in words["acts"].items():
        for verb, (own, values) in zip(KINDS[kind].verbs, acts, strict=True):
            assert japanese.standard(japanese.VERBS, own) in (verb.name, "presses")
            for value, (text, _) in zip(values, verb.examples, strict=False):
                if key(verb.name) not in japanese.FREE and verb.name != "touches":
                    assert key(japanese.standard_value(value["text"])) == key(text)
    for thing in words["things"]:
        assert any(key(thing["text"]).endswith(word) for word in words["kinds"])
    assert [one["text"] for one in words["values"]["エンジン"]] == ["フレーム", "イベントループ"]
    chosen = {one["text"]: one["adds"] for one in words["choices"]}
    assert {"text": "手を振る", "words": "Wave"}.items() <= words["gestures"][0].items()
    assert [one["text"] for one in words["postures"]][:2] == ["立位", "標準の立位"]
    assert chosen["手を振る"] == {"device": "身ぶり", "settings": {"Name": "手を振る"}}
    assert chosen["頭への接触"] == {"device": "接触", "settings": {"Zone": "頭"}}


# ---- examples of the help
@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.slow)])
def test_examples_of_the_help_say_in_japanese_what_they_say_in_english(every: int) -> None:
    count = 0
    for file in files()[::every]:
        pairs = zip(page(file, "en").examples, page(file, "ja").examples, strict=True)
        for english, own in pairs:
            first, second = checked(english.source), checked(own.source)
            assert own.anchor == english.anchor
            assert [(d.code, d.address and d.address.cell, bool(d.fixes)) for d in first.report] == [
                (d.code, d.address and d.address.cell, bool(d.fixes)) for d in second.report
            ], own.source
            heads = [recognise(text_sheet(sheet.head, sheet.rows)) for sheet in own.parts]
            there = [(sheet, what) for sheet, what in zip(own.parts, heads, strict=True) if what.kind and not what.near]
            count += len(there)
            for sheet, what in there if file != "SHEET017.html" else ():  # whose rows are broken
                header = sheet.rows[what.row - 1]
                assert [header[at - 1] for at in what.columns.values() if header[at - 1].isascii()] == [], file
                notes = [row[what.columns["Notes"] - 1] for row in sheet.rows[what.row :] if "Notes" in what.columns]
                assert [note for note in notes if note and note.isascii()] == []
    assert count > 300 / every


@pytest.mark.parametrize("device", load_robot().devices.values(), ids=lambda device: device.name)
def test_examples_call_devices_as_the_japanese_grid_does_and_declare_them(device: DeviceType) -> None:
    sheets = sheets_of(in_language(device.example, "ja"))
    cells = {
        name for rows in sheets.values() for row in rows for cell in row for name in re.split(r", *|(?= done)", cell)
    }
    assert cells & set(japanese.DEVICES.values()) == set()
    declared = {row[0] for row in sheets["デバイス"][1:]}
    used = {cell for row in next(iter(sheets.values()))[1:] for cell in (row[0], row[-1])} & set(japanese.DEVICES)
    assert used <= declared and checked(in_language(device.example, "ja")).graph.streams


def test_the_page_on_the_scene_shows_the_words_of_the_language() -> None:
    shown = as_text(text_on("scene", language="ja"), "ja")
    assert all(word in shown for word in ("現れる", "位置 1, 0.2, 0.4", "声 女性", "紫", "左足"))
    assert not re.search(r"appears|Red ball|Left|\bat 1", shown)


@pytest.mark.parametrize(("device", "name"), [("gesture", "手を振る"), ("POSTURE", "立位"), ("身ぶり", "手を振る")])
def test_a_device_has_a_japanese_name_of_a_movement_however_it_is_spelt(tmp_path: Path, device: str, name: str) -> None:
    more = f"\n## Devices\n| Stream | Device | Name |\n|---|---|---|\n| W | {device} | {name} |\n"
    book = tmp_path / "spelt.md"
    book.write_text(
        f"## B\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n| Touch | subscribe | | W |\n{more}",
        encoding="utf-8",
    )
    assert [d.code for d in api.check(book).report] == []
