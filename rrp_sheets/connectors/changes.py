"""changes: drops a value that is equal to the one before."""

from __future__ import annotations

from rrp_sheets.connectors.spec import Connector, ConnectorContext, Passing, ValueStream
from rrp_sheets.model.values import identity


def build(wiring: ConnectorContext) -> ValueStream:
    """Return an observable of the values that differ from the one before them."""
    from reactivex import operators as ops

    return wiring.inputs[0].pipe(ops.distinct_until_changed(identity))


CHANGES = Connector(
    name="changes",
    icon=(
        '<path d="M.8 9h3.4V3h3.4v6H11"/>'
        '<circle cx="4.2" cy="3" r="1" class="f"/><circle cx="7.6" cy="9" r="1" class="f"/>'
    ),
    words=("distinctuntilchange", "change", "different", "変化", "変わる"),
    help="Passes a value on only when it differs from the one before.",
    sentence="Each {one} that differs from the one before becomes {output}.",
    variants={"next": "Each {one} that differs from the one before is passed on to {rows}."},
    legend="only what differs",
    build=build,
    synonyms=("distinctUntilChanged",),
    advanced=True,
    passes=Passing("changes"),
    example=("1-1-2-2-1",),
)
