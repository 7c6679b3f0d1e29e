"""Speech of people: a voice for each, audio that is kept as .wav, its way to the robot's microphone, and what is heard.

The microphone hears everybody at once, quieter from farther away, with the noise of the room, and nothing while the
robot itself speaks and a moment longer; a sound that it plays is noise.
"""

from __future__ import annotations

import math
import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from rrp_sheets.model.exchange import DeviceUse, Notice, SceneAction
from rrp_sheets.model.japanese import LETTERS
from rrp_sheets.model.names import key
from rrp_sheets.perception.word_recognition import RATE, Ear, Listener, Signal, pieces
from rrp_sheets.sim.arbitration import Tell
from rrp_sheets.sim.sounds import Audio, Espeak, Speech, keep
from rrp_sheets.sim.stage import Stage
from rrp_sheets.texts import N_

MOST_TOLD = 5  # words that cannot be recognised, in one message
AFTER_US = 250_000  # the robot hears again so long after it has spoken
LONGEST_US = 10_000_000  # of audio that is recognised at once; longer speech comes in parts
PAD = RATE // 5  # samples of noise before and after an utterance, for the recogniser
NEAR = 0.5  # m: nearer than that nobody is louder
FAR_AWAY = 1.0  # m, of who speaks without being seen
SELF_NOISE, NOISE = 0.0025, 0.04  # of full scale: the microphone's own; of a room at 100 %: half as loud as speech
OWN_SOUND = 0.3  # of a sound that the robot plays, as noise: it knows the sound, and takes most of it away
MOST_AT_ONCE = 6  # people whose speech is heard at the same time
SPEED = 140  # words a minute
_CHILDREN = ("child", "kid", "boy", "girl")
_WOMEN = ("a", "ie", "woman", "therapist", "mother")  # how names end
_VOICES = {  # espeak-ng's variants, each with a pitch (0 to 100); those with breath differ from run to run
    "female": (("en-us+f1", 48), ("en-us+f1", 55), ("en-us+f1", 62)),
    "male": (("en-us", 50), ("en-us+m3", 50), ("en-us+m1", 50), ("en-us+m6", 50)),
    "child": (("en-us+f1", 72), ("en-us+f1", 80), ("en-us+f1", 88)),
}


def voice_of(name: str, kind: str = "") -> tuple[str, int]:
    """Return a person's voice: of the kind that the scene gives, else as the name suggests; always the same.

    >>> voice_of("Child 2") in _VOICES["child"], voice_of("Mia", "male") in _VOICES["male"]
    (True, True)
    """
    if not kind:
        woman = key(name).endswith(_WOMEN)
        kind = "child" if key(name).startswith(_CHILDREN) else "female" if woman else "male"
    voices = _VOICES.get(kind, _VOICES["female"])
    return voices[zlib.crc32(key(name).encode("utf-8", "replace")) % len(voices)]


@dataclass
class PendingSpeech:
    """Speech of one person, reported when no sensor recognises a word in it."""

    action: SceneAction
    text: str
    cut: bool = False  # the robot could not hear all of it, since it spoke itself
    heard: bool = False  # a sensor recognised a word in it


@dataclass
class Utterance:
    """Sound at the microphone until nobody speaks any more."""

    start_us: int
    sound: Signal  # without noise
    said: list[PendingSpeech] = field(default_factory=list)
    deaf: list[tuple[int, int]] = field(default_factory=list)
    noise: float = 0.0  # of the room, 0 to 1, in the mean
    steps: int = 0
    is_last: bool = True  # False for the first parts of a long speech
    at_microphone: Signal | None = None  # the sound with noise, once a sensor has listened to it

    @property
    def end_us(self) -> int:
        """Time at which the audio ends, in microseconds."""
        return self.start_us + len(self.sound) * 1_000_000 // RATE

    def mix(self, sound: Signal, us: int) -> None:
        """Add another person's speech, from a time on."""
        first = (us - self.start_us) * RATE // 1_000_000
        whole = np.zeros(max(len(self.sound), first + len(sound)), np.float32)
        whole[: len(self.sound)] = self.sound
        whole[first : first + len(sound)] += sound
        self.sound = whole


class Talk:
    """Lets people speak, and gives the sound at the robot's microphone. Without a folder it keeps no files."""

    def __init__(self, stage: Stage, speech: Speech, out: Path | None, tell: Tell, seed: int) -> None:
        self._stage, self._speech, self._out, self._tell, self._seed = stage, speech, out, tell, seed
        self._busy: dict[str, int] = {}  # until when everybody speaks
        self._waiting: list[tuple[int, SceneAction]] = []
        self._open: Utterance | None = None
        self._deaf_until = 0
        self._count = 0
        self._us = 0
        self.over: list[Utterance] = []  # at the present step

    def say(self, action: SceneAction) -> None:
        """Schedule what a person says, now or after what they are saying."""
        begins = max(self._busy.get(key(action.thing), 0), action.time_us)
        self._waiting.append((begins, action))

    def go_on(self, us: int, speaking: bool, playing: bool) -> None:
        """Advance to the time `us`, while the robot speaks, plays a sound, or is silent."""
        self.over = []
        if speaking:
            self._deaf_until = us + AFTER_US
        now = self._open
        if now is not None:
            now.noise += max(self._stage.noise, OWN_SOUND if playing else 0.0)
            now.steps += 1
            if us < self._deaf_until:
                now.deaf.append((self._us, us + 1))
            if us >= now.end_us or us - now.start_us >= LONGEST_US:
                self._end(now, us)
        waiting, self._waiting = self._waiting, []
        for begins, action in waiting:
            busy = self._busy.get(key(action.thing), 0)
            if max(begins, busy) > us:
                self._waiting.append((max(begins, busy), action))
            else:
                self._begin(action, us)
        self._us = us

    def _begin(self, action: SceneAction, us: int) -> None:
        text = str(action.values.get("words", ""))
        row = f"Scene!{action.row}" if action.row else ""
        speaking = [name for name, until in self._busy.items() if until > us]
        if len(speaking) >= MOST_AT_ONCE:
            told = N_(
                "{thing} says “{words}”: nobody hears it, because too many speak at the same time.",
                thing=action.thing, words=text,
            )  # fmt: skip
            self._tell(Notice("note", told, row=row))
            return
        library = self._speech.library()
        audio = np.zeros(0, np.int16) if library is None else self._speak(library, action, text)
        rate = RATE if library is None else library.rate
        self._busy[key(action.thing)] = us + len(audio) * 1_000_000 // rate
        file = ""
        if len(audio):
            self._count += 1
            file = f"person-{self._count:03}.wav"
            if self._out is not None:
                keep(self._out / file, audio, rate, self._tell)
        told = N_("{thing} says “{words}”", thing=action.thing, words=text)
        self._tell(Notice("person", told, row=row, sound=file if self._out else ""))
        sound = self._at_microphone(action, audio, rate)
        if self._open is None:
            self._open = Utterance(us, sound)
        else:
            self._open.mix(sound, us)
        self._open.said.append(PendingSpeech(action, text))

    def _speak(self, library: Espeak, action: SceneAction, text: str) -> Audio:
        person = self._stage.persons.get(key(action.thing))
        voice, pitch = voice_of(action.thing, person.voice if person is not None else "")
        if not library.voice(voice.replace("en-us", "ja") if LETTERS.search(text) else voice):
            library.voice("en")
        audio = library.say(text, SPEED, 100, pitch, self._speech.halted)
        library.voice("en")
        return audio

    def _at_microphone(self, action: SceneAction, audio: Audio, rate: int) -> Signal:
        person, far = self._stage.persons.get(key(action.thing)), FAR_AWAY
        if person is not None:
            far = max(NEAR, math.dist(person.path.at(self._stage.us)[:2], (0.0, 0.0)))
        return np.asarray(resampled(np.asarray(audio / 32768, np.float32), rate) / far, np.float32)

    def _end(self, now: Utterance, us: int) -> None:
        """Pass on what was said until now for recognition; the rest of a long speech comes later."""
        self._open = None
        taken = (us - now.start_us) * RATE // 1_000_000
        if len(rest := now.sound[taken:]):
            self._open = Utterance(us, rest, now.said)
            now.is_last = False
        now.sound = now.sound[:taken].copy()
        for begin, end in now.deaf:
            first, last = ((t - now.start_us) * RATE // 1_000_000 for t in (begin, end))
            now.sound[max(0, first) : max(0, last)] = 0
        for said in now.said:
            said.cut = said.cut or bool(now.deaf)
        now.noise /= max(1, now.steps)
        self.over.append(now)

    def microphone(self, heard: Utterance) -> Signal:
        """Return an utterance with the noise of room and microphone, as the recogniser gets it; mixed only once."""
        if heard.at_microphone is None:
            sound = np.concatenate([np.zeros(PAD, np.float32), heard.sound, np.zeros(PAD, np.float32)])
            mixed = sound + noise(len(sound), heard.noise, (self._seed, heard.start_us))
            heard.at_microphone = np.asarray(mixed, np.float32)
        return heard.at_microphone


def resampled(sound: Signal, rate: int) -> Signal:
    """Return a sound at the microphone's rate; silence of its length without soxr, which recognition needs too."""
    try:
        import soxr
    except ImportError:
        return np.zeros(len(sound) * RATE // rate, np.float32)
    return np.asarray(soxr.resample(sound, rate, RATE), np.float32)


def noise(count: int, level: float, seed: tuple[int, int]) -> Signal:
    """Return samples of a room's noise, deeper tones stronger; the same for the same seed (of run and place in it).

    Its level is 0 (only the microphone's own) to 1 (as loud as speech).
    """
    chance = np.random.default_rng([abs(n) for n in seed])
    tones = np.fft.rfft(chance.standard_normal(count))
    low = max(1.0, count * 60 / RATE)
    tones /= np.sqrt(np.maximum(np.arange(len(tones)), low))
    room = np.fft.irfft(tones, count) if count > 1 else np.zeros(count)
    room /= max(float(room.std()), 1e-12)
    return np.asarray(room * (SELF_NOISE + NOISE * level), np.float32)


class Hearing:
    """Recognises what people say for the sensors that listen for words."""

    def __init__(self, talk: Talk, speech: Speech, tell: Tell, sensors: Sequence[DeviceUse]) -> None:
        wanted = [str(word) for s in sensors for word in s.settings.get("words") or ()]
        self._talk, self._tell = talk, tell
        self._ear: Ear | None = None
        self._listeners: list[tuple[tuple[str, ...], Listener]] = []
        if wanted:
            try:
                self._ear = Ear([piece for word in wanted for piece in pieces(word)], speech.library)
            except ImportError as error:
                package = error.name or "pocketsphinx"
                text = N_("The robot cannot recognise words, because the package {package} is not installed. Type them "
                          "in the run panel: Send a value.", package=package)  # fmt: skip
                self._tell(Notice("error", text))

    def listen(self, stream: str, words: Sequence[str]) -> Listener | None:
        """Listen for a sensor's words; None when nothing can be recognised."""
        if self._ear is None:
            return None
        listener, deaf, same = self._ear.listener(f"s{len(self._listeners)}", words)
        if deaf:
            told = N_("{words} cannot be heard: only English words are recognised. Type it in the run panel: Send a "
                      "value.", words=", ".join(f"“{text}”" for text in deaf[:MOST_TOLD]))  # fmt: skip
            self._tell(Notice("error", told, stream))
        for one, other in same:
            told = N_("“{other}” sounds like “{one}”: it is heard as “{one}”.", other=other, one=one)
            self._tell(Notice("note", told, stream))
        self._listeners.append((tuple(words), listener))
        return listener

    def words(self, listener: Listener) -> list[tuple[str, float]]:
        """Return the words that a sensor recognises in the utterances that end at this step."""
        found = []
        for utterance in self._talk.over:
            assert self._ear is not None
            words = self._ear.recognise(listener, self._talk.microphone(utterance))
            found += words
            for said in utterance.said if words else ():
                said.heard = True
        return found

    def notes(self) -> list[Notice]:
        """Return notes on speech in which no sensor recognised a word; call it after the sensors were read."""
        return [
            Notice("note", self._unheard(said, utterance), row=f"Scene!{said.action.row}" if said.action.row else "")
            for utterance in self._talk.over if utterance.is_last
            for said in utterance.said if not said.heard
        ]  # fmt: skip

    def _unheard(self, said: PendingSpeech, utterance: Utterance) -> str:
        template = N_("{thing} says “{words}”: the robot did not understand it.")
        if not self._listeners:
            template = N_("{thing} says “{words}”: no sensor of this workbook listens for words.")
        elif said.cut:
            template = N_("{thing} says “{words}”: the robot does not hear while it speaks.")
        elif not any(words_in(said.text, words) for words, _ in self._listeners):
            template = N_("{thing} says “{words}”: no sensor of this workbook listens for that.")
        elif not said.text.isascii():
            template = N_("{thing} says “{words}”: the robot did not understand it, because it knows only English "
                          "words.")  # fmt: skip
        elif utterance.noise >= 0.05:
            template = N_("{thing} says “{words}”: the robot did not understand it. The noise is {noise}.")
        return N_(template, thing=said.action.thing, words=said.text, noise=f"{utterance.noise:.0%}")


def words_in(text: str, words: tuple[str, ...]) -> list[str]:
    """Return those of the words (or phrases) that occur in a text, in the text's order.

    >>> words_in("Yes, okay! Yesterday…", ("no", "okay", "yes"))
    ['yes', 'okay']
    """
    said = _spoken(text)
    places = []
    for word in words:
        place = said.find(_spoken(word))
        if place < 0 and not word.isascii():  # languages that write without spaces
            place = text.casefold().find(word.casefold())
        if place >= 0 and word:
            places.append((place, word))
    return [word for _, word in sorted(places, key=lambda p: p[0])]


def _spoken(text: str) -> str:
    return " " + " ".join(re.findall(r"\w+", text.casefold())) + " "
