"""Sounds, the same in every run: voices (espeak-ng; Open JTalk reads Japanese), the robot's own, and .wav files."""

from __future__ import annotations

import contextlib
import ctypes
import io
import math
import re
import wave
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rrp_sheets.model.exchange import Command, DeviceUse, Notice, SceneAction
from rrp_sheets.model.japanese import LETTERS
from rrp_sheets.model.values import Value
from rrp_sheets.robots.media_files import Wave
from rrp_sheets.sim.arbitration import Tell
from rrp_sheets.texts import N_, os_reason

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
    return (noise - np.convolve(noise, np.ones(4) / 4, mode="same")) * np.exp(-t / 0.018)


def _hat(seconds: float = 0.08) -> Signal:
    noise = np.diff(_hiss(seconds, 5), prepend=0.0)
    return noise * np.exp(-_time(seconds)[: len(noise)] / 0.02)


def _bell() -> Signal:
    return _struck(660.0, 2.5, ((0.5, 0.35, 1.1), (1, 1.0, 0.9), (1.2, 0.4, 0.5), (2, 0.5, 0.4), (3.01, 0.25, 0.25)))


def _chime() -> Signal:
    partials = ((1, 1, 0.7), (2.76, 0.3, 0.2))
    return _mixed(2.2, [(0.28 * k, 1.0, _struck(_hertz(n), 1.6, partials)) for k, n in enumerate(("E5", "G5", "C6"))])


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
            parts += [(now, 1.0, _drum_beat(0.4)), (now + BEAT / 2, 0.12, _hat())]
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


GUESSED_WORD_LENGTH = 6  # characters, with the space: for the duration when there is no speech library
FALLBACK = "en"
_NAN = re.compile("何(?=[だでてと])")  # before these it is not “nani”
NO_KANJI = N_("The simulated voice cannot read kanji, because the package pyopenjtalk-plus is not installed.")
NO_SPEECH = N_("The robot has no sound, because the package espeakng-loader is not installed. Durations are estimated.")
LONGEST = 2_000  # letters that are spoken of one text: two or three minutes
# Numbers of the C interface (espeak-ng's speak_lib.h).
_RATE, _VOLUME, _PITCH = 1, 2, 3
_USUAL_PITCH = 50  # of 0 to 100
_SYNCHRONOUS, _UTF8, _BY_CHARACTER, _IPA = 2, 1, 1, 2
_OK, _ABORT = 0, 1
_UNSPEAKABLE = re.compile(r"[\x00-\x08\x0b-\x1f\x7f\ud800-\udfff]")  # the library stops at the first, or refuses them


class NoSpeech(Exception):
    """Raised when the speech library cannot be loaded."""


def is_japanese(language: str) -> bool:
    """Return True for the code of Japanese, or of a voice of it: `ja`, `ja+f1`."""
    return re.split("[-_+]", language.strip().casefold())[0] == "ja"


@cache
def japanese_reader() -> Callable[..., Any] | None:
    """Load the library that knows how Japanese is said (0.1 s); None when it is not installed."""
    try:
        with contextlib.redirect_stdout(io.StringIO()):  # it writes what else could be installed
            from pyopenjtalk import run_frontend
    except ImportError:
        return None
    return run_frontend


def spoken(text: str, *, japanese: bool) -> str:
    """Return what is spoken of a text, a Japanese one in kana as it is said, its phrases apart (with the library).

    >>> spoken("今日は3回やってみよう。何色？", japanese=True), spoken("Aはどれ", japanese=True)
    ('キョーワ サンカイ ヤッテミヨー。 ナニイロ？', 'エイ ワ ドレ')
    """
    text, read = _UNSPEAKABLE.sub(" ", text[:LONGEST]), japanese_reader() if japanese else None
    if read is None:
        return text
    said, begins = "", True
    text = _NAN.sub("なん", text.replace("何色", "なに色"))
    for word in read(text, predict_nani=False, use_sudachi_kanji_yomi=False):  # both need more to be loaded
        mark = word["pos"] == "記号" and not LETTERS.match(word["pron"])  # “A” is “エイ”
        particle = begins and word["pos"] == "助詞"  # no clause begins with one: that “ha” is no “wa”
        said += "" if mark or word["chain_flag"] == 1 else " "
        said += word["string" if mark else "read" if particle else "pron"].replace("’", "")  # a silent vowel
        begins = mark and word["string"] not in "」』）”’"
    return said.strip()


@cache
def espeak() -> Espeak:
    """The speech library of this process; raises NoSpeech when it is not there."""
    return Espeak()  # it must not be started twice: that frees the sounds of the voice in use


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
        self._japanese = False  # the voice chosen
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
        found = bool(self._lib.espeak_SetVoiceByName(name.encode("utf-8", "replace")) == _OK)
        self._japanese = is_japanese(name) if found else self._japanese
        return found

    def say(
        self, text: str, words_a_minute: float, volume: float, pitch: int = _USUAL_PITCH,
        halted: Callable[[], bool] = lambda: False,
    ) -> Audio:  # fmt: skip
        """Return the audio of a text in the chosen voice's language: at most `LONGEST` letters of it are spoken.

        The volume is in percent, the pitch 0 to 100; when `halted`, asked after each 0.2 s, is true, the rest is left
        out.
        """
        self._halted = halted
        for parameter, value in ((_RATE, round(words_a_minute)), (_VOLUME, round(volume)), (_PITCH, pitch)):
            self._lib.espeak_SetParameter(parameter, value, 0)
        self._parts = []
        data = spoken(text, japanese=self._japanese).encode()
        self._lib.espeak_Synth(data, len(data) + 1, 0, _BY_CHARACTER, 0, _UTF8, None, None)
        self._lib.espeak_Synchronize()
        return np.concatenate(self._parts) if self._parts else np.zeros(0, np.int16)

    def phonemes(self, text: str) -> str:
        """Return the chosen voice's pronunciation of a text, in letters of the phonetic alphabet."""
        found = []
        rest = ctypes.c_char_p(spoken(text, japanese=self._japanese).encode())
        while rest.value:  # clause by clause
            found.append(self._lib.espeak_TextToPhonemes(ctypes.byref(rest), _UTF8, _IPA) or b"")
        return b" ".join(found).decode("utf-8", "replace")


class Speech:
    """The speech library that the robot and the persons share, loaded when somebody first speaks."""

    def __init__(self, tell: Tell, halted: Callable[[], bool] = lambda: False) -> None:
        self._tell = tell
        self.halted = halted  # whether the robot is to rest, so that no speech is wanted any more
        self._library: Espeak | None = None
        self._missing = False

    def prepare(self, actuators: Sequence[DeviceUse], scene: Sequence[SceneAction]) -> None:
        """Load what Japanese needs, if somebody will speak it, so that no sentence of the run waits for it."""
        robot = any(is_japanese(str(a.settings.get("language", ""))) for a in actuators)
        people = any(LETTERS.search(str(a.values.get("words", ""))) for a in scene)
        if (robot or people) and japanese_reader() is None:
            self._tell(Notice("error", NO_KANJI))

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
    command: Command
    spoken: bool
    start_us: int = 0
    end_us: int = 0
    audio: Audio | None = None
    rate: int = 0
    file: Path | None = None


class Voice:
    """Speaks sentences and plays sounds; their duration comes from the audio. Without a folder it keeps no files."""

    def __init__(self, out: Path | None, tell: Tell, speech: Speech) -> None:
        self._out, self._tell, self._speech = out, tell, speech
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

    def say(self, text: str, command: Command, settings: Mapping[str, Value], us: int) -> None:
        """Begin a sentence."""
        self._now = Sounding(text, command, True)
        if len(text) > LONGEST:
            told = N_("The robot says only the first {n:,} of {of:,} letters.", n=LONGEST, of=len(text))
            self._tell(Notice("clamp", told, command.stream, command.row))
        speed = float(settings["speed"])
        language = str(settings["language"] or FALLBACK).strip().casefold().replace("_", "-")
        library = self._speech.library(command.stream, command.row)
        if library is None:
            japanese = is_japanese(language)
            letters = len(spoken(text, japanese=japanese)) * (2 if japanese else 1)  # a kana lasts longer than a letter
            self._begin(self._now, us, letters / GUESSED_WORD_LENGTH / speed * 60)
            return
        if not library.voice(language):
            library.voice(FALLBACK)
            told = N_(
                "There is no voice for the language “{language}”, so the robot speaks English.", language=language
            )
            self._tell(Notice("error", told, command.stream, command.row))
        self._now.audio = library.say(text, speed, float(settings["volume"]), halted=self._speech.halted)
        self._now.rate = library.rate
        self._begin(self._now, us)

    def play(self, name: str, audio: Audio, rate: int, volume: float, command: Command, us: int) -> None:
        """Begin a sound; volume in percent."""
        self._now = Sounding(name, command, False, audio=louder(audio, volume), rate=rate)
        self._begin(self._now, us)

    def over(self, us: int) -> bool | None:
        """Return True when the sentence or sound has come to its end, else None."""
        if self._now is not None and us < self._now.end_us:
            return None
        self._now = None
        return True

    def stop(self, us: int) -> None:
        """Break off the sentence or sound; its file is shortened to what was played until now."""
        now, self._now = self._now, None
        if now is not None and now.file is not None and now.audio is not None:
            heard = (us - now.start_us) * now.rate // 1_000_000
            keep(now.file, now.audio[: max(0, heard)], now.rate, self._tell)

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
        self._tell(Notice(kind, sounding.text, sounding.command.stream, sounding.command.row, file))


def keep(path: Path, audio: Audio, rate: int, tell: Tell) -> None:
    """Write audio into the run's folder; when that cannot be done, report it and let the run go on."""
    try:
        write_wave(path, audio, rate)
    except OSError as error:
        path.unlink(missing_ok=True)
        told = N_("{file} could not be written ({reason}).", file=path.name, reason=os_reason(error))
        tell(Notice("error", told))
