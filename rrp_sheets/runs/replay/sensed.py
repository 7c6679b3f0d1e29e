"""Values from a trace, as the robot gave them: records with the fields of their device, as the rows know them."""

from __future__ import annotations

from typing import Any

from rrp_sheets.engine.plan import Plan
from rrp_sheets.model.exchange import DONE, commanded
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record, RecordType, Value, record_from_mapping, to_json
from rrp_sheets.runs.replay.record import same_json


class Senses:
    """Makes values of streams from their JSON.

    What was commanded comes back in the end of the command: a list or a record of a formula's, which JSON does not
    tell apart. So commands are remembered as they are made, and the end has the very value.

    Args:
        plan: of the workbook that is played.
    """

    def __init__(self, plan: Plan) -> None:
        self._records: dict[str, RecordType] = {
            s.id: s.device.type.payload for s in plan.streams if s.device and s.device.type.payload
        }
        self._of = plan.dones
        self._given: dict[tuple[str, str], Value] = {}

    def command(self, stream: str, value: Value) -> None:
        """A row has made a command."""
        if isinstance(value, (list, tuple, Record)):
            told = commanded(value)
            self._given[stream, same_json(to_json(told))] = told

    def value(self, stream: str, value: Any) -> Value:
        """The value that a sensor stream, or one of ended commands, had."""
        kind = DONE if stream in self._of else self._records.get(stream)
        if kind is None or not isinstance(value, dict):
            return _plain(value)
        fields = {key(n): _plain(v) for n, v in value.items()}
        if kind is DONE and isinstance(value.get("value"), (list, dict)):
            given = self._given.get((self._of[stream], same_json(value["value"])))
            fields["value"] = fields["value"] if given is None else given
        if set(fields) - {key(f.name) for f in kind.fields}:  # of another version of the catalogue
            return record_from_mapping(kind.name, {n: fields[key(n)] for n in value})
        return kind.make(**fields)


def _plain(value: Any) -> Value:
    if isinstance(value, dict):
        return record_from_mapping("Record", {str(n): _plain(v) for n, v in value.items()})
    if isinstance(value, list):
        return [_plain(v) for v in value]
    return value
