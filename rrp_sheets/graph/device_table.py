"""Device streams of a workbook: those of the Devices sheet, and names of the robot's devices with default settings."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from rrp_sheets.devices import DeviceType, FoundDevice, Robot, Setting
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.fix import Fix, Put
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.graph.settings import understand
from rrp_sheets.model.cells import Address, Cell
from rrp_sheets.model.names import Proposals, is_reserved, key, nearest
from rrp_sheets.model.values import Value
from rrp_sheets.model.workbook import Device, Workbook

_DONE = re.compile(r"(.*\S)[\s_\-]*done", re.IGNORECASE)


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
        self.declared: dict[str, Declared] = {}
        self._implicit: dict[str, Declared] = {}
        self.propose = Proposals()
        self.broken: set[str] = set()  # declared, but with an unknown device: told once, at the Devices row
        self._mine: Mapping[str, tuple[str, ...]] = {  # names that settings may take from the workbook itself
            "behaviour": tuple(b.name for b in workbook.behaviours),
            "gesture": tuple(dict.fromkeys(g.name.text for g in workbook.gestures if g.name)),
        }
        self._headers = {k: header.strip() for d in workbook.devices for k, header in d.headers.items()}
        misspelt = self._misspelt_columns(workbook.devices)
        for device in workbook.devices:
            settings = {misspelt.get(k, k): cell for k, cell in device.settings.items() if misspelt.get(k) != "notes"}
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
            guess = nearest(k, [*free, "Notes"])
            if guess:
                meant[k] = key(guess)
                cell, found = uses[0]
                remedy = Phrase("Did you mean {guess}? Then correct the header of this column.", guess=guess)
                self.report.add(
                    "DEV007", cell.address, device=found.name, setting=self._headers.get(k, k), remedy=remedy
                )
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
            guess = nearest(device.text, [f.name for f in self.robot.names.values()])
            remedy = Phrase("Did you mean {guess}?", guess=guess) if guess else "See `rrp-sheets help devices`."
            if not device:
                self.report.add("DEV006", device.address, stream=stream.text)
            else:
                self.report.add("DEV001", device.address, name=device.text, remedy=remedy)
            self.broken.add(k)
            return
        values = self._settings(found, settings, stream, device)
        self.declared[k] = Declared(stream.text, found, values, stream.address)

    def _settings(self, found: FoundDevice, cells: Mapping[str, Cell], stream: Cell, device: Cell) -> dict[str, Value]:
        values = _usual(found, stream.text)
        for k, cell in cells.items():
            if not cell:
                continue
            setting = found.type.settings.get(k)
            if setting is None:
                self._unknown_setting(found, k, cell, device)
                continue
            values[k] = self._setting(setting, cell)
        for k, setting in found.type.settings.items():
            blank = k not in cells or not cells[k]
            if setting.required and blank and values.get(k) in (None, ""):
                cell_address = cells[k].address if k in cells else stream.address
                self.report.add("DEV003", cell_address, device=found.name, setting=setting.name, help=setting.help)
        return values

    def _unknown_setting(self, found: FoundDevice, k: str, cell: Cell, device: Cell) -> None:
        names = [s.name for s in found.type.settings.values()]
        remedy: str = Phrase("Leave the cell blank; its settings are: {names}.", names=", ".join(names))
        if not names:
            remedy = "It has no settings: leave the cell blank."
        others = self.robot.others_with(found, k)[:2]
        if others:
            each = " ".join(f"{one.name}: {one.type.help}" for one in (found, *others))
            remedy = Phrase("{each} Use that device, or leave the cell blank.", each=each)
        here = device.address
        fixes = [Fix(Phrase("Use {name}", name=o.name), (Put(here, o.name),)) for o in others if here]
        self.report.add(
            "DEV007", cell.address, fixes=fixes, device=found.name, setting=self._headers.get(k, k), remedy=remedy
        )

    def _setting(self, setting: Setting, cell: Cell) -> Value:
        value, wants = understand(setting, cell.text, self.robot, self._mine.get(setting.kind, ()))
        if wants and setting.kind == "behaviour":
            self.report.add("DEV010", cell.address, name=cell.text, wants=wants)
            return setting.default
        if wants:
            self.report.add("DEV004", cell.address, text=cell.text, setting=setting.name, wants=wants)
            return setting.default
        return value

    def find(self, name: str) -> Declared | None:
        """Return the device behind a stream name, declared or used by its own name; None if there is none."""
        k = key(name)
        if k in self.declared or k in self.broken:
            return self.declared.get(k)
        if k not in self._implicit:
            found = self.robot.find(name)
            if found is None:
                return None
            self._implicit[k] = Declared(found.name, found, _usual(found, name))
        return self._implicit[k]

    def done(self, name: str) -> tuple[str, Declared] | None:
        """Return the actuator stream (name and device) whose done stream a name stands for (`Ask done`), or None."""
        of = done_of(name)
        found = self.find(of) if of else None
        return (of, found) if found and found.found.type.kind == "actuator" else None

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


def done_of(name: str) -> str:
    """Return the stream whose done stream a name stands for, as `Ask` in `Ask done`; empty for other names.

    >>> done_of("Ask done"), done_of("head_tracker_DONE"), done_of("SayDone"), done_of("done"), done_of("Ask")
    ('Ask', 'head_tracker', 'Say', '', '')
    """
    words = _DONE.fullmatch(name.strip())
    return words[1].rstrip("_-") if words else ""


def _usual(found: FoundDevice, stream: str) -> dict[str, Value]:
    """Return the default settings of a device, with its presets and the stream's name as label."""
    values = {k: stream if s.kind == "label" else s.default for k, s in found.type.settings.items()}
    values.update(found.preset)
    return values


def describe(device: DeviceType) -> str:
    """Return `a sensor` or `an actuator`."""
    return "a sensor" if device.kind == "sensor" else "an actuator"
