"""Text to audio with espeak-ng, through its C library that comes with `espeakng-loader`."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

Audio = NDArray[np.int16]
# Numbers of the C interface (espeak-ng's speak_lib.h).
SYNCHRONOUS = 2
RATE, VOLUME = 1, 2
UTF8 = 1
BY_CHARACTER = 1
OK = 0


class NoSpeech(Exception):
    """The speech library is not there."""


class Espeak:
    """The speech library, loaded once per process."""

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
        kind = ctypes.CFUNCTYPE(ctypes.c_int, ctypes.POINTER(ctypes.c_short), ctypes.c_int, ctypes.c_void_p)

        def take(wave: Any, count: int, _events: Any) -> int:
            if count > 0 and wave:
                self._parts.append(np.ctypeslib.as_array(wave, shape=(count,)).copy())
            return 0

        self._callback: Callable[..., int] = kind(take)  # kept alive as long as the library may call it
        self._lib.espeak_SetSynthCallback(self._callback)

    def voice(self, language: str) -> bool:
        """Choose a language; False when there is no voice for it."""
        return bool(self._lib.espeak_SetVoiceByName(language.encode()) == OK)

    def say(self, text: str, words_a_minute: float, volume: float) -> Audio:
        """The audio of a text; volume in percent."""
        self._lib.espeak_SetParameter(RATE, round(words_a_minute), 0)
        self._lib.espeak_SetParameter(VOLUME, round(volume), 0)
        self._parts = []
        data = text.encode()
        self._lib.espeak_Synth(data, len(data) + 1, 0, BY_CHARACTER, 0, UTF8, None, None)
        self._lib.espeak_Synchronize()
        return np.concatenate(self._parts) if self._parts else np.zeros(0, np.int16)
