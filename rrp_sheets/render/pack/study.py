"""The study as the Protocol sheet describes it: participants, risks and benefits, and what a board asks for in vain."""

from __future__ import annotations

from collections.abc import Iterable

from rrp_sheets.checks.ethics import REAL, SIMULATED
from rrp_sheets.model.names import key
from rrp_sheets.render.pack.model import Labelled, MissingField, RiskLine
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.style import clean
from rrp_sheets.texts import translate
from rrp_sheets.workbook.schema import FIELDS, title_of

STUDY = (
    "Research question", "Design", "Measures", "Analysis and publication", "Participants",
    "Why these participants", "Number of participants",
    "Inclusion and exclusion", "Recruitment", "Compensation", "Sessions", "Place", "Period", "Present", "Distance kept",
    "Test of Stop",
    "Changes after approval",
    "Robot used", "Ending the study", "Feedback", "Investigators", "Training and background checks",
    "Permissions and conformity", "Funding and conflicts of interest", "Insurance", "Attachments",
)  # fmt: skip
BENEFITS = ("Benefits", "Adverse events and safeguarding", "Incidental findings")
DATA = (
    "Data kept", "Other data", "Retention", "Lawful basis and impact assessment", "Responsible for the data",
    "Face data", "Access", "Code key", "Encryption", "Network", "Sharing",
)  # fmt: skip
CONSENT = ("Information sheets", "Consent and capacity", "Assent", "Dissent", "Withdrawal", "Deletion", "Complaints")
OPERATOR = ("Participants are told", "Reason for concealment", "Debriefing")
FRONT = (
    "Title", "Authors", "Version", "Version date", "Ethics reference", "Contact", "Purpose", "What happens",
    "What participants do", "Robot in sessions",
)  # fmt: skip
RUN = ("Run", "Engine", "Frame rate", "Seed")
MOST_RISKS = 100


def field_label(source: Source, name: str) -> str:
    """Return what a field of the Protocol sheet is called in the pack's language."""
    return FIELDS[key(name)].name_in(source.words.language)


def stated(
    source: Source, names: Iterable[str], *, marked: bool = True, front: Iterable[str] = ()
) -> tuple[Labelled, ...]:
    """Return what the Protocol sheet says in some fields, and in one line what it leaves open.

    The statements are `marked` as such, where they stand among what the program knows. Those of the fields `front`
    stand on the first page.
    """
    names = list(names)
    lines = [Labelled(field_label(source, n), text, stated=marked) for n in names if (text := source.protocol(n))]
    wanted = set(source.checked.study.missing_fields())
    if lacks := [field_label(source, n) for n in (*front, *names) if n in wanted]:
        lines.append(Labelled(source.get("study.open"), source.words.listed(lacks)))
    return tuple(lines)


def meets(source: Source) -> Labelled:
    """Return which robot participants meet, and that the persons of the scene are simulated."""
    study, scene = source.checked.study, source.checked.scene
    entry = "nobody" if study.is_demonstration else {SIMULATED: "simulated", REAL: "real"}.get(study.meets, "open")
    lines = [source.get(f"meets.{entry}", robot=clean(source.checked.robot.title))]
    shown = [what.split()[0] for s in study.sensed if s.device for what in s.device.type.shows]
    acting = {action.what for action in scene} if scene is not None else set(shown)  # those of the scene made for it
    if study.meets != REAL and acting & {"person", "touch", "say", "near"}:
        lines.append(source.get("meets.persons"))
    return Labelled(source.get("meets.label"), source.words.sentences(lines))


def mode(source: Source) -> str:
    """Return what stands at the foot of every page: which robot it is about."""
    return source.get("mode_real" if source.checked.study.meets == REAL else "mode")


def missing(source: Source) -> tuple[MissingField, ...]:
    """Return what a board asks for and the workbook does not say, with the place where it belongs."""
    study, get = source.checked.study, source.get
    cells = source.checked.workbook.protocol.fields
    found = []
    for name in study.missing_fields():
        cell = cells.get(key(name))
        where = get("missing.row_is", row=cell.address.row) if cell is not None else ""
        found.append(MissingField(field_label(source, name), where))
    if not study.is_demonstration:
        own = study.workbook.risks
        sheet = clean(own.address.sheet) if own else title_of("risks", source.words.language)
        where = get("missing.risks", sheet=sheet)
        if left := len(study.unnamed_risks()):
            found.append(MissingField(source.count("missing.risk", left), where, left))
        if not study.task_risks():
            found.append(MissingField(get("missing.task_risks"), where))
    return tuple(found)


def count(lacks: Iterable[MissingField]) -> int:
    """Return how many things are missing; of risks each counts."""
    return sum(lack.count for lack in lacks)


def missing_where(source: Source) -> str:
    """Return in which sheet the missing fields belong."""
    end = source.checked.workbook.protocol.end
    return source.get("missing.where", sheet=clean(end.sheet) if end else title_of("protocol", source.words.language))


def missing_note(source: Source, lacks: int) -> str:
    """Return the sentence above the list of what is missing; without such a list, the reason why there is none."""
    if source.checked.study.is_demonstration:
        return source.get("missing.nobody")
    return source.count("missing.note", lacks) if lacks else source.get("missing.none")


def risks(source: Source) -> tuple[RiskLine, ...]:
    """Return the rows of the sheet Risks, then what the program proposes for it."""
    study = source.checked.study
    rows = study.workbook.risks.rows if study.workbook.risks else ()
    lines = [
        RiskLine(clean(r.risk.text), clean(r.whom.text), clean(r.likely.text), clean(r.reduces.text),
                 clean(r.ends.text), proposed=False)
        for r in rows
    ]  # fmt: skip
    for risk in study.unnamed_risks():
        name, whom, likely, reduces, ends = (translate(text, source.words.language) for text in risk.texts)
        lines.append(RiskLine(name, whom, likely, reduces, ends, proposed=True))
    return tuple(lines[:MOST_RISKS])


def risks_note(source: Source) -> str:
    """Return how the table of risks came about."""
    study = source.checked.study
    own, left = bool(study.workbook.risks and study.workbook.risks.rows), bool(study.unnamed_risks())
    if not own and not left:
        return source.get("risks.nothing")
    lines = [source.get("risks.both" if own and left else "risks.own" if own else "risks.proposed")]
    lines += [source.get("risks.severe")] if left else []
    lines += [] if study.is_demonstration or study.task_risks() else [source.get("risks.task")]
    return source.words.sentences(lines)


def elsewhere() -> set[str]:
    """Return the keys of the fields that stand at a place of their own in the pack."""
    names = (*FRONT, *STUDY, *BENEFITS, *DATA, *CONSENT, *OPERATOR)
    run = ("Time limit", "Robot", "Language", "Face memory", "Camera pictures")
    return {key(name) for name in (*names, *run, *RUN)} & FIELDS.keys()
