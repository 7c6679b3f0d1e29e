"""Worker process that prints: `python -m rrp_sheets.web.records.press_child LINK`, started by `protocol_printer`.

It assembles and typesets the protocol of a workbook. The workbook's tests run here, with a memory limit.
"""

from __future__ import annotations

import json
from dataclasses import asdict
from functools import lru_cache
from pathlib import Path
from typing import Any

from rrp_sheets.printing import Gathered, HasErrors, gather
from rrp_sheets.render.legend import draw_legend
from rrp_sheets.render.pack.make import set_pack
from rrp_sheets.runs.worker_loop import serve


@lru_cache(maxsize=2)
def _gathered(path: str, digest: str, against: str, language: str) -> Gathered:
    """Gather the protocol's content; cached by the digests, as the page and its PDF are requested in turn."""
    other = Path(against) if against else None
    try:
        return gather(Path(path), against=other, language=language)
    except HasErrors:
        return gather(Path(path), against=other, language=language, draft=True)


def _data(path: str, digest: str, against: str, language: str, target: str) -> None:
    """Write the protocol, its diagrams and the legend as JSON."""
    found = _gathered(path, digest, against, language)
    legend, _, _ = draw_legend(found.pack.language)
    everything: dict[str, Any] = {"pack": asdict(found.pack), "pictures": found.pictures, "legend": legend}
    Path(target).write_text(json.dumps(everything, ensure_ascii=False), encoding="utf-8")


def _pdf(path: str, digest: str, against: str, language: str, paper: str, target: str) -> list[str]:
    """Write the PDF; return notes on what it lacks."""
    found = _gathered(path, digest, against, language)
    data, notes = set_pack(found.pack, found.pictures, "letter" if paper == "letter" else "a4")
    Path(target).write_bytes(data)
    return notes


if __name__ == "__main__":
    serve({"data": _data, "pdf": _pdf})
