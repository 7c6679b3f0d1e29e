"""`help scene`: what the rows of a Scene sheet may say."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.devices import load_robot
from rrp_sheets.devices.scene import thing_names, verb_names
from rrp_sheets.topics.layout import columns, grid, heading, paragraph, titled

WORDS = [
    ("A ball", "appears", "at 1, 0.2, 0.4", "metres: ahead, to the left, above the floor"),
    ("", "", "at 1, 0.2, 0.4 size 10 cm", "without a size it is 6 cm"),
    ("", "moves", "to 0.5, 0, 0.4 in 2 s", "without a time it takes 2 s"),
    ("", "circles", "radius 0.3 period 4 s", "also: around 0.8, 0, 0.4; flat for a level circle"),
    ("", "disappears", "", ""),
    ("A person", "enters", "at 1, 0", "also: the height of the face; name Emma; id 2"),
    ("", "moves", "to 1, 0.5 in 3 s", ""),
    ("", "looks away", "", "and looks back"),
    ("", "is seen", "1, Emma, 6", "id, name, seconds: in view for that long"),
    ("", "touches", "Left hand", "a place where the robot feels a touch"),
    ("", "says", "hello", "a word"),
    ("", "leaves", "", ""),
    ("Operator", "presses", "Start", "the label of a button"),
]
EXAMPLE = [
    ["Time (s)", "Thing", "Does", "Value", "Notes"],
    ["1", "Red ball", "appears", "at 1, 0.2, 0.4", "far"],
    ["3", "Red ball", "moves", "to 0.5, 0, 0.4 in 2 s", "it comes near"],
    ["9", "Red ball", "disappears", "", ""],
    ["10", "Mia", "enters", "at 1, 0", ""],
]


def scene() -> Iterator[str]:
    """What the Scene sheet is, its things, verbs and values."""
    yield heading("The Scene sheet: what happens in the simulated room")
    yield paragraph(
        "Every row says when (seconds from the start of the run), which thing, what it does, and where or how. "
        "Without a Scene sheet the simulator shows the robot what its behaviours look for."
    )
    yield titled("For example", grid("Scene", EXAMPLE))
    yield heading("What they can do")
    yield columns(WORDS)
    yield paragraph(
        f"Things: {', '.join(thing_names())}, a ball of another colour, or the name of a person. "
        f"They do: {', '.join(verb_names())}."
    )
    robot = load_robot()
    yield paragraph(f"{robot.title} feels a touch on: {', '.join(robot.touch_zones)}.")
