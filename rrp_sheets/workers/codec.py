"""Codec of dataclasses, errors and stream values for messages between processes, by their type hints.

An object is a list of its class's name and its fields. Values of streams keep their types: records, tuples, lists and
mappings stay distinct.

>>> from rrp_sheets.model.workbook import Address
>>> pack(Address("Greet", 4, 2)), unpack(Address, ["Address", "Greet", 4, 2])
(['Address', 'Greet', 4, 2], Address(sheet='Greet', row=4, column=2))
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from functools import cache
from pathlib import Path
from types import NoneType, UnionType
from typing import Any, NamedTuple, TypeVar, Union, cast, get_args, get_origin, get_type_hints

from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.diagnostics.report import UnreadableWorkbook
from rrp_sheets.errors import MissingPart, RunBroken, SheetsError, UnreadableFile
from rrp_sheets.model.values import Record, Value, record_from_mapping
from rrp_sheets.texts import LazyMessage, message_from, plural

T = TypeVar("T")
Change = Callable[[Any], Any] | None
_ERRORS = {error.__name__: error for error in (SheetsError, MissingPart, RunBroken, UnreadableFile)}
_AS_JSON = frozenset((None, NoneType, bool, int, float, list, dict, bytearray))


class _Codec(NamedTuple):
    """Changes that pack and unpack what a type hint describes; None where JSON has it as it is."""

    pack: Change = None
    unpack: Change = None


def pack(value: Any, hint: Any = None) -> Any:
    """Return an object as JSON; without a hint it is a dataclass object, an error, or JSON already."""
    if hint is None and not (is_dataclass(value) or isinstance(value, SheetsError | str)):
        return value
    change = _codec(cast(Any, hint or type(value))).pack
    return change(value) if change else value


def unpack(hint: type[T], packed: Any) -> T:
    """Return the object that was packed by its class or another hint. Raises ValueError when it is something else."""
    change = _codec(cast(Any, hint)).unpack
    return cast(T, change(packed) if change else packed)


@cache
def _codec(hint: Any) -> _Codec:
    origin, inner = get_origin(hint), get_args(hint)
    if origin in (Union, UnionType):
        return _union(inner)
    if origin is tuple:
        return _tuple(inner)
    if origin in (Sequence, list):
        return _several(_codec(inner[0]), tuple if origin is Sequence else list)
    if isinstance(origin, type) and issubclass(origin, Mapping):
        return _mapping(*inner)
    if hint is Any:
        return _Codec(_pack_value, _unpack_value)
    return _class(hint)


def _class(hint: Any) -> _Codec:
    if hint in _AS_JSON:
        return _Codec()
    if not isinstance(hint, type):
        raise TypeError(f"there is no codec for {hint}")
    if is_dataclass(hint):
        return _object(hint)
    if issubclass(hint, SheetsError):
        return _Codec(_pack_error, _unpack_error)
    if issubclass(hint, Enum):
        return _Codec(lambda value: value.value, hint)
    if issubclass(hint, Path):
        return _Codec(str, Path)
    if issubclass(hint, str):
        return _Codec(_pack_text, _unpack_text)
    if hint is bytes:
        return _Codec(None, bytes)
    raise TypeError(f"there is no codec for {hint.__name__}")


def _object(kind: type[Any]) -> _Codec:
    """Return the codec of a dataclass, whose fields are looked at later, since it may hold itself."""
    name = kind.__name__

    @cache
    def parts() -> list[tuple[str, Change, Change]]:
        hints = get_type_hints(kind)
        return [(f.name, *_codec(hints[f.name])) for f in fields(kind) if f.init]

    def packed(value: Any) -> list[Any]:
        return [name, *[change(getattr(value, n)) if change else getattr(value, n) for n, change, _ in parts()]]

    def unpacked(data: Any) -> Any:
        if data[0] != name:
            raise ValueError(f"{data[0]} is no {name}")
        each = zip(parts(), data[1:], strict=True)
        return kind(*[change(part) if change else part for (_, _, change), part in each])

    return _Codec(packed, unpacked)


def _union(inner: Sequence[Any]) -> _Codec:
    """Return the codec of one of several: of dataclasses, of None and something else, or of plain JSON."""
    kinds = {kind.__name__: _codec(kind) for kind in inner if isinstance(kind, type) and is_dataclass(kind)}
    if len(kinds) > 1:
        return _Codec(
            lambda value: value if value is None else _changed(kinds[type(value).__name__].pack, value),
            lambda data: data if data is None else _changed(kinds[data[0]].unpack, data),
        )
    others = [_codec(kind) for kind in inner if kind is not NoneType]
    if len(others) > 1:
        if not _AS_JSON.issuperset(hint for hint in inner if hint not in (str, bytes)):
            raise TypeError(f"there is no codec for one of {inner}")
        return _Codec(_pack_text, _unpack_text) if str in inner else _Codec()
    pack, unpack = others[0]
    return _Codec(
        pack and (lambda value: None if value is None else pack(value)),
        unpack and (lambda data: None if data is None else unpack(data)),
    )


def _changed(change: Change, value: Any) -> Any:
    return change(value) if change else value


def _tuple(inner: Sequence[Any]) -> _Codec:
    if inner[-1] is Ellipsis:
        return _several(_codec(inner[0]), tuple)
    codecs = [_codec(hint) for hint in inner]
    return _Codec(
        lambda value: [_changed(c.pack, part) for c, part in zip(codecs, value, strict=True)],
        lambda data: tuple(_changed(c.unpack, part) for c, part in zip(codecs, data, strict=True)),
    )


def _several(codec: _Codec, kind: Callable[[Any], Any]) -> _Codec:
    pack, unpack = codec
    return _Codec(
        pack and (lambda value: [pack(part) for part in value]),
        (lambda data: kind([unpack(part) for part in data])) if unpack else kind,
    )


def _mapping(keys: Any, values: Any) -> _Codec:
    named = int if keys is int else None  # JSON has texts only as keys
    pack, unpack = _codec(values)
    if named is None and unpack is None and pack is None:
        return _Codec()
    return _Codec(
        (lambda value: {k: pack(v) for k, v in value.items()}) if pack else None,
        lambda data: {_changed(named, k): _changed(unpack, v) for k, v in data.items()},
    )


# ---- values, texts and errors
def _pack_value(value: Value) -> Any:
    if value is None or isinstance(value, (str, int, float)):
        return value
    if isinstance(value, Record):
        return {"record": value.type.name, "fields": {n: _pack_value(v) for n, v in value.as_dict().items()}}
    if isinstance(value, tuple):
        return {"tuple": [_pack_value(v) for v in value]}
    if isinstance(value, list):
        return [_pack_value(v) for v in value]
    if isinstance(value, Mapping):
        return {"mapping": {k: _pack_value(v) for k, v in value.items()}}
    return value  # the transport knows what to do with it


def _unpack_value(packed: Any) -> Value:
    if isinstance(packed, list):
        return [_unpack_value(v) for v in packed]
    if isinstance(packed, dict):
        if "mapping" in packed:
            return {k: _unpack_value(v) for k, v in packed["mapping"].items()}
        if "tuple" in packed:
            return tuple(_unpack_value(v) for v in packed["tuple"])
        return record_from_mapping(packed["record"], {n: _unpack_value(v) for n, v in packed["fields"].items()})
    return packed


def _pack_text(text: object) -> Any:
    """Pack a text; a message of the program keeps its template, so that it can still be translated."""
    if type(text) is str:
        return text
    if isinstance(text, LazyMessage):
        places = {name: _pack_text(value) for name, value in text.places.items()}
        packed = {"said": text.template, "places": places, "context": text.context}
        return packed if text.forms is None else {**packed, "forms": text.forms}
    return text if isinstance(text, str | int | float | None) else str(text)


def _unpack_text(packed: Any) -> Any:
    if isinstance(packed, dict):
        places = {name: _unpack_text(value) for name, value in packed["places"].items()}
        message = message_from(packed["said"], packed["context"], places)
        forms = packed.get("forms")
        if not isinstance(forms, list) or len(forms) != 2 or type(places.get("n")) is not int:
            return message
        known = all(isinstance(message_from(form, "", places), LazyMessage) for form in forms)
        return plural(*forms, **message.places) if known and isinstance(message, LazyMessage) else message
    return packed


def _pack_error(error: SheetsError) -> list[Any]:
    """Pack an error that a user may see, one with a finding as that; of an unknown kind, as a plain one."""
    if isinstance(error, UnreadableWorkbook):
        return ["UnreadableWorkbook", pack(error.finding)]
    words = [_pack_text(error.message), _pack_text(error.remedy)]
    if isinstance(error, UnreadableFile):
        return ["UnreadableFile", error.code, *words]
    return [type(error).__name__, *words]


def _unpack_error(packed: list[Any]) -> SheetsError:
    kind, *words = packed
    if kind == "UnreadableWorkbook":
        return UnreadableWorkbook(unpack(Diagnostic, words[0]))
    words = [_unpack_text(text) for text in words]
    return _ERRORS.get(kind, SheetsError)(*words)
