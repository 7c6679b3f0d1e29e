"""Explanations and diagrams in Japanese: nothing of them stays English but what people have typed."""

from __future__ import annotations

import re
import string
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from babel.messages.pofile import read_po
from click.testing import CliRunner

from rrp_sheets import api
from rrp_sheets.cli.main import group
from rrp_sheets.connectors import connectors
from rrp_sheets.errors import SheetsError
from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.layout import FILES
from rrp_sheets.help.topics import text_on
from rrp_sheets.model import japanese as words_of_sheets
from rrp_sheets.model.names import key as word_key
from rrp_sheets.render.diagram import draw_diagram, draw_legend
from rrp_sheets.render.sentences import explain, explain_text
from rrp_sheets.render.style import NAME_PT, PAGE, width
from rrp_sheets.render.texts import texts
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_words import KINDS
from rrp_sheets.services.printing import gather
from rrp_sheets.texts import LANGUAGES, LOCALE, LazyMessage, translate

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
UNITS = {"m", "rad", "cm", "Hz", "TRUE", "FALSE"}
HEAD = "| Input streams | Connector | Formula | Output stream | On |\n|---|---|---|---|---|\n"
GREETING = f"""## あいさつ

{HEAD}| 顔 | forgetAfter | 5 s | 来た人 | |
| 来た人 | filter | value.new | 新しい人 | |
| 新しい人 | subscribe | | こんにちは | |
| こんにちは done | filter | value.completed | 言い終わり | |
| Red ball | map | redBall.distance | 距離 | |
| 距離 | filter | AND(距離 >= 0.5; 距離 < 2) | 近い | |
| 近い | subscribe | | Head tracker | |
| 近い | map | IF(距離 < 1; "近い"; "遠い") | 言葉 | FALSE |

## Devices

| Stream | Device | Text |
|---|---|---|
| 顔 | Face | |
| こんにちは | Say parameter | こんにちは。Naoです。 |

## Protocol

| Field | Value |
|---|---|
| Title | あいさつの練習 |
| Language | 日本語 |
"""


@pytest.fixture(scope="module")
def greeting(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("books") / "挨拶.md"
    path.write_text(GREETING, encoding="utf-8")
    return path


def places(text: str) -> set[str]:
    return {name for _, name, _, _ in string.Formatter().parse(text) if name}


def test_every_language_has_the_entries_of_english_with_the_same_places() -> None:
    english = texts("en").entries
    for language in LANGUAGES:
        other = texts(language).entries
        assert sorted(other) == sorted(english)
        lower = {
            name: ({p.lower() for p in places(english[name])}, {p.lower() for p in places(other[name])})
            for name in other
        }
        assert {name: pair for name, pair in lower.items() if pair[0] != pair[1]} == {}


def test_the_japanese_words_hold_no_english_ones() -> None:
    allowed = {"Esc", "Ctrl", "RRP", "Sheets", "Protocol", "SHA", "NAO", "kg", *UNITS, *(c.name for c in connectors())}
    found = {}
    for name, text in texts("ja").entries.items():
        words = set(
            re.findall(r"[A-Za-z]{2,}", re.sub(r"\{\w+\}|`[^`]*`|「[^」]*」|（[\w .*/{}-]+）|[\w/-]+\.\w+", "", text))
        )
        if words - allowed:
            found[name] = words - allowed
    assert found == {}


def test_a_language_that_there_is_not() -> None:
    with pytest.raises(SheetsError, match="language “xx”"):
        texts("xx")


# ---- the devices' words ----


def test_every_device_of_nao_has_its_japanese_words() -> None:
    for device in load_robot("nao").devices.values():
        english, japanese = device.words("en"), device.words("ja")
        assert japanese.title and japanese.help != english.help, device.name
        assert japanese.says != english.says or re.fullmatch(r"\{\w+\}", english.says), device.name
        assert {c.split(": ")[0] for c in english.says.split(" | ")[:-1]} == {
            c.split(": ")[0] for c in japanese.says.split(" | ")[:-1]
        }, device.name
        assert places(japanese.says) == places(english.says), device.name
        for part in ("stops", "says_given", "given", "says_fixed", "says_value", "when"):
            here, there = getattr(english, part), getattr(japanese, part)
            assert (not here or there != here) and places(there) == places(here), (device.name, part)
        assert device.kind == "sensor" or (japanese.takes and japanese.takes != english.takes), device.name
        for key, (name, about) in japanese.fields.items():
            assert device.payload and device.payload.keys.get(word_key(name)) == key  # that formulas read it
            assert name != english.fields[key][0] and about != english.fields[key][1], (device.name, key)


def test_choices_colours_postures_and_gestures_have_japanese_names() -> None:
    robot = load_robot("nao")
    words = robot.devices["gesture"].words("ja")
    assert [n for n in (*robot.postures, *robot.gestures) if words.name(n) == n] == []
    choices = {c for d in robot.devices.values() for s in d.settings.values() for c in s.choices}
    settings = {s.name for d in robot.devices.values() for s in d.settings.values()}
    assert [s for s in sorted(settings) if words.setting(s) == s] == []
    assert [c for c in sorted({*choices, *robot.touch_zones}) if words.value(c) == c] == []


def test_what_a_robot_of_ones_own_says_is_translated_as_far_as_it_is_the_program_s() -> None:
    ball = load_robot("nao").devices["redball"]
    own = replace(ball, help="A ball.", says="the robot sees our ball").words("ja")
    assert (own.title, own.help, own.says) == ("赤いボール", "A ball.", "the robot sees our ball")
    assert own.value("red") == "赤" and own.value("our red") == "our red" and own.said("red", "text") == "red"


def test_words_of_devices_settings_and_scene_are_those_that_sheets_take() -> None:
    robot = load_robot("nao")

    def shown(text: str, context: str) -> str:
        return translate(LazyMessage(text, msgctxt=context), "ja")

    def word(table: Mapping[str, str], text: str) -> str:
        return words_of_sheets.japanese(table, [text])[0]

    pairs = []
    for device in robot.devices.values():
        pairs.append((shown(device.title, f"{device.name}.title"), word(words_of_sheets.DEVICES, device.title)))
        for setting in device.settings.values():
            own = word(words_of_sheets.SETTINGS, setting.name)
            pairs.append((shown(setting.name, "setting"), f"{setting.name}（{own}）"))
            known = words_of_sheets.CHOICES.get(setting.name.lower(), {})
            pairs += [(shown(choice, "value"), word(known, choice)) for choice in setting.choices]
    for kind in KINDS.values():
        pairs.append((shown(kind.name, "scene"), words_of_sheets.japanese_thing(kind.name)))
        pairs += [(shown(verb.name, "scene"), word(words_of_sheets.VERBS, verb.name)) for verb in kind.verbs]
    assert [pair for pair in pairs if pair[0] != pair[1] and not pair[1].isascii()] == []


# ---- one word for one term ----

NOT_USED = {
    "check": "チェック|検査", "event": "イベント(?!ループ)", "record": "レコード", "field": "フィールド", "formula": "(?<!配列)数式",
    "helper": "ヘルパー", "gesture": "ジェスチャー", "operator": "オペレーター", "participant": "被験者", "pilot": "パイロット",
    "seed": "シード", "behaviour": "振る舞い", "blank": "空欄|空白のセル", "device": "装置", "priority": "優先順位", "test": "試験",
    "replay": "リプレイ", "connector": "コネクタ(?!ー)", "actuator": "アクチュエータ(?!ー)|装置", "sensor": "センサ(?!ー)",
    "folder": "フォルダ(?!ー)", "server": "サーバ(?!ー)", "browser": "ブラウザ(?!ー)", "board": "(?<!審査)倫理委員会",
    "notes": "注記", "cop(y|ies)": "写し(?!た)|写さ|別の複製|以前の複製", "archive": "保管", "word": "単語", "cancel": "取り消しました",
    "table": "机", "light": "明かり", "cup": "カップ", "quote": "文字列",
}  # fmt: skip
"""English terms, each with words that its translations must not have: the glossary and the texts say it with another."""


def translations() -> Iterator[tuple[str, str]]:
    """The English texts with their Japanese ones: both catalogues, and the topics of the help."""
    for path in (LOCALE / "ja" / "LC_MESSAGES").glob("*.po"):
        with path.open("rb") as file:
            for message in read_po(file):
                one, own = message.id, message.string
                yield from [(one, own)] if isinstance(one, str) else zip(one, (own[0], own[-1]), strict=True)
    for path in FILES.glob("*.md"):
        english, own = path.read_text(encoding="utf-8"), (FILES / "ja" / path.name).read_text(encoding="utf-8")
        yield from zip(english.split("\n"), own.split("\n"), strict=True)


def test_a_term_has_one_japanese_word() -> None:
    terms = {term: (re.compile(rf"\b{term}", re.IGNORECASE), re.compile(other)) for term, other in NOT_USED.items()}
    found = [
        (term, own)
        for english, own in translations()
        for term, (wanted, other) in terms.items()
        if wanted.search(english) and other.search(own)
    ]
    assert found == []


def test_the_words_of_the_glossary_are_those_of_the_texts() -> None:
    glossary = (FILES / "ja" / "glossary.md").read_text(encoding="utf-8")
    entries = re.findall(r"^\* ([^（|]+)（([a-z ]+)） \|", glossary, re.MULTILINE)
    texts_of = list(translations())
    assert len(entries) > 30
    for own, term in entries:
        assert not re.search(NOT_USED.get(term, "^$"), own)
        said = [text for english, text in texts_of if re.search(rf"\b{term}s?\b", english, re.IGNORECASE)]
        stem = own.removesuffix("り")
        assert not said or sum(stem in text for text in said) * 3 > len(said), (term, own)


def test_the_help_names_devices_as_the_japanese_grid_does() -> None:
    """English names stand in brackets, in commands and in examples only; what is found by one is found by the other."""
    words = words_of_sheets.DEVICES
    own = {name: words_of_sheets.japanese(words, [name])[0] for name in words.values()}
    english = re.compile(rf"(?<![A-Za-z])(?:{'|'.join(sorted(own, key=len, reverse=True))})(?![A-Za-z])")
    said = [own for text, own in translations() if english.search(text) and own[:1] != "|"]
    said = [text for text in said if text != "Say done" and "_" not in text]  # of examples; on spellings of names
    bare = [re.sub(r"（(?:[^（）]|（[^（）]*）)*）|`[^`]*`", "", text) for text in said]
    assert len(bare) > 100 and [text for text in bare if english.search(text)] == []
    listed = as_text(text_on("devices", language="ja"), "ja")
    for device in load_robot().devices.values():
        name = own[device.title]
        page = as_text(text_on(device.title, language="ja"), "ja")
        assert page.startswith(f"{name}（{device.title}）（") and f"  {name}（{device.title}）" in listed
        assert as_text(text_on(name, language="ja"), "ja") == page
        if device.kind == "actuator":
            done = [as_text(text_on(f"{one} done", language="ja"), "ja") for one in (device.title, name)]
            assert done[0] == done[1] and done[0].startswith(f"{name} done（")


# ---- explanations ----


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKBOOKS)
def test_nothing_english_is_left_in_the_explanations(name: str) -> None:
    """All that is left in Latin letters are names, texts and formulas of the workbook, and names of the robot's joints."""
    checked = api.check(bundled("workbooks") / f"{name}.xlsx")
    said = explain_text(checked.graph, checked.workbook, language="ja")
    graph = checked.graph
    names = [s.name for s in graph.streams.values()] + [b.name for b in graph.behaviours]
    names += [*checked.robot.postures, *checked.robot.gestures, *(j.name for j in checked.robot.joints.values())]
    for stream in graph.streams.values():
        names += [str(word) for v in stream.settings.values() for word in (v if isinstance(v, tuple) else (v,)) if word]
    headings = {h for b in checked.workbook.behaviours for h in b.headings.values()}  # as the user typed them
    said = "\n".join(line for line in said.splitlines() if line.strip() not in headings)
    rest = re.sub(r"`[^`]*`|「[^」]*」|『[^』]*』", "＊", said)
    for text in sorted({n for n in names if n}, key=len)[::-1]:
        rest = rest.replace(text, "＊")
    assert set(re.findall(r"[A-Za-z]+", rest)) <= UNITS
    assert not re.search(r"[。、][。、]|ますます|[{}“”]|, ", rest)


def test_the_workbooks_in_japanese(golden) -> None:
    for name in ("simple-tracking", "greeter-with-memory", "follow-my-pointing"):
        checked = api.check(bundled("workbooks") / f"{name}.xlsx")
        golden(f"{name}.ja.txt", explain_text(checked.graph, checked.workbook, language="ja"))


def test_a_japanese_workbook_speaks_japanese_by_itself(greeting: Path) -> None:
    text, checked = api.explain(greeting)
    assert checked.run.language == "ja" and not checked.report.errors
    for sentence in (
        "「新しい人」が届くたびに、『こんにちは。Naoです。』と話します。", "「来た人」の「新しい顔」が真であるとき",
        "「こんにちは」が中断されずに終わったとき", "「距離」が0.5から2 mまでの間にあるとき", "赤いボールを頭で追います。",
        "無効：「近い」が届くたびに、`IF(距離 < 1; \"近い\"; \"遠い\")`で「言葉」を計算します。", "センサー：顔とRed ball（赤いボール）", "9行目は無効です。",
    ):  # fmt: skip
        assert sentence in text
    assert text.startswith("あいさつ\n========\n")
    assert api.explain(greeting, language="en")[0].count("When ") > 3


def test_lists_and_conditions_are_joined_as_in_japanese() -> None:
    ja = texts("ja")
    assert ja.listed(["甲"]) == "甲" and ja.listed(["甲", "乙"]) == "甲と乙"
    assert ja.listed(["甲", "乙", "丙"], "or") == "甲、乙または丙"
    assert ja.listed(["高い", "遠い"], "any") == "高い、または遠い"
    assert [ja.duration(us) for us in (500_000, 2_000_000, 60_000_000)] == ["500ミリ秒", "2秒", "1分"]


# ---- connectors of third parties ----


def test_a_connector_may_bring_its_sentence_in_other_languages(tmp_path: Path) -> None:
    (tmp_path / "w.md").write_text(f"## T\n{HEAD}| Head yaw | map | value | Yaw | |\n", encoding="utf-8")
    checked = api.check(tmp_path / "w.md")
    step = checked.graph.behaviours[0].steps[0]
    own = replace(
        step.connector, name="own", sentence="{Input} is turned.", sentences={"ja": "{input}を回し、{output}とします。"}
    )
    behaviour = replace(checked.graph.behaviours[0], steps=(replace(step, connector=own),))
    graph = replace(checked.graph, behaviours=(behaviour,))
    said = {language: explain(graph, checked.workbook, language=language)[0].rows[0].text for language in ("en", "ja")}
    assert said == {"en": "“Head yaw” is turned.", "ja": "「Head yaw」を回し、「Yaw」とします。"}


# ---- diagrams ----


def test_the_words_of_a_diagram_are_japanese(greeting: Path) -> None:
    checked = api.check(greeting)
    (page,) = draw_diagram(checked.graph, checked.graph.behaviours[0], problems={2: 1}, language="ja")
    for words in (
        "センサー 顔",
        "ストリーム 距離",
        "9行目、map：IF(",
        "、無効</title>",
        "、問題1</title>",
        ">無効</text>",
    ):
        assert words in page.svg
    assert "ふるまい「あいさつ」の図（2行目から9行目まで）" in page.alt and page.language == "ja"
    assert not re.search(r">(off|Row|Sensor)\b", page.svg)


@pytest.mark.slow
def test_parts_of_a_long_behaviour_refer_to_each_other_in_japanese(tmp_path: Path) -> None:
    rows = "".join(
        f"| Head yaw | map | headYaw * {n} | Yaw {n} | |\n| Yaw {n - 1 if n else 0} | subscribe | | Print | |\n"
        for n in range(15)
    )
    (tmp_path / "long.md").write_text(f"## T\n{HEAD}{rows}", encoding="utf-8")
    checked = api.check(tmp_path / "long.md")
    pages = draw_diagram(checked.graph, checked.graph.behaviours[0], language="ja")
    assert pages[0].caption == f"1 / {len(pages)}：2行目から{pages[0].rows[1]}行目まで"
    assert any("図2へ" in p.svg for p in pages) and any("図1から" in p.svg for p in pages)


def test_the_legend_fits_in_both_languages() -> None:
    for language in LANGUAGES:
        said = texts(language)
        legend, wide, _ = draw_legend(language)
        assert said.get("legend.title") in legend and wide == PAGE[0]
        for connector in dict.fromkeys(connectors()):
            about = translate(connector.legend_message(), language)
            meaning = said.get("legend.meaning", connector=connector.name, meaning=about)
            assert width(meaning, NAME_PT - 1) <= PAGE[0] / 2 - 26


# ---- commands ----


def test_the_commands_take_a_language(greeting: Path, tmp_path: Path) -> None:
    run = CliRunner().invoke
    assert "センサー" in (svg_of(run, greeting, tmp_path, []))
    assert "Sensor" in (svg_of(run, greeting, tmp_path, ["--language", "en"]))
    english = run(group, ["explain", "--language", "en", str(greeting)])
    assert english.exit_code == 0 and "When " in english.output
    refused = run(group, ["explain", "--language", "klingon", str(greeting)])
    assert refused.exit_code == 2 and "'en', 'ja'" in refused.output


def svg_of(run, path: Path, folder: Path, options: list[str]) -> str:
    target = folder / "d.svg"
    assert run(group, ["diagram", str(path), "-o", str(target), *options]).exit_code == 0
    return target.read_text(encoding="utf-8")


# ---- the ethics pack ----


@pytest.mark.slow
def test_nothing_of_the_programs_own_is_english_in_a_japanese_pack() -> None:
    """Names of the Protocol's fields and of settings stand as they are typed; so do what is said and the formulas."""
    found = gather(bundled("workbooks", "mixed-control.xlsx"), language="ja")
    pack = found.pack
    said = [pack.summary, pack.hand_note, pack.hand_title, pack.says_note, pack.tests_note, *pack.always]
    said += [x.text for x in (*pack.glance, *pack.cautions)] + [
        x.text for x in (*pack.kept, *pack.consent) if not x.stated
    ]
    said += [x.label for x in (*pack.glance, *pack.numbers, *pack.facts, *pack.kept, *pack.consent, *pack.cautions)]
    said += [f"{s.through} {s.notices} {s.values}" for s in pack.sensed] + [s.voice for s in pack.says]
    said += [f"{a.does} {a.parts} {a.speed}" for a in pack.acts] + [f"{s.who} {s.how}" for s in pack.stops]
    said += (
        [words for h in pack.hand for words in (h.starts, h.ends)]
        + [t.counted for t in pack.tests]
        + [r.part for r in pack.rivals]
    )
    robot = found.checked.robot
    names = sorted((*robot.postures, *robot.gestures, *(j.name for j in robot.joints.values())), key=len, reverse=True)
    rest = re.sub(
        r"「[^」]*」|『[^』]*』|[\w-]+\.(?:jsonl|xlsx|zip|gif|png|wav)|rrp-sheets [\w -]+", "", "\n".join(said)
    )
    for name in names:
        rest = rest.replace(name, "")
    assert set(re.findall(r"[A-Za-z]{2,}", rest)) <= {*UNITS, "Esc", "Ctrl", "Protocol", "runs", "SHA", "NAO"}
    assert "操作者が「Praise」" in pack.summary
    assert all(a.does.endswith("ます") for a in pack.acts)
