"""merge: every value of every input."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Parameter, batch_per_instant, by_input
from rrp_sheets.model.values import Value

if TYPE_CHECKING:
    from reactivex import Observable


def build(wiring: ConnectorContext) -> Observable[Value]:
    """Return an observable of every value of every input; those of one instant in the order of the inputs."""

    def flush(batch: list[tuple[int, Value]], emit: Callable[[Value], None]) -> None:
        for _, value in by_input(batch):
            emit(value)

    return batch_per_instant(wiring, flush)


MERGE = Connector(
    name="merge",
    min_inputs=2,
    max_inputs=None,
    parameter=Parameter.NONE,
    icon=('<path d="M1 2.2h2L6.6 6H11M1 9.8h2L6.6 6M8.9 3.9 11 6 8.9 8.1"/>'),
    help="All values of all its inputs, one after the other.",
    sentence="Whenever any of {inputs_or} comes, it goes on.",
    build=build,
    any_input=True,
    example=("1---2---", "--a---b-"),
)
