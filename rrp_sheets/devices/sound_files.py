"""Sounds of the user's own: .wav files beside the workbook. Looked at when a workbook is checked, and when it runs."""

from __future__ import annotations

import wave
from dataclasses import dataclass
from pathlib import Path

from rrp_sheets.diagnostics.phrase import Phrase

LARGEST = 20_000_000  # bytes
LONGEST = 300.0  # s
RATES = (4_000, 192_000)  # samples a second
MOST_CHANNELS = 8
SUFFIX = ".wav"


class BadSoundError(Exception):
    """A file that cannot be played; the text goes on after the file's name."""


@dataclass(frozen=True)
class Wave:
    """A sound as its file has it.

    Attributes:
        data: samples, little-endian, the channels of one moment side by side.
        width: bytes of one sample.
        rate: moments a second.
    """

    data: bytes
    width: int
    channels: int
    rate: int


def is_plain(name: str) -> bool:
    r"""Return whether a text can be the name of a sound file beside the workbook: no folder, no way out of one.

    >>> [is_plain(n) for n in ("song.wav", "My Song.WAV", "../song.wav", "a\\b.wav", "/song.wav", "song.mp3", ".wav")]
    [True, True, False, False, False, False, False]
    """
    dull = not name.startswith(".") and not any(c in '/\\:*?"<>|' or not c.isprintable() for c in name)
    return dull and name.casefold().endswith(SUFFIX) and len(name) <= 200


def read_wave(folder: Path, name: str) -> Wave:
    """Read a sound file that is beside a workbook.

    Raises:
        BadSoundError: it is not there, is no sound, or is too large or too long.
    """
    path = _beside(folder, name)
    try:
        with wave.open(str(path), "rb") as file:
            _judge(file)
            data = file.readframes(file.getnframes())
            return Wave(data, file.getsampwidth(), file.getnchannels(), file.getframerate())
    except (wave.Error, EOFError):
        raise BadSoundError("is no .wav file that can be played: save it as 16-bit PCM") from None
    except OSError as error:
        raise BadSoundError(Phrase("cannot be read ({strerror})", strerror=error.strerror)) from None


def look_at(folder: Path, name: str) -> None:
    """As :func:`read_wave`, without reading the sound itself."""
    path = _beside(folder, name)
    try:
        with wave.open(str(path), "rb") as file:
            _judge(file)
    except (wave.Error, EOFError):
        raise BadSoundError("is no .wav file that can be played: save it as 16-bit PCM") from None
    except OSError as error:
        raise BadSoundError(Phrase("cannot be read ({strerror})", strerror=error.strerror)) from None


def _beside(folder: Path, name: str) -> Path:
    if not is_plain(name):
        raise BadSoundError("is not the name of a .wav file beside the workbook")
    path = folder / name
    try:
        if not path.is_file():
            raise BadSoundError("is not in the folder of the workbook")
        if path.resolve().parent != folder.resolve():
            raise BadSoundError("is a link that leaves the folder of the workbook")
        size = path.stat().st_size
    except OSError as error:
        raise BadSoundError(Phrase("cannot be read ({strerror})", strerror=error.strerror)) from None
    if size > LARGEST:
        raise BadSoundError(Phrase("has {n:.0f} MB; {most:.0f} MB are possible", n=size / 1e6, most=LARGEST / 1e6))
    return path


def _judge(file: wave.Wave_read) -> None:
    rate, frames = file.getframerate(), file.getnframes()
    if not RATES[0] <= rate <= RATES[1]:
        raise BadSoundError(
            Phrase(
                "has {rate:,} samples a second; {value:,} to {value2:,} are possible",
                rate=rate,
                value=RATES[0],
                value2=RATES[1],
            )
        )
    if not 1 <= file.getnchannels() <= MOST_CHANNELS or file.getsampwidth() not in (1, 2, 3, 4):
        raise BadSoundError("is no .wav file that can be played: save it as 16-bit PCM")
    if not frames:
        raise BadSoundError("is empty")
    if frames / rate > LONGEST:
        raise BadSoundError(
            Phrase("lasts {value:.0f} s; {longest:.0f} s are possible", value=frames / rate, longest=LONGEST)
        )
