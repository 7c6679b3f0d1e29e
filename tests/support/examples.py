"""The number of examples that property tests try."""

from __future__ import annotations

from hypothesis import settings


def example_count(number: int) -> int:
    """Return a third of a number of examples, which are the same each time; all for `make soak`, which draws new ones."""
    return number if settings.get_current_profile_name() == "drawn" else number // 3
