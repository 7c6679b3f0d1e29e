"""Lints: mistakes that the check finds before the run, and rows that it accepts."""

from __future__ import annotations

from pathlib import Path

import pytest
from play import check, example, findings, play, rows

from rrp_sheets import api
from rrp_sheets.diagnostics.report import checks_wait
from rrp_sheets.resources import bundled

HEADER = "| Input streams | Connector | Formula | Output stream | Priority |\n|---|---|---|---|---|\n"
DEVICES = """
## Devices
| Stream | Device | Label | Words | Joint | Name | Zone | Text | Rate |
|---|---|---|---|---|---|---|---|---|
| Start | OperatorButton | Start | | | | | | |
| Words | WordRecognized | | yes, no, stop | | | | | |
| Touch | Touch | | | | | | | |
| Head joints | SetJointPosition | | | Head | | | | |
| Neck | SetJointPosition | | | HeadYaw | | | | |
| Nodding | SetJointPosition | | | HeadPitch | | | | |
| Show | Gesture | | | | | | | |
| Wave | Gesture | | | | Wave | | | |
| Nod | Gesture | | | | Nod | | | |
| Stand | Posture | | | | StandInit | | | |
| Pose | Posture | | | | | | | |
| Rest | Wait | | | | | | | |
| Ask | Say | | | | | | | |
| Hint | Say | | | | | | | |
| Hello | SayParameter | | | | | | Hello | |
| Slow ball | RedBall | | | | | | | 0.2 |
"""


def lints(text: str, *more: str, header: str = HEADER) -> list[tuple[str, str]]:
    return [f for f in findings(rows(text, DEVICES, *more, header=header)) if f[0].startswith(("LINT", "FORM"))]


DISTANCE = "| Red ball | map | redBall.distance | D | |\n"
CLOSE = DISTANCE + "| D | filter | d < 0.5 | Close | |\n"

STALE = [
    # a filtered input with one that is not; with all that bounds the age
    (CLOSE + "| Close, D | combineLatest | d | X | |\n| X | subscribe | | Print | |", [("LINT001", "B4")]),
    (CLOSE + "| D, Close | combineLatest | close + d | X | |\n| X | subscribe | | Print | |", [("LINT001", "B4")]),
    (CLOSE + "| Close, D | combineLatest | | X | |\n| X | subscribe | | Print | |", [("LINT001", "B4")]),
    (CLOSE + "| Close, Head yaw | combineLatest | close + headYaw | X | |\n| X | subscribe | | Print | |", [("LINT001", "B4")]),
    ("| Start, Red ball | combineLatest | redBall.x | X | |\n| X | subscribe | | Print | |", [("LINT001", "B2")]),
    (CLOSE + "| Close | sample | 1 s | S | |\n| S, D | combineLatest | d | X | |\n| X | subscribe | | Print | |", [("LINT001", "B5")]),
    # a blank that the formula does not look at changes nothing
    (CLOSE + "| Close | forgetAfter | 1 s | R | |\n| R, D | combineLatest | d | X | |\n| X | subscribe | | Print | |", [("LINT001", "B5")]),
    (CLOSE + "| Close | forgetAfter | 1 s | R | |\n| R, D | combineLatest | IF(ISBLANK(r); BLANK; d) | X | |\n| X | subscribe | | Print | |", []),
    (CLOSE + "| Close | timestamp | | C | |\n| D | timestamp | | T | |\n| C, T | combineLatest | (t.v, t.t - c.t) | P | |\n"
     "| P | filter | p[1] < 1 | X | |\n| X | subscribe | | Print | |", []),
    # timestamps whose times nobody compares
    (CLOSE + "| Close | timestamp | | C | |\n| D | timestamp | | T | |\n| C, T | combineLatest | t.v - c.v | X | |\n| X | subscribe | | Print | |", [("LINT001", "B6")]),
    # both have gone through the same filter; map and filter with further inputs; totals
    (CLOSE + "| Close | map | close * 2 | A | |\n| Close | map | close * 3 | B | |\n| A, B | combineLatest | a + b | X | |\n| X | subscribe | | Print | |", []),
    (CLOSE + "| D, Close | map | close + d | X | |\n| X | subscribe | | Print | |", []),
    (CLOSE + "| D, Close | filter | close < d | X | |\n| X | subscribe | | Print | |", []),
    ("| Start | accumulate | | N | |\n| N, Red ball | combineLatest | n + redBall.x | X | |\n| X | subscribe | | Print | |", []),
    ("| Red ball, Head yaw | combineLatest | redBall.x + headYaw | X | |\n| X | subscribe | | Print | |", []),
    ("| Start, Words | combineLatest | words.word | X | |\n| X | subscribe | | Print | |", []),
]  # fmt: skip

FLOODED = [
    ("| Red ball | map | redBall.colour | C | |\n| C | subscribe | | Say | |", [("LINT002", "B3")]),
    ("| Red ball | filter | redBall.distance < 1 | C | |\n| C | subscribe | | Hello | |", [("LINT002", "B3")]),
    ("| Face | subscribe | | Hello | |", [("LINT002", "B2")]),
    ("| Head yaw | subscribe | | Say | |", [("LINT002", "B2")]),
    ("| Red ball | sample | 100 ms | C | |\n| C | subscribe | | Hello | |", [("LINT002", "B3")]),
    ("| Red ball | sample | 3 s | C | |\n| C | subscribe | | Hello | |", []),
    ("| Red ball | throttle | 3 s | C | |\n| C | subscribe | | Hello | |", []),
    ("| Red ball | map | redBall.colour | | |\n| | changes | | C | |\n| C | subscribe | | Say | |", []),
    ("| Face | once | face.id | F | |\n| F | subscribe | | Hello | |", []),
    ("| Red ball, Start | timeout | 5 s | F | |\n| F | subscribe | | Hello | |", []),
    ("| Slow ball | subscribe | | Hello | |", []),
    ("| Touch | subscribe | | Hello | |", []),
    ("| Hello done | subscribe | | Ask | |\n| Touch | subscribe | | Hello | |", [("LINT012", "A2")]),
    ("| Face, Start | accumulate | IF(ISBLANK(start); total + 1; 0) | N | |\n| N | filter | n = 3 | T | |\n| T | subscribe | | Hello | |", []),
    ("| Red ball | map | BLANK | Q | |\n| Q | subscribe | | Hello | |", []),
]  # fmt: skip

TRACKED = "| {a} | subscribe | | Head tracker | {p} |\n"
CONFLICTS = [
    # one value reaches both; two sensors that come again and again; a steady row and one event
    (DISTANCE + "| D | subscribe | | Head tracker | |\n| Red ball | subscribe | | Head and body tracker | |", [("LINT003", "D4")]),
    ("| Red ball | subscribe | | Head tracker | |\n| Face | subscribe | | Head tracker | |", [("LINT003", "D3")]),
    ("| Red ball | subscribe | | Head tracker | |\n| Start | subscribe | | Nod | |", [("LINT003", "D3")]),
    ("| Red ball | subscribe | | Head tracker | |\n| Start | subscribe | | Nod | 1 |", []),
    ("| Red ball | subscribe | | Head tracker | |\n| Start | subscribe | | Wave | |", []),
    # filters that exclude each other
    (DISTANCE + "| D | filter | d < 0.5 | N | |\n| D | filter | d >= 0.5 | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", []),
    (DISTANCE + "| D | filter | d < 0.5 | N | |\n| D | filter | NOT(d < 0.5) | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", []),
    (DISTANCE + "| D | filter | d < 0.5 | N | |\n| Red ball | filter | redBall.distance > 0.7 | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", []),
    (DISTANCE + "| D | filter | d <= 0.5 | N | |\n| D | filter | d >= 0.5 | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", [("LINT003", "D6")]),
    (DISTANCE + "| D | filter | d < 0.6 | N | |\n| D | filter | d >= 0.5 | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", [("LINT003", "D6")]),
    (DISTANCE + "| D | filter | OR(d < 0.5; d > 2) | N | |\n| D | filter | 0.5 <= d <= 2 | F | |\n| N | subscribe | | Head tracker | |\n| F | subscribe | | Head and body tracker | |", []),
    ('| Touch | filter | touch.zone = "Head" | A | |\n| Touch | filter | touch.zone = "Chest" | B | |\n| A | subscribe | | Nod | |\n| B | subscribe | | Stand | |', []),
    ('| Touch | filter | touch.zone = "Head" | A | |\n| Touch | filter | touch.zone <> "head" | B | |\n| A | subscribe | | Nod | |\n| B | subscribe | | Stand | |', []),
    ('| Touch | filter | touch.pressed | A | |\n| Touch | filter | NOT(touch.pressed) | B | |\n| A | subscribe | | Nod | |\n| B | subscribe | | Stand | |', []),
    ('| Touch | filter | touch.pressed | A | |\n| Touch | filter | touch.zone = "Head" | B | |\n| A | subscribe | | Nod | |\n| B | subscribe | | Stand | |', [("LINT003", "D5")]),
    ('| Words, Start | filter | words.word = start.label | A | |\n| Words, Start | filter | words.word <> start.label | B | |\n| A | subscribe | | Nod | |\n| B | subscribe | | Stand | |', []),
    # different events in one behaviour; a row that follows the other's end
    ("| Start | subscribe | | Nod | |\n| Touch | subscribe | | Stand | |", []),
    ("| Start | subscribe | | Nod | |\n| Nod done | subscribe | | Stand | |", []),
    # speech: told, not warned of
    ("| Start | subscribe | | Hello | |\n| Start | map | start.label | L | |\n| L | subscribe | | Ask | |", [("LINT004", "D4")]),
    ("| Start | subscribe | | Hello | |\n| Touch | subscribe | | Ask | |", [("LINT012", "A3")]),
    # the eyes: how bright, and in which colour, are two things
    ("| Red ball | map | redBall.colour | C | |\n| C | subscribe | | Eye LED color | |\n| Red ball | map | CLAMP(redBall.x; 0; 1) | B | |\n| B | subscribe | | Eye brightness | |", []),
    ('| Red ball | map | "red" | C | |\n| C | subscribe | | Eye LED color | |\n| Red ball | map | "blue" | B | |\n| B | subscribe | | Eye LED color | |', [("LINT003", "D5")]),
    # a state decides
    ('| Words | map | words.word | Mode | |\n| Red ball, Mode | filter | mode = "yes" | A | |\n| Face, Mode | filter | mode = "no" | B | |\n| A | subscribe | | Head tracker | |\n| B | subscribe | | Head tracker | |', []),
    # what stops is in nobody's way
    ("| Red ball | subscribe | | Head tracker | |\n| Start | map | BLANK | Q | |\n| Q | subscribe | | Nod | |", []),
    ('| Red ball | map | "red" | C | |\n| C | subscribe | | Eye LED color | |\n| C | forgetAfter | 2 s | F | |\n| F | filter | ISBLANK(f) | N | |\n| N | map | "white" | W | |\n| W | subscribe | | Eye LED color | |', []),
    # two joints of the head
    ("| Red ball | map | redBall.x | A | |\n| A | subscribe | | Neck | |\n| Red ball | map | redBall.y | B | |\n| B | subscribe | | Nodding | |", []),
    ("| Red ball | map | redBall.x | A | |\n| A | subscribe | | Neck | |\n| Red ball | map | (redBall.x, 0) | B | |\n| B | subscribe | | Head joints | |", [("LINT003", "D5")]),
    # which gesture it is decides what it uses
    ('| Start | map | "Point left" | G | |\n| G | subscribe | | Show | |\n| Start | subscribe | | Nod | |', []),
    ('| Start | map | "Bow" | G | |\n| G | subscribe | | Show | |\n| Start | subscribe | | Nod | |', [("LINT003", "D4")]),
]  # fmt: skip

NEVER = [
    (DISTANCE + "| D | filter | d < 0.5 and d > 1 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C3")]),
    (CLOSE + "| Close | filter | close > 1 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C4")]),
    (DISTANCE + "| D | filter | d < 0 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C3")]),
    ("| Red ball | filter | redBall.distance < -1 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    ('| Red ball | filter | redBall.color = "yellow" | X | |\n| X | subscribe | | Print | |', [("LINT005", "C2")]),
    ('| Red ball | filter | redBall.colour = "Green" | X | |\n| X | subscribe | | Print | |', []),
    (CLOSE + "| Close | filter | close > 0.3 | X | |\n| X | subscribe | | Print | |", []),
    ("| Head yaw | filter | headYaw > 3 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    ("| Head yaw | filter | headYaw > 2 | X | |\n| X | subscribe | | Print | |", []),
    ('| Words | filter | words.word = "maybe" | X | |\n| X | subscribe | | Print | |', [("LINT005", "C2")]),
    ('| Words | filter | words.word = "Yes" | X | |\n| X | subscribe | | Print | |', []),
    ('| Touch | filter | touch.zone = "Nose" | X | |\n| X | subscribe | | Print | |', [("LINT005", "C2")]),
    ("| Red ball | filter | FALSE | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    ("| Red ball | filter | ISBLANK(redBall) | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    ("| Red ball | forgetAfter | 1 s | R | |\n| R | filter | ISBLANK(r) | X | |\n| X | subscribe | | Print | |", []),
    ("| Hello done | subscribe | | Print | |", [("LINT007", "A2")]),
    ("| Hello done | subscribe | | Print | |\n| Touch | subscribe | | Hello | |", []),
]  # fmt: skip

MIXED = [
    ('| Red ball | map | 1 | A | |\n| Start | map | "x" | B | |\n| A, B | merge | | M | |\n| M | subscribe | | Print | |', [("LINT006", "A4")]),
    ('| Red ball | map | 1 | A | |\n| Start | map | "x" | B | |\n| A, B | merge | | M | |\n| M | subscribe | | Stand | |', []),
    ("| Touch, Start | merge | | M | |\n| M | subscribe | | Stand | |", []),
    ("| Red ball, Head yaw | merge | | M | |\n| M | map | m.x + 1 | X | |\n| X | subscribe | | Print | |", [("LINT006", "A2")]),
    ("| Red ball, Green ball | merge | | M | |\n| M | map | m.x + 1 | X | |\n| X | subscribe | | Print | |", []),
]  # fmt: skip

TAKING = [
    ("| Start | map | (1, 2) | X | |\n| X | subscribe | | Say | |", [("LINT012", "A3")]),
    ("| Start | subscribe | | Say | |", [("LINT012", "A2")]),
    ("| Start | subscribe | start.label | Say | |", []),
    ("| Start | subscribe | start.count | Say | |", []),
    ("| Start | subscribe | start.count > 1 | Say | |", [("LINT012", "C2")]),
    ("| Start | subscribe | start.label | Neck | |", [("LINT012", "C2")]),
    ("| Start | subscribe | 0.5 | Neck | |", []),
    ("| Start | subscribe | 2.5 | Neck | |", [("LINT013", "C2")]),
    ("| Start | subscribe | 90° | Neck | |", []),
    ("| Start | subscribe | 180° | Neck | |", [("LINT013", "C2")]),
    ("| Start | subscribe | IF(start.count > 1; 0.5; -2.5) | Neck | |", [("LINT013", "C2")]),
    ("| Start | subscribe | start.count / 4 | Neck | |", []),
    ("| Start | subscribe | start.count * 4 | Neck | |", [("LINT013", "C2")]),
    ("| Start | subscribe | CLAMP(start.count * 4; -2; 2) | Neck | |", []),
    ("| Start | subscribe | (0, 0.5) | Head joints | |", []),
    ("| Start | subscribe | (0, 0.6) | Head joints | |", [("LINT013", "C2")]),
    ("| Start | subscribe | (1.5, 0.4) | Head joints | |", [("LINT013", "C2")]),
    ("| Start | subscribe | (1.5, 0.1) | Head joints | |", []),
    ("| Start | subscribe | 0.5 | Head joints | |", [("LINT012", "C2")]),
    ("| Start | subscribe | IF(start.count > 1; (0, 0.6); (0, 0.5)) | Head joints | |", [("LINT013", "C2")]),
    ("| Start | subscribe | (0, start.count * 4) | Head joints | |", [("LINT013", "C2")]),
    ("| Start | subscribe | 1 | Eye LED color | |", [("LINT012", "C2")]),
    ('| Start | subscribe | "redd" | Eye LED color | |', [("LINT012", "C2")]),
    ('| Start | subscribe | "#ff0000" | Eye LED color | |', []),
    ("| Start | subscribe | (1, 0, 300) | Eye LED color | |", [("LINT012", "C2")]),
    ("| Start | subscribe | 3 | Eye brightness | |", [("LINT013", "C2")]),
    ('| Start | subscribe | "soon" | Rest | |', [("LINT012", "C2")]),
    ('| Start | subscribe | "8 s" | Rest | |', []),
    ('| Start | subscribe | "Wav" | Show | |', [("LINT012", "C2")]),
    ('| Start | subscribe | "Wave" | Show | |', []),
    ("| Touch | subscribe | | Show | |", [("LINT012", "A2")]),
    ("| Start | subscribe | | Show | |", [("LINT012", "A2")]),
    ("| Touch, Start | merge | | M | |\n| M | subscribe | | Show | |", []),
    ("| Red ball | throttle | 3 s | B | |\n| B | subscribe | | Show | |", []),
    ("| Start | subscribe | | Eye LED color | |", [("LINT012", "A2")]),
    ("| Red ball | subscribe | | Eye LED color | |", []),
    ('| Start | subscribe | "Standinit" | Pose | |', []),
    ('| Start | subscribe | "Lotus" | Pose | |', [("LINT012", "C2")]),
    ("| Start | subscribe | | Pose | |", [("LINT012", "A2")]),
    ("| Start | subscribe | | Stand | |", []),
    ("| Start | subscribe | | Head tracker | |", [("LINT014", "D2")]),
    ("| Start, Red ball | map | redBall.x | X | |\n| X | subscribe | | Head tracker | |", []),
    ("| Start | subscribe | BLANK | Say | |", []),
]  # fmt: skip

NEVER_EQUAL = [
    # the formula of a row that follows the colour of Ball, what is never equal, and the formula as the fix writes it
    ("map", 'IF(col = "赤"; 1; 2)', ["赤"], 'IF(col = "red"; 1; 2)'),
    ("map", 'IF(col = "赤"; "赤"; "青")', ["赤"], 'IF(col = "red"; "赤"; "青")'),
    ("map", 'IF("Gren" <> col; 1; 2)', ["Gren"], 'IF("green" <> col; 1; 2)'),
    ("map", 'IF(col = "rot"; 1; 2)', ["rot"], None),
    ("map", 'IF(col = "赤" or col = "赤"; 1; 2)', ["赤"], None),  # which of them is not decided
    ("map", 'col in ["red"; "青"]', ["青"], 'col in ["red"; "blue"]'),
    ("map", 'SWITCH(col; "red"; 1; "緑"; 2)', ["緑"], 'SWITCH(col; "red"; 1; "green"; 2)'),
    ("accumulate", 'total + IF(col = "青"; 1; 0)', ["青"], 'total + IF(col = "blue"; 1; 0)'),
    ("filter", 'col = "赤"', ["赤"], 'col = "red"'),
    ("filter", 'col = "赤" or col = "blue"', ["赤"], 'col = "red" or col = "blue"'),
    ("once", 'IF(col = "赤"; 1; 2)', ["赤"], 'IF(col = "red"; 1; 2)'),
    ("map", 'IF(col = "RED"; 1; 2)', [], None),
    ("map", 'IF(col = LOWER("赤"); "赤"; "青")', [], None),
    ("map", 'col & "" = "赤"', [], None),
]  # fmt: skip


@pytest.mark.parametrize(("connector", "formula", "texts", "corrected"), NEVER_EQUAL)
def test_a_text_that_what_it_is_compared_with_never_is(connector, formula, texts, corrected):
    row = f"| Ball | map | ball.colour | Col | |\n| Col | {connector} | {formula} | X | |"
    found = list(check(rows(f"{row}\n| X | subscribe | | Print | |", header=HEADER)).report)
    assert [(d.code, str(d.address)) for d in found] == [("LINT005", "T!C3")] * len(texts)
    assert all("can only be “red”, “green” or “blue”" in str(d.message) for d in found)
    fixes = [edit.text for d in found for fix in d.fixes for edit in fix.edits]
    assert fixes == ([corrected] if corrected else [])


@pytest.mark.parametrize(("call", "expected"), [
    ("reddish(ball.colour)", [("LINT005", "C2")]), ('reddish(ball.colour) or reddish("赤")', []),
    ('reddish(ball.distance & "")', []),
])  # fmt: skip
def test_a_text_in_a_helper_that_no_row_gives_it(call, expected):
    helpers = '\n## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| reddish | what | what = "赤" |\n'
    found = check(rows(f"| Ball | map | {call} | X | |\n| X | subscribe | | Print | |", helpers, header=HEADER)).report
    assert [(d.code, d.address.cell) for d in found] == expected
    assert {d.address.sheet for d in found} == ({"Helpers"} if expected else set())


@pytest.mark.parametrize(("given", "expected"), [
    ('"ja"', []), ('start.count & ""', []), ('IF(start.count > 1; "ja"; "nein")', []),
    ('IF(start.count > 1; "no"; "nein")', [("LINT005", "C5")]),
])  # fmt: skip
def test_a_text_is_compared_with_all_that_rows_give(given, expected):
    text = f"| Start | map | {given} | A | |\n| Words | map | words.word | B | |\n| A, B | merge | | C | |\n"
    assert lints(text + '| C | map | IF(c = "ja"; 1; 2) | X | |\n| X | subscribe | | Print | |') == expected


def test_a_japanese_text_that_a_sensor_never_gives_is_told_as_it_is_typed():
    row = '| Bumper | map | IF(bumper.zone = "左手"; 1; 2) | X | |\n| X | subscribe | | Print | |'
    (found,) = check(rows(row, header=HEADER)).report
    assert found.code == "LINT005" and "“左手” never occurs" in str(found.message)


@pytest.mark.parametrize(("text", "meant"), [("head\\e", "head\\d"), ("ha nds", 'ha ""nd'), ("foot", "")])
def test_a_text_that_no_row_of_a_table_has(text, meant):
    parts = '\n## Parts\n| Zone |\n|---|\n| head\\d |\n| ha "nd |\n| foot |\n'
    formula = 'IF(PICK(Parts).zone = "{}"; 1; 2)'
    row = f"| Touch | map | {formula.format(text)} | X | |\n| X | subscribe | | Print | |"
    found = check(rows(row, parts, header=HEADER)).report
    assert [d.code for d in found] == (["LINT005"] if meant else [])
    assert [e.text for d in found for f in d.fixes for e in f.edits] == ([formula.format(meant)] if meant else [])


FREE = '| Touch, Ask done | filter | askDone.completed | Free | |\n| Free | subscribe | "Hi" | Ask | |'
WAITING = [
    (FREE, [("LINT017", "A2")]),
    ('| Start | subscribe | "Hello" | Ask | |\n' + FREE, []),
    ("| Touch, Ask done | merge | | Any | |\n| Any | throttle | 3 s | T | |\n| T | subscribe | \"Hi\" | Ask | |", []),
    ('| Touch, Ask done | once | | T | |\n| T | subscribe | "Hi" | Ask | |', []),
    ('| Ask done | subscribe | "Hi" | Ask | |', [("LINT017", "A2")]),
    ('| Touch, Ask done | subscribe | "Hi" | Ask | |', [("LINT017", "A2")]),
    ("| Touch, Ask done | combineLatest | | B | |\n| B | map | \"Hi\" | T | |\n| T | subscribe | | Ask | |",
     [("LINT017", "A2")]),
    # two that wait for each other are one mistake
    ('| Wave done | subscribe | "Hi" | Ask | |\n| Ask done | subscribe | | Wave | |', [("LINT017", "A2")]),
    ('| Wave done | subscribe | "Hi" | Ask | |\n| Ask done | subscribe | | Wave | |\n| Start | subscribe | | Wave | |', []),
    # what follows from such a row is not told again; an end that no row causes may come from elsewhere
    (FREE + "\n| Free, Touch | merge | | M | |\n| M | subscribe | | Print | |\n| Free | subscribe | | Print | |",
     [("LINT017", "A2")]),
    ("| Touch, Ask done | filter | askDone.completed | F | |\n| F | subscribe | | Print | |", []),
    ("| Touch, Ask done | filter | askDone.completed | F | |\n| F, Start | merge | | M | |\n"
     '| M | throttle | 3 s | T | |\n| T | subscribe | "Hi" | Ask | |', []),
]  # fmt: skip

FORMULAS = [
    ('| Red ball | map | redBall.x + "a" | X | |\n| X | subscribe | | Neck | |', [("LINT010", "C2")]),
    ("| Red ball | map | 1 / (redBall.x - 0.1) | X | |\n| X | subscribe | | Print | |", [("LINT010", "C2")]),
    ("| Red ball | map | redBall.x & 1 | X | |\n| X | subscribe | | Print | |", []),
    ("| Start | filter | start.label | X | |\n| X | subscribe | | Print | |", [("LINT011", "C2")]),
    ("| Start | filter | (1, 2) | X | |\n| X | subscribe | | Print | |", [("LINT011", "C2")]),
    ("| Start | filter | start.count | X | |\n| X | subscribe | | Print | |", []),
    # a formula after a filter that keeps the example back, a done stream's value: nothing can be said
    ("| Red ball | map | redBall.distance | D | |\n| D | filter | d > 2 | F | |\n| F | map | SQRT(f - 2) | X | |\n| X | subscribe | | Print | |", []),
    ("| Hello done | map | helloDone.value + 1 | X | |\n| X | subscribe | | Print | |\n| Start | subscribe | | Hello | |", []),
    ("| Start, Touch | accumulate | IF(ISBLANK(start); total + touch.zone; 0) | N | |\n| N | subscribe | | Print | |", [("LINT010", "C2")]),
]  # fmt: skip


PASSING = [
    ("| Red ball | filter | 3 | X | |\n| X | subscribe | | Print | |", [("LINT015", "C2")]),
    ("| Red ball | filter | TRUE | X | |\n| X | subscribe | | Print | |", [("LINT015", "C2")]),
    ("| Red ball | filter | 2 > 1 | X | |\n| X | subscribe | | Print | |", [("LINT015", "C2")]),
    ('| Red ball | filter | LEN("ab") | X | |\n| X | subscribe | | Print | |', [("LINT015", "C2")]),
    ("| Red ball | filter | ABS(redBall.x) + 1 | X | |\n| X | subscribe | | Print | |", [("LINT015", "C2")]),
    ("| Red ball | accumulate | | Balls | |\n| Balls | filter | balls | X | |\n| X | subscribe | | Print | |", [("LINT015", "C3")]),
    # after a second without any, the count is blank, and blank does not pass
    ("| Red ball | accumulate | | Balls | |\n| Balls | forgetAfter | 1 s | B | |\n| B | filter | b | X | |\n| X | subscribe | | Print | |", []),
    ("| Red ball | filter | 0 | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    ("| Red ball | filter | BLANK | X | |\n| X | subscribe | | Print | |", [("LINT005", "C2")]),
    # a number that may be 0, a random one, what may be blank: sometimes it is kept back
    ("| Red ball | filter | ABS(redBall.x) | X | |\n| X | subscribe | | Print | |", []),
    ("| Red ball | filter | redBall.x | X | |\n| X | subscribe | | Print | |", []),
    ("| Red ball | filter | PICK(TRUE; FALSE) | X | |\n| X | subscribe | | Print | |", []),
    ("| Red ball | filter | redBall.x > 0 | X | |\n| X | subscribe | | Print | |", []),
]  # fmt: skip


SPOKEN = [
    # text, language of Say, cell
    ('| Start | subscribe | "こんにちは" | Ask | |', "", [("LINT018", "C2")]),
    ('| Start | subscribe | "質問一" | Ask | |', "en-us", [("LINT018", "C2")]),
    ('| Start | subscribe | "Red は 赤" | Ask | |', "de", [("LINT018", "C2")]),
    ('| Start | map | IF(start.count > 1; "また会いましたね"; "はじめまして") | Text | |\n| Text | changes | | New | |\n| New | subscribe | | Ask | |', "", [("LINT018", "C2")]),
    ('| Start, Touch | merge | | Any | |\n| Any | map | "はい" | Text | |\n| Text | subscribe | | Ask | |\n| Text | subscribe | | Print | |', "", [("LINT018", "C3")]),
    ('| Start | subscribe | "ボタン" & start.count | Ask | |\n| Touch | subscribe | "足" | Ask | |', "", [("LINT018", "C2")]),
    ('| Start | subscribe | "こんにちは" | Ask | |\n| Touch | subscribe | "Please touch my head" | Ask | |', "", [("LINT018", "C2")]),
    ('| Start | subscribe | "こんにちは" | Ask | |\n| Touch | subscribe | "Please touch my head" | Ask | |', "ja", [("LINT018", "C3")]),
    ('| Start | subscribe | "Please touch my head" | Ask | |', "ja", [("LINT018", "C2")]),
    ('| Start | subscribe | "Well done, number " & start.count | Ask | |', "ja", [("LINT018", "C2")]),
    ('| Start | subscribe | "ボール " & start.label | Ask | |', "ja", []),
    ('| Start | subscribe | "Hello, NAO" | Ask | |', "ja", []),
    ('| Start | subscribe | "Red ball は赤いボールです" | Ask | |', "ja", []),
    ('| Start | subscribe | "你好" | Ask | |', "cmn", []),
    ('| Start | subscribe | "Please touch my head" | Ask | |', "", []),
    ('| Start | subscribe | "Dziękuję bardzo, café!" | Ask | |', "", []),
    ('| Start | map | "こんにちは" | 挨拶 | |\n| 挨拶 | subscribe | | Print | |', "", []),
    ('| Start | subscribe | BLANK | Ask | |', "ja", []),
]  # fmt: skip


@pytest.mark.parametrize(("text", "language", "expected"), SPOKEN)
def test_texts_in_letters_that_the_voice_does_not_read(text, language, expected):
    devices = "\n## Devices\n| Stream | Device | Label | Language |\n|---|---|---|---|\n"
    devices += f"| Start | Operator button | Start | |\n| Ask | Say | | {language} |\n"
    assert findings(rows(text, devices, header=HEADER)) == expected


def test_texts_of_endless_helpers_are_followed_only_so_far():
    helpers = "".join(f"| h{i} | | h{i + 1} & h{i + 1} & h{i + 1} |\n" for i in range(15)) + '| h15 | | "はい" |'
    helpers = f"\n## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n{helpers}\n"
    assert ("LINT018", "C2") in lints("| Start | subscribe | h0 | Ask | |", helpers)


@pytest.mark.parametrize(("text", "expected"), PASSING)
def test_a_filter_that_chooses_nothing(text, expected):
    assert lints(text) == expected


@pytest.mark.parametrize(("text", "expected"), STALE)
def test_old_values_with_new_ones(text, expected):
    assert [f for f in lints(text) if f[0] == "LINT001"] == expected


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), FLOODED)
def test_endless_speech(text, expected):
    assert lints(text) == expected


@pytest.mark.parametrize(("text", "expected"), CONFLICTS)
def test_rows_in_each_others_way(text, expected):
    assert lints(text) == expected


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), NEVER)
def test_what_never_happens(text, expected):
    assert lints(text) == expected


@pytest.mark.parametrize(("text", "expected"), MIXED)
def test_different_kinds_of_values_joined(text, expected):
    assert lints(text) == expected


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), WAITING)
def test_rows_that_wait_for_themselves(text, expected):
    assert [f for f in lints(text) if f[0] == "LINT017"] == expected


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), [case for case in WAITING if "| Ask |" in case[0]])
def test_the_engine_agrees_on_which_rows_wait_for_themselves(text, expected):
    touches = [(1000.0 * n, "Touch", example("Touch")) for n in range(5)]
    presses = [(1000.0 * n + 500, "Start", example("Operator button")) for n in range(5)]
    played = play(rows(text, DEVICES, header=HEADER), sorted(touches + presses, key=lambda event: event[0]))
    assert bool(played["Ask"] or played["Wave"]) is not bool(expected)


@pytest.mark.parametrize(("text", "expected"), TAKING)
def test_values_that_an_actuator_cannot_use(text, expected):
    assert lints(text) == expected


@pytest.mark.parametrize(("text", "expected"), FORMULAS)
def test_formulas_that_will_not_do(text, expected):
    assert lints(text) == expected


def test_two_behaviours_are_warned_of_once_and_priority_decides():
    one = "| Touch | subscribe | | Wave | {p} |\n| Touch | subscribe | | Nod | {p} |"
    other = f"## U\n{HEADER}| Start | subscribe | | Wave | |\n| Start | subscribe | | Nod | |\n"
    found = lints(one.format(p=""), other)
    assert found == [("LINT003", "D2"), ("LINT003", "D3")]  # the right arm, and the head
    assert lints(one.format(p="1"), other) == []
    switched = other + "\n## Protocol\n| Field | Value |\n|---|---|\n| Run | T |\n"
    assert lints(one.format(p=""), switched) == []


HELPERS = "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n"


@pytest.mark.parametrize(
    ("lines", "use", "expected"),
    [
        ("| Twice | x | 2 * x |", "twice(redBall.x)", []),
        ("| Twice | x | 2 * x |\n| Unused | x | x |", "twice(redBall.x)", [("LINT008", "A3")]),
        ("| Twice | x | thrice(x) |\n| Thrice | x | 3 * x |", "twice(redBall.x)", []),
        ("| Twice | x, y | 2 * x |", "twice(redBall.x, 1)", [("LINT009", "C2")]),
        ("| Trials | | 4 |", "redBall.x < trials", []),
    ],
)
def test_helpers(lines, use, expected):
    assert lints(f"| Red ball | map | {use} | X | |\n| X | subscribe | | Print | |", HELPERS + lines) == expected


@pytest.mark.slow
@pytest.mark.parametrize("path", sorted(bundled("workbooks").glob("*.xlsx")), ids=lambda p: p.stem)
def test_the_workbooks_that_come_with_the_program_hold_one_mistake_only(path: Path):
    found = [d.code for d in api.check(path).report if d.code.startswith("LINT")]
    assert found == (["LINT001"] if path.stem == "complex-tracking" else [])


def test_the_stale_combination_is_told_with_its_rows():
    report = api.check(bundled("workbooks", "complex-tracking.xlsx")).report
    (finding,) = [d for d in report if d.code == "LINT001"]
    assert "row 5" in finding.message and "Row 10" in finding.message and "Close ball" in finding.message
    assert len(finding.fixes) == 2 and not any(f.safe for f in finding.fixes)


def test_a_circle_of_rows_or_many_equal_rows_do_not_stop_the_lints():
    many = "\n".join("| Red ball | subscribe | | Head tracker | |" for _ in range(300))
    assert {code for code, _ in lints(many)} <= {"LINT003"}
    assert check(rows("| B | map | b | A | |\n| A | filter | a | B | |", header=HEADER)).report.errors


def test_a_value_and_the_limit_that_it_passes_look_different():
    (found,) = list(check(rows("| Start | subscribe | 120° | Neck | |", DEVICES, header=HEADER)).report)
    assert found.code == "LINT013" and found.message.startswith("2.094 is outside") and "2.086" in found.message


def test_many_rows_that_wait_for_themselves_are_found_at_once():
    text = '| Ask done | subscribe | "Hi" | Ask | |\n' * 1500  # looking behind each of them anew took minutes
    assert [f for f in lints(text) if f[0] == "LINT017"] == [("LINT017", "A2")]


SPEAKS_ALWAYS = "| Red ball | map | redBall.distance | D | |\n| D | subscribe | | Say | |\n"
WAITS = '| Say done | map | "a" | Q | |\n| Q | subscribe | | Say | |\n'
TEST = "## Try\n| Time (ms) | Stream | Send | Expect |\n|---|---|---|---|\n"
OTHER = HEADER + "| Chest button | map | 1 | Left over | |\n"


@pytest.mark.parametrize(
    ("text", "more", "expected"),
    [
        # an unused row, in another sheet or in the same one
        (SPEAKS_ALWAYS, ["## Other", OTHER], [("LINT002", "B3"), ("GRAPH011", "D2")]),
        (SPEAKS_ALWAYS + "| Chest button | map | 1 | Left over | |", [], [("LINT002", "B3"), ("GRAPH011", "D4")]),
        (SPEAKS_ALWAYS, ["## Other", OTHER, "## Protocol\n| Run | T |\n"], [("LINT002", "B3"), ("GRAPH011", "D2")]),
        (WAITS + '| Say done | map | "a" | Q2 | |', [], [("LINT017", "A2"), ("GRAPH011", "D4")]),
        # what is said of the unused row itself waits until it is used
        ("| Red ball | filter | 1 | X | |", [], [("GRAPH011", "D2")]),
        # a period that was meant in seconds: other rows, and those after it
        (SPEAKS_ALWAYS + "| Red ball | sample | 3 | X | |\n| X | subscribe | | Print | |", [],
         [("LINT002", "B3"), ("CONN010", "C4")]),
        ("| Red ball | throttle | 10 | X | |\n| X | map | \"a\" | Y | |\n| Y | subscribe | | Say | |", [], [("CONN010", "C2")]),
        # a sheet whose rows are all off, and a row that waits for what it does
        ("| Say done | map | \"a\" | Q | |\n| Q | subscribe | | Print | |\n" + SPEAKS_ALWAYS.replace("Say", "Ask"),
         [DEVICES, "## Off\n| On " + HEADER.replace("\n|", "\n|---|") + "| no | Red ball | subscribe | \"a\" | Say | |"],
         [("LINT002", "B5"), ("GRAPH014", "B1")]),
        # a helper that hides a function: other rows, and those that call it
        (SPEAKS_ALWAYS + "| Red ball | filter | ABS(redBall) | X | |\n| X | subscribe | | Print | |",
         ['## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Abs | x | "text" |'],
         [("LINT002", "B3"), ("FORM012", "A2")]),
        # a helper that calls it, and a row that would be in the way of one that depends on it
        ("| Chest button | map | deep(1) | X | |\n| X | subscribe | | Head yaw | |\n"
         "| Chest button | map | 0.5 | Y | |\n| Y | subscribe | | Head yaw | |",
         ["## Devices\n| Stream | Device | Joint |\n|---|---|---|\n| Head yaw | SetJointPosition | HeadYaw |",
          "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| Deep | x | deeper(x) |\n"
          "| Deeper | x | max(x) |\n| Max | x | x |"],
         [("FORM012", "A4")]),
    ],
)  # fmt: skip
def test_a_warning_hides_only_the_lints_of_what_depends_on_its_row(text, more, expected):
    assert findings(rows(text, *more, header=HEADER)) == expected


WRONG = "| Red bal | map | 1 | W | |\n| W | subscribe | | Print | |\n"
SPEAKS_OTHER = "| Red ball | map | redBall.distance | D | |\n| D | subscribe | | Talk | |\n"
TALK = "## Devices\n| Stream | Device | Speed |\n|---|---|---|\n"


@pytest.mark.parametrize(
    ("text", "more", "expected"),
    [
        # beside what an error has nothing to do with, also in another sheet
        (SPEAKS_ALWAYS + WRONG, [], [("GRAPH001", "A4"), ("LINT002", "B3")]),
        (SPEAKS_ALWAYS, ["## Other", HEADER + WRONG], [("GRAPH001", "A2"), ("LINT002", "B3")]),
        (SPEAKS_ALWAYS + "| Red ball | mapp | 1 | W | |\n| W | subscribe | | Print | |", [], [("CONN002", "B4"), ("LINT002", "B3")]),
        # rows that depend on it: by its output, its formula, a helper, one of several inputs, through further rows
        (SPEAKS_ALWAYS.replace("distance", "distence"), [], [("FORM007", "C2")]),
        ("| Red ball | map | far(redBall.distance) | D | |\n| D | subscribe | | Say | |",
         ["## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| far | x | x + |"], [("FORM001", "C2")]),
        ("| Red bal | map | 1 | X | |\n| X, Red ball | merge | | M | |\n| M | map | 1 | N | |\n| N | subscribe | | Say | |", [], [("GRAPH001", "A2")]),
        # two rows in each other's way, and one of them is not yet what is meant
        ('| Red ball | map | "a" | Q | |\n| Q | subscribe | | Say | |\n| Red ball | map | "b" | R | |\n| R | subscribe | r.x | Say | |',
         [], [("FORM021", "C5"), ("LINT002", "B3")]),
        # a device with a wrong setting, and another one; a device without a name can be any
        (SPEAKS_ALWAYS + SPEAKS_OTHER.replace("| D", "| E").replace("D |", "E |"), [TALK + "| Talk | Say | quick |"],
         [("DEV004", "C2"), ("LINT002", "B3")]),
        (SPEAKS_ALWAYS, [TALK + "| | Say | |"], [("DEV005", "A2")]),
        # the robot
        (SPEAKS_ALWAYS, ["## Protocol\n| Field | Value |\n|---|---|\n| Robot | neo |"], [("PROT001", "B2")]),
        # what no row does is told when all rows are understood
        (WAITS + WRONG, [], [("GRAPH001", "A4")]),
        ("| Say done | subscribe | | Print | |\n" + WRONG, [], [("GRAPH001", "A3")]),
        (WRONG, ["## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| far | | 1 |"], [("GRAPH001", "A2")]),
        # what no row takes: unless a row takes something that is not understood
        ("| Red ball | map | 1 | Unused | |\n| Red ball | map | redBall.distence | W | |\n| W | subscribe | | Print | |", [],
         [("FORM007", "C3"), ("GRAPH011", "D2")]),
        ("| Red ball | map | 1 | Unused | |\n| Red ball | mapp | 1 | W | |\n| W | subscribe | | Print | |", [],
         [("CONN002", "B3"), ("GRAPH011", "D2")]),
        ("| Red ball | map | 1 | Unused | |\n" + WRONG, [], [("GRAPH001", "A3")]),
        ("| Red ball | map | 1 | Unused | |\n| Red ball | merge | | W | |\n| W | subscribe | | Print | |", [], [("CONN003", "A3")]),
        # tests, where the formula of a row is wrong, and where a row may have another name
        ("| Red ball | map | redBall.distence | W | |\n| W | subscribe | | Print | |", [TEST + "| 0 | Red bal | | 1 |"],
         [("FORM007", "C2"), ("TEST002", "B2")]),
        (WRONG, [TEST + "| 0 | V | | 1 |"], [("GRAPH001", "A2")]),
    ],
)  # fmt: skip
def test_an_error_hides_only_what_may_follow_from_it_and_it_is_said_that_checks_wait(text, more, expected):
    report = check(rows(text, *more, header=HEADER)).report
    assert report.flatten(["code", "cell"]) == expected
    assert checks_wait(report)


def test_an_error_of_the_protocol_that_no_row_depends_on_lets_no_check_wait():
    protocol = "## Protocol\n| Field | Value |\n|---|---|\n| Seed | many |"
    report = check(rows(WAITS, TEST + "| 0 | Nobody | | 1 |", protocol, header=HEADER)).report
    assert report.flatten(["code", "cell"]) == [("TEST002", "B2"), ("PROT005", "B2"), ("LINT017", "A2")]
    assert not checks_wait(report)


def test_a_wrong_setting_hides_only_the_lints_of_its_device():
    speaks = SPEAKS_ALWAYS + "| Start | map | 3 | Three | |\n| Three | subscribe | | Pose | |"
    found = findings(rows(speaks, DEVICES.replace("Name", "Nmae"), header=HEADER))
    assert [f for f in found if f[0].startswith("LINT")] == [("LINT002", "B3"), ("LINT012", "A5")]
    found = findings(
        rows(speaks, DEVICES.replace("| Pose | Posture | | | | |", "| Pose | Posture | | 2 s | | |"), header=HEADER)
    )
    assert [f for f in found if f[0].startswith("LINT")] == [("LINT002", "B3")]
    speaks = SPEAKS_ALWAYS.replace("Say", "Talk") + "| Red ball | subscribe | | Follow | |"
    devices = (
        "## Devices\n| Stream | Device | Speed |\n|---|---|---|\n| Talk | Say | 120 |\n| Follow | Head tracker | 50 |"
    )
    assert findings(rows(speaks, devices, header=HEADER)) == [("LINT002", "B3"), ("DEV007", "C3")]
