"""Describes a behaviour in plain words: a sentence for each row, and a paragraph that joins related rows.

Devices have sentences of their own (`says` in robot.toml), filled with their settings. `says` may offer several texts,
each for some settings: `mode=head: follow {source} with the head | follow {source}`; the first whose conditions hold is
taken. Places are settings by key, and `{source}`: what the value comes from.
"""

from __future__ import annotations

import re
from collections import defaultdict
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

from rrp_sheets.connectors import Connector
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import show
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.render.formula_words import Content, FieldNames, Named, Wording, contents, is_blank, shown
from rrp_sheets.render.style import clean, columns
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.robots import FoundDevice
from rrp_sheets.texts import capital, translate

_JOINED = ("map", "filter")  # their result may be called "it" in the sentence that follows


@dataclass(frozen=True)
class RowText:
    """A row in words; `active` unless it is switched off or nothing feeds it; `heading` is the comment above it."""

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

    def lists(self, words: Texts) -> tuple[str, str]:
        """Return the sensors and the actuators in words."""

        def told(kind: str, names: Sequence[str]) -> str:
            return words.get(f"behaviour.{kind if names else f'no_{kind}'}", list=words.listed(names))

        return told("sensors", self.sensors), told("actuators", self.actuators)


def explain(
    graph: Graph, workbook: Workbook, behaviours: Sequence[BehaviourGraph] | None = None, *, language: str = "en"
) -> list[BehaviourText]:
    """Describe all behaviours (or some) in plain words."""
    rows = Rows(graph, workbook, texts(language))
    chosen = graph.behaviours if behaviours is None else behaviours
    headings = {key(b.name): b.headings for b in workbook.behaviours}
    return [_behaviour(behaviour, rows, headings.get(behaviour.key, {})) for behaviour in chosen]


def explain_text(
    graph: Graph, workbook: Workbook, behaviours: Sequence[BehaviourGraph] | None = None, *, language: str = "en"
) -> str:
    """Describe behaviours in plain words, as one text for the terminal."""
    words = texts(language)
    blocks = []
    for said in explain(graph, workbook, behaviours, language=language):
        wide = max((len(str(row.number)) for row in said.rows), default=1)
        rows = []
        for row in said.rows:
            rows += ["", f"  {row.heading}"] if row.heading else []
            rows.append(f"  {row.number:>{wide}}  {row.text}")
        rows = rows[1:] if rows and not rows[0] else rows
        head = [said.name, "=" * columns(said.name), said.paragraph, "", *said.lists(words), ""]
        blocks.append("\n".join([*head, *rows]))
    return "\n\n".join(blocks) + "\n"


def _behaviour(behaviour: BehaviourGraph, rows: Rows, headings: Mapping[int, str]) -> BehaviourText:
    active = [step for step in behaviour.steps if step.row.on and step.active]
    streams, words = rows.graph.streams, rows.texts
    used = dict.fromkeys(i for step in active for i in step.inputs if rows.is_sensor(i))
    driven = dict.fromkeys(step.output for step in active if streams[step.output].kind is StreamKind.ACTUATOR)
    return BehaviourText(
        clean(behaviour.name),
        one_stop(_paragraph(behaviour, active, rows)),
        tuple(
            RowText(s.number, rows.sentence(s), s.row.on and s.active, capital(clean(headings.get(s.number, ""))))
            for s in behaviour.steps
        ),
        tuple(_named_device(streams[i], words) for i in used),
        tuple(_named_device(streams[i], words) for i in driven),
    )


def _named_device(stream: Stream, words: Texts) -> str:
    """Return a stream's name, with what there is to say about its device in brackets."""
    device, name, title = stream.device, clean(stream.name), device_title(stream, words)
    about = [title] if title and key(title) != key(name) else []
    if stream.kind is StreamKind.SENSOR and device is not None and device.type.knowledge:
        if device.type.name == "OperatorButton":
            about = [words.get("behaviour.pressed")]
        else:
            about.append(words.get("behaviour.told"))
    return words.get("behaviour.about", name=name, about=words.in_a_row(about)) if about else name


class _Chain:
    """Active rows in order, with the readers of each stream, so that long sheets take linear time."""

    def __init__(self, steps: list[Step]) -> None:
        self._after = {id(a): b for a, b in pairwise(steps)}
        self._readers: dict[str, list[Step]] = {}
        for step in steps:
            for stream in dict.fromkeys(step.inputs):
                self._readers.setdefault(stream, []).append(step)

    def after(self, step: Step) -> Step | None:
        return self._after.get(id(step))

    def only_use(self, stream: str, by: Step) -> bool:
        return all(step is by for step in self._readers.get(stream, ()))


def _paragraph(behaviour: BehaviourGraph, active: list[Step], rows: Rows) -> str:
    sentences: list[str] = []
    place, chain, words = 0, _Chain(active), rows.texts
    while place < len(active):
        step, following = active[place], active[place + 1] if place + 1 < len(active) else None
        before = active[place - 1] if place else None
        chained = before is not None and _follows(step, before)
        if (
            step.connector.name == "filter" and following is not None and len(set(step.inputs)) == 1
            and _follows(following, step) and chain.only_use(step.output, following)
            and following.connector.name in ("map", "subscribe") and (chained or not rows.is_sensor(step.inputs[0]))
        ):  # fmt: skip
            sentences.append(_when(step, following, chained, chain, rows))
            place += 2
        else:
            sentences.append(_sentence(step, before, chain, rows))
            place += 1
    if off := [str(step.number) for step in behaviour.steps if not step.row.on]:
        name = words.get("behaviour.rows" if len(off) > 1 else "behaviour.row", n=words.listed(off))
        sentences.append(words.get("behaviour.rows_off", rows=name))
    return words.sentences(sentences if active else [words.get("behaviour.nothing"), *sentences])


def _follows(step: Step, before: Step) -> bool:
    """Return whether a row takes only the result of the row before it, so that the result may be called "it"."""
    alone = set(step.inputs) == {before.output}
    return alone and before.connector.name in _JOINED and step.connector.name in (*_JOINED, "subscribe")


def _when(test: Step, act: Step, chained: bool, chain: _Chain, rows: Rows) -> str:
    """Return a filter and the one row that takes its output as one sentence."""
    get, condition = rows.texts.get, rows.wording(test, pronoun=chained).condition(test.row.formula.text)
    if act.connector.is_sink:
        return rows.sentence_of_subscribe(act, event=get("chain.does", condition=condition))
    work = rows.wording(act, pronoun=True).work(act.row.formula.text)
    return get("chain.when", condition=condition, work=work, **{"as": _name(act, chain, rows)})


def _sentence(step: Step, before: Step | None, chain: _Chain, rows: Rows) -> str:
    if before is None or before.connector.name != "map" or not _follows(step, before):
        return rows.bare_sentence(step, unnamed=step.connector.name == "map" and not _needs_name(step, chain, rows))
    get, wording, formula = rows.texts.get, rows.wording(step, pronoun=True), step.row.formula.text
    if step.connector.name == "filter":
        onto = get("row.onto", name=rows.noun(step.output)) if rows.graph.streams[step.output].name else ""
        return get("chain.filter", condition=wording.condition(formula), onto=onto)
    if step.connector.name == "map":
        return get("chain.next", work=wording.work(formula), **{"as": _name(step, chain, rows)})
    return rows.sentence_of_subscribe(step, event=get("chain.then"))


def _name(step: Step, chain: _Chain, rows: Rows) -> str:
    return rows.named(rows.noun(step.output) if _needs_name(step, chain, rows) else "")


def _needs_name(step: Step, chain: _Chain, rows: Rows) -> bool:
    """Return whether the result has a name that a later sentence uses instead of "it"."""
    following = chain.after(step) if step.connector.name == "map" else None
    if following is not None and _follows(following, step) and chain.only_use(step.output, following):
        return False
    return bool(rows.graph.streams[step.output].name)


class Rows:
    """Maker of the sentences for a workbook's rows."""

    def __init__(self, graph: Graph, workbook: Workbook, texts: Texts) -> None:
        self.graph = graph
        self.texts = texts
        self.contents = contents(graph)
        self.helpers = {key(h.name.text): h.name.text for h in workbook.helpers}
        self.fields = field_names(graph, texts)
        self.makers = {s.output: s for b in graph.behaviours for s in b.steps}

    def sentence(self, step: Step) -> str:
        """Return a row in words, also one that is switched off."""
        said = one_stop(self.bare_sentence(step))
        if not step.row.on:
            return self.texts.get("row.off", sentence=said)
        return said if step.active else self.texts.get("row.unfed", sentence=said)

    def bare_sentence(self, step: Step, *, unnamed: bool = False) -> str:
        """Return a row in words, as if it were on; `unnamed`: without the name of its result."""
        kind, formula = step.connector.name, step.row.formula.text
        if kind == "subscribe":
            return self.sentence_of_subscribe(step, event=self.event(step))
        values = self._values(step)
        if unnamed:
            values["as"] = self.named("")
        if kind == "combineLatest":
            values["work"] = self.wording(step).work(formula) if formula else self.texts.get("value.record")
        elif "{work}" in step.connector.sentence:
            wording = self.wording(step, pronoun=self.is_sensor(step.inputs[0]))
            values |= {"event": self.event(step), "work": wording.work(formula)}
        elif "{condition}" in step.connector.sentence:
            return self._filter(step, values)
        return capital(self._said(step.connector, values, _case(step)))

    def _said(self, connector: Connector, values: Mapping[str, str], case: str = "") -> str:
        language = self.texts.language
        template = connector.sentences.get(language) or translate(connector.sentence_for(case), language)
        return template.format_map(defaultdict(str, values))  # places that are not known stay empty

    def _filter(self, step: Step, values: dict[str, str]) -> str:
        first = step.inputs[0]
        from_sensor = self.is_sensor(first) and len(step.inputs) == 1
        values["condition"] = self.wording(step, pronoun=from_sensor).condition(step.row.formula.text)
        if from_sensor:
            return self._said(step.connector, values | {"event": self.event(step)}, "sensor")
        if len(set(step.inputs)) > 1:
            others = [self.noun(i) for i in dict.fromkeys(step.inputs[1:]) if i != first]
            return self._said(step.connector, values | {"others": self.texts.listed(others)}, "several")
        return self._said(step.connector, values | {"input": self.texts.get("name.it")})

    def sentence_of_subscribe(self, step: Step, *, event: str) -> str:
        """Return the sentence of a `subscribe`; where blanks may come, it adds what they stop."""
        said = self._action(step, event)
        stream = self.graph.streams[step.output]
        blank = any(self.contents.get(i, Content()).may_be_blank for i in step.inputs)
        stops = stream.device is None or bool(stream.device.type.stops)
        if not blank or self._sends_blanks(step) or not stops:
            return said
        return self.texts.get("row.stops", sentence=said, does=device_stops(stream, self.texts))

    def _sends_blanks(self, step: Step) -> bool:
        if formula := step.row.formula.text:
            return is_blank(formula)
        return bool(step.inputs) and all(self.contents.get(i, Content()).blank for i in step.inputs)

    def _action(self, step: Step, event: str) -> str:
        formula, values = step.row.formula.text, {"event": event}
        if not formula or self._sends_blanks(step):
            return self._said(step.connector, values | {"does": self.does(step)})
        wording, device = self.wording(step), self.graph.streams[step.output].device
        if device is not None and device.type.takes == "text" and (words := wording.says_words(formula)):
            return self._said(step.connector, values | {"work": words}, "words")
        values |= {"work": wording.work(formula), "does": self.does(step)}
        return self._said(step.connector, values, "formula")

    def does(self, step: Step) -> str:
        """Return the action of a `subscribe` in words."""
        stream = self.graph.streams[step.output]
        if self._sends_blanks(step):
            return device_stops(stream, self.texts)
        sensors = dict.fromkeys(s for i in step.inputs for s in self.contents.get(i, Content()).sensors)
        return device_says(stream, self.texts, source_of([self.graph.streams[s] for s in sensors], self.texts))

    def event(self, step: Step) -> str:
        """Return the event that triggers a row, in words."""
        get = self.texts.get
        inputs = list(dict.fromkeys(step.inputs))
        triggers = inputs if step.connector.is_sink and not step.row.formula.text else inputs[:1]
        stream = self.graph.streams[triggers[0]]
        if len(triggers) == 1 and stream.kind is StreamKind.SENSOR:
            says, name, device = device_says(stream, self.texts), self.noun(stream.id), stream.device
            known = device is None or key(device.name) == key(stream.name) or name in says  # a button's label
            event = get("event.sensor", says=says) if known else get("event.sensor_named", says=says, name=name)
        elif len(triggers) == 1 and stream.kind is StreamKind.DONE:
            actuator = get("name.quoted", name=clean(stream.name.removesuffix("done").rstrip()))
            event = get("event.done", name=actuator)
        else:
            event = get("event.value", input=self.texts.listed([self.noun(i) for i in triggers], "or"))
        others = [self.noun(i) for i in inputs if i not in triggers]
        return get("event.latest", event=event, others=self.texts.listed(others)) if others else event

    def is_sensor(self, stream: str) -> bool:
        """Return whether a stream is that of a sensor."""
        return self.graph.streams[stream].kind is StreamKind.SENSOR

    def noun(self, stream: str) -> str:
        """Return a stream's name in quotes; for an anonymous stream the row that makes it."""
        found = self.graph.streams[stream]
        if found.kind is StreamKind.DONE:
            actuator = found.name.removesuffix("done").rstrip()
            return self.texts.get("name.done", name=self.texts.get("name.quoted", name=clean(actuator)))
        if found.name:
            return self.texts.get("name.quoted", name=clean(found.name))
        maker = self.makers.get(stream)
        return self.texts.get("name.result", n=maker.number if maker else "?")

    def wording(self, step: Step, *, pronoun: bool = False) -> Wording:
        """Return the wording for a row's formula; `pronoun`: the first input is "it"."""
        names: dict[str, Named] = {}
        for place, stream in enumerate(step.inputs):
            is_it = pronoun and place == 0
            noun = self.texts.get("name.it") if is_it else self.noun(stream)
            named = Named(noun, self.contents.get(stream, Content()), is_it)
            name = self.graph.streams[stream].name
            for spelling in (argument_name(name), name, "value" if len(step.inputs) == 1 else ""):
                if spelling:
                    names.setdefault(key(spelling), named)
        return Wording(self.texts, names, self.helpers, self.fields)

    def _values(self, step: Step) -> dict[str, str]:
        """Return the values that templates of rows may name."""
        nouns = [self.noun(i) for i in dict.fromkeys(step.inputs)]
        output = self.noun(step.output) if self.graph.streams[step.output].name else ""
        period = self.texts.duration(step.period_us) if step.period_us is not None else clean(step.row.formula.text)
        formula = self.texts.get("value.code", formula=shown(clean(step.row.formula.text)))
        plain = {
            "input": nouns[0] if nouns else "", "inputs": self.texts.listed(nouns), "formula": formula,
            "inputs_or": self.texts.listed(nouns, "or"), "others": self.texts.listed(nouns[1:], "or"),
            "period": period, "pace": self._pace(step), "output": output, "as": self.named(output),
            "onto": self.texts.get("row.onto", name=output) if output else "",
        }  # fmt: skip
        return {**plain, **{name.capitalize(): capital(value) for name, value in plain.items()}}

    def named(self, noun: str) -> str:
        """Return the phrase for the name of a result; an empty noun gives the phrase for none."""
        return self.texts.get("row.as", name=noun) if noun else self.texts.get("row.as_nothing")

    def _pace(self, step: Step) -> str:
        us, get = step.period_us, self.texts.get
        if not us:  # the row is wrong, and is told as it stands
            return get("pace.every", period=clean(step.row.formula.text) or "…")
        if us <= 1_000_000 and 1_000_000 % us == 0:
            times = 1_000_000 // us
            return get("pace.once") if times == 1 else get("pace.twice") if times == 2 else get("pace.times", n=times)
        return get("pace.every", period=self.texts.duration(us))


def _case(step: Step) -> str:
    """Return the case of a row for which its connector has a sentence of its own."""
    case = ""
    formula = "formula" if step.row.formula.text else "no_formula"
    for name in (formula, "several" if len(set(step.inputs)) > 1 else "one"):
        longer = f"{case}_{name}" if case else name
        if longer in step.connector.variants:
            case = longer
    return case


def one_stop(text: str) -> str:
    """Remove the full stop after a quotation that ends with one.

    >>> one_stop("Say “It is time.”. Then wait.")
    'Say “It is time.” Then wait.'
    """
    return text.replace(".”.", ".”")


_CONDITIONS = re.compile(r"\s*((?:\w+=[\w ]*)(?:,\s*\w+=[\w ]*)*):\s+(.*)", re.DOTALL)


def device_says(stream: Stream, texts: Texts, source: str = "") -> str:
    """Return the sentence of a device: what an actuator does, or what happens when a sensor gives a value."""
    name = texts.get("name.quoted", name=clean(stream.name))
    words = stream.device.type.words(texts.language) if stream.device else None
    if words is not None and words.says:
        return _template(words.says, stream, texts, source)
    if stream.kind is not StreamKind.SENSOR:
        return texts.get("does.unknown", name=name)
    if not key(stream.name).endswith("done"):
        return texts.get("event.unknown", name=name)
    actuator = re.sub(r"\s*done$", "", clean(stream.name), flags=re.IGNORECASE)
    return texts.get("event.ended", name=texts.get("name.quoted", name=actuator))


def device_stops(stream: Stream, texts: Texts) -> str:
    """Return the sentence for a blank sent to an actuator: what it stops, or that it stops nothing."""
    name = texts.get("name.quoted", name=clean(stream.name))
    if stream.device is None:
        return texts.get("does.stop", name=name)
    stops = stream.device.type.words(texts.language).stops
    if not stops:
        return texts.get("does.stop_nothing", name=name)
    return texts.get("does.stop_device", stops=_template(stops, stream, texts), name=name)


def _template(template: str, stream: Stream, texts: Texts, source: str = "") -> str:
    """Fill a text of the catalogue with the stream's settings: words of the catalogue are translated."""
    assert stream.device is not None
    kind, name = stream.device.type, texts.get("name.quoted", name=clean(stream.name))
    words = kind.words(texts.language)
    settings = {**stream.device.preset, **stream.settings}

    def filled(match: re.Match[str]) -> str:
        if match[1] == "source":
            return source or name
        if match[1] == "name" and "name" not in settings:
            return name
        value = settings.get(key(match[1]))
        setting = kind.settings.get(key(match[1]))
        if setting is not None and setting.kind == "duration" and isinstance(value, int):
            return clean(texts.duration(value))
        if isinstance(value, str):
            return clean(words.said(value, setting.kind if setting else ""))
        if isinstance(value, tuple):
            return clean(texts.in_a_row([f"“{part}”" if "," in str(part) else str(part) for part in value]))
        return clean(show(value))

    return re.sub(r"\{(\w+)\}", filled, _chosen(template, settings))


def device_title(stream: Stream, texts: Texts) -> str:
    """Return the name of a stream's device in a language; empty when it has no name in it."""
    return stream.device.type.words(texts.language).title if stream.device else ""


def field_names(graph: Graph, texts: Texts) -> FieldNames:
    """Return the names of record fields in a language, by the record's name and the field's key."""
    done = {(DONE.name, key(f.name)): texts.get(f"done.{key(f.name)}") for f in DONE.fields}
    kinds = (s.device.type for s in graph.streams.values() if s.device)
    words = [(t.payload.name, t.words(texts.language).fields) for t in kinds if t.payload]
    return done | {(record, k): name for record, fields in words for k, (name, _) in fields.items()}


def source_of(sensors: Sequence[Stream], texts: Texts) -> str:
    """Return the source of a value in words: the things that the sensors behind it see."""
    seen = [(s, s.device) for s in sensors if s.device and s.device.type.payload]
    things = [device_title(stream, texts) or _thing(device) for stream, device in seen]
    names = list(dict.fromkeys(texts.get("name.sensor", name=thing) for thing in things))
    if len(names) == 1:
        return names[0]
    return texts.get("does.several", list=texts.listed(names, "or")) if names else texts.get("does.nothing_seen")


def _chosen(says: str, settings: Mapping[str, object]) -> str:
    text = ""
    for choice in says.split(" | "):
        match = _CONDITIONS.fullmatch(choice)
        if match is None:
            return choice
        conditions = (c.split("=", 1) for c in match[1].split(","))
        text = text or match[2]
        if all(key(str(settings.get(key(name)) or "")) == key(value) for name, value in conditions):
            return match[2]
    return text


def _thing(device: FoundDevice) -> str:
    """Return the name of what a sensor sees: the record's (`face`), unless the device has a name of its own."""
    record = device.type.payload
    name = record.name if record and key(device.name) == key(device.type.name) else device.name
    return name if name[1:2].isupper() else name[:1].lower() + name[1:]  # NAO stays
