"""Scene rows that wait: for the row above, or for an event of a stream; and what people do to the scene by hand."""

from __future__ import annotations

import pytest
from test_run_control import BOOK, FRAME, Run, Script, wish

from rrp_sheets.engine.scene import SceneTriggers
from rrp_sheets.model.exchange import SceneAction

S = 1_000_000
ROWS = {
    "two rows answer two events": (["1", "ask+1", "ask+1"], [2, 2, 5], [("3", 3), ("4", 6)]),
    "an event before its turn is none": (["4", "ask+1"], [2, 3], []),
    "an event at its turn counts": (["2", "ask+0"], [2], [("3", 2)]),
    "what belongs to one event counts from the row above": (["ask+1", "+0", "+0.5"], [2, 9], [("2", 3), ("3", 3), ("4", 3.5)]),
    "a row waits until the row above has happened": (["ask+3", "ask+1"], [1, 2, 5], [("2", 4), ("3", 6)]),
    "rows may begin with one that counts from the start": (["+2", "+1"], [], [("2", 2), ("3", 3)]),
    "a time of the run waits for nothing": (["ask+1", "1", "other+1"], [], []),
    "other streams are others": (["other+1", "ask+1"], [1, 2], []),
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("case", ROWS)
def test_when_a_row_that_waits_has_its_turn(case: str) -> None:
    times, events, expected = ROWS[case]
    actions = []
    for row, text in enumerate(times, start=2):
        cue, plus, seconds = text.rpartition("+")
        actions.append(SceneAction(round(float(seconds) * S), "Mia", "say", row=row, cue=(cue or "+") if plus else ""))
    triggers = SceneTriggers(actions)
    for second in events:
        triggers.heard("ask", second * S)
    due = [(str(a.row), a.time_us / S) for a in triggers.take()]
    assert due == expected and triggers.take() == ()
    waiting = {a.row for a in actions if a.cue} - {int(row) for row, _ in due}
    assert [h.row for h in triggers.left()] == [f"Scene!{row}" for row in sorted(waiting)]


def test_light_cups_and_ranges_by_hand(tmp_path) -> None:
    script = Script({
        1: [wish("scene", thing="Light", verb="set to", value="40 %"),
            wish("scene", thing="Blue cup", verb="appears", value="at 0.4..0.6, 0 on table"),
            wish("scene", thing="Light", verb="set to", value="400 %"),
            wish("scene", thing="Mia", verb="enters", value="at 1, 0 with picture mia.png")],
    })  # fmt: skip
    made = Run(tmp_path, BOOK, script, seconds=0.2)
    light, cup = made.worlds[0].acted
    assert (light.kind, light.values, light.time_us) == ("light", {"share": 0.4}, FRAME)
    assert 0.4 <= cup.values["at"][0] <= 0.6 and cup.values["on"] == "table"
    assert [kind for kind, _, _ in script.refusals] == ["scene", "scene"]
    assert "0 to 100 %" in script.refusals[0][2] and "next to the workbook" in script.refusals[1][1]
