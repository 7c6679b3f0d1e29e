"""Names that are proposed for unknown ones: the same as an exhaustive search finds, and bounded in large workbooks."""

from __future__ import annotations

import difflib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from play import check, rows

from rrp_sheets.connectors import connectors
from rrp_sheets.formulas.functions import library
from rrp_sheets.help.topics import TOPICS
from rrp_sheets.model.names import Proposals, count_typos, is_near, key, nearest
from rrp_sheets.robots import load_robot

NAMES = st.text("abcd e", max_size=8)


@given(NAMES, st.lists(NAMES, max_size=20))
def test_the_nearest_name_is_that_of_the_exhaustive_search(name, candidates):
    by_key = {key(c): c for c in candidates if is_near(name, c)}
    close = difflib.get_close_matches(key(name), list(by_key), n=1, cutoff=0.66)
    assert nearest(name, candidates) == (by_key[close[0]] if close else None)


VOCABULARY = [
    *load_robot().device_names("sensor"), *load_robot().device_names("actuator"), *load_robot().gestures,
    *connectors().names(), *TOPICS,
]  # fmt: skip
GUESSES = [
    ("Red bal", "Red ball"), ("Tuch", "Touch"), ("Sonr", "Sonar"), ("Head trackr", "Head tracker"), ("Tiemr", "Timer"),
    ("Gestur", "Gesture"), ("Bumpr", "Bumper"), ("Waev", "Wave"), ("sampel", "sample"), ("subscibe", "subscribe"),
    ("combinelatst", "combineLatest"), ("acumulate", "accumulate"), ("trottle", "throttle"), ("CLMP", "CLAMP"),
    ("SQR", "SQRT"), ("XLOKUP", "XLOOKUP"), ("conectors", "connectors"), ("protokol", "protocol"), ("Orientaton", "Orientation"),
    ("Wrd recognised", "Word recognized"), ("Rember face", "Remember face"), ("Play sond", "Play sound"),
]  # fmt: skip
FAR = (
    "start", "begin", "stop", "hello", "music", "therapist", "happy", "yes", "session",
    "when the run begins", "every second", "password", "undo", "headset", "greeting", "joke", "goodbye", "うなずく",
)  # fmt: skip


@pytest.mark.parametrize(("typed", "meant"), GUESSES)
def test_a_misspelt_name_is_guessed(typed, meant):
    assert nearest(typed, [*VOCABULARY, *library().names()]) == meant


@pytest.mark.parametrize("typed", FAR)
def test_a_word_that_is_no_misspelt_name_is_not_guessed(typed):
    assert nearest(typed, VOCABULARY) is None


WORDS = [
    # the row, the code, what the remedy proposes, and what the fix writes
    ("| Start | subscribe | | Print |", "GRAPH001", "Did you mean Operator button or Timer?", ""),
    ("| Clock | subscribe | | Print |", "GRAPH001", "Did you mean Timer?", "Timer"),
    ("| Hand | subscribe | | Print |", "GRAPH001", "Did you mean Touch?", "Touch"),
    ("| 触る | subscribe | | Print |", "GRAPH001", "Did you mean Touch?", "Touch"),
    ("| Hear | subscribe | | Print |", "GRAPH001", "Declare “Hear” in the sheet Devices, with the device Word recognized", ""),
    ('| Touch | subscribe | "Hi" | Speak |', "GRAPH006", "Did you mean Say?", "Say"),
    ("| Touch | subscribe | | Nod |", "GRAPH006", "Declare “Nod” in the sheet Devices, with the device Gesture", ""),
    ("| Touch | subscribe | | Stop |", "GRAPH006", "Did you mean End run?", "End run"),
    ("| Tac | subscribe | | Print |", "GRAPH001", "Did you mean Touch?", "Touch"),
    ("| Ta | subscribe | | Print |", "GRAPH001", "Write the output stream of another row", ""),
    ("| Touch | subscribe | | 言う |", "GRAPH006", "Did you mean Say?", "Say"),
    ("| Touch | count | | N |\n| N | subscribe | | Print |", "CONN002", "Did you mean accumulate?", "accumulate"),
    ("| Touch | 数える | | N |\n| N | subscribe | | Print |", "CONN002", "Did you mean accumulate?", "accumulate"),
    # an output that nothing reads may have been called so before; a misspelt name of the workbook's own comes first
    ("| Distance | subscribe | | Print |\n| Touch | map | 1 | Far |", "GRAPH001", "Write the output stream of another row", ""),
    ("| Touch | map | 1 | Clocks |\n| Clock | subscribe | | Print |", "GRAPH001", "Did you mean Clocks?", "Clocks"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "code", "remedy", "written"), WORDS)
def test_plain_words_are_guessed_before_names_that_look_alike(text, code, remedy, written):
    found = next(d for d in check(rows(text)).report if d.code == code)
    assert found.remedy.startswith(remedy), found.remedy
    spelt = [fix.edits[0].new for fix in found.fixes if fix.id == "correct-spelling"]
    assert spelt == ([written] if written else [])


@pytest.mark.parametrize(
    ("heads", "typed", "meant"),
    [
        ("Stream | Device", "Tac", "Touch"),
        ("Stream | Device", "hea", ""),
        ("ストリーム | デバイス", "tac", "接触"),
        ("Stream | Device", "ta", ""),
    ],
)
def test_the_beginning_of_a_plain_word_of_a_device_is_enough(heads, typed, meant):
    header = {"header": "| 入力 | コネクター | 式 | 出力 |\n|---|---|---|---|\n"} if "Stream" not in heads else {}
    more = f"## Devices\n| {heads} |\n|---|---|\n| Pat | {typed} |\n"
    (found,) = [
        d for d in check(rows("| Red ball | subscribe | | Print |", more, **header)).report if d.code == "DEV001"
    ]
    assert [edit.new for fix in found.fixes for edit in fix.edits] == ([meant] if meant else [])


@given(NAMES, NAMES, st.integers(0, 6))
def test_slips_up_to_a_bound_are_those_without(first, second, most):
    every = count_typos(first, second)
    bounded = count_typos(first, second, most)
    assert bounded == every if every <= most else bounded > most


def test_proposals_end_when_very_many_names_were_looked_at():
    propose, names = Proposals(most=1_000), [f"Stream {i}" for i in range(300)]
    assert [propose("Streem 7", names) for _ in range(5)] == ["Stream 7"] * 4 + [None]


@pytest.mark.slow
def test_the_first_of_many_unknown_names_get_a_proposal_and_all_are_told():
    lines = [f"| Streem {i} | map | value | Stream {i} |" for i in range(800)]
    errors = check(rows("\n".join(lines))).report.errors
    proposed = ["Did you mean Stream" in d.remedy for d in errors]
    assert len(errors) == 800 and proposed[0] and proposed == sorted(proposed, reverse=True) and not proposed[-1]
