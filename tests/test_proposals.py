"""Names that are proposed for unknown ones: the same as an exhaustive search finds, and bounded in large workbooks."""

from __future__ import annotations

import difflib

import pytest
from hypothesis import given
from hypothesis import strategies as st
from play import check, rows

from rrp_sheets.diagnostics.report import count_typos
from rrp_sheets.model.names import Proposals, key, nearest

NAMES = st.text("abcd e", max_size=8)


@given(NAMES, st.lists(NAMES, max_size=20))
def test_the_nearest_name_is_that_of_the_exhaustive_search(name, candidates):
    by_key = {key(c): c for c in candidates}
    close = difflib.get_close_matches(key(name), list(by_key), n=1, cutoff=0.6)
    assert nearest(name, candidates) == (by_key[close[0]] if close else None)


@given(NAMES, NAMES, st.integers(0, 6))
def test_slips_up_to_a_bound_are_those_without(first, second, most):
    every = count_typos(first, second)
    bounded = count_typos(first, second, most)
    assert bounded == every if every <= most else bounded > most


def test_proposals_end_when_very_many_names_were_looked_at():
    propose, names = Proposals(most=1_000), [f"Stream {i}" for i in range(300)]
    assert [propose("Streem 7", names) for _ in range(5)] == ["Stream 7"] * 4 + [None]


@pytest.mark.slow
def test_the_first_of_many_unknown_names_get_a_proposal_and_all_are_told():
    lines = [f"| Streem {i} | map | value | Stream {i} |" for i in range(800)]
    errors = check(rows("\n".join(lines))).report.errors
    proposed = ["Did you mean Stream" in d.remedy for d in errors]
    assert len(errors) == 800 and proposed[0] and proposed == sorted(proposed, reverse=True) and not proposed[-1]
