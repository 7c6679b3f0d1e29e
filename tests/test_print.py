"""The ethics pack: what a board reads about a workbook, as an accessible PDF."""

from __future__ import annotations

import dataclasses
import re
from itertools import pairwise
from pathlib import Path

import pytest
from packs import DAY, workbook
from pdftree import filled, read_pdf, tags, texts_of, unspaced

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.model.names import key
from rrp_sheets.render.pack import Pack, Print, make_pack
from rrp_sheets.render.pack.make import set_pack
from rrp_sheets.render.pack.model import Labelled
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot
from rrp_sheets.services.printing import gather, make
from rrp_sheets.sim.process import Spec

GOLDEN = Path(__file__).parent / "golden" / "print"
WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
VARIED = {"follow-my-pointing", "mixed-control", "say-ball-colour-ja"}
"""Those that have between them all that any of them has to print."""


def pack_of(path: Path, **options: object) -> Pack:
    """Printed protocol of a workbook, without its diagrams."""
    reading = api.read(path)
    checked = check_workbook(reading.workbook, reading.report)
    return make_pack(reading, checked, Print(path.name, DAY.isoformat(), "1.0"), drawn=False, **options)[0]


# ---- every workbook that comes along
def flat(value: object, path: str = "") -> list[str]:
    """The words of a pack, line by line; the rows and their sentences stand in the golden files of `explain`."""
    if isinstance(value, Labelled):
        return [f"{path}: {value.label}: {value.text}"]
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return [
            line
            for f in dataclasses.fields(value)
            if f.name not in ("sentences", "rows", "paragraph", "widths") or path == "rivals"
            for line in flat(getattr(value, f.name), f"{path}.{f.name}".lstrip("."))
        ]
    if isinstance(value, tuple):
        return [line for part in value for line in flat(part, path)]
    return [f"{path}: {value}"] if value not in ("", None, False, 0) else []


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=[pytest.mark.slow] * (name not in VARIED)) for name in WORKBOOKS]
)
def test_what_is_printed_of_every_workbook(name, request):
    pack = pack_of(bundled("workbooks", f"{name}.xlsx"))
    _, warnings = set_pack(pack, {})  # Typst refuses what is no PDF/UA
    assert not warnings, "its page numbers are wrong, or a font is missing"
    text = "\n".join(line for line in flat(pack) if not line.startswith("digest")) + "\n"
    golden = GOLDEN / f"{name}.txt"
    if request.config.getoption("--regenerate-golden"):
        golden.write_text(text, encoding="utf-8")
    assert text == golden.read_text(encoding="utf-8")


# ---- one of them as a PDF
@pytest.fixture(scope="module")
def printed():
    return make(bundled("workbooks", "complex-tracking.xlsx"), today=DAY)


@pytest.fixture(scope="module")
def pdf(printed):
    return read_pdf(printed.data)


@pytest.fixture(scope="module")
def pages(pdf):
    return texts_of(pdf)


@pytest.mark.slow
def test_every_page_has_its_number_and_the_hash(pages, printed):
    digest = api.read(bundled("workbooks", "complex-tracking.xlsx")).digest
    for number, text in enumerate(pages, 1):
        assert f"page {number} of {len(pages)}" in text
        assert digest[:16] in text
        assert "TRIED IN SIMULATION ONLY" in text
    assert digest in pages[0]
    assert printed.notes == []


def test_the_first_page_is_enough_for_a_reader_in_a_hurry(pages):
    for said in (
        "Complex tracking",
        "Printed 2026-11-21",
        "Compare it with that in a recording: run.xlsx, sheet About this run.",
        "The robot acts on these occasions: the robot sees a red ball",
        "What the robot says No row makes the robot speak.",
        "What the robot moves Head, left arm, right arm and legs. The arms include the hands.",
        "The check of the workbook has found 1 fault. See section 7.1.",
    ):
        assert said in re.sub(
            r" (\d+|\d+ of \d+) (?=behaviours|rows|sensor|actuator|texts|tests|problems)", r" \1 ", pages[0]
        )


def test_what_is_open_and_which_tests_fail_is_told(pages):
    text = " ".join(pages)
    assert "Add a row with forgetAfter for “Close ball”" in text
    assert re.search(r"Test old angle FAILS 1 of 3 values are not as expected", text)
    assert "got: -0.3 at 3000 ms" in text


def test_it_is_accessible(pdf, printed):
    root = pdf.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and root["/Lang"] == "en"
    assert root["/ViewerPreferences"]["/DisplayDocTitle"]
    assert pdf.metadata.title == "Complex tracking – Protocol for ethics review"
    assert b"pdfuaid" in root["/Metadata"].get_object().get_data()
    tree = tags(pdf)
    levels = [int(tag.name[1:]) for tag in tree.all("H1", "H2", "H3")]
    assert levels[0] == 1 and len(levels) > 15
    assert all(after <= before + 1 for before, after in pairwise(levels))
    figures = list(tree.all("Figure"))
    assert len(figures) == 2 and all(figure.alt for figure in figures)  # the legend and the diagram
    tables = list(tree.all("Table"))
    assert len(tables) > 5
    for table in tables:
        heads = list(table.all("TH"))
        assert heads and all(head.scope == "/Column" for head in heads)


@pytest.mark.parametrize("paper", ["a4", pytest.param("letter", marks=pytest.mark.slow)])
def test_hash_formulas_and_names_can_be_copied_and_searched(paper, tmp_path):
    long = "IF(NOT(ISBLANK(aVeryLongNameOfAStream)); 1; " * 8 + "0" + ")" * 8
    word = "x" * 90
    rows = (
        f"| Red ball | map | redBall.distance | {word} | |\n| {word} | map | {long} | Step | |\n"
        f'| Step | map | CONCATENATE("{word}";"{word}") | | |\n|  | subscribe | | Say | |\n'
        "| Red ball | filter | redBall.distance < 0.5 and redBall.distance > 0.25 | A_name_of.a-stream/with_signs | |\n"
    )
    helpers = (
        "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Far | ball | ballToDistance(ball.distance) > 2 |\n"
    )
    path = workbook(tmp_path, rows, rest=helpers, protocol=f"| {word} | {word} |")
    texts = [page.extract_text() for page in read_pdf(make(path, today=DAY, draft=True, paper=paper).data).pages]
    whole = "\n".join(texts)
    assert "\u200b" not in whole
    assert api.read(path).digest in texts[0]  # in one piece
    for row in api.read(path).workbook.behaviours[0].rows:
        for cell in (row.formula.text, row.output.text):
            assert unspaced(cell) in unspaced(whole)
    for in_one_piece in (
        "redBall.distance",
        "IF(NOT(ISBLANK(aVeryLongNameOfAStream));",
        "ballToDistance(ball.distance)",
    ):
        assert in_one_piece in whole
    assert not [line for line in whole.splitlines() if line.lstrip().startswith((";", ",", ")"))]


@pytest.mark.slow
def test_no_page_is_half_empty_or_turned_and_diagrams_stand_in_their_order():
    pages = read_pdf(make(bundled("workbooks", "mixed-control.xlsx"), today=DAY).data).pages
    signed = next(i for i, page in enumerate(pages) if "Responsible researcher" in page.extract_text())
    assert min(filled(page) for i, page in enumerate(pages[:-1]) if i != signed) > 0.6  # the annex has pages of its own
    assert {tuple(page.mediabox) for page in pages} == {tuple(pages[0].mediabox)}
    captions = re.findall(r"Operator, part (\d) of \d", "\n".join(page.extract_text() for page in pages))
    assert len(captions) > 3 and captions == sorted(captions)


def test_the_same_workbook_on_the_same_day_gives_the_same_bytes(printed):
    assert make(bundled("workbooks", "complex-tracking.xlsx"), today=DAY).data == printed.data


# ---- what it says about a workbook
def test_every_text_that_can_be_known_is_printed(tmp_path):
    rows = (
        '| Go | map | PICK(praise) & " It is " & LOWER(go.label) & "." | |\n|  | subscribe | | Say |\n'
        '| Face | map | "Hello, " & face.name & "!" | |\n|  | subscribe | | Say |\n'
        '| Go | map | IF(go.count > 3; "Enough."; BLANK) | |\n|  | subscribe | | Say |\n'
        "| Go | subscribe | | Hello |\n| Go | map | BLANK | |\n|  | subscribe | | Say |\n"
    )
    rest = (
        "## Devices\n| Stream | Device | Label | Text | Language |\n|---|---|---|---|---|\n| Go | OperatorButton | RED | | |\n"
        "| Hello | Say parameter | | Guten Tag | de |\n\n"
        '## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Praise | | ["Yes!"; "Good!"] |\n'
    )
    pack = pack_of(workbook(tmp_path, rows, rest=rest))
    assert [said.words for said in pack.says] == [
        ("Yes! It is red.", "Good! It is red."), ("Hello, ‹face.name›!",), ("Enough.",), ("Guten Tag",),
    ]  # fmt: skip
    assert "German" in pack.says[3].voice
    assert [g.text for g in pack.glance if g.label == "What the robot says"] == [
        "The robot can say 5 texts. Section 4 prints them. The run fills in parts of some texts."
    ]


def test_a_text_without_the_part_that_may_be_empty_is_printed_too(tmp_path):
    rows = '| Face | map | "Hello" & IF(face.name = ""; ""; ", " & face.name) & "!" | |\n|  | subscribe | | Say |\n'
    empty = '| Face | map | IF(face.name = ""; ""; "Hi") | |\n|  | subscribe | | Say |\n'
    said = pack_of(workbook(tmp_path, rows + empty)).says
    assert [s.words for s in said] == [("Hello!", "Hello, ‹face.name›!"), ("Hi",)]


def test_arms_that_move_while_it_talks_are_disclosed(tmp_path):
    rest = "## Devices\n| Stream | Device | Text | Gestures |\n|---|---|---|---|\n| Hi | Say parameter | Hi | yes |\n"
    pack = pack_of(workbook(tmp_path, "| Red ball | subscribe | | Hi | |\n", rest=rest))
    assert "the free arms make small gestures" in pack.says[0].voice
    assert [g.text for g in pack.glance if g.label == "What the robot moves"] == [
        "Left arm and right arm. The arms include the hands. Every run ends with a crouch."
    ]


def test_gestures_and_postures_are_listed_where_the_texts_are(tmp_path):
    rows = (
        '| Go | map | PICK(["Wave"; "Nod"]) | | |\n|  | subscribe | | Any | |\n| Go | subscribe | | Bow | |\n'
        "| Go | map | INDEX(Steps; go.count) | Step | |\n| Step | map | step.move | | |\n|  | subscribe | | Any | |\n"
        "| Go | map | go.label | | |\n|  | subscribe | | Any | |\n| Go | subscribe | | Sit | |\n"
        "| Go | subscribe | BLANK | Any | |\n"
    )
    rest = (
        "## Devices\n| Stream | Device | Label | Name |\n|---|---|---|---|\n| Go | OperatorButton | | |\n"
        "| Any | Gesture | | |\n| Bow | Gesture | | Bow |\n| Sit | Posture | | Sit |\n\n"
        "## Steps\n| Say | Move |\n|---|---|\n| One | Clap |\n| Two | Yes |\n"
    )
    pack = pack_of(workbook(tmp_path, rows, rest=rest))
    made = [(m.words, m.voice, m.used[0].rows) for m in pack.makes]
    assert made[:2] == [(("Wave", "Nod"), "Any", (3,)), (("Bow",), "Bow", (4,))]
    assert made[2] == (("Clap", "Yes"), "Any", (7,))
    assert made[3] == (("Go",), "Any", (9,)) or "‹" in made[3][0][0]
    assert made[4] == (("Sit",), "Sit", (10,)) and len(made) == 5
    assert "おじぎ（Bow）" in [
        w for m in pack_of(workbook(tmp_path, rows, rest=rest), language="ja").makes for w in m.words
    ]


MOVES = (
    "| Go | subscribe | | Bye | |\n| Go | subscribe | | Slow | |\n| Go | subscribe | | Rest | |\n| Go | subscribe | | Mine | |\n",
    "## Devices\n| Stream | Device | Name | Tempo | Times | Speed |\n|---|---|---|---|---|---|\n| Go | OperatorButton | | | | |\n"
    "| Bye | Gesture | Wave | | | |\n| Slow | Gesture | Wave | | 2 | |\n| Rest | Posture | Sit | | | 0.5 |\n| Mine | Gesture | Look | | | |\n\n"
    "## Gestures\n| Name | Time (s) | HeadYaw | LShoulderPitch |\n|---|---|---|---|\n| Look | 1 | 50° | 0° |\n| Look | 2 | -30° | 0° |\n",
)


def test_movements_are_drawn_and_described_in_words_that_people_can_judge(tmp_path):
    pytest.importorskip("pybullet")
    found = gather(workbook(tmp_path, MOVES[0], rest=MOVES[1]), today=DAY)
    assert [(m.name, len(m.poses)) for m in found.pack.movements] == [("Wave", 3), ("Wave", 3), ("Sit", 3), ("Look", 3)]
    wave, twice, sit, look = (m.text for m in found.pack.movements)
    assert "Waves with the raised right hand. Right arm raised up to 141°" in wave and "It takes about 4.1 s." in wave
    assert float(re.search(r"about ([\d.]+) s", twice)[1]) > 6 and "Knees bent up to 1" in sit.replace("knees", "Knees")
    assert (
        "Head turned up to 50° to the left, head turned up to 30° to the right" in look
        and "left arm raised up to 90°" in look
    )
    assert "gesture of this workbook" not in look
    drawings = [[found.pictures[file] for file in m.poses] for m in found.pack.movements]
    assert all(len(set(strip)) == len(strip) for strip in drawings)
    top = [min(int(y) for y in re.findall(r"[ M]\d+,(\d+)", svg)) for svg in (*drawings[0][:2], drawings[2][-1])]
    assert top[1] < top[0] < top[2], "a raised arm is above the head, and who sits is lower"
    figures = [f.alt for f in tags(read_pdf(set_pack(found.pack, found.pictures)[0])).all("Figure")]
    assert "Drawing 2 of 3 of the movement Wave" in figures


@pytest.mark.parametrize(("device", "name"), [("Gesture", "Wave"), ("Gesture", "Bow"), ("Posture", "Sit")])
def test_printed_length_of_a_movement_is_that_of_the_simulated_robot(tmp_path, device, name):
    world_module = pytest.importorskip("rrp_sheets.sim.world")
    rest = f"## Devices\n| Stream | Device | Name |\n|---|---|---|\n| Go | OperatorButton | |\n| Move | {device} | {name} |\n"
    (told,) = pack_of(workbook(tmp_path, "| Go | subscribe | | Move | |\n", rest=rest)).movements
    robot = load_robot()
    use = DeviceUse("m", name, device, robot.devices[key(device)].with_defaults({"name": name}))
    world = world_module.SimWorld(Spec(robot, actuators=(use,), dones={"m": "done"}))
    world.start()
    events, frame = [], 0
    while not events and frame < 300:
        frame += 1
        events = list(world.advance(frame * 33_333, [Command("m", True, "Play!2")] if frame == 1 else []).events)
    world.close()
    assert float(re.search(r"about ([\d.]+) s", told.text)[1]) == pytest.approx(events[0][1]["seconds"], abs=0.3)


@pytest.mark.slow
def test_the_programs_own_list_of_what_is_kept_stands_above_that_of_the_authors(tmp_path):
    rows = "| Red ball | subscribe | | Head tracker | |\n| Red ball | map | 'Hello' | | |\n|  | subscribe | | Say | |\n"
    pack = pack_of(workbook(tmp_path, rows, protocol="| Data kept | Every value; no picture is kept |"))
    kept = [(line.label, line.text) for line in pack.kept]
    everything = "Every value with its time, pictures of the robot's camera, a film of the robot and the sound of what the robot says"
    assert kept[0] == ("What a run saves", f"{everything}.")
    assert [label for label, _ in kept[-3:]] == ["Data kept", "The program saves more", "Not stated"]
    assert kept[-2][1] == (
        "The field Data kept does not name this, but a run also saves it: pictures of the robot's camera, a film of the robot and the sound of what the robot says."
    )
    assert [f.text for f in pack.findings if "Data kept" in f.text]
    whole = pack_of(workbook(tmp_path, rows, protocol=f"| Data kept | {everything} |"))
    assert "The program saves more" not in [line.label for line in whole.kept] and not [
        f for f in whole.findings if "Data kept" in f.text
    ]


def test_too_many_combinations_are_told_in_short(tmp_path):
    many = "; ".join(f'"{c}"' for c in "abcdefghij")
    rows = f'| Go | map | PICK([{many}]) & "-" & PICK([{many}]) | |\n|  | subscribe | | Say |\n'
    devices = "## Devices\n| Stream | Device |\n|---|---|\n| Go | OperatorButton |\n"
    words = pack_of(workbook(tmp_path, rows, rest=devices)).says[0].words
    assert len(words) == 10
    assert words[0] == "‹a | b | c | d | e | f | g | h | i | j›-a"


def test_faces_that_are_kept_are_disclosed(tmp_path):
    rows = "| Face | subscribe | | Remember face |\n"
    kept = {p: " ".join(line.text for line in pack_of(workbook(tmp_path, rows, protocol=p)).kept)
            for p in ("", "| Face memory | kept |")}  # fmt: skip
    assert "When the run ends, it deletes all faces" in kept[""]
    assert "runs/faces.json" in kept["| Face memory | kept |"]
    wiping = pack_of(workbook(tmp_path, rows, protocol="| Face memory | kept |")).consent
    assert any("by its name" in line.text for line in wiping)
    assert not any("rrp-sheets" in line.text for line in wiping), "commands stand in the annex"
    annex = pack_of(workbook(tmp_path, rows, protocol="| Face memory | kept |")).sheets[-1]
    assert [command for _, command in annex.rows] == [
        "rrp-sheets print WORKBOOK --for participants", "rrp-sheets runs delete --participant CODE",
        "rrp-sheets faces --forget NAME",
    ]  # fmt: skip


def test_what_leaves_the_computer_and_what_the_operator_can_change_is_disclosed(tmp_path):
    pack = pack_of(workbook(tmp_path, "| Red ball | map | redBall.distance | Distance | |\n"))
    told = " ".join(line.text for line in pack.kept)
    assert (
        "It sends nothing over the network, unless somebody starts it for several computers (rrp-sheets serve" in told
    )
    assert "the screen can show the picture of the simulated camera" in told
    assert any(line.startswith("change the formulas of rows") for line in pack.always)
    assert "The connection is not encrypted" in told and "from the joint angles" in told
    assert "A changed formula leaves this protocol" in pack.summary


def test_one_of_several_buttons_is_enough_and_a_face_is_followed(tmp_path):
    rows = "| Go, Stay | merge | | Both | |\n| Both | subscribe | | Hello | |\n| FaceDetection | subscribe | | Head tracker | |\n"
    rest = (
        "## Devices\n| Stream | Device | Text |\n|---|---|---|\n"
        "| Go | OperatorButton | |\n| Stay | OperatorButton | |\n| Hello | SayParameter | Hello |\n"
    )
    pack = pack_of(workbook(tmp_path, rows, rest=rest))
    assert [s.notices for s in pack.sensed] == ["the robot sees a face", "the operator presses “Go” or “Stay”"]
    assert "the operator presses “Go” or “Stay”" in pack.summary
    assert [a.does for a in pack.acts] == ["Follow the face with the head"]


@pytest.mark.parametrize(
    ("condition", "language", "acts"),
    [
        ("touch.pressed", "en", "on these occasions: somebody touches the robot. It may"),
        ("touch.pressed", "ja", "次の場合に動作します：だれかがロボットに触れるとき。"),
        ('touch.zone = "Head"', "en", "on these occasions: somebody touches the robot or lets go. It may"),
    ],
)
def test_robot_acts_on_what_triggers_rows_but_not_on_their_further_inputs(condition, language, acts, tmp_path):
    rows = (
        f"| Touch | filter | {condition} | Touched | |\n| Touched, Red ball | map | redBall.colour | | |\n"
        "| | subscribe | | Say | |\n| Face | map | face.name | Unread | |\n"
    )
    pack = pack_of(workbook(tmp_path, rows), language=language)
    assert acts in pack.summary


@pytest.mark.parametrize(
    ("rows", "begin"),
    [
        ("| Go, Level | map | level.count | N | |\n| N | subscribe | | Say | |\n",
         "The robot acts on these occasions: the operator presses “Go”. It may"),
        ("| Go | map | go.count | N | |\n", "No row controls an actuator"),
    ],
)  # fmt: skip
def test_summary_names_buttons_that_trigger_and_denies_no_reading_of_sensors(rows, begin, tmp_path):
    rest = "## Devices\n| Stream | Device |\n|---|---|\n| Go | OperatorButton |\n| Level | OperatorButton |\n"
    assert pack_of(workbook(tmp_path, rows, rest=rest)).summary.startswith(begin)


def test_buttons_stops_walking_and_rivals_are_disclosed(tmp_path):
    rows = (
        "| Go | subscribe | | There | 2 |\n| Go | merge | | Both | |\n| Both | subscribe | | Sit down | 1 |\n"
        "| Chest | subscribe | | Finish | |\n| Red ball | subscribe | | Head tracker | |\n"
    )
    rest = (
        "## Devices\n| Stream | Device | Label | Forward | Name | Speed |\n|---|---|---|---|---|---|\n"
        "| Go | OperatorButton | Start | | | |\n| There | Walk | | 0.5 | | |\n| Sit down | Posture | | | Sit | 0.2 |\n"
        "| Chest | Chest button | | | | |\n| Finish | End run | | | | |\n"
    )
    pack = pack_of(
        workbook(tmp_path, rows, rest=rest, protocol="| Time limit | 5 min |\n| Participants are told | Later |")
    )
    assert [(h.name, h.starts, h.ends) for h in pack.hand] == [("Start", "“There” and “Sit down”", "nothing")]
    assert [(c.label, c.text) for c in pack.operator] == [
        ("Participants are told", "Later"), ("Not stated", "Reason for concealment and Debriefing")
    ]  # fmt: skip
    speeds = {a.stream: a.speed for a in pack.acts}
    assert speeds["There"] == "at most 0.5 m forward, 0 m to the side and a turn of 0° at one command"
    assert speeds["Sit down"] == "95°/s (right shoulder; 20 % of what is possible)"
    assert "Yes, by “There”" in pack.cautions[0].text
    assert "“There” and “Sit down”" in pack.cautions[1].text
    legs = next(r for r in pack.rivals if r.part == "legs")
    assert [(priority, refs[0].rows) for priority, refs in legs.rows] == [("2", (2,)), ("1", (4,))]
    assert "after one of these actions has ended" in pack.hand_note
    ends = {s.who: s for s in pack.stops}
    assert ends["Rows of the workbook"].used[0].rows == (5,)
    assert ends["The chest button"].used[0].rows == (5,)
    assert "After 5 min" in ends["Time limit"].how


@pytest.mark.parametrize(
    ("name", "button", "starts", "ends"),
    [
        ("follow-my-pointing", "Enough", "“Goodbye”, “Wave” and “Gaze”", "“Ask”, “Hint”, “Cheer” and “Tell”"),
        ("attention-training", "Break", "“Break talk”", "“Ask”, “Show”, “Cheer” and “Comfort”"),
        ("touch-and-name", "Start", "“Welcome”", "“Welcome”, “Ask”, “Cheer” and “Help”"),
    ],
)
def test_buttons_start_only_what_their_own_values_reach(name, button, starts, ends):
    pack = pack_of(bundled("workbooks", f"{name}.xlsx"))
    assert [(h.starts, h.ends) for h in pack.hand if h.name == button] == [(starts, ends)]


def test_robot_that_gets_only_buttons_senses_nothing():
    pack = pack_of(bundled("workbooks", "attention-training.xlsx"))
    assert {g.label: g.text for g in pack.glance}["What the robot senses"].startswith("Nothing. It gets presses")
    assert "behaviour: 1" in [f"{n.label}: {n.text}" for n in pack.numbers]
    assert "sensors read: 0" in [f"{n.label}: {n.text}" for n in pack.numbers]
    assert "Child looked" in pack.sensed[-1].streams
    assert pack.behaviours[0].takes_in == (
        "Sensors: none; buttons of the operator: Start, Break, Go on and Child looked (in the rows: Looked)"
    )
    said = {s.row: s.text for s in pack.behaviours[0].sentences}
    assert "every “Child looked” becomes “Saw it”" in said[28] and not any("“Looked”" in s for s in said.values())
    assert said[11] == "“Start” sets “Trial” to 1. “Go on” sets “Trial” to 1 if it is less. “Rested” adds 1 to “Trial”."


@pytest.mark.parametrize(
    ("thing", "robot", "told"),
    [
        ("Person", "", True),
        ("Person", "simulated", True),
        ("Person", "real", False),
        ("Red ball", "simulated", False),
        ("", "", False),
    ],
)
def test_simulated_persons_are_told_on_the_first_page(tmp_path, thing, robot, told):
    head = "## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n"
    rest = f"{head}| 1 | {thing} | appears | at 1, 0, 0.5 |\n" if thing else ""
    path = workbook(
        tmp_path, "| Red ball | map | redBall.x | X | |\n", rest=rest, protocol=f"| Robot in sessions | {robot} |"
    )
    assert ("The persons in this run are simulated." in pack_of(path).meets.text) == told


def test_persons_of_a_scene_that_the_program_makes_are_told_too(tmp_path):
    path = workbook(tmp_path, "| Face | map | face.name | X | |\n")
    assert "The persons in this run are simulated." in pack_of(path).meets.text


def test_the_microphone_is_said_to_hear_simulated_persons_only():
    pack = pack_of(bundled("workbooks", "follow-my-pointing.xlsx"))
    senses, kept = (next(g.text for g in part if label in g.label) for part, label in
                    ((pack.glance, "senses"), (pack.kept, "Sound")))  # fmt: skip
    assert "all the time, except while the robot speaks" in senses and "no sound of the room is kept" in senses
    assert (
        "hears the simulated persons only, from the beginning of a run to its end, except while the robot speaks"
        in kept
    )


@pytest.mark.slow
def test_commands_are_not_broken_and_the_annex_comes_last():
    pages = texts_of(read_pdf(make(bundled("workbooks", "touch-and-name.xlsx"), today=DAY).data))
    whole = "\n".join(pages)
    assert "rrp-sheets runs delete --participant CODE" in whole
    signed, annex = whole.rindex("Responsible researcher"), whole.rindex("For technicians: the behaviours")
    assert whole.index("rrp-sheets runs delete") > annex
    assert whole.rindex("Consent, withdrawal and deletion") < signed < annex


def test_the_speed_of_a_gesture_is_that_of_its_keyframes(tmp_path):
    rows = '| Go | subscribe | | Shake | |\n| Go | map | PICK(["Slow"; "Fast"]) | | |\n|  | subscribe | | Any | |\n'
    rest = (
        "## Devices\n| Stream | Device | Name |\n|---|---|---|\n| Go | OperatorButton | |\n| Shake | Gesture | Slow |\n"
        "| Any | Gesture | |\n\n## Gestures\n| Name | Time (s) | HeadYaw |\n|---|---|---|\n| Slow | 2 | 20° |\n"
        "| Fast | 0.4 | 60° |\n"
    )
    acts = {a.stream: a for a in pack_of(workbook(tmp_path, rows, rest=rest)).acts}
    slow, fast = (int(acts[name].speed.removesuffix("°/s (neck)")) for name in ("Shake", "Any"))
    assert slow <= 100  # °/s: on its way back
    assert 60 / 0.4 < fast < 474  # the faster one of the two; the neck could do 474
    assert (acts["Shake"].parts, acts["Any"].parts) == ("head", "head")


def test_comment_rows_group_the_sentences_and_every_field_is_printed(tmp_path):
    rows = (
        "| # first part | | | | |\n| Red ball | map | redBall.distance | Near | |\n| Near | subscribe | | Print | |\n"
    )
    pack = pack_of(workbook(tmp_path, rows, protocol="| Weather | Fine |\n| Consent | A parent signs |"))
    assert [s.group for s in pack.behaviours[0].sentences] == ["First part", ""]
    assert [(s.label, s.text) for s in pack.statements] == [("Weather", "Fine")]
    assert ("Consent and capacity", "A parent signs", True) in [(c.label, c.text, c.stated) for c in pack.consent]
    assert "Contact" in [lack.name for lack in pack.missing]
