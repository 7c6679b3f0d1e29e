"""Rows that are edited while they run: taken over when the graph has the same shape, refused with why when not."""

from __future__ import annotations

import pytest
from acting import Run, Script, wish
from play import check, rows

from rrp_sheets.engine.live_edits import compare
from rrp_sheets.engine.plan import make_plan
from rrp_sheets.errors import SheetsError

ROWS = """
| Head yaw | accumulate | total + headYaw | Sum |
| Sum, Head pitch | combineLatest | sum * 10 + headPitch | Both |
| Both | subscribe | | Print |
| Head yaw | sample | 300 ms | Sampled |
| Sampled | map | double(sampled) | |
| | filter | value > 2 | Large |
| Large | subscribe | | Say |
"""
HELPERS = "## Helpers\n| Name | Inputs | Formula |\n|---|---|---|\n| double | x | x * 2 |\n"
EVENTS = [(0, "headpitch", 1), *((n * 100, "headyaw", 1) for n in range(10))]
AT = 10  # the frame in which it is edited: at 0.333 s, four values have come


def edited(folder, after, by="Bo", rows_before=ROWS, helpers=HELPERS, helpers_after=None, seconds=1.0):
    """A run that is paused, edited, and goes on when the edit was used or refused."""
    before = rows(rows_before, helpers)
    now = rows(after, helpers if helpers_after is None else helpers_after)

    def edit(control):
        (folder / "book.md").write_text(now)
        control.ask(wish("apply", by, path=str(folder / "book.md")))

    script = Script({AT: [wish("pause"), edit]})
    script.waiting = [lambda control: resume(script, control)]
    return Run(folder, before, script, EVENTS, seconds=seconds)


def resume(script, control):
    """Go on when the edit was used or refused; until then look again."""
    if script.refusals or any(act.kind == "edit" for _, act in script.acts):
        control.ask(wish("resume"))
    else:
        script.waiting.append(lambda control: resume(script, control))


def test_formulas_are_used_from_the_next_frame_on_and_totals_stay(tmp_path):
    made = edited(tmp_path, ROWS.replace("total + headYaw", "total + headYaw * 100").replace("sum * 10", "sum * 1000"))
    assert made.script.values("T!Sum") == [1, 2, 3, 4, 104, 204, 304, 404, 504, 604]
    assert made.script.values("T!Both")[3:5] == [41, 104_001]  # the latest of the other input stays too
    [edit] = [act for _, act in made.script.acts if act.kind == "edit"]
    assert edit.text == "Used from 0.333333 s on: T!2, T!3." and edit.by == "Bo"
    assert [(line["row"], line["text"], line["by"]) for line in made.happened("edit")] == [
        ("T!2", "total + headYaw → total + headYaw * 100", "Bo"), ("T!3", "sum * 10 + headPitch → sum * 1000 + headPitch", "Bo"),
    ]  # fmt: skip
    assert made.happened("edit")[0]["detail"] == {
        "place": "T!2",
        "was": "total + headYaw",
        "now": "total + headYaw * 100",
    }


def test_a_period_is_used_at_once_also_when_the_next_tick_was_far(tmp_path):
    made = edited(tmp_path, ROWS.replace("300 ms", "100 ms"))
    sampled = [us for us, name, _, _ in made.script.events if made.script.start.streams[name] == "T!Sampled"]
    assert sampled[:2] == [300_000, 433_333] and len(sampled) == 7
    (tmp_path / "far").mkdir()
    made = edited(tmp_path / "far", ROWS.replace("300 ms", "200 ms"), rows_before=ROWS.replace("300 ms", "10 min"))
    sampled = [us for us, name, _, _ in made.script.events if made.script.start.streams[name] == "T!Sampled"]
    assert sampled == [533_333, 733_333, 933_333]


def test_a_helper_is_used_in_all_rows_and_recorded_where_it_stands(tmp_path):
    made = edited(tmp_path, ROWS, helpers_after=HELPERS.replace("x * 2", "x * 20"))
    assert made.script.values("T!Large") == [20, 20] and made.script.values("T!#6") == [2, 20, 20]
    [line] = made.happened("edit")
    assert (line["row"], line["text"]) == ("Helpers!double", "(x) x * 2 → (x) x * 20")


def test_rows_whose_numbers_have_shifted_keep_those_of_the_run(tmp_path):
    moved = ROWS.replace("| Head yaw | sample", "| | | | |\n| Head yaw | sample").replace("value > 2", "value > 1")
    made = edited(tmp_path, moved)
    assert not made.script.refusals
    [line] = made.happened("edit")
    assert (line["row"], line["text"]) == ("T!7", "value > 2 → value > 1")
    assert made.script.values("T!Large") == [2, 2]
    assert {row for _, _, row, _ in made.script.events if row} == {f"T!{n}" for n in range(2, 9)}


def test_what_was_only_written_differently_and_notes_change_nothing(tmp_path):
    made = edited(tmp_path, ROWS.replace("300 ms", "0.3 s"))
    [edit] = [act for _, act in made.script.acts if act.kind == "edit"]
    assert edit.detail["changes"] == [] and edit.text == "No running row has changed." and not made.happened("edit")


@pytest.mark.parametrize(("was", "now", "why"), [
    ("| Sum, Head pitch | combineLatest", "| Head pitch, Sum | combineLatest", "row T!3 has different inputs"),
    ("accumulate | total + headYaw", "map | headYaw", "row T!2 has a different connector"),
    ("| value > 2 | Large |", "| value > 2 | Huge |", "row T!7 has a different output"),
    ("| Large | subscribe | | Say |\n", "", "T has fewer active rows"),
    ("| Large | subscribe | | Say |\n", "| Large | subscribe | | Say |\n| Large | subscribe | | Print |\n", "T has more active rows"),
    ("| accumulate | total + headYaw |", "| accumulate | |", "row T!2 has a new formula or no formula"),
    ("| Both | subscribe | | Print |", "| Both | subscribe | both | Print |", "row T!4 has a new formula"),
])  # fmt: skip
def test_another_shape_is_refused_with_why(was, now, why):
    before, after = (
        make_plan(check(rows(text, HELPERS)))
        for text in (
            ROWS,
            ROWS.replace(was, now).replace("| Large | subs", "| Huge | subs" if "Huge" in now else "| Large | subs"),
        )
    )
    assert was in ROWS
    with pytest.raises(SheetsError) as caught:
        compare(before, before.checked, {s.ref: s for s in before.steps}, after)
    assert why in caught.value.message and caught.value.remedy == "Restart the run to use them."


@pytest.mark.parametrize(("sheet", "why"), [
    ("## Protocol\n| Field | Value |\n|---|---|\n| Frame rate | 60 |\n", "Frame rate"),
    ("## Protocol\n| Field | Value |\n|---|---|\n| Engine | event loop |\n", "Engine"),
    ("## Devices\n| Stream | Device | Joint |\n|---|---|---|\n| Head yaw | JointPosition | HeadPitch |\n", "the device of Head yaw"),
    ("## Scene\n| Time | Thing | Does | Value |\n|---|---|---|---|\n| 0 | Red ball | appears | at 1, 0, 0.4 |\n", "the Scene"),
    ("## B\n| Input streams | Connector | Formula | Output stream |\n|---|---|---|---|\n| Head yaw | subscribe | | Print |\n", "other behaviours"),
])  # fmt: skip
def test_other_devices_scenes_and_settings_are_refused(sheet, why):
    before, after = make_plan(check(rows(ROWS, HELPERS))), make_plan(check(rows(ROWS, HELPERS, sheet)))
    with pytest.raises(SheetsError) as caught:
        compare(before, before.checked, {s.ref: s for s in before.steps}, after)
    assert why in caught.value.message


def test_errors_and_unreadable_files_are_refused_and_the_run_goes_on(tmp_path):
    made = edited(tmp_path, ROWS.replace("total + headYaw", "total + headYow"))
    [(kind, message, remedy)] = made.script.refusals
    assert kind == "apply" and "T!C2" in message and "uses the old rows" in remedy
    assert made.script.values("T!Sum") == list(range(1, 11)) and not made.happened("edit")


def test_an_edited_row_keeps_its_formula_when_its_behaviour_is_switched_on_again(tmp_path):
    before = rows(ROWS, HELPERS)

    def edit(control):
        (tmp_path / "book.md").write_text(before.replace("total + headYaw", "total + 10"))
        control.ask(wish("apply", path=str(tmp_path / "book.md")))

    script = Script({AT: [wish("pause"), edit], 20: wish("switch", behaviour="T", on=False), 21: wish("switch", behaviour="T", on=True)})  # fmt: skip
    script.waiting = [lambda control: resume(script, control)]
    made = Run(tmp_path, before, script, EVENTS)
    assert made.script.values("T!Sum") == [1, 2, 3, 4, 14, 24, 34, 10, 20]
