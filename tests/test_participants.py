"""The information sheet for participants: one page in plain words and large type, from what the rows do."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from packs import DAY, workbook
from pdftree import read_pdf, texts_of
from typed import run

from rrp_sheets import api
from rrp_sheets.checks import check_workbook
from rrp_sheets.render.pack import Print
from rrp_sheets.render.pack.participants import BLANK, ParticipantSheet, make_sheet
from rrp_sheets.render.texts import texts
from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot
from rrp_sheets.services.printing import make_for_participants

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
HEADS = "| Stream | Device | Label | Words | Name | Forward | Sound | Text |\n|---|---|---|---|---|---|---|---|\n"
EVERYTHING = """| Red ball | subscribe | | Head tracker | |
| Colours | subscribe | | Eye color | |
| Face | subscribe | | Remember face | |
| Touch | subscribe | | Waving | |
| Bumper | subscribe | | Ringing | |
| Chest button | subscribe | | Steps | |
| Sonar | subscribe | | Talk | |
| Heard | subscribe | | Waving | |
| Go | subscribe | | Waving | |
"""
ITS_DEVICES = f"""## Devices
{HEADS}| Go | Operator button | Go | | | | | |
| Colours | Blob | | | | | | |
| Heard | Word recognized | | yes, no | | | | |
| Waving | Gesture | | | Wave | | | |
| Steps | Walk | | | | 0.2 | | |
| Ringing | Play sound | | | | | Bell | |
| Talk | Say parameter | | | | | | Hi |
"""
FIELDS = """| Version | 1.0 |
| Participants | Children of 9 to 12 years |
| Robot in sessions | real |
| Face memory | kept |
| Investigators | Dr Tanaka and Ms Sato |
| Sessions | Twice, 10 min |
| Access | Dr Tanaka |
| Contact | Dr Aiko Tanaka, University Hospital, Department of Rehabilitation, +81 29 000 0000, aiko@example.org, 9 to 5 |
"""
PROGRAM_WORDS = "stream|row|connector|formula|sensor|actuator|workbook|sheet|event|device|operator|protocol|run|trace"


def sheet_of(path: Path, language: str = "en", **options: bool) -> ParticipantSheet:
    reading = api.read(path)
    checked = check_workbook(reading.workbook, reading.report)
    return make_sheet(reading, checked, Print(path.name, DAY.isoformat(), "1.0"), language=language, **options)


def part(sheet: ParticipantSheet, title: str) -> tuple[str, ...]:
    return next((p.sentences for p in sheet.parts if p.title == title), ())


@pytest.fixture
def everything(tmp_path: Path) -> Path:
    return workbook(tmp_path, EVERYTHING, rest=ITS_DEVICES, protocol=FIELDS)


# ---- plain words
def syllables(word: str) -> int:
    """Groups of vowels, without a silent e at the end; at least one."""
    found = len(re.findall(r"[aeiouy]+", word))
    return max(1, found - (word.endswith("e") and not word.endswith("le")))


def grade(text: str) -> float:
    """Reading grade of an English text by Flesch and Kincaid."""
    words = re.findall(r"[a-z']+", text.casefold())
    sentences = len(re.findall(r"[.!?](?:\s|$)", text))
    return 0.39 * len(words) / sentences + 11.8 * sum(map(syllables, words)) / len(words) - 15.59


def test_reading_grade_is_measured_as_known_texts_have_it():
    assert grade("The cat sat on the mat.") < 0
    assert grade("The Australian platypus is seemingly a hybrid of a mammal and reptilian creature.") == pytest.approx(
        11.3, abs=1.5
    )


def test_every_sentence_can_be_read_at_nine_years():
    entries = {n: t for n, t in texts("en").entries.items() if n.startswith("participants.") and t.endswith((".", "?"))}
    adults = {n: entries.pop(n) for n in [*entries] if ".adult_" in n}
    assert adults and {n: text for n, text in adults.items() if grade(text) > 8} == {}
    whole = " ".join(text.format_map({"robot": "NAO", "cm": "57", "text": "us"}) for text in entries.values())
    assert grade(whole) <= 3
    hard = {n: text for n, text in entries.items() if grade(text) > 6}
    assert hard == {}


@pytest.mark.parametrize("name", WORKBOOKS)
def test_sheet_of_every_workbook_reads_as_grade_six_at_most(name):
    sheet = sheet_of(bundled("workbooks", f"{name}.xlsx"))
    theirs = (
        "You can also ask",
        "We are",
        "How often",
        "Who can see",
        "How long we",
        "If you say no",
        "If you stop later",
        "This is what",
        "What it is for",
        "The buttons",
    )
    lines = [line for p in (sheet.intro, *sheet.parts) for line in p.sentences if not line.startswith(theirs)]
    assert grade(" ".join(lines)) <= 6
    assert re.findall(rf"\b(?:{PROGRAM_WORDS})s?\b", " ".join(lines), re.IGNORECASE) == []


# ---- what it says
def test_everything_that_rows_do_is_said(everything):
    sheet = sheet_of(everything)
    assert part(sheet, "What does it do?") == (
        "It talks to you.", "It plays sounds or music.", "It moves its head.", "It moves its arms and hands.",
        "It walks a few steps.", "Its eyes light up.",
    )  # fmt: skip
    assert part(sheet, "What does it see and hear?") == (
        "It looks for balls.", "It looks for colours.", "It looks for faces.", "It notices when you touch it.",
        "It notices a bump at its feet.", "It notices when you push the button on its chest.",
        "It notices how far away you are.", "It listens for some words.",
        "It learns your face. It will still know your face next time.",
        "We can see what its camera sees.",
    )  # fmt: skip
    assert part(sheet, "What do we keep?") == (
        "We write down what the robot does, and when.", "We write down where you touch it.",
        "We write down which words the robot hears.", "We do not keep your voice.",
        "We keep pictures from its camera. You may be in them.", "We keep your face as a list of numbers.",
        "We keep a film of the robot. You are not in it.",
        "We write down which buttons a person pushes.", "We use a code, not your name.",
        "Who can see this: Dr Tanaka.", f"How long we keep it: {BLANK}.",
        f"If you say no later: {BLANK}.",
    )  # fmt: skip
    assert part(sheet, "What do you do?") == (
        f"This is what you do: {BLANK}.", "You sit or stand near the robot.", "You can touch it when it asks you.", "You can talk to it.",
        "Hands off while it moves.", "It may be loud.", "You may get tired, or not like it. Then tell us.",
        "This can happen: it startles you, it pinches a finger, it falls over, it bumps into you, its lights feel bad, "
        "you miss it later, others see what we keep, it gets hot or you catch germs from it.",
        "How often, how long: Twice, 10 min.",
    )  # fmt: skip
    assert part(sheet, "Does it get help?") and "It is in the room with you." in sheet.intro.sentences
    assert "57 cm" in sheet.intro.sentences[-1]


@pytest.mark.parametrize("sensor", sorted(d.name for d in load_robot().devices.values() if d.kind == "sensor"))
def test_every_sensor_of_the_robot_has_its_sentence(tmp_path, sensor):
    rest = f"## Devices\n{HEADS}| Sensed | {sensor} | Go | yes, no | | | | |\n"
    sheet = sheet_of(workbook(tmp_path, "| Sensed | subscribe | | Print | |\n", rest=rest), draft=True)
    assert [note for note in sheet.notes if "says nothing about the sensor" in note] == []


def test_a_quiet_robot_is_said_to_be_quiet(tmp_path):
    rows = "| Touch | map | touch.zone | Zone | |\n"
    sheet = sheet_of(workbook(tmp_path, rows, protocol="| Robot in sessions | real |"))
    assert part(sheet, "What does it do?") == ("It does not move or talk.",)
    assert part(sheet, "What does it see and hear?") == (
        "It notices when you touch it.", "It does not look at you.", "We can see what its camera sees.",
        "It does not listen to you.",
    )  # fmt: skip
    assert part(sheet, "Does it get help?") == ()


def test_risks_of_the_sheet_that_the_program_does_not_know_are_said_too(tmp_path):
    head = "## Risks\n| Risk | For whom | How likely | What reduces it | Who ends the session when |\n|---|---|---|---|---|\n"
    rest = f"{head}| Pain in the arms | Children | | | |\n| Boredom | The operator | | | |\n| A loud voice | | | | |\n"
    rows = "| Red ball | map | 'Hi' | | |\n|  | subscribe | | Say | |\n"
    for robot, more in (("simulated", ""), ("real", ", it gets hot")):
        sheet = sheet_of(workbook(tmp_path, rows, rest=rest, protocol=f"| Robot in sessions | {robot} |"))
        risks = [line for line in part(sheet, "What do you do?") if "can happen" in line]
        assert risks[1:] == ["This can happen too: Pain in the arms."] and "it startles you" in risks[0]
        assert ("it gets hot" in risks[0]) == bool(more)


def test_how_to_stop_and_that_one_may_say_no_is_always_said(tmp_path):
    sheet = sheet_of(workbook(tmp_path, "| Touch | map | touch.zone | Zone | |\n"))
    assert "walk away" in part(sheet, "How can you stop? (to confirm)")[0]
    assert part(sheet, "You choose (to confirm)")[0] == "You can say yes or no."


def test_simulated_robot_is_on_a_screen_and_nobody_is_in_its_film(tmp_path):
    sheet = sheet_of(
        workbook(tmp_path, "| Touch | subscribe | | Print | |\n", protocol="| Robot in sessions | simulated |")
    )
    assert "You see it on a screen." in sheet.intro.sentences
    assert "We keep a film of the robot. You are not in it." in part(sheet, "What do we keep?")


@pytest.mark.parametrize("field", ["", "simulated", "real"])
def test_robot_is_in_the_room_only_when_the_protocol_says_so(tmp_path, field):
    path = workbook(tmp_path, EVERYTHING, rest=ITS_DEVICES, protocol=FIELDS.replace("| real |", f"| {field} |"))
    sheet = sheet_of(path)
    whole = " ".join(line for p in (sheet.intro, *sheet.parts) for line in p.sentences)
    for said in ("You sit or stand near", "Hands off", "You can talk to it", "It listens for", "It bends its knees"):
        assert (said in whole) == (field == "real")
    assert ("☐ on a screen, ☐ in the room" in whole) == (not field)
    assert ("It cannot see or hear you." in whole) == (field == "simulated")


def test_adults_read_words_for_adults_with_task_and_purpose(tmp_path):
    protocol = (
        "| Participants | Adults |\n| Purpose | Light exercises |\n| What participants do | You lift your arms |\n"
        "| Withdrawal | At any time |\n| Consent | In writing |"
    )
    sheet = sheet_of(workbook(tmp_path, "| Red ball | subscribe | | Head tracker | |\n", protocol=protocol))
    whole = " ".join(line for p in (sheet.intro, *sheet.parts) for line in p.sentences)
    assert "This is what you do: You lift your arms." in whole and "What it is for: Light exercises." in whole
    assert "cross with you" not in whole and "shake your head" not in whole
    assert sheet.mark == "Name and signature:" and "☐ yes" in sheet.agree and sheet.date


def test_blank_fields_are_places_to_fill_in_by_hand(tmp_path):
    sheet = sheet_of(workbook(tmp_path, "| Touch | subscribe | | Print | |\n", protocol="| Participants | Children |"))
    blank = [line for p in (sheet.intro, *sheet.parts) for line in p.sentences if BLANK in line]
    for start in (
        "We are",
        "This is what",
        "How often",
        "Who can see",
        "How long",
        "If you say no",
        "You can also ask",
    ):
        assert any(line.startswith(start) for line in blank)


@pytest.mark.parametrize(
    ("reason", "hidden"), [("", False), ("Nothing is concealed", False), ("To see natural talk", True)]
)
def test_helping_person_is_left_out_only_for_a_reason_that_is_given(tmp_path, reason, hidden):
    rest = f"## Devices\n{HEADS}| Go | Operator button | | | | | | |\n"
    protocol = f"| Reason for concealment | {reason} |"
    sheet = sheet_of(workbook(tmp_path, "| Go | subscribe | | Print | |\n", rest=rest, protocol=protocol))
    assert (part(sheet, "Does it get help?") == ()) == hidden
    assert any("a person controls the robot" in note for note in sheet.notes) == hidden


def test_who_prints_is_told_what_the_sheet_lacks(tmp_path):
    notes = sheet_of(workbook(tmp_path, "| Touch | subscribe | | Print | |\n")).notes
    for field in ("Robot in sessions", "Contact", "Investigators", "Sessions", "Access"):
        assert any(field in note for note in notes)


@pytest.mark.parametrize(
    ("protocol", "status"),
    [
        ("| Participants | Adults |", "DRAFT: not all is decided yet"),
        ("| Participants | Adults |\n| Withdrawal | At any time |\n| Consent | In writing |", ""),
        ("| Participants | Children |\n| Withdrawal | At any time |", "DRAFT: not all is decided yet"),
        ("| Participants | Nobody |", ""),
    ],
)
def test_promises_that_the_protocol_does_not_state_make_a_draft(tmp_path, protocol, status):
    sheet = sheet_of(workbook(tmp_path, "| Touch | subscribe | | Print | |\n", protocol=protocol))
    assert sheet.status == status
    assert (sheet.mark, sheet.date) == ("", "") if status else sheet.mark and "☐ yes" in sheet.agree
    assert ("do not sign" in sheet.agree) == bool(status)


@pytest.mark.parametrize(
    ("participants", "aloud"),
    [("Children of 4 to 8 years", True), ("5～7歳の子ども", True), ("Children of 9 to 12 years", False),
     ("Adults of 6 years of training", False), ("Children", False)],
)  # fmt: skip
def test_page_is_read_to_small_children(tmp_path, participants, aloud):
    sheet = sheet_of(
        workbook(tmp_path, "| Touch | subscribe | | Print | |\n", protocol=f"| Participants | {participants} |")
    )
    assert bool(sheet.aloud) == aloud and sheet.study == "T"


# ---- one page
def measured(data: bytes) -> tuple[int, float, str]:
    """Pages of a PDF, the size of its smallest type, and its text."""
    pdf = read_pdf(data)
    sizes: list[float] = []

    def visit(text: str, matrix: list[float], at: list[float], _font: object, size: float) -> None:
        if text.strip():
            sizes.append(size * abs(at[3]) * abs(matrix[3]))

    pdf.pages[0].extract_text(visitor_text=visit)
    return len(pdf.pages), min(sizes), " ".join(texts_of(pdf))


@pytest.mark.parametrize(
    ("language", "paper"),
    [
        ("ja", "a4"),
        ("en", "letter"),
        pytest.param("en", "a4", marks=pytest.mark.slow),
        pytest.param("ja", "letter", marks=pytest.mark.slow),
    ],
)
def test_the_fullest_sheet_is_one_page_of_large_type(everything, language, paper):
    printed = make_for_participants(everything, language=language, paper=paper, today=DAY)
    pages, smallest, text = measured(printed.data)
    assert pages == 1 and smallest >= 12.99
    assert "aiko@example.org" in text.replace(" ", "")
    assert "1.0 · 2026-11-21" in text


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKBOOKS)
def test_sheet_of_every_workbook_is_one_page(name):
    for language, paper in (("en", "letter"), ("ja", "a4")):
        printed = make_for_participants(bundled("workbooks", f"{name}.xlsx"), language=language, paper=paper, today=DAY)
        pages, smallest, _ = measured(printed.data)
        assert pages == 1 and smallest >= 12.99


def test_long_and_hostile_contacts_keep_it_on_one_page(tmp_path):
    contact = "#import " + "<b>x</b>" * 40 + "w" * 300
    path = workbook(tmp_path, EVERYTHING, rest=ITS_DEVICES, protocol=FIELDS.replace("Dr Aiko Tanaka", contact))
    printed = make_for_participants(path, paper="letter", today=DAY)
    assert measured(printed.data)[0] == 1
    assert any("too long for the page" in note for note in printed.notes)


def test_it_is_accessible_and_shows_the_robot(everything):
    pdf = read_pdf(make_for_participants(everything, today=DAY).data)
    root = pdf.trailer["/Root"]
    assert root["/MarkInfo"]["/Marked"] and b"pdfuaid" in root["/Metadata"].get_object().get_data()
    assert pdf.metadata.title == "Meet NAO" and sheet_of(everything).picture.startswith("<svg")


def test_picture_is_left_out_for_a_robot_beside_the_workbook(tmp_path):
    folder = bundled("robots", "nao")
    copy = tmp_path / "robots" / "nao"
    copy.mkdir(parents=True)
    for file in folder.iterdir():
        (copy / file.name).write_bytes(file.read_bytes())
    path = workbook(tmp_path, EVERYTHING, rest=ITS_DEVICES, protocol=FIELDS)
    assert sheet_of(path).picture == ""
    assert measured(make_for_participants(path, today=DAY).data)[0] == 1


# ---- the command
def test_command_prints_it_beside_the_workbook(everything, monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    code, said = run("print", "w.md", "--for", "participants", "--date", "2026-01-02")
    assert code == 0 and said.endswith("Printed: w-participants.pdf\n")
    assert "Meet NAO" in texts_of(read_pdf((tmp_path / "w-participants.pdf").read_bytes()))[0]
    code, said = run("print", "w.md", "--for", "participants", "--against", "w.md")
    assert code == 2 and "belongs to the protocol for a board" in said


def test_workbook_with_errors_gives_a_draft_only(tmp_path, monkeypatch):
    workbook(tmp_path, "| Red ball | mapp | redBall.distance | Near | |\n")
    monkeypatch.chdir(tmp_path)
    assert run("print", "w.md", "--for", "participants")[0] == 1
    assert not (tmp_path / "w-participants.pdf").exists()
    run("print", "w.md", "--for", "participants", "--draft")
    assert "DRAFT" in texts_of(read_pdf((tmp_path / "w-participants.pdf").read_bytes()))[0]
    assert api.print_pack("w.md", "p.pdf", draft=True, reader="participants")
    assert (tmp_path / "p.pdf").stat().st_size > 1_000
