"""Rules for the tests themselves: values of a page are waited for, and docstrings say what something is."""

from __future__ import annotations

import ast
import functools
import re
from collections.abc import Iterator
from pathlib import Path

import pytest
from house import QUESTION

HERE = Path(__file__).parent
READS = frozenset((
    "get_attribute", "inner_text", "text_content", "input_value", "inner_html", "is_visible", "is_hidden", "is_enabled",
    "is_disabled", "is_checked", "is_editable", "all_inner_texts", "all_text_contents", "evaluate", "evaluate_all",
    "bounding_box", "eval_on_selector", "eval_on_selector_all", "query_selector", "query_selector_all",
))  # fmt: skip
"""What Playwright's pages and locators say at once; `count()` besides, without arguments."""
SHOWN = frozenset(("here", "spoken"))  # of `GridPage` and `Shared`, which read the page too
POLLS = frozenset(("becomes", "eventually", "some", "until"))  # of chromium.py
SAFE = "# read once: "
"""Marks a place that is safe all the same, with the reason behind it."""


def is_read(node: ast.AST) -> bool:
    """True when an expression reads what a page shows now."""
    if isinstance(node, ast.Attribute):
        return node.attr in SHOWN and isinstance(node.ctx, ast.Load)
    if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
        return False
    name, plain = node.func.attr, not node.args and not node.keywords
    return name in READS or (name == "count" and plain) or (name == "text" and _names_a_cell(node))


def _names_a_cell(call: ast.Call) -> bool:
    """True for `grid.text("D2")`, not for a text of a response or a sheet."""
    wanted = call.args[0] if len(call.args) == 1 else None
    if isinstance(wanted, ast.JoinedStr):
        return True
    return isinstance(wanted, ast.Constant) and re.fullmatch(r"[A-Z]+\d+", str(wanted.value)) is not None


def reads(node: ast.AST) -> Iterator[ast.AST]:
    """The reads in an expression; what stands in a lambda is called by what waits."""
    if isinstance(node, ast.Lambda):
        return
    if is_read(node):
        yield node
        return
    for child in ast.iter_child_nodes(node):
        yield from reads(child)


def asserted(tree: ast.AST) -> Iterator[ast.expr]:
    """Expressions that are asserted, or waited for."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Assert):
            yield node.test
        elif isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id in POLLS - {"some"}:
            yield node


def compared(source: str) -> list[int]:
    """The lines in which something is asserted of what a page shows at that moment.

    A name that was given such a value in the same function counts as the value.
    """
    tree, lines = ast.parse(source), source.split("\n")
    found = set()
    for function in (n for n in ast.walk(tree) if isinstance(n, (ast.FunctionDef, ast.AsyncFunctionDef))):
        read_once: dict[str, int] = {}
        for node in ast.walk(function):
            if isinstance(node, ast.Assign) and any(reads(node.value)):
                for name in (n for target in node.targets for n in ast.walk(target) if isinstance(n, ast.Name)):
                    read_once[name.id] = node.lineno
        for test in asserted(function):
            found.update(getattr(read, "lineno", test.lineno) for read in reads(test))
            named = {n.id for n in ast.walk(test) if isinstance(n, ast.Name)}
            found.update(line for name, line in read_once.items() if name in named)
    return sorted(n for n in found if SAFE not in lines[n - 1] and SAFE not in lines[max(n - 2, 0)])


def test_what_a_page_shows_is_waited_for() -> None:
    """Use expect(), or becomes() and eventually() of chromium.py."""
    paths = [*HERE.glob("*.py"), *HERE.glob("support/*.py")]
    found = {path.name: compared(path.read_text(encoding="utf-8")) for path in paths}
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.parametrize(
    "line",
    [
        "assert page.locator('#x').get_attribute('data-v') == 'a'",
        "assert page.inner_text('#x') == 'a'",
        "assert page.locator('#x').count() == 0 and True",
        "assert grid.text('D2') == 'x'",
        "assert grid.here == 'D2'",
        "assert [c.is_visible() for c in page.locator('td').all()] == [True]",
        "was = grid.cell('D3').get_attribute('data-v'); grid.type('x'); assert grid.rows() == [was]",
        "a, b = page.evaluate('1'), 2\n    assert a == b",
    ],
)
def test_what_is_read_once_is_found(line: str) -> None:
    assert compared(f"def test_x(page, grid):\n    {line}\n")


@pytest.mark.parametrize(
    "line",
    [
        "expect(page.locator('#x')).to_have_text('a')",
        "becomes(lambda: page.inner_text('#x'), 'a')",
        "eventually(lambda: page.locator('#x').count() == 0)",
        "until(page, lambda: grid.here == 'D2')",
        "assert 'abc'.count('a') == 1 and answer.text() == ''",
        "width = page.evaluate('innerWidth'); page.mouse.move(width, 1)",
        "assert page.evaluate('1 + 1') == 2  # read once: it is no state of the page",
    ],
)
def test_what_is_waited_for_is_not_found(line: str) -> None:
    assert compared(f"def test_x(page, grid):\n    {line}\n") == []


@functools.cache
def parts() -> dict[Path, list[ast.AST]]:
    """The parts of each file of the tests."""
    return {path: list(ast.walk(ast.parse(path.read_text(encoding="utf-8")))) for path in sorted(HERE.rglob("*.py"))}


def test_docstrings_of_tests_do_not_begin_as_questions() -> None:
    described = [
        (path.name, ast.get_docstring(node) or "")
        for path, nodes in parts().items()
        for node in nodes
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef)
    ]
    assert len(described) > 1_000
    assert [place for place in described if QUESTION.match(place[1])] == []


def test_pages_wait_for_functions_and_not_for_expressions() -> None:
    """An expression is evaluated anew each time, which our pages forbid, so it fails unless it holds at once."""
    found = [
        (path.name, node.lineno)
        for path, nodes in parts().items()
        for node in nodes
        if isinstance(node, ast.Call) and getattr(node.func, "attr", "") == "wait_for_function"
        and isinstance(node.args[0], ast.Constant | ast.JoinedStr) and "=>" not in ast.unparse(node.args[0])
    ]  # fmt: skip
    assert found == []
