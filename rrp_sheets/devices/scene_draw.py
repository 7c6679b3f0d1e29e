"""A scene of one run: its ranges drawn, by the run's seed."""

from __future__ import annotations

import random
from collections.abc import Sequence
from dataclasses import dataclass, replace

from rrp_sheets.model.scene import Range, SceneAction
from rrp_sheets.model.values import Value


@dataclass(frozen=True)
class Drawn:
    """What a run has drawn.

    Attributes:
        row: of the Scene sheet.
        text: what it drew, in words.
    """

    row: int
    text: str


def draw_scene(actions: Sequence[SceneAction], seed: int) -> tuple[tuple[SceneAction, ...], tuple[Drawn, ...]]:
    """The actions with a number for each range, and what was drawn. The same seed draws the same numbers.

    Each number depends on the seed and its own cell alone: a row more or less changes no other.

    >>> action = SceneAction(0, "Red ball", "appear", {"at": (Range(0.8, 1.2), 0.0, 0.4)}, row=4)
    >>> (one,), (told,) = draw_scene([action], 7)
    >>> 0.8 <= one.values["at"][0] <= 1.2, told.row, draw_scene([action], 7)[0][0] == one
    (True, 4, True)
    """
    found, told = [], []
    for one in actions:
        action, drawer = one, _Drawer(seed, one.row)
        values = {name: drawer.value(name, value) for name, value in action.values.items()}
        time_us = action.time_us
        if action.span_us:
            time_us = round(1e6 * drawer.number("time", Range(time_us / 1e6, (time_us + action.span_us) / 1e6)))
        if drawer.told:
            told.append(Drawn(action.row, f"Drawn by the run: {', '.join(drawer.told)}."))
            action = replace(action, time_us=time_us, span_us=0, values=values)
        found.append(action)
    return tuple(found), tuple(told)


class _Drawer:
    def __init__(self, seed: int, row: int) -> None:
        self._name = f"{seed}\nScene!{row}"
        self.told: list[str] = []

    def value(self, name: str, value: Value) -> Value:
        if isinstance(value, tuple):
            return tuple(self.value(name if i == 0 else f"{name} {i + 1}", part) for i, part in enumerate(value))
        return self.number(name, value) if isinstance(value, Range) else value

    def number(self, name: str, among: Range) -> float:
        # seeded with a text, Python hashes it the same way everywhere; only random() stays the same for ever
        chance = random.Random(f"{self._name}\n{name}").random()
        number = among.low + chance * (among.high - among.low)
        number = min(max(round(number, 3), among.low), among.high)
        self.told.append(f"{name} {number:g} of {among}")
        return number
