"""Frozen dataclasses from what JSON made of them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from functools import lru_cache
from types import NoneType, UnionType
from typing import Any, TypeVar, cast, get_args, get_origin, get_type_hints

T = TypeVar("T")


def rebuilt(kind: type[T], data: Mapping[str, Any]) -> T:
    """An object of a dataclass whose fields are texts, numbers, tuples, dicts and such dataclasses.

    >>> from rrp_sheets.render.pack.model import Ref
    >>> rebuilt(Ref, {"behaviour": "Greet", "rows": [2, 3]})
    Ref(behaviour='Greet', rows=(2, 3))
    """
    hints = _hints(cast(Any, kind))
    return kind(**{name: _value(hints[name], data[name]) for name in hints})


@lru_cache(maxsize=64)
def _hints(kind: type[Any]) -> dict[str, Any]:
    known = get_type_hints(kind)
    return {f.name: known[f.name] for f in fields(kind)}


def _value(hint: Any, data: Any) -> Any:
    origin, inner = get_origin(hint), get_args(hint)
    if origin is UnionType:
        return None if data is None else _value(next(i for i in inner if i is not NoneType), data)
    if origin is tuple:
        several = inner[0:1] * len(data) if inner[-1] is Ellipsis else inner
        return tuple(_value(i, part) for i, part in zip(several, data, strict=True))
    if origin is dict:
        return {_value(inner[0], k): _value(inner[1], v) for k, v in data.items()}
    if is_dataclass(hint) and isinstance(hint, type):
        return rebuilt(hint, data)
    return hint(data)
