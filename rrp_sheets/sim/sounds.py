"""Sounds of the robot, made from tones and noise with the same samples in every run, and .wav files."""

from __future__ import annotations

import math
import wave
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rrp_sheets.robots.media_files import Wave

RATE = 22_050  # samples a second
PEAK = 0.8  # of the loudest that a file can hold
BEAT = 0.5  # s: dance music has 120 beats a minute
FADE = 0.004  # s: without it a sound that ends would click
Audio = NDArray[np.int16]
Signal = NDArray[np.float64]
_NAMES = {"C": 0, "D": 2, "E": 4, "F": 5, "G": 7, "A": 9, "B": 11}


def own_sound(name: str) -> Audio:
    """Make one of the robot's own sounds, by the catalogue's name, at `RATE`. Raises KeyError for any other."""
    signal = SOUNDS[name]()
    fade = np.minimum(1.0, np.arange(len(signal))[::-1] / (FADE * RATE))
    signal = signal * fade * (PEAK / max(float(np.abs(signal).max()), 1e-9))
    return np.asarray(signal * 32767, np.int16)


def from_wave(read: Wave) -> Audio:
    """The samples of a file, its channels mixed."""
    if read.width == 1:  # without sign, as the format wants it
        samples = (np.frombuffer(read.data, np.uint8).astype(np.int32) - 128) << 8
    elif read.width == 3:
        whole = read.data[: len(read.data) // 3 * 3]
        high = np.frombuffer(whole, np.uint8).reshape(-1, 3)
        samples = high[:, 1].astype(np.int32) | (high[:, 2].astype(np.int8).astype(np.int32) << 8)
    else:
        whole = read.data[: len(read.data) // read.width * read.width]
        samples = np.frombuffer(whole, f"<i{read.width}").astype(np.int32) >> (8 * (read.width - 2))
    moments = len(samples) // read.channels
    mixed = samples[: moments * read.channels].reshape(moments, read.channels).mean(axis=1)
    return np.asarray(mixed, np.int16)


def louder(audio: Audio, percent: float) -> Audio:
    """The audio at another volume; what would be too loud for a file is cut."""
    if percent == 100:
        return audio
    return np.clip(audio.astype(np.float64) * percent / 100, -32768, 32767).astype(np.int16)


def write_wave(path: Path, audio: Audio, rate: int) -> None:
    """Write a .wav file; raises OSError."""
    with path.open("wb") as data, wave.open(data, "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(rate)
        file.writeframes(audio.astype("<i2").tobytes())


def _time(seconds: float) -> Signal:
    return np.arange(round(seconds * RATE)) / RATE


def _hertz(note: str) -> float:
    """Return the frequency of a note: `A4` is 440 Hz."""
    half_tones = _NAMES[note[0]] + (note.count("#")) + 12 * int(note[-1]) - 57
    return float(440.0 * 2 ** (half_tones / 12))


def _struck(hertz: float, seconds: float, partials: Sequence[tuple[float, float, float]]) -> Signal:
    """Make a ringing tone of partials: (times the tone, strength, seconds until it has faded to a third)."""
    t = _time(seconds)
    parts = [a * np.exp(-t / fades) * np.sin(2 * math.pi * hertz * times * t) for times, a, fades in partials]
    return np.asarray(sum(parts), dtype=np.float64) * np.minimum(1.0, t / 0.002)


def _tone(note: str, seconds: float) -> Signal:
    """A note as a wind instrument plays it."""
    t = _time(seconds)
    hertz = _hertz(note)
    swell = np.minimum(1.0, t / 0.02) * np.minimum(1.0, (seconds - t) / 0.05)
    return np.asarray(swell * sum(np.sin(2 * math.pi * hertz * k * t) / k**1.3 for k in range(1, 6)), np.float64)


def _pluck(note: str, seconds: float) -> Signal:
    return _struck(_hertz(note), seconds, ((1, 1.0, 0.5), (2, 0.5, 0.3), (3, 0.2, 0.2), (4, 0.1, 0.1)))


def _mixed(seconds: float, parts: Sequence[tuple[float, float, Signal]]) -> Signal:
    """Mix sounds at their times (s), each with its strength."""
    whole = np.zeros(round(seconds * RATE))
    for at, strength, part in parts:
        start = round(at * RATE)
        piece = part[: max(0, len(whole) - start)]
        whole[start : start + len(piece)] += strength * piece
    return whole


def _hiss(seconds: float, seed: int) -> Signal:
    return np.random.default_rng(seed).standard_normal(round(seconds * RATE))


def _drum_beat(seconds: float = 0.5) -> Signal:
    t = _time(seconds)
    skin = np.exp(-t / 0.16) * np.sin(2 * math.pi * (62 * t + 2.8 * (1 - np.exp(-t / 0.05))))
    return np.asarray(skin + 0.25 * np.exp(-t / 0.012) * _hiss(seconds, 3)[: len(t)], np.float64)


def _clap(seed: int) -> Signal:
    t = _time(0.12)
    noise = _hiss(0.12, seed)
    soft = np.convolve(noise, np.ones(4) / 4, mode="same")
    return (noise - soft) * np.exp(-t / 0.018)


def _hat(seconds: float = 0.08) -> Signal:
    noise = np.diff(_hiss(seconds, 5), prepend=0.0)
    return noise * np.exp(-_time(seconds)[: len(noise)] / 0.02)


def _bell() -> Signal:
    return _struck(660.0, 2.5, ((0.5, 0.35, 1.1), (1, 1.0, 0.9), (1.2, 0.4, 0.5), (2, 0.5, 0.4), (3.01, 0.25, 0.25)))


def _chime() -> Signal:
    notes = ("E5", "G5", "C6")
    return _mixed(2.2, [(0.28 * k, 1.0, _struck(_hertz(n), 1.6, ((1, 1, 0.7), (2.76, 0.3, 0.2))))
                        for k, n in enumerate(notes)])  # fmt: skip


def _drum() -> Signal:
    beat = _drum_beat()
    return _mixed(2.0, [(at, loud, beat) for at, loud in ((0, 1), (0.5, 0.7), (0.75, 0.7), (1.0, 1), (1.5, 0.9))])


def _applause() -> Signal:
    chance = np.random.default_rng(11)
    seconds = 4.0
    claps = [_clap(100 + k) for k in range(12)]
    parts = []
    for _ in range(520):
        at = float(chance.uniform(0, seconds - 0.15))
        swell = min(1.0, at / 0.5) * min(1.0, (seconds - at) / 1.5)
        parts.append((at, swell * float(chance.uniform(0.2, 1.0)), claps[int(chance.integers(12))]))
    return _mixed(seconds, parts)


def _tada() -> Signal:
    short = sum((_tone(n, 0.16) for n in ("G4", "C5", "E5")), np.zeros(round(0.16 * RATE)))
    long = sum((_tone(n, 1.1) for n in ("C5", "E5", "G5", "C6")), np.zeros(round(1.1 * RATE)))
    return _mixed(1.4, [(0, 0.8, short), (0.22, 1.0, long)])


def _buzzer() -> Signal:
    t = _time(0.7)
    swell = np.minimum(1.0, t / 0.01) * np.minimum(1.0, (0.7 - t) / 0.03)
    wave_form = np.tanh(3 * np.sin(2 * math.pi * 115 * t)) + 0.6 * np.tanh(3 * np.sin(2 * math.pi * 171 * t))
    return np.asarray(swell * wave_form, np.float64)


def _whistle() -> Signal:
    t = _time(0.9)
    hertz = 1500 + 700 * np.sin(math.pi * t / 0.9)
    swell = np.minimum(1.0, t / 0.04) * np.minimum(1.0, (0.9 - t) / 0.1)
    return np.asarray(swell * np.sin(2 * math.pi * np.cumsum(hertz) / RATE), np.float64)


def _dance_music() -> Signal:
    """Eight bars of four beats: 16 s."""
    bars = (("C", "E", "G"), ("A", "C", "E"), ("F", "A", "C"), ("G", "B", "D"))
    tune = ["E5", "G5", "A5", "G5", "C6", "A5", "G5", "E5", "F5", "A5", "C6", "A5", "G5", "B5", "D6", "B5"]
    parts: list[tuple[float, float, Signal]] = []
    for bar in range(8):
        chord, at = bars[bar % 4], bar * 4 * BEAT
        for beat in range(4):
            now = at + beat * BEAT
            parts.append((now, 1.0, _drum_beat(0.4)))
            parts.append((now + BEAT / 2, 0.12, _hat()))
            parts.append((now, 0.5, _pluck(f"{chord[0]}{2 + beat % 2}", BEAT)))
            parts += [(now + BEAT / 2, 0.16, _pluck(f"{n}4", BEAT / 2)) for n in chord]
            if beat % 2:
                parts.append((now, 0.3, _clap(7)))
            if bar % 4 < 3 or beat < 3:
                parts.append((now, 0.4, _pluck(tune[bar % 4 * 4 + beat], BEAT)))
    return _mixed(8 * 4 * BEAT, parts)


def _calm_music() -> Signal:
    """A slow tune on bells: 16 s."""
    tune = ["E5", "C5", "G4", "C5", "D5", "G5", "G5", "D5", "E5", "D5", "C5", "G4", "A4", "G4", "C5", "C5"]
    ring = ((1, 1.0, 1.2), (2, 0.25, 0.6), (3, 0.08, 0.3))
    parts = [(k * 1.0, 0.7, _struck(_hertz(n), 3.0, ring)) for k, n in enumerate(tune)]
    parts += [(4.0 * k, 0.5, _struck(_hertz(n), 4.0, ring)) for k, n in enumerate(("C4", "G3", "C4", "F3"))]
    return _mixed(17.0, parts)


SOUNDS: Mapping[str, Callable[[], Signal]] = {
    "Bell": _bell, "Chime": _chime, "Drum": _drum, "Applause": _applause, "Tada": _tada, "Buzzer": _buzzer,
    "Whistle": _whistle, "Dance music": _dance_music, "Calm music": _calm_music,
}  # fmt: skip
