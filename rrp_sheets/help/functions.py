"""`help functions`: the library by topic; `help CLAMP`: one function, its examples as users type them."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator

from rrp_sheets.formulas.functions import Function, library
from rrp_sheets.help.layout import FOR_EXAMPLE, Block, columns, heading, lines, paragraph, titled
from rrp_sheets.model.names import argument_name
from rrp_sheets.model.workbook import Helper
from rrp_sheets.texts import N_, LazyMessage, listed

_TOPICS = {
    "logic": N_("Logic"), "maths": N_("Maths"), "statistics": N_("Statistics"),
    "trigonometry": N_("Angles (in radians)"), "geometry": N_("Distances and ranges"), "text": N_("Text"),
    "lists": N_("Lists"), "table_functions": N_("Tables"),
}  # fmt: skip
_LAZY = {  # functions of the grammar have no Python function, and so no doctest
    "IF": 'IF(3 > 2; "far"; "near")', "AND": "AND(TRUE; 3 > 2)", "OR": "OR(FALSE; 3 > 2)", "NOT": "NOT(TRUE)",
    "IFERROR": 'IFERROR(1 / 0; "no answer")',
}  # fmt: skip


def all_functions() -> Iterator[Block]:
    """Yield every function with its usage and its first sentence, by topic."""
    yield paragraph(N_("The functions that formulas can use. Separate the values in brackets by semicolons or commas; "
                       "capitals make no difference. For one with examples: `rrp-sheets help CLAMP`."))  # fmt: skip
    by_topic: dict[str, dict[str, Function]] = {topic: {} for topic in _TOPICS}
    for function in library():
        module = function.call.__module__.rpartition(".")[2]
        by_topic.setdefault(module, {})[function.name] = function
    for topic, functions in by_topic.items():
        if functions:
            yield heading(_TOPICS.get(topic, topic.capitalize()))
            yield columns([(usage(f), first_line(f)) for f in functions.values()])


def one_function(function: Function) -> Iterator[Block]:
    """Yield a function: usage, what it does, other names, examples."""
    yield heading(usage(function), function.name)
    yield from map(paragraph, words(function))
    others = [name for name in function.names if name != function.name]
    if others:
        yield paragraph(N_("Also called {names}.", names=listed(others)))
    shown = [f"{call} → {result}" for call, result in examples(function)]
    if shown:
        yield titled(FOR_EXAMPLE, lines(shown))


def one_helper(helper: Helper) -> Iterator[Block]:
    """Yield a helper of a workbook: usage, where it stands, its formula, its notes."""
    name = argument_name(helper.name.text)
    inputs = "; ".join(argument_name(i.text) for i in helper.inputs)
    yield heading(f"{name}({inputs})" if inputs else name)
    yield paragraph(N_("A helper of this workbook: {address}. Its formula:", address=helper.name.address))
    yield lines([helper.formula.text.removeprefix("=").strip() or N_("(blank)")])
    if notes := helper.remarks.get("Notes", ""):
        yield titled(N_("Notes"), *(paragraph(line) for line in notes.splitlines() if line.strip()))


def usage(function: Function) -> str:
    """The usage with semicolons, as in a spreadsheet.

    >>> usage(library().get("CLAMP"))
    'CLAMP(value; low; high)'
    """
    return function.usage.replace(",", ";").replace("_)", ")")


def first_line(function: Function) -> LazyMessage:
    """Return the first sentence of a function's help."""
    return words(function)[0]


def words(function: Function) -> list[LazyMessage]:
    """Return the paragraphs of a function's help, which is its docstring without the examples."""
    told = re.split(r"^>>> ", function.help, maxsplit=1, flags=re.MULTILINE)[0].strip().replace("`", "")
    return [LazyMessage(" ".join(text.split()), msgctxt="function") for text in told.split("\n\n")]


def examples(function: Function) -> list[tuple[str, str]]:
    """The doctests of a function as users type them: a formula, and what comes out.

    >>> examples(library().get("CLAMP"))[0]
    ('CLAMP(7; 0; 5)', '5')
    """
    if function.name in _LAZY and ">>> " not in function.help:
        return [(_LAZY[function.name], literal_text(worked_out(_LAZY[function.name])))]
    found = []
    for asked, answer in re.findall(r"^>>> (.+)\n((?:(?!>>> ).+\n?)*)", function.help, re.MULTILINE):
        found += _pairs(asked, answer.strip())
    return found


def worked_out(formula: str) -> object:
    """Return the value of a formula without inputs."""
    from rrp_sheets.formulas import compile_formula, make_scope
    from rrp_sheets.formulas.evaluator import GuardedInterpreter

    return compile_formula(formula, make_scope([])).prepare(GuardedInterpreter())()


def _pairs(asked: str, answer: str) -> list[tuple[str, str]]:
    try:
        tree = ast.parse(asked, mode="eval").body
    except SyntaxError:
        return [(asked, literal_text(ast.literal_eval(answer)))]  # written as users type it already
    result = ast.parse(answer, mode="eval").body
    if isinstance(tree, ast.Tuple) and isinstance(result, ast.Tuple):
        return [(_Spelling().visit(t), _Spelling().visit(r)) for t, r in zip(tree.elts, result.elts, strict=True)]
    return [(_Spelling().visit(tree), _Spelling().visit(result))]


def literal_text(value: object) -> str:
    """A value as users type it: TRUE, BLANK, "text", [1; 2], 4 for 4.0."""
    if value is None or isinstance(value, bool):
        return {None: "BLANK", True: "TRUE", False: "FALSE"}[value]
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, (list, tuple)):
        return f"[{'; '.join(literal_text(v) for v in value)}]"
    return f"{value:.12g}" if isinstance(value, float) else str(value)


class _Spelling(ast.NodeVisitor):
    """An expression of a doctest as users type it."""

    def visit_Constant(self, node: ast.Constant) -> str:
        return literal_text(node.value)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> str:
        return f"-{self.visit(node.operand)}"

    def visit_List(self, node: ast.List) -> str:
        return f"[{'; '.join(self.visit(e) for e in node.elts)}]"

    def visit_Tuple(self, node: ast.Tuple) -> str:
        return f"({'; '.join(self.visit(e) for e in node.elts)})"

    def visit_Attribute(self, node: ast.Attribute) -> str:
        return node.attr

    def visit_Name(self, node: ast.Name) -> str:
        return node.id

    def visit_Call(self, node: ast.Call) -> str:
        name = ast.unparse(node.func)
        shown = {function.call.__name__: function.name for function in library()}.get(name, name.upper())
        return f"{shown}({'; '.join(self.visit(a) for a in node.args)})"

    def generic_visit(self, node: ast.AST) -> str:
        return ast.unparse(node)
