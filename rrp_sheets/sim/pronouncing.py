"""How English words sound: the recogniser's dictionary, and what espeak-ng says of words that are not in it."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Mapping
from pathlib import Path

from rrp_sheets.sim.espeak import Espeak

MOST_WAYS = 4  # pronunciations of a word that are listened for
LONGEST = 60  # sounds of a word: longer ones nobody says
_PIECE = re.compile(r"[^\W_]+(?:['’][^\W_]+)*")
# Letters of the phonetic alphabet, longest first, as sounds of the recogniser (CMU's 39).
_SOUNDS: Mapping[str, str] = {
    "tʃ": "CH", "dʒ": "JH", "aɪə": "AY ER", "aɪɚ": "AY ER", "aʊɚ": "AW ER", "aɪ": "AY", "aʊ": "AW", "eɪ": "EY",
    "oʊ": "OW", "əʊ": "OW", "ɔɪ": "OY", "ɜː": "ER", "ɜ": "ER", "ɚ": "ER", "ɝ": "ER", "iː": "IY", "i": "IY", "ɪ": "IH",
    "ᵻ": "IH", "ɨ": "IH", "uː": "UW", "u": "UW", "ʊ": "UH", "ɛ": "EH", "e": "EH", "æ": "AE", "a": "AE", "ɑː": "AA",
    "ɑ": "AA", "ɒ": "AA", "ɔː": "AO", "ɔ": "AO", "oː": "AO", "o": "OW", "ʌ": "AH", "ə": "AH", "ɐ": "AH", "ŋ": "NG",
    "ʃ": "SH", "ʒ": "ZH", "θ": "TH", "ð": "DH", "ɹ": "R", "r": "R", "ɾ": "T", "ʔ": "T", "ɡ": "G", "g": "G", "j": "Y",
    "b": "B", "d": "D", "f": "F", "h": "HH", "k": "K", "l": "L", "ɫ": "L", "m": "M", "n": "N", "p": "P", "s": "S",
    "t": "T", "v": "V", "w": "W", "z": "Z", "x": "K", "ç": "HH", "ɬ": "L", "ʁ": "R", "y": "UW", "ø": "ER", "œ": "ER",
}  # fmt: skip
_ANY = re.compile("|".join(sorted(map(re.escape, _SOUNDS), key=len, reverse=True)))


def pieces(text: str) -> list[str]:
    """The single words of a phrase, as a dictionary has them.

    >>> pieces("Blood test!"), pieces("X-ray"), pieces("Don’t"), pieces("?")
    (['blood', 'test'], ['x', 'ray'], ["don't"], [])
    """
    return [piece.replace("’", "'") for piece in _PIECE.findall(unicodedata.normalize("NFKC", text).casefold())]


def sounds_of(ipa: str) -> str:
    """Sounds of the recogniser for letters of the phonetic alphabet; stress and what is unknown are left out.

    >>> sounds_of("jˈɛstɚdˌeɪ"), sounds_of("ˈɛksɹˈeɪ"), sounds_of("()")
    ('Y EH S T ER D EY', 'EH K S R EY', '')
    """
    return " ".join(_SOUNDS[found] for found in _ANY.findall(re.sub(r"\([^)]*\)|[ˈˌ]", "", ipa)))


class Pronunciations:
    """Looks words up.

    Args:
        dictionary: the recogniser's.
        words: those that will be asked for: the others of the dictionary are not kept.
        speech: for words that are not in it; None when there is none.
    """

    def __init__(self, dictionary: Path, words: Iterable[str], speech: Espeak | None) -> None:
        wanted = set(words)
        self._known: dict[str, list[str]] = {}
        self._speech = speech
        with dictionary.open(encoding="utf-8", errors="replace") as lines:
            for line in lines:
                word, _, sounds = line.partition(" ")
                word = word.partition("(")[0]
                if word in wanted and sounds:
                    self._known.setdefault(word, []).append(sounds.strip())

    def of(self, word: str) -> list[str]:
        """The ways to say a word, as sounds with spaces between them; empty when nobody knows."""
        if word not in self._known:
            sounds = sounds_of(self._spoken(word))
            self._known[word] = [sounds] if sounds and sounds.count(" ") < LONGEST else []
        return self._known[word][:MOST_WAYS]

    def _spoken(self, word: str) -> str:
        if self._speech is None or not word.isprintable() or not self._speech.voice("en-us"):
            return ""
        return self._speech.phonemes(word) if any(c.isdecimal() or _is_latin(c) for c in word) else ""


def _is_latin(letter: str) -> bool:
    return unicodedata.name(letter, "").startswith("LATIN ")
