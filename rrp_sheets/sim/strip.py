"""Lays the shots of a run out: as pictures of a film, and as a strip of six moments for a report."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw, ImageFont

from rrp_sheets.resources import vendored
from rrp_sheets.sim.camera import Shot

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


@cache
def font_of(size: int, bold: bool = False) -> Font:
    """The font that comes along, which has Japanese, Greek and Cyrillic letters; else one with Latin letters only."""
    path = vendored("fonts", f"NotoSansJP-{'Bold' if bold else 'Regular'}.ttf")
    return ImageFont.truetype(path, size) if path.is_file() else ImageFont.load_default(size)


def palette_of(pictures: Sequence[NDArray[np.uint8]]) -> Image.Image:
    """One palette for all pictures: the background then stays the same to the pixel and costs nothing.

    What is small but coloured (a ball, the eyes) counts more than its pixels, else the floor would take all colours.
    """
    pixels = np.concatenate([p.reshape(-1, 3) for p in pictures])
    red, green, blue = (pixels[:, k].astype(np.intp) >> 3 for k in range(3))
    codes = red << 10 | green << 5 | blue
    counts = np.bincount(codes)
    used = np.flatnonzero(counts)
    first = np.empty_like(counts)
    first[codes[::-1]] = np.arange(len(codes) - 1, -1, -1)  # of several, what is written last stays: the first pixel
    sample = np.repeat(pixels[first[used]], np.ceil(counts[used] ** 0.4).astype(int), axis=0)
    return Image.fromarray(sample[None]).quantize(COLOURS, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)


def film_frame(shot: Shot) -> Image.Image:
    """A picture of the film: the robot, what it sees, the clock, and what it says."""
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
        draw.text((left + INSET[0] // 2, top - LABEL // 2), "what the robot sees", INK, small, anchor="mm")
    middle = outside.height + BAR // 2
    draw.text((12, middle), f"{shot.us / 1e6:.1f} s", INK, font, anchor="lm")
    _dot(draw, 78, middle, 8, shot.eyes)
    words = f"“{shot.saying}”" if shot.saying else shot.sees.replace(NBSP, " ")
    text = _shorten(draw, words, font, outside.width - 110)
    draw.text((98, middle), text, INK if shot.saying else FAINT, font, anchor="lm")
    return frame


def write_strip(path: Path, shots: Sequence[Shot], title: str = "") -> None:
    """Six moments side by side: the robot from outside, what it saw, and what it said."""
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
        _tile(strip, shot, (MARGIN + k * (TILE[0] + GAP), head), font, small)
    strip.save(path)  # the best compression takes four times as long, for a twentieth less


def _tile(strip: Image.Image, shot: Shot, place: tuple[int, int], font: Font, small: Font) -> None:
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
    draw.text((x + 26, top + 10), "eyes", FAINT, small, anchor="lm")
    lines = [(line, FAINT) for line in _wrap(draw, f"sees {shot.sees}", small, room, 2)] if shot.sees else []
    if shot.saying:
        lines += [(line, INK) for line in _wrap(draw, f"“{shot.saying}”", small, room, 5 - len(lines))]
    for k, (line, colour) in enumerate(lines):
        draw.text((x, top + 28 + 21 * k), line, colour, small)


def choose(shots: Sequence[Shot], count: int = MOMENTS) -> list[Shot]:
    """Moments where something changes, spread over the run, no two nearly the same where that can be helped.

    One by one the moment that adds most: what happens in it, how far it is from the chosen ones, how unlike them.
    """
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
    """What a moment adds to those chosen; `part` is a sixth of the run, in microseconds."""
    apart = min((abs(shot.us - other.us) for other in chosen), default=part) / part
    crowded = 10.0 if apart < NEAREST else 0.0
    return shot.weight + SPREAD * min(apart, 1.0) + NOVEL * unlike - crowded


def _unlike(shot: Shot, other: Shot) -> float:
    """How different two moments look and sound: 0 the same, 1 clearly different."""
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
