"""Explanations in plain words: true for every row, and quoted where a paraphrase could be wrong."""

from __future__ import annotations

import pytest
from play import rows

from rrp_sheets import api
from rrp_sheets.model.values import Field, RecordType
from rrp_sheets.render.formula_words import Content, Named, Wording
from rrp_sheets.render.sentences import explain, explain_text
from rrp_sheets.render.texts import texts
from rrp_sheets.resources import bundled

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
BALL = RecordType("Ball", (Field("distance", "number", "m"), Field("colour", "text"), Field("new", "truth")))
HEAD = "| Input streams | Connector | Formula | Output stream | On |\n|---|---|---|---|---|\n"


def explained(tmp_path, rows, more=""):
    path = tmp_path / "w.md"
    path.write_text(f"## T\n{HEAD}{rows}\n{more}", encoding="utf-8")
    checked = api.check(path)
    (said,) = explain(checked.graph, checked.workbook)
    return said


@pytest.mark.parametrize("connector", ["map", "filter"])
def test_a_row_without_its_formula_yet(tmp_path, connector):
    said = explained(
        tmp_path, f"| Red ball | {connector} | | D | |\n| D | {connector} | | E | |\n| E | subscribe | | Print | |"
    )
    for text in (said.paragraph, *(row.text for row in said.rows[:2])):
        assert "(no formula yet)" in text and "`" not in text


@pytest.fixture
def wording():
    names = {
        "ball": Named("“Ball”", Content(BALL)), "distance": Named("“Distance”", Content(unit="m")),
        "it": Named("it", Content(BALL), pronoun=True, name="“Ball”"),
    }  # fmt: skip
    return Wording(texts(), names, {"howfar": "howFar"})


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKBOOKS)
def test_the_workbooks_in_words(name, golden):
    checked = api.check(bundled("workbooks") / f"{name}.xlsx")
    golden(f"{name}.txt", explain_text(checked.graph, checked.workbook))


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("distance < 0.5", "“Distance” is under 0.5 m"),
        ("0.5 > distance", "“Distance” is under 0.5 m"),
        ("distance >= -1", "“Distance” is at least −1 m"),
        ("0.5 <= distance < 2", "“Distance” is between 0.5 and 2 m"),
        ("AND(distance >= 0.5, distance <= 2)", "“Distance” is from 0.5 to 2 m"),
        ("distance < 1 or distance > 2", "“Distance” is under 1 m or “Distance” is over 2 m"),
        ('ball.colour == "red"', "the colour of “Ball” is “red”"),
        ('it.colour != "red"', "its colour is not “red”"),
        ("not ball.new", "the value “new” of “Ball” is not true"),
        ("ISBLANK(distance)", "“Distance” is blank"),
        ("howFar", "“how far” is true"),
        # never guessed:
        ("distance", "`distance` is true"),
        ("ball.unknown > 1", "`ball.unknown > 1` is true"),
        ("distance < 1 and (distance > 2 or ball.new)", "`distance < 1 and (distance > 2 or ball.new)` is true"),
        ("ABS(distance) < 1", "`ABS(distance) < 1` is true"),
        ("distance <", "`distance <` is true"),
        ("not distance < 1", "`not distance < 1` is true"),
        ("0.5 < distance > 0.1", "`0.5 < distance > 0.1` is true"),
    ],
)
def test_conditions(wording, formula, words):
    assert wording.condition(formula).text == words


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("it.distance", "its distance"),
        ("=ball.distance", "the distance of “Ball”"),
        ('"Hello"', "the words “Hello”"),
        ('IF(distance < 1, "near", "far")', "“near” if “Distance” is under 1 m, otherwise “far”"),
        ("1 if distance < 1 else 0", "1 if “Distance” is under 1 m, otherwise 0"),
        ("howFar", "“how far”"),
        ("howFar(ball)", "“how far” from “Ball”"),
        ("distance * 2", "“Distance” × 2"),
        ("ROWS(Parts) + 1", "one more than the number of rows in “Parts”"),
        ("INDEX(Parts; distance)", "the row of “Parts” at position “Distance”"),
        ("INDEX(Parts[Say]; it)", "the value “Say” in that row of the table “Parts”"),
        ("XLOOKUP(ball.colour; Parts[Name]; Parts)", "the row of “Parts” whose “Name” is the colour of “Ball”"),
        ("PICK(praise)", "a random entry of “praise”, each once before any comes again"),
        ('"I see a " & it.colour & " ball"', "the words “I see a ‹colour of Ball› ball”"),
        ('f"{distance} m"', "the words “‹Distance› m”"),
        ('"So " & howFar(ball.distance)', "the words “So ‹how far(distance of Ball)›”"),
        # never guessed:
        ("(", "`(`"),
        ("(1, 0, 0)", "the values (1, 0, 0)"),
        ("(distance, 0)", "`(distance, 0)`"),
        ("distance * 2 + 1", "`distance * 2 + 1`"),
        ("XLOOKUP(distance; Parts[Name]; Others)", "`XLOOKUP(distance; Parts[Name]; Others)`"),
        ("ball.unknown", "`ball.unknown`"),
    ],
)
def test_values(wording, formula, words):
    assert wording.value(formula).text == words


def test_an_explanation_of_three_rows(tmp_path):
    said = explained(
        tmp_path,
        "| Red ball | map | redBall.distance | Distance | |\n| Distance | filter | distance < 0.5 | Close ball | |\n"
        "| Close ball | subscribe | | Head tracker | |\n",
    )
    assert said.paragraph == (
        "When the robot sees a red ball, set “Distance” to its distance. "
        "When “Distance” is under 0.5 m, follow the red ball with the head."
    )
    assert said.sensors == ("Red ball",) and said.actuators == ("Head tracker",)


def test_rows_that_are_off_are_claimed_nowhere(tmp_path):
    said = explained(
        tmp_path,
        "| Red ball | filter | redBall.distance < 1 | Near | no |\n| Near | subscribe | | Print | |\n"
        "| Green ball | subscribe | | Eye LED color | |\n",
    )
    assert said.rows[0].text.startswith("Switched off: ") and not said.rows[0].active
    assert said.rows[1].text.startswith("Not active") and not said.rows[1].active
    assert said.sensors == ("Green ball",) and said.actuators == ("Eye LED color",)
    assert "red ball" not in said.paragraph and said.paragraph.endswith("Switched off: row 2.")


def test_forgotten_values_stop_the_actuator(tmp_path):
    said = explained(
        tmp_path,
        "| Red ball | forgetAfter | 2 s | Fresh ball | |\n| Fresh ball | subscribe | | Head tracker | |\n",
    )
    assert said.rows[0].text == (
        "Each “Red ball” becomes “Fresh ball” at once. If no new one arrives for 2 s, an empty value (blank) follows."
    )
    assert said.rows[1].text.endswith("If it is blank, stop the tracking “Head tracker”.")


def test_a_blank_is_told_by_what_it_stops(tmp_path):
    devices = "\n## Devices\n| Stream | Device | Time | Name |\n|---|---|---|---|\n| Pause | Wait | 30 s | |\n| Nod | Gesture | | Nod |\n"
    said = explained(
        tmp_path,
        "| Red ball | subscribe | BLANK | Pause | |\n| Red ball | subscribe | =blank() | Nod | |\n"
        "| Red ball | map | BLANK | Off | |\n| Off | subscribe | | Eye LED color | |\n| Off | subscribe | | Print | |\n",
        devices,
    )
    assert [row.text for row in said.rows] == [
        "When the robot sees a red ball, interrupt the wait “Pause”.",
        "When the robot sees a red ball, stop the gesture “Nod”.",
        "When the robot sees a red ball, set “Off” to an empty value (blank).",
        "When “Off” arrives, send an empty value (blank) to “Eye LED color”, which stops nothing.",
        "When “Off” arrives, send an empty value (blank) to “Print”, which stops nothing.",
    ]


def test_only_what_a_blank_stops_is_told_to_stop(tmp_path):
    said = explained(
        tmp_path,
        "| Face | forgetAfter | 2 s | Seen | |\n| Seen | subscribe | | Remember face | |\n| Seen | subscribe | | Say | |\n",
    )
    assert said.rows[1].text == "When “Seen” arrives, remember the face that it sees."
    assert said.rows[2].text == "When “Seen” arrives, say it. If it is blank, stop what “Say” is saying."


def test_any_input_of_a_merge_is_enough_and_a_filter_looks_at_all_of_its_further_inputs(tmp_path):
    said = explained(
        tmp_path,
        "| Red ball, Green ball, Blue ball | merge | | Ball | |\n| Ball | merge | | Same | |\n"
        "| Ball, Red ball, Green ball | filter | ball.distance < redBall.distance + greenBall.distance | Near | |\n",
    )
    assert said.rows[0].text == "Any of “Red ball”, “Green ball” or “Blue ball” becomes “Ball”."
    assert said.rows[1].text == "Each “Ball” becomes “Same”."
    assert said.rows[2].text == (
        "When “Ball” arrives, if its field “distance” is under the distance of the latest “Red ball” + the distance of "
        "the latest “Green ball”, send “Near”."
    )


def test_pointing_names_the_arm(tmp_path):
    said = explained(
        tmp_path,
        "| Red ball | subscribe | | Pointer | |\n",
        "\n## Devices\n| Stream | Device | Mode | Effector |\n|---|---|---|---|\n| Pointer | Tracker | Move | Left arm |\n",
    )
    assert said.rows[0].text == "When the robot sees a red ball, point at the red ball with the left arm."


def test_every_connector_has_words(tmp_path):
    from rrp_sheets.connectors import connectors

    for connector in connectors():
        assert connector.sentence and connector.legend, connector.name


def test_an_operators_button_and_what_it_lets_say_are_told_once(tmp_path):
    button = "\n## Devices\n| Stream | Device | Label |\n|---|---|---|\n| Praise | Operator button | Praise |\n"
    praise = explained(tmp_path, '| Praise | subscribe | "It is time." | Say | |\n', button)
    assert praise.paragraph == "When the operator presses the button “Praise”, say “It is time.”"
    assert praise.rows[0].text == praise.paragraph and praise.sensors == () and praise.buttons == ("Praise",)
    chain = '| Praise | map | praise.count | N | |\n| N | filter | n > 3 | E | |\n| E | map | "End." | Words | |\n'
    chained = explained(tmp_path, f"{chain}| Words | subscribe | | Say | |\n", button)
    for text in (chained.paragraph, *(row.text for row in chained.rows)):
        assert ".”." not in text and "“Praise” (stream “Praise”)" not in text
    other = explained(
        tmp_path, "| Praise | subscribe | | Print | |\n", button.replace("| Praise |\n", "| Well done |\n")
    )
    assert other.paragraph.startswith("When the operator presses the button “Well done” (stream “Praise”)")


def test_headings_of_the_sheet_stand_above_their_rows(tmp_path):
    """Comments are kept as in print: joined, also over a blank row; a lone # and a row switched off by one are none."""
    text = rows(
        "| # near things |  |  |  |\n| # and far ones |  |  |  |\n| Red ball | map | redBall.distance | D |\n"
        "| # | Red ball | map | x |\n| D | subscribe | | Print |\n| # last |  |  |  |\n"
    )
    (tmp_path / "x.md").write_text(text, encoding="utf-8")
    said = api.explain(tmp_path / "x.md")[0].splitlines()
    first = next(n for n, line in enumerate(said) if line.startswith("  4  "))
    assert said[first - 1] == "  Near things and far ones" and said[first - 2] == ""
    assert sum("ear things" in line for line in said) == 1 and not any("last" in line for line in said)


DEVICES = """
## Devices
| Stream | Device | Every | Label | Forward | Left | Turn | Words |
|---|---|---|---|---|---|---|---|
| Clock | Timer | 1 s | | | | | |
| Going | Operator button | | Go | | | | |
| Back | Walk | | | -0.15 | | | |
| Around | Walk | | | 1.2 | -0.3 | -90° | |
| Words | Word recognized | | | | | | yes, no |
"""


@pytest.mark.parametrize(
    ("row", "sentence"),
    [
        ("Clock | filter | clock.count > 3 | Late", "Every second (stream “Clock”), if its count is over 3, send “Late”."),
        ("Clock, Going | filter | going.count = 1 | Beat", "While the count of “Going” is 1, every “Clock” becomes “Beat”."),
        ("Clock | subscribe | | Back", "Every second (stream “Clock”), walk 15 cm backwards."),
        (
            "Clock | subscribe | | Around",
            "Every second (stream “Clock”), walk 1.2 m forwards and 30 cm to the right, then turn 90° to the right.",
        ),
        ('Clock | subscribe | "red" | Eye LED color', "Every second (stream “Clock”), turn both eyes red."),
        ('Clock | subscribe | "red" | Say', "Every second (stream “Clock”), say “red”."),
        ("Clock | subscribe | clock.count | Print", "Every second (stream “Clock”), write its count to the log."),
        ("Say done | filter | sayDone.completed | Said", "When “Say” finishes uninterrupted, send “Said”."),
        ("Say done | filter | NOT(sayDone.completed) | Cut", "When “Say” is interrupted, send “Cut”."),
        ("Touch | filter | touch.pressed | Held", "When somebody touches the robot or lets go, if the touch begins, send “Held”."),
        ("Touch | filter | NOT(touch.pressed) | Let go", "When somebody touches the robot or lets go, if the touch ends, send “Let go”."),
        ("Clock, Going | merge | | ", "Each value of “Clock” or “Going” is passed on to row 3."),
        ("Clock, Going | accumulate | IF(ISBLANK(going); total + 1; 0) | N", "“Clock” adds 1 to “N”. “Going” sets “N” to 0."),
        ("Clock, Going | accumulate | IF(ISBLANK(going); total; 1) | N", "“Clock” leaves “N” as it is. “Going” sets “N” to 1."),
        ("Clock, Going | accumulate | total + value.count | N", "Each “Clock” or “Going” updates “N” to `total + value.count`."),
        ("Words, Clock | timeout | 2 s | Calm", "2 s after the last “Words”, send “Calm”, unless “Clock” arrives first."),
        ("Words | map | words.word | Word", "When the robot hears “yes” or “no” (stream “Words”), set “Word” to its word."),
        ("Clock, Going | once | | First", "Only the first “Clock” becomes “First”, and again the first one after each “Going”."),
    ],
)  # fmt: skip
def test_whole_sentences_for_each_kind_of_row(tmp_path, row, sentence):
    said = explained(tmp_path, f"| {row} | |\n| | subscribe | | Print | |\n", DEVICES)
    assert said.rows[0].text == sentence


def test_inputs_that_may_be_blank_themselves_are_not_taken_for_their_events(tmp_path):
    said = explained(
        tmp_path,
        "| Clock | forgetAfter | 2 s | Old | |\n| Old, Going | accumulate | IF(ISBLANK(old); total + 1; 0) | N | |\n",
        DEVICES,
    )
    assert said.rows[1].text == "Each “Old” or “Going” updates “N” to `IF(ISBLANK(old); total + 1; 0)`."
