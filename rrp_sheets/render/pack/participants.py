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
from rrp_sheets.render.sentences import Rows
from rrp_sheets.render.style import clean, shortened, typeset
from rrp_sheets.render.texts import texts
from rrp_sheets.resources import bundled
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading

LONGEST_CONTACT = 120  # columns: two lines
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
        status: that it is a draft, or empty.
        foot: version and day.
    """

    language: str
    title: str
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
    status = words.get("participants.draft") if draft or checked.report.errors else ""
    version = clean(source.protocol("Version"))
    foot = words.get("participants.foot" if version else "participants.foot_day", version=version, day=this.day)
    return ParticipantSheet(
        language=words.language, title=writer.say("title", robot=robot), intro=writer.intro(robot),
        picture=_picture(checked), alt=writer.say("alt", robot=robot), parts=writer.parts(), status=status,
        foot=shortened(foot, 60), notes=tuple(writer.notes),
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
        return self.source.words.get(f"participants.{entry}", **values)

    def _part(self, name: str, entries: Iterable[str]) -> SheetPart:
        return SheetPart(self.say(name), tuple(self.say(f"{name}_{entry}") for entry in dict.fromkeys(entries)))

    def intro(self, robot: str) -> SheetPart:
        """Say who the robot is, and where."""
        lines = [self.say("who_is", robot=robot), self.say("who_machine")]
        height = self.source.checked.robot.data["robot"].get("height")
        if self.study.meets == SIMULATED:
            lines.append(self.say("who_screen"))
        elif self.study.meets == REAL:
            lines.append(self.say("who_room"))
        elif not self.study.is_demonstration:
            self.notes.append(N_("The sheet does not say if the robot is real: fill in the field Robot in sessions."))
        if self.study.meets == REAL and isinstance(height, (int, float)):
            lines.append(self.say("who_high", cm=round(height * 100)))
        return SheetPart(self.say("who", robot=robot), tuple(lines))

    def parts(self) -> tuple[SheetPart, ...]:
        """Return the parts below the picture, in pairs beside one another."""
        made = [
            self._part("does", self._does()), self._part("senses", self._senses()),
            self._part("stop", ("how", "at_once")), self._part("choice", ("no", "later", "why")),
            self._part("keeps", self._keeps()),
        ]  # fmt: skip
        if self.study.buttons:
            if _hidden(self.source):
                self.notes.append(N_("The sheet does not say that a person controls the robot, as the field Reason for "
                                     "concealment gives a reason."))  # fmt: skip
            else:
                made.append(self._part("helper", ("person", "buttons")))
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
        if "microphone" not in channels:
            found.append("not_microphone")
        return found

    def _keeps(self) -> list[str]:
        kinds = kept_kinds(self.source.checked.robot, self.source.checked.graph, self.source.checked.run)
        entries = [kind for kind in ("events", "words", "camera", "faces") if kind in kinds]
        film = [] if "film" not in kinds else ["film_screen"] if self.study.meets == SIMULATED else ["film"]
        return [*entries, *film, "code"]

    def _questions(self) -> SheetPart:
        contact = " ".join(self.source.protocol("Contact").split())
        if not contact:
            self.notes.append(N_("The sheet names nobody to ask: fill in the field Contact."))
        elif (short := shortened(clean(contact), LONGEST_CONTACT)) != contact:
            self.notes.append(N_("The field Contact is too long for the sheet, which shows: {text}", text=short))
        lines = [self.say("ask_us")]
        if contact:
            lines.append(self.say("ask_contact", contact=shortened(clean(contact), LONGEST_CONTACT)))
        return SheetPart(self.say("ask"), tuple(lines))


def _hidden(source: Source) -> bool:
    reason = source.protocol("Reason for concealment")
    return bool(reason) and not _NOTHING.match(reason)
