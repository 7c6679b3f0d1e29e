"""A stream or a helper gets another name everywhere, and nothing else changes."""

from __future__ import annotations

from pathlib import Path

import pytest
from click.testing import CliRunner

from rrp_sheets import api
from rrp_sheets.cli.files import rename_command
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import StreamKind
from rrp_sheets.resources import bundled
from rrp_sheets.workbook.files import read_sheets

BOOK = """
## Tracking

| Input streams | Connector | Formula | Output stream | Notes |
|---|---|---|---|---|
| Red ball | map | redBall.distance | Distance | the Distance of the ball |
| Distance | filter | AND(distance < limit; "distance" <> "") | Close | |
| Distance | map | f"It is {DISTANCE:.1f} m; {distance}" | Told | |
| distance, Button | combineLatest | | Both | |
| Both | filter | AND(both.distance > 1; both.button.count > 1) | Far | |
| Far | map | [d * value.distance for d in [1; 2]] | Twice | |
| Twice | subscribe | | Print | |
| Told | subscribe | | Say | |
| Say done, Distance | merge | | Any | |
| Any, Distance | combineLatest | IF(any = distance; near(distance); distance) | Mixed | |
| Mixed | subscribe | | Print | |

## Second

| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | redBall.distance | Distance |
| Distance | subscribe | | Print |

## Devices

| Stream | Device | Text | Label |
|---|---|---|---|
| Button | Operator button | | |
| Say | Say | | |

## Helpers

| Name | Inputs | Formula |
|---|---|---|
| limit | | 0.8 |
| near | distance | distance < limit |

## Scene

| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0 | Red ball | appears | at 1, 0, 0.3 |
| Tracking!Distance + 2 | Operator | presses | Button |
| Say done + 1 | Red ball | disappears | |

## Test

| Time (ms) | Stream | Send | Expect |
|---|---|---|---|
| 0 | Red ball | distance=2; x=1 | |
| 0 | Tracking!Distance | | 2 |
| 0 | Both | | distance=2; button=1 |
| 0 | Button | count=1 | |
"""


WORKBOOKS = sorted(bundled("workbooks", "source").glob("*.md"))


@pytest.fixture
def book(tmp_path: Path) -> Path:
    path = tmp_path / "本 b.md"
    path.write_text(BOOK, encoding="utf-8")
    assert api.check(path).report.errors == []
    return path


def cells(path: Path) -> list[str]:
    """The texts of a workbook's cells with their places."""
    return [f"{s.name} {row} {column} {c.typed}" for s in read_sheets(path) for (row, column), c in s.cells.items()]


def rename(book: Path, old: str, new: str, *changes: str) -> None:
    """Rename, and compare the cells with those of the text that was changed by hand, each time from `a` to `b`."""
    text = book.read_text(encoding="utf-8")
    for change in changes:
        before, _, after = change.partition(" → ")
        assert before in text, before
        text = text.replace(before, after)
    expected = book.with_name("expected.md")
    expected.write_text(text, encoding="utf-8")
    done = api.rename(book, old, new)
    assert cells(book) == cells(expected)
    assert done.report.errors == [] and done.renaming.unsafe == ()


def test_a_stream_of_a_row_is_renamed_in_inputs_formulas_fields_scene_and_tests(book: Path) -> None:
    rename(
        book, "Tracking!Distance", "Ball far",
        "redBall.distance | Distance | the → redBall.distance | Ball far | the", "| Distance | filter → | Ball far | filter",
        "AND(distance < → AND(ballFar <", "| Distance | map → | Ball far | map", "{DISTANCE:.1f} m; {distance} → {ballFar:.1f} m; {ballFar}",
        "| distance, Button → | Ball far, Button", "both.distance → both.ballFar", "value.distance → value.ballFar",
        "Say done, Distance → Say done, Ball far", "Any, Distance → Any, Ball far",
        "(any = distance; near(distance); distance) → (any = ballFar; near(ballFar); ballFar)",
        "Tracking!Distance → Tracking!Ball far", "distance=2; button → ballFar=2; button",
    )  # fmt: skip


def test_a_stream_of_the_devices_is_renamed_with_its_done_stream_and_its_label(book: Path) -> None:
    rename(
        book,
        "Say",
        "Voice",
        "subscribe | | Say → subscribe | | Voice",
        "Say done → Voice done",
        "| Say | Say → | Voice | Say",
    )
    rename(
        book, "Button", "Go on", "distance, Button → distance, Go on", "both.button → both.goOn", "presses | Button → presses | Go on",
        "| Button | Operator → | Go on | Operator", "2; button=1 → 2; goOn=1", "| 0 | Button → | 0 | Go on",
    )  # fmt: skip


def test_a_helper_is_renamed_where_formulas_use_it(book: Path) -> None:
    rename(book, "limit", "Edge", "< limit → < edge", "| limit | → | Edge |")
    rename(book, "near", "is close", "near(distance) → isClose(distance)", "| near | → | is close |")


def test_another_spelling_of_the_same_name(book: Path) -> None:
    rename(
        book, "Tracking!Distance", "DISTANCE", "| Distance | the → | DISTANCE | the", "| Distance | filter → | DISTANCE | filter",
        "| Distance | map → | DISTANCE | map", "{DISTANCE:.1f} → {distance:.1f}", "| distance, Button → | DISTANCE, Button",
        "Say done, Distance → Say done, DISTANCE", "Any, Distance → Any, DISTANCE", "Tracking!Distance → Tracking!DISTANCE",
    )  # fmt: skip


@pytest.mark.parametrize(("old", "new", "message"), [
    ("Distance", "X", "“Distance” is a name in Tracking and Second."),
    ("Tracking!Distance", "close", "A stream is already called “close”."),
    ("Tracking!Distance", "Red ball", "A stream is already called “Red ball”."),
    ("Tracking!Distance", "Say done", "A stream is already called “Say done”."),
    ("Tracking!Distance", "limit", "“limit” means something else in row Tracking!3."),
    ("Tracking!Distance", "a, b", "“a, b” cannot be a name"),
    ("Tracking!Distance", " ", "cannot be a name"),
    ("Tracking!Distance", "If", "“If” cannot be a name"),
    ("Button", "Say", "A stream is already called “Say”."),
    ("Red ball", "Ball", "“Red ball” is the robot’s own name."),
    ("Nothing", "Ball", "No row, device or helper has the name “Nothing”."),
    ("Elsewhere!Distance", "Ball", "There is no sheet “Elsewhere”."),
    ("limit", "near", "A helper or sheet “near” already exists."),
    ("limit", "distance", "“distance” means something else in row Helpers!3."),
    ("near", "IF", "“IF” cannot be a name"),
    ("near", "Any", "“Any” means something else in row Tracking!11."),
    ("Tracking!Distance", "# 1", "“# 1” cannot be a name"),
    ("Tracking!Distance", "=far", "“=far” cannot be a name"),
    ("Say", "'Voice", "“'Voice” cannot be a name"),
])  # fmt: skip
def test_a_name_that_is_taken_wrong_or_nobodys_is_refused(book: Path, old: str, new: str, message: str) -> None:
    before = book.read_bytes()
    with pytest.raises(SheetsError) as error:
        api.rename(book, old, new)
    assert message in error.value.message and error.value.remedy
    assert book.read_bytes() == before


def test_a_formula_whose_loop_has_the_name_stays_and_is_told(book: Path) -> None:
    text = book.read_text(encoding="utf-8").replace(
        "[d * value.distance for d in [1; 2]]", "[far + far for far in [1; 2]]"
    )
    book.write_text(text, encoding="utf-8")
    done = CliRunner().invoke(rename_command, [str(book), "Far", "Away"])
    assert "Tracking!C7 stays: its formula means something else by this name too." in done.output
    assert "| Away" in book.read_text(encoding="utf-8")
    assert "[far + far for far in [1; 2]]" in book.read_text(encoding="utf-8")


def test_a_preview_shows_the_cells_and_changes_nothing(book: Path) -> None:
    before = book.read_bytes()
    done = CliRunner().invoke(rename_command, [str(book), "Say", "Voice", "--preview"])
    assert "Tracking!D9: “Say” → “Voice”" in done.output and "4 cells would change." in done.output
    assert book.read_bytes() == before


def test_a_name_that_was_typed_over_can_be_used_everywhere_or_given_again(book: Path) -> None:
    text, renamed = book.read_text(encoding="utf-8"), book.with_name("renamed.md")
    renamed.write_text(text, encoding="utf-8")
    api.rename(renamed, "Tracking!Distance", "Ball far")
    over = book.with_name("over.md")
    over.write_text(
        text.replace("redBall.distance | Distance | the", "redBall.distance | Ball far | the"), encoding="utf-8"
    )
    (finding,) = (d for d in api.check(over).report if d.code == "GRAPH001")
    assert [(fix.id, fix.title, fix.safe) for fix in finding.fixes] == [
        ("use-new-name", "Use the new name “Ball far” everywhere", False),
        ("restore-name", "Call the output “Distance” again", False),
    ]
    for wanted, expected in (("use-new-name", renamed), ("restore-name", book)):
        api.fix(over, book.with_name(f"{wanted}.md"), {"GRAPH001": wanted})
        assert cells(book.with_name(f"{wanted}.md")) == cells(expected)


@pytest.mark.parametrize(("typed", "first"), [
    ("Red bal", "correct-spelling"), ("Rd ball", "correct-spelling"), ("Red wall panel", "use-new-name"),
])  # fmt: skip
def test_a_stream_that_is_spelled_nearly_so_comes_before_a_name_that_was_typed_over(
    tmp_path: Path, typed: str, first: str
) -> None:
    book = tmp_path / "near.md"
    book.write_text(
        "## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n"
        f"| Red ball | map | redBall.x | Across |\n| {typed} | subscribe | | Print |\n",
        encoding="utf-8",
    )
    (finding,) = (d for d in api.check(book).report if d.code == "GRAPH001")
    assert finding.fixes[0].id == first and "restore-name" in [fix.id for fix in finding.fixes]


@pytest.mark.parametrize(("change", "why"), [
    (("redBall.distance | Distance | the", "redBall.distance | Ball far | the"), "the row that lacks it gives the unused one"),
    (("| Told | subscribe", "| Spoken | subscribe"), "another name is missing too"),
    (("| Far | map", "| Fahr | map"), "two outputs are used nowhere"),
])  # fmt: skip
def test_where_it_is_not_clear_what_was_typed_over_nothing_is_offered(
    book: Path, change: tuple[str, str], why: str
) -> None:
    text = book.read_text(encoding="utf-8").replace(
        "redBall.distance | Distance | the", "redBall.distance | Ball far | the"
    )
    if why.startswith("the row"):
        text = text.replace(
            "| Red ball | map | redBall.distance | Ball far | the", "| Distanse | map | value | Ball far | the"
        )
    else:
        assert change[0] in text
        text = text.replace(*change)
    book.write_text(text, encoding="utf-8")
    found = [d for d in api.check(book).report if d.code == "GRAPH001"]
    assert found and not [fix for d in found for fix in d.fixes if fix.id == "use-new-name"], why


@pytest.mark.parametrize("most", [1, pytest.param(1_000, marks=pytest.mark.soak)])
@pytest.mark.parametrize("source", WORKBOOKS, ids=lambda path: path.stem)
def test_streams_of_the_workbooks_get_another_name_and_their_own_again(source: Path, most: int, tmp_path: Path) -> None:
    book = tmp_path / source.name
    book.write_bytes(source.read_bytes())
    checked = api.check(book)
    found = [(d.code, d.address) for d in checked.report]
    declared = {d.stream.text for d in checked.workbook.devices}
    streams = checked.graph.streams.values()
    names = [(s.address.sheet, s.name) for s in streams if s.kind is StreamKind.ORDINARY][-most:]
    names += [("Devices", s.name) for s in streams if s.name in declared and "!" not in s.id and not s.done_of][-most:]
    for sheet, name in names:
        assert api.rename(book, name, f"The {name} 二", sheet).renaming.edits
    assert [(d.code, d.address) for d in api.check(book).report] == found
    assert api.diff(source, book).same
    for sheet, name in names:
        api.rename(book, f"The {name} 二", name, sheet)
    assert cells(book) == cells(source)


def test_diff_tells_no_effect_when_an_actuator_whose_end_is_read_has_another_name(tmp_path: Path) -> None:
    rows = '| Red ball | map | "Hi" | Words |\n| Words | subscribe | | Voice |\n| Voice done | map | 1 | After |\n'
    source = tmp_path / "a.md"
    head = "## T\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n"
    devices = "| After | subscribe | | Print |\n\n## Devices\n| Stream | Device |\n|---|---|\n| Voice | Say |\n"
    source.write_text(head + rows + devices, encoding="utf-8")
    other = tmp_path / "b.md"
    other.write_text(source.read_text(encoding="utf-8").replace("Voice", "Talk"), encoding="utf-8")
    assert api.diff(source, other).same
