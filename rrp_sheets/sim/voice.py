"""The robot's voice: one sentence at a time; real audio, kept as .wav files."""

from __future__ import annotations

import wave
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.model.exchange import Command, Happening
from rrp_sheets.model.values import Value
from rrp_sheets.sim.espeak import Audio, Espeak, NoSpeech

Tell = Callable[[Happening], None]
GUESSED_WORD_LENGTH = 6  # characters, with the space: for the duration when there is no speech library
FALLBACK = "en"


@dataclass
class Sentence:
    """Something to say, for an order, with the actuator's settings."""

    text: str
    order: Command
    settings: Mapping[str, Value]
    start_us: int = 0
    end_us: int = 0
    audio: Audio | None = None
    file: Path | None = None


class Voice:
    """Speaks sentences; how long that takes comes from the audio."""

    def __init__(self, out: Path | None, tell: Tell) -> None:
        self._out = out
        self._tell = tell
        self._speaking: Sentence | None = None
        self._count = 0
        self._library: Espeak | None = None
        self._missing = False

    @property
    def saying(self) -> str:
        """The sentence being spoken, or empty."""
        return self._speaking.text if self._speaking else ""

    def say(self, text: str, order: Command, settings: Mapping[str, Value], us: int) -> None:
        """Begin a sentence."""
        self._speaking = Sentence(text, order, settings)
        self._start(self._speaking, us)

    def over(self, us: int) -> bool | None:
        """TRUE when the sentence has come to its end, else None."""
        if self._speaking is not None and us < self._speaking.end_us:
            return None
        self._speaking = None
        return True

    def stop(self, us: int) -> None:
        """Break the sentence off."""
        if self._speaking is not None:
            self._cut(self._speaking, us)
            self._speaking = None

    def _start(self, sentence: Sentence, us: int) -> None:
        order = sentence.order
        speed = float(sentence.settings["speed"])
        library = self._load(order)
        if library is None:
            seconds = len(sentence.text) / GUESSED_WORD_LENGTH / speed * 60
        else:
            language = str(sentence.settings["language"] or FALLBACK)
            if not library.voice(language):
                library.voice(FALLBACK)
                text = f"There is no voice for the language “{language}”; it is spoken in English."
                self._tell(Happening("error", text, order.stream, order.row))
            sentence.audio = library.say(sentence.text, speed, float(sentence.settings["volume"]))
            seconds = len(sentence.audio) / library.rate
            self._count += 1
            if self._out is not None:
                sentence.file = self._out / f"say-{self._count:03}.wav"
                self._write(sentence.file, sentence.audio)
        sentence.start_us, sentence.end_us = us, us + round(seconds * 1e6)
        sound = sentence.file.name if sentence.file is not None else ""
        self._tell(Happening("say", sentence.text, order.stream, order.row, sound))

    def _load(self, order: Command) -> Espeak | None:
        if self._library is None and not self._missing:
            try:
                self._library = Espeak()
            except NoSpeech:
                self._missing = True
                text = "There is no sound: the package espeakng-loader is not installed. Durations are estimated."
                self._tell(Happening("error", text, order.stream, order.row))
        return self._library

    def _cut(self, sentence: Sentence, us: int) -> None:
        """What was not spoken any more is not in the file either."""
        if sentence.file is not None and sentence.audio is not None and self._library is not None:
            spoken = (us - sentence.start_us) * self._library.rate // 1_000_000
            self._write(sentence.file, sentence.audio[: max(0, spoken)])

    def _write(self, path: Path, audio: Audio) -> None:
        assert self._library is not None
        try:
            with path.open("wb") as data, wave.open(data, "wb") as file:
                file.setnchannels(1)
                file.setsampwidth(2)
                file.setframerate(self._library.rate)
                file.writeframes(audio.astype("<i2").tobytes())
        except OSError as error:  # the robot speaks all the same
            path.unlink(missing_ok=True)
            self._tell(Happening("error", f"{path.name} could not be written ({error.strerror})."))
