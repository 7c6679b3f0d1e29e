"""The library of functions, one file per topic. Each function's docstring is its help text and its test.

A third party adds functions through the entry point group `rrp_sheets.functions`: a callable that returns
`[(name, function), …]`, made with :func:`define`.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

from rrp_sheets.formulas.functions.define import Function, define
from rrp_sheets.registry import Registry, load

__all__ = ["Function", "define", "library"]


def _builtin() -> Iterable[tuple[str, Function]]:
    from rrp_sheets.formulas.functions import (
        geometry,
        lists,
        logic,
        maths,
        statistics,
        table_functions,
        text,
        trigonometry,
    )

    for topic in (logic, maths, statistics, trigonometry, text, lists, table_functions, geometry):
        for function in topic.FUNCTIONS:
            for name in function.names:
                yield name, function


@lru_cache(maxsize=1)
def library() -> Registry[Function]:
    """The functions that formulas may call, by name in any spelling."""
    return load("function", "rrp_sheets.functions", _builtin)
