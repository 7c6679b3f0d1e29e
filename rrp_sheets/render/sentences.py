"""Describes a behaviour in plain words: a sentence for each row, and a paragraph that joins related rows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rrp_sheets.devices import Robot
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.render.device_sentences import device_title
from rrp_sheets.render.measure import clean, columns
from rrp_sheets.render.rows import Rows, one_stop
from rrp_sheets.render.texts import Texts, texts

_JOINED = ("map", "filter")  # their result may be called "it" in the sentence that follows


@dataclass(frozen=True)
class RowText:
    """A row in words.

    `active` is False when it is switched off or nothing feeds it; `heading` is the comment above it.
    """

    number: int
    text: str
    active: bool
    heading: str = ""


@dataclass(frozen=True)
class BehaviourText:
    """A behaviour in words: what it takes in and acts on (active rows only), the paragraph, and the rows."""

    name: str
    paragraph: str
    rows: tuple[RowText, ...]
    sensors: tuple[str, ...]
    actuators: tuple[str, ...]


def explain(
    graph: Graph,
    workbook: Workbook,
    robot: Robot,
    behaviours: Sequence[BehaviourGraph] | None = None,
    *,
    language: str = "en",
) -> list[BehaviourText]:
    """Describe all behaviours (or some) in plain words."""
    words = texts(language)
    rows = Rows(graph, workbook, words)
    chosen = graph.behaviours if behaviours is None else behaviours
    headings = {key(b.name): b.headings for b in workbook.behaviours}
    return [_behaviour(behaviour, rows, words, headings.get(behaviour.key, {})) for behaviour in chosen]


def explain_text(
    graph: Graph,
    workbook: Workbook,
    robot: Robot,
    behaviours: Sequence[BehaviourGraph] | None = None,
    *,
    language: str = "en",
) -> str:
    """Describe behaviours in plain words, as one text for the terminal."""
    words = texts(language)
    blocks = []
    for said in explain(graph, workbook, robot, behaviours, language=language):
        lists = [
            words.get(f"behaviour.{kind}", list=words.listed(names)) if names else words.get(f"behaviour.no_{kind}")
            for kind, names in (("sensors", said.sensors), ("actuators", said.actuators))
        ]
        wide = max((len(str(row.number)) for row in said.rows), default=1)
        rows = []
        for row in said.rows:
            rows += ["", f"  {row.heading}"] if row.heading else []
            rows.append(f"  {row.number:>{wide}}  {row.text}")
        rows = rows[1:] if rows and not rows[0] else rows
        blocks.append("\n".join([said.name, "=" * columns(said.name), said.paragraph, "", *lists, "", *rows]))
    return "\n\n".join(blocks) + "\n"


def _behaviour(behaviour: BehaviourGraph, rows: Rows, words: Texts, headings: Mapping[int, str]) -> BehaviourText:
    active = [step for step in behaviour.steps if step.row.on and step.active]
    streams = rows.graph.streams
    used = dict.fromkeys(i for step in active for i in step.inputs if rows.is_sensor(i))
    driven = dict.fromkeys(step.output for step in active if streams[step.output].kind is StreamKind.ACTUATOR)
    return BehaviourText(
        clean(behaviour.name),
        one_stop(_paragraph(behaviour, active, rows, words)),
        tuple(
            RowText(s.number, rows.sentence(s), s.row.on and s.active, _heading(headings.get(s.number, "")))
            for s in behaviour.steps
        ),
        tuple(_sensor(streams[i], words) for i in used),
        tuple(_actuator(streams[i], words) for i in driven),
    )


def _heading(text: str) -> str:
    text = clean(text)
    return text[:1].upper() + text[1:]


def _sensor(stream: Stream, words: Texts) -> str:
    device, name, title = stream.device, clean(stream.name), device_title(stream, words)
    about = [title] if title and key(title) != key(name) else []
    if device is not None and device.type.knowledge:
        about = (
            [words.get("behaviour.pressed")]
            if device.type.name == "OperatorButton"
            else [*about, words.get("behaviour.told")]
        )
    return words.get("behaviour.about", name=name, about=words.in_a_row(about)) if about else name


def _actuator(stream: Stream, words: Texts) -> str:
    title, name = device_title(stream, words), clean(stream.name)
    return words.get("behaviour.about", name=name, about=title) if title and key(title) != key(name) else name


class _Chain:
    """Active rows in order, with the readers of each stream, so that long sheets take linear time."""

    def __init__(self, steps: list[Step]) -> None:
        self._after = {id(a): b for a, b in pairwise(steps)}
        self._readers: dict[str, list[Step]] = {}
        for step in steps:
            for stream in dict.fromkeys(step.inputs):
                self._readers.setdefault(stream, []).append(step)

    def after(self, step: Step) -> Step | None:
        """Return the row that follows a row."""
        return self._after.get(id(step))

    def only_use(self, stream: str, by: Step) -> bool:
        """Return whether no other row reads a stream."""
        return all(step is by for step in self._readers.get(stream, ()))


def _paragraph(behaviour: BehaviourGraph, active: list[Step], rows: Rows, words: Texts) -> str:
    sentences: list[str] = []
    place = 0
    chain = _Chain(active)
    while place < len(active):
        step, following = active[place], active[place + 1] if place + 1 < len(active) else None
        before = active[place - 1] if place else None
        chained = before is not None and _follows(step, before)
        if (
            step.connector.name == "filter" and following is not None and len(set(step.inputs)) == 1
            and _follows(following, step) and chain.only_use(step.output, following)
            and following.connector.name in ("map", "subscribe") and (chained or not rows.is_sensor(step.inputs[0]))
        ):  # fmt: skip
            sentences.append(_when(step, following, chained, chain, rows, words))
            place += 2
            continue
        sentences.append(_sentence(step, before, chain, rows, words))
        place += 1
    off = [str(step.number) for step in behaviour.steps if not step.row.on]
    if off:
        name = words.get("behaviour.rows" if len(off) > 1 else "behaviour.row", n=words.listed(off))
        sentences.append(words.get("behaviour.rows_off", rows=name))
    return words.sentences(sentences if active else [words.get("behaviour.nothing"), *sentences])


def _follows(step: Step, before: Step) -> bool:
    """Return whether a row takes only the result of the row before it, so that the result may be called "it"."""
    alone = set(step.inputs) == {before.output}
    return alone and before.connector.name in _JOINED and step.connector.name in (*_JOINED, "subscribe")


def _when(test: Step, act: Step, chained: bool, chain: _Chain, rows: Rows, words: Texts) -> str:
    """Return a filter and the one row that takes its output as one sentence."""
    condition = rows.wording(test, pronoun=chained).condition(test.row.formula.text)
    if act.connector.is_sink:
        return rows.sentence_of_subscribe(act, event=words.get("chain.does", condition=condition))
    work = rows.wording(act, pronoun=True).work(act.row.formula.text)
    return words.get("chain.when", condition=condition, work=work, **{"as": _name(act, chain, rows)})


def _sentence(step: Step, before: Step | None, chain: _Chain, rows: Rows, words: Texts) -> str:
    if before is not None and before.connector.name == "map" and _follows(step, before):
        wording, formula = rows.wording(step, pronoun=True), step.row.formula.text
        if step.connector.name == "filter":
            condition = wording.condition(formula)
            onto = words.get("row.onto", name=rows.noun(step.output)) if rows.graph.streams[step.output].name else ""
            return words.get("chain.filter", condition=condition, onto=onto)
        if step.connector.name == "map":
            return words.get("chain.next", work=wording.work(formula), **{"as": _name(step, chain, rows)})
        return rows.sentence_of_subscribe(step, event=words.get("chain.then"))
    return rows.bare_sentence(step, unnamed=step.connector.name == "map" and not _needs_name(step, chain, rows))


def _name(step: Step, chain: _Chain, rows: Rows) -> str:
    """Return the phrase for the name of the result, or for none."""
    return rows.named(rows.noun(step.output) if _needs_name(step, chain, rows) else "")


def _needs_name(step: Step, chain: _Chain, rows: Rows) -> bool:
    """Return whether the result has a name that a later sentence uses instead of "it"."""
    following = chain.after(step)
    is_it = step.connector.name == "map" and following is not None and _follows(following, step)
    if is_it and following is not None and chain.only_use(step.output, following):
        return False
    return bool(rows.graph.streams[step.output].name)
