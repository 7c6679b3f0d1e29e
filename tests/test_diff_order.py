"""Comparing workbooks: order, renames, formulas in other words, workbooks that are not in order."""

from __future__ import annotations

import re

import pytest
from compared import BASE, compare, told
from hypothesis import given, settings
from hypothesis import strategies as st

from rrp_sheets.compare.as_text import say

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
    assert told(comparison) == ["~ Talk row 5 moved (was row 4)"] and "PICK" in comparison.changes[0].note


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
        "Talk row 2: formula face.new → face.nwe +",
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


# ---- lists in their order

PARTS = (
    SPEAK
    + """
## Devices
| Stream | Device | Text |
|---|---|---|
| New | Face | |

## Parts
| Say | Gesture |
|---|---|
"""
)


@settings(max_examples=40, deadline=None)
@given(st.data())
def test_one_changed_cell_of_a_table_is_one_change(tmp_path_factory, data):
    rows = data.draw(st.lists(st.tuples(st.sampled_from("abc"), st.sampled_from("xyz")), min_size=1, max_size=6))
    at, column = data.draw(st.integers(0, len(rows) - 1)), data.draw(st.integers(0, 1))
    text = data.draw(st.sampled_from("abcxyzq").filter(lambda c: c != rows[at][column]))
    changed = [
        tuple(text if (n, c) == (at, column) else cell for c, cell in enumerate(row)) for n, row in enumerate(rows)
    ]
    first, second = (
        SPEAK.replace("1 | Eye", "ROWS(Parts) | Eye")
        + PARTS[len(SPEAK) :]
        + "".join(f"| {a} | {b} |\n" for a, b in table)
        for table in (rows, changed)
    )
    comparison = compare(tmp_path_factory.mktemp("w"), first, second)
    head = ("say", "gesture")[column]
    assert told(comparison) == [f"Table Parts row {at + 2}: {head} {rows[at][column]} → {text}"]


def test_a_row_that_stays_in_its_place_has_not_moved(tmp_path):
    other = SPEAK.replace("## Talk", "## Chat")
    lines = [say(c) for c in compare(tmp_path, SPEAK + other, other + SPEAK).changes]
    assert lines and not [line for line in lines if re.search(r"row (\d+) moved \(was row \1\)", line)]
    assert any(line.endswith("acts in another order") for line in lines)
    three = "## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n"
    rows = [f"| Red ball | map | value.{c} | {c}{c} |\n" for c in "xyd"]
    lines = [say(c) for c in compare(tmp_path, three + "".join(rows), three + "".join(reversed(rows))).changes]
    assert lines and not [line for line in lines if re.search(r"row (\d+) moved \(was row \1\)", line)]


def test_what_a_test_sends_and_expects_means_another_thing_in_other_letters(tmp_path):
    test = (
        SPEAK
        + "\n## Greeting\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n| 0 | Face | | |\n| 0 | Say | | Hello |\n"
    )
    (change,) = compare(tmp_path, test, test.replace("| Hello |", "| hello |")).changes
    assert (change.kind, change.effect) == ("changed", False) and "it means the same" not in change.note
    (change,) = compare(tmp_path, test.replace("Hello |", "0.5 |"), test.replace("Hello |", ".50 |")).changes
    assert (change.kind, change.note) == ("written", "it means the same")


def test_another_device_of_one_kind_is_another_device(tmp_path):
    devices = (
        SPEAK
        + "| New | subscribe | | Follow | |\n\n## Devices\n| Stream | Device |\n|---|---|\n| Follow | Head tracker |\n"
    )
    comparison = compare(tmp_path, devices, devices.replace("Head tracker", "Head and body tracker"))
    assert not comparison.same and told(comparison)[0] == "Devices: Follow: device Head tracker → Head and body tracker"
    assert not [c for c in comparison.changes if c.kind == "written"]


def test_a_formula_that_changed_in_several_places_is_told_before_and_after(tmp_path):
    comparison = compare(tmp_path, BASE, BASE.replace("IF(both > 0.5, True, False)", "IF(both > 1, False, True)"))
    assert told(comparison) == ["Tracking row 7: formula IF(both > 0.5, True, False) → IF(both > 1, False, True)"]
