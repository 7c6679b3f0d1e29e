"""LINT008 and LINT009: helpers, and inputs of helpers, that nothing uses."""

from __future__ import annotations

import ast
import re

from rrp_sheets.checks.lints.context import LintContext
from rrp_sheets.formulas import HelperDef
from rrp_sheets.model.names import key


def lint_unused_helpers(context: LintContext) -> None:
    """Report unused helpers, and inputs that a helper does not use."""
    helpers = context.compiled.helpers
    if not helpers.by_key or context.report.errors:
        return  # what is wrong elsewhere may be what would use them
    used: set[str] = set()
    waiting = [f.tree for f in context.compiled.formulas.values()]
    while waiting:
        for node in ast.walk(waiting.pop()):
            helper: HelperDef | None = getattr(node, "helper", None)
            if helper is not None and key(helper.shown) not in used:
                used.add(key(helper.shown))
                waiting += [helper.tree] if helper.tree is not None else []
    words = _words_of_unread_formulas(context)
    for k, helper in helpers.by_key.items():
        name, formula = helpers.cells[k]
        if k not in used and k not in words:
            context.report.add("LINT008", name.address, name=name.text)
        if helper.tree is None:
            continue
        read = {n.id for n in ast.walk(helper.tree) if isinstance(n, ast.Name)}
        for parameter in helper.parameters:
            if parameter.name not in read:
                context.report.add("LINT009", formula.address, name=name.text, input=parameter.shown)


def _words_of_unread_formulas(context: LintContext) -> set[str]:
    """Return the names in formulas that are unreadable or switched off, and in tests: they count as uses."""
    book, formulas = context.workbook, context.compiled.formulas
    texts = [r.formula.text for b in book.behaviours for r in b.rows if f"{b.name}!{r.number}" not in formulas]
    texts += [cell.text for sheet in book.tests for row in sheet.rows for cell in (row.send, row.expect)]
    words = (word for text in texts for word in re.sub(r"[^\w ]", " ", text).split(" "))
    return {key(text) for text in (*texts, *words)}
