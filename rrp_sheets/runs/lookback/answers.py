"""Answers the requests of the page that looks back at a run, in the query process; keeps what was read last."""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.errors import SheetsError
from rrp_sheets.runs.lookback.book import WORKBOOK, Book, drawing, read_book, sheets
from rrp_sheets.runs.lookback.index import Index, index_trace
from rrp_sheets.runs.lookback.poses import POSES, Poses, index_poses, picture, picture_times
from rrp_sheets.runs.lookback.values import Words, names_of, piece
from rrp_sheets.runs.records.metadata import TRACE

Stamp = tuple[int, int]
_LOST = SheetsError("There is no such part of the run.", "Load the page again: the record has perhaps changed.")


def answer(place: Path, what: str, number: int = 0) -> str:
    """One part of a run.

    Args:
        place: the run's folder.
        what: `sheets`, `overview`, `piece`, `poses` (all as JSON), `diagram` (SVG) or `picture` (JPEG in base64).
        number: of the piece, the diagram or the picture.

    Raises:
        UnreadableFile: it is no trace.
        SheetsError: there is no such part.
    """
    return _ANSWERS[what](place, number)


def _sheets(place: Path, _: int) -> str:
    book = _book(place)
    return _json({"sheets": sheets(book), "why": book.why})


def _overview(place: Path, _: int) -> str:
    index, poses = _index(place), _poses(place)
    kinds = {**{s.stream: "stream" for s in index.series if s.stream}, **index.kinds}
    names = names_of(kinds)
    return _json({
        "seconds": index.seconds, "count": index.count, "pieces": index.piece_times(),
        "series": [[s.row, names.get(s.stream, ""), kinds.get(s.stream, "")] for s in index.series],
        "moments": [vars(line) for line in index.log], "left_out": index.left_out,
        "edits": index.edits, "switches": index.switches,
        "poses": poses.times, "pictures": picture_times(place),
    })  # fmt: skip


def _piece(place: Path, number: int) -> str:
    index = _index(place)
    if not 0 <= number < len(index.starts):
        raise _LOST
    return _json(piece(index, number, _words(place)))


def _pose_piece(place: Path, number: int) -> str:
    poses = _poses(place)
    if not 0 <= number < len(poses.times):
        raise _LOST
    return _json(poses.piece(number))


def _diagram(place: Path, number: int) -> str:
    return drawing(_book(place), number)


def _picture(place: Path, number: int) -> str:
    return base64.b64encode(picture(place, number)).decode("ascii")


_ANSWERS: dict[str, Callable[[Path, int], str]] = {
    "sheets": _sheets, "overview": _overview, "piece": _piece, "poses": _pose_piece, "diagram": _diagram,
    "picture": _picture,
}  # fmt: skip


def _json(data: Any) -> str:
    text = json.dumps(data, ensure_ascii=False, separators=(",", ":"), allow_nan=False)
    return text.replace("<", "\\u003c")  # as markup it would mean nothing, wherever it came to stand


# ---- kept while the files are the same
def _index(place: Path) -> Index:
    return _known_index(place, _stamp(place / TRACE))


def _poses(place: Path) -> Poses:
    return _known_poses(place, _stamp(place / POSES))


def _book(place: Path) -> Book:
    return _known_book(place, _stamp(place / WORKBOOK))


def _words(place: Path) -> Words:
    book = _book(place)
    return Words(book.robot, book.units)


def _stamp(path: Path) -> Stamp:
    try:
        about = path.stat()
    except FileNotFoundError:
        return (0, 0)
    return about.st_mtime_ns, about.st_size


@lru_cache(maxsize=2)
def _known_index(place: Path, stamp: Stamp) -> Index:
    return index_trace(place)


@lru_cache(maxsize=2)
def _known_poses(place: Path, stamp: Stamp) -> Poses:
    return index_poses(place)


@lru_cache(maxsize=4)
def _known_book(place: Path, stamp: Stamp) -> Book:
    return read_book(place)
