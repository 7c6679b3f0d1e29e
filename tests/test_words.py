"""People speak real audio, and the robot recognises words in it."""

from __future__ import annotations

import sys
import wave

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("pocketsphinx")
pytest.importorskip("soxr")

from play import findings, rows
from processes import end_simulator

from rrp_sheets.drivers.simulated import SimulatedWorld
from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.perception.word_recognition import Ear, split
from rrp_sheets.robots import load_robot
from rrp_sheets.sim import sounds as voices
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.sounds import Speech
from rrp_sheets.sim.talk import noise, voice_of
from rrp_sheets.sim.world import SimWorld

NAO = load_robot()
SAY = DeviceUse("say", "Say", "SayInput", {"language": "en", "speed": 150, "volume": 100})
DRUM = DeviceUse("drum", "Drum", "PlaySound", {"sound": "Drum", "file": "", "volume": 100})


def ear(*words: str, stream: str = "words") -> DeviceUse:
    return DeviceUse(stream, stream.title(), "WordRecognized", {"words": words})


def says(second: float, who: str, text: str, row: int = 2) -> SceneAction:
    return SceneAction(round(second * 1e6), who, "say", {"words": text}, row)


class Heard:
    """A world that goes on until `seconds`; what came of it."""

    def __init__(self, sensors, scene, seconds, *, orders=None, seed=0, out="", actuators=(SAY, DRUM)):
        world = SimWorld(Spec(NAO, tuple(sensors), actuators, tuple(scene), seed=seed, out=str(out)))
        try:
            outcome, self.events, self.told = world.start(), [], []
            for frame in range(1, round(seconds * 30) + 1):
                self.take((frame - 1) / 30, outcome)
                outcome = world.advance(frame * 1_000_000 // 30, (orders or {}).get(frame, ()))
            self.take(seconds, outcome)
        finally:
            world.close()

    def take(self, t, outcome):
        self.events += [(t, stream, v) for stream, v in outcome.events]
        self.told += [(t, h.kind, h.text, h.row, h.sound) for h in outcome.notices]

    @property
    def words(self):
        return [v["word"] for _, s, v in self.events if "word" in v]

    def texts(self, kind):
        return [text for _, k, text, _, _ in self.told if k == kind]


def test_words_and_phrases_are_recognised_when_they_have_been_said(tmp_path):
    scene = [says(0.2, "Child", "yes", 7), says(1.5, "Tom", "The blood test, no? Yes!"), says(5, "Kai", "banana")]
    heard = Heard([ear("yes", "no", "blood test")], scene, 6, out=tmp_path)
    assert heard.words == ["yes", "blood test", "no", "yes"]
    assert all(0 < v["confidence"] <= 1 for _, _, v in heard.events)
    spoken = [h for h in heard.told if h[1] == "person"]
    assert [h[2:] for h in spoken[:2]] == [
        ("Child says “yes”", "Scene!7", "person-001.wav"),
        ("Tom says “The blood test, no? Yes!”", "Scene!2", "person-002.wav"),
    ]
    with wave.open(str(tmp_path / "person-001.wav")) as file:
        seconds = file.getnframes() / file.getframerate()
        assert 0.3 < seconds < 1 and any(file.readframes(file.getnframes()))
    assert heard.events[0][0] == pytest.approx(0.2 + seconds, abs=0.05)  # when the audio is over
    assert heard.texts("note") == ["Kai says “banana”: no sensor of this workbook listens for that."]


def test_the_robot_is_deaf_while_it_speaks_but_not_while_it_plays():
    speech = {2: [Command("say", "Hello, I am a robot, and I like to talk.", "T!2")], 105: [Command("drum", 1, "T!3")]}
    heard = Heard([ear("yes", "no")], [says(0.5, "Child", "yes"), says(3.8, "Child", "no")], 5, orders=speech)
    assert heard.words == ["no"]
    assert heard.texts("note") == ["Child says “yes”: the robot does not hear while it speaks."]
    assert heard.texts("sound") == ["Drum"]


def apart(seed: int) -> list[tuple]:
    """Words heard in a process of its own, as in every run."""
    scene = [
        SceneAction(0, "Noise", "level", {"to": 0.1}, kind="noise"),
        says(0.2, "Tom", "seven"),
        says(1.2, "Mia", "dance"),
    ]
    world = SimulatedWorld(NAO, (ear("seven", "dance", "sleep"),), (), scene, seed=seed)
    try:
        found = list(world.start().events)
        for frame in range(1, 65):
            found += [(frame, *v.as_dict().values()) for _, v in world.advance(frame * 1_000_000 // 30, ()).events]
        return found
    finally:
        end_simulator(world)


@pytest.mark.slow
def test_what_is_heard_depends_on_nothing_but_workbook_and_seed():
    first, second, other = (apart(seed) for seed in (4, 4, 5))
    assert first == second != other
    assert [word for _, word, _ in first] == ["seven", "dance"]
    same, again, others = (noise(500, 0.5, (seed, 7)) for seed in (4, 4, 5))
    assert (same == again).all() and (same != others).any()


def test_people_have_voices():
    assert voice_of("Child 3")[1] > 70 and voice_of("Anna", "child")[1] > 70
    assert voice_of("Tom") == voice_of("Tom") and "+f" in voice_of("Emma")[0]
    assert "+f" not in voice_of("Emma", "male")[0]


def test_several_people_speak_at_once_and_one_after_another():
    """One person's sentences follow each other; what two say together is one utterance."""
    crowd = [says(0.1, f"Person {n}", "hello") for n in range(9)]
    heard = Heard([ear("hello")], crowd, 1.5)
    assert heard.words.count("hello") <= 1
    assert len(heard.texts("person")) == 6
    assert sum("too many speak" in note for note in heard.texts("note")) == 3
    heard = Heard([ear("seven", "elephant")], [says(0.1, "Tom", "seven"), says(0.2, "Tom", "elephant")], 3)
    starts = [t for t, kind, *_ in heard.told if kind == "person"]
    assert heard.words == ["seven", "elephant"] and starts[1] - starts[0] > 0.4


@pytest.mark.slow
def test_speech_longer_than_the_run_and_than_the_recogniser_takes_at_once():
    text = "I went to the market with my mother and we saw the animals there. " * 8 + "Elephant!"
    heard = Heard([ear("elephant")], [says(0.1, "Mia", text)], 2)
    assert heard.words == [] and len(heard.texts("person")) == 1
    heard = Heard([ear("elephant")], [says(0.1, "Mia", "Elephant! " * 10)], 12)
    assert heard.words.count("elephant") >= 9
    assert heard.events[0][0] < 10.5  # not only at the end


HOSTILE = (
    "yes",
    "); <x> = ( | *",
    "#JSGF",
    "{tag}",
    "🙂",
    "はい",
    "?",
    "a" * 900,
    "\x00",
    "yes!",
    "to",
    "two",
    "%s\n",
    "w0",
)


def test_hostile_words_are_told_and_do_no_harm():
    heard = Heard([ear(*HOSTILE)], [says(0.2, "Child", "yes"), says(1.5, "🙂", "\x00"), says(2, "Kai", "はい")], 4)
    assert heard.words == ["yes"]
    (trouble,) = heard.texts("error")
    assert "“🙂”" in trouble and "“はい”" in trouble and "Send a value" in trouble
    notes = heard.texts("note")
    assert "“yes!” sounds like “yes”: it is heard as “yes”." in notes
    assert "“two” sounds like “to”: it is heard as “to”." in notes
    assert any(
        "it knows only English words" in note or "not listens" in note or "listens for" in note for note in notes
    )


def test_most_words_are_right_and_few_others_are_taken_for_one():
    """The benchmark says how many, for more words, voices and noise."""
    world = SimWorld(Spec(NAO, (ear("yes", "no", "doctor", "stop", "hello", "seven"),)))
    sensor = world._sensors[0][1]
    try:
        said = (
            "yes",
            "no",
            "doctor",
            "stop",
            "hello",
            "seven",
            "garden",
            "music",
            "window",
            "tomorrow",
            "paper",
            "tree",
        )
        right = []
        for place, text in enumerate(said):
            listener, talk = sensor._listener, world.talk
            talk.say(SceneAction(place * 9_000_000, f"Person {place}", "say", {"words": text}))
            for us in range(place * 9_000_000, place * 9_000_000 + 3_000_000, 100_000):
                talk.go_on(us, False, False)
                if talk.over:
                    right.append([w for w, _ in world.hearing.words(listener)] == ([text] if place < 6 else []))
        assert len(right) == 12 and sum(right[:6]) >= 5 and sum(right[6:]) >= 4
    finally:
        world.close()


def test_many_words():
    speech = Speech(lambda h: None)
    words = [f"{a} {b}" for a in ("red", "green", "happy", "little", "seven") for b in
             ["apple", "bird", "cat", "dog", "ear", "fish", "goat", "hand", "ice", "jam", "kite", "lamp", "moon", "nose", "oven", "pig", "queen", "rose", "sun", "tree"]] * 5  # fmt: skip
    words = list(dict.fromkeys(words))
    listening = Ear([p for w in words for p in w.split()], speech.library)
    listener, deaf, same = listening.listener("many", words)
    assert len(listener.words) == len(words) == 100 and not deaf and not same


def test_pieces_between_pauses():
    quiet, loud = noise(8000, 0.0, (1, 1)), noise(8000, 1.0, (1, 2)) * 3
    import numpy as np

    assert len(split(np.concatenate([quiet, loud, quiet, loud, quiet]))) == 2
    assert split(quiet) == [] and split(quiet[:100]) == []


@pytest.mark.parametrize("missing", ["pocketsphinx", "soxr"])
def test_without_the_recogniser_the_run_says_so_in_one_line(missing, monkeypatch):
    monkeypatch.setitem(sys.modules, missing, None)
    heard = Heard([ear("yes"), ear("no", stream="more")], [says(0.1, "Child", "yes")], 1.2)
    (line,) = heard.texts("error")
    assert line.startswith(f"The robot cannot recognise words, because the package {missing} is not installed.")
    assert heard.words == []


def test_people_who_say_japanese_have_japanese_voices(tmp_path):
    heard = Heard([ear("yes")], [says(0.1, "Mia", "はい、三つできました")], 3, out=tmp_path)
    with wave.open(str(tmp_path / "person-001.wav")) as sound:
        assert 1 < sound.getnframes() / sound.getframerate() < 2.2  # 12 s as letters in English
    assert heard.words == []
    assert heard.texts("note") == ["Mia says “はい、三つできました”: no sensor of this workbook listens for that."]


def test_without_a_speech_library_nobody_speaks(monkeypatch):
    def broken():
        raise voices.NoSpeech

    monkeypatch.setattr(voices, "espeak", broken)
    heard = Heard([ear("yes")], [says(0.1, "Child", "yes")], 1)
    assert heard.words == [] and heard.texts("error") == [voices.NO_SPEECH]


@pytest.mark.parametrize(("words", "expected"), [
    ("yes, no", []), ("blood test, x-ray", []), ("yes, はい", [("DEV011", "C2")]), ("🙂", [("DEV011", "C2")]),
    ("да", [("DEV011", "C2")]), ("yes, please; no", [("DEV013", "C2")]), ('"yes, please"; no', []), ("yes; please", []), ("no, Thank you", [("DEV014", "C2")]), ('"no, thank you"', []), (", ;", [("DEV004", "C2")]), ("café", []),
])  # fmt: skip
def test_words_that_cannot_be_heard_are_told_at_their_cell(words, expected):
    book = rows("| Heard | subscribe | heard.word | Print |",
                f"\n## Devices\n| Stream | Device | Words |\n|---|---|---|\n| Heard | Word recognized | {words} |\n")  # fmt: skip
    assert findings(book) == expected
