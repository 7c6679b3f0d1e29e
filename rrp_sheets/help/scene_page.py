"""`help scene`: what the rows of a Scene sheet may say. All of it comes from the tables that the parser reads by."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.help.layout import columns, entries, grid, heading, paragraph, titled
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_sheet import MOST_THINGS, WAITING_US
from rrp_sheets.scene.scene_words import COLOURS, KINDS, ThingKind

TIMES = [
    ("2.5", "seconds from the start of the run"),
    ("2..4", "a time between both, which every run draws anew"),
    ("+ 2", "two seconds after the row above has happened"),
    ("Say done + 2", "two seconds after an event of a stream: a sensor, a row's output, or the end of an actuator’s "
     "command. It is the first event that comes when the row above has happened. Rows under each other that wait for "
     "the same stream answer one event after the other; what belongs to the same event gets a time such as + 0."),
]  # fmt: skip
EXAMPLE = [
    ["Time (s)", "Thing", "Does", "Value", "Notes"],
    ["0", "Table", "appears", "at 0.55, 0", "before the robot"],
    ["0", "Red cup", "appears", "at 0.5, 0.1 on table", ""],
    ["1..2", "Mia", "enters", "at 1, -0.2..0.2", "elsewhere in every run"],
    ["3", "Red ball", "appears", "at 0.6, 0.2, 0.4", ""],
    ["Say done + 2", "Mia", "says", "the red ball", "when the robot has spoken"],
    ["+ 1", "Mia", "touches", "Left hand for 1 s", "a second later"],
]


def scene_words(kind: ThingKind) -> list[tuple[str, str, str]]:
    """Return the verbs of a kind of thing as rows: verb (once), a value, and a line of help."""
    rows = []
    for verb in kind.verbs:
        for at, (value, line) in enumerate(verb.examples):
            also = f"or: {', '.join(verb.also)}" if verb.also and at == len(verb.examples) - 1 else ""
            rows.append((verb.name if at == 0 else "", value, "; ".join(p for p in (line, also) if p)))
    return rows


def scene() -> Iterator[str]:
    """Yield the help on the Scene sheet: its times, things, verbs and values."""
    yield heading("The Scene sheet: what happens in the simulated room")
    yield paragraph(
        "Every row says when, which thing, what it does, and where or how. Without a Scene sheet the simulator shows "
        "the robot what its behaviours look for."
    )
    yield titled("For example", grid("Scene", EXAMPLE))
    yield heading("When")
    yield entries(TIMES)
    yield heading("Where and how")
    yield paragraph(
        "Places are metres from where the robot starts: ahead, to its left, above the floor. A length without a unit "
        "is in metres, a time in seconds. Any number may be a range such as 0.4..0.6: every run draws one by its seed, "
        "the same seed the same, and the trace says what was drawn."
    )
    for kind in KINDS.values():
        yield heading(kind.title)
        names = ", ".join(kind.things)
        yield paragraph(f"{names}{', …' if len(kind.things) > 1 else '.'} {kind.help}".strip())
        yield columns(scene_words(kind))
    robot = load_robot()
    yield heading("Good to know")
    yield paragraph(
        f"{robot.title} feels a touch on: {', '.join(robot.touch_zones)}. A thing that comes against one touches it "
        "as well."
    )
    yield paragraph(
        f"Colours: {', '.join(COLOURS)}. Several things of one kind have numbers: Red ball 2, Wall 2. There may be "
        f"{MOST_THINGS} things at once."
    )
    yield paragraph(
        "A run ends 5 s after the last row. A row that waits for an event is taken to wait "
        f"{WAITING_US // 1_000_000} s; say with --for how long it shall be when that is not right."
    )
