"""What devices work with beside the rows: words that can be heard, files that can be played."""

from __future__ import annotations

import unicodedata
from pathlib import Path

from rrp_sheets.devices import Robot
from rrp_sheets.devices.sound_files import SUFFIX, BadSoundError, is_plain, look_at
from rrp_sheets.diagnostics import Report
from rrp_sheets.diagnostics.phrase import Phrase
from rrp_sheets.graph.settings import divided_phrase, doubtful_phrase, understand
from rrp_sheets.model.cells import Cell
from rrp_sheets.model.names import nearest
from rrp_sheets.model.workbook import Workbook

_ELSE = "Put it there, or leave the cell blank and choose a Sound."


def check_device_material(workbook: Workbook, robot: Robot, folder: Path, report: Report) -> None:
    """Warn of words that are not English ones, and of sound files that cannot be played.

    Args:
        workbook: as it was read.
        robot: whose devices it uses.
        folder: where the workbook's files are.
        report: takes the findings.
    """
    for device in workbook.devices:
        found = robot.find(device.device.text)
        for k, cell in device.settings.items() if found else ():
            setting = found.type.settings.get(k) if found else None
            if setting is None or not cell:
                continue
            if setting.kind == "words":
                words, wrong = understand(setting, cell.text, robot)
                word = next((w for w in words or () if not can_be_heard(w)), None)
                if word is not None and not wrong:
                    report.add("DEV011", cell.address, word=word)
                if (phrase := doubtful_phrase(cell.text)) and not wrong:
                    report.add("DEV013", cell.address, phrase=phrase)
                whole, count = divided_phrase(cell.text)
                if whole and not wrong:
                    report.add("DEV014", cell.address, phrase=whole, count=count)
            elif setting.kind == "sound file":
                _check_sound(cell, folder, report)


def can_be_heard(word: str) -> bool:
    """Whether a word is written as English is: Latin letters and digits, with signs between them.

    >>> [can_be_heard(w) for w in ("yes", "x-ray", "café", "7 up", "はい", "да", "?")]
    [True, True, True, True, False, False, False]
    """
    spoken = [c for c in unicodedata.normalize("NFKC", word) if c.isalnum()]
    return bool(spoken) and all(c in "0123456789" or unicodedata.name(c, "").startswith("LATIN ") for c in spoken)


def _check_sound(cell: Cell, folder: Path, report: Report) -> None:
    name = cell.text.strip()
    if not is_plain(name):  # told as a setting that is not understood
        return
    try:
        look_at(folder, name)
    except BadSoundError as problem:
        remedy = _ELSE
        if not (folder / name).is_file():
            guess = nearest(name, _sounds_in(folder))
            remedy = Phrase("Did you mean {guess}?", guess=guess) if guess else _ELSE
        report.add("DEV012", cell.address, name=name, problem=problem, remedy=remedy)


def _sounds_in(folder: Path) -> list[str]:
    try:
        return [p.name for p in sorted(folder.iterdir())[:1_000] if p.suffix.casefold() == SUFFIX]
    except OSError:
        return []
