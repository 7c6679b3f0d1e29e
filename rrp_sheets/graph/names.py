"""Resolves the stream names in rows: ordinary streams of the sheet, declared devices, devices of the robot."""

from __future__ import annotations

import re
from collections.abc import Sequence
from functools import cached_property
from typing import Any

from rrp_sheets.connectors import Connector
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, Insert, Put, meant
from rrp_sheets.graph import Stream, StreamKind
from rrp_sheets.graph.device_table import Declared, DeviceTable, describe, done_of, setting_fixes
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.japanese import LETTERS
from rrp_sheets.model.names import argument_name, is_reserved, key
from rrp_sheets.model.workbook import Behaviour, Cell, Row
from rrp_sheets.robots import DeviceType, FoundDevice
from rrp_sheets.texts import N_

DONE_DEVICE = FoundDevice(
    "Done", DeviceType("Done", "sensor", "Tells the end of every command of an actuator stream.", payload=DONE)
)
_AND = re.compile(r"[;&+/]|\band\b", re.IGNORECASE)  # what is written between two names instead of a comma
_ENDED = re.compile(r"[\W_]+(?:done|finished|ended|completed?|over|ready|end)$", re.IGNORECASE)
_IS = re.compile(r"[\W_]+(?:is|has|was)$", re.IGNORECASE)
_LONGEST_ENDED = 100  # letters of a name that is looked at as one of a done stream
_SHARED = N_("Behaviours share only devices. Use the same sensor here, and repeat the rows that you need.")
_KINDS = {"sensor": StreamKind.SENSOR, "actuator": StreamKind.ACTUATOR}


class Names:
    """Resolver of the stream names of one behaviour; it adds the streams that it finds to `streams`."""

    def __init__(
        self, behaviour: Behaviour, connectors: Sequence[Connector | None], devices: DeviceTable,
        streams: dict[str, Stream], report: Report, sheets: frozenset[str],
    ) -> None:  # fmt: skip
        self.sheet = key(behaviour.name)
        self.sheets = sheets
        self.devices = devices
        self.streams = streams
        self.report = report
        self.rows: dict[str, Row] = {}  # the row that gives each ordinary stream; rows that are on come first
        self._told: set[str] = set()  # keys of names that nothing gives: each is told once, where it stands first
        self._read = {key(cell.text) for row in behaviour.rows if row.on for cell in row.inputs}
        pairs = list(zip(behaviour.rows, connectors, strict=True))
        self._unclear = {key(row.output.text) for row, c in pairs if row.on and c is None}  # actuators or streams
        self._driven_names = {key(row.output.text) for row, c in pairs if row.on and c is not None and c.is_sink}
        for on in (True, False):
            for row, connector in pairs:
                if row.on is on and row.output and not (connector and connector.is_sink):
                    self.rows.setdefault(key(row.output.text), row)

    def output_id(self, row: Row) -> str:
        """Return the id of a row's output, even of a faulty row, so that the rows after it can still be drawn."""
        if row.output:
            return self._ordinary(row.output, f"{self.sheet}!{key(row.output.text)}")
        return self._anonymous(row)

    def _anonymous(self, row: Row) -> str:
        stream_id = f"{self.sheet}!#{row.number}"
        self.streams.setdefault(stream_id, Stream(stream_id, "", StreamKind.ANONYMOUS, row.output.address))
        return stream_id

    def input(self, cell: Cell, row: Row) -> str | None:
        """Return the stream id of an input name, or None when it is refused."""
        k = key(cell.text)
        if k in self.rows:
            return self._ordinary(self.rows[k].output, f"{self.sheet}!{k}")
        done = self.devices.done(cell.text)
        if done is not None:
            return self._done(cell, *done)
        if self._of_another_sheet(cell, row):
            return None
        declared = self.devices.find(cell.text)
        if declared is None:
            if row.on and k not in self._told and k not in self.devices.broken and not self._done_of_missing(k):
                self._told.add(k)
                details = self._propose(cell.text, row)
                self.report.add("GRAPH001", cell.address, name=cell.text, **details)
            return None
        if declared.found.type.kind == "actuator":
            if row.on:
                self.report.add("GRAPH009", cell.address, name=cell.text)
            return None
        return self._device(declared, cell, row)

    def _propose(self, text: str, row: Row) -> dict[str, Any]:
        parts = [part.strip() for part in _AND.split(text)]
        known = (key(part) in self.rows or self.devices.find(part) is not None for part in parts)
        if any(sign in text for sign in ";&+") or (len(parts) > 1 and all(known)):
            return {"remedy": N_("Write a comma between two streams.")}
        of = self.devices.find(done_of(text)) if done_of(text) else None
        if of is not None:
            named, kind = done_of(text), describe(of.found.type)
            remedy = N_("Only actuators have a done stream; {done_of} is {describe}.", done_of=named, describe=kind)
            return {"remedy": remedy}
        ended = self._meant_done(text)
        guess = ended or self.devices.propose(text, self._inputs)
        unused_output = any(k not in self._read and other is not row for k, other in self.rows.items())
        if not (ended or unused_output) and (found := self.devices.device_remedy(text, guess, "sensor")):
            return found  # else that output may have been called so
        unused = self.rows.get(key(guess)) if guess else None
        if guess is None or unused is None or key(guess) in self._read:
            return meant(guess, N_("Write the output stream of another row, or a sensor."))
        remedy = N_("Did you mean {guess}? Or write “{text}” into {cell}, which nothing uses yet.",
                        guess=guess, text=text, cell=unused.output.address.cell)  # fmt: skip
        return {"remedy": remedy, "guess": guess}

    def _meant_done(self, text: str) -> str | None:
        """Return the done stream meant by `Say finished` or by what an actuator says (`Good bye done`), or None."""
        bare = _ENDED.sub("", text) if len(text) <= _LONGEST_ENDED else text
        if bare == text:
            return None
        bare = _IS.sub("", bare)
        named = self.devices.find(bare)
        if named is not None and named.found.type.kind == "actuator":
            return f"{named.name if named.address else named.found.name} done"
        mine = (d for d in self.devices.declared.values() if d.found.type.kind == "actuator")
        said = _letters(bare)
        saying = [d.name for d in mine if any(_letters(v) == said for v in d.settings.values() if isinstance(v, str))]
        return f"{saying[0]} done" if len(saying) == 1 else None

    @cached_property
    def _inputs(self) -> list[str]:
        dones = [f"{name} done" for name in self.devices.names("actuator")]
        return [*(r.output.text for r in self.rows.values()), *self.devices.names("sensor"), *dones]

    def _done(self, cell: Cell, name: str, declared: Declared) -> str:
        stream_id, of = key(cell.text), key(name)
        shown = f"{declared.name if declared.address else name} done"
        address = declared.address or cell.address
        self.streams.setdefault(
            stream_id, Stream(stream_id, shown, StreamKind.DONE, address, DONE_DEVICE, declared.settings, done_of=of)
        )
        return stream_id

    def _of_another_sheet(self, cell: Cell, row: Row) -> bool:
        """Return whether a name has the form `Sheet!stream`, which only tests use; report it if the row is on."""
        sheet, mark, stream = cell.text.partition("!")
        if not mark or key(sheet) not in self.sheets:
            return False
        if row.on:
            mine = key(sheet) == self.sheet
            remedy = N_("Write {value}.", value=stream.strip()) if mine else _SHARED
            self.report.add("GRAPH017", cell.address, name=cell.text, remedy=remedy)
        return True

    def _done_of_missing(self, k: str) -> bool:
        """Return whether a name is the done stream of a missing actuator, which is reported at its own cell."""
        name = k.removesuffix("done")
        return name != k and (name in self.devices.broken | self._driven_names | self._unclear)

    def output(self, row: Row, connector: Connector, read_below: bool) -> str | None:
        """Return the stream id of a row's output, or None when it is refused."""
        cell = row.output
        if connector.is_sink:
            return self._actuator(cell, row)
        if not cell:
            if not read_below:
                if row.on:
                    self.report.add("GRAPH004", cell.address)
                return None
            return self._anonymous(row)
        k = key(cell.text)
        if self.devices.done(cell.text) is not None:
            if row.on:
                self.report.add("GRAPH016", cell.address, name=cell.text)
            return None
        if row.on and is_reserved(cell.text):
            self.report.add("GRAPH018", cell.address, name=cell.text)
        declared = self.devices.find(cell.text)
        if self._of_another_sheet(cell, row):
            return None
        if not argument_name(cell.text) or "," in cell.text or "\n" in cell.text:  # inputs could not name it
            self.report.add("GRAPH013", cell.address, name=cell.text)
            return None
        is_actuator = declared is not None and declared.found.type.kind == "actuator"
        if declared is not None and (is_actuator or declared.address is not None):
            if row.on:
                fixes = [self._apart(row)] if is_actuator else []
                self.report.add("GRAPH007" if is_actuator else "GRAPH008", cell.address, fixes=fixes, name=cell.text)
            return None
        first = self.rows[k]
        if first is not row and row.on and first.on:
            name, other = first.output.text, str(first.output.address)
            self.report.add("GRAPH002", cell.address, name=name, first=other, second=str(cell.address))
            return None
        return self._ordinary(first.output, f"{self.sheet}!{k}")

    def _apart(self, row: Row) -> Fix:
        """Return the fix that names a row's output, and sends it to the actuator in a subscribe row below."""
        at, actuator = row.output.address, row.output.text
        name = f"{actuator}に送る値" if LETTERS.search(actuator) else f"Value for {actuator}"
        names = (name, *(f"{name} {n}" for n in range(2, len(self.rows) + 3)))
        free = next(n for n in names if key(n) not in self.rows and self.devices.find(n) is None)
        cells = ((row.inputs_cell, free), (row.connector, "subscribe"), (row.output, actuator))
        below = tuple((c.address.column, text) for c, text in cells)
        title = N_("Name this output “{name}”, and send it to “{actuator}” in a new subscribe row", name=free,
                   actuator=actuator)  # fmt: skip
        return Fix("add-subscribe-row", title, (Put(at, free), Insert(at.sheet, at.row + 1, below)))

    def _actuator(self, cell: Cell, row: Row) -> str | None:
        if not cell:
            if row.on:
                self.report.add("GRAPH005", cell.address)
            return None
        declared = self.devices.find(cell.text)
        if declared is not None and declared.found.type.kind == "actuator":
            return self._device(declared, cell, row)
        if not row.on or key(cell.text) in self.devices.broken | self._told | self._unclear:
            return None
        self._told.add(key(cell.text))
        guess = self.devices.propose(cell.text, self.devices.names("actuator"))
        remedy = N_("Write an actuator, for example Head tracker, or declare “{text}” in the sheet Devices, with its "
                    "device and settings.", text=cell.text)  # fmt: skip
        if guess:
            remedy = N_("Did you mean {guess}? Or declare “{text}” in the sheet Devices, with its device and settings.",
                        guess=guess, text=cell.text)  # fmt: skip
        details = self.devices.device_remedy(cell.text, guess, "actuator") or {"remedy": remedy, "guess": guess}
        if declared is not None:
            what = describe(declared.found.type)
        else:
            what = N_("the stream of another row") if key(cell.text) in self.rows else N_("not a device of the robot")
        self.report.add("GRAPH006", cell.address, name=cell.text, what=what, **details)
        return None

    def _ordinary(self, first: Cell, stream_id: str) -> str:
        self.streams.setdefault(stream_id, Stream(stream_id, first.text, StreamKind.ORDINARY, first.address))
        return stream_id

    def _device(self, declared: Declared, cell: Cell, row: Row) -> str | None:
        setting = self.devices.needs_declaring(declared)
        if setting is not None:
            if row.on:
                name, device = setting.name, declared.found.name
                fixes = setting_fixes(self.devices.workbook, setting, cell.text, device)
                self.report.add("DEV008", cell.address, fixes=fixes, device=device, setting=name, stream=cell.text)
            return None
        stream_id = key(cell.text)
        address = declared.address or cell.address
        kind = _KINDS[declared.found.type.kind]
        name = declared.name if declared.address else cell.text
        self.streams.setdefault(stream_id, Stream(stream_id, name, kind, address, declared.found, declared.settings))
        return stream_id


def _letters(text: str) -> str:
    return "".join(filter(str.isalnum, text)).casefold()
