"""Half a million formulas by chance (`make soak`); RRP_FORMULAS gives another count, RRP_SEED another beginning."""

from __future__ import annotations

import os
import resource
import time
from collections import Counter

import pytest
from formula_makers import Maker, inputs, scope

from rrp_sheets.formulas import FormulaProblem, Picker, compile_formula
from rrp_sheets.formulas.evaluator import GuardedInterpreter
from rrp_sheets.model.values import Failure, Record

pytestmark = pytest.mark.soak


def test_half_a_million_formulas():
    count, seed = int(os.environ.get("RRP_FORMULAS", "500000")), int(os.environ.get("RRP_SEED", "7"))
    maker, in_scope, interpreter, values = Maker(seed), scope(), GuardedInterpreter(), inputs()
    before = repr(values)
    counts: Counter[str] = Counter()
    slowest = (0.0, "")
    for i in range(count):
        text = maker.formula()
        began = time.process_time()
        try:
            formula = compile_formula(text, in_scope)
        except FormulaProblem as problem:
            assert problem.message and problem.remedy and -1 <= problem.column <= len(text), text
            counts["rejected " + problem.code] += 1
        else:
            result = formula.prepare(interpreter, Picker(seed, "A!1"))(*values.values())
            assert type(result) in (int, float, bool, str, type(None), list, tuple, Record, Failure), text
            code = result.code if isinstance(result, Failure) else ""
            assert code != "FORM109", text
            counts["error " + code if code else "ok"] += 1
        slowest = max(slowest, (time.process_time() - began, text))
        if not i % 1000:
            assert repr(values) == before, text
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    print(
        f"\n{count} formulas, seed {seed}: slowest {slowest[0] * 1000:.0f} ms ({slowest[1][:90]!r}), peak {peak:.0f} MB"
    )
    print(", ".join(f"{name} {n}" for name, n in counts.most_common()))
    assert repr(values) == before
    assert counts["ok"] > count / 50 and slowest[0] < 1 and peak < 500
