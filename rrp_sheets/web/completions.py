"""Words that the grid suggests while typing: connectors, devices, streams, functions, fields and values of cells."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict
from functools import lru_cache
from typing import Any

from rrp_sheets.connectors import Parameter, connectors
from rrp_sheets.documents.grid import Grid, setting_columns
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.help.devices import described, device_help
from rrp_sheets.help.functions import examples, first_line, usage
from rrp_sheets.help.scene_page import TIMES, scene_message, scene_value
from rrp_sheets.help.topics import plain_words
from rrp_sheets.model import japanese
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.model.values import RecordType, Value
from rrp_sheets.model.workbook import Helper, Workbook
from rrp_sheets.render.formula_words import contents
from rrp_sheets.robots import FoundDevice, Joint, Robot, Setting, robot_names
from rrp_sheets.scene.scene_words import COLOURS, KINDS, kind_of
from rrp_sheets.texts import N_, LazyMessage, listed, sentences, translate
from rrp_sheets.web.analysis import Analysis
from rrp_sheets.workbook.schema import FIELDS, SHEETS, setting_header

Word = dict[str, str]


def vocabulary(
    analysis: Analysis, columns: Sequence[str] | None = None, language: str = "en", grids: Iterable[Grid] = ()
) -> dict[str, Any]:
    """Return all suggestions for one workbook, in the format of the grid's script.

    `columns` are the keys of the columns of its sheet Devices in English, into which chosen devices are written; None
    without one.
    `language` is that of its headers, in which devices and the choices of their settings are offered. `grids` are the
    sheets that may get further columns.
    """
    robot, graph, firsts = analysis.robot, analysis.graph, _firsts(analysis.robot)
    named = [s for s in graph.streams.values() if s.name]
    streams = [_stream(s.name, s, analysis) for s in named]
    names = {key(a): _stream(a, s, analysis) for s in named for a in [argument_name(s.name)]}
    records, types = {}, dict[str, str]()  # the second by the names of their records
    for device in robot.device_names("sensor"):
        found, name = robot.find(device), argument_name(device)
        if found is not None and found.type.payload is not None:
            records[key(name)] = _record(found.type.payload, found.type.name)
            types.setdefault(found.type.payload.name, found.type.name)
            names.setdefault(key(name), {"text": name, "help": device_help(found.type)})
    known = contents(graph)
    for s in named:
        if s.id in known and (record := known[s.id].record) is not None:
            own = s.device.type if s.device else None
            origin = own.name if own and own.payload else types.get(record.name, "")
            records[key(argument_name(s.name))] = _record(record, origin)
    words = {
        **_fixed(), **cell_words(analysis.workbook, robot), "uses": _uses(analysis),
        "streams": streams, "names": names, "records": records,
        "sensors": _devices(analysis, firsts, "sensor", columns),
        "actuators": _devices(analysis, firsts, "actuator", columns), "choices": _chosen(analysis, columns, language),
        "columns": {grid.name: more for grid in grids if (more := missing_columns(analysis, grid, language))},
        "dones": [
            {"text": f"{s.name} done", "kind": "done", "help": N_("when a command of {name} has ended", name=s.name)}
            for s in named if s.kind is StreamKind.ACTUATOR
        ],
        "helpers": [_helper(h) for h in analysis.workbook.helpers if h.name],
        "tables": [
            {"text": argument_name(s), "help": N_("your table")} for s in analysis.workbook.sheets
            if key(s) in analysis.workbook.tables
        ],
        "devices": [
            {"text": name, "kind": kind, "help": _help(robot, firsts, name), "words": _synonyms(robot, name)}
            for kind in ("sensor", "actuator") for name in _offered(robot, firsts, kind)
        ],
    }  # fmt: skip
    return _as_written_in_japanese(words) if language == "ja" else words


def _as_written_in_japanese(found: dict[str, Any]) -> dict[str, Any]:
    """Return suggestions with the words of a Japanese workbook: devices, their settings, scene, tests and Protocol.

    A device that is `named` so must be in the sheet Devices: the robot itself knows it by its English name.
    """

    def written(words: Mapping[str, str], text: str) -> str:
        return japanese.japanese_word(words, text)

    def own(name: str) -> str:
        return written(japanese.DEVICES, name)

    def chosen(words: Mapping[str, Any], setting: str) -> dict[str, Any]:
        known = japanese.MOVES if setting == "name" else japanese.CHOICES.get(setting, {})
        choices = japanese.japanese(known, [one["text"] for one in words["choices"]])
        return {**words, "choices": [{"text": text} for text in choices]}

    def act(verb: str, values: Sequence[Word]) -> list[Any]:
        labels = verb == "presses"  # of the workbook's own buttons
        texts = [one["text"] if labels else translate(scene_value(verb, one["text"], "ja"), "ja") for one in values]
        return [written(japanese.VERBS, verb), [{**one, "text": text} for one, text in zip(values, texts, strict=True)]]

    for name in ("sensors", "actuators"):
        mine = {key(one["text"]) for one in found[name] if "device" in one}
        found[name] = [
            {**one, "text": own(one["text"]), "adds": {**one["adds"], "device": own(one["adds"]["device"])},
             "named": own(one["text"]) != one["text"]}
            if "adds" in one else one for one in found[name] if "adds" not in one or key(own(one["text"])) not in mine
        ]  # fmt: skip
    for record in found["records"].values():
        record["fields"] = [_field_written(one) for one in record["fields"]]
    found["choices"] = [_choice_written(one) for one in found["choices"]]
    found["devices"] = [{**one, "text": own(one["text"])} for one in found["devices"]]
    for name in ("gestures", "postures"):
        found[name] = [{**m, "text": written(japanese.MOVES, m["text"]), "words": m["text"]} for m in found[name]]
    takes = {device: {s: chosen(words, s) for s, words in known.items()} for device, known in found["takes"].items()}
    also = {key(word): takes[key(device)] for word, device in japanese.DEVICES.items() if key(device) in takes}
    found["takes"] = {**takes, **also}
    found["things"] = [{**one, "text": japanese.japanese_thing(one["text"])} for one in found["things"]]
    found["acts"] = {kind: [act(verb, values) for verb, values in acts] for kind, acts in found["acts"].items()}
    found["expects"] = [{**one, "text": written(japanese.EXPECTED, one["text"])} for one in found["expects"]]
    found["fields"] = [
        {**one, "text": field.name_in("ja"), "words": f"{one['text']} {one['words']}"}
        for one, field in zip(found["fields"], FIELDS.values(), strict=True)
    ]
    for field in FIELDS.values():
        for name in (field.name, *field.synonyms) if field.choices else ():
            choices = [{**asdict(choice), "text": field.shown(choice.text, "ja")} for choice in field.choices]
            found["values"] = {**found["values"], key(name): choices}
    return found


def _field_written(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return a field by its Japanese name, if it has one (those of the workbook's own tables have none), and values."""
    own = next((word for word in found["words"].split() if not word.isascii()), found["text"])
    values = japanese.CHOICES.get(key(found["text"]), {})
    choices = [{"text": japanese.japanese_word(values, c["text"]), "words": c["text"]} for c in found["choices"]]
    return {**found, "text": own, "words": f"{found['text']} {found['words']}", "choices": choices}


def _choice_written(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return a device with one of its choices in Japanese, such as “手を振る”."""
    zone = found["group"] == "zone"
    [(setting, choice)] = found["adds"]["settings"].items()
    own = japanese.japanese_word(japanese.ZONES if zone else japanese.MOVES, choice)
    device = japanese.japanese_word(japanese.DEVICES, found["adds"]["device"])
    text = f"{own}への接触" if zone else own
    return {**found, "text": text, "words": choice, "adds": {"device": device, "settings": {setting: own}}}


def _uses(analysis: Analysis) -> dict[str, dict[str, int]]:
    """Return how many rows use each stream of a behaviour, by its key, and of the sheet Devices, by an empty text."""
    streams, steps = analysis.graph.streams, [s for b in analysis.graph.behaviours for s in b.steps]
    used = Counter(
        stream
        for step in steps
        for stream in {streams[i].done_of or i for i in (*step.inputs, step.output) if i in streams}
        if stream != step.output or streams[stream].kind is StreamKind.ACTUATOR  # what a row gives it does not use
    )
    given = [("", key(device.stream.text)) for device in analysis.workbook.devices]
    given += [(i.partition("!")[0], i.partition("!")[2]) for i, s in streams.items() if s.kind is StreamKind.ORDINARY]
    found: dict[str, dict[str, int]] = {}
    for behaviour, name in given:
        found.setdefault(behaviour, {})[name] = used[f"{behaviour}!{name}" if behaviour else name]
    return found


@lru_cache(maxsize=1)
def _fixed() -> dict[str, Any]:
    functions = {f.name: f for f in library()}
    known = list(dict.fromkeys(connectors()))
    return {
        "connectors": [
            {"text": c.name, "words": " ".join(c.words), "meaning": c.legend_message(),
             "help": N_("{help} (advanced)", help=c.help_message()) if c.advanced else c.help_message()}
            for c in known
        ],
        "periods": [key(c.name) for c in known if c.parameter is Parameter.PERIOD],
        "durations": [{"text": text} for text in ("500 ms", "1 s", "3 s", "10 s", "1 min")],
        "functions": [
            {"text": f"{f.name}(", "name": f.name, "names": f.names, "label": usage(f), "help": first_line(f),
             "words": " ".join(f.words),
             "example": next((N_("{formula} is {value}", formula=a, value=v) for a, v in examples(f)), "")}
            for f in functions.values()
        ],
        "things": [{"text": name, "help": scene_message(kind.help)} for kind in KINDS.values() for name in kind.things],
        "scenetimes": [{"text": text, "help": line} for text, line in TIMES[:-1]],
        "kinds": {
            key(word): found[0] for words in japanese.THING_WORDS.items() for word in words
            if (found := kind_of(words[1])) is not None
        },
        "fields": [
            {"text": field.name, "help": field.prompt, "words": " ".join(field.synonyms)} for field in FIELDS.values()
        ],
        "closed": [key(name) for field in FIELDS.values() if field.closed for name in (field.name, *field.synonyms)],
    }  # fmt: skip


def _helper(helper: Helper) -> Word:
    name = argument_name(helper.name.text)
    usage = f"{name}({', '.join(i.text for i in helper.inputs)})" if helper.inputs else name
    text = N_("your helper: {formula}", formula=helper.formula.text[:60])
    return {"text": name, "name": helper.name.text, "help": text, "label": usage}


def _stream(text: str, stream: Stream, analysis: Analysis) -> Word:
    example = analysis.stream_examples.get(stream.id, "")
    about = N_("for example {example}", example=example) if example else ""
    return {"text": text, "kind": stream.kind.value, "help": about}


def _record(record: RecordType, device: str = "") -> dict[str, Any]:
    fields = []
    for field in record.fields:
        about = N_(field.help, msgctxt=f"{device}.{field.name}" if device else "done") if field.help else ""
        about = N_("{help} ({unit})", help=about, unit=field.unit) if field.unit else about
        also = " ".join(name for name, meant in record.aliases.items() if key(meant) == key(field.name))
        choices = [{"text": choice} for choice in field.choices]
        fields.append({"text": argument_name(field.name), "help": about, "words": also, "choices": choices})
    return {"name": record.name, "fields": fields}


def _devices(
    analysis: Analysis, firsts: Mapping[str, str], kind: str, columns: Sequence[str] | None
) -> list[dict[str, Any]]:
    robot, devices = analysis.robot, analysis.workbook.devices
    used = {key(stream.name) for stream in analysis.graph.streams.values()}
    mine = [d.stream.text for d in devices if (f := robot.find(d.device.text)) and f.type.kind == kind]
    offered = [n for n in _offered(robot, firsts, kind) if key(n) not in {key(m) for m in mine}]
    declared = {key(d.stream.text): d.device.text for d in devices}
    own = ((name, declared[key(name)]) for name in mine)
    return [
        *({"text": n, "kind": kind, "help": N_("of your Devices: {device}", device=d), "device": d,
           "words": _synonyms(robot, d), "used": True} for n, d in own),
        *(
            {"text": n, "kind": kind, "help": _help(robot, firsts, n), "words": _synonyms(robot, n)}
            | ({"used": True} if key(n) in used else {} if columns is None else {"adds": {"device": n, "settings": {}}})
            for n in offered
        ),
    ]  # fmt: skip


def missing_columns(analysis: Analysis, grid: Grid, language: str) -> list[Word]:
    """Return the columns that a sheet may have and has not: settings of its devices, required ones first, or joints."""
    if grid.kind not in SHEETS:
        return []
    has = setting_columns(grid)
    settings: dict[str, tuple[Setting, list[str]]] = {}
    for device in analysis.workbook.devices if grid.kind == "devices" else ():
        known = analysis.robot.find(device.device.text)
        for k, setting in known.type.settings.items() if known else ():
            if known and k not in has and k not in known.preset:
                settings.setdefault(k, (setting, []))[1].append(device.stream.text)
    joints = analysis.robot.joints.items() if grid.kind == "gestures" else ()
    return [
        *({"text": setting_header(s.name, language), "name": s.name, "help": described(s), "streams": listed(streams)}
          for s, streams in sorted(settings.values(), key=lambda one: not one[0].required)),
        *({"text": j.name, "name": j.name, "help": _limits(j), "streams": ""} for k, j in joints if k not in has),
        *({"text": c.header(language), "name": c.name, "help": c.prompt, "streams": ""}
          for c in SHEETS[grid.kind].optional if key(c.name) not in has),
    ]  # fmt: skip


_NAMED = {"zone": "{choice} touch", "gesture": "{choice}", "posture": "{choice}"}
"""Stream names that are proposed for a device with one of its choices, by the kind of the setting."""


def _chosen(analysis: Analysis, columns: Sequence[str] | None, language: str) -> list[dict[str, Any]]:
    """Return devices with one of the choices of a setting, as “Wave”; its column comes along if Devices lacks it."""
    if columns is None:
        return []
    robot = analysis.robot
    taken = {*robot.names, *(key(s.name) for s in analysis.graph.streams.values())}
    taken |= {key(d.stream.text) for d in analysis.workbook.devices}
    found = []
    for kind in ("sensor", "actuator"):
        for device in filter(None, map(robot.find, robot.device_names(kind))):
            setting = next((s for s in device.type.settings.values() if s.kind in _NAMED), None)
            if setting is None or device.preset:
                continue
            for choice in (c["text"] for c in _choices(setting, robot, analysis.workbook)):
                name = _NAMED[setting.kind].format(choice=choice)
                if key(name) not in taken:
                    found.append({
                        "text": name, "kind": kind, "group": setting.kind,
                        "help": _choice_help(robot, device, setting, choice, language),
                        "adds": {"device": device.name, "settings": {setting.name: choice}},
                    })  # fmt: skip
    return found


def _gesture_help(text: str) -> str:
    return LazyMessage(text, msgctxt="gesture") if text else ""


def _choice_help(robot: Robot, device: FoundDevice, setting: Setting, choice: str, language: str) -> str:
    zone, motion = setting.kind == "zone", robot.motions.get(key(choice))
    own = japanese.word_in(japanese.ZONES if zone else japanese.MOVES, choice, language)
    if zone:
        return N_("Somebody touches this part of the robot or lets go: {zone}.", zone=own)
    name, header = japanese.word_in(japanese.DEVICES, device.name, language), setting_header(setting.name, language)
    places = {"device": name, "setting": header, "value": own}
    if motion and motion.help and setting.kind == "gesture":
        return N_("{device} with {setting} = {value}: {help}", help=_gesture_help(motion.help), **places)
    return N_("{device} with {setting} = {value}", **places)


def _offered(robot: Robot, firsts: Mapping[str, str], kind: str) -> list[str]:
    """Return the devices in catalogue order; names of the same device stand together, the shorter one first."""
    names = robot.device_names(kind)
    places: dict[str, int] = {}
    for place, name in enumerate(names):
        places.setdefault(firsts[key(name)], place)
    return sorted(names, key=lambda name: (places[firsts[key(name)]], len(name)))


def _firsts(robot: Robot) -> dict[str, str]:
    """Map the key of each device name to the shortest name of the same device."""
    shortest: dict[tuple[str, frozenset[tuple[str, Value]]], str] = {}
    for found in robot.names.values():
        if found.offered and len(found.name) < len(shortest.get(_thing(found), found.name + " ")):
            shortest[_thing(found)] = found.name
    return {name: shortest.get(_thing(found), found.name) for name, found in robot.names.items()}


def _thing(found: FoundDevice) -> tuple[str, frozenset[tuple[str, Value]]]:
    return found.type.name, frozenset(found.preset.items())


def _help(robot: Robot, firsts: Mapping[str, str], name: str) -> str:
    first, found = firsts.get(key(name), name), robot.find(name)
    if key(first) != key(name):
        return N_("the same as {name}", name=first)
    return device_help(found.type) if found else ""


def _synonyms(robot: Robot, name: str) -> str:
    """Return plain words for a device, by which it is found too."""
    found = robot.find(name)
    return " ".join(plain_words(found.type, robot)) if found and "joint" not in found.preset else ""


_EXPECTS = (
    ("any", N_("any value")), ("nothing", N_("no value since the row before")),
    ("nothing or blank", N_("no value but blanks, which stop an actuator")),
    ("≈0.5", N_("about this number, as it rounds")),
    (">0.5", N_("a condition; also <, <>, AND(value > 1; value < 2)")), ("blank", N_("a blank")),
)  # fmt: skip


def cell_words(workbook: Workbook, robot: Robot) -> dict[str, Any]:
    """Return the suggestions for the cells of one workbook, in the format of the grid's script."""
    behaviours = [{"text": b.name} for b in workbook.behaviours]
    return {
        "takes": _takes(robot, workbook),
        "instead": _instead(robot),
        "joints": {key(j.name): _about(j) for j in robot.joints.values()},
        "gestures": [{"text": g.name, "help": _gesture_help(g.help)} for g in robot.motions.values()],
        "postures": [{"text": name, "help": N_("a posture")} for name in robot.postures],
        "acts": _acts(robot, [d.settings["label"].text for d in workbook.devices if "label" in d.settings]),
        "expects": [{"text": text, "help": line} for text, line in _EXPECTS],
        "values": {
            "robot": [{"text": n} for n in robot_names()],
            "run": behaviours,
            **{
                key(name): [asdict(choice) for choice in field.choices]
                for field in FIELDS.values() if field.choices for name in (field.name, *field.synonyms)
            },
        },
    }  # fmt: skip


def _takes(robot: Robot, workbook: Workbook) -> dict[str, dict[str, Any]]:
    """Return the settings that each device takes, by the keys of the device's and the setting's names."""
    found = {}
    for name in robot.device_names("sensor") + robot.device_names("actuator"):
        if device := robot.find(name):
            found[key(name)] = {
                k: {"name": s.name, "help": described(s), "choices": _choices(s, robot, workbook)}
                for k, s in device.type.settings.items() if k not in device.preset
            }  # fmt: skip
    return found


def _instead(robot: Robot) -> dict[str, dict[str, list[str]]]:
    """Return the devices to use instead of one that lacks a setting, by the keys of the device and the setting."""
    known = {k for device in robot.devices.values() for k in device.settings}
    devices = [d for kind in ("sensor", "actuator") for n in robot.device_names(kind) if (d := robot.find(n))]
    by_type = {
        d.type.name: {k: [o.name for o in others] for k in known - set(d.type.settings)
                      if (others := robot.others_with(d, k))}
        for d in {d.type.name: d for d in devices}.values()  # what to use instead does not depend on its name
    }  # fmt: skip
    return {key(d.name): settings for d in devices if (settings := by_type[d.type.name])}


def _choices(setting: Setting, robot: Robot, workbook: Workbook) -> list[Word]:
    listed = {
        "joint": [*(j.name for j in robot.joints.values()), *robot.groups], "zone": robot.touch_zones,
        "posture": robot.postures, "gesture": robot.gestures, "colour": setting.choices or COLOURS,
        "language": robot.languages, "behaviour": [b.name for b in workbook.behaviours],
    }.get(setting.kind, setting.choices)  # fmt: skip
    return [{"text": c} for c in listed]


def _limits(joint: Joint) -> str:
    if not joint.unit:
        return N_("{low:g} (closed) to {high:g} (open).", low=joint.lower, high=joint.upper)
    low, high = (f"{a:.2f} ({math.degrees(a):.0f}°)" for a in (joint.lower, joint.upper))
    return N_("{low} to {high} rad; 30° is fine.", low=low, high=high)


def _about(joint: Joint) -> Word:
    """Describe the limits of a joint's angle, for a Gestures sheet."""
    blank = N_("Blank: it is on its way to the next keyframe that has it.")
    return {"name": joint.name, "help": sentences(_limits(joint), blank)}


def _acts(robot: Robot, labels: list[str]) -> dict[str, list[Any]]:
    """Return the verbs of each kind of thing, with examples of their values and a line of help."""
    own = {
        ("person", "touches"): [{"text": zone} for zone in robot.touch_zones],
        ("operator", "presses"): [{"text": label} for label in labels if label],
    }
    known = {
        (kind.name, verb.name): [{"text": text, "help": scene_message(line)} for text, line in verb.examples if text]
        for kind in KINDS.values() for verb in kind.verbs
    }  # fmt: skip
    return {
        kind.name: [[verb.name, own.get((kind.name, verb.name)) or known[kind.name, verb.name]] for verb in kind.verbs]
        for kind in KINDS.values()
    }


ON_PAGES: Mapping[str, str] = {
    "See `rrp-sheets help devices`.": N_("See Help (F1): devices."),
    "See `rrp-sheets help functions`.": N_("See Help (F1): functions."),
    "See `rrp-sheets check`.": N_("See the list of problems."),
    "Copy the cells you need into a new workbook (`rrp-sheets new FILE` makes one) and use that. If the file came from "
    "someone else, ask them where it comes from before you go on.": N_(
        "Copy the cells you need into a new workbook and use that. If the file came from someone else, ask them where "
        "it comes from before you go on."
    ),
    "Make a new workbook with `rrp-sheets new FILE`, or take an earlier copy.": N_(
        "Create a new workbook on the page Workbooks, or use an earlier copy."
    ),
    "Name another folder with --out.": N_("See to it that runs can be kept beside the workbook."),
    "Make room, or name another folder with --out.": N_("Make room."),
}
"""What a page says instead of a text with a command, which cannot be followed there."""


def in_browser(text: str) -> str:
    """Return a message as a page shows it: without commands of the terminal.

    >>> in_browser(N_("{before} {after}", before=N_("There is no “Blue”."), after=N_("See `rrp-sheets help devices`.")))
    'There is no “Blue”. See Help (F1): devices.'
    """
    if not isinstance(text, LazyMessage):
        return text
    if (instead := ON_PAGES.get(text.template)) is not None:
        return LazyMessage(instead, **text.places)
    places = {name: in_browser(value) if isinstance(value, str) else value for name, value in text.places.items()}
    return text if places == text.places else LazyMessage(text.template, msgctxt=text.context, **places)
