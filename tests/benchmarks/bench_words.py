"""Accuracy of recognising the words that the robot listens for, by voice and noise, and the time that it takes.

Measured: the recogniser as a sensor uses it (`perception/word_recognition.py`), with the words of ten settings, on what espeak-ng says
with the voices that people have in the scene; the same for words that are in no setting. Right means: that word and no
other. Not measured: real voices, microphones, rooms and echoes, dialects, emphasis, words within long sentences.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Iterator, Sequence

import numpy as np
import pytest

from rrp_sheets.perception.word_recognition import RATE, Ear, Listener, pieces
from rrp_sheets.sim import talk
from rrp_sheets.sim.sounds import Speech

SETTINGS = [text.split(", ") for text in (
    "yes, no", "red, blue, green", "doctor, blood test, x-ray", "again, next", "okay, stop, start", "left, right",
    "happy, sad, angry", "cat, dog, cow", "one, two, three, four, five", "hello, goodbye, dance with me",
)]  # fmt: skip
OTHERS = [
    "apple",
    "table",
    "window",
    "orange",
    "music",
    "paper",
    "yellow",
    "water",
    "garden",
    "robot",
    "mother",
    "school",
    "river",
    "bottle",
    "monkey",
    "summer",
    "morning",
    "please",
    "thanks",
    "maybe",
    "never",
    "always",
    "today",
    "nothing",
    "sleep",
    "jump",
    "walk",
    "sing",
    "play",
    "eat",
    "drink",
    "house",
    "tree",
]
RIGHT, FALSE, SLOWEST = 0.95, 0.125, 60.0  # of the words; of the others; ms of processor time for a second of audio
NOISES = (0.0, 0.1, 0.3)
VOICES = ("female", "male", "child")


class Bench:
    """The recogniser with all settings."""

    def __init__(self) -> None:
        self.speech = Speech(lambda happening: None)
        self.ear = Ear([p for words in SETTINGS for w in words for p in pieces(w)], self.speech.library)
        self.listeners = [self.ear.listener(f"b{n}", words)[0] for n, words in enumerate(SETTINGS)]
        self.seconds = self.audio = 0.0

    def hear(self, listener: Listener, text: str, voice: tuple[str, int], level: float) -> list[tuple[str, float]]:
        """Words that are recognised when somebody says a text."""
        library = self.speech.library()
        assert library is not None and library.voice(voice[0])
        sound = talk.resampled(library.say(text, talk.SPEED, 100, voice[1]).astype(np.float32) / 32768, library.rate)
        quiet = np.zeros(talk.PAD, np.float32)
        sound = np.concatenate([quiet, sound, quiet])
        sound = sound + talk.noise(len(sound), level, (1, len(sound)))
        began = time.process_time()
        heard = self.ear.recognise(listener, sound)
        self.seconds += time.process_time() - began
        self.audio += len(sound) / RATE
        return heard


@pytest.fixture(scope="module")
def bench() -> Iterator[Bench]:
    yield Bench()


@pytest.mark.parametrize("level", NOISES)
def test_words_right_and_false(bench: Bench, level: float) -> None:
    right: dict[str, list[bool]] = {}
    false: list[bool] = []
    sure: dict[bool, list[float]] = {True: [], False: []}
    for kind in VOICES:
        voices = [talk.voice_of(name, kind) for name in ("Anna", "Ben", "Cleo", "Dora")]
        for number, (words, listener) in enumerate(zip(SETTINGS, bench.listeners, strict=True)):
            for place, word in enumerate(words):
                heard = bench.hear(listener, word, voices[(number + place) % len(voices)], level)
                right.setdefault(kind, []).append([w for w, _ in heard] == [word])
                sure[True] += [s for w, s in heard if w == word]
            for other in _some(OTHERS, number):
                heard = bench.hear(listener, other, voices[number % len(voices)], level)
                false.append(bool(heard))
                sure[False] += [s for _, s in heard]
    share = statistics.mean(r for rights in right.values() for r in rights)
    by_voice = ", ".join(f"{kind} {sum(r)} of {len(r)}" for kind, r in right.items())
    print(
        f"\nnoise {level:.0%}: words right {share:.1%} ({by_voice}); of words not listened for "
        f"{sum(false)} of {len(false)} taken for one ({statistics.mean(false):.1%}); confidence in the middle "
        f"{_middle(sure[True]):.2f} when right, {_middle(sure[False]):.2f} when not; "
        f"{1000 * bench.seconds / bench.audio:.0f} ms for a second of audio"
    )
    assert statistics.mean(false) <= FALSE
    assert level or share >= RIGHT
    assert 1000 * bench.seconds / bench.audio <= SLOWEST


def _some(words: Sequence[str], number: int) -> Sequence[str]:
    return words[number % 5 :: 5]


def _middle(values: Sequence[float]) -> float:
    return statistics.median(values) if values else 0.0
