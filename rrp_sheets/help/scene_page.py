"""`help scene`: what the rows of a Scene sheet may say. All of it comes from the tables that the parser reads by."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from rrp_sheets.help.layout import columns, entries, from_markdown, grid, heading, paragraph, titled
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_sheet import MOST_THINGS, WAITING_US
from rrp_sheets.scene.scene_words import COLOURS, KINDS, ThingKind

TIMES = [
    ("2.5", "seconds from the start of the run"),
    ("2..4", "a time between both, drawn again in every run"),
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
    """Yield the help on the Scene sheet: the page `scene.md` with its times, things, verbs and values."""
    robot = load_robot()
    made: dict[str, list[str]] = {
        "{example}": [titled("For example", grid("Scene", EXAMPLE))],
        "{times}": [entries(TIMES)],
        "{kinds}": [block for kind in KINDS.values() for block in _kind(kind)],
    }
    places = {"robot": robot.title, "zones": ", ".join(robot.touch_zones), "colours": ", ".join(COLOURS),
              "most": MOST_THINGS, "waiting": WAITING_US // 1_000_000}  # fmt: skip
    for block in (Path(__file__).parent / "scene.md").read_text(encoding="utf-8").strip().split("\n\n"):
        yield from made[block] if block in made else from_markdown(block.format(**places))


def _kind(kind: ThingKind) -> Iterator[str]:
    yield heading(kind.title)
    yield paragraph(f"{', '.join(kind.things)}{', …' if len(kind.things) > 1 else '.'} {kind.help}".strip())
    yield columns(scene_words(kind))
