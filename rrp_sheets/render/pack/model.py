"""Data of the ethics pack: plain data in words, without layout; `templates/print/pack.typ` sets it."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Labelled:
    """A text with its label; `stated` by the workbook's authors in the Protocol sheet, else known by the program."""

    label: str
    text: str
    stated: bool = False


@dataclass(frozen=True)
class MissingField:
    """Something that boards ask for and the workbook lacks: its name in words, where to fill it in, how many it is."""

    name: str
    where: str
    count: int = 1


@dataclass(frozen=True)
class RiskLine:
    """A risk, as the sheet Risks has it; `proposed` by the program and not confirmed when the sheet does not."""

    risk: str
    whom: str
    likely: str
    reduces: str
    ends: str
    proposed: bool


@dataclass(frozen=True)
class Ref:
    """Rows of one behaviour."""

    behaviour: str
    rows: tuple[int, ...]


@dataclass(frozen=True)
class Sensed:
    """Sensor streams, the channel of the sensor, the sentence of what it notices, and the values that rows get."""

    streams: str
    through: str
    notices: str
    values: str
    used: tuple[Ref, ...]


@dataclass(frozen=True)
class Said:
    """Texts that rows can say and their voice, or gestures that rows can make and their stream.

    `words` has ‹…› where the run decides.
    """

    used: tuple[Ref, ...]
    words: tuple[str, ...]
    left_out: int
    voice: str


@dataclass(frozen=True)
class DrawnMovement:
    """A gesture or posture that rows can make: what it is, how far and how long it goes, the files of its drawings."""

    name: str
    text: str
    poses: tuple[str, ...]


@dataclass(frozen=True)
class Act:
    """An actuator stream: what it does, which parts of the robot it uses, how fast at most."""

    stream: str
    does: str
    parts: str
    speed: str
    used: tuple[Ref, ...]


@dataclass(frozen=True)
class Rival:
    """A part of the robot that several rows drive: the rows by priority, the largest first."""

    part: str
    rows: tuple[tuple[str, tuple[Ref, ...]], ...]


@dataclass(frozen=True)
class Hand:
    """Button of the operator: the rows that take it in, and the actuators that it starts and ends."""

    name: str
    used: tuple[Ref, ...]
    starts: str
    ends: str


@dataclass(frozen=True)
class Stopping:
    """A way to end the run."""

    who: str
    how: str
    used: tuple[Ref, ...] = ()


@dataclass(frozen=True)
class OpenFinding:
    """A finding of the check that is still open; `flag` is its number in the diagrams."""

    flag: int
    severity: str
    where: str
    row: int
    text: str
    remedy: str


@dataclass(frozen=True)
class TestSheetResult:
    """Result of a test sheet of the workbook: whether it passes today, and its failures."""

    name: str
    passed: bool
    counted: str
    failures: tuple[str, ...] = ()


@dataclass(frozen=True)
class Figure:
    """A diagram, or a part of one; sizes in points, `picture` is the name of its file."""

    picture: str
    alt: str
    caption: str
    width: float
    height: float
    first: int
    last: int


@dataclass(frozen=True)
class Sentence:
    """A row in words; `flags` are numbers of findings, `mark` says what changed, `group` is the comment above it."""

    row: int
    text: str
    flags: tuple[int, ...]
    mark: str
    group: str = ""


@dataclass(frozen=True)
class TableRow:
    """A row as the sheet has it."""

    row: int
    inputs: str
    connector: str
    formula: str
    output: str
    on: bool
    priority: str
    notes: str
    mark: str
    group: str = ""


@dataclass(frozen=True)
class BehaviourPart:
    """A behaviour: what it takes in and acts on, paragraph, diagrams, sentences, table.

    A long paragraph is left out: the sentences say the same. `note`: what is missing, or that it starts later.
    """

    name: str
    takes_in: str
    acts_on: str
    paragraph: str
    note: str
    figures: tuple[Figure, ...]
    sentences: tuple[Sentence, ...]
    rows: tuple[TableRow, ...]


@dataclass(frozen=True)
class Sheet:
    """Table of the workbook; `note` stands above it, `mono` has the columns of formulas, `widths` are relative."""

    title: str
    note: str
    heads: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    widths: tuple[float, ...]
    left_out: str = ""
    mono: tuple[int, ...] = ()


@dataclass(frozen=True)
class VersionDifference:
    """A difference from the approved version."""

    kind: str
    where: str
    before: str
    after: str
    note: str


@dataclass(frozen=True)
class Changes:
    """Differences from the approved version: `effects` alter the behaviour, `others` do not.

    `marks` tell what happened to rows (`added`, `changed`), by the behaviour's key and the row's number.
    """

    intro: str
    digest: str
    verdict: str
    effects: tuple[VersionDifference, ...]
    others: tuple[VersionDifference, ...]
    left_out: str
    marks: dict[str, dict[int, str]]


@dataclass(frozen=True)
class Pack:
    """Contents of the whole ethics pack.

    Attributes:
        status: what is wrong with using it (`DRAFT`), or empty.
        digest: SHA-256 of the workbook.
        connectors: names of those that rows use, for the legend.
        facts: of the title block; `glance`: the boxes of the first page.
        kept: what is stored; `consent`: consent, withdrawal and deletion.
        meets: which robot participants meet; `body`: the robot's size, weight, forces and speeds.
        missing: what a board asks for and the workbook lacks; `missing_note` and `missing_where` stand above.
        study: the statements on the study and its participants; `benefits` those that are weighed with the risks.
    """

    language: str
    title: str
    status: str
    version: str
    reference: str
    mode: str
    digest: str
    authors: tuple[str, ...]
    purpose: str
    facts: tuple[Labelled, ...]
    happens: str
    summary: str
    glance: tuple[Labelled, ...]
    numbers: tuple[Labelled, ...]
    findings: tuple[OpenFinding, ...]
    findings_left_out: str
    sensed: tuple[Sensed, ...]
    kept: tuple[Labelled, ...]
    says: tuple[Said, ...]
    says_note: str
    makes: tuple[Said, ...]
    movements: tuple[DrawnMovement, ...]
    acts: tuple[Act, ...]
    cautions: tuple[Labelled, ...]
    rivals: tuple[Rival, ...]
    hand: tuple[Hand, ...]
    hand_title: str
    hand_note: str
    always: tuple[str, ...]
    stops: tuple[Stopping, ...]
    tests: tuple[TestSheetResult, ...]
    tests_note: str
    behaviours: tuple[BehaviourPart, ...]
    connectors: tuple[str, ...]
    sheets: tuple[Sheet, ...]
    changes: Changes | None
    consent: tuple[Labelled, ...]
    statements: tuple[Labelled, ...]
    meets: Labelled
    missing: tuple[MissingField, ...]
    missing_note: str
    missing_where: str
    study: tuple[Labelled, ...]
    benefits: tuple[Labelled, ...]
    risks: tuple[RiskLine, ...]
    risks_note: str
    body: tuple[Labelled, ...]
    body_note: str
    operator: tuple[Labelled, ...]
    signatures: tuple[str, ...]
