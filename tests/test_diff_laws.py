"""Laws of comparing: nothing differs from itself, spelling is no difference, both ways round the opposite is told."""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from examples import example_count
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from test_diff import BASE

from rrp_sheets import api
from rrp_sheets.compare import Comparison

NAMES = ["Red ball", "Blue ball", "Near", "Far", "ボール", "Calm"]
ROW = st.tuples(
    st.sampled_from(["", "", "no"]),
    st.sampled_from(["", "", "1"]),
    st.sampled_from(["", *NAMES, "Near, Far", "Far, Near", "Red ball, Calm"]),
    st.sampled_from(["map", "filter", "subscribe", "merge", "combineLatest", "sample", "once", "nothing"]),
    st.sampled_from(["", "value > 1", "near + far", "redBall.x", "ABS(value)", "1 s", "500", "near +", "=1"]),
    st.sampled_from(["", "", "Near", "Far", "ボール", "Calm", "Say", "Print", "Eye brightness"]),
    st.sampled_from(["", "", "a note"]),
)
SHEET = st.lists(ROW, min_size=1, max_size=12)
BOOK = st.dictionaries(st.sampled_from(["One", "Two", "三"]), SHEET, min_size=1, max_size=3)
BOUNDED = settings(max_examples=example_count(60), deadline=None, suppress_health_check=[HealthCheck.too_slow])


def text(
    book: dict[str, list[tuple[str, ...]]], headers: str = "On|Priority|Inputs|Connector|Formula|Output|Notes"
) -> str:
    out = ""
    for name, rows in book.items():
        out += f"## {name}\n|{headers}|\n|---|---|---|---|---|---|---|\n"
        out += "".join(f"|{'|'.join(row)}|\n" for row in rows) + "\n"
    return out


def compare(before: str, after: str) -> Comparison:
    with TemporaryDirectory() as folder:
        paths = Path(folder) / "a.md", Path(folder) / "b.md"
        for path, content in zip(paths, (before, after), strict=True):
            path.write_text(content, encoding="utf-8")
        return api.diff(*paths)


@pytest.mark.slow
@BOUNDED
@given(BOOK)
def test_nothing_differs_from_itself(book):
    assert compare(text(book), text(book) + "\n").changes == ()


OPPOSITE = {"added": "removed", "removed": "added", "on": "off", "off": "on"}


@pytest.mark.slow
@BOUNDED
@given(BOOK, BOOK)
def test_both_ways_round_the_opposite_is_told(first, second):
    there, back = compare(text(first), text(second)), compare(text(second), text(first))
    assert there.same == back.same
    mine = [(c.kind, c.part, c.rows, c.what, c.before, c.after, c.effect) for c in there.changes]
    other = [
        (OPPOSITE.get(c.kind, c.kind), c.part, c.rows[::-1], c.what, c.after, c.before, c.effect) for c in back.changes
    ]
    assert sorted(mine) == sorted(other)


@BOUNDED
@given(BOOK, st.data())
def test_every_row_is_accounted_for(book, data):
    """Rows taken out are told as removed, each of them, and no other."""
    name = data.draw(st.sampled_from(sorted(book)))
    at = data.draw(st.integers(0, len(book[name]) - 1))
    fewer = {**book, name: book[name][:at] + book[name][at + 1 :]}
    if not fewer[name] or not any(book[name][at][2:6]):
        return
    comparison = compare(text(book), text(fewer))
    rows = [c for c in comparison.changes if c.part == "row" and c.kind in ("added", "removed")]
    assert sum(c.kind == "removed" for c in rows) - sum(c.kind == "added" for c in rows) == 1
    assert len(rows) == 1


SPELLINGS = {
    "map": ["Map", "MAP"], "combineLatest": ["combine latest", "Combine_Latest"], "sample": ["SAMPLE"],
    "1000": ["1 s", "1000 ms", "1.0 s"], "redBall.distance": ["Red_Ball.Distance", "=redball . distance", "value.distance"],
    "steady < 20": ["steady<20", "Steady < 20.0", "value < 20"], "both > 0.5, True, False": ["both>.50,TRUE,false"],
    "distance * 2": ["distance*2"], "Distance": ["distance", "DISTANCE", "Dis tance"],
    "Eye brightness": ["EyeBrightness", "eye_brightness"], "no": ["FALSE", "off", "0"], "| 7 |": ["| 7.0 |"],
    "at 1, 0.2, 0.4": ["at 1.0,0.2,0.40"], "in 2 s": ["in 2 s"], "x < limit": ["X<LIMIT"],
}  # fmt: skip


@BOUNDED
@given(st.data())
def test_order_of_sheets_and_spelling_make_no_difference(data):
    sheets = ["## " + part for part in BASE.split("## ") if part.strip()]
    sheets = data.draw(st.permutations(sheets))
    after = "\n".join(sheets)
    for old in data.draw(st.sets(st.sampled_from(sorted(set(SPELLINGS) - {"| 7 |"})))):
        lines = after.split("\n")
        places = [i for i, line in enumerate(lines) if f"| {old} |" in line]
        for i in places:
            lines[i] = lines[i].replace(f"| {old} |", f"| {data.draw(st.sampled_from(SPELLINGS[old]))} |")
        after = "\n".join(lines)
    comparison = compare(BASE, after)
    assert comparison.same, [c for c in comparison.changes if c.effect]
    assert {c.kind for c in comparison.changes} <= {"written", "moved"}
