"""One registry for what can be added from outside: connectors and functions.

The built-in ones are registered exactly as third parties' are: through a function that a distribution names as
an entry point and that returns the things to register. Nothing is loaded at import.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from importlib.metadata import entry_points
from typing import Generic, TypeVar

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.texts import N_

T = TypeVar("T")


class Registry(Generic[T]):
    """Things by name. Names with the same key are the same name, and a second one is refused.

    >>> r = Registry("fruit"); r.add("Red apple", 1); r.get("red_apple")
    1
    """

    def __init__(self, kind: str) -> None:
        self.kind = kind
        self._things: dict[str, tuple[str, T]] = {}

    def add(self, name: str, thing: T) -> None:
        """Register `thing`; raises SheetsError when another thing has that name."""
        other = self._things.get(key(name))
        if other is not None:
            raise SheetsError(
                N_("There are two {kind}s named {name}.", kind=self.kind, name=name),
                N_("Uninstall or rename one of them."),
            )
        self._things[key(name)] = (name, thing)

    def get(self, name: str) -> T | None:
        """The thing of that name in any spelling, or None."""
        entry = self._things.get(key(name))
        return entry[1] if entry else None

    def names(self) -> list[str]:
        """The names as they were registered, in that order."""
        return [name for name, _ in self._things.values()]

    def __iter__(self) -> Iterator[T]:
        return iter([thing for _, thing in self._things.values()])


def load(kind: str, group: str, builtin: Callable[[], Iterable[tuple[str, T]]]) -> Registry[T]:
    """A registry filled with the built-in things and then with those of the entry points of `group`."""
    registry: Registry[T] = Registry(kind)
    providers = [builtin, *(point.load() for point in entry_points(group=group))]
    for provider in providers:
        for name, thing in provider():
            registry.add(name, thing)
    return registry
