"""The diagram beside the grid with 50 rows: from the key that ends an edit to the new diagram on the screen, and of
that the part of the server's picture (`/panels`).

Wall time on this machine, browser included; other programs count.
"""

from __future__ import annotations

import sys
from pathlib import Path

import pytest

sys.path.insert(0, str(Path(__file__).parents[1] / "support"))

from chromium import CHROMIUM, GridPage, browsing, serving

from rrp_sheets.workbook.files import make_workbook

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
EDITS = 7
WATCH = """(text) => {
    let from = 0;
    document.addEventListener("keydown", () => { from = performance.now(); }, { capture: true, once: true });
    window.redrawn = new Promise((done, give) => {
        setTimeout(() => give(new Error("no new diagram")), 20000);
        const watch = new MutationObserver(() => {
            if (!document.getElementById("diagram").textContent.includes(text)) return;
            watch.disconnect();
            requestAnimationFrame(() => setTimeout(() => {
                const panels = performance.getEntriesByType("resource").filter((e) => e.name.includes("/panels/")).at(-1);
                done([performance.now() - from, panels ? panels.duration : 0]);
            }, 0));
        });
        watch.observe(document.getElementById("panels"), { subtree: true, childList: true, characterData: true });
    });
}"""


@pytest.mark.skipif(not CHROMIUM, reason="there is no Chromium on this machine")
def test_the_diagram_follows_an_edit(tmp_path: Path) -> None:
    rows = []
    for n in range(0, 50, 5):
        rows += [
            ["", "Red ball", "map", "redBall.distance", f"D{n}", ""],
            ["", f"D{n}", "filter", "value > 1", f"Far {n}", ""],
            ["", f"D{n}", "filter", "value <= 1", f"Near {n}", ""],
            ["", f"Near {n}", "map", "value * 2", f"Twice {n}", ""],
            ["", f"Twice {n}", "subscribe", "", "Print", ""],
        ]
    make_workbook({"T": [HEADER, *rows]}, tmp_path / "b.xlsx")
    with serving(tmp_path) as url, browsing() as browser:
        grid = GridPage(browser, url, "b.xlsx")
        grid.page.wait_for_selector("#diagram [data-row='51']")
        times = []
        for n in range(EDITS):
            grid.go("D5")
            grid.page.keyboard.type(f"value * {n + 30}")
            grid.page.evaluate(WATCH, f"value * {n + 30}")
            grid.press("Enter")
            times.append(grid.page.evaluate("window.redrawn"))
        grid.close()
    whole, panels = (sorted(t[k] for t in times)[EDITS // 2] for k in (0, 1))
    print(
        f"\n50 rows: from the key to the new diagram {whole:.0f} ms, of that {panels:.0f} ms the server's picture (median)"
    )
    assert whole < 300
