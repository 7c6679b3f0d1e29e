"""Pictures of faces and sounds beside the workbook: looked at when it is checked, and again when it runs."""

from __future__ import annotations

import struct
import wave
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath, PureWindowsPath

from rrp_sheets.diagnostics.report import Report, meant
from rrp_sheets.model.exchange import SceneAction
from rrp_sheets.model.names import nearest
from rrp_sheets.model.workbook import SceneRow
from rrp_sheets.texts import N_, MessageError, os_reason

SUFFIXES = (".png", ".jpg", ".jpeg")
MOST_BYTES = 5_000_000
MOST_PIXELS = 4_000  # of a side
LEAST_PIXELS = 32
_PUT = N_("Put the file next to the workbook, or leave out “with picture”.")
_NOWHERE = (N_("there is no folder to look in."), _PUT, None)
_PNG = b"\x89PNG\r\n\x1a\n"


def check_pictures(
    actions: Sequence[SceneAction], rows: Mapping[int, SceneRow], folder: Path | None, report: Report
) -> tuple[SceneAction, ...]:
    """Return the actions with whole paths of their pictures; those whose picture cannot be used are reported."""
    found = []
    for action in actions:
        name = action.values.get("picture")
        if name is None:
            found.append(action)
            continue
        problem, remedy, guess = _NOWHERE if folder is None else _problem(folder, name)
        if problem:
            address = rows[action.row].value.address
            report.add("SCENE008", address, name=name, problem=problem, **meant(guess, remedy))
        elif folder is not None:
            found.append(replace(action, values={**action.values, "picture": str((folder / name).resolve())}))
    return tuple(found)


def _problem(folder: Path, name: str) -> tuple[str, str, str | None]:
    """Return why a picture cannot be used, the remedy, and the name that may be meant; empty texts when it can."""
    if PurePosixPath(name).name != name or PureWindowsPath(name).name != name or name.startswith("."):
        remedy = N_("Put the file next to the workbook, and write only its name.")
        return N_("it is not next to the workbook."), remedy, None
    if Path(name).suffix.casefold() not in SUFFIXES:
        return N_("it is neither a .png nor a .jpg file."), N_("Save the picture as a .png or .jpg file."), None
    path = folder / name
    try:
        if not path.is_file():
            there = [p.name for p in sorted(folder.iterdir()) if p.suffix.casefold() in SUFFIXES]
            return N_("there is no such file next to the workbook."), _PUT, nearest(name, there)
        if path.stat().st_size > MOST_BYTES:
            why = N_("it is larger than {value} MB.", value=MOST_BYTES // 1_000_000)
            return why, N_("Save it smaller: 400 x 400 pixels are enough."), None
        size = picture_size(path.read_bytes())
    except (OSError, ValueError):
        return N_("it cannot be read."), N_("Save it again as a .png or .jpg file."), None
    if size is None:
        return N_("it is not a picture."), N_("Save it again as a .png or .jpg file."), None
    if not all(LEAST_PIXELS <= side <= MOST_PIXELS for side in size):
        why = N_("it is {value} x {value2} pixels large.", value=size[0], value2=size[1])
        return why, N_("Save it with sides from {low} to {high} pixels.", low=LEAST_PIXELS, high=MOST_PIXELS), None
    return "", "", None


def picture_size(data: bytes) -> tuple[int, int] | None:
    """Width and height of a PNG or JPEG picture, in pixels; None when it is neither.

    >>> picture_size(b"GIF89a")
    """
    if data.startswith(_PNG) and data[12:16] == b"IHDR":
        width, height = struct.unpack(">II", data[16:24])
        return width, height
    if not data.startswith(b"\xff\xd8"):
        return None
    at = 2
    while at + 9 < len(data) and data[at] == 0xFF:
        mark, length = data[at + 1], int.from_bytes(data[at + 2 : at + 4])
        if mark in range(0xC0, 0xD0) and mark not in (0xC4, 0xC8, 0xCC):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        at += 2 + length
    return None


LARGEST = 20_000_000  # bytes
LONGEST = 300.0  # s
RATES = (4_000, 192_000)  # samples a second
MOST_CHANNELS = 8
SUFFIX = ".wav"


class BadSoundError(MessageError):
    """A file that cannot be played; the text goes on after the file's name."""


@dataclass(frozen=True)
class Wave:
    """A sound as its file has it."""

    data: bytes  # samples, little-endian, the channels of one moment side by side
    width: int  # bytes of one sample
    channels: int
    rate: int  # moments a second


def is_plain(name: str) -> bool:
    r"""Return whether a text can be the name of a sound file beside the workbook: no folder, no way out of one.

    >>> [is_plain(n) for n in ("song.wav", "My Song.WAV", "../song.wav", "a\\b.wav", "/song.wav", "song.mp3", ".wav")]
    [True, True, False, False, False, False, False]
    """
    dull = not name.startswith(".") and not any(c in '/\\:*?"<>|' or not c.isprintable() for c in name)
    return dull and name.casefold().endswith(SUFFIX) and len(name) <= 200


def read_wave(folder: Path, name: str) -> Wave:
    """Read a sound file beside a workbook; raises BadSoundError if it is missing, no sound, too large or too long."""
    with _opened(folder, name) as file:
        data = file.readframes(file.getnframes())
        return Wave(data, file.getsampwidth(), file.getnchannels(), file.getframerate())


def check_sound(folder: Path, name: str) -> None:
    """Check that a sound file can be used, without reading the sound; raises BadSoundError otherwise."""
    with _opened(folder, name):
        pass


@contextmanager
def _opened(folder: Path, name: str) -> Iterator[wave.Wave_read]:
    path = _beside(folder, name)
    try:
        with wave.open(str(path), "rb") as file:
            rate, frames = file.getframerate(), file.getnframes()
            if not RATES[0] <= rate <= RATES[1]:
                low, high = RATES
                raise BadSoundError("has {rate:,} samples a second; {value:,} to {value2:,} are possible",
                                    rate=rate, value=low, value2=high)  # fmt: skip
            if not 1 <= file.getnchannels() <= MOST_CHANNELS or file.getsampwidth() not in (1, 2, 3, 4):
                raise wave.Error
            if not frames:
                raise BadSoundError("is empty")
            if (length := frames / rate) > LONGEST:
                raise BadSoundError("lasts {value:.0f} s; {longest:.0f} s are possible", value=length, longest=LONGEST)
            yield file
    except (wave.Error, EOFError):
        raise BadSoundError("is not a .wav file that can be played: save it as 16-bit PCM") from None
    except OSError as error:
        raise BadSoundError("cannot be read ({strerror})", strerror=os_reason(error)) from None


def _beside(folder: Path, name: str) -> Path:
    if not is_plain(name):
        raise BadSoundError("is not the name of a .wav file next to the workbook")
    path = folder / name
    try:
        if not path.is_file():
            raise BadSoundError("is not in the folder of the workbook")
        if path.resolve().parent != folder.resolve():
            raise BadSoundError("is a link that leaves the folder of the workbook")
        size = path.stat().st_size
    except OSError as error:
        raise BadSoundError("cannot be read ({strerror})", strerror=os_reason(error)) from None
    if size > LARGEST:
        raise BadSoundError("has {n:.0f} MB; {most:.0f} MB are possible", n=size / 1e6, most=LARGEST / 1e6)
    return path
