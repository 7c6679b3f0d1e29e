"""Drawing and explaining a checked workbook."""

from __future__ import annotations

from pathlib import Path

from rrp_sheets.checks import Checked
from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model.names import key, nearest
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook.atomic import write_atomically

MOST_ROWS = 2_000  # a hundred pages; Graphviz takes half a minute for them


def draw(checked: Checked, target: Path, behaviour: str = "", language: str = "") -> list[str]:
    """Draw the behaviours (or one) into a file; return what the picture lacks (a font, say), in words.

    The language is the Protocol's unless another one is given.

    Raises:
        SheetsError: when it cannot be written or drawn.
    """
    from rrp_sheets.render.diagram import draw_diagram, to_dot
    from rrp_sheets.render.output import NOT_WRITTEN, NOTHING, SUFFIXES, target_of, write_diagram

    path, suffix = target_of(target, NOT_WRITTEN, (*SUFFIXES, ".dot"))
    behaviours = chosen(checked, behaviour)
    if suffix == ".dot":  # one graph: programs that read it draw the first of several and are silent on the others
        if not any(b.steps for b in behaviours):
            raise SheetsError(NOTHING)
        write_atomically(path, to_dot(checked.graph, behaviours).encode())
        return []
    pages = []
    for graph in behaviours:
        if len(graph.steps) > MOST_ROWS:
            raise SheetsError(
                N_("The behaviour “{name}” has {n} rows; at most {most} can be drawn.",
                   name=graph.name, n=len(graph.steps), most=MOST_ROWS),
                N_("Divide it into several behaviours."),
            )  # fmt: skip
        flags = {
            d.address.row: n
            for n, d in enumerate(checked.report, 1)
            if d.address and key(d.address.sheet) == graph.key and d.severity is not Severity.INFO
        }
        pages += draw_diagram(checked.graph, graph, problems=flags, language=language or checked.run.language)
    return write_diagram(pages, target)


def explain(checked: Checked, behaviour: str = "", language: str = "") -> str:
    """Explain the behaviours (or one) in plain words, in the Protocol's language or the one that is given."""
    from rrp_sheets.render.sentences import explain_text

    behaviours = chosen(checked, behaviour)
    return explain_text(checked.graph, checked.workbook, behaviours, language=language or checked.run.language)


def chosen(checked: Checked, name: str) -> list[BehaviourGraph]:
    """Return all behaviours, or the one of that name; raise SheetsError when there is none."""
    behaviours = checked.graph.behaviours
    found = [b for b in behaviours if not name or b.key == key(name)]
    if name and not found:
        names = [b.name for b in behaviours]
        guess = nearest(name, names)
        others = N_("The behaviours are: {names}.", names=listed(names))
        hint = N_("Did you mean {guess}?", guess=guess) if guess else others
        raise SheetsError(N_("There is no behaviour “{name}” in this workbook.", name=name), hint)
    return found
