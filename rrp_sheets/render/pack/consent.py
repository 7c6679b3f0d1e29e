"""Statements of the authors in the Protocol sheet: consent, withdrawal, and fields shown nowhere else."""

from __future__ import annotations

from rrp_sheets.model.names import key
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack import senses
from rrp_sheets.render.pack.model import Labelled
from rrp_sheets.render.pack.operator import TOLD
from rrp_sheets.render.pack.source import Source

HAPPENS = "What happens"
_WANTED = ("Version", "Purpose", "Participants", "Contact", "Ethics reference", "Data kept", "Retention")
_ELSEWHERE = (
    "Title", "Authors", *_WANTED, HAPPENS, TOLD, "Consent", "Withdrawal", "Deletion", "Time limit", "Robot", "Language",
    "Face memory", "Camera pictures",
)  # fmt: skip


def consent(source: Source) -> tuple[Labelled, ...]:
    """Return consent, withdrawal and deletion: the authors' statements, and what the program does."""
    get = source.get
    lines = []
    for entry in ("consent", "withdrawal", "deletion"):
        label, field = get(f"consent.{entry}"), entry.capitalize()
        if text := source.protocol(field):
            lines.append(Labelled(label, text, stated=True))
        elif entry == "consent":
            lines.append(Labelled(label, get("consent.not_stated", field=field)))
        if entry != "consent":
            lines.append(Labelled(label, get(f"consent.{entry}_text")))
    if senses.remembers_faces(source) and source.checked.run.keeps_faces:
        lines.append(Labelled(get("consent.deletion"), get("consent.deletion_faces")))
    return tuple(lines)


def statements(source: Source) -> tuple[Labelled, ...]:
    """Return the fields of the Protocol sheet that stand nowhere else in the pack."""
    protocol = source.checked.workbook.protocol
    elsewhere = {key(name) for name in _ELSEWHERE}
    return tuple(
        Labelled(clean(protocol.names.get(name, name)), cell.text)
        for name, cell in protocol.fields.items()
        if cell.text and name not in elsewhere
    )


def unstated(source: Source) -> list[str]:
    """Return the fields that a board asks for and the Protocol sheet lacks."""
    wanted = [*_WANTED, "Consent", *([TOLD] if source.buttons else [])]
    return [name for name in wanted if not source.protocol(name)]


def missing(source: Source) -> str:
    """Return the lacking fields in words; empty when there are none."""
    lacks = unstated(source)
    return source.get("consent.missing", list=source.listed(lacks)) if lacks else ""
