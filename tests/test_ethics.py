"""Questions of ethics boards: fields that are asked for, the sheet Risks, and what the printed protocol says of both."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest
from packs import DAY, workbook
from pdftree import read_pdf, texts_of
from test_print import pack_of
from typed import run

from rrp_sheets import api
from rrp_sheets.compare.as_text import say
from rrp_sheets.render.pack import Pack
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot
from rrp_sheets.services.printing import make
from rrp_sheets.sim.body import SOLE
from rrp_sheets.sim.gait import STEP_TIME, STRIDE
from rrp_sheets.workbook import read
from rrp_sheets.workbook.schema import FIELDS
from rrp_sheets.workbook.template import beginning

RISKS = (
    "## Risks\n| Risk | For whom | How likely | What reduces it | Who ends the session when |\n|---|---|---|---|---|\n"
)
DEVICES = "## Devices\n| Stream | Device | Label | Name | Forward | Volume |\n|---|---|---|---|---|---|\n"
LOOKS = "| Red ball | subscribe | | Head tracker | |\n"
NOT_KEPT = "| Camera pictures | not kept |"
ALWAYS = ["tiredness", "privacy", "battery"]
"""The risks of every robot that does something."""


def risks_of(folder: Path, rows: str, *, devices: str = "", protocol: str = NOT_KEPT) -> list[str]:
    """Kinds of the risks that are proposed for some rows."""
    path = workbook(folder, rows, rest=DEVICES + devices if devices else "", protocol=protocol)
    return [risk.kind for risk in api.check(path).study.proposed_risks()]


def lacks(pack: Pack) -> dict[str, str]:
    return {field.name: field.where for field in pack.missing}


# ---- risks
@pytest.mark.parametrize(
    ("rows", "devices", "kinds"),
    [
        (LOOKS, "", ["pinching", "distress"]),
        ("| Red ball | map | 'Hi' | | |\n|  | subscribe | | Say | |\n", "", ["startle", "attachment", "distress"]),
        ("| Touch | subscribe | | Bell | |\n", "| Bell | Play sound | | | | |\n",
         ["startle", "falling", "attachment", "distress", "power", "cleaning"]),
        ("| Red ball | subscribe | | Wave | |\n", "| Wave | Gesture | | Wave | | |\n",
         ["pinching", "attachment", "distress"]),
        ("| Red ball | subscribe | | Go | |\n", "| Go | Walk | | | 0.2 | |\n", ["falling", "walking", "distress"]),
        ("| Red ball | subscribe | | Eye color | |\n", "", ["lights", "distress"]),
        ("| Go | subscribe | | Eye color | |\n", "| Go | Operator button | | | | |\n",
         ["lights", "deception", "distress"]),
        ("| Red ball | map | redBall.x | Side | |\n", "", []),
        ("| Red ball | map | BLANK | | |\n|  | subscribe | | Say | |\n", "", []),
    ],
)  # fmt: skip
def test_risks_are_proposed_from_what_rows_do(tmp_path, rows, devices, kinds):
    assert sorted(risks_of(tmp_path, rows, devices=devices)) == sorted([*kinds, *(ALWAYS if kinds else [])])


def test_recordings_of_people_are_a_risk_of_their_own(tmp_path):
    assert "privacy" in risks_of(tmp_path, LOOKS)
    assert risks_of(tmp_path, "| Red ball | map | redBall.x | Side | |\n", protocol="") == ["privacy"]


def test_simulated_robot_harms_no_body(tmp_path):
    devices = "| Wave | Gesture | | Wave | | |\n"
    kinds = risks_of(tmp_path, "| Touch | subscribe | | Wave | |\n", devices=devices,
                     protocol="| Robot in sessions | simulated |")  # fmt: skip
    assert kinds == ["attachment", "distress", "tiredness", "privacy"]


@pytest.mark.parametrize(("zone", "asked"), [("", True), ("Chest", True), ("Head", False)])
def test_touch_contradicts_a_distance_and_the_chest_is_the_power_button(tmp_path, zone, asked):
    devices = f"| Wave | Gesture | | Wave | |\n| Hand | Touch | | | {zone} |\n"
    rest = "## Devices\n| Stream | Device | Label | Name | Zone |\n|---|---|---|---|---|\n" + devices
    path = workbook(tmp_path, "| Hand | subscribe | | Wave | |\n", rest=rest)
    found = {risk.kind: str(risk.texts[3]) for risk in api.check(path).study.proposed_risks()}
    assert "these rows move its arms: Play 2." in found["pinching"] and ("power" in found) == asked
    (chest,) = [s for s in pack_of(path).stops if s.who == "The chest button"]
    assert bool(chest.used) == asked and "A real NAO is switched off by it" in chest.how


def test_proposals_promise_nothing_that_the_workbook_does_not_say(tmp_path):
    texts = [str(r.texts[3]) for r in api.check(bundled("workbooks", "touch-and-name.xlsx")).study.proposed_risks()]
    assert not [text for text in texts if "should" not in text and "State another measure" not in text]
    assert any("full volume (100 %)" in text for text in texts)


def test_proposals_name_volume_buttons_and_children(tmp_path):
    devices = "| Loud | Say | | | | 60 |\n| Go | Operator button | Praise it | | | |\n"
    rows = "| Go | map | 'Good' | | |\n|  | subscribe | | Loud | |\n"
    path = workbook(tmp_path, rows, rest=DEVICES + devices, protocol="| Participants | Ten pupils of 8 years |")
    found = {risk.kind: risk.texts for risk in api.check(path).study.proposed_risks()}
    assert "60 % at most" in found["startle"][3]
    assert "“Praise it”" in found["deception"][0]
    assert found["distress"][1] == "The child"


@pytest.mark.parametrize(("suffix", "language"), [(".md", "English"), (".xlsx", "日本語"), ("", "English")])
def test_fix_adds_the_proposed_rows_in_every_format(tmp_path, suffix, language):
    made = workbook(tmp_path, LOOKS, rest=RISKS, protocol=f"| Language | {language} |")
    path = made if suffix == ".md" else api.convert(made, tmp_path / f"book{suffix}")
    (finding,) = [d for d in api.check(path).report if d.code == "PROT012"]
    count = 2 + len(ALWAYS)
    assert len(finding.fixes[0].edits) == count
    fixed = tmp_path / f"fixed{suffix or '.xlsx'}"
    assert run("check", path, "--fix", fixed, "--apply", "PROT012:add-proposed")[0] == 0
    risks = read(fixed).workbook.risks
    assert risks is not None and len(risks.rows) == count
    assert all(row.reduces and row.ends and row.whom and row.likely for row in risks.rows)
    assert ("驚" in risks.rows[0].risk.text or "指" in risks.rows[0].risk.text) == (language == "日本語")
    assert not [d for d in api.check(fixed).report if d.code.startswith("PROT01")]


def test_rows_in_japanese_and_below_other_headers_count(tmp_path):
    rows = "| リスク | 対策 | 中止の判断 |\n|---|---|---|\n| 腕に指をはさむ | 離れる | 保護者 |\n| 子どもの不安 | そばにいる | 保護者 |\n"
    rows += "| 疲れ | 休む | 保護者 |\n| 個人情報の漏れ | 暗号化 | 研究者 |\n| 電池 | 外す | 研究者 |\n"
    path = workbook(tmp_path, LOOKS, rest=f"## リスク表\n{rows}", protocol=NOT_KEPT)
    checked = api.check(path)
    assert checked.workbook.risks is not None and checked.study.unnamed_risks() == []
    assert not list(checked.report)


def test_incomplete_row_is_told_and_a_sheet_of_ones_own_is_left_alone(tmp_path):
    path = workbook(tmp_path, LOOKS, rest=RISKS + "| Pinching | | | | |\n| Fear | | | Care | |\n", protocol=NOT_KEPT)
    said = [str(d.message) for d in api.check(path).report if d.code == "PROT013"]
    assert said == [
        "The risk “Pinching” does not say what reduces it and who ends the session when.",
        "The risk “Fear” does not say who ends the session when.",
    ]
    own = workbook(tmp_path, LOOKS, "own.md", rest="## Register\n| Risk | Score |\n|---|---|\n| Rain | 3 |\n")
    assert api.check(own).workbook.risks is None and not list(api.check(own).report)


def test_changed_risk_leaves_the_behaviour_the_same(tmp_path):
    first = workbook(tmp_path, LOOKS, "a.md", rest=RISKS + "| Fear | Child | Possible | A parent | The parent |\n")
    second = workbook(tmp_path, LOOKS, "b.md", rest=RISKS + "| Fear | Child | Likely | A parent | The parent |\n")
    found = api.diff(first, second)
    assert found.same
    assert [say(change) for change in found.changes] == ["Risks row 2: how likely Possible → Likely"]


# ---- fields
def test_every_field_is_known_by_its_japanese_name(tmp_path):
    names = [field.synonyms[0] for field in FIELDS.values() if field.synonyms and not field.closed]
    path = workbook(tmp_path, LOOKS, protocol="".join(f"| {name} | 30 |\n" for name in names if name != "題名"))
    fields = read(path).workbook.protocol.fields
    known = {k for k, field in FIELDS.items() if field.synonyms and not field.closed}
    assert known <= set(fields)
    lacking = {field.name for field in pack_of(workbook(tmp_path, LOOKS, "none.md"), language="ja").missing}
    assert {field.synonyms[0] for field in FIELDS.values() if field.asked == "always" and not field.closed} <= lacking


def test_closed_fields_take_japanese_words(tmp_path):
    fields = "| 参加者が会うロボット | 実機 |\n| カメラの画像 | 残さない |\n| 顔の記憶 | 残す |\n"
    checked = api.check(workbook(tmp_path, LOOKS, protocol=fields))
    assert not checked.report.errors
    assert (checked.study.meets, checked.run.keeps_pictures, checked.run.keeps_faces) == ("real", False, True)


@pytest.mark.parametrize(
    ("participants", "rows", "asked"),
    [
        ("Ten adults", LOOKS, set()),
        ("Children of 9 years", LOOKS, {"Assent", "Dissent"}),
        ("小学生10人", LOOKS, {"Assent", "Dissent"}),
        ("Ten adults", "| Go | subscribe | | Print | |\n",
         {"Participants are told", "Reason for concealment", "Debriefing"}),
        ("Ten adults", "| Face | subscribe | | Head tracker | |\n", {"Face data"}),
        ("Ten adults |\n| Robot in sessions | simulated", LOOKS, {"-Robot used"}),
    ],
)  # fmt: skip
def test_boards_ask_for_more_when_there_is_more_to_ask(tmp_path, participants, rows, asked):
    rest = DEVICES + "| Go | Operator button | | | | |\n"
    path = workbook(tmp_path, rows, rest=rest, protocol=f"| Participants | {participants} |")
    always = {field.name for field in FIELDS.values() if field.asked == "always"}
    real = {"Robot used", "Version date"} - {name.removeprefix("-") for name in asked}
    more = {name for name in asked if not name.startswith("-")}
    assert set(api.check(path).study.asked_fields()) - always == more | real


@pytest.mark.parametrize("nobody", ["Nobody: a demonstration", "なし（デモ）", "No participants"])
def test_nothing_is_missing_when_nobody_takes_part(tmp_path, nobody):
    pack = pack_of(workbook(tmp_path, LOOKS, protocol=f"| Participants | {nobody} |"))
    assert pack.missing == () and "nobody takes part" in pack.missing_note
    assert pack.meets.text.startswith("Nobody takes part")


def test_fix_adds_the_fields_that_boards_ask_for(tmp_path):
    path = workbook(tmp_path, LOOKS, protocol="| Participants | Children |\n| Ethics reference | |")
    (finding,) = [d for d in api.check(path).report if d.code == "PROT014"]
    code, _ = run("check", path, "--fix", tmp_path / "more.md", "--apply", "PROT014:add-fields")
    assert code == 0
    fields = read(tmp_path / "more.md").workbook.protocol.fields
    assert {"assent", "benefits", "recruitment", "encryption", "lawfulbasisandimpactassessment", "codekey"} <= set(
        fields
    )
    assert "debriefing" not in fields
    assert not [d for d in api.check(tmp_path / "more.md").report if d.code == "PROT014"]
    assert finding.severity.value == "info"
    assert not list(api.check(workbook(tmp_path, LOOKS, "none.md", protocol="| Participants | Children |")).report)


def test_new_protocol_sheet_has_every_field_and_lacks_none_that_is_asked(tmp_path):
    names = [row[0] for row in beginning("protocol")[1:]]
    assert [name for name in names if not name.startswith("#")] == [field.name for field in FIELDS.values()]


# ---- the printed protocol
def test_first_page_lists_what_is_missing_with_its_place(tmp_path):
    path = workbook(tmp_path, LOOKS, protocol="| Participants | Children |\n| Benefits | |")
    pack = pack_of(path)
    assert lacks(pack)["Benefits"] == "row 4" and lacks(pack)["Assent"] == ""
    assert lacks(pack)["5 risks that the rows bring"] == "sheet Risks"
    assert [n.text for n in pack.numbers if n.label == "points open"] == [
        str(len(pack.missing) + 4)
    ]  # each risk counts
    filled = "".join(f"| {field.name} | Said |\n" for field in FIELDS.values() if field.asked and not field.closed)
    whole = workbook(tmp_path, LOOKS, "whole.md", protocol=filled + "| Robot in sessions | real |\n")
    complete = pack_of(whole)
    assert list(lacks(complete)) == ["5 risks that the rows bring", "Risks of the task"]
    assert complete.missing_note.startswith("6 things") and complete.status


@pytest.mark.parametrize(
    ("risks", "missing"),
    [(["Fingers are pinched"], True), (["Fingers are pinched", "Pinched skin from the exercise band"], False),
     (["Falls and pain during the exercises"], False)],
)  # fmt: skip
def test_risks_of_the_task_are_missing_until_a_row_is_no_proposal(tmp_path, risks, missing):
    rest = RISKS + "".join(f"| {risk} | All | Possible | Care | The operator |\n" for risk in risks)
    pack = pack_of(workbook(tmp_path, LOOKS, rest=rest, protocol="| Participants | Adults |"))
    assert ("Risks of the task" in lacks(pack)) == missing
    assert ("only the risks of the robot" in pack.risks_note) == missing


@pytest.mark.parametrize("complete", [True, False])
def test_incomplete_protocol_is_a_draft_that_no_board_signs(tmp_path, complete):
    filled = "".join(f"| {field.name} | Said |\n" for field in FIELDS.values() if field.asked and not field.closed)
    protocol = filled + "| Robot in sessions | simulated |\n" if complete else "| Participants | Adults |"
    rows = "| Red ball | map | redBall.distance | Near | |\n"
    rest = RISKS + "| A child trips over a toy | Child | Possible | Tidy up | The operator |\n"
    path = workbook(tmp_path, rows, rest=rest, protocol=f"{protocol.strip()}\n{NOT_KEPT}")
    pack = pack_of(path)
    assert (not pack.missing) == complete == (not pack.status) == ("For the ethics board" in pack.signatures)
    pages = texts_of(read_pdf(make(path, today=DAY).data))
    assert all("DRAFT" in page for page in pages) != complete


@pytest.mark.slow
@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("language", ["en", "ja"])
@pytest.mark.parametrize("name", ["mixed-control", "greeter-with-memory", "sing-and-dance", "attention-training"])
def test_list_of_what_is_missing_and_who_is_met_stand_on_the_first_page(name, language, paper):
    path = bundled("workbooks", f"{name}.xlsx")
    first = "".join(texts_of(read_pdf(make(path, language=language, paper=paper, today=DAY).data))[0].split())
    pack = pack_of(path, language=language)
    assert "".join(pack.meets.text.split()) in first
    assert "".join(pack.missing_note.split()) in first
    assert [lack.name for lack in pack.missing if "".join(lack.name.split()) not in first] == []


@pytest.mark.parametrize(
    ("field", "said", "mode"),
    [
        ("", "Not stated yet", "TRIED IN SIMULATION ONLY"),
        ("", "the approval of a real one needs a new print.", "TRIED IN SIMULATION ONLY"),
        ("simulated", "Participants see it on a screen", "TRIED IN SIMULATION ONLY"),
        (
            "real",
            "A real NAO in the room. With this version of the program nobody can meet it",
            "TRIED IN SIMULATION ONLY, REAL ROBOT PLANNED",
        ),
    ],
)
def test_what_participants_meet_is_said_first(tmp_path, field, said, mode):
    pack = pack_of(workbook(tmp_path, LOOKS, protocol=f"| Robot in sessions | {field} |"))
    assert said in pack.meets.text and pack.mode == mode


def test_proposed_risks_are_marked_as_not_confirmed(tmp_path):
    rest = RISKS + "| Pinching | Child | Unlikely | Distance | The operator |\n"
    pack = pack_of(workbook(tmp_path, LOOKS, rest=rest, protocol=NOT_KEPT))
    assert [(risk.risk.split()[0], risk.proposed) for risk in pack.risks] == [
        ("Pinching", False), ("Distress:", True), ("Tiredness", True), ("A", True), ("Heat", True)
    ]  # fmt: skip
    assert lacks(pack)["4 risks that the rows bring"] == "sheet Risks"
    assert "not yet in this protocol" in pack.risks_note
    none = pack_of(workbook(tmp_path, "| Red ball | map | redBall.x | Side | |\n", "none.md", protocol=NOT_KEPT))
    assert none.risks == () and "proposes none" in none.risks_note


def test_hostile_texts_in_risks_and_fields_are_printed_as_texts(tmp_path):
    hostile = "#import <b>&amp; $x$ \\u{0} " + "x" * 300
    rest = RISKS + f"| {hostile} | {hostile} | {hostile} | {hostile} | {hostile} |\n"
    path = workbook(tmp_path, LOOKS, rest=rest, protocol=f"| Benefits | {hostile} |\n| Participants | {hostile} |")
    pages = "".join("".join(texts_of(read_pdf(make(path, today=DAY).data))).split())
    assert pages.count("#import<b>&amp;$x$") >= 3


# ---- the robot as a body
def facts(pack: Pack) -> dict[str, str]:
    return {fact.label: fact.text for fact in pack.body}


def test_facts_about_the_robot_follow_from_its_model():
    body = load_robot().data["body"]
    tree = ET.parse(load_robot().folder / "nao.urdf").getroot()
    assert body["weight"] == round(sum(float(mass.get("value", 0)) for mass in tree.iter("mass")), 1)
    efforts = {
        j.get("name", ""): float(j.find("limit").get("effort"))
        for j in tree.iter("joint")
        if j.find("limit") is not None
    }
    hand = load_robot().data["arm"]["hand"][0]
    at_the_hand = max(efforts["LElbowRoll"] / (hand - 0.105), efforts["LShoulderRoll"] / hand)
    assert body["hand_force"] - 1 < at_the_hand <= body["hand_force"]
    arm = max(efforts[name] for name in ("LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll"))
    assert body["joint_force"] - 2 < arm / 0.03 <= body["joint_force"]
    assert STRIDE / STEP_TIME <= body["walking_speed"] < STRIDE / STEP_TIME + 0.001
    places = {"LShoulder": (0.0, 0.0, 0.0)}
    for joint in tree.iter("joint"):
        offset = [float(x) for x in joint.find("origin").get("xyz").split()]
        if (parent := joint.find("parent").get("link")) in places:
            places[joint.find("child").get("link")] = tuple(a + b for a, b in zip(places[parent], offset, strict=True))
    tips = []
    for link in tree.iter("link"):
        for shape in link.findall("visual") if link.get("name") in places else ():
            at = [float(x) for x in shape.find("origin").get("xyz").split()]
            mesh = shape.find("geometry/mesh")
            half = max(float(x) for x in mesh.get("scale").split()) / 2 if mesh is not None else 0.0
            tips.append(math.hypot(*(a + b for a, b in zip(places[link.get("name")], at, strict=True))) + half)
    assert len(tips) > 5 and body["reach"] - 0.01 < max(tips) <= body["reach"]
    legs = ("LHipYawPitch", "LKneePitch", "LAnklePitch", "LShoulderPitch")
    drops = [abs(float(j.find("origin").get("xyz").split()[2])) for j in tree.iter("joint") if j.get("name") in legs]
    assert len(drops) == 4 and body["raised"] - 0.01 < sum(drops) + abs(SOLE) + max(tips) <= body["raised"]


def test_facts_are_said_in_words_that_people_can_judge(tmp_path):
    devices = "| Go | Walk | | | 0.2 | |\n| Wave | Gesture | | Wave | | |\n"
    rows = "| Red ball | subscribe | | Go | |\n| Red ball | subscribe | | Wave | |\n"
    found = facts(pack_of(workbook(tmp_path, rows, rest=DEVICES + devices)))
    assert found["Size and weight"] == (
        "57 cm high: a little higher than an adult's knee. 5.4 kg: as heavy as 5 one-litre bottles of water."
    )
    assert found["Walking"] == "At most 10 cm a second: slower than a crawling baby."
    assert "14 N, the weight of 1.4 kg" in found["Force of the arms"]
    assert "26 cm" in found["Distance"] and "with a raised arm 70 cm" in found["Distance"]
    assert "Esc pressed twice" in found["Stopping"] and "It does not cut the power" in found["Stopping"]
    assert (
        "the right shoulder, turns by at most 201° a second. With a stretched arm a hand moves at most"
        in found["Fastest movement"]
    )


@pytest.mark.parametrize(
    ("version", "day", "shown", "asked"),
    [
        ("1.0", "", "1.0", True),
        ("1.0", "2026-11-01", "1.0, 2026-11-01", False),
        ("1.0 (3 May 2026)", "", "1.0 (3 May 2026)", False),
        ("20261101", "", "20261101", False),
        ("第2版（令和8年11月1日）", "", "第2版（令和8年11月1日）", False),
        ("1.202611", "", "1.202611", True),
    ],
)
def test_version_has_a_date(tmp_path, version, day, shown, asked):
    pack = pack_of(workbook(tmp_path, LOOKS, protocol=f"| Version | {version} |\n| Version date | {day} |"))
    assert {fact.label: fact.text for fact in pack.facts}["Version"] == shown
    assert ("Version date" in lacks(pack)) == asked and "Version date" not in [s.label for s in pack.statements]


def test_facts_say_what_rows_do_not_move(tmp_path):
    quiet = facts(pack_of(workbook(tmp_path, "| Red ball | map | 'Hi' | | |\n|  | subscribe | | Say | |\n")))
    assert quiet["Fastest movement"] == "No row moves a joint." and "Walking" not in quiet
    assert quiet["Force of the arms"] == "No row moves the arms."
    head = facts(pack_of(workbook(tmp_path, LOOKS, "head.md")))
    assert head["Fastest movement"] == "The fastest joint, the neck, turns by at most 474° a second."


def test_robot_of_ones_own_without_facts_is_printed_without_them(tmp_path):
    path = workbook(tmp_path, LOOKS, protocol="| Robot | mine |")
    copy = tmp_path / "robots" / "mine"
    copy.mkdir(parents=True)
    for part in load_robot().folder.iterdir():
        (copy / part.name).write_bytes(part.read_bytes())
    text = (copy / "robot.toml").read_text(encoding="utf-8")
    (copy / "robot.toml").write_text(text.replace("[body]", "[elsewhere]"), encoding="utf-8")
    pack = pack_of(path)
    assert pack.body == () and "does not state its weight" in pack.body_note
