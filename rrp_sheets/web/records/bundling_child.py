"""Worker process that packs bundles: `python -m rrp_sheets.web.records.bundling_child LINK`."""

from __future__ import annotations

from pathlib import Path

from rrp_sheets.bundling import pack
from rrp_sheets.runs.worker_loop import serve


def _pack(path: str, runs: list[str], target: str) -> None:
    pack(Path(path), Path(target), runs, None, None)


if __name__ == "__main__":
    serve({"pack": _pack})
