"""Describes a behaviour in plain words: a sentence for each row, and a paragraph that joins a value with its use.

A row's sentence is one of its connector's, with phrases for the event that triggers the row and for its formula.
Devices have phrases of their own (`says` in robot.toml), filled with their settings. `says` may offer several texts,
each for some settings: `mode=head: follow {source} with the head | follow {source}`; the first whose conditions hold is
taken. Places are settings by key, `{source}`: what the value comes from, `{stream}`: the actuator's name, and `{way}`:
how far Walk goes.
"""

from __future__ import annotations

import math
import re
from collections import defaultdict
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass, replace

from rrp_sheets.connectors import Connector
from rrp_sheets.graph import BehaviourGraph, Graph, Step, Stream, StreamKind
from rrp_sheets.model.durations import show_duration
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import show
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.render.formula_words import (
    Content,
    FieldNames,
    Form,
    Named,
    Phrase,
    Wording,
    contents,
    has_blank,
    is_blank,
    names_in,
    shown,
)  # fmt: skip
from rrp_sheets.render.style import clean, columns
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.robots import FoundDevice
from rrp_sheets.texts import capital, translate


@dataclass(frozen=True)
class RowText:
    """A row in words; `active` unless it is switched off or nothing feeds it; `heading` is the comment above it."""

    number: int
    text: str
    active: bool
    heading: str = ""


@dataclass(frozen=True)
class BehaviourText:
    """A behaviour in words: what it takes in (`buttons` aside) and acts on in active rows, the paragraph, the rows."""

    name: str
    paragraph: str
    rows: tuple[RowText, ...]
    sensors: tuple[str, ...]
    buttons: tuple[str, ...]
    actuators: tuple[str, ...]

    def lists(self, words: Texts) -> tuple[str, str]:
        """Return the sensors, with the operator's buttons, and the actuators in words."""

        def told(kind: str, names: Sequence[str]) -> str:
            return words.get(f"behaviour.{kind if names else f'no_{kind}'}", list=words.listed(names))

        sensors = told("sensors", self.sensors)
        if self.buttons:
            sensors = words.get("behaviour.buttons", sensors=sensors, list=words.listed(self.buttons))
        return sensors, told("actuators", self.actuators)


def explain(
    graph: Graph, workbook: Workbook, behaviours: Sequence[BehaviourGraph] | None = None, *, language: str = "en",
    labels: bool = False,
) -> list[BehaviourText]:  # fmt: skip
    """Describe all behaviours (or some) in plain words; with `labels` buttons are called by these, not as in rows."""
    rows = Rows(graph, workbook, texts(language), labels=labels)
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
    used = dict.fromkeys(i for step in active for i in step.inputs if streams[i].kind is StreamKind.SENSOR)
    driven = dict.fromkeys(step.output for step in active if streams[step.output].kind is StreamKind.ACTUATOR)
    return BehaviourText(
        clean(behaviour.name),
        one_stop(_paragraph(behaviour, active, rows)),
        tuple(
            RowText(s.number, rows.sentence(s), s.row.on and s.active, capital(clean(headings.get(s.number, ""))))
            for s in behaviour.steps
        ),
        tuple(_named_device(streams[i], words) for i in used if not _is_button(streams[i])),
        tuple(_named_device(streams[i], words) for i in used if _is_button(streams[i])),
        tuple(_named_device(streams[i], words) for i in driven),
    )


def _named_device(stream: Stream, words: Texts) -> str:
    """Return what a stream is called, with what there is to say about its device in brackets."""
    device, name, title = stream.device, _called(stream), device_title(stream, words)
    about = [title] if title and key(title) != key(name) else []
    if _is_button(stream):
        about = [words.get("behaviour.in_rows", name=clean(stream.name))] if name != clean(stream.name) else []
    elif stream.kind is StreamKind.SENSOR and device is not None and device.type.knowledge:
        about.append(words.get("behaviour.told"))
    return words.get("behaviour.about", name=name, about=words.in_a_row(about)) if about else name


def _is_button(stream: Stream) -> bool:
    return stream.device is not None and stream.device.type.is_button


def _called(stream: Stream) -> str:
    """Return what people know a stream by: a button's label, else the stream's name."""
    return clean(str((_is_button(stream) and stream.settings.get("label")) or stream.name))


def _paragraph(behaviour: BehaviourGraph, active: list[Step], rows: Rows) -> str:
    """Return the rows' sentences; a row that only prepares what the next one does is said together with it."""
    words, sentences, place = rows.texts, [], 0
    while place < len(active):
        step, following = active[place], active[place + 1] if place + 1 < len(active) else None
        if following is not None and following.connector.is_sink and rows.prepares(step, following):
            sentences.append(rows.joined_sentence(step, following))
            place += 1
        else:
            sentences.append(rows.bare_sentence(step))
        place += 1
    if off := [str(step.number) for step in behaviour.steps if not step.row.on]:
        name = words.get("behaviour.rows" if len(off) > 1 else "behaviour.row", n=words.listed(off))
        sentences.append(words.get("behaviour.rows_off", rows=name))
    return words.sentences(sentences if active else [words.get("behaviour.nothing"), *sentences])


class Rows:
    """Maker of the sentences for a workbook's rows."""

    def __init__(self, graph: Graph, workbook: Workbook, texts: Texts, *, labels: bool = False) -> None:
        self.graph = graph
        taken = {key(stream.name) for stream in graph.streams.values()}  # a label may be the name of another stream
        called = {i: _called(stream) for i, stream in graph.streams.items() if labels}
        self.labels = {i: label for i, label in called.items() if key(label) not in taken}
        self.texts = texts
        self.contents = contents(graph)
        self.helpers = {key(h.name.text): h.name.text for h in workbook.helpers}
        self.fields = field_names(graph, texts)
        self.makers = {s.output: s for b in graph.behaviours for s in b.steps}
        self.readers: dict[str, list[Step]] = defaultdict(list)
        for behaviour in graph.behaviours:
            for step in behaviour.steps:
                for stream in dict.fromkeys(step.inputs):
                    self.readers[stream].append(step)

    def sentence(self, step: Step) -> str:
        """Return a row in words, also one that is switched off."""
        said = one_stop(self.bare_sentence(step))
        if not step.row.on:
            return self.texts.get("row.off", sentence=said)
        return said if step.active else self.texts.get("row.unfed", sentence=said)

    def bare_sentence(self, step: Step) -> str:
        """Return a row in words, as if it were on."""
        if step.connector.is_sink:
            return self._subscribe(step, self.event(step))
        values = self._values(step)
        special = {"several" if len(set(step.inputs)) > 1 else "one"}
        if step.row.formula.text:
            special.add("formula")
        if not self.graph.streams[step.output].name:
            special.add("next")
        places = "".join((step.connector.sentence, *step.connector.variants.values()))
        if "{condition}" in places:
            special |= self._filter(step, values)
        elif step.connector.name == "accumulate" and (said := self._total(step, values)):
            return said
        elif "{value}" in places:
            follows = "{Event}" in places or "{event}" in places
            phrase = self.wording(step, pronoun=follows, latest=follows).value(step.row.formula.text)
            values["value"] = phrase.text
            special.add(phrase.form.value)
        return self._said(step.connector, values, special)

    def _said(self, connector: Connector, values: Mapping[str, str], special: Container[str] = ()) -> str:
        """Fill the connector's sentence for the most that is special about a row."""
        language = self.texts.language
        fitting = [v for v in connector.variants if all(part in special for part in v.split("_"))]
        case = max(fitting, key=lambda v: v.count("_"), default="")
        template = connector.sentences.get(language) or translate(connector.sentence_for(case), language)
        capitals = {name.capitalize(): capital(value) for name, value in values.items()}
        return template.format_map(defaultdict(str, {**values, **capitals}))  # places that are not known stay empty

    def _filter(self, step: Step, values: dict[str, str]) -> set[str]:
        """Add the condition to the values; return what is special about it."""
        first, formula = step.inputs[0], step.row.formula.text
        stream, several = self.graph.streams[first], len(set(step.inputs)) > 1
        used = names_in(formula)
        names_first = not used or not used.isdisjoint(
            {key(argument_name(stream.name)), key(stream.name), "" if several else "value"}
        )
        if several and not names_first:
            values["condition"] = self.wording(step, latest=False).condition(formula).text
            return {"while"}
        if not several and (self._completes(step) or stream.kind is not StreamKind.SENSOR):
            values["condition"] = self.wording(step).condition(formula).text
            return set()
        condition = self.wording(step, pronoun=True).condition(formula)
        values["condition"] = condition.text
        return {"event", condition.form.value}

    def _completes(self, step: Step) -> bool:
        return self.graph.streams[step.inputs[0]].kind is StreamKind.DONE

    def _total(self, step: Step, values: Mapping[str, str]) -> str:
        """Return a total in words, a sentence for all inputs that do the same to it; empty for other formulas."""
        inputs = list(dict.fromkeys(step.inputs))
        keys = [key(argument_name(self.graph.streams[i].name)) for i in inputs]
        wording = self.wording(step, latest=False)
        steps = wording.total(step.row.formula.text, keys) if step.row.formula.text else ()
        if len(inputs) < 2 or not steps:
            return ""
        sentences = []
        for change in dict.fromkeys(steps):
            same = self.texts.listed(
                [self.noun(i) for i, one in zip(inputs, steps, strict=True) if one == change], "or"
            )
            sentences.append(
                self.texts.get(
                    f"total.{change.does}", inputs=same, output=values["output"], value=change.value, n=change.value
                )
            )
        return self.texts.sentences([capital(said) for said in sentences])

    def prepares(self, step: Step, act: Step) -> bool:
        """Return whether a row's value has no use but the action of the next row, which takes nothing else."""
        if set(act.inputs) != {step.output} or act.row.formula.text or len(self.readers[step.output]) > 1:
            return False
        if step.connector.name == "filter":
            return len(set(step.inputs)) == 1 and self.graph.streams[step.inputs[0]].kind is not StreamKind.SENSOR
        device = self.graph.streams[act.output].device
        blank = is_blank(step.row.formula.text)
        return step.connector.name == "map" and device is not None and (blank or bool(device.type.says_value))

    def joined_sentence(self, step: Step, act: Step) -> str:
        """Return the sentence of a row that only prepares an action, together with the action."""
        if step.connector.name == "filter":
            condition = self.wording(step).condition(step.row.formula.text).text
            return self._subscribe(act, self.texts.get("event.condition", condition=condition))
        joined = replace(act, inputs=step.inputs, row=replace(act.row, formula=step.row.formula))
        return self._subscribe(joined, self.event(joined))

    def _subscribe(self, step: Step, event: str) -> str:
        """Return the sentence of a `subscribe`; where blanks may come, it adds what they stop."""
        formula, stream = step.row.formula.text, self.graph.streams[step.output]
        values = self._values(step) | {"event": event}
        special: set[str] = set()
        if not formula or self._sends_blanks(step):
            values["does"] = self._does(step)
        else:
            phrase = self.wording(step, pronoun=True).value(formula)
            values |= {"value": phrase.text, "does": self._does_with(step, phrase)}
            special = {phrase.form.value, "several" if len(set(step.inputs)) > 1 else "one"}
            if stream.device is not None and not stream.device.type.says_value:
                special = {"used"}
        said = self._said(step.connector, values, special)
        blank = any(self.contents.get(i, Content()).may_be_blank for i in step.inputs) or has_blank(formula)
        stops = stream.device is None or bool(stream.device.type.stops)
        if not blank or self._sends_blanks(step) or not stops:
            return said
        return self.texts.get("row.stops", sentence=said, does=device_stops(stream, self.texts))

    def _sends_blanks(self, step: Step) -> bool:
        if formula := step.row.formula.text:
            return is_blank(formula)
        return bool(step.inputs) and all(self.contents.get(i, Content()).blank for i in step.inputs)

    def does(self, step: Step) -> str:
        """Return the action of a `subscribe` in words."""
        stream = self.graph.streams[step.output]
        if self._sends_blanks(step):
            return device_stops(stream, self.texts)
        return device_says(stream, self.texts, self._source(step))

    def _does(self, step: Step) -> str:
        """Return the action in words that follow its event: `make this gesture`."""
        stream = self.graph.streams[step.output]
        words = stream.device.type.words(self.texts.language).says_given if stream.device else ""
        said = "" if self._sends_blanks(step) else _template(words, stream, self.texts, strict=True)
        return said or self.does(step)

    def _given(self, step: Step) -> str:
        """Return what an actuator takes from its inputs in words, `the name of a gesture`; empty when it takes any."""
        device, carried = self.graph.streams[step.output].device, [self.contents.get(i, Content()) for i in step.inputs]
        if not step.connector.is_sink or step.row.formula.text or device is None or self._sends_blanks(step):
            return ""
        given = device.type.words(self.texts.language).given
        if not given or any(content.record for content in carried):
            return ""
        if device.type.takes in _USERS_TEXTS and any(content.unit for content in carried):
            return self.texts.get("event.a_number")
        return _template(given, self.graph.streams[step.output], self.texts, strict=True)

    def _source(self, step: Step) -> str:
        sensors = dict.fromkeys(s for i in step.inputs for s in self.contents.get(i, Content()).sensors)
        return source_of([self.graph.streams[s] for s in sensors], self.texts)

    def _does_with(self, step: Step, phrase: Phrase) -> str:
        """Return the action with the value of the row's formula: `say “Red”`."""
        stream = self.graph.streams[step.output]
        if stream.device is None:
            return self.texts.get("does.unknown_value", value=phrase.text, name=self.noun(stream.id))
        words = stream.device.type.words(self.texts.language)
        if phrase.form is not Form.FIXED or not words.says_fixed:
            return _template(words.says_value or words.says, stream, self.texts, self._source(step), phrase.text)
        own = stream.device.type.takes in _USERS_TEXTS
        fixed = phrase.fixed if own else words.name(words.value(phrase.fixed))
        return _template(words.says_fixed, stream, self.texts, value=clean(fixed))

    def event(self, step: Step) -> str:
        """Return the event that triggers a row, in words: `when “Ball” arrives`."""
        get = self.texts.get
        inputs = list(dict.fromkeys(step.inputs))
        triggers = inputs if step.connector.is_sink and not step.row.formula.text else inputs[:1]
        stream = self.graph.streams[triggers[0]]
        if len(triggers) > 1 or stream.kind not in (StreamKind.SENSOR, StreamKind.DONE):
            what = self._given(step) or (get("event.a_value") if any(map(self._unnamed, triggers)) else "")
            names = [get("behaviour.row", n=self._maker(i)) if self._unnamed(i) else self.noun(i) for i in triggers]
            return get("event.gives" if what else "event.value", input=self.texts.listed(names, "or"), what=what)
        if stream.kind is StreamKind.DONE:
            return get("event.done", name=get("name.quoted", name=_actuator(stream)))
        name, device = self.noun(stream.id), stream.device
        when = device.type.words(self.texts.language).when if device else ""
        says = _template(when, stream, self.texts) if when else device_says(stream, self.texts)
        if device is None or key(device.name) == key(stream.name) or name in says:  # a button's label
            return says if when else get("event.sensor", says=says)
        return get("event.sensor_named", event=says if when else get("event.sensor", says=says), name=name)

    def noun(self, stream: str) -> str:
        """Return a stream's name in quotes; for an anonymous stream the row that makes it."""
        return self.texts.get("name.the_result", n=self._maker(stream)) if self._unnamed(stream) else self._bare(stream)

    def _bare(self, stream: str) -> str:
        """Return a stream's name as it stands after “each” or “the latest”."""
        if self._unnamed(stream):
            return self.texts.get("name.result", n=self._maker(stream))
        return self.texts.get("name.quoted", name=self.labels.get(stream) or clean(self.graph.streams[stream].name))

    def _unnamed(self, stream: str) -> bool:
        return not self.graph.streams[stream].name

    def _maker(self, stream: str) -> str:
        return str(self.makers[stream].number) if stream in self.makers else "?"

    def wording(self, step: Step, *, pronoun: bool = False, latest: bool = True) -> Wording:
        """Return the wording for a row's formula.

        Args:
            step: the row.
            pronoun: whether the first input is called "it".
            latest: whether the further inputs are called "the latest".
        """
        names: dict[str, Named] = {}
        for place, stream in enumerate(step.inputs):
            is_it = pronoun and place == 0
            noun = self.texts.get("name.it") if is_it else self.noun(stream)
            if latest and place and stream != step.inputs[0]:
                noun = self.texts.get("name.latest", name=self._bare(stream))
            found = self.graph.streams[stream]
            name, actuator = found.name, _actuator(found) if found.kind is StreamKind.DONE else ""
            content = self.contents.get(stream, Content())
            named = Named(noun, content, is_it, self._bare(stream), actuator)
            for spelling in (argument_name(name), name, "value" if len(step.inputs) == 1 else ""):
                if spelling:
                    names.setdefault(key(spelling), named)
        return Wording(self.texts, names, self.helpers, self.fields)

    def _values(self, step: Step) -> dict[str, str]:
        """Return the values that sentences of rows may name."""
        inputs, words = list(dict.fromkeys(step.inputs)), self.texts
        nouns, bare = [self.noun(i) for i in inputs], [self._bare(i) for i in inputs]
        rows = words.listed([str(reader.number) for reader in self.readers[step.output]])
        many = len(self.readers[step.output]) > 1
        rows = words.get("behaviour.rows" if many else "behaviour.row", n=rows) if rows else words.get("row.unread")
        named = not self._unnamed(step.output)
        return {
            "event": self.event(step) if inputs else "",
            "input": nouns[0] if nouns else "", "inputs": words.listed(nouns), "inputs_or": words.listed(nouns, "or"),
            "one": bare[0] if bare else "", "each_or": words.listed(bare, "or"),
            "others": words.listed(bare[1:], "or" if step.connector.first_input else "and"),
            "others_or": words.listed(nouns[1:], "or"),
            "formula": words.get("value.code", formula=shown(clean(step.row.formula.text))),
            "period": words.duration(step.period_us) if step.period_us is not None else clean(step.row.formula.text),
            "pace": self._pace(step), "rows": rows,
            "output": self.noun(step.output) if named else words.get("row.input_of", rows=rows),
        }  # fmt: skip

    def _pace(self, step: Step) -> str:
        us, get = step.period_us, self.texts.get
        if not us:  # the row is wrong, and is described as it stands
            return get("pace.every", period=clean(step.row.formula.text) or "…")
        if us <= 1_000_000 and 1_000_000 % us == 0:
            times = 1_000_000 // us
            return get("pace.once") if times == 1 else get("pace.twice") if times == 2 else get("pace.times", n=times)
        return get("pace.every", period=self.texts.duration(us))


_USERS_TEXTS = ("text", "anything")
"""Contents that actuators take of which no word is the catalogue's own."""


def one_stop(text: str) -> str:
    """Remove the full stop after a quotation that ends a sentence itself.

    >>> one_stop("Say “It is time!”. Then wait.")
    'Say “It is time!” Then wait.'
    """
    return re.sub("([.!?]”)[.]", r"\1", text)


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
    return texts.get("event.ended", name=texts.get("name.quoted", name=_actuator(stream)))


def _actuator(done: Stream) -> str:
    """Return the name of the actuator whose end a stream tells."""
    return re.sub(r"\s*done$", "", clean(done.name), flags=re.IGNORECASE)


def device_stops(stream: Stream, texts: Texts) -> str:
    """Return the sentence for a blank sent to an actuator: what it stops, or that it stops nothing."""
    name = texts.get("name.quoted", name=clean(stream.name))
    if stream.device is None:
        return texts.get("does.stop", name=name)
    stops = stream.device.type.words(texts.language).stops
    if not stops:
        return texts.get("does.stop_nothing", name=name)
    said = _template(stops, stream, texts)
    return said if "{stream}" in stops else texts.get("does.stop_device", stops=said, name=name)


def _template(
    template: str, stream: Stream, texts: Texts, source: str = "", value: str = "", *, strict: bool = False
) -> str:
    """Fill a text of the catalogue with the stream's settings: words of the catalogue are translated.

    A `strict` one is empty when none of its choices fits the settings.
    """
    if not template:
        return ""
    assert stream.device is not None
    kind, name = stream.device.type, texts.get("name.quoted", name=clean(stream.name))
    words = kind.words(texts.language)
    settings = {**stream.device.preset, **stream.settings}

    def filled(match: re.Match[str]) -> str:
        if match[1] == "source":
            return source or name
        if match[1] == "value":
            return value
        if match[1] == "way":
            return _way(settings, texts)
        if match[1] == "stream":
            return name
        if match[1] == "name" and "name" not in settings:
            return name
        given = settings.get(key(match[1]))
        setting = kind.settings.get(key(match[1]))
        if setting is not None and setting.kind == "duration" and isinstance(given, int):
            return clean(texts.duration(given))
        if isinstance(given, str):
            return clean(words.said(given, setting.kind if setting else ""))
        if isinstance(given, tuple):
            return texts.listed([texts.get("name.quoted", name=clean(str(part))) for part in given], "or")
        return clean(show(given))

    times = {k for k, s in kind.settings.items() if s.kind == "duration"}
    choices = {k: show_duration(v) if k in times and isinstance(v, int) else v for k, v in settings.items()}
    return re.sub(r"\{(\w+)\}", filled, _chosen(template, choices, strict=strict))


def _way(settings: Mapping[str, object], texts: Texts) -> str:
    """Return how far Walk goes: `walk 15 cm backwards`; what the value says when no setting has a number."""

    def number(name: str) -> float:
        given = settings.get(name)
        return float(given) if isinstance(given, (int, float)) else 0.0

    def length(entry: str, metres: float) -> str:
        unit, factor = ("cm", 100) if abs(metres) < 1 else ("m", 1)
        return texts.get(entry, n=texts.get(f"walk.{unit}", n=f"{abs(metres) * factor:g}"))

    forward, left, degrees = number("forward"), number("left"), math.degrees(number("turn"))
    ways = [length("walk.forwards" if forward > 0 else "walk.backwards", forward)] if forward else []
    ways += [length("walk.left" if left > 0 else "walk.right", left)] if left else []
    turn = texts.get("walk.turn_left" if degrees > 0 else "walk.turn_right", n=f"{abs(degrees):.0f}") if degrees else ""
    entry = ("both" if turn else "walk") if ways else "turn" if turn else "value"
    return texts.get(f"walk.{entry}", way=texts.listed(ways), turn=turn)


def device_title(stream: Stream, texts: Texts) -> str:
    """Return the name of a stream's device in a language; empty when it has no name in it."""
    return stream.device.type.words(texts.language).title if stream.device else ""


def field_names(graph: Graph, texts: Texts) -> FieldNames:
    """Return the names of record fields in a language, by the record's name and the field's key."""
    done = {(DONE.name, key(f.name)): texts.get(f"done.{key(f.name)}") for f in DONE.fields}
    kinds = (s.device.type for s in graph.streams.values() if s.device)
    words = [(t.payload.name, t.words(texts.language).fields) for t in kinds if t.payload]
    return {(record, k): name for record, fields in words for k, (name, _) in fields.items()} | done


def source_of(sensors: Sequence[Stream], texts: Texts) -> str:
    """Return the source of a value in words: the things that the sensors behind it see."""
    seen = [(s, s.device) for s in sensors if s.device and s.device.type.payload]
    things = [device_title(stream, texts) or _thing(device) for stream, device in seen]
    names = list(dict.fromkeys(texts.get("name.sensor", name=thing) for thing in things))
    if len(names) == 1:
        return names[0]
    return texts.get("does.several", list=texts.listed(names, "or")) if names else texts.get("does.nothing_seen")


def _chosen(says: str, settings: Mapping[str, object], *, strict: bool = False) -> str:
    text = ""
    for choice in says.split(" | "):
        match = _CONDITIONS.fullmatch(choice)
        if match is None:
            return choice
        conditions = (c.split("=", 1) for c in match[1].split(","))
        text = text or ("" if strict else match[2])
        if all(key(str(settings.get(key(name)) or "")) == key(value) for name, value in conditions):
            return match[2]
    return text


def _thing(device: FoundDevice) -> str:
    """Return the name of what a sensor sees: the record's (`face`), unless the device has a name of its own."""
    record = device.type.payload
    name = record.name if record and key(device.name) == key(device.type.name) else device.name
    return name if name[1:2].isupper() else name[:1].lower() + name[1:]  # NAO stays
