"""Text to audio with espeak-ng, through its C library that comes with `espeakng-loader`."""

from __future__ import annotations

import ctypes
import re
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from rrp_sheets.sim.sounds import Audio

LONGEST = 2_000  # letters that are spoken of one text: two or three minutes
# Numbers of the C interface (espeak-ng's speak_lib.h).
SYNCHRONOUS = 2
RATE, VOLUME, PITCH = 1, 2, 3
USUAL_PITCH = 50
UTF8 = 1
BY_CHARACTER = 1
IPA = 2
OK = 0
ABORT = 1
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
        self.rate: int = self._lib.espeak_Initialize(SYNCHRONOUS, 0, str(data).encode(), 0)
        if self.rate <= 0:
            raise NoSpeech("the speech library did not start")
        self._parts: list[Audio] = []
        self._halted: Callable[[], bool] = lambda: False
        kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)

        def take(wave: Any, count: int, _events: Any) -> int:
            if count > 0 and wave:
                self._parts.append(np.ctypeslib.as_array(wave, shape=(count,)).copy())
            return ABORT if self._halted() else 0

        self._callback: Callable[..., int] = kind(take)  # kept alive as long as the library may call it
        self._lib.espeak_SetSynthCallback(self._callback)
        self._lib.espeak_TextToPhonemes.restype = ctypes.c_char_p

    def voice(self, name: str) -> bool:
        """Choose a language (`de`) or a voice of it (`en-us+f2`); False when there is none of that name."""
        return bool(self._lib.espeak_SetVoiceByName(name.encode("utf-8", "replace")) == OK)

    def say(
        self,
        text: str,
        words_a_minute: float,
        volume: float,
        pitch: int = USUAL_PITCH,
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
        self._lib.espeak_SetParameter(RATE, round(words_a_minute), 0)
        self._lib.espeak_SetParameter(VOLUME, round(volume), 0)
        self._lib.espeak_SetParameter(PITCH, pitch, 0)
        self._parts = []
        data = _UNSPEAKABLE.sub(" ", text[:LONGEST]).encode()
        self._lib.espeak_Synth(data, len(data) + 1, 0, BY_CHARACTER, 0, UTF8, None, None)
        self._lib.espeak_Synchronize()
        return np.concatenate(self._parts) if self._parts else np.zeros(0, np.int16)

    def phonemes(self, text: str) -> str:
        """Return the chosen voice's pronunciation of a text, in letters of the phonetic alphabet."""
        found = []
        rest = ctypes.c_char_p(_UNSPEAKABLE.sub(" ", text[:LONGEST]).encode())
        while rest.value:  # clause by clause
            found.append(self._lib.espeak_TextToPhonemes(ctypes.byref(rest), UTF8, IPA) or b"")
        return b" ".join(found).decode("utf-8", "replace")
