"""Device streams of a workbook: those of the Devices sheet with their settings, and names of the robot's devices."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, FixEdit, Insert, Put, meant, surely
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import meant_duration, parse_duration
from rrp_sheets.model.names import Proposals, is_reserved, key, nearest
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Address, Cell, Device, Workbook, truth_of
from rrp_sheets.robots import DeviceType, FoundDevice, Robot, Setting
from rrp_sheets.robots.media_files import is_plain
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.workbook.schema import DEVICES, setting_header

_DONE = re.compile(r"(.*\S)[\s_\-]*done", re.IGNORECASE)
_HEX = re.compile(r"#[0-9a-f]{6}", re.IGNORECASE)
_DEGREES = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)\s*°")
_NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)(e[+-]?\d+)?", re.IGNORECASE)
_WEAK, _STRONG = re.compile("[,，、]"), re.compile("[;；\n]")
_ENDS = ("please", "thanks", "thank you", "robot", "nao", "too", "sir", "madam", "darling", "everybody", "everyone")
_QUOTED = re.compile(r"""["“”„«][^"“”„«»]*["“”»]""")
LONGEST_SETTING = 1_000  # characters: minutes of speech
COLOURS = ("white", "red", "green", "blue", "yellow", "magenta", "cyan", "orange", "purple", "pink", "black")


@dataclass(frozen=True)
class Declared:
    """Stream that is a device: the device, its settings, and where it is declared (None when used by name alone)."""

    name: str
    found: FoundDevice
    settings: Mapping[str, Value]
    address: Address | None = None


class DeviceTable:
    """All device streams by key; those that use a device's own name are added when first looked up."""

    def __init__(self, workbook: Workbook, robot: Robot, report: Report) -> None:
        self.robot = robot
        self.report = report
        self.workbook = workbook
        self.declared: dict[str, Declared] = {}
        self._implicit: dict[str, Declared] = {}
        known = workbook.language != "en" and (workbook.language in robot.languages or not robot.languages)
        self._language = workbook.language if known else ""  # of speech, instead of the robot's usual one
        self.propose = Proposals()
        self.broken: set[str] = set()  # declared, but with an unknown device: told once, at the Devices row
        self._mine: Mapping[str, tuple[str, ...]] = {  # names that settings may take from the workbook itself
            "behaviour": tuple(b.name for b in workbook.behaviours),
            "gesture": tuple(dict.fromkeys(g.name.text for g in workbook.gestures if g.name)),
        }
        self._headers = {k: header.strip() for d in workbook.devices for k, header in d.headers.items()}
        misspelt = self._misspelt_columns(workbook.devices)
        for device in workbook.devices:
            settings = {
                misspelt.get(k, k): _standard(misspelt[k], cell) if k in misspelt else cell
                for k, cell in device.settings.items() if misspelt.get(k) != "notes"
            }  # fmt: skip
            self._declare(device.stream, device.device, settings)
        for k, declared in list(self.declared.items()):  # of an actuator that may be declared after it
            if self.done(declared.name) is not None and declared.address is not None:
                self.report.add("GRAPH016", declared.address, name=declared.name)
                del self.declared[k]

    def _misspelt_columns(self, devices: Sequence[Device]) -> dict[str, str]:
        """Return the settings meant by misspelt column headers, by the headers' keys, and report each header once."""
        known = {k for device in self.robot.devices.values() for k in device.settings}
        filled: dict[str, list[tuple[Cell, FoundDevice]]] = {}
        for device in devices:
            found = self.robot.find(device.device.text)
            for k, cell in device.settings.items() if found else ():
                if cell and k not in known and found is not None:
                    filled.setdefault(k, []).append((cell, found))
        meant = {}
        for k, uses in filled.items():
            settings = {key(s.name): s.name for _, found in uses for s in found.type.settings.values()}
            free = [name for s, name in settings.items() if not any(s in d.settings for d in devices)]
            own = japanese.words_for(japanese.SETTINGS, *free)
            guess = nearest(k, [*free, *own, *(c.name for c in DEVICES.optional)])
            if guess:
                meant[k] = key(japanese.standard(japanese.SETTINGS, guess))
                cell, found = uses[0]
                header = self._headers.get(k, k)
                remedy = N_("Did you mean {guess}? Then correct the header of this column.", guess=guess)
                self.report.add("DEV007", cell.address, device=found.name, setting=header, remedy=remedy)
        return meant

    def _declare(self, stream: Cell, device: Cell, settings: Mapping[str, Cell]) -> None:
        if not stream:
            self.report.add("DEV005", stream.address)
            return
        if is_reserved(stream.text):
            self.report.add("GRAPH018", stream.address, name=stream.text)
        k = key(stream.text)
        if k in self.declared:
            other = self.declared[k].address
            self.report.add("DEV002", stream.address, name=stream.text, other=str(other))
            return
        found = self.robot.find(device.text)
        if found is None:
            if not device:
                self.report.add("DEV006", device.address, stream=stream.text)
            else:
                guess = nearest(device.text, [*(f.name for f in self.robot.names.values()), *japanese.DEVICES])
                remedy = self.device_remedy(device.text, guess) or meant(guess, N_("See `rrp-sheets help devices`."))
                self.report.add("DEV001", device.address, name=device.text, **remedy)
            self.broken.add(k)
            return
        values = self._settings(found, settings, stream, device)
        self.declared[k] = Declared(stream.text, found, values, stream.address)

    def _settings(self, found: FoundDevice, cells: Mapping[str, Cell], stream: Cell, device: Cell) -> dict[str, Value]:
        values = self._usual(found, stream.text)
        for k, cell in cells.items():
            if not cell:
                continue
            setting = found.type.settings.get(k)
            if setting is None:
                self._unknown_setting(found, k, cell, device)
                continue
            value, wants = understand(setting, cell.text, self.robot, self._mine.get(setting.kind, ()))
            if wants and setting.kind == "behaviour":
                self.report.add("DEV010", cell.address, name=cell.text, wants=wants)
            elif wants:
                name = N_(setting.name, msgctxt="setting")
                self.report.add("DEV004", cell.address, text=cell.text, setting=name, wants=wants)
            values[k] = setting.default if wants else value
        for k, setting in found.type.settings.items():
            blank = k not in cells or not cells[k]
            if setting.required and blank and values.get(k) in (None, ""):
                at = cells[k].address if k in cells else stream.address
                fixes = () if k in cells else setting_fixes(self.workbook, setting, stream.text, found.name)
                header, help_text = setting_header(setting.name, self.workbook.language), setting.help
                fill = N_("Fill in the column {setting} of this row: {help}.", setting=header, help=help_text)
                add = N_(
                    "Add the column {setting}, and fill it in for this row: {help}.", setting=header, help=help_text
                )
                remedy = fill if k in cells else add
                self.report.add("DEV003", at, fixes=fixes, device=found.name, setting=setting.name, remedy=remedy)
        return values

    def _unknown_setting(self, found: FoundDevice, k: str, cell: Cell, device: Cell) -> None:
        names = [s.name for s in found.type.settings.values()]
        remedy: str = N_("Leave the cell blank; its settings are: {names}.", names=", ".join(names))
        if not names:
            remedy = N_("It has no settings: leave the cell blank.")
        others = self.robot.others_with(found, k)[:2]
        if others:
            helps = ((f.name, N_(f.type.help, msgctxt=f"{f.type.name}.help")) for f in (found, *others))
            each = sentences(*(N_("{name}: {help}", name=name, help=help) for name, help in helps))
            remedy = N_("{each} Use that device, or leave the cell blank.", each=each)
        fixes = []
        for name in (other.name for other in others):
            title, edit = N_("Use {name}", name=name), Put(device.address, name)
            fixes.append(Fix(f"use-{name.casefold().replace(' ', '-')}", title, (edit,)))
        header = self._headers.get(k, k)
        self.report.add("DEV007", cell.address, fixes=fixes, device=found.name, setting=header, remedy=remedy)

    def _usual(self, found: FoundDevice, stream: str) -> dict[str, Value]:
        """Return the settings of a device that no cell gives: its presets, the stream's name as label, defaults.

        The language is that of the workbook, if its headers are Japanese and the robot speaks that.
        """
        values: dict[str, Value] = {
            k: stream if s.kind == "label" else self._language if s.kind == "language" and self._language else s.default
            for k, s in found.type.settings.items()
        }
        return {**values, **found.preset}

    def find(self, name: str) -> Declared | None:
        """Return the device behind a stream name, declared or used by its own name (English or Japanese), or None."""
        k = key(name)
        if k in self.declared or k in self.broken:
            return self.declared.get(k)
        if k not in self._implicit:
            found = self.robot.find(japanese.standard(japanese.DEVICES, name))
            if found is None:
                return None
            self._implicit[k] = Declared(found.name, found, self._usual(found, name))
        return self._implicit[k]

    def done(self, name: str) -> tuple[str, Declared] | None:
        """Return the actuator stream (name and device) whose done stream a name stands for (`Ask done`), or None."""
        of = done_of(name)
        found = self.find(of) if of else None
        return (of, found) if found and found.found.type.kind == "actuator" else None

    def device_remedy(self, word: str, guess: str | None, kind: str = "") -> dict[str, Any]:
        """Return the details `remedy` and `guess` for a plain word of devices (of a kind), such as `hand`.

        They are empty for another word, and for one that is nearly spelt as the `guess`. With a kind, the word is that
        of a stream: a device that needs a setting is then proposed for the sheet Devices. Devices have the names of the
        workbook's language, where there is a sheet Devices to declare them.
        """
        found = [] if guess and surely(word, guess) else self.robot.devices_for(word, kind)
        if not found:
            return {}
        declared = [d for d in found if kind and any(s.required or s.kind == "gesture" for s in d.settings.values())]
        plain = [d for d in found if d not in declared]
        names = [d.title for d in plain or found]
        if self.workbook.language == "ja" and self.workbook.device_sheet:
            names = list(japanese.japanese(japanese.DEVICES, names))
        if not plain:
            return {"remedy": N_("Declare “{text}” in the sheet Devices, with the device {guess} and its settings.",
                                 text=word, guess=listed(names, "or"))}  # fmt: skip
        remedy = N_("Did you mean {guess}?", guess=listed(names, "or"))
        return {"remedy": remedy, "guess": names[0]} if len(names) == 1 else {"remedy": remedy}

    def needs_declaring(self, declared: Declared) -> Setting | None:
        """Return the required setting that a device used by its name alone lacks (`Say parameter`: Text), or None."""
        if declared.address is not None:
            return None
        settings = declared.found.type.settings
        return next((s for k, s in settings.items() if s.required and declared.settings.get(k) in (None, "")), None)

    def names(self, kind: str) -> list[str]:
        """Return the names to propose: declared streams first, then the robot's devices."""
        mine = [d.name for d in self.declared.values() if d.found.type.kind == kind]
        return mine + self.robot.device_names(kind)


def setting_fixes(workbook: Workbook, setting: Setting, stream: str, device: str, text: str = "") -> list[Fix]:
    """Return the fix that makes place in the sheet Devices for a setting to be filled in, if there is one.

    With a text, it is written there.
    """
    header = setting_header(setting.name, workbook.language)
    edits, cell = setting_edits(workbook, stream, device, setting.name, text)
    if any(isinstance(edit, Insert) for edit in edits):
        return [Fix("declare", N_("Add “{stream}” to the sheet Devices", stream=stream), edits, fill=cell)]
    if text and len(edits) == 1:
        return [Fix("fill-setting", N_("Write {value} into the column {header}", value=text, header=header), edits)]
    if text and edits:
        return [Fix("add-column", N_("Add the column {header} and write {value}", header=header, value=text), edits)]
    return [Fix("add-column", N_("Add the column {header}", header=header), edits, fill=cell)] if edits else []


def setting_edits(
    workbook: Workbook, stream: str, device: str, setting: str, text: str = ""
) -> tuple[tuple[FixEdit, ...], Address | None]:
    """Return the edits that make place in the sheet Devices for a setting of a stream, and write a text there.

    They add the column and the row if these are missing. The address is the cell's; without such a sheet there is none.
    """
    sheet = workbook.device_sheet
    rows = [d.stream.address for d in workbook.devices if key(d.stream.text) == key(stream)]
    if sheet is None or any(at.sheet != sheet.address.sheet for at in rows):
        return (), None
    name, edits = sheet.address.sheet, list[FixEdit]()
    cell = Address(name, rows[0].row if rows else sheet.last + 1, sheet.columns.get(key(setting), sheet.free))
    if key(setting) not in sheet.columns:
        edits.append(Put(Address(name, sheet.address.row, cell.column), setting_header(setting, workbook.language)))
    if rows:
        return (*edits, Put(cell, text)) if text else tuple(edits), cell
    cells = sorted({sheet.columns["stream"]: stream, sheet.columns["device"]: device, cell.column: text}.items())
    return (*edits, Insert(name, cell.row, tuple((column, text) for column, text in cells if text))), cell


def _standard(setting: str, cell: Cell) -> Cell:
    """Return a cell of a setting that a misspelt header means, with the standard word for a Japanese choice."""
    return replace(cell, text=japanese.standard(japanese.CHOICES.get(setting, {}), cell.text))


def done_of(name: str) -> str:
    """Return the stream whose done stream a name stands for, as `Ask` in `Ask done`; empty for other names.

    >>> done_of("Ask done"), done_of("head_tracker_DONE"), done_of("SayDone"), done_of("done"), done_of("Ask")
    ('Ask', 'head_tracker', 'Say', '', '')
    """
    words = _DONE.fullmatch(name.strip())
    return words[1].rstrip("_-") if words else ""


def describe(device: DeviceType) -> str:
    """Return `a sensor` or `an actuator`."""
    return N_("a sensor") if device.kind == "sensor" else N_("an actuator")


def understand(setting: Setting, text: str, robot: Robot, mine: Sequence[str] = ()) -> tuple[Value, str]:
    """Return the value of a setting's text and, if it is not understood, what is expected (else an empty text).

    `mine` are names of the workbook's own that it may be: behaviours, gestures.
    """
    if setting.kind == "number":
        return _number(setting, text)
    if setting.kind == "truth":
        meant = truth_of(text)
        return meant, "" if meant is not None else N_("TRUE or FALSE (yes and no also work)")
    if setting.kind == "angle":
        degrees = text.strip().removesuffix("°") if _DEGREES.fullmatch(text.strip()) else ""
        return _number(setting, str(math.radians(float(degrees))) if degrees else text)
    names = _names_for(setting, robot, mine)
    if names is not None:
        by_key = {key(n): n for n in reversed(names)}
        ours = setting.kind in ("choice", "zone")
        shown = [N_(name, msgctxt="value") for name in names] if ours else names
        return by_key.get(key(text)), "" if key(text) in by_key else _one_of(text, shown)
    if setting.kind == "joint":
        k = key(text)
        if k in robot.joints:
            return robot.joints[k].name, ""
        if k in robot.groups:
            return next(g for g in robot.data["groups"] if key(g) == k), ""
        guess = nearest(text, [j.name for j in robot.joints.values()] + list(robot.data["groups"]))
        return None, N_("a joint such as {value}", value=guess or "HeadYaw")
    if setting.kind == "colour":
        if _HEX.fullmatch(text):
            return text.casefold(), ""
        wants = N_("a colour such as {value} or #ff8000", value=nearest(text, COLOURS) or "red")
        return key(text), "" if key(text) in COLOURS else wants
    if setting.kind == "words":
        words = tuple(dict.fromkeys(phrases(text)))
        good = bool(words) and len(text) <= LONGEST_SETTING
        return words, "" if good else N_("words with commas between them, for example yes, no")
    if setting.kind in ("language", "sound file"):
        return _language(text, robot) if setting.kind == "language" else _sound_file(text.strip())
    if setting.kind == "duration":
        us = parse_duration(text, bare="s")
        return us, "" if us is not None else N_("a time such as {value}", value=meant_duration(text, "s") or "2 s")
    return text, "" if len(text) <= LONGEST_SETTING else N_("a text of at most {most} characters", most=LONGEST_SETTING)


def phrases(text: str) -> list[str]:
    """Return the words and phrases of a list.

    Semicolons or line breaks divide it where there are any, else commas. A phrase in quotation marks is one phrase.

    >>> phrases("yes, no"), phrases('"yes, please", no'), phrases("yes, please; no")
    (['yes', 'no'], ['yes, please', 'no'], ['yes, please', 'no'])
    """
    divider = _STRONG if _STRONG.search(_QUOTED.sub("", text)) else _WEAK
    found, at = [], 0
    marks = [m.span() for m in divider.finditer(_QUOTED.sub(lambda m: "x" * len(m[0]), text))]
    for start, end in [*marks, (len(text), len(text))]:
        piece = text[at:start].strip(" \t\n,，、")
        found.append(piece[1:-1].strip() if _QUOTED.fullmatch(piece) else piece)
        at = end
    return [phrase for phrase in found if phrase]


def doubtful_phrase(text: str) -> str:
    """Return the first phrase that keeps a comma only because semicolons or line breaks divide the list.

    >>> doubtful_phrase("yes, please; no"), doubtful_phrase('"yes, please"; no'), doubtful_phrase("yes, no")
    ('yes, please', '', '')
    """
    bare = _QUOTED.sub("", text)
    if not _STRONG.search(bare) or not _WEAK.search(bare):
        return ""
    quoted = {m[0][1:-1].strip() for m in _QUOTED.finditer(text)}
    return next((phrase for phrase in phrases(text) if _WEAK.search(phrase) and phrase not in quoted), "")


def divided_phrase(text: str) -> tuple[str, int]:
    """Return a list that commas divide although it may be one phrase, and the number of its parts; else a blank one.

    A part such as `please` is seldom a word of its own.

    >>> divided_phrase("yes, please"), divided_phrase("yes, no"), divided_phrase('"yes, please"')
    (('yes, please', 2), ('', 0), ('', 0))
    """
    bare = _QUOTED.sub("", text)
    if _STRONG.search(bare) or not _WEAK.search(bare):
        return "", 0
    parts = phrases(text)
    return (text.strip(), len(parts)) if any(part.casefold() in _ENDS for part in parts[1:]) else ("", 0)


def _sound_file(name: str) -> tuple[Value, str]:
    wants = N_("the name of a .wav file next to the workbook, such as song.wav, without a folder")
    return name, "" if is_plain(name) else wants


def _language(text: str, robot: Robot) -> tuple[Value, str]:
    """Return the code of a language, given its code or name (`German`); a robot without a list takes any."""
    languages = robot.languages
    code = text.strip().casefold().replace("_", "-")
    if code in languages or not languages:
        return code, ""
    names = {key(name): code for code, name in reversed(list(languages.items()))}
    if key(text) in names:
        return names[key(text)], ""
    guess = nearest(text, languages.values()) or nearest(text, languages)
    near = names.get(key(guess), guess) if guess else "de"
    return None, N_("a language such as {near} ({value})", near=near, value=languages[near])


def _names_for(setting: Setting, robot: Robot, mine: Sequence[str]) -> tuple[str, ...] | None:
    """Return the names that are allowed as a setting's value; None when its kind has no such list."""
    if setting.kind == "choice":
        return setting.choices
    if setting.kind == "zone":
        return robot.touch_zones
    if setting.kind == "posture":
        return robot.postures
    if setting.kind == "gesture":
        return (*mine, *robot.gestures)
    return tuple(mine) if setting.kind == "behaviour" else None


def _one_of(text: str, names: Sequence[str]) -> str:
    guess = nearest(text, names)
    every = listed(names)
    if not names:
        return N_("the name of a sheet with rows")
    if guess and len(names) > 3:
        return N_("{guess} (it can be {listed})", guess=guess, listed=every)
    return N_("one of {listed}", listed=every) if len(names) > 1 else every


def _number(setting: Setting, text: str) -> tuple[Value, str]:
    low, high = setting.lower, setting.upper
    unit = N_(setting.unit, msgctxt="value")
    wants = N_("a number ({unit})", unit=unit) if unit else N_("a number")
    if low is not None and high is not None:
        wants = N_(
            "a number from {low:g} to {high:g} ({unit})" if unit else "a number from {low:g} to {high:g}",
            low=low, high=high, unit=unit,
        )  # fmt: skip
    bare = text.strip().removesuffix(setting.unit).strip() if setting.unit else text.strip()
    if not _NUMBER.fullmatch(bare):
        pointed = bare.replace(",", ".")
        return None, N_("{pointed}, with a decimal point", pointed=pointed) if _NUMBER.fullmatch(pointed) else wants
    number = float(bare)
    if not math.isfinite(number):
        return None, wants
    inside = (low is None or number >= low) and (high is None or number <= high)
    return (int(number) if number == int(number) else number), "" if inside else wants
