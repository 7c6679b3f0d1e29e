"""Every route of the server with an address that works, for attacks on all of them.

A new route that changes something needs a line in JSON or FORMS: the tests fail for one that has none.
"""

from __future__ import annotations

import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pytest
from browser import HOME, let_in
from flask import Flask
from werkzeug.routing import Rule

from rrp_sheets.workbook.files import make_workbook

BOOK, SHEET, RUN = "good.xlsx", "Tracking", "20260101-000000-good"
HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
SECRET = "a-secret-outside"
OURS = {"X-RRP": "grid", "Origin": HOME}

SOME = pytest.mark.parametrize("every", [pytest.param(5, id="some"), pytest.param(1, id="all", marks=pytest.mark.soak)])
"""Each route is tried with every fifth of the cases, beginning at another one; with all of them by `make soak`.

Names in addresses of files and folders are always tried with all of them, for one of a route's actions: see `OPENED`.
"""
OPENED = frozenset({"file", "filename", "name", "run"})
"""Parts of addresses that open files: they are tried with all cases in every run, for the first action of each route."""

PLACES: dict[str, Any] = {
    "name": BOOK, "sheet": SHEET, "run": RUN, "number": 1, "first": 0, "filename": "style.css", "action": "stop",
    "picture": "plots", "what": "piece", "form": "svg", "export": "plots",
}  # fmt: skip
"""What stands in the variable parts of an address; `file` and others where the route needs them so."""

_FILES = {"run_panel.sound": "say-001.wav", "exports.file": "trace.jsonl"}

_WHO = {"client": "c", "name": "Anna", "tag": "t"}
_PLACE = {**_WHO, "sheet": SHEET, "row": "ROW", "column": 6}
JSON: dict[str, dict[str, Any]] = {
    "sheet.change cells": {
        **_WHO, "sheet": SHEET, "cells": [{"row": "ROW", "column": 6, "text": "x", "was": None}],
        "unlock": {"row": "ROW", "column": 6}, "stand": {"row": "ROW", "column": 6},
    },
    "sheet.change insert": {**_WHO, "sheet": SHEET, "before": "ROW", "rows": [{"id": "wabcd-1"}]},
    "sheet.change delete": {**_WHO, "sheet": SHEET, "rows": ["ROW"]},
    "sheet.change move": {**_WHO, "sheet": SHEET, "rows": ["ROW"], "before": None},
    "sheet.change rename": {**_WHO, "sheet": SHEET, "old": "Distance", "new": "Far"},
    "sheet.change replace": {
        **_WHO, "sheets": [{"sheet": SHEET, "cells": [{"row": "ROW", "column": 1, "text": "x", "was": None}]}],
    },
    "sheet.change comment": {**_PLACE, "what": "add", "text": "x", "id": ""},
    "sheet.change look": {
        **_WHO, "sheet": SHEET, "cells": [{"row": "ROW", "column": 6}], "bold": True, "fill": "green", "wrap": False,
    },
    "sheet.change column": {**_WHO, "sheet": "Devices", "row": "ROW", "setting": "Every"},
    "sheet.change undo": {**_WHO, "sheet": SHEET},
    "sheet.change redo": {**_WHO, "sheet": SHEET},
    "sheet.change lock": _PLACE,
    "sheet.change unlock": _PLACE,
    "sheet.change stand": _PLACE,
    "sheet.change part": _WHO,
    "sheet.change test": _WHO,
    "sheet.change fix": {**_WHO, "finding": "0123456789abcdef", "fix": "correct-spelling", "title": "Put it right"},
    "gestures.pose": {**_WHO, "sheet": SHEET, "row": "ROW"},
    "tabs.change add": {**_WHO, "kind": "behaviour", "title": "New", "columns": ""},
    "tabs.change rename": {**_WHO, "of": SHEET, "title": "Other"},
    "tabs.change move": {**_WHO, "of": SHEET, "by": 1},
    "tabs.change duplicate": {**_WHO, "of": SHEET},
    "tabs.change delete": {**_WHO, "of": SHEET},
    "run_panel.start": {
        **_WHO, "mode": "simulated", "participant": "", "condition": "", "operator": "", "until": "scene", "speed": 1,
    },
    "run_panel.act restart": _WHO,
    "run_panel.act pause": _WHO,
    "run_panel.act resume": _WHO,
    "run_panel.act step": _WHO,
    "run_panel.act clear": _WHO,
    "run_panel.act speed": {**_WHO, "speed": 2},
    "run_panel.act mark": {**_WHO, "note": "x"},
    "run_panel.act switch": {**_WHO, "behaviour": SHEET, "on": False},
    "run_panel.act send": {**_WHO, "stream": "Red ball", "text": "x=1"},
    "run_panel.act press": {**_WHO, "label": "Go"},
    "run_panel.act scene": {**_WHO, "thing": "Red ball", "verb": "move", "value": "to 1, 0, 0"},
    "run_panel.act put": {**_WHO, "thing": "Red ball", "x": 1, "y": 0, "z": 0.4},
}  # fmt: skip
"""What is sent as JSON."""

FORMS: dict[str, dict[str, Any]] = {
    "language": {"language": "ja", "next": "/"},
    "help.open_example": {"page": "priority.html", "example": "x", "name": "x"},
    "workbooks.act new": {"name": "new", "template": "guided"},
    "workbooks.act copy": {"book": BOOK},
    "workbooks.act rename": {"book": BOOK, "name": "other"},
    "workbooks.act archive": {"book": BOOK},
    "workbooks.act unarchive": {"book": BOOK},
    "workbooks.act tutorial": {},
    "workbooks.act upload": {"file": b"no workbook"},
    "comparison.act keep": {"title": "before"},
    "comparison.act restore": {"version": "1"},
    "run_deletion.delete": {"run": RUN, "shown": RUN, "typed": "no"},
    "run_panel.stop": {},
}
"""What is sent as a form by our own script."""


@dataclass(frozen=True)
class Way:
    """A route with one of its actions: `key` names it in JSON and FORMS; `parts` are what stands in its address."""

    key: str
    rule: str
    post: bool
    parts: dict[str, Any]

    def address(self, **other: str) -> str:
        """An address; `other` parts instead, put in as they are."""
        return re.sub(
            r"<(?:[^<>:]*:)?(\w+)>",
            lambda found: other.get(found[1]) or quote(str(self.parts[found[1]]), safe="/"),
            self.rule,
        )

    @property
    def names(self) -> list[str]:
        """The parts of its address that are texts of the sender's choice."""
        return re.findall(r"<(?:string:|path:)?(\w+)>", self.rule)


def ways(app: Flask) -> list[Way]:
    """All routes, those with a choice of actions once for each."""
    return [way for rule in app.url_map.iter_rules() for way in _ways(rule)]


def _ways(rule: Rule) -> Iterator[Way]:
    post = "POST" in (rule.methods or ())
    parts = {name: _FILES.get(rule.endpoint, PLACES.get(name, "x")) for name in rule.arguments}
    parts.update({name: PLACES[name] for name in rule.arguments if name in ("name", "run", "sheet")})
    actions = [k.split(" ")[1] for k in (*JSON, *FORMS) if k.startswith(f"{rule.endpoint} ")] if post else []
    choice = re.search(r"<any\(([^)]*)\):action>", rule.rule)
    if choice:
        actions = [a.strip() for a in choice[1].split(",")]
    if "action" not in rule.arguments or not actions:
        yield Way(rule.endpoint, rule.rule, post, parts)
        return
    for action in actions:
        yield Way(f"{rule.endpoint} {action}", rule.rule, post, {**parts, "action": action})


def body(way: Way, row: str = "") -> dict[str, Any]:
    """Body of a request, as an argument of the test client."""
    if way.key in JSON:
        return {"json": _with_row(JSON[way.key], row)}
    if way.key not in FORMS:
        return {}
    form = {n: (io.BytesIO(v), "up.xlsx") if isinstance(v, bytes) else v for n, v in FORMS[way.key].items()}
    return {"data": form, "content_type": "multipart/form-data"}


def _with_row(value: Any, row: str) -> Any:
    if isinstance(value, dict):
        return {k: _with_row(v, row) for k, v in value.items()}
    if isinstance(value, list):
        return [_with_row(v, row) for v in value]
    return row if value == "ROW" else value


def make_folder(place: Path) -> Path:
    """A folder with a workbook and a recorded run, and a secret beside it."""
    (place / "secret.md").write_text(f"# {SECRET}\n", encoding="utf-8")
    folder = place / "inside"
    folder.mkdir()
    rows = [["", "Red ball", "map", "redBall.distence", "Distance", "a note"],
            ["", "Distance", "subscribe", "", "Say", ""]]  # fmt: skip
    make_workbook({SHEET: [HEADER, *rows]}, folder / BOOK)
    run = folder / "runs" / RUN
    run.mkdir(parents=True)
    (run / "trace.jsonl").write_text('{"t": 0}\nno record\n', encoding="utf-8")
    (run / "say-001.wav").write_bytes(b"RIFF")
    return folder


def contents(folder: Path) -> dict[str, bytes]:
    """All files of a folder but the journal."""
    files = (p for p in sorted(folder.rglob("*")) if p.is_file() and ".rrp-sheets" not in p.parts)
    return {str(p.relative_to(folder)): p.read_bytes() for p in files}


def enter(app: Flask) -> Any:
    """A browser that was let in by a link."""
    return let_in(app)
