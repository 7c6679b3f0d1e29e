"""`help connectors`: the list; `help sample`: one of them, with its example run."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.connectors import Connector, Parameter, connectors
from rrp_sheets.help.connector_marbles import MARK_US, can_be_run, input_names, marbles, output_name, parts, workbook
from rrp_sheets.help.layout import checked, entries, grids, heading, paragraph, titled
from rrp_sheets.model.names import key
from rrp_sheets.workbook.schema import BEHAVIOUR

_INPUTS, _CONNECTOR, _FORMULA, _OUTPUT = (column.name for column in BEHAVIOUR.required)
_CELLS = {
    Parameter.FORMULA: "a formula, or the name of a helper",
    Parameter.OPTIONAL_FORMULA: "a formula or the name of a helper; may be blank",
    Parameter.PERIOD: "a time: 500 ms, 2 s, 1 min; a number alone means milliseconds",
    Parameter.NONE: "blank",
}

IN_USE = {
    "once": (
        "To count each visitor once: the formula says what makes a visitor another one",
        """
## Visitors
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Face | once | face.id | Visitor |
| Visitor | accumulate | | Visitors |
| Visitors | subscribe | | Print |
""",
    ),
}
"""A workbook that shows what a connector is good for, with its title."""


def all_connectors() -> Iterator[str]:
    """The connectors, the small set first."""
    found = {c.name: c for c in connectors()}.values()
    yield paragraph(
        "What a row does with its input streams. `rrp-sheets help sample`, say, shows one with an example. "
        "Spelling is free: combineLatest, combine latest and COMBINE_LATEST are the same."
    )
    yield heading("To begin with")
    yield entries((c.name, c.help) for c in found if not c.advanced)
    advanced = [(c.name, c.help) for c in found if c.advanced]
    if advanced:
        yield heading("Advanced")
        yield entries(advanced)


def one_connector(connector: Connector) -> Iterator[str]:
    """A connector: what it does, what it takes, its sentence and its example."""
    yield heading(f"{connector.name} (connector{', advanced' if connector.advanced else ''})")
    yield paragraph(connector.help)
    facts = [(_INPUTS, _count(connector)), (_FORMULA, _CELLS[connector.parameter])]
    facts.append((_OUTPUT, "an actuator" if connector.is_sink else "a new name"))
    synonyms = [s for s in connector.synonyms if key(s) != key(connector.name)]
    if synonyms:
        facts.append(("Also called", ", ".join(synonyms)))
    yield entries(facts)
    if can_be_run(connector):
        yield from _example(connector)
    if connector.name in IN_USE:
        title, book = IN_USE[connector.name]
        yield titled(title, *grids(book), between="\n\n")


def _example(connector: Connector) -> Iterator[str]:
    rows, parameter = parts(connector)
    names = ", ".join(input_names(len(rows)))
    cells = ((_INPUTS, names), (_CONNECTOR, connector.name), (_FORMULA, parameter), (_OUTPUT, output_name(connector)))
    yield titled("For example", entries(cell for cell in cells if cell[1]))
    yield titled("In words", paragraph(_sentence(connector), 2))
    title = f"As marbles: one place is {MARK_US // 1000} ms, time goes to the right"
    picture = entries(marbles(connector), kind="marbles")
    picture.head = connector.name  # a page draws it anew
    yield titled(title, picture)


def _sentence(connector: Connector) -> str:
    from rrp_sheets.render.sentences import Rows
    from rrp_sheets.render.texts import texts

    book = checked(workbook(connector))
    steps = book.graph.behaviours[0].steps
    step = next(s for s in reversed(steps) if s.connector.name == connector.name)
    return Rows(book.graph, book.workbook, texts()).sentence(step)


def _count(connector: Connector) -> str:
    least, most = connector.min_inputs, connector.max_inputs
    if most == least:
        return {1: "one", 2: "two"}.get(least, str(least))
    words = {1: "one", 2: "two"}.get(least, str(least))
    return f"{words} or more" if most is None else f"{words} to {most}"
