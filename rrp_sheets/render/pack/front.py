"""First page of the ethics pack, for a quick judgement: title block, summary, boxes, numbers."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from rrp_sheets.render.pack import acts as doing
from rrp_sheets.render.pack import people, study
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
    get, limit, streams = source.get, source.checked.run.time_limit_us, source.checked.graph.streams
    occasions = [device_says(streams[s], source.words) for s in source.sensors if not source.is_button(s)]
    occasions = list(dict.fromkeys(occasions + ([source.presses()] if source.buttons else [])))
    texts = doing.all_texts(said)
    moving = [d for d in source.drivers if not d.stops and not doing.speaks(d.stream)]
    can = [source.count("summary.says", len(texts))] if texts else []
    can = list(dict.fromkeys(can + [source.rows.does(d.step) for d in moving]))
    sentences = (
        get("summary.senses", list=_shortened(source, occasions)) if occasions else get("summary.senses_nothing"),
        get("summary.acts", list=_shortened(source, can)) if can else get("summary.acts_nothing"),
        get("summary.ends_limit", limit=source.words.duration(limit)) if limit else get("summary.ends"),
    )
    return source.words.sentences(sentences)


def _shortened(source: Source, things: Sequence[str]) -> str:
    if len(things) > MOST_OCCASIONS:
        rest = source.get("summary.more", n=len(things) - MOST_OCCASIONS + 1)
        things = [*things[: MOST_OCCASIONS - 1], rest]
    return source.words.listed(things, "any")


def glance(source: Source, said: Sequence[Said]) -> tuple[Labelled, ...]:
    """Return the six boxes of the first page."""
    get, run, streams = source.get, source.checked.run, source.checked.graph.streams
    through = list(dict.fromkeys(get(f"channel.{source.channel(streams[s])}") for s in source.sensors))
    senses = "senses_some" if through else "senses_nothing"
    keeps = ["keeps_pictures" if people.keeps_pictures(source) else "keeps_events"]
    if people.remembers_faces(source):
        keeps.append("keeps_faces" if run.keeps_faces else "forgets_faces")
    texts = doing.all_texts(said)
    is_open = any(_OPEN.search(text) for text in texts)
    says = "nothing" if not texts else "open" if is_open else _one_or_some(texts)
    parts = [get(f"part.{p}") for p in doing.moving_parts(source)]
    moves = "nothing" if not parts else "walks" if doing.walkers(source) else "parts"
    labels = [source.label(s) for s in source.buttons]
    hand = _one_or_some(labels) if labels else "nothing"
    limit = source.words.duration(run.time_limit_us) if run.time_limit_us else ""
    boxes = {
        "senses": get(f"glance.{senses}", List=capital(source.words.listed(through))),
        "keeps": source.words.sentences([get(f"glance.{entry}") for entry in keeps]),
        "says": get(f"glance.says_{says}", n=len(texts)),
        "moves": get(f"glance.moves_{moves}", Parts=capital(source.words.listed(parts))),
        "hand": get(f"glance.hand_{hand}", n=len(labels), list=source.quoted(labels)),
        "stops": get("glance.stops_limit" if limit else "glance.stops_only", limit=limit),
    }
    return tuple(Labelled(get(f"glance.{name}"), text) for name, text in boxes.items())


def _one_or_some(things: Sequence[str]) -> str:
    return "one" if len(things) == 1 else "some"


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
    return (*lines, Labelled(get("number.open"), f"{len(source.findings) + len(study.missing(source)):,}"))


def title_of(source: Source, name: str) -> str:
    """Return the Protocol's title; without one the file's name."""
    return clean(source.protocol("Title")) or clean(name.rsplit(".", 1)[0]) or name
