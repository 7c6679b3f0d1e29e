"""What a word of the Scene sheet is made of: kinds of things, what they do, and the parts of their Value cell."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from types import MappingProxyType

FARTHEST = 20.0  # m; farther is surely a typing mistake


@dataclass(frozen=True)
class Part:
    """A part of a Value cell: a word and what follows it.

    Attributes:
        word: before it; `also` are further ones. The first part of a verb may come without its word.
        name: of what it says, in the action's values.
        kind: how it is read: `place`, `length`, `lengths`, `seconds`, `share`, `angle`, `text`, `rest`, `whole`,
            `flag`, `choice`, `file`, `zone`.
        least, most: limits of a number, or how many numbers a place or a size has.
        choices: of `choice` and `flag`: the words, and what each means.
        default: when the cell does not say it; None: then it is left out.
        needed: whether the cell must say it.
        help: for people.
    """

    word: str
    name: str
    kind: str
    least: float = 0.0
    most: float = FARTHEST
    also: tuple[str, ...] = ()
    choices: Mapping[str, object] = field(default_factory=lambda: MappingProxyType({}))
    default: object = None
    needed: bool = False
    help: str = ""


@dataclass(frozen=True)
class Verb:
    """Something that a kind of thing can do.

    Attributes:
        name: as people write it; `also` are further ways.
        action: what it is to the simulator.
        parts: of the Value cell; the first may come without its word.
        examples: of the Value cell, each with a line of help; the first is the one in messages.
        help: in a line.
    """

    name: str
    action: str
    parts: tuple[Part, ...] = ()
    examples: tuple[tuple[str, str], ...] = (("", ""),)
    also: tuple[str, ...] = ()

    @property
    def example(self) -> str:
        """A Value cell as one would write it; empty where nothing is needed."""
        return self.examples[0][0]


@dataclass(frozen=True)
class Kind:
    """A kind of thing.

    Attributes:
        name: `ball`, `person`, …
        title: as help calls it.
        named: how a thing of this kind may be called, in words.
        things: names that drop-downs offer; the first is the one in examples.
        coloured: whether a colour may stand before the name.
    """

    name: str
    title: str
    things: tuple[str, ...]
    verbs: tuple[Verb, ...]
    coloured: bool = False
    help: str = ""
