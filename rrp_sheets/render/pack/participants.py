"""The information sheet for participants: one page in plain language, from whole sentences about each device."""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import asdict, dataclass

from rrp_sheets.checks import Checked
from rrp_sheets.checks.ethics import REAL, SIMULATED
from rrp_sheets.checks.protocol import kept_kinds
from rrp_sheets.render.pack import acts, people
from rrp_sheets.render.pack.front import Print
from rrp_sheets.render.pack.make import Paper
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.pack.study import field_label
from rrp_sheets.render.sentences import Rows
from rrp_sheets.render.style import clean, shortened, typeset
from rrp_sheets.render.texts import texts
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading

BLANK = "_" * 12  # to be filled in by hand
LONGEST = 120  # columns of a field: two lines
MOST_READ_ALOUD = 8  # years: younger children do not read it by themselves
_AGES = re.compile(r"(\d{1,2})(?:\s*(?:to|and|or|から|[-–〜～])\s*\d{1,2})?\s*(?:years|歳)", re.IGNORECASE)
_STAFF = re.compile(r"\s*(?:the )?(?:operator|researcher|investigator|staff|操作者|研究者|スタッフ)", re.IGNORECASE)
_NOTHING = re.compile(r"\s*(?:nothing|none|no\b|なし|ありません|隠しません|何も)", re.IGNORECASE)
_SENSORS = {
    "RedBall": "balls", "GreenBall": "balls", "BlueBall": "balls", "Ball": "balls", "Blob": "colours",
    "FaceDetection": "faces", "Touch": "touch", "Bumper": "bumps", "ChestButton": "chest", "Sonar": "distance",
    "WordRecognized": "words", "JointPosition": "", "OperatorButton": "", "Orientation": "", "Timer": "",
}  # fmt: skip
"""The sentence about each sensor of the catalogue; empty for one that senses nothing of a person."""


@dataclass(frozen=True)
class SheetPart:
    """A heading of the sheet, a question or a statement, and the sentences below it."""

    title: str
    sentences: tuple[str, ...]


@dataclass(frozen=True)
class ParticipantSheet:
    """Contents of the information sheet; `notes` are for the person who prints it.

    Attributes:
        intro: who the robot is; stands beside its `picture`, an SVG text or empty.
        study: the title of the study; `agree`, `mark` and `date`: what a participant fills in; not on a draft.
        aloud: that it is read to a child, or empty; `status`: that it is a draft, or empty.
        foot: version, day and the first digits of the workbook's SHA-256.
    """

    language: str
    title: str
    study: str
    aloud: str
    agree: str
    mark: str
    date: str
    intro: SheetPart
    picture: str
    alt: str
    parts: tuple[SheetPart, ...]
    status: str
    foot: str
    notes: tuple[str, ...]


def make_sheet(
    reading: Reading, checked: Checked, this: Print, *, language: str = "en", draft: bool = False
) -> ParticipantSheet:
    """Make the information sheet of a checked workbook, in a language."""
    words = texts(language)
    source = Source(reading, checked, words, Rows(checked.graph, checked.workbook, words))
    writer = _Writer(source)
    robot = clean(checked.robot.title)
    status = "draft" if draft or checked.report.errors else "draft_open" if writer.is_open() else ""
    ages = [int(age) for age in _AGES.findall(source.protocol("Participants"))]
    aloud = writer.study.has_children and min(ages, default=99) <= MOST_READ_ALOUD
    version = clean(source.protocol("Version"))
    foot = words.get("participants.foot" if version else "participants.foot_day", version=version, day=this.day)
    return ParticipantSheet(
        language=words.language, title=writer.say("title", robot=robot),
        study=shortened(clean(source.protocol("Title")), 60), aloud=writer.say("aloud") if aloud else "",
        agree=writer.say("agree_not" if status else "agree"),
        mark="" if status else writer.say("mark"), date="" if status else writer.say("date"),
        intro=writer.intro(robot), picture=_picture(checked),
        alt=writer.say("alt", robot=robot), parts=writer.parts(),
        status=writer.say(status) if status else "",
        foot=writer.say("foot_digest", foot=shortened(foot, 24), digest=reading.digest[:12]), notes=tuple(writer.notes),
    )  # fmt: skip


def set_sheet(sheet: ParticipantSheet, paper: Paper = "a4") -> tuple[bytes, list[str]]:
    """Return the sheet as a PDF of one page, and warnings in words; raises SheetsError as `typeset` does."""
    data = {"paper": {"a4": "a4", "letter": "us-letter"}[paper], "sheet": asdict(sheet)}
    made, notes = typeset("participants.typ", data, {"robot.svg": sheet.picture} if sheet.picture else {}, "pdf")
    return made, [*sheet.notes, *notes]


def _picture(checked: Checked) -> str:
    """Return the drawing of a robot that comes with the program; files beside a workbook are a stranger's."""
    robot = checked.robot
    path = bundled("templates", "print", "robots") / f"{robot.name}.svg"
    ours = robot.folder == bundled("robots", robot.name)
    return path.read_text(encoding="utf-8") if ours and path.is_file() else ""


class _Writer:
    """Chooses the sentences for one workbook; `notes` gather what the person who prints has to know."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.study = source.checked.study
        self.notes: list[str] = []

    def say(self, entry: str, /, **values: object) -> str:
        adult = f"participants.adult_{entry}"
        chosen = adult if self._are_adults and self.source.words.has(adult) else f"participants.{entry}"
        return self.source.words.get(chosen, **values)

    @property
    def _are_adults(self) -> bool:
        return bool(self.source.protocol("Participants")) and not (
            self.study.has_children or self.study.is_demonstration
        )

    def _part(self, name: str, entries: Iterable[str], *more: str) -> SheetPart:
        said = (self.say(f"{name}_{entry}") for entry in dict.fromkeys(entries))
        title = self.say(name)
        if name in ("stop", "choice") and self.is_open():
            title = self.say("confirm", text=title)
        return SheetPart(title, (*said, *filter(None, more)))

    def _stated(self, field: str, entry: str) -> str:
        """Return the sentence with a field of the Protocol sheet, or with a place to fill it in by hand.

        A field that is blank or too long gives a note.
        """
        text, name = clean(" ".join(self.source.protocol(field).split())), field_label(self.source, field)
        short = shortened(text, LONGEST)
        if not text and not self.study.is_demonstration:
            self.notes.append(N_("The page lacks the field {name}: fill it in.", name=name))
            return self.say(entry, text=BLANK)
        if short != text:
            self.notes.append(
                N_("The field {name} is too long for the page, which shows: {text}", name=name, text=short)
            )
        return self.say(entry, text=short.rstrip(".。")) if text else ""

    def is_open(self) -> bool:
        """Return whether the Protocol sheet does not state yet how one says no and stops, which the page promises."""
        return bool({"Consent and capacity", "Assent", "Dissent", "Withdrawal"} & {*self.study.missing_fields()})

    def intro(self, robot: str) -> SheetPart:
        """Say who the robot is, and where."""
        lines = [self.say("who_is", robot=robot), self.say("who_machine")]
        if not self.study.is_demonstration:
            lines += [self.say("who_research"), self._stated("Investigators", "who_we")]
        if self._are_adults:
            lines.append(self._stated("Purpose", "adult_who_purpose"))
        height = self.source.checked.robot.data["robot"].get("height")
        if self.study.meets == SIMULATED:
            lines.append(self.say("who_screen"))
        elif self.study.meets == REAL:
            lines.append(self.say("who_room"))
        elif not self.study.is_demonstration:
            self.notes.append(N_("The sheet does not say if the robot is real: fill in the field Robot in sessions."))
            lines.append(self.say("who_open"))
        if self.study.meets == REAL and isinstance(height, (int, float)):
            lines.append(self.say("who_high", cm=round(height * 100)))
        return SheetPart(self.say("who", robot=robot), tuple(lines))

    def parts(self) -> tuple[SheetPart, ...]:
        """Return the parts below the picture, in pairs beside one another."""
        sign = "" if self.study.is_demonstration else self.say("stop_sign", text=BLANK)
        made = [
            self._part("does", self._does()), self._sensed(),
            self._part("you", [], self._stated("What participants do", "you_task"),
                       *(self.say(f"you_{entry}") for entry in self._you()), *self._risks(),
                       self._stated("Sessions", "you_sessions")),
            self._part("stop", ("how",), sign, self.say("stop_at_once"),
                       self.say("stop_crouch") if self.study.meets == REAL else ""),
            self._part("choice", ("no", "later", "why", *(["parents"] if self.study.has_children else []))),
            self._part("keeps", self._keeps(), self._stated("Access", "keeps_who"),
                       self._stated("Retention", "keeps_long"), self._stated("Deletion", "keeps_after")),
        ]  # fmt: skip
        if self.study.buttons:
            if _hidden(self.source):
                self.notes.append(N_("The sheet does not say that a person controls the robot, as the field Reason for "
                                     "concealment gives a reason."))  # fmt: skip
            else:
                labels = self.source.quoted(clean(label) for label in self.study.buttons[:6])
                made.append(self._part("helper", ("person", "buttons"), self.say("helper_list", text=labels)))
        return (*made, self._questions())

    def _does(self) -> list[str]:
        moving = set(acts.moving_parts(self.source))
        kinds = {s.device.type.name for s in self.study.driven if s.device}
        says = any(acts.speaks(s) for s in self.study.driven)
        holds = {
            "talks": says, "sounds": "PlaySound" in kinds, "head": "head" in moving,
            "arms": bool({"left arm", "right arm"} & moving), "walks": bool(acts.walkers(self.source)),
            "legs": "legs" in moving and not acts.walkers(self.source), "eyes": "eyes" in self.study.parts,
        }  # fmt: skip
        return [entry for entry, true in holds.items() if true] or ["nothing"]

    def _sensed(self) -> SheetPart:
        """Say what a robot in the room senses; one on a screen senses nothing of a person."""
        entries = self._senses()
        if self.study.meets == REAL or self.study.is_demonstration:
            return self._part("senses", entries)
        if self.study.meets == SIMULATED:
            return self._part("senses", ["screen"])
        return self._part("senses", [], self.say("senses_open", text=BLANK))

    def _senses(self) -> list[str]:
        found: list[str] = []
        for stream in self.study.sensed:
            name = stream.device.type.name if stream.device else ""
            if name in _SENSORS:
                found += filter(None, [_SENSORS[name]])
            else:
                self.notes.append(N_("The sheet says nothing about the sensor {name}.", name=clean(stream.name)))
        channels = people.channels(self.source)
        if people.remembers_faces(self.source):
            found.append("learns_kept" if self.source.checked.run.keeps_faces else "learns_run")
        if "camera" not in channels:
            found.append("not_camera")
        if self.study.meets == REAL:
            found.append("live")
        if "microphone" not in channels:
            found.append("not_microphone")
        return found

    def _keeps(self) -> list[str]:
        real = self.study.meets == REAL or self.study.is_demonstration
        kinds = kept_kinds(self.source.checked.robot, self.source.checked.graph, self.source.checked.run)
        holds = {
            "touch": real and self.study.is_touched, "words": real and "words" in kinds,
            "no_voice": real and "words" in kinds, "camera": real and "camera" in kinds,
            "faces": real and "faces" in kinds, "film": "film" in kinds,
            "buttons": bool(self.study.buttons) and not _hidden(self.source),
        }  # fmt: skip
        return ["events", *(entry for entry, true in holds.items() if true), "code"]

    def _you(self) -> list[str]:
        real = self.study.meets == REAL
        holds = {
            "screen": self.study.meets == SIMULATED, "near": real, "touch": real and self.study.is_touched,
            "talk": real and "microphone" in people.channels(self.source),
            "hands": real and bool(acts.moving_parts(self.source)),
            "loud": any(acts.speaks(s) for s in self.study.driven), "hard": bool(self.study.driven),
        }  # fmt: skip
        return [entry for entry, true in holds.items() if true]

    def _risks(self) -> list[str]:
        """Say the risks for participants: those that the rows bring, then further ones of the sheet Risks."""
        words, study = self.source.words, self.study
        entries = (f"participants.risk_{risk.kind}" for risk in study.proposed_risks() if study.driven)
        known = [words.get(entry) for entry in entries if words.has(entry)]
        rows = [row for row in study.task_risks() if not _STAFF.match(row.whom.text)]
        own = words.listed([clean(row.risk.text).rstrip(".。") for row in rows], "or")
        said = {"you_risks": words.listed(known, "or"), "you_risks_too": shortened(own, LONGEST)}
        return [self.say(entry, text=text) for entry, text in said.items() if text]

    def _questions(self) -> SheetPart:
        return self._part("ask", ["us"], self._stated("Contact", "ask_contact"))


def _hidden(source: Source) -> bool:
    reason = source.protocol("Reason for concealment")
    return bool(reason) and not _NOTHING.match(reason)
