"""First page of the ethics pack, for a quick judgement: title block, summary, boxes, numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.render.pack import acts as doing
from rrp_sheets.render.pack import people
from rrp_sheets.render.pack.model import Labelled, Said, TestSheetResult
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.sentences import device_says
from rrp_sheets.render.style import clean
from rrp_sheets.texts import capital

MOST_OCCASIONS = 8
_OPEN = re.compile("‹[^|›]*›")  # what only the run decides; of several possibilities all are printed
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
    lines = [Labelled(get(f"fact.{entry}"), text) for entry, n in _FIELDS if (text := source.protocol(n))]
    return (
        *lines,
        Labelled(get("fact.robot"), get("fact.robot_is", title=source.checked.robot.title)),
        Labelled(get("fact.limit"), source.words.duration(limit) if limit else get("not_limited")),
        Labelled(get("fact.file"), this.name),
        Labelled(get("fact.printed"), this.day),
        Labelled(get("fact.program"), get("fact.program_is", version=this.program)),
    )


def summary(source: Source, said: Sequence[Said]) -> str:
    """Describe the robot's behaviour in three sentences."""
    get, limit = source.get, source.checked.run.time_limit_us
    occasions, can = _occasions(source), _can(source, said)
    sentences = (
        get("summary.senses", list=_shortened(source, occasions)) if occasions else get("summary.senses_nothing"),
        get("summary.acts", list=_shortened(source, can)) if can else get("summary.acts_nothing"),
        get("summary.ends_limit", limit=source.words.duration(limit)) if limit else get("summary.ends"),
    )
    return source.words.sentences(sentences)


def _occasions(source: Source) -> list[str]:
    streams = source.checked.graph.streams
    others = [device_says(streams[s], source.words) for s in source.sensors if not source.is_button(s)]
    buttons = [source.presses()] if source.buttons else []
    return list(dict.fromkeys([*others, *buttons]))


def _can(source: Source, said: Sequence[Said]) -> list[str]:
    texts = doing.all_texts(said)
    can = [source.count("summary.says", len(texts))] if texts else []
    for driver in source.drivers:
        if not driver.stops and not doing.speaks(driver.stream):
            can.append(source.rows.does(driver.step))
    return list(dict.fromkeys(can))


def _shortened(source: Source, things: Sequence[str]) -> str:
    if len(things) > MOST_OCCASIONS:
        rest = source.get("summary.more", n=len(things) - MOST_OCCASIONS + 1)
        things = [*things[: MOST_OCCASIONS - 1], rest]
    return source.words.listed(things, "any")


def glance(source: Source, said: Sequence[Said]) -> tuple[Labelled, ...]:
    """Return the six boxes of the first page."""
    get = source.get
    boxes = {
        "senses": _senses(source), "keeps": _keeps(source), "says": _says(source, said), "moves": _moves(source),
        "hand": _hand(source), "stops": _stops(source),
    }  # fmt: skip
    return tuple(Labelled(get(f"glance.{name}"), text) for name, text in boxes.items())


def _senses(source: Source) -> str:
    through: dict[str, None] = {}
    for stream in source.sensors:
        through[source.get(f"channel.{source.channel(source.checked.graph.streams[stream])}")] = None
    if not through:
        return source.get("glance.senses_nothing")
    return source.get("glance.senses_some", List=capital(source.listed(list(through))))


def _keeps(source: Source) -> str:
    entries = ["keeps_pictures" if people.keeps_pictures(source) else "keeps_events"]
    if people.remembers_faces(source):
        entries.append("keeps_faces" if source.checked.run.keeps_faces else "forgets_faces")
    return source.words.sentences([source.get(f"glance.{entry}") for entry in entries])


def _says(source: Source, said: Sequence[Said]) -> str:
    texts = doing.all_texts(said)
    if not texts:
        return source.get("glance.says_nothing")
    entry = "open" if any(_OPEN.search(text) for text in texts) else "one" if len(texts) == 1 else "some"
    return source.get(f"glance.says_{entry}", n=len(texts))


def _moves(source: Source) -> str:
    parts = [source.get(f"part.{p}") for p in doing.moving_parts(source)]
    if not parts:
        return source.get("glance.moves_nothing")
    entry = "moves_walks" if doing.walkers(source) else "moves_parts"
    return source.get(f"glance.{entry}", Parts=capital(source.listed(parts)))


def _hand(source: Source) -> str:
    labels = [source.label(s) for s in source.buttons]
    entry = "some" if len(labels) > 1 else "one" if labels else "nothing"
    return source.get(f"glance.hand_{entry}", n=len(labels), list=source.quoted(labels))


def _stops(source: Source) -> str:
    limit = source.checked.run.time_limit_us
    if limit:
        return source.get("glance.stops_limit", limit=source.words.duration(limit))
    return source.get("glance.stops_only")


def numbers(source: Source, said: Sequence[Said], tests: Sequence[TestSheetResult]) -> tuple[Labelled, ...]:
    """Return the workbook in numbers, each labelled with what it counts."""
    get = source.get
    rows = [s for _, s in source.active if s.row.on]
    drives = {d.stream.id for d in source.drivers}
    passed = sum(t.passed for t in tests)
    counted = {
        "behaviours": len(source.checked.graph.behaviours), "rows": len(rows), "sensors": len(source.sensors),
        "actuators": len(drives), "says": len(doing.all_texts(said)),
    }  # fmt: skip
    lines = [Labelled(get(f"number.{name}"), f"{n:,}") for name, n in counted.items()]
    result = get("number.tests_of", passed=passed, n=len(tests)) if tests else get("no_tests")
    lines.append(Labelled(get("number.tests"), result))
    return (*lines, Labelled(get("number.open"), f"{len(source.findings) + len(people.unstated(source)):,}"))


def title_of(source: Source, name: str) -> str:
    """Return the Protocol's title; without one the file's name."""
    return clean(source.protocol("Title")) or clean(name.rsplit(".", 1)[0]) or name
