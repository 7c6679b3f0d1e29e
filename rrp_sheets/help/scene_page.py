"""`help scene`: what the rows of a Scene sheet may say. All of it comes from the tables that the parser reads by."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.help.layout import (
    FOR_EXAMPLE,
    Block,
    columns,
    entries,
    from_file,
    heading,
    paragraph,
    slug,
    titled,
    workbook,
)
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.robots import load_robot
from rrp_sheets.scene.scene_sheet import MOST_THINGS, WAITING_US
from rrp_sheets.scene.scene_words import COLOURS, KINDS, ThingKind
from rrp_sheets.texts import N_, LazyMessage, listed, translate

TIMES = [
    ("2.5", N_("seconds from the start of the run")),
    ("2..4", N_("a time between both, drawn again in every run")),
    ("+ 2", N_("two seconds after the row above has happened")),
    ("Say done + 2", N_("two seconds after an event of a stream: a sensor, a row's output, or the end of an "
                        "actuator’s command. It is the first event that comes when the row above has happened. Rows "
                        "under each other that wait for the same stream answer one event after the other; what "
                        "belongs to the same event gets a time such as + 0.")),
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


def verb_rows(kind: ThingKind, language: str) -> list[tuple[str, str, str]]:
    """Return the verbs of a kind of thing as rows: verb (once), a value, and a line of help."""
    rows = []
    for verb in kind.verbs:
        name, *also = [verb.name, *verb.also] if language == "en" else japanese.words_for(japanese.VERBS, verb.name)
        for at, (value, line) in enumerate(verb.examples):
            told: str = scene_message(line)
            if also and at == len(verb.examples) - 1:
                others = listed(also)
                told = (
                    N_("{before}; or: {names}", before=told, names=others) if line else N_("or: {names}", names=others)
                )
            rows.append((name if at == 0 else "", scene_value(verb.name, value, language), told))
    return rows


def scene_value(verb: str, value: str, language: str) -> str:
    """Return an example of a Value as it is written in a language; what people say is a message."""
    if language == "en" or not value:
        return value
    return scene_message(value) if key(verb) in japanese.FREE else japanese.japanese_value(value)


def scene(language: str = "en") -> Iterator[Block]:
    """Yield the help on the Scene sheet: the page `scene.md` with its times, things, verbs and values."""
    robot = load_robot()
    table = "\n".join(f"| {' | '.join(row)} |" for row in [EXAMPLE[0], ["---"] * len(EXAMPLE[0]), *EXAMPLE[1:]])
    made: dict[str, list[Block]] = {
        "{example}": [titled(FOR_EXAMPLE, workbook("Scene", f"## Scene\n{table}\n", language, drawn=False))],
        "{times}": [entries(TIMES)],
        "{kinds}": [block for kind in KINDS.values() for block in _kind(kind, language)],
    }
    lists = {"zones": (japanese.ZONES, robot.touch_zones), "colours": (japanese.COLOURS, COLOURS)}
    told = {n: list(w if language == "en" else japanese.japanese(own, w)) for n, (own, w) in lists.items()}
    places = {name: translate(listed(words), language) for name, words in told.items()}
    places |= {"robot": robot.title, "most": str(MOST_THINGS), "waiting": str(WAITING_US // 1_000_000)}
    for block in from_file("scene", language, **places):
        yield from made.get(block.head, [block])


def _kind(kind: ThingKind, language: str) -> Iterator[Block]:
    yield heading(scene_message(kind.title), slug(kind.title))
    names = kind.things if language == "en" else tuple(map(japanese.japanese_thing, kind.things))
    things = listed([*names, "…"]) if len(names) > 1 else N_("{text}.", text=names[0])
    yield paragraph(N_("{before} {after}", before=things, after=scene_message(kind.help)) if kind.help else things)
    yield columns(verb_rows(kind, language))


def scene_message(text: str) -> str:
    """Return a text of the tables of the scene as a message."""
    return LazyMessage(text, msgctxt="scene") if text else ""
