"""Workbooks for sessions in the run panel, and what one does there."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

from chromium import press_twice

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
TRACKING = [
    HEADER,
    ["", "Red ball", "map", "redBall.distance", "Distance", "<b>bold</b>"],
    ["", "Distance", "filter", "distance < 0.3", "Near", ""],
    ["", "Near", "subscribe", "", "Head tracker", ""],
    ["no", "Near", "subscribe", "", "Print", ""],
    ["", "Distance", "map", "1 / (distance - distance)", "Bad", ""],
    ["", "Bad", "subscribe", "", "Print", ""],
]
CHEER = [
    HEADER,
    ["", "Encourage, Well done", "merge", "", "Pressed", ""],
    ["", "Pressed", "map", 'IF(pressed.label = "Encourage"; "You can do it"; "Well done <i>you</i>")', "Words", ""],
    ["", "Words", "subscribe", "", "Say", ""],
]
DEVICES = [
    ["Stream", "Device", "Label", "Notes"],
    ["Encourage", "OperatorButton", "Encourage", ""], ["Well done", "OperatorButton", "Well done", ""],
]  # fmt: skip
SCENE = [["Time (s)", "Thing", "Does", "Value"], ["0", "Red ball", "appears", "at 1, 0, 0.4"]]
LONG = [HEADER, *(["", "Red ball", "map", f"redBall.distance + {n}", f"D{n}", ""] for n in range(60)),
        ["", "D1", "subscribe", "", "Head tracker", ""]]  # fmt: skip
SESSION = {"Tracking": TRACKING, "Cheer": CHEER, "Devices": DEVICES, "Scene": SCENE}
WRONG = [TRACKING[0], TRACKING[1], ["", "Distance", "filter", "distence < 0.3", "Near", ""], TRACKING[3]]
BOOKS = {"session.xlsx": SESSION, "long.xlsx": {"T": LONG}, "wrong.xlsx": {"T": WRONG}}
LIVE = "td.example .live .value"


def run(page: Any, **settings: str) -> None:
    """Press Run, answer what is asked, and wait until it runs."""
    page.wait_for_selector("#panels:not([aria-busy])", state="attached")
    page.click("[data-run=start]")
    if settings:
        page.check("#run-dialog [value=simulated]")
    for name, text in settings.items():
        page.fill(f"#run-dialog [name={name}]", text)
    page.click("#run-dialog [type=submit]")
    running(page)


def running(page: Any) -> None:
    page.wait_for_selector("body[data-run=running]")


def ended(page: Any) -> str:
    page.wait_for_selector("body[data-run=ended]")
    return str(page.inner_text("#run-notice"))


def trace(folder: Path, book: str) -> list[dict[str, Any]]:
    """The trace of the newest run of a workbook."""
    newest = max((folder / "runs").glob(f"*-{book}*"), key=lambda p: p.stat().st_mtime)
    return [json.loads(line) for line in (newest / "trace.jsonl").read_text(encoding="utf-8").splitlines()]


def row(page: Any, number: int) -> Any:
    return page.locator(f"tbody tr:has(th.number:text-is('{number}'))")


def told_of_stop(page: Any) -> dict[str, float]:
    """Press Esc twice; by phase, the milliseconds from the second press until the page told it."""
    page.evaluate("""() => {
        window.addEventListener('keydown', () => { window.pressed = performance.now(); }, { capture: true });
        const told = window.told = {};
        new MutationObserver(() => { told[document.body.dataset.run] ??= performance.now() - window.pressed; })
            .observe(document.body, { attributeFilter: ['data-run'] });
    }""")
    press_twice(page)
    ended(page)
    return dict(page.evaluate("window.told"))
