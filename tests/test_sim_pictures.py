"""The pictures that a run leaves: which moments the strip shows, and that captions can be read in any language."""

from __future__ import annotations

import pytest

pytest.importorskip("pybullet")
pytest.importorskip("cv2")
import itertools
from pathlib import Path

import numpy as np
from PIL import ImageFont

from rrp_sheets.model.exchange import Command, DeviceUse, SceneAction
from rrp_sheets.resources import vendored
from rrp_sheets.robots import load_robot
from rrp_sheets.sim.camera import Shot
from rrp_sheets.sim.film import EVERY, MOST, Film, choose, font_of, write_strip
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.world import SimWorld

SECOND = 1_000_000
GREY = np.full((32, 56, 3), 128, np.uint8)
needs_font = pytest.mark.skipif(not vendored("fonts", "NotoSansJP-Regular.ttf").is_file(), reason="built offline")


def shot(second: float, saying: str = "", weight: float = 0.0) -> Shot:
    return Shot(round(second * SECOND), GREY, GREY, saying, (1.0, 1.0, 1.0), "", weight)


@needs_font
def test_japanese_captions_are_letters_and_not_boxes() -> None:
    captions = [bytes(font_of(20).getmask(text)) for text in ("赤い", "青い", "緑の", "Ελλ", "Рус")]
    assert len(set(captions)) == len(captions)


def test_without_the_fetched_font_there_is_one(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rrp_sheets.sim.film.vendored", lambda *parts: vendored("nowhere", *parts))
    font = font_of(20)
    assert isinstance(font, (ImageFont.FreeTypeFont, ImageFont.ImageFont))
    assert font.getlength("Hello") > 20


def test_the_strip_shows_when_something_happens() -> None:
    told = {10.0: "Hello", 30.0: "Hello again", 40.0: "Hello"}
    shots = [shot(t, told.get(t, ""), 3.0 if t in told else 0.0) for t in (k / 3 for k in range(150))]
    seconds = [s.us / SECOND for s in choose(shots)]
    assert set(told) <= set(seconds)
    assert len(seconds) == 6
    assert all(later - earlier > 2 for earlier, later in itertools.pairwise(seconds))


def test_of_moments_that_happen_often_no_two_neighbours_are_taken() -> None:
    shots = [shot(k / 3, "Red" if k % 3 == 0 else "", 2.0 if k % 3 == 0 else 0.0) for k in range(60)]
    seconds = [s.us / SECOND for s in choose(shots)]
    assert seconds == sorted(seconds)
    assert max(seconds) - min(seconds) > 12
    assert len(choose(shots[:2])) == 2
    assert choose([]) == []


PERSON = SceneAction(0, "Mia", "appear", {"at": (1.1, 0.0, 0.62)})
FACE, RARELY = (DeviceUse("face", "Face", "FaceDetection", {"rate": rate}) for rate in (10.0, 1.0))
SAY = DeviceUse("say", "Say", "SayInput", {"language": "en", "speed": 150.0, "volume": 100.0})


def filmed(scene: tuple[SceneAction, ...], orders: dict[float, str], seconds: float, face: DeviceUse) -> list[Shot]:
    """The shots of a run of a world in this process."""
    world = SimWorld(Spec(load_robot(), (face,), (SAY,), scene, film=True))
    film = world._film
    assert isinstance(film, Film)
    world.start()
    for frame in range(1, round(seconds * 30) + 1):
        said = orders.get((frame - 1) / 30)
        world.advance(frame * SECOND // 30, [Command("say", said, "A!2")] if said else [])
    world.close()
    return film.shots


@pytest.mark.slow
def test_a_caption_goes_when_the_newest_picture_has_nothing() -> None:
    shots = filmed((PERSON, SceneAction(SECOND, "Mia", "disappear")), {}, 1.4, FACE)
    assert [s.sees for s in shots if s.us < SECOND] == ["Face"] * 3
    assert [s.sees for s in shots if s.us >= SECOND] == [""] * 2


@pytest.mark.parametrize(
    ("language", "name", "sees"),
    [("en", "Ball", "Ball at 0.80\N{NO-BREAK SPACE}m"), ("ja", "玉", "玉（0.80\N{NO-BREAK SPACE}m）")],
)
def test_captions_are_in_the_language_of_the_workbook(language: str, name: str, sees: str, tmp_path: Path) -> None:
    world = SimWorld(Spec(load_robot(), (DeviceUse("ball", name, "RedBall"),), film=True, language=language))
    world.start()
    film = world._film
    assert isinstance(film, Film)
    film.saw(0, "ball", {"distance": 0.8})
    film._take()
    world.close()
    assert film.shots[-1].sees == sees
    english, own = tmp_path / "english.png", tmp_path / "own.png"
    for path, chosen in ((english, "en"), (own, language)):
        write_strip(path, film.shots[-1:], language=chosen)
    assert (english.read_bytes() == own.read_bytes()) is (language == "en")


@pytest.mark.slow
def test_speech_is_in_the_picture_also_in_a_long_run(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("rrp_sheets.sim.film.MOST", 4)
    shots = filmed((PERSON,), {3.5: "Hello, how are you?"}, 5, RARELY)
    assert len(shots) <= 5 < MOST
    assert max(shots, key=lambda s: s.weight).saying == "Hello, how are you?"
    gaps = {(b.us - a.us) / SECOND for a, b in itertools.pairwise(shots)}
    assert max(gaps) > 2 * EVERY / 240
