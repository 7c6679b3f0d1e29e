"""The robot's voice: one sentence or sound at a time; real audio, kept as .wav files.

Speech is made with espeak-ng, through its C library that comes with `espeakng-loader`.
"""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from rrp_sheets.model.exchange import Command, Notice
from rrp_sheets.model.values import Value
from rrp_sheets.sim.arbitration import Tell
from rrp_sheets.sim.sounds import Audio, louder, write_wave
from rrp_sheets.texts import N_

GUESSED_WORD_LENGTH = 6  # characters, with the space: for the duration when there is no speech library
FALLBACK = "en"
NO_SPEECH = N_("There is no sound: the package espeakng-loader is not installed. Durations are estimated.")
LONGEST = 2_000  # letters that are spoken of one text: two or three minutes
# Numbers of the C interface (espeak-ng's speak_lib.h).
_SYNCHRONOUS = 2
_RATE, _VOLUME, _PITCH = 1, 2, 3
_USUAL_PITCH = 50
_UTF8 = 1
_BY_CHARACTER = 1
_IPA = 2
_OK = 0
_ABORT = 1
_UNSPEAKABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff]")  # the library stops at the first, or refuses them


class NoSpeech(Exception):
    """Raised when the speech library cannot be loaded."""


@cache
def espeak() -> Espeak:
    """The speech library of this process. It must not be started twice: that frees the sounds of the voice in use.

    Raises:
        NoSpeech: it is not there.
    """
    return Espeak()


class Espeak:
    """The speech library; `espeak()` gives the one of this process."""

    def __init__(self) -> None:
        try:
            import espeakng_loader

            self._lib: Any = ctypes.CDLL(espeakng_loader.get_library_path())
            data = espeakng_loader.get_data_path()
        except (ImportError, OSError) as error:
            raise NoSpeech(str(error)) from error
        self.rate: int = self._lib.espeak_Initialize(_SYNCHRONOUS, 0, str(data).encode(), 0)
        if self.rate <= 0:
            raise NoSpeech("the speech library did not start")
        self._parts: list[Audio] = []
        self._halted: Callable[[], bool] = lambda: False
        kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)

        def take(wave: Any, count: int, _events: Any) -> int:
            if count > 0 and wave:
                self._parts.append(np.ctypeslib.as_array(wave, shape=(count,)).copy())
            return _ABORT if self._halted() else 0

        self._callback: Callable[..., int] = kind(take)  # kept alive as long as the library may call it
        self._lib.espeak_SetSynthCallback(self._callback)
        self._lib.espeak_TextToPhonemes.restype = ctypes.c_char_p

    def voice(self, name: str) -> bool:
        """Choose a language (`de`) or a voice of it (`en-us+f2`); False when there is none of that name."""
        return bool(self._lib.espeak_SetVoiceByName(name.encode("utf-8", "replace")) == _OK)

    def say(
        self,
        text: str,
        words_a_minute: float,
        volume: float,
        pitch: int = _USUAL_PITCH,
        halted: Callable[[], bool] = lambda: False,
    ) -> Audio:
        """Return the audio of a text, of which at most `LONGEST` letters are spoken.

        Args:
            text: in the language of the chosen voice.
            words_a_minute: the speed.
            volume: in percent.
            pitch: 0 to 100.
            halted: called after each 0.2 s of audio; when it returns True, the rest is left out.
        """
        self._halted = halted
        self._lib.espeak_SetParameter(_RATE, round(words_a_minute), 0)
        self._lib.espeak_SetParameter(_VOLUME, round(volume), 0)
        self._lib.espeak_SetParameter(_PITCH, pitch, 0)
        self._parts = []
        data = _UNSPEAKABLE.sub(" ", text[:LONGEST]).encode()
        self._lib.espeak_Synth(data, len(data) + 1, 0, _BY_CHARACTER, 0, _UTF8, None, None)
        self._lib.espeak_Synchronize()
        return np.concatenate(self._parts) if self._parts else np.zeros(0, np.int16)

    def phonemes(self, text: str) -> str:
        """Return the chosen voice's pronunciation of a text, in letters of the phonetic alphabet."""
        found = []
        rest = ctypes.c_char_p(_UNSPEAKABLE.sub(" ", text[:LONGEST]).encode())
        while rest.value:  # clause by clause
            found.append(self._lib.espeak_TextToPhonemes(ctypes.byref(rest), _UTF8, _IPA) or b"")
        return b" ".join(found).decode("utf-8", "replace")


class Speech:
    """The speech library that the robot and the persons share, loaded when somebody first speaks.

    Args:
        halted: whether the robot is to rest, so that no speech is wanted any more.
    """

    def __init__(self, tell: Tell, halted: Callable[[], bool] = lambda: False) -> None:
        self._tell = tell
        self.halted = halted
        self._library: Espeak | None = None
        self._missing = False

    def library(self, stream: str = "", row: str = "") -> Espeak | None:
        """Return the library; None when it is not installed, which is reported once, on a row."""
        if self._library is None and not self._missing:
            try:
                self._library = espeak()
            except NoSpeech:
                self._missing = True
                self._tell(Notice("error", NO_SPEECH, stream, row))
        return self._library


@dataclass
class Sounding:
    """Sentence, or sound by its name, that is played for a command."""

    text: str
    order: Command
    spoken: bool
    start_us: int = 0
    end_us: int = 0
    audio: Audio | None = None
    rate: int = 0
    file: Path | None = None


class Voice:
    """Speaks sentences and plays sounds; their duration comes from the audio. Without a folder it keeps no files."""

    def __init__(self, out: Path | None, tell: Tell, speech: Speech) -> None:
        self._out = out
        self._tell = tell
        self._speech = speech
        self._now: Sounding | None = None
        self._counts = {"say": 0, "sound": 0}

    @property
    def saying(self) -> str:
        """The sentence being spoken, or empty."""
        return self._now.text if self._now and self._now.spoken else ""

    @property
    def is_playing(self) -> bool:
        """True while a sound is played."""
        return self._now is not None and not self._now.spoken

    def say(self, text: str, order: Command, settings: Mapping[str, Value], us: int) -> None:
        """Begin a sentence."""
        self._now = Sounding(text, order, True)
        if len(text) > LONGEST:
            told = N_("Only the first {n:,} of {of:,} letters are said.", n=LONGEST, of=len(text))
            self._tell(Notice("clamp", told, order.stream, order.row))
        speed = float(settings["speed"])
        library = self._speech.library(order.stream, order.row)
        if library is None:
            self._begin(self._now, us, len(text[:LONGEST]) / GUESSED_WORD_LENGTH / speed * 60)
            return
        language = str(settings["language"] or FALLBACK).strip().casefold().replace("_", "-")
        if not library.voice(language):
            library.voice(FALLBACK)
            told = N_("There is no voice for the language “{language}”; it is spoken in English.", language=language)
            self._tell(Notice("error", told, order.stream, order.row))
        self._now.audio = library.say(text, speed, float(settings["volume"]), halted=self._speech.halted)
        self._now.rate = library.rate
        self._begin(self._now, us)

    def play(self, name: str, audio: Audio, rate: int, volume: float, order: Command, us: int) -> None:
        """Begin a sound; volume in percent."""
        self._now = Sounding(name, order, False, audio=louder(audio, volume), rate=rate)
        self._begin(self._now, us)

    def over(self, us: int) -> bool | None:
        """Return True when the sentence or sound has come to its end, else None."""
        if self._now is not None and us < self._now.end_us:
            return None
        self._now = None
        return True

    def stop(self, us: int) -> None:
        """Break off the sentence or sound."""
        if self._now is not None:
            self._cut(self._now, us)
            self._now = None

    def _begin(self, sounding: Sounding, us: int, seconds: float = 0.0) -> None:
        kind = "say" if sounding.spoken else "sound"
        if sounding.audio is not None:
            seconds = len(sounding.audio) / sounding.rate
            self._counts[kind] += 1
            if self._out is not None:
                sounding.file = self._out / f"{kind}-{self._counts[kind]:03}.wav"
                keep(sounding.file, sounding.audio, sounding.rate, self._tell)
        sounding.start_us, sounding.end_us = us, us + round(seconds * 1e6)
        file = sounding.file.name if sounding.file is not None else ""
        order = sounding.order
        self._tell(Notice(kind, sounding.text, order.stream, order.row, file))

    def _cut(self, sounding: Sounding, us: int) -> None:
        """Shorten the file to what was played until now."""
        if sounding.file is not None and sounding.audio is not None:
            heard = (us - sounding.start_us) * sounding.rate // 1_000_000
            keep(sounding.file, sounding.audio[: max(0, heard)], sounding.rate, self._tell)


def keep(path: Path, audio: Audio, rate: int, tell: Tell) -> None:
    """Write audio into the run's folder; when that cannot be done, report it and let the run go on."""
    try:
        write_wave(path, audio, rate)
    except OSError as error:
        path.unlink(missing_ok=True)
        told = N_("{file} could not be written ({reason}).", file=path.name, reason=error.strerror)
        tell(Notice("error", told))
