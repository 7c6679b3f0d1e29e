"""The robot plays sounds: its own, and files beside the workbook; and it speaks, in several languages."""

from __future__ import annotations

import struct
import sys
import wave
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("pybullet")

from play import findings, rows

from rrp_sheets import api
from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.robots import load_robot
from rrp_sheets.robots.media_files import BadSoundError, Wave, read_wave
from rrp_sheets.sim import sounds as voices
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.sounds import (
    LONGEST,
    RATE,
    SOUNDS,
    espeak,
    from_wave,
    japanese_reader,
    louder,
    own_sound,
    spoken,
)  # fmt: skip
from rrp_sheets.sim.world import SimWorld

NAO = load_robot()
SAY = DeviceUse("say", "Say", "SayInput", {"language": "en", "speed": 150, "volume": 100})


def player(stream: str = "play", **settings: object) -> DeviceUse:
    return DeviceUse(stream, "Play", "PlaySound", {"sound": "Bell", "file": "", "volume": 100, **settings})


def tone(path: Path, seconds: float = 0.4, rate: int = 8_000, width: int = 2, channels: int = 1) -> Path:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(channels)
        file.setsampwidth(width)
        file.setframerate(rate)
        file.writeframes(b"\x10" * round(seconds * rate) * width * channels)
    return path


class Played:
    def __init__(self, actuators, commands, seconds, tmp_path, beside=""):
        dones = {a.stream: f"{a.stream}done" for a in actuators}
        world = SimWorld(Spec(NAO, (), tuple(actuators), out=str(tmp_path), beside=str(beside), dones=dones))
        self.dones = []
        try:
            self.told = [(h.kind, h.text, h.row, h.sound) for h in world.start().notices]
            for frame in range(1, round(seconds * 30) + 1):
                outcome = world.advance(
                    frame * 1_000_000 // 30,
                    [Command(stream, value, f"T!{n}") for n, (stream, value) in enumerate(commands.get(frame, ()), 2)],
                )
                self.dones += [(s, v["completed"], round(v["seconds"], 2)) for s, v in outcome.events]
                self.told += [(h.kind, h.text, h.row, h.sound) for h in outcome.notices]
        finally:
            world.close()


def frames(path: Path) -> tuple[float, int]:
    with wave.open(str(path)) as file:
        data = np.frombuffer(file.readframes(file.getnframes()), "<i2")
        return file.getnframes() / file.getframerate(), int(np.abs(data).max(initial=0))


@pytest.mark.slow
@pytest.mark.parametrize("name", SOUNDS)
def test_its_own_sounds_are_always_the_same_and_neither_silent_nor_cut(name):
    sound = own_sound(name)
    assert (sound == own_sound(name)).all()
    assert 0.5 * RATE < len(sound) < 20 * RATE and abs(int(sound[-1])) < 400
    assert 24_000 < np.abs(sound).max() < 32_000 and sound.astype(float).std() > 2_000


def test_the_catalogue_offers_every_sound_that_there_is():
    assert NAO.devices["playsound"].settings["sound"].choices == tuple(SOUNDS)
    assert len({own_sound(name).tobytes() for name in SOUNDS}) == len(SOUNDS)


def test_dance_music_has_a_beat():
    """The loudest moments of the music are half a second apart."""
    music = own_sound("Dance music").astype(float)
    loud = np.add.reduceat(music**2, np.arange(0, len(music), RATE // 100))
    rises = np.maximum(np.diff(loud), 0)[:1_500]
    alike = [float(rises[lag:] @ rises[:-lag]) for lag in range(20, 80)]
    assert 20 + int(np.argmax(alike)) == 50


@pytest.mark.slow
def test_a_sound_is_kept_and_ends_and_takes_its_turn_with_speech(tmp_path):
    played = Played((player(sound="Tada"), SAY), {1: [("play", 1), ("say", "Well done!")]}, 3.4, tmp_path)
    assert [t[:2] + t[3:] for t in played.told] == [
        ("sound", "Tada", "sound-001.wav"), ("say", "Well done!", "say-001.wav"),
    ]  # fmt: skip
    assert [d[:2] for d in played.dones] == [("playdone", True), ("saydone", True)]
    assert played.dones[0][2] == pytest.approx(1.4, abs=0.05)
    assert frames(tmp_path / "sound-001.wav")[0] == pytest.approx(1.4, abs=0.01)


def test_blank_stops_a_sound_and_speech_at_once(tmp_path):
    commands = {1: [("play", 1)], 10: [("play", None)], 20: [("say", "A long sentence, really.")], 30: [("say", None)]}
    played = Played((player(sound="Dance music"), SAY), commands, 1.4, tmp_path)
    assert played.dones == [("playdone", False, 0.3), ("saydone", False, 0.33)]
    assert frames(tmp_path / "sound-001.wav")[0] == pytest.approx(0.3, abs=0.02)
    assert frames(tmp_path / "say-001.wav")[0] == pytest.approx(0.33, abs=0.02)


def test_volume(tmp_path):
    quiet = (player("a", volume=10), player("b", volume=0), player("c", volume=200))
    Played(quiet, {1: [("a", 1)], 5: [("a", None), ("b", 1)], 10: [("b", None), ("c", 1)]}, 0.6, tmp_path)
    loudest = [frames(tmp_path / f"sound-00{n}.wav")[1] for n in (1, 2, 3)]
    assert 1_000 < loudest[0] < 3_000 and loudest[1] == 0 and loudest[2] > 30_000
    assert louder(np.array([30_000, -30_000], np.int16), 200).tolist() == [32_767, -32_768]


def test_a_file_beside_the_workbook(tmp_path):
    tone(tmp_path / "My song.wav")
    out = tmp_path / "out"
    out.mkdir()
    played = Played((player(file="My song.wav"), player("lost", file="lost.wav")),
                    {1: [("play", 1)], 16: [("lost", 1)]}, 0.7, out, tmp_path)  # fmt: skip
    assert played.dones == [("playdone", True, 0.4), ("lostdone", False, 0.0)]
    assert frames(out / "sound-001.wav")[0] == pytest.approx(0.4, abs=0.01)
    assert played.told[-1][1] == "Play: the file “lost.wav” is not in the folder of the workbook."


@pytest.mark.parametrize(("width", "data", "expected"), [
    (1, bytes([128, 255, 0]), [0, 32_512, -32_768]), (2, struct.pack("<2h", 5, -5), [5, -5]),
    (3, b"\x00\x05\x00\xff\xfa\xff", [5, -6]), (4, struct.pack("<2i", 5 << 16, -5 << 16), [5, -5]),
])  # fmt: skip
def test_samples_of_every_width(width, data, expected):
    assert from_wave(Wave(data, width, 1, 8_000)).tolist() == expected
    twice = b"".join(data[k : k + width] * 2 for k in range(0, len(data), width))
    assert from_wave(Wave(twice, width, 2, 8_000)).tolist() == expected


def broken(folder: Path) -> None:
    tone(folder / "good.wav")
    tone(folder / "long.wav", 301, 4_000, 1)
    tone(folder / "empty.wav", 0)
    tone(folder / "slow.wav", 1, 1_000)
    (folder / "text.wav").write_text("no sound")
    (folder / "cut.wav").write_bytes((folder / "good.wav").read_bytes()[:20])
    (folder / "large.wav").write_bytes(b"RIFF" + bytes(20_000_001))
    (folder / "folder.wav").mkdir()
    outside = folder.parent / f"{folder.name}-outside.wav"
    tone(outside)
    (folder / "link.wav").symlink_to(outside)


BAD = {
    "long": "lasts 301 s", "empty": "is empty", "slow": "1,000 samples a second", "text": "save it as 16-bit PCM",
    "cut": "save it as 16-bit PCM", "large": "has 20 MB", "folder": "is not in the folder", "lost": "is not in the folder",
    "link": "leaves the folder",
}  # fmt: skip


def test_files_that_cannot_be_played_are_told_when_the_workbook_is_checked(tmp_path):
    broken(tmp_path)
    devices = "\n## Devices\n| Stream | Device | File |\n|---|---|---|\n"
    names = [f"{n}.wav" for n in BAD] + ["good.wav", "godo.wav", "../good.wav", "/etc/passwd", "good.mp3"]
    uses = [f"| P{n} | Play sound | {name} |" for n, name in enumerate(names)]
    steps = "\n".join(f"| Chest button | subscribe | | P{n} |" for n in range(len(names)))
    book = tmp_path / "book.md"
    book.write_text(rows(steps, devices + "\n".join(uses) + "\n"), encoding="utf-8")
    found = [d for d in api.check(book).report if d.code in ("DEV004", "DEV012")]
    cells = {d.address.cell: d for d in found if d.address}
    for place, words in enumerate(BAD.values(), 2):
        assert words in cells[f"C{place}"].message, words
    assert f"C{2 + len(BAD)}" not in cells  # good.wav
    assert "Did you mean good.wav?" in cells[f"C{3 + len(BAD)}"].remedy
    assert [cells[f"C{4 + len(BAD) + k}"].code for k in range(3)] == ["DEV004"] * 3
    for name, words in BAD.items():
        with pytest.raises(BadSoundError, match=words):
            read_wave(tmp_path, f"{name}.wav")


@pytest.mark.parametrize(("language", "expected"), [
    ("de", []), ("ja", []), ("German", []), ("EN_US", []), ("Germn", ["de (German)"]), ("jap", ["ja (Japanese)"]),
    ("klingon!", ["such as"]),
])  # fmt: skip
def test_languages_are_checked_at_their_cell(language, expected):
    book = rows("| Red ball | subscribe | \"Hello\" | Talk |",
                f"\n## Devices\n| Stream | Device | Language |\n|---|---|---|\n| Talk | Say | {language} |\n")  # fmt: skip
    assert [c for c in findings(book) if c[0].startswith("DEV")] == [("DEV004", "C2")] * len(expected)
    from play import check

    messages = " ".join(f"{d.message} {d.remedy}" for d in check(book).report)
    assert all(words in messages for words in expected)


def test_every_language_of_the_catalogue_can_be_spoken():
    library = espeak()
    assert [code for code in NAO.languages if not library.voice(code)] == []
    sounds = {}
    for code, text in (("en", "Hello, robot"), ("de", "Guten Tag"), ("fr", "Bonjour"), ("ja", "こんにちは")):
        library.voice(code)
        sounds[code] = library.say(text, 150, 100)
        assert 0.4 < len(sounds[code]) / library.rate < 3 and sounds[code].any()
    assert not library.voice("xx-none")


@pytest.mark.parametrize(("text", "kana", "reading"), [
    ("上手ですね。", "じょうずですね。", "ジョーズデスネ。"),
    ("今日は一緒に遊びましょう。", "きょうは いっしょに あそびましょう。", "キョーワ イッショニ アソビマショー。"),
    ("右手を上げて、頭を触って。", "みぎてをあげて、あたまをさわって。", "ミギテヲ アゲテ、 アタマヲ サワッテ。"),
    ("赤いボールはどれですか？", "あかいボールはどれですか？", "アカイ ボールワ ドレデスカ？"),
    ("私の名前はナオです。", "わたしのなまえは ナオです。", "ワタシノ ナマエワ ナオデス。"),
    ("一人で三つ数えてください。", "ひとりで みっつ かぞえてください。", "ヒトリデ ミッツ カゾエテクダサイ。"),
    ("家へ帰ろう、また明日。", "いえへ かえろう、また あした。", "イエエ カエロー、 マタ アシタ。"),
    ("これは何ですか。", "これは なんですか。", "コレワ ナンデスカ。"),
    ("三回触りましたね。", "さんかい さわりましたね。", "サンカイ サワリマシタネ。"),
])  # fmt: skip
def test_japanese_in_kanji_sounds_as_in_kana(text, kana, reading):
    library = espeak()
    library.voice("ja")
    assert spoken(text, japanese=True) == reading
    assert library.phonemes(text) == library.phonemes(kana)


@pytest.mark.parametrize(("text", "reading"), [
    ("3回、10秒、2つ、1人、5人", "サンカイ、 ジュービョー、 フタツ、 ヒトリ、 ゴニン"),
    ("1本、6本、3匹、１０分、8歳", "イッポン、 ロッポン、 サンビキ、 ジュップン、 ハッサイ"),
    ("25点、100点、1.5メートル", "ニジュー ゴテン、 ヒャクテン、 イッテン ゴメートル"),
    ("4月7日、3時30分", "シガツ ナノカ、 サンジ サンジュップン"),
    ("何色？何回？何が？何でも", "ナニイロ？ ナンカイ？ ナニガ？ ナンデモ"),
    ("太郎くん、花子さん、山田先生", "タロークン、 ハナコサン、 ヤマダセンセー"),
    ("こんにちは、母は歯が痛い", "コンニチワ、 ハハワ ハガ イタイ"), ("はい、はと、はやく", "ハイ、 ハト、 ハヤク"), ("", ""), ("…", "…"),
    ("Aはどれ、Ｂ\ud800\0", "エイ ワ ドレ、 ビー"), ("「赤」はどれ？", "「 アカ」 ワ ドレ？"),
])  # fmt: skip
def test_numbers_names_and_particles_in_japanese(text, reading):
    assert spoken(text, japanese=True) == reading


def test_long_japanese_without_a_pause_is_said_to_its_end():
    library = espeak()
    library.voice("ja")
    assert library.phonemes("右手を上げて" * 20).count("ɡ") == 40


@pytest.mark.parametrize(("language", "words", "loaded"), [("en", "yes", 0), ("ja", "yes", 1), ("en", "はい", 1)])
def test_what_japanese_needs_is_loaded_before_time_0_or_not_at_all(language, words, loaded):
    japanese_reader.cache_clear()
    say = DeviceUse("say", "Say", "SayInput", SAY.settings | {"language": language})
    SimWorld(Spec(NAO, (), (say,), (SceneAction(0, "Mia", "say", {"words": words}),))).close()
    assert japanese_reader.cache_info().currsize == loaded


def test_without_the_reader_of_japanese_it_is_told_once(tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyopenjtalk", None)
    japanese_reader.cache_clear()
    say = [DeviceUse(n, n, "SayInput", SAY.settings | {"language": code}) for n, code in (("a", "ja"), ("b", "JA"))]
    try:
        played = Played(say, {1: [("a", "あか")], 30: [("b", "あか")]}, 2, tmp_path)
    finally:
        japanese_reader.cache_clear()
    assert [t[:2] for t in played.told] == [("error", voices.NO_KANJI), ("say", "あか"), ("say", "あか")]


def test_without_a_speech_library_the_reading_tells_how_long_japanese_lasts(tmp_path, monkeypatch):
    def missing():
        raise voices.NoSpeech

    monkeypatch.setattr(voices, "espeak", missing)
    say = DeviceUse("say", "Say", "SayInput", SAY.settings | {"language": "ja"})
    played = Played((say,), {1: [("say", "頭を触って。")]}, 2, tmp_path)
    assert played.dones == [("saydone", True, pytest.approx(1.33, abs=0.04))]  # “アタマヲ サワッテ。”


def test_extremes_of_speech(tmp_path):
    library = espeak()
    library.voice("en")
    slow, fast = (len(library.say("one two three four", speed, 100)) for speed in (80, 400))
    assert slow > 2 * fast
    assert not library.say("Hello", 150, 0).any()
    for text in ("\x00", "\ud800", "🙂", "<b>[[h@loU]]</b>", " ", "!" * 50):
        library.say(text, 150, 100)  # what is said does not matter: it ends, and breaks nothing
    assert len(library.say("Hello\x00there friend", 150, 100)) > len(library.say("Hello", 150, 100))


def test_a_very_long_text_is_cut_and_said_so(tmp_path):
    played = Played((SAY,), {1: [("say", "la " * LONGEST)], 3: [("say", None)]}, 0.3, tmp_path)
    assert played.told[0] == ("clamp", "The robot says only the first 2,000 of 6,000 letters.", "T!2", "")
    assert played.dones[0][1] is False
