"""The Scene sheet's words: whatever stands in its cells is understood or told, and ranges are drawn by the seed."""

from __future__ import annotations

import pytest
from examples import example_count
from hypothesis import example, given, settings
from hypothesis import strategies as st
from PIL import Image
from play import check, findings, rows
from test_scene import ROBOT, rows_of

from rrp_sheets import api
from rrp_sheets.diagnostics.report import Report
from rrp_sheets.model.exchange import RandomRange, SceneAction
from rrp_sheets.model.workbook import Address, Cell, SceneRow
from rrp_sheets.scene.scene_sheet import parse_scene, scene_end_us
from rrp_sheets.scene.scene_words import KINDS, choose_random_numbers

UNDERSTOOD = [
    ("| 0 | Red cup | appears | at 0.4, 0.1 on table |", "cup",
     {"at": (0.4, 0.1, 0.0), "on": "table", "size": 0.09, "colour": "red"}),
    ("| 0 | Cup 2 | appears | at 40 cm, 0, 0.2 |", "cup", {"at": (0.4, 0.0, 0.2), "size": 0.09, "colour": "white"}),
    ("| 0 | Green box | appears | at 0.8, 0.3 size 30 x 20 x 25 cm turned 90° |", "box",
     {"at": (0.8, 0.3, 0.0), "size": (0.3, 0.2, 0.25), "turned": pytest.approx(1.570796, abs=1e-6), "colour": "green"}),
    ("| 0 | Box | appears | size 10 cm |", "box", {"at": (0.8, 0.0, 0.0), "size": (0.1, 0.1, 0.1), "colour": "brown"}),
    ("| 0 | Table | appears | |", "table", {"at": (0.55, 0.0, 0.0), "size": (0.7, 0.4, 0.28)}),
    ("| 0 | Table | appears | at 1, 0 size 1 x 0.5 m height 50 cm |", "table",
     {"at": (1.0, 0.0, 0.0), "size": (1.0, 0.5, 0.5)}),
    ("| 0 | Wall | appears | at 2, 0 |", "wall", {"at": (2.0, 0.0, 0.0), "size": (2.0, 0.8)}),
    ("| 0 | Mia | comes | at 1, 0 standing |", "person", {"at": (1.0, 0.0, 1.104), "posture": "standing", "tall": 1.2}),
    ("| 0 | Mia | enters | at 1, 0 height 150 cm seated voice child |", "person",
     {"at": (1.0, 0.0, 0.78), "posture": "seated", "tall": 1.5, "voice": "child"}),
    ("| 0 | Mia | touches | Head for 2 s |", "person", {"zone": "Head", "seconds": 2.0}),
    ("| 0 | Mia | pushes | from the left hard |", "person", {"from": "left", "how": "hard"}),
    ("| 0 | Mia | pushes | |", "person", {"from": "front"}),
    ("| 0 | Mia | says | at 1, 0 in 2 s, he said |", "person", {"words": "at 1, 0 in 2 s, he said"}),
    ("| 0 | Light | set to | 40 % |", "light", {"share": 0.4}),
    ("| 0 | Noise | is | 0.25 in 3 s |", "noise", {"share": 0.25, "seconds": 3.0}),
    ("| 0 | Red ball | appears | at 0.8 … 1.2, \N{MINUS SIGN}0.1, 0.4 size 5..10 cm |", "ball",
     {"at": (RandomRange(0.8, 1.2), -0.1, 0.4), "size": RandomRange(0.05, 0.1), "colour": "red"}),
    ("| 0 | Red ball | moves | to 1, 0, 0.4 in 2..1.5 s |", "ball",
     {"to": (1.0, 0.0, 0.4), "seconds": RandomRange(1.5, 2.0)}),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("row", "kind", "values"), UNDERSTOOD)
def test_what_a_row_means(row: str, kind: str, values: dict[str, object]) -> None:
    report = Report()
    (action,) = parse_scene(rows_of(row), report, ROBOT)
    assert (action.kind, dict(action.values)) == (kind, values)
    assert not report.errors


TIMES = [
    ("2.5", (2_500_000, 0, "")), ("1..2 s", (1_000_000, 1_000_000, "")), ("500..700 ms", (500_000, 200_000, "")),
    ("+ 2", (2_000_000, 0, "+")), ("+1..2", (1_000_000, 1_000_000, "+")),
    ("Ask done + 2", (2_000_000, 0, "Ask done")), ("Tracking!Near + 500 ms", (500_000, 0, "Tracking!Near")),
]  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize(("text", "expected"), TIMES)
def test_what_a_time_means(text: str, expected: tuple[int, int, str]) -> None:
    report = Report()
    (action,) = parse_scene(rows_of(f"| {text} | Mia | says | hello |"), report, ROBOT)
    assert (action.time_us, action.span_us, action.cue) == expected


WRONG = [
    ("| 1 | Red ball | appears | at 1, 0, 0.4 size -5 cm |", "SCENE004", "from 0.01 to 1 m"),
    ("| 1 | Wall | appears | at 2, 0 size 0 x 0 |", "SCENE004", "from 0.1 to 20 m"),
    ("| 1 | Light | set to | 140 % |", "SCENE004", "from 0 to 100 %"),
    ("| 1 | Light | set to | |", "SCENE004", "40 %"),
    ("| 1 | Light | shines | |", "SCENE003", "set to"),
    ("| 1 | Left wall | appears | |", "SCENE002", "Wall"),
    ("| 1 | Mia | enters | at 1, 0 height 9 m |", "SCENE004", "from 0.5 to 2.2 m"),
    ("| 1 | Mia | pushes | from above |", "SCENE004", "the left, the right, behind, the front"),
    ("| 1 | Cup | appears | at 0.4, 0, 0.3 on table |", "SCENE004", "two numbers"),
    ("| 1 | Red ball | appears | at 0.4..0.5..0.6, 0, 0.4 |", "SCENE004", "at 1, 0.2, 0.4"),
    ("| 1 | Mia | enters | at 1, 0 with picture ../../etc/passwd.png |", "SCENE008", "next to the workbook"),
    ("| 1..2..3 | Mia | says | hello |", "SCENE001", "2.5"),
    ("| Ask done + soon | Mia | says | hello |", "SCENE001", "Ask done + 2"),
    ("| Ask done - 2 | Mia | says | hello |", "SCENE001", "Say done + 2"),
]


@pytest.mark.parametrize(("row", "code", "remedy"), WRONG)
def test_what_is_not_understood_says_what_to_do(row: str, code: str, remedy: str) -> None:
    report = Report()
    assert parse_scene(rows_of(row), report, ROBOT) == ()
    assert report.flatten(["code"]) == [(code,)]
    assert remedy in next(iter(report)).remedy


PIECES = (
    "at", "to", "in", "on", "table", "size", "with", "picture", "..", ",", "+", "x", "%", "°", "cm", "-", "1", "0.5",
    "seated", "voice", "child", "from", "behind", "hard", "for", "…", "(", "名", "😀", "id", "2s", "9" * 30, "\n",
)  # fmt: skip
words = st.one_of(st.text(max_size=30), st.lists(st.sampled_from(PIECES), max_size=9).map(" ".join))
things = st.one_of(words, st.sampled_from([t for k in KINDS.values() for t in k.things]))
does = st.one_of(words, st.sampled_from([v.name for k in KINDS.values() for v in k.verbs]))


@settings(max_examples=example_count(400))
@given(time=st.one_of(words, st.just("1")), thing=things, does=does, value=words)
@example(time="+", thing="Table", does="appears", value="at , size")
@example(time="1e400", thing="Red ball 9", does="circles", value="period 0..0 s")
def test_any_text_is_an_action_or_a_finding(time: str, thing: str, does: str, value: str) -> None:
    report = Report()
    here = (Cell(text, Address("Scene", 2, at)) for at, text in enumerate((time, thing, does, value), start=1))
    actions = parse_scene([SceneRow(*here)], report, ROBOT)
    assert actions or report.errors
    assert all(finding.address and finding.remedy for finding in report)
    drawn, _ = choose_random_numbers(actions, 3)
    assert "Range(" not in repr(drawn) and scene_end_us(actions) >= 0


@given(st.floats(-19, 19), st.floats(0, 1), st.integers(0, 2**31))
def test_a_range_gives_a_number_between_its_ends_and_the_seed_says_which(low: float, more: float, seed: int) -> None:
    low, high = round(low, 3), round(low + more, 3)
    report = Report()
    (action,) = parse_scene(rows_of(f"| 0 | Red ball | appears | at {low:.3f}..{high:.3f}, 0, 0.4 |"), report, ROBOT)
    (one,), told = choose_random_numbers([action], seed)
    assert low <= one.values["at"][0] <= high
    assert bool(told) == (low != high) and choose_random_numbers([action], seed)[0] == (one,)


def test_a_row_more_draws_the_others_as_before_and_other_seeds_draw_otherwise() -> None:
    def at(table: str, seed: int) -> list[float]:
        drawn, _ = choose_random_numbers(parse_scene(rows_of(table), Report(), ROBOT), seed)
        return [a.values["at"][0] for a in drawn]

    one = "| 0 | Red ball | appears | at 0.4..1.4, 0, 0.4 |"
    two = f"{one}\n| 0 | Blue ball | appears | at 0.4..1.4, 0, 0.4 |"
    assert at(two, 1)[0] == at(one, 1)[0] != at(two, 1)[1]
    assert len({at(one, seed)[0] for seed in range(20)}) > 15


def test_what_cannot_happen_in_a_scene_is_told_at_its_cell() -> None:
    report = Report()
    table = """
    | 0 | Red ball | appears | |
    | 1 | Red ball | appears | |
    | 2 | Red cup | appears | on table |
    | 3 | Table | appears | |
    | 4 | Blue cup | appears | on table |
    | 5 | Wall | disappears | |
    """
    parse_scene(rows_of(table), report, ROBOT)
    assert report.flatten(["code", "cell"]) == [("SCENE009", "B3"), ("SCENE010", "D4"), ("SCENE005", "B7")]


def test_thousands_of_rows_are_no_trouble() -> None:
    report = Report()
    actions = parse_scene(
        rows_of("\n".join(f"| {n} | Ball {n % 150} | appears | |" for n in range(2_000))), report, ROBOT
    )
    assert len(actions) == 2_000
    assert [c for c in report.flatten(["code"]) if c == ("SCENE011",)] == [("SCENE011",)]


def test_a_picture_is_looked_for_beside_the_workbook(tmp_path) -> None:
    book = tmp_path / "book.md"
    Image.new("RGB", (64, 64)).save(tmp_path / "my face.png")
    Image.new("RGB", (64, 64)).save(tmp_path / "anna.jpg")
    (tmp_path / "text.png").write_text("no picture", encoding="utf-8")
    Image.new("RGB", (8, 8)).save(tmp_path / "tiny.png")
    head = rows(
        "| Red ball | subscribe | | Print |", "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n"
    )

    def of(value: str) -> tuple[list[str], object]:
        book.write_text(f"{head}| 1 | Mia | enters | {value} |", encoding="utf-8")
        checked = api.check(book)
        return [d.remedy for d in checked.report], [a.values.get("picture") for a in checked.scene or ()]

    assert of('at 1, 0 with picture "my face.png" voice child') == ([], [str(tmp_path / "my face.png")])
    assert of("picture anna.jpg, at 1, 0") == ([], [str(tmp_path / "anna.jpg")])
    for name, remedy in (("ana.jpg", "Did you mean anna.jpg?"), ("text.png", "Save it again"), ("tiny.png", "32 to 4000"),
                         ("anna.gif", ".png or .jpg")):  # fmt: skip
        (told,), seen = of(f"at 1, 0 with picture {name}")
        assert remedy in told and seen == []


ASKS = """
| Start | map | "How are you?" | Question |
| Question | subscribe | | Ask |
"""
DEVICES = """
## Devices
| Stream | Device | Label |
|---|---|---|
| Start | Operator button | Start |
| Ask | Say | |
"""
SCENE = "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| 1 | Operator | presses | Start |\n"


@pytest.mark.parametrize(
    ("time", "expected"),
    [
        ("Ask done + 2", []), ("ask_done+2", []), ("Question + 1", []), ("T!Question + 1", []), ("Start + 0", []),
        ("Aks done + 2", [("SCENE007", "A3")]), ("Red ball + 2", [("SCENE007", "A3")]), ("Ask + 2", [("SCENE007", "A3")]),
    ],
)  # fmt: skip
def test_a_row_may_wait_for_a_stream_of_the_workbook(time: str, expected: list[tuple[str, str]]) -> None:
    assert findings(rows(ASKS, DEVICES, f"{SCENE}| {time} | Mia | says | fine |")) == expected


def test_the_streams_that_a_scene_waits_for_are_there_although_no_row_reads_them() -> None:
    checked = check(rows(ASKS, DEVICES, f"{SCENE}| Ask done + 2 | Mia | says | fine |"))
    assert [s.id for s in checked.cues] == ["askdone"]
    assert checked.scene is not None and [a.cue for a in checked.scene] == ["", "askdone"]
    assert scene_end_us(checked.scene) == 13_000_000  # 1 s, at most 10 s of waiting, and 2 s
    assert isinstance(checked.scene[1], SceneAction)
