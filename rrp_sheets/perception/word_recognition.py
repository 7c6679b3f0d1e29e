"""Speech recognition with pocketsphinx: each sensor's words among decoys, and the pronunciation of words.

A recogniser that knows only the words it waits for takes everything for one of them; with other words to choose from
it leaves most of what it does not know alone. Its own probabilities say little about how sure a word is; the confidence
given here is how well its sounds fit, in the mean, beside those that would fit best at each moment (`sure`).
"""

from __future__ import annotations

import difflib
import math
import re
import unicodedata
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

if TYPE_CHECKING:
    from pocketsphinx import Decoder


Signal = NDArray[np.float32]
RATE = 16_000  # samples a second, of the microphone
DECOYS = 24
WORTH = 15.0  # times as likely as a decoy
LEAST = -4.6  # fit of a word that is taken for recognised
_POOL = (
    "mountain", "seven", "window", "under", "purple", "children", "table", "question", "river", "yesterday",
    "picture", "sugar", "machine", "travel", "country", "little", "number", "story", "beautiful",
    "different", "which", "jump", "chair", "good", "ask", "music", "paper", "yellow", "orange", "winter", "kitchen",
    "pencil", "teacher", "building", "sister", "birthday", "coffee", "hospital", "finger", "carpet", "tomorrow",
    "nobody", "weather", "potato", "market", "holiday", "letter",
)  # fmt: skip
_ALIKE = 0.65  # of the sounds: a decoy that is so like a word would take its place
_ONE_WORD = 1.4  # s: what is longer is listened to as several words
_PAUSE, _FRAME = 0.2, 0.02  # s: of silence between two pieces; of a look at the loudness
_QUIET = 0.012  # of full scale: never taken for speech
_EDGE = RATE // 8  # samples kept before and after a piece
MOST_WORDS = 1_000
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


@dataclass(frozen=True)
class Word:
    """A word of a sensor as tokens of the recogniser, so that no text of a cell gets into its grammar."""

    text: str
    tokens: tuple[str, ...]


class Listener:
    """The words of one sensor."""

    def __init__(self, name: str, words: Sequence[Word]) -> None:
        self.name = name
        self.words = words

    def among(self, tokens: Sequence[str]) -> list[tuple[Word, int]]:
        """Return the words in recognised tokens, with their places; where one word begins another, the longer one."""
        found, place = [], 0
        while place < len(tokens):
            fits = [w for w in self.words if tuple(tokens[place : place + len(w.tokens)]) == w.tokens]
            best = max(fits, key=lambda w: len(w.tokens), default=None)
            if best is not None:
                found.append((best, place))
            place += len(best.tokens) if best is not None else 1
        return found


class Phonetics(Protocol):
    """Library that knows how words of a language are said."""

    def voice(self, name: str) -> bool:
        """Choose a language, such as `en-us`; False when it is not there."""
        ...

    def phonemes(self, text: str) -> str:
        """Return the pronunciation of a text, in letters of the phonetic alphabet."""
        ...


class Ear:
    """The recogniser, loaded once, with only the sensors' words and decoys; raises ImportError if not installed."""

    def __init__(self, wanted: Sequence[str], phonetics: Callable[[], Phonetics | None]) -> None:
        import soxr  # noqa: F401  # the microphone needs it
        from pocketsphinx import Decoder, get_model_path

        model = Path(get_model_path()) / "en-us"
        self._decoder: Decoder = Decoder(hmm=str(model / "en-us"), dict=None, lm=None, samprate=RATE, loglevel="FATAL")
        self._sounds = Pronunciations(model / "cmudict-en-us.dict", [*wanted, *_POOL], phonetics())
        self._tokens: dict[str, str] = {}

    def listener(self, name: str, words: Sequence[str]) -> tuple[Listener, list[str], list[tuple[str, str]]]:
        """Return a listener for words, the words that cannot be recognised, and pairs that sound the same."""
        known: dict[tuple[str, ...], Word] = {}
        deaf, same = list[str](), list[tuple[str, str]]()
        for text in words[:MOST_WORDS]:
            tokens = tuple(self._token(piece) for piece in pieces(text))
            sounds = tuple(" ".join(self._sounds.of(piece)[:1]) for piece in pieces(text))
            if not tokens or not all(sounds):
                deaf.append(text)
            elif sounds in known:
                same.append((known[sounds].text, text))
            else:
                known[sounds] = Word(text, tokens)
        found = Listener(name, tuple(known.values()))
        if known:
            alternatives = [f"/{WORTH}/ {' '.join(w.tokens)}" for w in found.words]
            alternatives += [f"/1/ {token}" for token in self._decoys(found.words)]
            for kind, end in (("one", ""), ("many", "+")):
                grammar = f"#JSGF V1.0;\ngrammar g;\npublic <said> = ( {' | '.join(alternatives)} ){end};\n"
                self._decoder.add_jsgf_string(f"{name} {kind}", grammar)
        return found, deaf, same

    def recognise(self, listener: Listener, sound: Signal) -> list[tuple[str, float]]:
        """Return the words in a sound from the microphone, in order, each with a confidence from 0 to 1."""
        if not listener.words:
            return []
        return [found for piece in split(sound) for found in self._piece(listener, piece)]

    def _piece(self, listener: Listener, sound: Signal) -> list[tuple[str, float]]:
        kind = "one" if len(sound) < _ONE_WORD * RATE else "many"
        segments = self._decode(f"{listener.name} {kind}", sound)
        spoken = [s for s in segments if s[0].startswith("w")]
        found = listener.among([s[0] for s in spoken])
        fits = [
            (word.text, math.fsum(s[3] for s in part) / sum(s[2] for s in part))
            for word, place in found
            if (part := spoken[place : place + len(word.tokens)])
        ]
        return [(text, sure(fit)) for text, fit in fits if fit >= LEAST]

    def _decode(self, name: str, sound: Signal) -> list[tuple[str, int, int, float]]:
        """Return the recognised segments: (token, first frame, frames, logarithm of how well it fits)."""
        decoder: Any = self._decoder
        decoder.activate_search(name)
        decoder.start_utt()
        data = (np.clip(sound, -1, 1) * 32767).astype(np.int16).tobytes()
        decoder.process_raw(data, no_search=False, full_utt=True)
        decoder.end_utt()
        if decoder.hyp() is None:
            return []
        return [
            (s.word.partition("(")[0], s.start_frame, s.end_frame - s.start_frame + 1, math.log(max(s.ascore, 1e-300)))
            for s in decoder.seg()
        ]

    def _token(self, piece: str) -> str:
        if piece not in self._tokens:
            token = self._tokens[piece] = f"w{len(self._tokens)}"
            for place, sounds in enumerate(self._sounds.of(piece)):
                self._decoder.add_word(token if place == 0 else f"{token}({place + 1})", sounds, False)
        return self._tokens[piece]

    def _decoys(self, words: Sequence[Word]) -> list[str]:
        """Return tokens of words that sound unlike those of the sensor."""
        known = {token: piece for piece, token in self._tokens.items()}
        mine = [self._sounds.of(known[t])[0].split() for t in {t for w in words for t in w.tokens}]
        unlike = [
            piece for piece in _POOL
            if not any(_ratio(self._sounds.of(piece)[0].split(), sounds) >= _ALIKE for sounds in mine)
        ]  # fmt: skip
        return [self._token(piece) for piece in (unlike or _POOL)[:DECOYS]]


def _ratio(one: list[str], other: list[str]) -> float:
    return difflib.SequenceMatcher(None, one, other, autojunk=False).ratio()


def sure(fit: float) -> float:
    """Return a confidence from 0 to 1 for how well a word fits (its mean over 10 ms, as a logarithm).

    >>> sure(-1.0) > sure(-3.0) > sure(-6.0)
    True
    """
    return round(1 / (1 + math.exp(-1.5 * (fit + 3.0))), 3)


def split(sound: Signal) -> list[Signal]:
    """Return the pieces of speech between pauses."""
    frame = round(_FRAME * RATE)
    count = len(sound) // frame
    if not count:
        return []
    loud = np.sqrt((sound[: count * frame].reshape(count, frame) ** 2).mean(axis=1))
    speaks = loud > max(_QUIET, 3 * float(np.quantile(loud, 0.05)))
    found: list[list[int]] = []
    for k in np.flatnonzero(speaks):
        if found and k - found[-1][1] <= _PAUSE / _FRAME:
            found[-1][1] = int(k)
        else:
            found.append([int(k), int(k)])
    return [sound[max(0, a * frame - _EDGE) : (b + 1) * frame + _EDGE] for a, b in found]


def pieces(text: str) -> list[str]:
    """Return the single words of a phrase, as a dictionary has them.

    >>> pieces("Blood test!"), pieces("X-ray"), pieces("Don’t"), pieces("?")
    (['blood', 'test'], ['x', 'ray'], ["don't"], [])
    """
    return [piece.replace("’", "'") for piece in _PIECE.findall(unicodedata.normalize("NFKC", text).casefold())]


def sounds_of(ipa: str) -> str:
    """Return the recogniser's sounds for phonetic letters; stress and unknown letters are left out.

    >>> sounds_of("jˈɛstɚdˌeɪ"), sounds_of("ˈɛksɹˈeɪ"), sounds_of("()")
    ('Y EH S T ER D EY', 'EH K S R EY', '')
    """
    return " ".join(_SOUNDS[found] for found in _ANY.findall(re.sub(r"\([^)]*\)|[ˈˌ]", "", ipa)))


class Pronunciations:
    """Looks up the sounds of words in the recogniser's dictionary, or derives them with the speech library.

    Only the given words of the dictionary are kept.
    """

    def __init__(self, dictionary: Path, words: Iterable[str], speech: Phonetics | None) -> None:
        wanted, self._speech = set(words), speech
        self._known: dict[str, list[str]] = {}
        with dictionary.open(encoding="utf-8", errors="replace") as lines:
            for line in lines:
                word, _, sounds = line.partition(" ")
                word = word.partition("(")[0]
                if word in wanted and sounds:
                    self._known.setdefault(word, []).append(sounds.strip())

    def of(self, word: str) -> list[str]:
        """Return the ways to say a word, as sounds with spaces between them; empty when they are unknown."""
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
