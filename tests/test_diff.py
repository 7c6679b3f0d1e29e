"""Comparing workbooks by what they mean: an edit, and exactly what is told about it."""

from __future__ import annotations

import pytest
from compared import BASE, compare, edited, told

from rrp_sheets import api


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
        ["Tracking row 2: formula redBall.distance → ABS(redBall.x)"],
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
    "zeros before a number of a table": (
        [("| pear | 2 |", "| pear | 002 |")],
        ["Table Words row 3: points 2 → 002"],
    ),
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
        ["~ The sheets have another order: Tracking, Looking → Looking, Tracking"],
    ),
    "nothing": ([], []),
}  # fmt: skip


@pytest.mark.parametrize("name", EDITS)
def test_edit(tmp_path, name):
    edits, expected = EDITS[name]
    comparison = compare(tmp_path, BASE, edited(*edits))
    assert told(comparison) == expected
    assert comparison.same == all(line.startswith("~") for line in expected)


@pytest.mark.slow
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
