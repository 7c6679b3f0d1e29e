"""Films the run in `film.gif` and `strip.png`: the robot from outside, with what it sees and says at that moment."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, partial
from pathlib import Path
from queue import SimpleQueue
from typing import TYPE_CHECKING, Any

import cv2
import numpy as np
from numpy.typing import NDArray
from PIL import GifImagePlugin, Image, ImageDraw, ImageFont

from rrp_sheets.model.exchange import Command, Notice, SceneAction
from rrp_sheets.model.run_files import FILM, STRIP
from rrp_sheets.model.values import Record, Value
from rrp_sheets.perception.pinhole import Pixels
from rrp_sheets.resources import vendored
from rrp_sheets.sim.camera import FilmCamera, Shot
from rrp_sheets.sim.process import Spec
from rrp_sheets.sim.stage import FRONT, Point
from rrp_sheets.texts import N_, translate

if TYPE_CHECKING:
    from rrp_sheets.sim.world import SimWorld


SIZE = (560, 320)  # pixels
EVERY = 80  # physics steps between two pictures: 3 a second
MOST = 120  # pictures kept; of a longer run the duller one of each two is dropped, again and again
ROBOT_BOX = ((-0.12, 0.16), (-0.20, 0.20), (0.0, 0.68))  # m, what must be in the picture: raised hands too
AWAY = 0.2  # m: a robot that has walked farther is filmed from another place
INTERESTING = 2.3  # m from the robot: things farther away need not be in the picture
HIGHEST = 1.25  # m: what is higher need not be in the picture
RECENT_US = 700_000  # a detection is shown so long, unless the sensor's next picture has nothing
STALE_US = 100_000  # the robot's own picture may be older by so much than the one from outside
PAUSED_US = 1_000_000  # an actuator that had no command for so long begins something new
SPEAKS, BEGINS, SHINES, NOTED, TOLD = 2.0, 1.5, 1.0, 0.5, 0.2
"""Weights of what makes a moment worth showing: speech, a command that changes, other eyes, a note, anything else."""
SEES, SAYS = 1.0, 1.0  # as much: that something is seen, that it speaks, without being new
POSED, FAR = 7.0, 1.2  # as much: that arms or head are so far (rad) from where they are when it stands
AFTERWARDS = 3.0  # and so much less, when the run is over
MOST_NEWS = 4.0  # so that a first moment with many beginnings does not outweigh all others
FRAME_MS = 333  # ms, of a film picture
SAME = 255  # the palette's place for what stays as it was; palettes have fewer colours
OFF, MOST_OFF = 40, 0.0005  # a colour is wrong by so much (of 255); of so many pixels, the film needs other colours
MOST_SAMPLES = 6  # pictures that a palette is made from
STRIP_EVERY = 5.0  # s (wall clock) between two strips at least; the last one is written when the robot rests
STRIP_SHARE = 20  # and so many times as long as the last one took, so that strips cost little on a busy machine
_END = b";"
INK, FAINT, PAPER, EDGE = (38, 44, 52), (110, 118, 128), (255, 255, 255), (214, 218, 222)
MOMENTS = 6
COLOURS = 224  # of the film's palette
BAR = 34  # pixels, below the film's picture
INSET = (128, 96)  # pixels, of what the robot sees, in the film
LABEL = 18  # pixels, above it
TILE = (364, 208)  # pixels, of the strip's pictures from outside
EYE = (176, 132)  # pixels, of what the robot saw, in the strip
GAP, MARGIN = 16, 28
LONGEST = 200  # letters of a caption that are looked at: a long speech would take seconds to measure
NBSP = "\N{NO-BREAK SPACE}"
NEAREST = 0.3  # of a sixth of the run: two moments are not nearer, unless the run is very short
SPREAD, NOVEL = 2.0, 2.0  # what being far from the others, and unlike them, is worth beside what happens
PALER, CHANGED = 40, 0.04  # a pixel has changed by so much (of 255); so many of them are another picture
Font = ImageFont.FreeTypeFont | ImageFont.ImageFont


class Film:
    """Collects shots while the world goes on."""

    def __init__(self, bullet: Any, world: SimWorld, spec: Spec, out: Path | None) -> None:
        self._world = world
        self._writer = FilmWriter(out, spec.title, spec.language) if out is not None else None
        self._language = spec.language
        self._names = {s.stream: s.name for s in spec.sensors}
        self._b, self._scene = bullet, spec.scene
        self._place = (0.0, 0.0)  # m, of the robot, where the camera expects it
        self._camera = FilmCamera(bullet, *_view(spec.scene, self._place), SIZE, _hiding(spec.scene))
        self.shots: list[Shot] = []
        self._every = EVERY
        self._next = 0
        self._news = 0.0
        self._seen: dict[str, tuple[int, str]] = {}
        self._ordered: dict[str, tuple[int, Value]] = {}
        self._eyes = world.eyes.shining
        self._step = 0
        self.over = False  # the run is over and the robot is brought to rest: less worth showing

    def tell(self, notice: Notice) -> None:
        """Let the next shot weigh more, because of a notice."""
        self._hurry({"say": SPEAKS, "person": SHINES, "sound": SHINES, "note": NOTED}.get(notice.kind, TOLD))

    def ordered(self, us: int, order: Command) -> None:
        """Take note of a command, which is news when it is the first for a while or differs from the one before."""
        before_us, before = self._ordered.get(order.stream, (-PAUSED_US, None))
        # Only texts, colours and blanks are compared, as measured numbers and records always differ.
        value = None if isinstance(order.value, (int, float, dict, Record)) else order.value
        self._ordered[order.stream] = us, value
        if us - before_us >= PAUSED_US or value != before:
            self._hurry(BEGINS)

    def _hurry(self, news: float) -> None:
        """Let the next shot weigh more, and take it soon also in a long run whose shots are far apart."""
        self._news += news
        if news >= SHINES:
            self._next = min(self._next, self._step + EVERY)

    def saw(self, us: int, stream: str, value: Value) -> None:
        """Take note of a sensor's value; None when its newest picture has nothing."""
        if value is None:
            self._seen.pop(stream, None)
        elif isinstance(value, dict):
            words = self._names.get(stream, stream)
            if isinstance(far := value.get("distance"), float):
                words = translate(N_("{name} at {n}", name=words, n=f"{far:.2f}{NBSP}m"), self._language)
            who = value.get("name")
            self._seen[stream] = (us, f"{words}: {who}" if who else words)

    def go_on(self, step: int) -> None:
        """Take a shot when one is due."""
        self._step = step
        if step < self._next:
            return
        self._next = step + self._every
        self._take()
        if len(self.shots) > MOST:
            pairs = zip(self.shots[::2], [*self.shots[1::2], self.shots[-1]], strict=False)
            self.shots = [max(pair, key=lambda shot: shot.weight) for pair in pairs]
            self._every *= 2
            if self._writer is not None:
                self._writer.add(self.shots, thinned=True)

    def _take(self) -> None:
        world = self._world
        us = world.stage.us
        inside = world.sight.recent(STALE_US) if world.keeps_pictures else None
        eyes = world.eyes.shining
        if eyes != self._eyes:
            self._news += SHINES
            self._eyes = eyes
        sees = [words for seen_us, words in self._seen.values() if us - seen_us <= RECENT_US]
        weight = min(self._news, MOST_NEWS) + (SEES if sees else 0.0) + (SAYS if world.voice.saying else 0.0)
        weight += POSED * self._posed() - (AFTERWARDS if self.over else 0.0)
        self._news = 0.0
        outside, from_left = self.shoot(), bool(self._camera.pose.position[1] > 0)
        self.shots.append(Shot(us, outside, inside, world.voice.saying, eyes, ", ".join(sees), weight, from_left))
        if self._writer is not None:
            self._writer.add(self.shots, thinned=False)

    def _posed(self) -> float:
        """Return how far arms and head are from the start posture: 0 as there, 1 in the midst of a gesture."""
        body = self._world.body
        chains = body.robot.data["chains"]
        upper = [j.name for j in body.robot.joints.values() if chains[j.chain] != "legs" and j.unit]
        return min(max((abs(body.position(j) - body.start[j]) for j in upper), default=0.0) / FAR, 1.0) ** 2

    def shoot(self) -> Pixels:
        """Take a picture of the robot from outside."""
        self._world.stage.place()
        x, y, _ = (float(c) for c in self._world.body.torso().position)
        if math.dist((x, y), self._place) > AWAY:  # it has walked
            self._place = (x, y)
            self._camera = FilmCamera(self._b, *_view(self._scene, self._place), SIZE, _hiding(self._scene))
        return self._camera.shoot(self._shadows(self._world.stage.us), self._world.stage.light)

    def _shadows(self, us: int) -> list[tuple[float, float, float, float]]:
        """Soft shadows on the floor: (x, y, radius, darkness)."""
        body, stage = self._world.body, self._world.stage
        feet = [body.sole(side).position for side in "LR"]
        torso = body.torso().position
        shadows = [(float(f[0]) + 0.03, float(f[1]), 0.055, 0.38) for f in feet]
        shadows.append((float(torso[0]) - 0.03, float(torso[1]) + 0.03, 0.16, 0.22))
        for ball in stage.balls.values():
            x, y, z = ball.path.at(us)
            shadows.append((x - 0.1 * z, y + 0.1 * z, ball.radius * (0.9 + z), 0.45 / (1 + 2 * z)))
        for prop in stage.props.values():
            x, y, z = prop.path.at(us)
            if prop.kind != "wall":
                dark = (0.2 if prop.kind == "table" else 0.4) / (1 + 4 * z)
                shadows.append((x, y, 0.45 * max(prop.size[:2]), dark))
        return shadows + [(*p.path.at(us)[:2], 0.18, 0.45) for p in stage.persons.values()]

    def write(self) -> None:
        """Write the rest of `film.gif` and `strip.png` into the run's folder."""
        if self._writer is not None:
            try:
                self._writer.finish(self.shots)
            except OSError as error:
                self._world.unwritten(N_("The film"), error)


def _view(scene: Sequence[SceneAction], robot: tuple[float, float]) -> tuple[list[Point], Sequence[float]]:
    """Return what should be in the picture (robot, and things near its start), and the sides (rad) to take it from."""
    points = [(robot[0] + x, robot[1] + y, z) for x in ROBOT_BOX[0] for y in ROBOT_BOX[1] for z in ROBOT_BOX[2]]
    persons = False
    last: dict[str, Sequence[float]] = {}
    for action in scene:
        values, what = action.values, action.what
        place = values.get("to") or values.get("at") or (FRONT if action.verb == "seen" else None)
        if action.verb == "circle":
            place, radius = values.get("around") or last.get(action.thing), float(values["radius"])
            if place:
                points += [_near(place, (0, radius * side, radius * side)) for side in (1, -1)]
        if place:
            last[action.thing] = place
            if what in ("wall", "table"):  # they may stand out of the picture
                continue
            points += [_near(place, (0, side * 0.05, side * 0.05)) for side in (1, -1)]
            if what == "person":
                persons = True
                points += [_near(place, (x, y, z)) for x in (-0.1, 0.1) for y in (-0.1, 0.1) for z in (-0.6, 0.12)]
    # from its right front; more from the side when persons are in front of it
    return points, [math.radians(a) for a in ((-62, -70) if persons else (-26, -34, -42, -50, -58))]


def _hiding(scene: Sequence[SceneAction]) -> list[tuple[float, float, float]]:
    """Return the places of persons and walls that could hide the robot: (x, y, radius) in m."""
    radius = {"person": 0.35, "wall": 0.6}
    places = ((a.what, a.values.get("at") or a.values.get("to")) for a in scene)
    return [(float(place[0]), float(place[1]), radius[what]) for what, place in places if place and what in radius]


def _near(place: Sequence[float], offset: Point = (0.0, 0.0, 0.0)) -> Point:
    """Return the place, or one on the way to it when it is far from the origin."""
    x, y, z = place[0] + offset[0], place[1] + offset[1], (place[2] if len(place) > 2 else 0.4) + offset[2]
    far = math.hypot(x, y)
    shrink = min(1.0, INTERESTING / far) if far else 1.0
    return x * shrink, y * shrink, min(max(z, 0.0), HIGHEST)


@dataclass(frozen=True, eq=False)
class _Picture:
    pixels: NDArray[np.uint8]  # places in the palette
    palette: bytes


class FilmFile:
    """An animated GIF that is whole after each picture: three a second, with clock, what the robot sees and says.

    A palette serves until a picture has other colours: the background then stays the same and costs nothing.
    """

    def __init__(self, path: Path, language: str = "en") -> None:
        self._path, self._language = path, language
        self._pictures: dict[int, _Picture] = {}  # by the shot's time
        self._size = (0, 0)
        self._palette = Image.new("P", (1, 1))
        self._samples: list[NDArray[np.uint8]] = []
        self._last: _Picture | None = None

    def add(self, shot: Shot) -> None:
        """Append a picture. Raises OSError when it cannot be written."""
        frame = film_frame(shot, self._language)
        self._size = frame.size
        packed = self._packed(frame) if self._samples else None
        if packed is None or _is_off(frame, packed):
            self._samples = [*self._samples[-MOST_SAMPLES + 1 :], np.asarray(frame)]
            self._palette = palette_of(self._samples)
            packed = self._packed(frame)
        picture = _Picture(np.asarray(packed), bytes(packed.getpalette("RGB") or ()))
        self._pictures[shot.us] = picture
        if self._last is None:
            self._path.write_bytes(self._header() + _encoded(picture, None) + _END)
        else:
            with self._path.open("r+b") as file:
                file.seek(-len(_END), 2)
                file.write(_encoded(picture, self._last) + _END)
        self._last = picture

    def keep(self, shots: Sequence[Shot]) -> None:
        """Drop all other pictures. Raises OSError when it cannot be written."""
        self._pictures = {shot.us: self._pictures[shot.us] for shot in shots if shot.us in self._pictures}
        half = self._path.with_suffix(".part")
        before = None
        try:
            with half.open("wb") as file:
                file.write(self._header())
                for picture in self._pictures.values():
                    file.write(_encoded(picture, before))
                    before = picture
                file.write(_END)
            half.replace(self._path)
        finally:
            half.unlink(missing_ok=True)
        self._last = before

    def _packed(self, frame: Image.Image) -> Image.Image:
        return frame.quantize(palette=self._palette, dither=Image.Dither.NONE)

    def _header(self) -> bytes:
        """Return the file's header: no global palette, and an endless loop."""
        width, height = (side.to_bytes(2, "little") for side in self._size)
        return b"GIF89a" + width + height + b"\x70\0\0!\xff\x0bNETSCAPE2.0\x03\x01\0\0\0"


def _is_off(frame: Image.Image, packed: Image.Image) -> bool:
    """Return whether a picture has colours that its palette does not have."""
    wrong = cv2.absdiff(np.asarray(frame), np.asarray(packed.convert("RGB"))) > OFF
    return bool((wrong[..., 0] | wrong[..., 1] | wrong[..., 2]).mean() > MOST_OFF)


def _encoded(picture: _Picture, before: _Picture | None) -> bytes:
    """Return a picture as a block of a GIF; pixels that stay as they were are left out."""
    pixels, (left, top) = picture.pixels, (0, 0)
    if before is not None and before.palette == picture.palette:
        changed = pixels != before.pixels
        rows, columns = np.flatnonzero(changed.any(axis=1)), np.flatnonzero(changed.any(axis=0))
        top, bottom = (int(rows[0]), int(rows[-1]) + 1) if len(rows) else (0, 1)
        left, right = (int(columns[0]), int(columns[-1]) + 1) if len(columns) else (0, 1)
        part = np.s_[top:bottom, left:right]
        pixels = np.where(changed[part], pixels[part], np.uint8(SAME))
    image = Image.fromarray(pixels)
    image.putpalette(picture.palette)
    data = GifImagePlugin.getdata(
        image, (left, top), include_color_table=True, duration=FRAME_MS, disposal=1, transparency=SAME
    )
    return b"".join(data)


class FilmWriter:
    """Writes `film.gif` and `strip.png`, which shows a title, into a run's folder, shot by shot, on a thread."""

    def __init__(self, folder: Path, title: str, language: str) -> None:
        self._film, self._strip = folder / FILM, folder / STRIP
        self._title, self._language = title, language
        self._file = FilmFile(self._film, language)
        self._work: SimpleQueue[Callable[[], None] | None] = SimpleQueue()
        self._error: Exception | None = None
        self._strip_at = time.monotonic() + STRIP_EVERY
        self._strip_waits = False
        self._thread = threading.Thread(target=self._write, name="film", daemon=True)
        self._thread.start()

    def add(self, shots: Sequence[Shot], *, thinned: bool) -> None:
        """Write the last of all shots so far; when they were thinned, the film keeps only these."""
        now = list(shots)
        self._work.put(partial(self._file.keep, now) if thinned else partial(self._file.add, now[-1]))
        if time.monotonic() >= self._strip_at and not self._strip_waits:
            self._strip_waits = True
            self._work.put(partial(self._write_strip, now))

    def finish(self, shots: Sequence[Shot]) -> None:
        """Write the rest and wait for it. Raises OSError after removing the incomplete files."""
        self._work.put(partial(self._write_strip, list(shots)))
        self._work.put(None)
        self._thread.join()
        if self._error is not None:
            self._film.unlink(missing_ok=True)
            self._strip.unlink(missing_ok=True)
            raise self._error

    def _write_strip(self, shots: Sequence[Shot]) -> None:
        half, began = self._strip.with_suffix(".part.png"), time.monotonic()
        try:
            write_strip(half, shots, self._title, self._language)
            half.replace(self._strip)
        finally:
            half.unlink(missing_ok=True)
            self._strip_at = time.monotonic() + max(STRIP_EVERY, STRIP_SHARE * (time.monotonic() - began))
            self._strip_waits = False

    def _write(self) -> None:
        while (work := self._work.get()) is not None:
            if self._error is None:
                try:
                    work()
                except Exception as error:  # a full disk, say: the run goes on, and at its end this is raised
                    self._error = error


@cache
def font_of(size: int, bold: bool = False) -> Font:
    """Return the bundled font, which has Japanese, Greek and Cyrillic letters; else one with Latin letters only."""
    path = vendored("fonts", f"NotoSansJP-{'Bold' if bold else 'Regular'}.ttf")
    return ImageFont.truetype(path, size) if path.is_file() else ImageFont.load_default(size)


def palette_of(pictures: Sequence[NDArray[np.uint8]]) -> Image.Image:
    """Return one palette for all pictures: the background then stays the same to the pixel and costs nothing."""
    pixels = np.concatenate([p.reshape(-1, 3) for p in pictures])
    red, green, blue = (pixels[:, k].astype(np.intp) >> 3 for k in range(3))
    codes = red << 10 | green << 5 | blue
    counts = np.bincount(codes)
    used = np.flatnonzero(counts)
    first = np.empty_like(counts)
    first[codes[::-1]] = np.arange(len(codes) - 1, -1, -1)  # of several, what is written last stays: the first pixel
    # What is small but coloured (a ball, the eyes) counts more than its pixels, else the floor would take all colours.
    sample = np.repeat(pixels[first[used]], np.ceil(counts[used] ** 0.4).astype(int), axis=0)
    return Image.fromarray(sample[None]).quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def film_frame(shot: Shot, language: str) -> Image.Image:
    """Draw a picture of the film: the robot, what it sees, the clock, and what it says."""
    font, small = font_of(15), font_of(12)
    outside = Image.fromarray(shot.outside)
    frame = Image.new("RGB", (outside.width, outside.height + BAR), PAPER)
    frame.paste(outside, (0, 0))
    draw = ImageDraw.Draw(frame)
    if shot.inside is not None:
        left = 10 if shot.from_left else outside.width - INSET[0] - 10  # where the robot is not
        top = outside.height - INSET[1] - 10
        draw.rectangle((left - 3, top - LABEL, left + INSET[0] + 2, top + INSET[1] + 2), fill=PAPER, outline=EDGE)
        frame.paste(Image.fromarray(shot.inside).resize(INSET, Image.Resampling.BILINEAR), (left, top))
        label = translate(N_("what the robot sees"), language)
        draw.text((left + INSET[0] // 2, top - LABEL // 2), label, INK, small, anchor="mm")
    middle = outside.height + BAR // 2
    draw.text((12, middle), f"{shot.us / 1e6:.1f} s", INK, font, anchor="lm")
    _dot(draw, 78, middle, 8, shot.eyes)
    words, ink = (f"“{shot.saying}”", INK) if shot.saying else (shot.sees.replace(NBSP, " "), FAINT)
    draw.text((98, middle), _shorten(draw, words, font, outside.width - 110), ink, font, anchor="lm")
    return frame


def write_strip(path: Path, shots: Sequence[Shot], title: str = "", language: str = "en") -> None:
    """Write six moments side by side: the robot from outside, what it saw, and what it said."""
    chosen = choose(shots)
    big, font, small = font_of(26, bold=True), font_of(20), font_of(16)
    head = MARGIN + (44 if title else 0)
    width = 2 * MARGIN + len(chosen) * TILE[0] + (len(chosen) - 1) * GAP
    height = head + 34 + TILE[1] + 12 + EYE[1] + MARGIN
    strip = Image.new("RGB", (width, height), PAPER)
    draw = ImageDraw.Draw(strip)
    if title:
        draw.text((MARGIN, MARGIN - 12), _shorten(draw, title, big, width - 2 * MARGIN), INK, big)
    for k, shot in enumerate(chosen):
        _tile(strip, shot, (MARGIN + k * (TILE[0] + GAP), head), font, small, language)
    strip.save(path)  # the best compression takes four times as long, for a twentieth less


def _tile(strip: Image.Image, shot: Shot, place: tuple[int, int], font: Font, small: Font, language: str) -> None:
    left, top = place
    draw = ImageDraw.Draw(strip)
    draw.text((left, top - 4), f"{shot.us / 1e6:.1f} s", INK, font)
    top += 34
    strip.paste(Image.fromarray(shot.outside).resize(TILE, Image.Resampling.LANCZOS), (left, top))
    draw.rectangle((left, top, left + TILE[0] - 1, top + TILE[1] - 1), outline=EDGE)
    top += TILE[1] + 12
    seen = EYE[0] + 12 if shot.inside is not None else 0
    if shot.inside is not None:
        strip.paste(Image.fromarray(shot.inside).resize(EYE, Image.Resampling.LANCZOS), (left, top))
        draw.rectangle((left, top, left + EYE[0] - 1, top + EYE[1] - 1), outline=EDGE)
    x, room = left + seen, TILE[0] - seen
    _dot(draw, x + 9, top + 10, 9, shot.eyes)
    draw.text((x + 26, top + 10), translate(N_("eyes"), language), FAINT, small, anchor="lm")
    sees = translate(N_("sees {what}", what=shot.sees), language) if shot.sees else ""
    lines = [(line, FAINT) for line in _wrap(draw, sees, small, room, 2)] if sees else []
    if shot.saying:
        lines += [(line, INK) for line in _wrap(draw, f"“{shot.saying}”", small, room, 5 - len(lines))]
    for k, (line, colour) in enumerate(lines):
        draw.text((x, top + 28 + 21 * k), line, colour, small)


def choose(shots: Sequence[Shot], count: int = MOMENTS) -> list[Shot]:
    """Choose moments where something changes, spread over the run, no two nearly the same if that is possible."""
    chosen = list[Shot]()
    part = max((shots[-1].us - shots[0].us) / count, 1.0) if shots else 1.0
    rest = [(shot, 1.0) for shot in shots]  # and how unlike those chosen it is: each pair is compared once only
    while rest and len(chosen) < count:
        best = max(range(len(rest)), key=lambda k: (_gain(*rest[k], chosen, part), -rest[k][0].us))
        shot, _ = rest.pop(best)
        chosen.append(shot)
        rest = [(other, min(unlike, _unlike(other, shot))) for other, unlike in rest]
    return sorted(chosen, key=lambda shot: shot.us)


def _gain(shot: Shot, unlike: float, chosen: Sequence[Shot], part: float) -> float:
    """Return how much a moment adds to those chosen; `part` is a sixth of the run, in microseconds."""
    apart = min((abs(shot.us - other.us) for other in chosen), default=part) / part
    crowded = 10.0 if apart < NEAREST else 0.0
    return shot.weight + SPREAD * min(apart, 1.0) + NOVEL * unlike - crowded


def _unlike(shot: Shot, other: Shot) -> float:
    """Return the difference of two moments in look and speech: 0 the same, 1 clearly different."""
    if (shot.saying, shot.eyes) != (other.saying, other.eyes):
        return 1.0
    pairs = [(shot.outside, other.outside)]
    if shot.inside is not None and other.inside is not None:
        pairs.append((shot.inside, other.inside))
    changed = [float((np.abs(a[::4, ::4].astype(np.int16) - b[::4, ::4]).max(axis=2) > PALER).mean()) for a, b in pairs]
    return min(1.0, max(changed) / CHANGED)


def _dot(draw: ImageDraw.ImageDraw, x: int, y: int, radius: int, rgb: tuple[float, float, float]) -> None:
    red, green, blue = (round(255 * c) for c in rgb)
    draw.ellipse((x - radius, y - radius, x + radius, y + radius), fill=(red, green, blue), outline=FAINT)


def _wrap(draw: ImageDraw.ImageDraw, text: str, font: Font, room: int, most: int) -> list[str]:
    lines = [""]
    for word in text[:LONGEST].split(" "):
        longer = f"{lines[-1]} {word}".strip()
        if draw.textlength(longer, font) <= room:
            lines[-1] = longer
            continue
        if lines[-1]:
            lines.append("")
        for letter in word:  # Japanese has no spaces: what does not fit is broken anywhere
            if lines[-1] and draw.textlength(lines[-1] + letter, font) > room:
                lines.append("")
            lines[-1] += letter
    if len(lines) > most:
        lines = [*lines[: most - 1], " ".join(lines[most - 1 :])]
    return [_shorten(draw, line.replace(NBSP, " "), font, room) for line in lines]


def _shorten(draw: ImageDraw.ImageDraw, text: str, font: Font, room: int) -> str:
    if len(text) <= LONGEST and draw.textlength(text, font) <= room:
        return text
    text = text[:LONGEST]
    while text and draw.textlength(text + "…", font) > room:
        text = text[:-1]
    return text.rstrip() + "…"
