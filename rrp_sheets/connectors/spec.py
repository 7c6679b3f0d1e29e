"""The description of a connector for checks, drawings, help and engines."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from enum import Enum
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from reactivex import Observable

    from rrp_sheets.connectors.wiring import ConnectorContext


class Parameter(Enum):
    """Content of a connector's Formula cell."""

    FORMULA = "formula"  # required
    OPTIONAL_FORMULA = "optional formula"
    PERIOD = "period"
    NONE = "none"


@dataclass(frozen=True)
class Connector:
    """Description of one kind of row for the checks, the engine and the help.

    Attributes:
        name: as shown, such as `combineLatest`; any spelling with the same key is accepted, and `synonyms` too.
        min_inputs: the least number of input streams.
        max_inputs: the most, or None for any number.
        parameter: what the Formula cell holds.
        icon: SVG elements in a 12 × 12 box, stroke only; `class="f"` marks what is filled.
        help: one or two sentences for users.
        sentence: a template for the plain-language description, with `{input}`, `{inputs}`, `{formula}`, `{period}`,
            `{output}`.
        sentences: the same in other languages, by their codes; the program's own connectors have theirs in its texts.
        build: wires the connector: from a :class:`ConnectorContext` to the observable of its output.
        is_sink: True for `subscribe`, the only connector with a side effect.
        any_input: True when one fed input is enough to be of use (`merge`); switched-off inputs are then silent.
        first_input: True when it is enough that the first input is fed (`timeout`); the others may be silent.
        extra: names that its formula sees before the inputs (accumulate: `total`, `value`).
        example: input rows of marbles (`1-2--3`) and the parameter, run to make the help's marble picture.
    """

    name: str
    min_inputs: int
    max_inputs: int | None
    parameter: Parameter
    icon: str
    help: str
    sentence: str
    build: Callable[[ConnectorContext], Observable[object]]
    synonyms: tuple[str, ...] = ()
    advanced: bool = False
    is_sink: bool = False
    any_input: bool = False
    first_input: bool = False
    extra: tuple[str, ...] = ()
    example: Sequence[str] = ()
    sentences: Mapping[str, str] = field(default_factory=dict, compare=False)
