"""The lessons of the tutorial: their texts, and what each step writes into the sheet.

The tutorial's workbook has a heading row and a test for each lesson; the panel beside its sheets says the rest
from here.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache

from rrp_sheets.texts import N_, LazyMessage, translate

_HEADING = re.compile(r"\D+\d+")


@dataclass(frozen=True, slots=True)
class TutorialStep:
    """Step of a lesson: its text, and the cells that it writes.

    Attributes:
        text: with places for the cells, by the kind of the column, and for the heading of the lesson.
        cells: the texts by the kind of the column, as in `workbook/schema.py`; `on` with TRUE ticks the row.
        row: the row below the lesson's heading, from 1, headings left out.
        of: the number of the lesson that the row stands under; 0 for the step's own.
    """

    text: str
    cells: Mapping[str, str] = field(default_factory=dict)
    row: int = 1
    of: int = 0


@dataclass(frozen=True, slots=True)
class TutorialLesson:
    """Lesson: the name of its test, which passes when it is done, its title, its aim in a sentence, and its steps."""

    test: str
    title: str
    about: str
    steps: tuple[TutorialStep, ...]

    def said(self, step: TutorialStep) -> str:
        """Return the text of a step with the words that it writes."""
        heading = _HEADING.match(self.test)
        return LazyMessage(step.text, lesson=heading[0] if heading else self.test, **step.cells)


LESSONS = (
    TutorialLesson(
        "Lesson 1 Hello", N_("Say hello"), N_("When the child says hello, the robot answers."), (
            TutorialStep(N_("Click the empty row under “{lesson}”, column B. "
                            "Type `{inputs}`: it is what the robot listens to."),
                         {"inputs": "Hello heard"}),
            TutorialStep(N_("Press Tab. Type `{connector}`: this connector lets the robot act."),
                         {"connector": "subscribe"}),
            TutorialStep(N_("Press Tab. Type `{formula}` with the quotes: a formula has text in quotes."),
                         {"formula": '"Hello!"'}),
            TutorialStep(N_("Press Tab. Type `{output}`, the robot’s voice. Press Enter."), {"output": "Say"}),
        ),
    ),
    TutorialLesson(
        "Lesson 2 Near", N_("Near"), N_("Only a ball nearer than half a metre turns the eyes red."), (
            TutorialStep(N_("A filter lets through only what fits its formula. Click the formula of the row with "
                            "`filter`, press F2 and change `5` to `0.5`. Press Enter."),
                         {"formula": "redBall.distance < 0.5"}),
        ),
    ),
    TutorialLesson(
        "Lesson 3 Name it", N_("Name it"), N_("The robot says where it is touched."), (
            TutorialStep(N_('A map calculates a new value from the one that came. Click `"?"` in the row with `map` '
                            'and type `{formula}`: `&` joins texts. Press Enter.'),
                         {"formula": '"That is my " & touched.zone'}, row=2),
        ),
    ),
    TutorialLesson(
        "Lesson 4 Slip", N_("Fix a slip"), N_("The second row is off, and a name in it is misspelled."), (
            TutorialStep(N_("Tick the box in column A of the second row. The misspelled name gets a red mark."),
                         {"on": "TRUE", "inputs": "Pressed"}, row=2),
            TutorialStep(N_("Click the cell with the red mark and choose “Apply fix”."), {"output": "Say"}, row=2),
        ),
    ),
    TutorialLesson(
        "Lesson 5 Wave", N_("Wave"),
        N_("The robot waves when the child says hello. It should also wave at its chest button."), (
            TutorialStep(N_("In the first row, column B, type `{inputs}`: two input streams."),
                         {"inputs": "Hello heard, Pressed"}),
            TutorialStep(N_("In column C, type `{connector}`: it makes one stream of two. Press Enter."),
                         {"connector": "merge"}),
        ),
    ),
    TutorialLesson(
        "Lesson 6 Together", N_("Together"), N_("When the two balls are side by side, the robot says so."), (
            TutorialStep(N_("A map acts only on events of its first stream. Click `map` in the row with the long "
                            "formula and type `{connector}`: now an event of either ball counts. Press Enter."),
                         {"connector": "combineLatest"}, row=2),
        ),
    ),
    TutorialLesson(
        "Lesson 7 Forget", N_("Forget"), N_("A red ball that was not seen for a second is forgotten."), (
            TutorialStep(N_("The row with `forgetAfter` in lesson 6 remembers the ball for an hour. Change its formula "
                            "`1 h` to `1 s`. Press Enter."), {"formula": "1 s"}, of=6),
        ),
    ),
    TutorialLesson(
        "Lesson 8 Silence", N_("Silence"), N_("Ten seconds after the last touch, the robot wants to play."), (
            TutorialStep(N_("In the first empty row, type `{inputs}`, `{connector}`, `{formula}` and `{output}`, "
                            "each followed by Tab."),
                         {"inputs": "Touched", "connector": "timeout", "formula": "10 s", "output": "Quiet"}),
            TutorialStep(N_("In the row below, type `{inputs}`, `{connector}`, `{formula}` and `{output}`."),
                         {"inputs": "Quiet", "connector": "subscribe", "formula": '"Shall we play?"', "output": "Say"},
                         row=2),
        ),
    ),
    TutorialLesson(
        "Lesson 9 Calm", N_("Calm"), N_("The camera sees the ball ten times a second. The robot speaks of it once."), (
            TutorialStep(N_("Tick the box in column A of both rows."), {"on": "TRUE", "inputs": "Close ball"}),
            TutorialStep(N_("Click `subscribe` in the second row. Choose the first “Apply fix”: `throttle` lets "
                            "one event through in a while."), {"connector": "throttle"}, row=2),
        ),
    ),
    TutorialLesson(
        "Lesson 10 Cheer", N_("Cheer"), N_("After three touches, the robot throws up its arms and cheers."), (
            TutorialStep(N_("In the first empty row, type `{inputs}`, `{connector}`, nothing and `{output}`: it "
                            "counts."),
                         {"inputs": "Touched", "connector": "accumulate", "output": "Touches"}),
            TutorialStep(N_("In the next row, type `{inputs}`, `{connector}`, `{formula}` and `{output}`."),
                         {"inputs": "Touches", "connector": "filter", "formula": "touches = 3", "output": "Three"},
                         row=2),
            TutorialStep(N_("In the next row, type `{inputs}`, `{connector}`, `{formula}` and `{output}`."),
                         {"inputs": "Three", "connector": "subscribe", "formula": '"Arms up"', "output": "Gesture"},
                         row=3),
            TutorialStep(N_("In the last row, type `{inputs}`, `{connector}`, `{formula}` and `{output}`."),
                         {"inputs": "Three", "connector": "subscribe", "formula": '"Hooray, three touches!"',
                          "output": "Say"}, row=4),
        ),
    ),
)  # fmt: skip
MOST_STEPS = 5
_JAPANESE = {
    "Hello heard": "呼びかけ", '"Hello!"': '"こんにちは！"', "Say": "話す", "Gesture": "身ぶり", "Pressed": "押された",
    "redBall.distance < 0.5": "赤いボール.distance < 0.5", "Hello heard, Pressed": "呼びかけ, 押された",
    '"That is my " & touched.zone': '"ここは" & 場所', "Touched": "触られた", "Quiet": "静か",
    '"Shall we play?"': '"いっしょに遊ぼう。"', "Close ball": "近いボール", "Touches": "接触の回数",
    "touches = 3": "接触の回数 = 3", "Three": "三回", '"Arms up"': '"両腕を上げる"',
    '"Hooray, three touches!"': '"やった、3回！"',
}  # fmt: skip
"""The texts of cells in the Japanese workbook; others are the same."""


def _in_japanese(number: int, lesson: TutorialLesson) -> TutorialLesson:
    cells = ({kind: _JAPANESE.get(text, text) for kind, text in step.cells.items()} for step in lesson.steps)
    steps = tuple(replace(step, cells=own) for step, own in zip(lesson.steps, cells, strict=True))
    return replace(lesson, test=f"レッスン{number} {translate(lesson.title, 'ja')}", steps=steps)


@cache
def japanese_lessons() -> tuple[TutorialLesson, ...]:
    """Return the same lessons with the words of the Japanese workbook."""
    return tuple(_in_japanese(number, lesson) for number, lesson in enumerate(LESSONS, 1))


def lesson_of(test: str) -> TutorialLesson | None:
    """Return the lesson that a test belongs to, with the words of its workbook; None for any other test.

    >>> lesson_of("Lesson 3 Name it").title
    'Name it'
    """
    return next((lesson for lesson in (*LESSONS, *japanese_lessons()) if lesson.test == test), None)
