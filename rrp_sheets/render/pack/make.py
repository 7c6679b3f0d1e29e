"""A workbook's ethics pack: everything in it, as data."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rrp_sheets.checks import Checked
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack import acts, consent, front, material, operator, senses
from rrp_sheets.render.pack.behaviours import Pictures, behaviour_parts
from rrp_sheets.render.pack.front import Print
from rrp_sheets.render.pack.model import Changes, Finding, Pack, Tested
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.rows import Rows
from rrp_sheets.render.texts import texts
from rrp_sheets.workbook import Reading

MOST_FINDINGS = 300
_AUTHORS = re.compile(r"\s*[;\n]\s*")


def make_pack(
    reading: Reading,
    checked: Checked,
    this: Print,
    *,
    language: str = "en",
    tests: Sequence[Tested] = (),
    tests_note: str = "",
    changes: Changes | None = None,
    draft: bool = False,
    drawn: bool = True,
) -> tuple[Pack, Pictures]:
    """The pack of a checked workbook, and its diagrams by the names under which it asks for them.

    Args:
        reading: as it was read.
        checked: the same, checked; it may have errors.
        this: of this print.
        language: of the program's own words.
        tests: what the workbook's tests amounted to.
        tests_note: what there is to say about all of them.
        changes: what is different from the approved version.
        draft: whether it is marked as one on every page; one with errors always is.
        drawn: whether it has diagrams; without them it is only text.
    """
    words = texts(language)
    source = Source(reading, checked, words, Rows(checked.graph, checked.workbook, words))
    get, said = source.get, acts.says(source)
    behaviours, pictures = behaviour_parts(source, changes, drawn=drawn)
    left = len(source.findings) - MOST_FINDINGS
    return (
        Pack(
            language=language, title=front.title_of(source, this.name), status=_status(source, draft),
            version=clean(source.protocol("Version")), reference=clean(source.protocol("Ethics reference")),
            mode=get("mode"), digest=reading.digest, authors=_authors(source), purpose=source.protocol("Purpose"),
            facts=front.facts(source, this), happens=source.protocol(consent.HAPPENS),
            summary=front.summary(source, said), glance=front.glance(source, said),
            numbers=front.numbers(source, said, tests),
            findings=tuple(_finding(source, n, d) for n, d in enumerate(source.findings[:MOST_FINDINGS], 1)),
            findings_left_out=get("more", n=left) if left > 0 else "",
            sensed=senses.sensed(source), kept=senses.kept(source), says=said, says_note=get("says.by_hand"),
            makes=acts.makes(source), acts=acts.acts(source), cautions=acts.cautions(source),
            rivals=acts.rivals(source), hand=operator.hand(source),
            hand_title=get("hand.title" if source.buttons else "hand.title_none"),
            hand_note=get("hand.note" if source.buttons else "hand.note_none"), always=operator.always(source),
            told=source.protocol(operator.TOLD), stops=operator.stops(source), tests=tuple(tests),
            tests_note=tests_note,
            behaviours=behaviours, sheets=material.sheets(source), changes=changes, consent=consent.consent(source),
            statements=consent.statements(source), missing=consent.missing(source),
            signatures=tuple(get(f"signatures.{who}") for who in ("researcher", "board", "operator")),
        ),
        pictures,
    )  # fmt: skip


def _status(source: Source, draft: bool) -> str:
    if errors := source.checked.report.errors:
        return source.count("draft_errors", len(errors))
    return source.get("draft") if draft else ""


def _authors(source: Source) -> tuple[str, ...]:
    return tuple(clean(name) for name in _AUTHORS.split(source.protocol("Authors")) if name.strip())


def _finding(source: Source, flag: int, found: Diagnostic) -> Finding:
    where, row = (clean(found.address.sheet), found.address.row) if found.address else ("", 0)
    severity = source.get(f"open.{found.severity.value}")
    said = found.in_language(source.words.language)
    return Finding(flag, severity, where, row, clean(said.message), clean(said.remedy))
