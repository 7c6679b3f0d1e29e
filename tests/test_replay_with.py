"""A recorded session replayed with another workbook: what would have been different."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from acting import Run, Script, wish
from click.testing import CliRunner
from hypothesis import given, settings
from hypothesis import strategies as st
from play import example, rows

from rrp_sheets import api
from rrp_sheets.cli.recordings import replay_command
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.exchange import DONE
from rrp_sheets.replay.output import write
from rrp_sheets.replay.report import as_text, robot_lines, row_lines

FILTER = """
| Head yaw | map | headYaw * 2 | Double |
| Double | filter | double > 3 | Far |
| Far | subscribe | | Say |
| Double | filter | double <= 3 | Near |
| Near | subscribe | | Print |
"""
SESSION = """
| Red ball | map | redBall.distance | Distance |
| Distance | filter | distance < 0.8 | Close |
| Close | once | | First |
| First | map | "Hello" | Greeting |
| Greeting | subscribe | | Say |
| Say done | map | "How are you?" | Question |
| Question | sample | 1 s | Asked |
| Asked | subscribe | | Ask |
| Distance | filter | distance >= 0.8 | Far |
| Far | subscribe | | Head tracker |
"""
ASK = "## Devices\n| Stream | Device | Text |\n|---|---|---|\n| Ask | Say parameter | And you? |\n"
VALUES = [0.1, -2.0, 1.5, 0.75, 3.0, 1.499, 1.501, -0.3, 9.0, 2.0, 1.75]


def values_at(values):
    return [(n * 100, "headyaw", value) for n, value in enumerate(values)]


def ball(distances):
    return [(n * 500, "redball", example("Red ball", distance=d)) for n, d in enumerate(distances)]


def done(value, seconds=0.7):
    return DONE.make(value=value, completed=True, seconds=seconds)


@pytest.fixture(scope="module")
def filtered(tmp_path_factory) -> Run:
    return Run(tmp_path_factory.mktemp("filter"), rows(FILTER), Script(), values_at(VALUES), seconds=1.5)


@pytest.fixture(scope="module")
def session(tmp_path_factory) -> Run:
    """A ball comes nearer, the robot greets, the child answers by a touch of the button."""
    folder = tmp_path_factory.mktemp("session")
    events = [*ball([1.2, 1.0, 0.9, 0.75, 0.6, 0.9, 0.7, 1.1]), (2_300, "saydone", done("Hello"))]
    script = Script({20: [wish("send", by="Aya", stream="Red ball", text="distance=1.5")]})
    return Run(folder, rows(SESSION, ASK), script, sorted(events, key=lambda e: e[0]), seconds=5.0)


def other(run: Run, folder: Path, *changes: tuple[str, str]) -> Path:
    text = run.path.read_text()
    for before, after in changes:
        assert before in text
        text = text.replace(before, after)
    path = folder / "other.md"
    path.write_text(text)
    return path


@pytest.mark.slow
@settings(max_examples=15, deadline=None)
@given(st.sampled_from(sorted({2 * v for v in VALUES})) | st.floats(-5, 20), st.booleans())
def test_a_changed_threshold_shows_exactly_the_events_it_concerns(filtered, threshold, strict):
    sign = ">" if strict else ">="
    with TemporaryDirectory() as folder:
        path = other(filtered, Path(folder), ("double > 3 ", f"double {sign} {threshold!r} "))
        found = api.replay(filtered.result.folder, path)
    doubles = [(e["t"], e["value"]) for e in filtered.lines if e.get("stream") == "T!Double"]
    assert len(doubles) == len(VALUES)
    gone, new = [], []
    for t, double in doubles:  # what a threshold does, worked out without any engine
        passed, passes = double > 3, double > threshold if strict else double >= threshold
        gone += [(t, double)] if passed and not passes else []
        new += [(t, double)] if passes and not passed else []
    for stream in ("T!Far", "Say"):
        mine = [d for d in found.differences if d.stream == stream]
        assert [(d.us / 1e6, d.recorded) for d in mine if d.kind == "missing"] == gone
        assert [(d.us / 1e6, d.came) for d in mine if d.kind == "extra"] == new
        assert len(mine) == len(gone) + len(new)
    assert {d.stream for d in found.differences} <= {"T!Far", "Say"} and found.same == (not gone and not new)


def test_equal_numbers_are_the_same_however_computed_also_in_lists(tmp_path):
    pairs = "| Head yaw | map | [1, headYaw * 2] | Pair |\n| Pair | subscribe | | Print |\n"
    run = Run(tmp_path, rows(pairs), Script(), values_at([1, 2.5]), seconds=0.5)
    assert [e["value"] for e in run.lines if e.get("stream") == "T!Pair"] == [[1, 2], [1, 5.0]]
    assert api.replay(
        run.result.folder, other(run, tmp_path, ("[1, headYaw * 2]", "[0.5 + 0.5, headYaw + headYaw]"))
    ).same
    assert not api.replay(run.result.folder, other(run, tmp_path, ("[1, headYaw", "[2, headYaw"))).same


def test_the_account_in_words(session, tmp_path, golden):
    path = other(session, tmp_path, ("distance < 0.8", "distance < 0.65"), ("distance >= 0.8", "distance >= 1"))
    found = api.replay(session.result.folder, path)
    golden("replay-with.txt", as_text(found) + "\n")


def test_commands_that_are_made_again_end_as_they_did_and_others_as_they_usually_do(session, tmp_path):
    same = api.replay(session.result.folder, other(session, tmp_path, ("T\n", "T\n")))
    assert same.same and same.compared > 20
    later = api.replay(session.result.folder, other(session, tmp_path, ("distance < 0.8", "distance < 0.65")))
    moved = [(d.kind, d.us / 1e6, d.came_us / 1e6) for d in later.differences if d.stream == "Say"]
    assert moved == [("time", 1.5, 2.0)]
    assert "is taken to end after the time that the same took in it" in " ".join(later.unknown)
    asked = [(d.kind, d.us / 1e6, d.came_us / 1e6) for d in later.differences if d.stream == "T!Question"]
    assert asked == [("time", pytest.approx(2.3), pytest.approx(2.7))]  # 0.7 s after it was said, as in the session
    words = [line.text for line in robot_lines(later)]
    assert words[0] == "would have said “Hello” at 2 s instead (T row 6)"
    never = api.replay(session.result.folder, other(session, tmp_path, ('"Hello"', '"Good day"')))
    assert "The session never had 1 command, so the end is unknown (“Good day”)" in " ".join(never.unknown)
    assert [line.text for line in robot_lines(never)] == [
        "would have said “Good day” instead of “Hello” (T row 6)", "would not have said “And you?” (T row 9)",
    ]  # fmt: skip


def test_rows_that_moved_or_are_called_otherwise_are_the_same(session, tmp_path):
    text = session.path.read_text().replace("| Red ball | map", "| | | | |\n| | | | |\n| Red ball | map")
    path = tmp_path / "moved.md"
    path.write_text(text.replace("Greeting", "Salute"))
    assert api.replay(session.result.folder, path).same


def test_a_stream_that_no_row_reads_is_not_told_to_get_nothing(session, tmp_path):
    path = other(session, tmp_path, ("| Far | subscribe | | Head tracker |", "| Far | subscribe | | Arm tracker |"))
    scene = "\n## Scene\n| Time (s) | Thing | Does | Value |\n|---|---|---|---|\n| Arm tracker done + 1 | Child | enters | at 1, 0 |\n"
    path.write_text(path.read_text(encoding="utf-8") + scene, encoding="utf-8")
    remarks = api.replay(session.result.folder, path).remarks
    assert remarks == ("Its Scene is different, but the sensor values are those of the recording.",)


def test_rows_that_are_new_or_gone_and_streams_that_were_not_recorded(session, tmp_path):
    path = other(session, tmp_path, ("| Far | subscribe | | Head tracker |", "| Head yaw | map | headYaw + 1 | More |"))
    found = api.replay(session.result.folder, path)
    assert "The session has no recording of “Head yaw”, so T row 11 gets no value from it." in found.remarks
    assert [(line.whose, line.text, line.row) for line in row_lines(found)] == [
        ("T row 11 of the session's workbook → Head tracker", "6 of 6 events would not have happened", "")
    ]
    path.write_text(path.read_text().replace("| Head yaw | map | headYaw + 1 |", "| Red ball | map | redBall.x |"))
    lines = {line.whose: line.text for line in row_lines(api.replay(session.result.folder, path))}
    assert lines["T row 11 (new) → More"] == "9 events would have happened"


def test_edits_of_the_session_are_made_in_rows_that_say_the_same(tmp_path):
    book = rows(FILTER)
    (tmp_path / "edit").mkdir()
    edited = book.replace("double > 3", "double > 5")

    def edit(control):
        (tmp_path / "book.md").write_text(edited)
        control.ask(wish("apply", path=str(tmp_path / "book.md")))

    script = Script({10: [wish("pause"), edit]})
    script.waiting = [lambda control: resumed(script, control)]
    run = Run(tmp_path, book, script, values_at(VALUES), seconds=1.5)
    assert len(run.happened("edit")) == 1
    (tmp_path / "book.md").write_text(book)
    assert api.replay(run.result.folder, other(run, tmp_path / "edit")).same
    found = api.replay(run.result.folder, other(run, tmp_path / "edit", ("double > 3", "double > 4")))
    assert any("The edit of T row 3 (“double > 3” → “double > 5”) is skipped" in r for r in found.remarks)


def resumed(script, control):
    if script.refusals or any(act.kind == "edit" for _, act in script.acts):
        control.ask(wish("resume"))
    else:
        script.waiting.append(lambda control: resumed(script, control))


def test_a_workbook_that_cannot_run_is_refused(session, tmp_path):
    with pytest.raises(SheetsError, match=r"other\.md” has errors and cannot run"):
        api.replay(session.result.folder, other(session, tmp_path, ("distance < 0.8", "distence < 0.8")))
    with pytest.raises(SheetsError, match=r"No row of “none\.md” is switched on"):
        (tmp_path / "none.md").write_text(rows(""))
        api.replay(session.result.folder, tmp_path / "none.md")


def test_rows_that_multiply_break_the_replay_off_and_not_the_program(session, tmp_path):
    doubling = "\n".join(f"| A{n} | map | a{n} | B{n} |\n| A{n}, B{n} | merge | | A{n + 1} |" for n in range(16))
    path = tmp_path / "many.md"
    path.write_text(rows(f"| Red ball | map | 1 | A0 |\n{doubling}\n| A16 | subscribe | | Print |"))
    found = api.replay(session.result.folder, path)
    assert found.ending.startswith("The replay stopped at 0 s: The rows multiply their values")


def test_the_command_needs_neither_simulator_nor_camera(session, tmp_path):
    path = other(session, tmp_path, ("distance < 0.8", "distance < 0.65"))
    table = tmp_path / "differences.csv"
    code = (
        "import sys\n"
        "for name in ('pybullet', 'cv2', 'numpy'): sys.modules[name] = None\n"  # importing them fails
        "from rrp_sheets.cli.main import main; main()"
    )
    words = [sys.executable, "-c", code, "replay", session.result.folder, "--with", path, "--json", "-o", table]
    told = subprocess.run(list(map(str, words)), capture_output=True, text=True, encoding="utf-8", timeout=300,
                          env={**os.environ, "PYTHONIOENCODING": "utf-8"})  # fmt: skip
    assert told.returncode == 1, told.stderr
    found = json.loads(told.stdout)
    assert not found["same"] and found["other"] == "other.md" and found["difference_count"] == len(found["differences"])
    assert len(table.read_text("utf-8-sig").splitlines()) == 1 + found["difference_count"]


def test_the_command_says_the_same_in_words_and_what_is_wrong(session, tmp_path):
    done = CliRunner().invoke(replay_command, [str(session.result.folder)])
    assert done.exit_code == 0 and done.output.startswith("The same: ")
    nowhere = CliRunner().invoke(replay_command, [str(tmp_path / "nowhere")])
    assert isinstance(nowhere.exception, UnreadableFile) and "There is no recording" in nowhere.exception.message
    odd = CliRunner().invoke(replay_command, [str(session.result.folder), "-o", "x.docx"])
    assert odd.exit_code == 2 and "The name of OUT ends with .xlsx" in odd.output


def test_differences_as_files(session, tmp_path):
    found = api.replay(session.result.folder, other(session, tmp_path, ("distance < 0.8", "distance < 0.65")))
    for name in ("d.xlsx", "d.svg"):
        assert write(found, tmp_path / name) == [] and (tmp_path / name).stat().st_size > 1000
    assert "instead" in (tmp_path / "d.svg").read_text()
    same = api.replay(session.result.folder)
    assert "was not written" in write(same, tmp_path / "same.svg")[0] and not (tmp_path / "same.svg").exists()
