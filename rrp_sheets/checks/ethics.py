"""Questions of ethics boards: the fields that a study needs, and the risks for people that follow from its rows."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

from rrp_sheets.checks.facts import BLANK, Fact
from rrp_sheets.checks.protocol import RunPlan, kept_kinds
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.report import Fix, Insert
from rrp_sheets.graph import Graph, Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_, listed, translate
from rrp_sheets.workbook.schema import FIELDS

SIMULATED, REAL = FIELDS["robotinsessions"].words
BUTTON = "OperatorButton"
_NOBODY = re.compile(r"\s*(?:nobody|no one|no participants?|none|なし|無し|いません|参加者なし|誰も)", re.IGNORECASE)
_CHILDREN = re.compile(
    r"\b(?:child|children|child's|pupils?|kids?|boys?|girls?|toddlers?|minors?|teenagers?|adolescents?|infants?)\b"
    r"|子ども|子供|こども|児童|幼児|小学生|中学生|未成年|園児|児",
    re.IGNORECASE,
)
_PRIVATE = frozenset({"words", "camera", "faces"})
"""The kinds of kept data that tell of a person."""
_BOTH_ARMS = frozenset(f"{side} arm" for side in ("left", "right"))
Texts = tuple[str, str, str, str, str]
"""Risk, for whom, how likely, what reduces it, who ends the session when."""


@dataclass(frozen=True)
class ProposedRisk:
    """A risk that rows bring: its short name, and the texts of a row of the sheet Risks."""

    kind: str
    name: str
    texts: Texts


_NAMES = {
    "startle": N_("being startled"), "pinching": N_("pinching and knocks"), "falling": N_("a fall of the robot"),
    "walking": N_("a collision while it walks"), "lights": N_("flashing lights"),
    "attachment": N_("attachment to the robot"), "deception": N_("deception about who decides"),
    "distress": N_("distress or fear"),
    "privacy": N_("a loss of privacy"),
}  # fmt: skip
# How people name each risk: beginnings of English words, and Japanese words.
_NAMED = {
    kind: re.compile(pattern)
    for kind, pattern in {
        "startle": r"\b(?:startl|fright|loud|noise|sound|surpris|voice)|驚|びっくり|大きな音|音量|声",
        "pinching": r"\b(?:pinch|knock|crush|squeez|finger|bruis|hit\b)|挟|はさ|ぶつ|打撲|指",
        "falling": r"\b(?:fall|fell|tip over|tipping|topple|drop)|転倒|倒れ|落下|転落",
        "walking": r"\b(?:walk|collision|collid|trip|run into)|歩|衝突|つまず",
        "lights": r"\b(?:light|flash|flicker|seizure|epilep|led)|光|点滅|てんかん|発作",
        "attachment": r"\b(?:attach|fond|bond|miss the robot|sad)|愛着|別れ|寂し|さびし",
        "deception": r"\b(?:decei|decept|trick|believ|conceal|hidden|wizard)|欺|だま|隠|思い込",
        "distress": r"\b(?:distress|fear|afraid|anxi|upset|stress|frustrat|overload|overwhelm|cry)|不安|恐|怖|苦痛|泣",
        "privacy": r"\b(?:privacy|private|confiden|leak|recording|personal data|identif)|個人情報|プライバシー|漏|秘密",
    }.items()
}


@dataclass(frozen=True)
class Study:
    """A checked workbook, as an ethics board asks about it."""

    workbook: Workbook
    robot: Robot
    graph: Graph
    run: RunPlan
    facts: Mapping[str, Fact]

    @property
    def is_demonstration(self) -> bool:
        """True if the Protocol says that nobody takes part."""
        return bool(_NOBODY.match(self.workbook.protocol.text("Participants")))

    @property
    def has_children(self) -> bool:
        """True if the Protocol says that children take part."""
        return bool(_CHILDREN.search(self.workbook.protocol.text("Participants")))

    @cached_property
    def driven(self) -> list[Stream]:
        """The actuator streams that active rows drive, each once; not those that rows only stop."""
        steps = [s for b in self.graph.behaviours for s in b.steps if s.active and s.connector.is_sink]
        starting = [s for s in steps if s.ref not in self.facts or self.facts[s.ref].known.kind != BLANK]
        found = dict.fromkeys(s.output for s in starting if s.output in self.graph.streams)
        return [self.graph.streams[i] for i in found if self.graph.streams[i].device is not None]

    @cached_property
    def sensed(self) -> list[Stream]:
        """The sensor streams that active rows take in, each once."""
        steps = [s for b in self.graph.behaviours for s in b.steps if s.active]
        streams = [self.graph.streams[i] for i in dict.fromkeys(i for s in steps for i in s.inputs)]
        return [s for s in streams if s.kind is StreamKind.SENSOR and s.device is not None]

    @cached_property
    def parts(self) -> set[str]:
        """The parts of the robot that rows drive, such as `voice` and `left arm`."""
        used = set[str]()
        for stream in self.driven:
            if stream.device is not None:
                used |= stream.device.type.resources_for(stream.settings)
            if stream.settings.get("gestures") is True:  # small gestures go with what it says
                used |= _BOTH_ARMS
        return used

    @property
    def buttons(self) -> list[str]:
        """The labels of the operator's buttons that rows take in."""
        mine = [s for s in self.sensed if s.device and s.device.type.name == BUTTON]
        return [str(s.settings.get("label") or s.name) for s in mine]

    @property
    def looks_for_faces(self) -> bool:
        """True if rows look for faces, or let the robot remember one."""
        return "memory" in self.parts or any("person" in s.device.type.shows for s in self.sensed if s.device)

    @property
    def meets(self) -> str:
        """The robot that participants meet, as the Protocol says: `simulated`, `real`, or empty."""
        return FIELDS["robotinsessions"].meaning(self.workbook.protocol.text("Robot in sessions"))

    def asked_fields(self) -> list[str]:
        """Return the names of the fields that a board asks for, in the order of the schema."""
        if self.is_demonstration:
            return []
        conditions = {
            "always": True, "children": self.has_children, "operator": bool(self.buttons),
            "faces": self.looks_for_faces,
        }  # fmt: skip
        return [field.name for field in FIELDS.values() if conditions.get(field.asked)]

    def missing_fields(self) -> list[str]:
        """Return the names of the fields that a board asks for and that are blank or not there."""
        return [name for name in self.asked_fields() if not self.workbook.protocol.text(name)]

    def proposed_risks(self) -> list[ProposedRisk]:
        """Return the risks that the rows bring, as they are proposed for the sheet Risks."""
        makers = {
            "startle": self._startle, "pinching": self._pinching, "falling": self._falling, "walking": self._walking,
            "lights": self._lights, "attachment": self._attachment, "deception": self._deception,
            "distress": self._distress, "privacy": self._privacy,
        }  # fmt: skip
        found = {kind: make() for kind, make in makers.items()}
        return [ProposedRisk(kind, _NAMES[kind], texts) for kind, texts in found.items() if texts is not None]

    def unnamed_risks(self) -> list[ProposedRisk]:
        """Return the proposed risks that no row of the sheet Risks names; all of them when there is no such sheet."""
        rows = self.workbook.risks.rows if self.workbook.risks else ()
        named = [row.risk.text.casefold() for row in rows]
        return [risk for risk in self.proposed_risks() if not any(_NAMED[risk.kind].search(text) for text in named)]

    # ---- the risks, one by one
    @property
    def _whom(self) -> str:
        return N_("The child") if self.has_children else N_("Participants")

    def _startle(self) -> Texts | None:
        voices = [s for s in self.driven if s.device and "voice" in s.device.type.resources]
        if not voices:
            return None
        volumes = [v for s in voices if isinstance(v := s.settings.get("volume"), (int, float))]
        volume = max(volumes, default=100)
        return (
            N_("Startled by the robot's voice or by a sound"), self._whom,
            N_("Possible, most of all at the first sentence or sound"),
            N_("The volume is {volume:g} % at most. Set the loudspeaker before the session, and let the voice be heard "
               "once, quietly, before it begins.", volume=volume),
            N_("The operator presses Stop when somebody covers the ears, cries or wants to leave."),
        )  # fmt: skip

    def _pinching(self) -> Texts | None:
        if not self.parts & {*_BOTH_ARMS, "head"}:
            return None
        touched = any(s.device and s.device.type.name in ("Touch", "Bumper", "ChestButton") for s in self.sensed)
        likely = (
            N_("Possible: people touch the robot, and it moves then") if touched
            else N_("Unlikely at a distance, possible when somebody touches the robot while it moves")
        )  # fmt: skip
        return (
            N_("Fingers pinched between moving parts, or a knock from an arm or the head"), self._whom, likely,
            N_("Everybody stays out of the reach of its arms while it moves. The settings Speed and Tempo make "
               "movements slower."),
            N_("The person beside the participant says “stop”, and the operator presses Stop, when a hand is near a "
               "moving part."),
        )  # fmt: skip

    def _falling(self) -> Texts | None:
        if "legs" not in self.parts:
            return None
        return (
            N_("The robot falls on somebody, or off the table"), N_("Everybody near the robot"),
            N_("Unlikely while it sits, possible when it stands, changes its posture or walks"),
            N_("The robot is on the floor, or on a wide and level surface. A person is within reach to catch it. "
               "Rehearsals in the simulator do not show whether a real robot keeps its balance."),
            N_("The person beside the robot ends the session after a fall, before anybody lifts the robot."),
        )  # fmt: skip

    def _walking(self) -> Texts | None:
        if not any(s.device and "forward" in s.device.type.settings for s in self.driven):
            return None
        return (
            N_("The robot walks into somebody, or somebody trips over it"), N_("Everybody near the robot"),
            N_("Possible"),
            N_("The area in which it walks is marked and kept free. The simulated robot stops before a thing in its "
               "way; this is tried with the real one before the study."),
            N_("The operator presses Stop when somebody enters the marked area."),
        )  # fmt: skip

    def _lights(self) -> Texts | None:
        if "eyes" not in self.parts:
            return None
        return (
            N_("Discomfort or a seizure from flashing eye lights"), N_("People with photosensitive epilepsy"),
            N_("Unlikely while the lights change less than 3 times a second"),
            N_("People are asked about epilepsy before the session. The lights do not flash."),
            N_("The operator presses Stop when somebody turns away from the lights or feels unwell."),
        )  # fmt: skip

    def _attachment(self) -> Texts | None:
        if not ("voice" in self.parts or self.looks_for_faces or self.parts & _BOTH_ARMS):
            return None
        return (
            N_("Attachment to the robot, and sadness when it is gone"), self._whom,
            N_("Possible after several sessions"),
            N_("Everybody learns at the start that the robot is a machine and how many sessions there are. The last "
               "session ends with a goodbye."),
            N_("The accompanying person ends the session when the participant cannot let go of the robot."),
        )  # fmt: skip

    def _deception(self) -> Texts | None:
        if not self.buttons:
            return None
        buttons = listed([N_("“{label}”", label=label) for label in self.buttons[:6]], "and")
        return (
            N_("Deception: people may believe that the robot decides what a person does with the buttons {buttons}",
               buttons=buttons),
            self._whom, N_("Likely, unless they are told"),
            N_("People are told before the session that a person controls parts of it, or they are told afterwards and "
               "can have their data deleted."),
            N_("The investigator ends the session and tells the truth when somebody feels tricked."),
        )  # fmt: skip

    def _distress(self) -> Texts | None:
        if not self.driven:
            return None
        if self.has_children:
            return (
                N_("Distress of the child: fear of the robot, too much at once, or frustration"), self._whom,
                N_("Possible, most of all in the first minutes"),
                N_("A person whom the child knows sits beside it. The robot is shown at rest before it moves. "
                   "Sessions are short, with breaks."),
                N_("The accompanying person or the operator ends the session at the first sign of dissent, without "
                   "asking for a reason."),
            )  # fmt: skip
        return (
            N_("Distress: fear of the robot, or frustration"), self._whom,
            N_("Possible, most of all in the first minutes"),
            N_("The robot is shown at rest before it moves. Everybody knows how to stop it."),
            N_("The operator ends the session when the participant asks for it or looks distressed."),
        )  # fmt: skip

    def _privacy(self) -> Texts | None:
        if not _PRIVATE.intersection(kept_kinds(self.robot, self.graph, self.run)):
            return None
        return (
            N_("A loss of privacy: somebody sees or hears recordings who should not"), N_("Everybody who is recorded"),
            N_("Unlikely"),
            N_("Recordings have codes instead of names. The disk is encrypted, few people have access, and the "
               "recordings are deleted on the planned day."),
            N_("The investigator stops recording, and tells the board, when recordings are lost or seen by others."),
        )  # fmt: skip


def check_ethics(study: Study, report: Report) -> None:
    """Report risks that the sheet Risks leaves out, rows of it that are incomplete, and fields that boards ask for."""
    language = study.run.language
    _check_risks(study, language, report)
    end, fields = study.workbook.protocol.end, study.workbook.protocol.fields
    lacking = [name for name in study.asked_fields() if key(name) not in fields]
    if end is None or key("Ethics reference") not in fields or not lacking:
        return
    rows = (Insert(end.sheet, end.row + n, ((end.column, name),)) for n, name in enumerate(lacking))
    fix = Fix("add-fields", N_("Add these fields"), tuple(rows))
    report.add("PROT014", fields[key("Ethics reference")].address, fixes=(fix,), names=", ".join(lacking))


def _check_risks(study: Study, language: str, report: Report) -> None:
    sheet = study.workbook.risks
    if sheet is None:
        return
    for row in sheet.rows:
        lacks = [what for cell, what in ((row.reduces, N_("what reduces it")),
                                         (row.ends, N_("who ends the session when"))) if not cell]  # fmt: skip
        if row.risk and lacks:
            report.add("PROT013", row.risk.address, risk=row.risk.text[:80], what=listed(lacks, "and"))
    left_out = study.unnamed_risks()
    if not left_out:
        return
    columns = list(sheet.columns.values())
    edits = []
    for n, risk in enumerate(left_out, 1):
        cells = ((c, translate(text, language)) for c, text in zip(columns, risk.texts, strict=True) if c)
        edits.append(Insert(sheet.address.sheet, sheet.last + n, tuple(sorted(cells))))
    title = N_("Add the proposed rows") if len(edits) > 1 else N_("Add the proposed row")
    fix = Fix("add-proposed", title, tuple(edits))
    what = listed([risk.name for risk in left_out], "and")
    report.add("PROT012", sheet.address, fixes=(fix,), what=what)
