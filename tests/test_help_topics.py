"""`rrp-sheets help`: every topic and every name. What it shows is true, because it is run."""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

import pytest
from click.testing import CliRunner
from PIL import Image
from play import check, example, play, rows

from rrp_sheets import api, help
from rrp_sheets.cli.help import help_command
from rrp_sheets.cli.main import group
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas import FormulaProblem, compile_formula, make_scope
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.formulas.functions import library
from rrp_sheets.help.as_text import as_text
from rrp_sheets.help.connectors import IN_USE, marbles, one_connector, workbook
from rrp_sheets.help.devices import DONE_EXAMPLE
from rrp_sheets.help.functions import examples, literal_text
from rrp_sheets.help.layout import checked
from rrp_sheets.help.scene_page import EXAMPLE, TIMES
from rrp_sheets.help.topics import EXAMPLES, TOPICS, all_names, english, text_on
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.values import Failure
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_words import KINDS
from rrp_sheets.web.analysis import no_analysis
from rrp_sheets.web.completions import vocabulary
from rrp_sheets.workbook.schema import FIELDS

WIDEST = 100
FILES = Path(help.__file__).parent
FUNCTIONS = {function.name: function for function in library()}
CONNECTORS = {connector.name: connector for connector in connectors()}
DEVICES = sorted({found.name for found in load_robot().names.values()})


def help_on(*topic: str) -> str:
    done = CliRunner().invoke(help_command, topic)
    assert done.exit_code == 0, done.exception
    return done.output


DONES = [f"{found.name} done" for found in load_robot().names.values() if found.type.kind == "actuator"]


def test_every_topic_and_every_name_reads_well():
    for topic in ("", *TOPICS, *DONES, *CONNECTORS, *FUNCTIONS, *DEVICES, *CODES):
        text = help_on(*topic.split())
        assert len(text) > 60 and max(map(len, text.split("\n"))) <= WIDEST, topic
        assert not re.search(r"\n\n\n|[ \t]\n|>>>|{\w+}", text.replace("{colour}", "")), topic


def test_codes_stand_under_what_they_are_about():
    titles = [line for line in help_on("codes").splitlines() if line and not line.startswith(" ")]
    assert "Gestures" in titles and not any(line.isupper() for line in titles)


@pytest.mark.parametrize("topic", ["", "formulas", "tests", "sample", "CLAMP", "FORM007", "scene"])
def test_pages_as_people_see_them(topic, golden):
    golden(f"help-{topic or 'overview'}.txt", help_on(topic))


@pytest.mark.parametrize(
    "field", [field for field in FIELDS.values() if field.closed and field.choices], ids=lambda f: f.name
)
def test_the_help_of_the_protocol_names_the_words_that_a_field_takes(field):
    lines = (FILES / "protocol.md").read_text(encoding="utf-8").splitlines()
    (line,) = [line for line in lines if line.startswith(f"* {field.name} | ")]
    named = line.partition(" | ")[2].partition(";")[0].rpartition(": ")[2]
    assert all(word in named for word in field.words)
    for word in re.split(",? or ", re.sub(r" \(.*\)", "", named)):
        table = f"## Protocol\n| Field | Value |\n|---|---|\n| {field.name} | {word} |"
        assert not check(rows("| Red ball | subscribe | | Print |", table)).report.errors, word


def test_the_readme_names_topics_that_there_are():
    readme = (FILES.parents[1] / "README.md").read_text(encoding="utf-8")
    table = readme.partition("| Topic | What it is about |")[2].partition("\n\n")[0]
    named = [line.split(" | ")[0] for line in table.splitlines()[2:]]
    topics = [re.findall(r"\[(\w+)\]\(rrp_sheets/help/\1\.md\)|`(\w+)`", cell) for cell in named]
    found = [linked or bare for cell in topics for linked, bare in cell]
    assert set(found) <= TOPICS.keys() and len(found) > 15
    linked = re.findall(r"\((rrp_sheets/[^)]+)\)", readme)
    assert linked and all((FILES.parents[1] / path).is_file() for path in linked)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("word", "topic"),
    [("sensors", "devices"), ("actuators", "devices"), ("operators", "connectors"), ("Formula", "formulas"),
     ("warnings", "codes"), ("combine latest", "combineLatest"), ("distinctUntilChanged", "changes"),
     ("Helpers", "helper"), ("PRIORITY", "priority"), ("say_done", "Say done"),
     ("red_ball", "Red ball"), ("clamp", "CLAMP"), ("form007", "FORM007"), ("help", "")],
)  # fmt: skip
def test_other_words_for_a_topic(word, topic):
    assert help_on(word) == help_on(topic)


@pytest.mark.parametrize(
    ("typo", "meant"),
    [
        ("clmp", "CLAMP"),
        ("sampel", "sample"),
        ("Red bal", "Red ball"),
        ("conectors", "connectors"),
        ("FORM999", "FORM"),
        ("Sayy done", "Say done"),
        ("protokol", "protocol"),
    ],
)
def test_an_unknown_topic_proposes_the_nearest(typo, meant):
    done = CliRunner().invoke(help_command, [typo])
    assert isinstance(done.exception, SheetsError) and f"Did you mean {meant}" in done.exception.remedy


# ---- plain words
QUERIES = {
    "en": [
        ("nod", "Gesture"), ("wave", "Gesture"), ("bow", "Gesture"), ("say", "Say"), ("speak", "Say"), ("talk", "Say"),
        ("wait", "Wait|delay"), ("pause", "Wait|delay"), ("repeat", "Timer"), ("again", "Timer"),
        ("every second", "Timer"), ("clock", "Timer"), ("touch", "Touch"), ("hand", "Touch"), ("pat its head", "Touch"),
        ("ball", "Ball"), ("toy", "Ball"), ("face", "Face"), ("child", "Face"), ("eye contact", "Face"),
        ("colour", "Blob|Eye LED color"), ("light", "Eye LED color"), ("eyes", "Eye color|Eye LED color"),
        ("blink", "Eye brightness"), ("stop", "End run"), ("end the run", "End run"), ("finish", "End run"),
        ("start", "Timer|Operator button"), ("begin", "Timer"), ("when the run begins", "Timer"),
        ("start of the run", "Timer"), ("random", "PICK|protocol"), ("count", "accumulate|COUNT"),
        ("how many times", "accumulate|count"), ("remember", "Remember face"), ("remember a face", "Remember face"),
        ("timer", "Timer"), ("print", "Print|ethics"), ("compare", "compare"),
        ("difference between two workbooks", "compare"), ("undo", "keys"), ("redo", "keys"), ("rename", "keys|serve"),
        ("copy", "keys"), ("paste", "keys"), ("record", "recordings"), ("film", "recordings"), ("share", "serve|bundles"),
        ("password", "serve"), ("headset", "Word recognized"), ("microphone", "Word recognized"),
        ("hear", "Word recognized"), ("music", "Play sound"), ("walk", "Walk"), ("sit", "Posture"),
        ("follow", "Tracker|Head tracker"), ("look at", "Tracker|Face"), ("button", "Operator button|Chest button"),
        ("distance", "Sonar|DISTANCE"), ("consent", "ethics"), ("delete a recording", "recordings"), ("test", "tests"),
        ("error", "codes"), ("only once", "once"), ("if", "filter|IF"), ("calculate", "map|formulas"),
        ("Excel", "sheets"), ("install", "systems"), ("stopping", "End run"), ("nodding", "Gesture"),
        ("raise the arm", "Gesture|Set joint position"), ("switch off", "Behaviour"),
        ("Gesture done", "Gesture done"), ("say done", "Say done"), ("Head tracker done", "Head tracker done"),
        ("wait 5 seconds", "Wait"), ("wait 5 seconds", "timeout"), ("ask a question", "Say"),
        ("answer", "Word recognized"), ("how long", "protocol|recordings"), ("add a column", "keys|sheets"),
    ],
    "ja": [
        ("うなずく", "Gesture"), ("うなずいて", "Gesture"), ("手を振る", "Gesture"), ("おじぎ", "Gesture"), ("話す", "Say"), ("言う", "Say"),
        ("待つ", "Wait|delay"), ("くり返す", "Timer"), ("繰り返す", "Timer"), ("毎秒", "Timer|sample"), ("触る", "Touch"),
        ("手", "Touch"), ("頭をなでる", "Touch"), ("ボール", "Ball|Red ball"), ("赤いボール", "Red ball"), ("顔", "Face"),
        ("目", "Eye LED color|Eye color"), ("色", "Blob|Eye LED color|Eye color"), ("止める", "End run"), ("終わる", "End run"),
        ("始める", "Timer|Operator button"), ("開始", "Timer|Operator button"), ("実行の開始", "Timer|serve"),
        ("乱数", "PICK|protocol"), ("数える", "accumulate"), ("覚える", "Remember face"), ("タイマー", "Timer"), ("印刷", "ethics"),
        ("比べる", "compare"), ("比較", "compare"), ("元に戻す", "keys"), ("名前を変える", "keys|serve"), ("コピー", "keys"),
        ("記録", "recordings|Print"), ("録画", "recordings"), ("共有", "serve|bundles"), ("パスワード", "serve"),
        ("マイク", "Word recognized"), ("聞く", "Word recognized"), ("音楽", "Play sound"), ("歩く", "Walk"), ("座る", "Posture"),
        ("見る", "Tracker|Head tracker"), ("ボタン", "Operator button"), ("同意", "ethics"), ("テスト", "tests"), ("エラー", "codes"),
        ("計算", "map|formulas"), ("条件", "filter"), ("優先度", "priority"), ("ダンス", "Gesture"), ("拍手", "Gesture"),
        ("用語", "glossary"), ("Gesture done", "Gesture done"), ("5秒待つ", "Wait"), ("5秒待つ", "timeout"), ("質問する", "Say"),
        ("長さ", "protocol|recordings"), ("列を追加", "keys|sheets"),
    ],
}  # fmt: skip
"""Queries by language; at least one of the pages beside each must be among the first three hits."""
ASKED = [(query, pages, language) for language, table in QUERIES.items() for query, pages in table]


@pytest.mark.parametrize(("query", "pages", "language"), ASKED)
def test_plain_words_lead_to_the_page_that_is_meant(query, pages, language):
    answer = CliRunner().invoke(group, ["help", *query.split(), "--language", language])
    assert answer.exit_code == 0, answer.exception
    listed = re.findall(r"^  (\S.*?)(?:  |$)", answer.output, re.M)[:3]
    shown = answer.output.partition("There is a command")[0].rstrip()
    for page in pages.split("|"):
        whole = CliRunner().invoke(group, ["help", *page.split(), "--language", language]).output
        if page in map(english, listed) or whole.startswith(shown):
            return
    raise AssertionError(answer.output)


def test_the_grid_offers_by_the_same_words():
    words = vocabulary(no_analysis())
    offered = {one["text"]: one["words"] for kind in ("sensors", "actuators", "connectors") for one in words[kind]}
    names = [entry for entry in all_names() if entry.what in ("sensor", "actuator", "connector") and entry.words]
    assert len(names) > 40
    assert {entry.name: " ".join(entry.words) for entry in names}.items() <= offered.items()


def test_a_command_is_explained_where_there_is_no_other_help_of_that_name():
    told = CliRunner().invoke(group, ["help", "replay"])
    assert told.exit_code == 0 and told.output.startswith("Usage:") and "replay [OPTIONS] TRACE" in told.output
    assert CliRunner().invoke(group, ["help", "test"]).output.endswith("a command test too: rrp-sheets test --help\n")
    assert "Did you mean replay?" in str(CliRunner().invoke(group, ["help", "replya"]).exception)


def test_a_name_that_means_two_things_shows_both():
    both = [name for name in FUNCTIONS if load_robot().find(name) or connectors().get(name)]
    for name in both:
        assert help_on(name).count("\n---") >= 2


# ---- what is shown is true


def value_of(formula: str, **inputs: object) -> object:
    scope = make_scope([(name, None) for name in inputs])
    return compile_formula(formula, scope).prepare(GuardedInterpreter())(*inputs.values())


def test_every_function_has_examples_and_they_are_right():
    for name, function in FUNCTIONS.items():
        shown = examples(function)
        assert shown, name
        for formula, result in shown:
            assert formula.isascii() or '"' in formula, formula
            assert literal_text(value_of(formula)) == result, formula


def table(name: str, heading: str) -> list[list[str]]:
    """The rows of the list below a heading of a topic's file."""
    text = (FILES / f"{name}.md").read_text(encoding="utf-8").partition(f"# {heading}\n")[2].partition("\n# ")[0]
    return [re.split(r" +\| +", line[2:].removesuffix(" |")) for line in text.split("\n") if re.match(r"\* |\| ", line)]


@pytest.mark.slow
@pytest.mark.parametrize("line", table("formulas", "Two ways of writing")[1:], ids=lambda line: line[0])
def test_both_spellings_mean_the_same(line):
    inputs = {"distance": 1.5, "colour": "red"}
    first, second = value_of(line[0], **inputs), value_of(line[1], **inputs)
    assert first == second and not isinstance(first, Failure)


@pytest.mark.parametrize("line", table("formulas", "What is refused, because it can be read in two ways"))
def test_what_the_page_says_is_refused_is_refused(line):
    with pytest.raises(FormulaProblem):
        value_of(line[0], x=2.0)


def test_the_example_of_a_test_sheet_holds(tmp_path):
    (found,) = [block for block in text_on("tests") if block.kind == "example"]
    (tmp_path / "book.md").write_text(found.source, encoding="utf-8")
    seen, report = api.test(tmp_path / "book.md")
    assert seen.report.flatten(["code", "cell"]) == [] and report is not None and report.passed


def test_the_scene_page_shows_what_the_scene_understands(tmp_path):
    book = tmp_path / "book.md"
    Image.new("RGB", (64, 64)).save(tmp_path / "anna.png")
    buttons = "\n## Devices\n| Stream | Device | Label |\n|---|---|---|\n| Go | Operator button | Start |\n"
    head = "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n"
    body = rows('| Go | subscribe | | Print |\n| Go | map | "Hello" | Hi |\n| Hi | subscribe | | Say |', buttons, head)
    text = help_on("scene")
    for kind in KINDS.values():
        thing = kind.things[0]
        lines = ["| 0 | Table | appears | |"] if kind.name != "table" else []
        for verb in kind.verbs:
            assert verb.name in text
            needs = verb.action in ("move", "circle", "disappear", "away", "look")
            for value, _ in verb.examples:
                lines += [f"| 1 | {thing} | {kind.verbs[0].name} | |"] * needs
                lines.append(f"| 1 | {thing} | {verb.name} | {value} |")
                lines += [f"| 2 | {thing} | disappears | |"] * (
                    verb.action == "appear" or (needs and verb.action != "disappear")
                )
                assert value.split(" size")[0] in text
        checked = "\n".join(
            line.replace("| 1 |", f"| {at} |").replace("| 2 |", f"| {at} |") for at, line in enumerate(lines)
        )
        book.write_text(body + checked, encoding="utf-8")
        assert api.check(book).report.flatten(["code", "cell", "message"]) == []
    for time, _ in TIMES:
        assert (
            check(f"{body}| 0 | Mia | says | hello |\n| {time} | Mia | says | hello |").report.flatten(["code"]) == []
        )
    shown = "\n".join(f"| {' | '.join(line[:4])} |" for line in EXAMPLE[1:])
    assert check(body + shown).report.flatten(["code", "cell"]) == []


@pytest.mark.parametrize("text", [DONE_EXAMPLE, *EXAMPLES.values()])
def test_the_examples_of_the_words_are_workbooks_in_order(text):
    assert check(text).report.flatten(["code", "cell", "message"]) == []


def test_a_done_stream_is_explained_with_its_fields_and_what_can_follow():
    text = help_on("Say", "done")
    assert all(field in text for field in ("value", "completed", "seconds"))
    start = example("OperatorButton", label="Start")
    said = DONE.make(value="Hello!", completed=True, seconds=0.5)
    came = play(DONE_EXAMPLE, [(1_000, "Start", start), (1_500, "Say done", said)])
    assert came["Say"] == [(1_000, "Hello!")] and came["Wait"] == [(1_500, "2 s")]
    assert came["Eye LED color"] == [(3_500, "red")]
    assert '"Say done"' in help_on("Say") and "done" not in help_on("Red", "ball")


@pytest.mark.parametrize("line", table("total", "total: what accumulate has added up so far"), ids=lambda x: x[0])
def test_what_the_page_on_total_shows_does_what_it_says(line):
    formula = "" if line[0] == "blank" else line[0]
    inputs = "Neck, Start" if "start" in formula else "Neck"
    book = rows(
        f"| {inputs} | accumulate | {formula} | N |\n| N | subscribe | | Print |",
        "\n## Devices\n| Stream | Device | Joint | Label |\n|---|---|---|---|\n"
        "| Neck | JointPosition | HeadYaw | |\n| Start | Operator button | | Start |\n",
    )
    came = play(book, [(100, "Neck", 2), (200, "Neck", 5), (300, "Neck", 3)]).values("N")
    assert came == {"total + value": [2, 7, 10], "MAX(total; value)": [2, 5, 5]}.get(formula, [1, 2, 3])
    if "start" in formula:
        events = [(100, "Neck", 2), (200, "Start", example("OperatorButton")), (300, "Neck", 3)]
        assert play(book, events).values("N") == [1, 0, 1]


def test_each_visitor_is_counted_once_as_the_help_of_once_shows():
    _, book = IN_USE["once"]
    assert check(book).report.flatten(["code", "cell", "message"]) == []
    faces = [(n * 100, "Face", example("Face", id=who)) for n, who in enumerate([1, 1, 2, 1, 3, 2])]
    assert play(book, faces).values("Visitors") == [1, 2, 3]
    assert "To count each visitor once" in help_on("once")


def test_a_time_of_a_setting_says_its_unit():
    assert "A number alone means seconds." in " ".join(help_on("Wait").split())


@pytest.mark.slow
@pytest.mark.parametrize("name", CONNECTORS)
def test_the_example_of_a_connector_is_a_workbook_in_order(name):
    assert not checked(workbook(CONNECTORS[name])).report.errors
    assert "As marbles" in as_text(one_connector(CONNECTORS[name]))


@pytest.mark.parametrize(
    "example", [(), ("no marbles",), ("---", "oops("), tuple("1-2" for _ in range(9)), ("----", "200 ms")]
)
def test_a_connector_of_somebody_else_may_have_an_odd_example(example):
    odd = replace(CONNECTORS["sample"], name="sample", example=example)
    assert "sample (connector)" in as_text(one_connector(odd))
    assert len(list(one_connector(odd))) >= 3


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("map", [("Input", "1---2-----3-"), ("Output", "10--20----30")]),
        ("filter", [("Input", "1-5--2-7"), ("Output", "--5----7")]),
        ("sample", [("Input", "1-2-3---4"), ("Output", "--2-3---4")]),
        ("merge", [("First", "1---2---"), ("Second", "--a---b-"), ("Output", "1-a-2-b-")]),
        ("timeout", [("First", "1---2------"), ("Second", "--a--------"), ("Output", "-------2---")]),
    ],
)
def test_marbles_come_from_a_run(name, expected):
    assert marbles(CONNECTORS[name]) == expected
