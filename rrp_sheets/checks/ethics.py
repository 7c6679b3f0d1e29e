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
from rrp_sheets.graph import Graph, Step, Stream, StreamKind
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import RiskRow, Workbook
from rrp_sheets.robots import Robot
from rrp_sheets.texts import N_, listed, sentences, translate
from rrp_sheets.workbook.schema import FIELDS

SIMULATED, REAL = FIELDS["robotinsessions"].words
_NOBODY = re.compile(r"\s*(?:nobody|no one|no participants?|none|なし|無し|いません|参加者なし|誰も)", re.IGNORECASE)
_CHILDREN = re.compile(
    r"\b(?:child|children|child's|pupils?|kids?|boys?|girls?|toddlers?|minors?|teenagers?|adolescents?|infants?)\b"
    r"|子ども|子供|こども|児童|幼児|小学生|中学生|未成年|園児|児",
    re.IGNORECASE,
)
_YEAR = re.compile(r"(?<!\d)(?:19|20)\d\d(?:[01]\d[0-3]\d)?(?!\d)|令和\s*[\d元]")  # a version with a year has its date
_BOTH_ARMS = frozenset(f"{side} arm" for side in ("left", "right"))  # parts of the robot, not texts
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
    "distress": N_("distress or fear"), "tiredness": N_("tiredness"), "privacy": N_("a loss of privacy"),
    "power": N_("the power button on its chest"), "battery": N_("battery and cables"), "cleaning": N_("infection"),
}  # fmt: skip
_BODILY = frozenset({"pinching", "falling", "walking", "power", "battery", "cleaning"})
"""The risks that only a robot in the room brings."""
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
        "tiredness": r"\b(?:tired|fatigue|exhaust|bored|too long)|疲|飽き",
        "privacy": r"\b(?:privacy|private|confiden|leak|recording|personal data|identif)|個人情報|プライバシー|漏|秘密",
        "power": r"\b(?:chest|power|switch(?:ed|es)? off)|胸|電源",
        "battery": r"\b(?:batter|charg|cable|cord|electric)|電池|バッテリー|充電|ケーブル|コード",
        "cleaning": r"\b(?:clean|hygien|infect|germ|disinfect)|清掃|消毒|衛生|感染",
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
        return [self.graph.streams[i] for i in dict.fromkeys(s.output for s in self._starting)]

    @cached_property
    def _starting(self) -> list[Step]:
        """The active rows that let an actuator do something: a blank only stops it."""
        steps = [s for b in self.graph.behaviours for s in b.steps if s.active and s.connector.is_sink]
        known = [s for s in steps if s.output in self.graph.streams and self.graph.streams[s.output].device]
        return [s for s in known if s.ref not in self.facts or self.facts[s.ref].known.kind != BLANK]

    @cached_property
    def sensed(self) -> list[Stream]:
        """The sensor streams that active rows take in, each once."""
        steps = [s for b in self.graph.behaviours for s in b.steps if s.active]
        streams = [self.graph.streams[i] for i in dict.fromkeys(i for s in steps for i in s.inputs)]
        return [s for s in streams if s.kind is StreamKind.SENSOR and s.device is not None]

    @cached_property
    def parts(self) -> set[str]:
        """The parts of the robot that rows drive, such as `voice` and `left arm`."""
        return set[str]().union(*map(_parts_of, self.driven))

    @property
    def is_touched(self) -> bool:
        """True if rows read touches of the robot."""
        return any(s.device and s.device.type.name in ("Touch", "Bumper", "ChestButton") for s in self.sensed)

    @property
    def buttons(self) -> list[str]:
        """The labels of the operator's buttons that rows take in."""
        mine = [s for s in self.sensed if s.device and s.device.type.is_button]
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
            "faces": self.looks_for_faces, "real": self.meets != SIMULATED,
            "undated": not _YEAR.search(self.workbook.protocol.text("Version")),
        }  # fmt: skip
        return [field.name for field in FIELDS.values() if conditions.get(field.asked)]

    def missing_fields(self) -> list[str]:
        """Return the names of the fields that a board asks for and that are blank or not there."""
        return [name for name in self.asked_fields() if not self.workbook.protocol.text(name)]

    def proposed_risks(self) -> list[ProposedRisk]:
        """Return the risks that the rows bring, as they are proposed for the sheet Risks."""
        found = {kind: getattr(self, f"_{kind}")() for kind in _NAMES
                 if not (kind in _BODILY and self.meets == SIMULATED)}  # fmt: skip
        return [ProposedRisk(kind, _NAMES[kind], texts) for kind, texts in found.items() if texts is not None]

    def unnamed_risks(self) -> list[ProposedRisk]:
        """Return the proposed risks that no row of the sheet Risks names; all of them when there is no such sheet."""
        rows = self.workbook.risks.rows if self.workbook.risks else ()
        named = [row.risk.text.casefold() for row in rows]
        return [risk for risk in self.proposed_risks() if not any(_NAMED[risk.kind].search(text) for text in named)]

    def task_risks(self) -> list[RiskRow]:
        """Return the rows of the sheet Risks besides those that name the proposed risks, each by its first."""
        rows = [row for row in self.workbook.risks.rows if row.risk] if self.workbook.risks else []
        named = {next((i for i, row in enumerate(rows) if _NAMED[r.kind].search(row.risk.text.casefold())), -1)
                 for r in self.proposed_risks()}  # fmt: skip
        return [row for i, row in enumerate(rows) if i not in named]

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
        limit = (
            N_("The volume is {volume:g} % at most.", volume=volume) if volume < 100
            else N_("The rows use the full volume (100 %). Set a lower one in the sheet Devices.")
        )  # fmt: skip
        return (
            N_("Startled by the robot's voice or by a sound"), self._whom,
            N_("Possible, most of all at the first sentence or sound"),
            sentences(limit, N_("The voice should be heard once at this volume before the session begins.")),
            N_("The operator presses Stop when somebody covers the ears, cries or wants to leave."),
        )  # fmt: skip

    def _pinching(self) -> Texts | None:
        if not self.parts & {*_BOTH_ARMS, "head"}:
            return None
        likely = (
            N_("Possible: people touch the robot, and it moves then") if self.is_touched
            else N_("Possible when somebody is near the robot or touches it while it moves")
        )  # fmt: skip
        moving = dict[str, list[str]]()
        for step in self._starting:
            if _parts_of(self.graph.streams[step.output]) & _BOTH_ARMS:
                moving.setdefault(step.ref.rpartition("!")[0], []).append(str(step.number))
        rows = "; ".join(f"{behaviour} {', '.join(numbers)}" for behaviour, numbers in moving.items())
        reduces = (
            N_("The robot asks to be touched, and these rows move its arms: {rows}. So nobody can stay out of the "
               "reach of its arms. State another measure.", rows=rows) if self.is_touched and moving
            else N_("Everybody but one trained adult should stay out of the reach of its arms while it moves.")
        )  # fmt: skip
        return (
            N_("Fingers pinched between moving parts, or a knock from an arm or the head"), self._whom, likely, reduces,
            N_("The person beside the participant says “stop”, and the operator presses Stop, when a hand is near a "
               "moving part."),
        )  # fmt: skip

    def _falling(self) -> Texts | None:
        if "legs" not in self.parts and not self.is_touched:
            return None
        likely = (
            N_("Possible: people touch the robot, and a push can tip it over") if self.is_touched
            else N_("Possible when it stands, changes its posture or walks")
        )  # fmt: skip
        return (
            N_("The robot falls on somebody, or off the table"), N_("Everybody near the robot"), likely,
            N_("The robot should be on the floor, or on a wide and level surface. Only one trained adult should be "
               "within its reach. Rehearsals in the simulator do not show whether a real robot keeps its balance."),
            N_("When it falls, everybody steps back, the operator presses Stop, and the trained adult ends the "
               "session. Nobody lifts the robot before it is still."),
        )  # fmt: skip

    def _walking(self) -> Texts | None:
        if not any(s.device and "forward" in s.device.type.settings for s in self.driven):
            return None
        return (
            N_("The robot walks into somebody, or somebody trips over it"), N_("Everybody near the robot"),
            N_("Possible"),
            N_("The area in which it walks should be marked and kept free. The simulated robot stops before a thing in "
               "its way; whether the real one does should be tried before the study."),
            N_("The operator presses Stop when somebody enters the marked area."),
        )  # fmt: skip

    def _lights(self) -> Texts | None:
        if "eyes" not in self.parts:
            return None
        return (
            N_("Discomfort or a seizure from flashing eye lights"), N_("People with photosensitive epilepsy"),
            N_("Possible when the lights change 3 times a second or more"),
            N_("People should be asked about epilepsy before the session, and the lights should not flash."),
            N_("The operator presses Stop when somebody turns away from the lights or feels unwell."),
        )  # fmt: skip

    def _attachment(self) -> Texts | None:
        if not ("voice" in self.parts or self.looks_for_faces or self.parts & _BOTH_ARMS):
            return None
        return (
            N_("Attachment to the robot, and sadness when it is gone"), self._whom,
            N_("Possible after several sessions"),
            N_("Everybody should learn at the start that the robot is a machine and how many sessions there are. The "
               "last session should end with a goodbye."),
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
            N_("People should be told before the session that a person controls parts of it. If they are told only "
               "afterwards, they should be able to have their data deleted."),
            N_("The investigator ends the session and tells the truth when somebody feels tricked."),
        )  # fmt: skip

    def _distress(self) -> Texts | None:
        if not self.driven:
            return None
        likely = N_("Possible, most of all in the first minutes")
        if self.has_children:
            return (
                N_("Distress of the child: fear of the robot, too much at once, or frustration"), self._whom, likely,
                N_("A person whom the child knows should sit beside it. The robot should be shown at rest before it "
                   "moves."),
                N_("The accompanying person or the operator ends the session at the first sign of dissent, without "
                   "asking for a reason."),
            )  # fmt: skip
        return (
            N_("Distress: fear of the robot, or frustration"), self._whom, likely,
            N_("The robot should be shown at rest before it moves. Everybody should know how to stop it."),
            N_("The operator ends the session when the participant asks for it or looks distressed."),
        )  # fmt: skip

    def _tiredness(self) -> Texts | None:
        if not self.driven:
            return None
        return (
            N_("Tiredness or boredom"), self._whom, N_("Possible, most of all near the end of a session"),
            N_("Sessions should be short and have breaks, and nobody should be urged to go on."),
            N_("The operator ends the session when the participant no longer looks or answers."),
        )  # fmt: skip

    def _privacy(self) -> Texts | None:
        private = {"words", "camera", "faces"} & {*kept_kinds(self.robot, self.graph, self.run)}
        if not self.driven and not private:
            return None
        return (
            N_("A loss of privacy: somebody sees recordings who should not, and finds out whose they are"),
            N_("Everybody who is recorded, the operator too"), N_("Not known: it depends on who can open the files"),
            N_("Recordings have codes instead of names. The disk should be encrypted, few people should have access, "
               "and the recordings should be deleted on a planned day."),
            N_("The investigator ends the session, and tells the board, when recordings are lost or seen by others."),
        )  # fmt: skip

    def _power(self) -> Texts | None:
        if not any(map(touches_chest, self.sensed)):
            return None
        return (
            N_("Somebody switches the robot off by the button on its chest, and it sinks down or falls"),
            N_("Everybody near the robot"), N_("Possible: rows read touches of the chest"),
            N_("The chest button of a NAO is its power button too: two presses make its joints limp, a long press "
               "switches it off (see its manual). Rows should ask for a touch at another place."),
            N_("The operator presses Stop when a hand stays on its chest, and everybody else steps back."),
        )  # fmt: skip

    def _battery(self) -> Texts | None:
        if not self.driven:
            return None
        return (
            N_("Heat or fire of the battery, hot motors, or a fall over the cable of the charger"),
            N_("Everybody near the robot"),
            N_("Not known: this program knows nothing about battery, charger and motors"),
            N_("The robot should run without its charger, and be charged elsewhere, as its manual says. It should rest "
               "when its joints are warm."),
            N_("The operator ends the session when the robot is hot, smells or warns of its battery."),
        )  # fmt: skip

    def _cleaning(self) -> Texts | None:
        if not self.is_touched:
            return None
        return (
            N_("Infection, as one participant after another touches the robot"), self._whom, N_("Possible"),
            N_("The robot should be cleaned after each participant, as its manual says, and hands should be washed."),
            N_("The investigator calls the session off when somebody is ill."),
        )  # fmt: skip


def _parts_of(stream: Stream) -> frozenset[str]:
    """Return the parts of the robot that an actuator stream uses."""
    used = stream.device.type.resources_for(stream.settings) if stream.device else frozenset[str]()
    return used | _BOTH_ARMS if stream.settings.get("gestures") is True else used  # they go with what it says


def touches_chest(stream: Stream) -> bool:
    """Return whether a sensor stream gives touches of the chest, alone or among others."""
    zone = str(stream.settings.get("zone") or "chest").casefold()
    shows = stream.device.type.shows if stream.device else ()
    return "touch chest" in shows or ("touch {zone}" in shows and zone == "chest")


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
