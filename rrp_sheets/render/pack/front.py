"""First page of the ethics pack, for a quick judgement: title block, summary, boxes, numbers."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.checks.protocol import kept_kinds, names_of
from rrp_sheets.checks.speech_texts import OPEN
from rrp_sheets.render.pack import acts as doing
from rrp_sheets.render.pack import people, study
from rrp_sheets.render.pack.model import Labelled, Said
from rrp_sheets.render.pack.source import Driver, Source
from rrp_sheets.render.sentences import device_says
from rrp_sheets.render.style import clean
from rrp_sheets.texts import capital, translate

MOST_OCCASIONS = 8
_FIELDS = (
    ("version", "Version"), ("authors", "Authors"), ("reference", "Ethics reference"), ("contact", "Contact"),
    ("participants", "Participants"),
)  # fmt: skip


@dataclass(frozen=True)
class Print:
    """Data of this print besides the workbook: its file's name, the day, the program's version."""

    name: str
    day: str
    program: str


def facts(source: Source, this: Print) -> tuple[Labelled, ...]:
    """Return the title block below title and purpose."""
    get, limit = source.get, source.checked.run.time_limit_us
    said = {n: source.protocol(n) for _, n in _FIELDS}
    dated = [text for text in (said["Version"], source.protocol("Version date")) if text]
    said["Version"] = source.words.in_a_row(dated)
    lines = [Labelled(get(f"fact.{entry}"), said[n]) for entry, n in _FIELDS if said[n]]
    return (
        *lines,
        Labelled(get("fact.robot"), get("fact.robot_is", title=source.checked.robot.title)),
        Labelled(get("fact.limit"), source.words.duration(limit) if limit else get("not_limited")),
        Labelled(get("fact.file"), this.name),
        Labelled(get("fact.printed"), this.day),
        Labelled(get("fact.program"), get("fact.program_is", version=this.program)),
    )


def summary(source: Source, said: Sequence[Said]) -> str:
    """Describe the robot's behaviour in a few sentences."""
    get, limit = source.get, source.checked.run.time_limit_us
    acting = source.occasions()
    occasions = [device_says(stream, source.words) for s, stream in acting.items() if not source.is_button(s)]
    pressed = [s for s in acting if source.is_button(s)]
    occasions += [source.presses(pressed)] if pressed else []
    if any(step.connector.passes and step.connector.passes.later for _, step in source.active):
        occasions.append(get("summary.clock"))
    occasions = list(dict.fromkeys(occasions))
    nothing = "" if source.sensors else get("summary.senses_nothing")
    texts = doing.count_texts(said)
    moving = [d for d in source.drivers if not d.stops and not doing.speaks(d.stream)]
    can = [source.count("summary.says", texts)] if texts else []
    can = list(dict.fromkeys(can + [_plainly(source, d) for d in moving]))
    sentences = (
        get("summary.senses", list=_shortened(source, occasions)) if occasions else nothing,
        get("summary.acts", list=_shortened(source, can)) if can else get("summary.acts_nothing"),
        get("summary.by_hand"),
        get("summary.ends_limit", limit=source.words.duration(limit)) if limit else get("summary.ends"),
    )
    return source.words.sentences(sentences)


def _plainly(source: Source, driver: Driver) -> str:
    """Return what a row does, without the technical name of a joint."""
    if not driver.stream.settings.get("joint"):
        return source.rows.does(driver.step)
    parts = [source.get(f"part.{part}") for part in doing.parts_of(source, [driver])]
    return source.get("summary.moves", parts=source.words.listed(parts))


def _shortened(source: Source, things: Sequence[str]) -> str:
    if len(things) > MOST_OCCASIONS:
        rest = source.get("summary.more", n=len(things) - MOST_OCCASIONS + 1)
        things = [*things[: MOST_OCCASIONS - 1], rest]
    return source.words.listed(things, "any")


def glance(source: Source, said: Sequence[Said]) -> tuple[Labelled, ...]:
    """Return the six boxes of the first page."""
    get, run, streams = source.get, source.checked.run, source.checked.graph.streams
    sensors = [s for s in source.sensors if not source.is_button(s)]
    through = list(dict.fromkeys(get(f"channel.{source.channel(streams[s])}") for s in sensors))
    senses = ("both" if source.buttons else "some") if through else "buttons" if source.buttons else "nothing"
    heard = ["senses_mic"] if "microphone" in people.channels(source) else []
    kinds = translate(names_of(kept_kinds(source.checked.robot, source.checked.graph, run)), source.words.language)
    keeps = ["keeps_kinds"]
    if people.remembers_faces(source):
        keeps.append("keeps_faces" if run.keeps_faces else "forgets_faces")
    texts = doing.count_texts(said)
    says = "nothing" if not texts else "open" if is_open(said) else "one" if texts == 1 else "some"
    moving = doing.moving_parts(source)
    parts = [get(f"part.{p}") for p in moving]
    moves = ["moves_nothing" if not parts else "moves_walks" if doing.walkers(source) else "moves_parts"]
    moves += ["moves_hands"] if {"left arm", "right arm"} & set(moving) else []
    moves += ["moves_end"] if "legs" not in moving else []
    labels = [source.label(s) for s in source.buttons]
    hand = "nothing" if not labels else "one" if len(labels) == 1 else "some"
    limit = source.words.duration(run.time_limit_us) if run.time_limit_us else ""

    def boxed(*entries: str, **values: object) -> str:
        return source.words.sentences([get(f"glance.{entry}", **values) for entry in entries])

    boxes = {
        "senses": boxed(f"senses_{senses}", *heard, "senses_live", List=capital(source.words.listed(through))),
        "keeps": boxed(*keeps, List=capital(kinds)),
        "says": get(f"glance.says_{says}", n=texts),
        "moves": boxed(*moves, Parts=capital(source.words.listed(parts))),
        "hand": get(f"glance.hand_{hand}", n=len(labels), list=source.quoted(labels)),
        "stops": get("glance.stops_limit" if limit else "glance.stops_only", limit=limit),
    }
    return tuple(Labelled(get(f"glance.{name}"), text) for name, text in boxes.items())


def is_open(said: Sequence[Said]) -> bool:
    """Return whether the run fills in parts of some texts."""
    return any(OPEN.search(text) for text in doing.all_texts(said))


def numbers(source: Source, said: Sequence[Said]) -> tuple[Labelled, ...]:
    """Return the workbook in numbers, each labelled with what it counts."""
    rows = [s for _, s in source.active if s.row.on]
    drives = {d.stream.id for d in source.drivers}
    counted = {
        "behaviours": len(source.checked.graph.behaviours), "rows": len(rows),
        "sensors": len(source.sensors) - len(source.buttons), "actuators": len(drives),
        "says": doing.count_texts(said),
    }  # fmt: skip
    lines = [Labelled(source.count(f"number.{name}", n), f"{n:,}") for name, n in counted.items()]
    still_open = len(source.findings) + study.count(study.missing(source))
    return (*lines, Labelled(source.count("number.open", still_open), f"{still_open:,}"))


def title_of(source: Source, name: str) -> str:
    """Return the Protocol's title; without one the file's name."""
    return clean(source.protocol("Title")) or clean(name.rsplit(".", 1)[0]) or name
