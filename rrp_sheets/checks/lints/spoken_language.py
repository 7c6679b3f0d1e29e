"""LINT018: texts in letters that the voice of their language does not read: `こんにちは` in English."""

from __future__ import annotations

import re
from collections.abc import Sequence

from rrp_sheets.checks.lints.context import LintContext, row_key
from rrp_sheets.checks.speech_texts import OPEN, SpeechTexts
from rrp_sheets.diagnostics.report import Fix
from rrp_sheets.graph import Step, Stream
from rrp_sheets.graph.device_table import setting_edits
from rrp_sheets.model.japanese import KANA, LETTERS
from rrp_sheets.model.names import key
from rrp_sheets.model.workbook import Address
from rrp_sheets.texts import N_

JAPANESE, ENGLISH = "ja", "en"
_CHINESE = ("cmn", "zh", "yue", "hak")
_LATIN = re.compile("[A-Za-z\u00c0-\u024f]{2,}")
_SEVERAL = 3  # Latin words: one or two may be a name
_LONGEST = 60  # letters of a text that are shown
_MOST = 20  # rows of one stream that are told
_LETTERS = {JAPANESE: N_("Japanese letters"), ENGLISH: N_("Latin letters")}


def lint_spoken_language(context: LintContext) -> None:
    """Report streams that say texts of another language than theirs, each at the first row that does so."""
    speech = SpeechTexts(context.graph, context.compiled.formulas, context.compiled.facts)
    wrong = {row_key(d.address) for d in context.report if d.address}
    unclear = {key(d.stream.text) for d in context.workbook.devices if row_key(d.stream.address) in wrong}
    said: dict[str, list[tuple[Step, list[str]]]] = {}
    for step in context.steps():
        stream = context.graph.streams[step.output]
        if key(stream.name) in unclear:
            continue  # its language may be what is wrong
        if step.connector.is_sink and stream.device is not None and "language" in stream.settings:
            is_fixed = "text" in stream.settings
            texts = [str(stream.settings["text"] or "")] if is_fixed else speech.texts_of(step)
            said.setdefault(stream.id, []).append((step, texts))
    for name, rows in said.items():
        _tell(context.graph.streams[name], rows, speech, context)


def language_of_text(text: str, voice: str) -> str:
    """Return the code of the language in which a text should be said instead of the voice's; empty for none.

    >>> language_of_text("赤いボールです", "en"), language_of_text("Well done, my friend", "ja")
    ('ja', 'en')
    >>> language_of_text("NAO", "ja"), language_of_text("你好", "cmn"), language_of_text("赤は red です", "ja")
    ('', '', '')
    """
    text, base = OPEN.sub(" ", text), voice.partition("-")[0]
    if base == JAPANESE:
        strange = len(_LATIN.findall(text)) >= _SEVERAL and not LETTERS.search(text)
        return ENGLISH if strange else ""
    return JAPANESE if KANA.search(text) or (LETTERS.search(text) and base not in _CHINESE) else ""


def _tell(
    stream: Stream, said: Sequence[tuple[Step, list[str]]], speech: SpeechTexts, context: LintContext
) -> None:  # fmt: skip
    voice = str(stream.settings["language"])
    each = ((step, next((text for text in texts if language_of_text(text, voice)), "")) for step, texts in said)
    wrong = [(step, text) for step, text in each if text]
    if not wrong:
        return
    other = language_of_text(wrong[0][1], voice)
    mixed = any(language_of_text(text, other) for _, texts in said for text in texts)
    languages = context.robot.languages
    spoken = N_(languages.get(voice, voice), msgctxt="value")
    remedy = N_("Set the Language of “{stream}” to {code} in the sheet Devices, or write the text in {spoken}.",
                stream=stream.name, code=other, spoken=spoken)  # fmt: skip
    if mixed:
        remedy = N_("Let another stream, with the Language {code} in the sheet Devices, say it, or write the text in "
                    "{spoken}.", code=other, spoken=spoken)  # fmt: skip
    named = stream.device.name if stream.device else ""
    edits, _ = setting_edits(context.workbook, stream.name, named, "Language", other)
    title = N_("Let “{stream}” speak {language}", stream=stream.name,
               language=N_(languages.get(other, other), msgctxt="value"))  # fmt: skip
    fixes = [Fix("other-language", title, edits)] if edits and not mixed else []
    for step, whole in wrong[: _MOST if mixed else 1]:
        text = OPEN.sub(" ", whole).strip()
        text = text if len(text) <= _LONGEST else f"{text[:_LONGEST]}…"
        place = _text_cell(stream, context) or speech.cell_of(step, whole)
        context.report.add(
            "LINT018", place, fixes=fixes, text=text,
            letters=_LETTERS[other], stream=stream.name, spoken=spoken, remedy=remedy,
        )  # fmt: skip


def _text_cell(stream: Stream, context: LintContext) -> Address | None:
    devices = (d for d in context.workbook.devices if key(d.stream.text) == key(stream.name))
    return next((cell.address for d in devices if (cell := d.settings.get("text"))), None)
