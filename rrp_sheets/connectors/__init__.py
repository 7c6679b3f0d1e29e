"""The connectors by name; each is defined in a module of its own.

A third party adds one through the entry point group `rrp_sheets.connectors`: a callable that returns
`[(name, Connector), …]`.

The program's own load reactivex when they are built, not before: a workbook is checked and drawn without it.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from rrp_sheets.connectors.spec import Connector, Parameter
from rrp_sheets.registry import Registry, load

__all__ = ["Connector", "Parameter", "connectors"]


def _builtin() -> Iterable[tuple[str, Connector]]:
    from rrp_sheets.connectors.accumulate import ACCUMULATE
    from rrp_sheets.connectors.changes import CHANGES
    from rrp_sheets.connectors.combine_latest import COMBINE_LATEST
    from rrp_sheets.connectors.delay import DELAY
    from rrp_sheets.connectors.filter import FILTER
    from rrp_sheets.connectors.forget_after import FORGET_AFTER
    from rrp_sheets.connectors.map import MAP
    from rrp_sheets.connectors.merge import MERGE
    from rrp_sheets.connectors.once import ONCE
    from rrp_sheets.connectors.sample import SAMPLE
    from rrp_sheets.connectors.subscribe import SUBSCRIBE
    from rrp_sheets.connectors.throttle import THROTTLE
    from rrp_sheets.connectors.timeout import TIMEOUT
    from rrp_sheets.connectors.timestamp import TIMESTAMP

    everyday = (MAP, FILTER, TIMESTAMP, SAMPLE, COMBINE_LATEST, MERGE, SUBSCRIBE, FORGET_AFTER)
    advanced = (ACCUMULATE, ONCE, TIMEOUT, CHANGES, THROTTLE, DELAY)
    for connector in (*everyday, *advanced):
        for name in (connector.name, *connector.synonyms):
            yield name, connector


@lru_cache(maxsize=1)
def connectors() -> Registry[Connector]:
    """Return the connectors by name, in any spelling."""
    return load("connector", "rrp_sheets.connectors", _builtin)
