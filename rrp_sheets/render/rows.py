"""Sentences that describe the rows of a workbook, one for each row."""

from __future__ import annotations

from rrp_sheets.graph import Graph, Step, StreamKind
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.render.contents import Content, contents, is_blank
from rrp_sheets.render.device_sentences import device_says, device_stops, field_names, source_of, stops_at_a_blank
from rrp_sheets.render.measure import clean
from rrp_sheets.render.texts import Texts
from rrp_sheets.render.words import Named, Wording, shown


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
        kind, get = step.connector.name, self.texts.get
        values = self._values(step)
        if unnamed:
            values["as"] = self.named("")
        if kind == "subscribe":
            return self.sentence_of_subscribe(step, event=self.event(step))
        if kind == "map":
            wording = self.wording(step, pronoun=self.is_sensor(step.inputs[0]))
            return get("row.map", **values, event=self.event(step), work=wording.work(step.row.formula.text))
        if kind == "filter":
            return self._filter(step, values)
        if kind == "combineLatest":
            formula = step.row.formula.text
            work = self.wording(step).work(formula) if formula else get("value.record")
            return get("row.combineLatest", **values, work=work)
        name = self._entry(step)
        if self.texts.has(name):
            return _capital(get(name, **values))
        own = step.connector.sentences.get(self.texts.language, step.connector.sentence)
        return _capital(own.format_map(_Places(values)))

    def _entry(self, step: Step) -> str:
        """Return the catalogue entry for a connector that can be used in several ways."""
        name = f"row.{step.connector.name}"
        formula, more = bool(step.row.formula.text), len(set(step.inputs)) > 1
        for suffix, holds in (("_key", formula), ("_count", not formula), ("_reset", more), ("_one", not more)):
            if holds and self.texts.has(name + suffix):
                name += suffix
        return name

    def _filter(self, step: Step, values: dict[str, str]) -> str:
        get, first = self.texts.get, step.inputs[0]
        if self.is_sensor(first) and len(step.inputs) == 1:
            condition = self.wording(step, pronoun=True).condition(step.row.formula.text)
            return get("row.filter_sensor", **values, event=self.event(step), condition=condition)
        values["condition"] = self.wording(step).condition(step.row.formula.text)
        if len(set(step.inputs)) > 1:
            others = [self.noun(i) for i in dict.fromkeys(step.inputs[1:]) if i != first]
            return get("row.filter_latest", **{**values, "others": self.texts.listed(others)})
        return get("row.filter", **{**values, "input": get("name.it")})

    def sentence_of_subscribe(self, step: Step, *, event: str) -> str:
        """Return the sentence of a `subscribe`; where blanks may come, it adds what they stop."""
        said = self._action(step, event)
        stream = self.graph.streams[step.output]
        blank = any(self.contents.get(i, Content()).may_be_blank for i in step.inputs)
        if not blank or self._sends_blanks(step) or not stops_at_a_blank(stream):
            return said
        return self.texts.get("row.stops", sentence=said, does=device_stops(stream, self.texts))

    def _sends_blanks(self, step: Step) -> bool:
        """Return whether a `subscribe` sends nothing but blanks."""
        formula = step.row.formula.text
        if formula:
            return is_blank(formula)
        return bool(step.inputs) and all(self.contents.get(i, Content()).blank for i in step.inputs)

    def _action(self, step: Step, event: str) -> str:
        formula, get = step.row.formula.text, self.texts.get
        if not formula or self._sends_blanks(step):
            return get("row.subscribe", event=event, does=self.does(step))
        wording = self.wording(step)
        stream = self.graph.streams[step.output]
        speaks = stream.device is not None and stream.device.type.takes == "text"
        if speaks and (words := wording.says_words(formula)):
            return get("row.subscribe_words", event=event, work=words)
        return get("row.subscribe_formula", event=event, work=wording.work(formula), does=self.does(step))

    def does(self, step: Step) -> str:
        """Return the action of a `subscribe` in words."""
        if self._sends_blanks(step):
            return device_stops(self.graph.streams[step.output], self.texts)
        sensors = {s: None for i in step.inputs for s in self.contents.get(i, Content()).sensors}
        source = source_of(Content(sensors=sensors), self.graph, self.texts)
        return device_says(self.graph.streams[step.output], self.texts, source)

    def event(self, step: Step) -> str:
        """Return the event that triggers a row, in words."""
        get = self.texts.get
        inputs = list(dict.fromkeys(step.inputs))
        triggers = inputs if step.connector.is_sink and not step.row.formula.text else inputs[:1]
        stream = self.graph.streams[triggers[0]]
        if len(triggers) == 1 and stream.kind is StreamKind.SENSOR:
            says, name = device_says(stream, self.texts), self.noun(stream.id)
            device = stream.device
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
            for spelling in (argument_name(name), name):
                if spelling:
                    names.setdefault(key(spelling), named)
            if len(step.inputs) == 1:
                names.setdefault("value", named)
        return Wording(self.texts, names, self.helpers, self.fields)

    def _values(self, step: Step) -> dict[str, str]:
        """Return the values that templates of rows may name."""
        nouns = [self.noun(i) for i in dict.fromkeys(step.inputs)]
        named = bool(self.graph.streams[step.output].name)
        output = self.noun(step.output) if named else ""
        period = self.texts.duration(step.period_us) if step.period_us is not None else clean(step.row.formula.text)
        formula = self.texts.get("value.code", formula=shown(clean(step.row.formula.text)))
        plain = {
            "input": nouns[0] if nouns else "", "inputs": self.texts.listed(nouns), "formula": formula,
            "inputs_or": self.texts.listed(nouns, "or"), "others": self.texts.listed(nouns[1:], "or"),
            "period": period, "pace": self._pace(step), "output": output,
            "as": self.named(output if named else ""),
            "onto": self.texts.get("row.onto", name=output) if named else "",
        }  # fmt: skip
        return {**plain, **{name.capitalize(): _capital(value) for name, value in plain.items()}}

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


class _Places(dict[str, str]):
    """Values for the template of a third party's connector; places that are not known stay empty."""

    def __missing__(self, name: str) -> str:
        return ""


def one_stop(text: str) -> str:
    """Remove the full stop after a quotation that ends with one.

    >>> one_stop("Say “It is time.”. Then wait.")
    'Say “It is time.” Then wait.'
    """
    return text.replace(".”.", ".”")


def _capital(text: str) -> str:
    """Return the text with a capital letter at its start; a quoted name stays as it is."""
    return text[:1].upper() + text[1:]
