"""Comparing workbooks by what they mean (design: 7-exchange, Compare): an edit, and exactly what is told about it."""

from __future__ import annotations

import re

import pytest

from rrp_sheets import api
from rrp_sheets.compare import Comparison
from rrp_sheets.compare.wording import say

BASE = """
## Tracking
| On | Priority | Input streams | Connector | Formula | Output stream | Notes |
|---|---|---|---|---|---|---|
| | | Red ball | map | redBall.distance | Distance | how far |
| | | Distance | sample | 1000 | Steady | |
| | | Steady | filter | steady < 20 | Close ball | |
| | 2 | Close ball | subscribe | near(closeBall) | Eyes | |
| | | Blue ball, Distance | combineLatest | blueBall.distance - distance | Both | |
| | | Both | filter | IF(both > 0.5, True, False) | | |
| | | | map | INDEX(Words, 1).Word | Word | |
| | | Word | subscribe | | Hello | |
| no | | Distance | map | distance * 2 | Twice | |
| | | Twice, Distance | merge | | Any | |
| | | Any | subscribe | | Print | |

## Looking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Blue ball | filter | blueBall.distance < 1 | Near blue |
| Near blue | subscribe | | Tracker |

## Devices
| Stream | Device | Text | Colour | Notes |
|---|---|---|---|---|
| Hello | Say parameter | Hello | | greets |
| Eyes | Eye brightness | | | |
| Spare | Say parameter | unused | | |

## Helpers
| Name | Inputs | Formula | Notes |
|---|---|---|---|
| near | x | x < limit | |
| limit | | 0.5 | |
| unused | | 3 | |

## Words
| Word | Points |
|---|---|
| apple | 1 |
| pear | 2 |

## Scene
| Time (s) | Thing | Does | Value | Notes |
|---|---|---|---|---|
| 1 | Red ball | appears | at 1, 0.2, 0.4 | |
| 2 | Red ball | moves | to 0.5, 0, 0.4 in 2 s | |
| 5 | Mia | enters | at 1, 0 | |

## Gestures
| Name | Time (s) | HeadYaw | HeadPitch |
|---|---|---|---|
| Nod | 0 | 0 | 0 |
| Nod | 1 | 0 | 10° |

## Protocol
| Field | Value |
|---|---|
| Title | A study |
| Version | 1.0 |
| Seed | 7 |

## Checks
| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | distance=1 | |
| 100 | Distance | | any |
"""


def compare(tmp_path, before: str, after: str) -> Comparison:
    paths = tmp_path / "before.md", tmp_path / "after.md"
    for path, text in zip(paths, (before, after), strict=True):
        path.write_text(text, encoding="utf-8")
    return api.diff(*paths)


def edited(*edits: tuple[str, str]) -> str:
    text = BASE
    for old, new in edits:
        assert text.count(old) == 1, (old, text.count(old))
        text = text.replace(old, new)
    return text


def told(comparison: Comparison) -> list[str]:
    """What is told, with `~` before what has no effect."""
    return [("" if c.effect else "~ ") + say(c) for c in comparison.changes]


def test_base_is_in_order(tmp_path):
    path = tmp_path / "base.md"
    path.write_text(BASE, encoding="utf-8")
    assert not api.check(path).report.errors


ROW_5 = "| | | Steady | filter | steady < 20 | Close ball | |\n"
ROW_12 = "| | | Any | subscribe | | Print | |"
EDITS = {
    "number in a formula": (
        [("steady < 20", "steady < 15")],
        ["Tracking row 4: 20 → 15 in the formula steady < 15"],
    ),
    "several tokens": (
        [("redBall.distance | D", "ABS(redBall.x) | D")],
        ["Tracking row 2: formula {+ABS(+}redBall.[-distance-]{+x)+}"],
    ),
    "period": ([("| 1000 |", "| 2 s |")], ["Tracking row 3: formula 1000 → 2 s"]),
    "same period": ([("| 1000 |", "| 1 s |")], ["~ Tracking row 3: formula is written differently: 1000 → 1 s"]),
    "formula gone": ([("near(closeBall)", "")], ["Tracking row 5: formula near(closeBall) → blank"]),
    "connector": (
        [("| Steady | filter | steady < 20", "| Steady | map | steady < 20")],
        ["Tracking row 4: connector filter → map"],
    ),
    "input": ([("| Distance | sample", "| Red ball | sample")], ["Tracking row 3: inputs Distance → Red ball"]),
    "order of inputs of merge": (
        [("Twice, Distance | merge", "Distance, Twice | merge")],
        ["Tracking row 11: inputs Twice, Distance → Distance, Twice"],
    ),
    "order of inputs of combineLatest": (
        [("Blue ball, Distance | comb", "Distance, Blue ball | comb")],
        ["~ Tracking row 6: inputs Blue ball, Distance → Distance, Blue ball"],
    ),
    "actuator": ([("| subscribe | | Print", "| subscribe | | Say")], ["Tracking row 12: output Print → Say"]),
    "off": ([("| | | Distance | sample", "| no | | Distance | sample")], ["Tracking row 3 switched off"]),
    "on": ([("| no | |", "| yes | |")], ["Tracking row 10 switched on"]),
    "a row that stays off": (
        [("distance * 2", "distance * 3")],
        ["~ Tracking row 10: 2 → 3 in the formula distance * 3"],
    ),
    "priority": ([("| | 2 | Close", "| | 3 | Close")], ["Tracking row 5: priority 2 → 3"]),
    "priority of a row that drives nothing": (
        [("| | | Distance | sample", "| | 4 | Distance | sample")],
        ["~ Tracking row 3: priority 0 → 4"],
    ),
    "notes": ([("how far", "in metres")], ["~ Tracking row 2: notes how far → in metres"]),
    "notes of a device": ([("| greets |", "| says hello |")], ["~ Devices: Hello: notes greets → says hello"]),
    "notes of the scene": (
        [("| at 1, 0.2, 0.4 | |", "| at 1, 0.2, 0.4 | on the table |")],
        ["~ Scene row 2: notes blank → on the table"],
    ),
    "row added": (
        [(ROW_5, ROW_5 + "| | | Close ball | timestamp | | Timed | |\n")],
        ["Tracking row 5 added: Close ball | timestamp |  | Timed"],
    ),
    "row removed": (
        [("| | | Any | subscribe | | Print | |\n", "")],
        ["Tracking row 12 removed: Any | subscribe |  | Print"],
    ),
    "comment and blank rows": ([(ROW_5, "| # a comment | | | | | | |\n| | | | | | | |\n" + ROW_5)], []),
    "moved, without effect": (
        [("| | | Any | subscribe | | Print | |\n", ""), (ROW_5, ROW_5 + "| | | Any | subscribe | | Print | |\n")],
        ["~ Tracking row 5 moved (was row 12)"],
    ),
    "a stream renamed everywhere": (
        [("| 1000 | Steady |", "| 1000 | Calm |"), ("| Steady | filter | steady < 20", "| Calm | filter | calm < 20")],
        ["~ Tracking: stream Steady is now called Calm"],
    ),
    "a stream renamed and its formula changed": (
        [("| 1000 | Steady |", "| 1000 | Calm |"), ("| Steady | filter | steady < 20", "| Calm | filter | calm < 15")],
        ["~ Tracking: stream Steady is now called Calm", "Tracking row 4: 20 → 15 in the formula calm < 15"],
    ),
    "a stream renamed where it is made only": (
        [("| 1000 | Steady |", "| 1000 | Calm |")],
        ["~ Tracking: stream Steady is now called Calm", "Tracking row 4: inputs Steady → Steady"],
    ),
    "an unnamed stream named": (
        [("True, False) | | |\n| | | | map", "True, False) | Far | |\n| | | Far | map")],
        ["~ Tracking: the unnamed stream of row 7 is now called Far"],
    ),
    "blank input written out": (
        [("| | | Steady | filter", "| | | | filter"), ("steady < 20", "value < 20")],
        ["~ Tracking row 4: inputs is written differently: Steady → the row above (Steady)",
         "~ Tracking row 4: formula is written differently: steady < 20 → value < 20"],
    ),
    "spreadsheet and Python spelling": (
        [("IF(both > 0.5, True, False)", "True if both>.50 else FALSE")],
        ["~ Tracking row 7: formula is written differently: IF(both > 0.5, True, False) → True if both>.50 else FALSE"],
    ),
    "capitals and spaces": (
        [("blueBall.distance - distance", "Blue_Ball.Distance-DISTANCE")],
        ["~ Tracking row 6: formula is written differently: blueBall.distance - distance → Blue_Ball.Distance-DISTANCE"],
    ),
    "spelling of a connector": (
        [("combineLatest", "COMBINE latest")],
        ["~ Tracking row 6: connector is written differently: combineLatest → COMBINE latest"],
    ),
    "spelling of an input": (
        [("| Blue ball |", "| blue_ball |")],
        ["~ Looking row 2: inputs is written differently: Blue ball → blue_ball"],
    ),
    "headers": ([("| Input streams | Connector | Formula | Output stream |\n", "| From | Operator | Parameter | To |\n")], []),
    "sheet renamed": ([("## Looking", "## Blue")], ["~ Behaviour Looking is now called Blue"]),
    "sheet renamed and a row changed": (
        [("## Looking", "## Blue"), ("blueBall.distance < 1", "blueBall.distance < 2")],
        ["~ Behaviour Looking is now called Blue", "Blue row 2: 1 → 2 in the formula blueBall.distance < 2"],
    ),
    "sheet removed": (
        [(BASE[BASE.index("## Looking"):BASE.index("## Devices")], "")],
        ["Behaviour Looking removed: 2 rows",
         "Looking row 2 removed: Blue ball | filter | blueBall.distance < 1 | Near blue",
         "Looking row 3 removed: Near blue | subscribe |  | Tracker"],
    ),
    "setting of a device": (
        [("Say parameter | Hello |", "Say parameter | Good day |")],
        ["Devices: Hello: Text Hello → Good day"],
    ),
    "another device": (
        [("| Eyes | Eye brightness | | |", "| Eyes | Eye colour | | |")],
        ["Devices: Eyes: device Eye brightness → Eye colour"],
    ),
    "device by its name alone": (
        [("| Eyes | Eye brightness | | | |\n", ""), ("near(closeBall) | Eyes", "near(closeBall) | Eye brightness")],
        ["~ Devices: stream Eyes is now called Eye brightness"],
    ),
    "a device declared as it is": (
        [("| Spare |", "| Tracker | Tracker | | | |\n| Spare |")],
        ["~ Devices: Tracker: declaration is written differently: blank → declared"],
    ),
    "unused device": ([("| Spare | Say parameter | unused |", "| Spare | Say parameter | idle |")], ["~ Devices: Spare: Text unused → idle"]),
    "device renamed": (
        [("| Hello | Say parameter", "| Greeting | Say parameter"), ("| subscribe | | Hello", "| subscribe | | Greeting")],
        ["~ Devices: stream Hello is now called Greeting"],
    ),
    "helper": ([("| limit | | 0.5 |", "| limit | | 0.8 |")], ["Helper limit: formula 0.5 → 0.8"]),
    "unused helper": ([("| unused | | 3 |", "| unused | | 4 |")], ["~ Helper unused: formula 3 → 4"]),
    "helper renamed": (
        [("| near | x |", "| close | x |"), ("near(closeBall)", "close(closeBall)")],
        ["~ Helper near is now called close"],
    ),
    "helper's input renamed": (
        [("| near | x | x < limit |", "| near | d | d < limit |")],
        ["~ Helper near: inputs is written differently: x → d", "~ Helper near: formula is written differently: x < limit → d < limit"],
    ),
    "cell of a table": ([("| pear | 2 |", "| pear | 3 |")], ["Table Words row 3: points 2 → 3"]),
    "row of a table": ([("| pear | 2 |", "| pear | 2 |\n| plum | 3 |")], ["Table Words row 4 added: plum | 3"]),
    "order of a table": (
        [("| apple | 1 |\n| pear | 2 |", "| pear | 2 |\n| apple | 1 |")],
        ["Table Words row 2 moved (was row 3)"],
    ),
    "scene value": ([("at 1, 0.2, 0.4", "at 1, 0.3, 0.4")], ["Scene row 2: value at 1, 0.2, 0.4 → at 1, 0.3, 0.4"]),
    "scene time": ([("| 5 | Mia", "| 6 | Mia")], ["Scene row 4: time 5 → 6"]),
    "scene spelt otherwise": (
        [("| 5 | Mia | enters | at 1, 0 |", "| 5 s | Mia | appears | at 1,0 |")],
        ["~ Scene row 4: time is written differently: 5 → 5 s", "~ Scene row 4: does is written differently: enters → appears",
         "~ Scene row 4: value is written differently: at 1, 0 → at 1,0"],
    ),
    "gesture": ([("| Nod | 1 | 0 | 10° |", "| Nod | 1 | 0 | 20° |")], ["Gestures row 3: headpitch 10° → 20°"]),
    "seed": ([("| Seed | 7 |", "| Seed | 8 |")], ["Protocol: Seed: 7 → 8"]),
    "seed gone": ([("| Seed | 7 |\n", "")], ["Protocol: Seed: 7 → blank"]),
    "defaults written out": (
        [("| Seed | 7 |", "| Seed | 7 |\n| Robot | nao |\n| Frame rate | 30 |\n| Engine | Frame |\n| Run | all |")],
        ["~ Protocol: Robot is written differently: blank → nao", "~ Protocol: Frame rate is written differently: blank → 30",
         "~ Protocol: Engine is written differently: blank → Frame", "~ Protocol: Run is written differently: blank → all"],
    ),
    "title": ([("A study", "The study")], ["~ Protocol: Title: A study → The study"]),
    "test": ([("distance=1", "distance=2")], ["~ Checks row 2: send distance=1 → distance=2"]),
    "test row": (
        [("| 100 | Distance | | any |", "| 100 | Distance | | any |\n| 200 | Distance | | nothing |")],
        ["~ Checks row 4 added: 200 | Distance |  | nothing"],
    ),
    "behaviour sheets in another order": (
        [(BASE[BASE.index("## Looking"):BASE.index("## Devices")], ""), ("## Tracking", BASE[BASE.index("## Looking"):BASE.index("## Devices")] + "## Tracking")],
        ["~ The sheets stand in another order: Tracking, Looking → Looking, Tracking"],
    ),
    "nothing": ([], []),
}  # fmt: skip


@pytest.mark.parametrize("name", EDITS)
def test_edit(tmp_path, name):
    edits, expected = EDITS[name]
    comparison = compare(tmp_path, BASE, edited(*edits))
    assert told(comparison) == expected
    assert comparison.same == all(line.startswith("~") for line in expected)


@pytest.mark.parametrize("name", EDITS)
def test_the_other_way_round_the_opposite_is_told(tmp_path, name):
    text = edited(*EDITS[name][0])
    there, back = compare(tmp_path, BASE, text), compare(tmp_path, text, BASE)
    assert there.same == back.same
    opposite = {"added": "removed", "removed": "added", "on": "off", "off": "on"}

    def facts(comparison, turn):
        return sorted(
            (opposite.get(c.kind, c.kind), c.part, c.rows[::-1], c.what, c.after, c.before, c.effect) if turn
            else (c.kind, c.part, c.rows, c.what, c.before, c.after, c.effect)
            for c in comparison.changes
        )  # fmt: skip

    assert facts(there, False) == facts(back, True)


# ---- what the order of rows does

SPEAK = """
## Talk
| Input streams | Connector | Formula | Output stream | Priority |
|---|---|---|---|---|
| Face | filter | face.new | New | |
| New | subscribe | "Hello" | Say | |
| New | subscribe | "Welcome" | Say | |
| New | subscribe | 1 | Eye brightness | |
"""
HELLO, WELCOME = '| New | subscribe | "Hello" | Say | |\n', '| New | subscribe | "Welcome" | Say | |\n'


def test_two_rows_that_drive_one_actuator_swapped_are_another_behaviour(tmp_path):
    comparison = compare(tmp_path, SPEAK, SPEAK.replace(HELLO + WELCOME, WELCOME + HELLO))
    assert [c.kind for c in comparison.changes] == ["moved"] and not comparison.same
    assert "comes last" in comparison.changes[0].note


def test_with_another_priority_their_order_does_not_matter(tmp_path):
    first = SPEAK.replace(WELCOME, WELCOME.replace("| |", "| 1 |"))
    second = SPEAK.replace(HELLO + WELCOME, WELCOME.replace("| |", "| 1 |") + HELLO)
    assert compare(tmp_path, first, second).same


def test_rows_of_different_actuators_may_swap(tmp_path):
    eyes = "| New | subscribe | 1 | Eye brightness | |\n"
    comparison = compare(tmp_path, SPEAK, SPEAK.replace(WELCOME + eyes, eyes + WELCOME))
    assert comparison.same and [c.kind for c in comparison.changes] == ["moved"]


def test_sheets_that_drive_one_actuator_swapped_are_another_behaviour(tmp_path):
    other = SPEAK.replace("## Talk", "## Chat")
    comparison = compare(tmp_path, SPEAK + other, other + SPEAK)
    assert not comparison.same
    assert {c.part for c in comparison.effects} == {"row"}


def test_the_event_loop_works_in_the_order_of_the_rows(tmp_path):
    protocol = "\n## Protocol\n| Field | Value |\n|---|---|\n| Engine | event loop |\n"
    eyes = "| New | subscribe | 1 | Eye brightness | |\n"
    swapped = SPEAK.replace(WELCOME + eyes, eyes + WELCOME)
    assert not compare(tmp_path, SPEAK + protocol, swapped + protocol).same


def test_moving_a_row_with_a_blank_input_changes_what_it_reads(tmp_path):
    rows = "## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n"
    a, b, c = "| Red ball | map | value.x | A |\n", "| Red ball | map | value.y | B |\n", "| | subscribe | | Print |\n"
    comparison = compare(tmp_path, rows + a + b + c, rows + b + a + c)
    assert "T row 4: inputs the row above (B) → the row above (A)" in told(comparison) and not comparison.same


# ---- renames


def test_renaming_every_stream_is_no_change_of_any_row(tmp_path):
    renamed = SPEAK.replace("| New |", "| Unknown visitor |")
    assert told(compare(tmp_path, SPEAK, renamed)) == ["~ Talk: stream New is now called Unknown visitor"]


def test_two_streams_that_swap_their_names_everywhere_are_the_same_behaviour(tmp_path):
    text = """
## T
| Inputs | Connector | Formula | Output |
|---|---|---|---|
| Red ball | map | value.x | Far |
| Blue ball | map | value.y | Near |
| Far | subscribe | far * 2 | Print |
| Near | subscribe | | Say |
"""
    swapped = text.replace("Far", "1").replace("Near", "Far").replace("1", "Near").replace("far *", "near *")
    assert told(compare(tmp_path, text, swapped)) == [
        "~ T: stream Far is now called Near", "~ T: stream Near is now called Far",
    ]  # fmt: skip


def test_a_name_that_went_to_another_row_stays_with_its_readers(tmp_path):
    text = SPEAK.replace("face.new", "face.id > 1").replace("| New |", "| Known |")
    after = text.replace("face.id > 1 | Known |", "face.id > 2 | Known |")
    extra = "| Face | filter | face.id > 1 | Old |\n"
    assert told(compare(tmp_path, text, after + extra)) == [
        "Talk row 2: 1 → 2 in the formula face.id > 2", "Talk row 6 added: Face | filter | face.id > 1 | Old",
    ]  # fmt: skip


def test_a_row_that_draws_tells_when_its_number_changes(tmp_path):
    text = SPEAK.replace('"Welcome"', 'PICK(["a", "b"])')
    comparison = compare(tmp_path, text, text.replace(HELLO, "| # | | | | |\n" + HELLO))
    assert told(comparison) == ["~ Talk row 5 moved (was row 4)"] and "seed" in comparison.changes[0].note


def test_the_fields_of_a_combination_follow_the_names_of_its_streams(tmp_path):
    text = """
## T
| Inputs | Connector | Formula | Output |
|---|---|---|---|
| Red ball | map | value.x | Far |
| Blue ball, Far | combineLatest | | Both |
| Both | filter | both.far > 1 | Big |
| Big | subscribe | both.far | Print |
""".replace("both.far | Print", "big.far | Print")
    renamed = text.replace("| Far |", "| Off |").replace("Blue ball, Far", "Blue ball, Off").replace(".far", ".off")
    assert told(compare(tmp_path, text, renamed)) == ["~ T: stream Far is now called Off"]
    assert not compare(tmp_path, text, text.replace("both.far > 1", "both.blueBall.x > 1")).same


def test_tests_follow_the_names_of_streams_and_sheets(tmp_path):
    text = SPEAK + "\n## Try\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n| 0 | Talk!New | | any |\n"
    renamed = text.replace("| New |", "| Known |").replace("Talk", "Speak").replace("!New", "!Known")
    comparison = compare(tmp_path, text, renamed)
    assert [say(c) for c in comparison.changes if c.kind not in ("renamed", "written")] == []


def test_a_behaviour_that_is_switched_may_be_renamed_with_its_switch(tmp_path):
    text = (
        SPEAK
        + """
## Look
| Inputs | Connector | Formula | Output |
|---|---|---|---|
| Blue ball | subscribe | | Tracker |
| Say done | subscribe | | Looking off |

## Devices
| Stream | Device | Name | State |
|---|---|---|---|
| Looking off | Behaviour | Look | off |
"""
    )
    renamed = text.replace("## Look", "## Watch").replace("| Look |", "| Watch |")
    assert told(compare(tmp_path, text, renamed)) == [
        "~ Behaviour Look is now called Watch",
        "~ Devices: Looking off: Name is written differently: Look → Watch",
    ]
    renamed = renamed.replace("Looking off", "Watching off")
    comparison = compare(tmp_path, text, renamed)
    assert comparison.same and "~ Devices: stream Looking off is now called Watching off" in told(comparison)
    assert not compare(tmp_path, text, text.replace("| Look |", "| Talk |")).same


# ---- workbooks that are not in order


def test_workbooks_with_errors_are_compared_by_their_text(tmp_path):
    broken = SPEAK.replace("face.new", "face.nwe +").replace("| subscribe | 1 |", "| subskribe | 1 |")
    comparison = compare(tmp_path, broken, broken)
    assert comparison.same and not comparison.changes and comparison.first.errors == 2
    comparison = compare(tmp_path, SPEAK, broken)
    assert told(comparison) == [
        "Talk row 2: formula face.[-new-]{+nwe ++}",
        "Talk row 5: connector subscribe → subskribe",
    ]


def test_a_workbook_without_behaviours(tmp_path):
    comparison = compare(tmp_path, "## Mine\n| a |\n|---|\n| 1 |\n", SPEAK)
    assert not comparison.same and comparison.changes[0].kind == "added"


def test_everything_changed(tmp_path):
    other = "## Other\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n| Blue ball | subscribe | 1 | Print |\n"
    comparison = compare(tmp_path, BASE, other)
    kinds = {c.kind for c in comparison.changes}
    assert kinds <= {"added", "removed", "changed"} and not comparison.same
    assert re.search(r"Behaviour Tracking removed: 11 rows", "\n".join(told(comparison)))


def test_a_scene_without_rows_is_not_the_default_scene(tmp_path):
    empty = SPEAK + "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n"
    assert told(compare(tmp_path, SPEAK, empty)) == ["Sheet Scene added: empty"]
    assert told(compare(tmp_path, empty, SPEAK)) == ["Sheet Scene removed: empty"]


# ---- formulas in two spellings

FORMULA = "## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n| Red ball | map | value.x | x |\n"
SAME = [
    ("IF(x>3;1;0)", "1 if x > 3 else 0"),
    ("x<>3", "x != 3"),
    ("IF(x=3, 1, 2)", "1 if x == 3 else 2"),
    ("x^2", "x ** 2"),
    ("x * 50%", "x * 0.5"),
    ("30° + x", "radians(30) + x"),
    ("AND(x > 1; x < 2)", "x > 1 and x < 2"),
    ("NOT(x > 1)", "not X > 1.0"),
    ("max(x; 1)", "MAX(x, 1)"),
    ('"say ""hi"""', "'say \"hi\"'"),
    ('"I see "&x', 'f"I see {x}"'),
    ("=ABS( X )", "abs(x)"),
    ('("a" & x) & "b" & "c"', 'f"a{x}bc"'),
    ("ROWS(Words)", "rows( words )"),
    ("TRUE", "True"),
    ("[a*2 for a in [x, 1]]", "[b * 2 for b in [x,1]]"),
    ("x – 1", "x-1"),
    ("twice", "twice(x)"),
]
OTHER = [
    ("x > 3", "x >= 3"),
    ("x - 1", "1 - x"),
    ('"Hello"', '"hello"'),
    ('"a b"', '"a  b"'),
    ("x + 1", "x + 1.5"),
    ("(x + 1) * 2", "x + 1 * 2"),
    ("x % 3", "x * 3%"),
    ("TRUE", '"TRUE"'),
    ("x", "BLANK"),
    ('"a" & x', 'f"a{x:.1f}"'),
    ("ROWS(Words)", "ROWS(Others)"),
]
HELPERS = "\n## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| twice | n | n * 2 |\n"
HELPERS += "\n## Words\n| A |\n|---|\n| 1 |\n\n## Others\n| A |\n|---|\n| 1 |\n"


@pytest.mark.parametrize(
    ("before", "after", "same"), [(*p, True) for p in SAME] + [(*p, False) for p in OTHER], ids=str
)
def test_formulas_are_compared_by_their_meaning(tmp_path, before, after, same):
    texts = [f"{FORMULA}| x | map | {f} | Out |\n| Out | subscribe | | Print |\n{HELPERS}" for f in (before, after)]
    comparison = compare(tmp_path, *texts)
    assert comparison.first.errors == comparison.second.errors == 0
    assert comparison.same is same
    assert [c.kind for c in comparison.changes if c.part == "row"] == ["written" if same else "changed"]


@pytest.mark.parametrize(
    ("other", "same"), [("redBall['distance']", True), ('red_ball["Distance"]', True), ("redBall['x']", False)]
)
def test_a_field_by_dot_and_in_brackets_is_the_same(tmp_path, other, same):
    texts = [f"{FORMULA}| Red ball | map | {f} | Out |\n| Out | subscribe | | Print |\n"
             for f in ("redBall.distance", other)]  # fmt: skip
    assert compare(tmp_path, *texts).same is same
