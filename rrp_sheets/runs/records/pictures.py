"""Pictures of a run that are made of its record: plots of its numbers, and a contact sheet of its moments."""

from __future__ import annotations

import io
from bisect import bisect_left, bisect_right
from collections.abc import Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.stamp import Stamp
from rrp_sheets.render.contact import Moment, draw_contact
from rrp_sheets.render.plots import Curve, Note, draw_plots
from rrp_sheets.render.texts import Texts, texts
from rrp_sheets.runs.records.course import course
from rrp_sheets.runs.records.stamp import stamp_of

MOMENTS = 24
FILM = "film.gif"
_MOST_PICTURES = 2_000  # of a film
_MOST_PIXELS = 4_000 * 4_000
_QUALITY = 82  # of a JPEG
_LANES = {
    "say": "said", "person": "heard", "sound": "said", "press": "button", "button": "button", "mark": "mark",
    "error": "error", "note": "note", "clamp": "note",
}  # fmt: skip
_RANKS = ("mark", "error", "say", "person", "press", "button", "send", "scene", "edit", "sound", "note")


def draw_run_plots(place: Path, only: Collection[str] = ()) -> tuple[str, float, float]:
    """The numbers of a run over time, as SVG with its width and height in points.

    Args:
        place: the run's folder.
        only: these streams; all when empty.

    Raises:
        UnreadableFile: when it is no trace.
        SheetsError: there are no numbers to plot.
    """
    told = course(place, only)
    curves = [Curve(c["name"], c["kind"], c["unit"], [(t, v) for t, v in c["points"]], c["count"])
              for c in told["curves"]]  # fmt: skip
    if not curves:
        raise _nothing(place, only)
    notes = [Note(e["t"], e["until"], _LANES.get(e["kind"], "by_hand"), e["text"]) for e in told["lines"]]
    stamp = stamp_of(place)
    more = ""
    if told["more_curves"]:
        more = texts(stamp.language).get("plots.more", n=told["more_curves"])
    return draw_plots(
        title_of(stamp),
        curves,
        notes,
        float(told["seconds"]),
        foot=stamp.line(),
        more=more,
        about=dict(stamp.pairs()),
        language=stamp.language,
    )


def _nothing(place: Path, only: Collection[str]) -> SheetsError:
    if not only:
        return SheetsError(f"“{place.name}” has no numbers that change.", "Export it as a table: -o run.xlsx")
    known = [c["name"] for c in course(place)["curves"]]
    remedy = f"Streams with numbers are: {', '.join(known[:20])}." if known else "This run has no numbers at all."
    return SheetsError(f"No stream called {', '.join(only)} has numbers.", remedy)


def draw_run_contact(place: Path, count: int = MOMENTS) -> tuple[str, float, float]:
    """Moments of a run's film with what happened then, as SVG with its width and height in points.

    Raises:
        UnreadableFile: when it is no trace, or its film is no film.
        SheetsError: the run was not filmed.
    """
    film = place / FILM
    if not film.is_file():
        raise SheetsError(f"“{place.name}” has no film to take pictures from.", "Export its plots: -o plots.svg")
    told = course(place)["lines"]
    stamp = stamp_of(place)
    moments = _moments(film, told, count, texts(stamp.language))
    return draw_contact(title_of(stamp), moments, foot=stamp.line(), about=dict(stamp.pairs()), language=stamp.language)


def title_of(stamp: Stamp) -> str:
    """What stands above a picture of a run."""
    who = ", ".join(filter(None, (stamp.participant, stamp.condition)))
    return f"{stamp.workbook or stamp.run}{f', {who}' if who else ''}, {stamp.began[:16].replace('T', ' ')}"


def _moments(film: Path, told: Sequence[Mapping[str, Any]], count: int, say: Texts) -> list[Moment]:
    from PIL import Image

    try:
        with Image.open(film, formats=["GIF"]) as picture:
            frames = min(getattr(picture, "n_frames", 1), _MOST_PICTURES)
            if picture.width * picture.height > _MOST_PIXELS:
                raise ValueError
            times = _times(picture.info.get("comment", b""), frames)
            chosen = choose(times or list(range(frames)), told if times else (), count)
            found = []
            for number, place in enumerate(chosen):
                picture.seek(place)
                packed = io.BytesIO()
                picture.convert("RGB").save(packed, "JPEG", quality=_QUALITY)
                when, words = "", tuple[str, ...]()
                if times:
                    until = times[chosen[number + 1]] if number + 1 < len(chosen) else float("inf")
                    when, words = (
                        f"{times[place]:.1f} s",
                        _words(told, 0.0 if number == 0 else times[place], until, say),
                    )
                found.append(Moment(packed.getvalue(), picture.width, picture.height, when, words))
            return found
    except (OSError, ValueError, EOFError, Image.DecompressionBombError):
        raise UnreadableFile("FILE001", f"“{film}” is no film of a run.", "Copy the run's folder again.") from None


def _times(comment: bytes | str, frames: int) -> list[float]:
    """When the film's pictures were taken, in seconds; none of a film that does not say it."""
    text = comment.decode("ascii", "replace") if isinstance(comment, bytes) else comment
    parts = text.split()
    if len(parts) != frames or not all(p.isdecimal() and len(p) < 13 for p in parts):
        return []
    return sorted(int(p) / 1000 for p in parts)


def choose(times: Sequence[float], told: Sequence[Mapping[str, Any]], count: int) -> list[int]:
    """The pictures of a sheet: of each stretch the one where most happens, else the middle one.

    >>> choose([0, 1, 2, 3, 4, 5], [{"kind": "say", "t": 3.5}], 2)
    [1, 4]
    """
    if len(times) <= count:
        return list(range(len(times)))
    ranks = {kind: len(_RANKS) - n for n, kind in enumerate(_RANKS)}
    weights = [0] * len(times)
    for entry in told:
        place = min(bisect_left(times, float(entry["t"])), len(times) - 1)  # its effect is seen after it
        weights[place] = max(weights[place], ranks.get(str(entry["kind"]), 1))
    found = []
    for n in range(count):
        stretch = range(len(times) * n // count, len(times) * (n + 1) // count)
        middle = stretch[len(stretch) // 2]
        found.append(max(stretch, key=lambda place: (weights[place], -abs(place - middle))))
    return found


def _words(told: Sequence[Mapping[str, Any]], first: float, until: float, say: Texts) -> tuple[str, ...]:
    times = [float(e["t"]) for e in told]
    there = told[bisect_left(times, first) : bisect_right(times, until - 1e-9)]
    order = {kind: n for n, kind in enumerate(_RANKS)}
    ordered = sorted(there, key=lambda e: order.get(str(e["kind"]), len(order)))
    entries = [(f"moments.told.{e['kind']}", str(e["text"])) for e in ordered]
    return tuple(say.get(entry, text=text) if say.has(entry) else text for entry, text in entries)
