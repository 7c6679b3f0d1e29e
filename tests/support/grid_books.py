"""One server and one browser page for all tests of a file; each test opens a workbook of its own in it."""

from __future__ import annotations

import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any

from chromium import PAGES, GridPage, listening, violations
from playwright.sync_api import Error

from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import make_workbook

HEADER = ["On", "Input streams", "Connector", "Formula", "Output stream", "Notes"]
ROWS = [
    ["", "Red ball", "map", "redBall.distance", "Distance", ""],
    ["", "Distance", "filter", "distance < 0.5", "Close ball", "near"],
    ["", "Close ball", "subscribe", "", "Head tracker", ""],
]
Sheets = Mapping[str, Sequence[Sequence[str]]]
TRACKING: Sheets = {"T": [HEADER, *ROWS]}
EMPTY: Sheets = {"T": [HEADER, [""] * 6]}


class Shared(GridPage):
    """A grid in a page that is used again; `path` is the workbook's file."""

    def __init__(self, page: Any, path: Path) -> None:
        self.page, self.context, self.errors, self.path = page, page.context, page.problems, path

    def rows(self) -> list[tuple[str, str, str, str]]:
        """The rows of the first behaviour as the file has them."""
        self.saved()
        found = read(self.path).workbook.behaviours[0].rows
        return [(r.inputs_cell.text, r.connector.text, r.formula.text, r.output.text) for r in found]

    def checked(self) -> None:
        """Wait until the check has ended and the page knows it."""
        self.page.wait_for_selector("body[data-words] #panels:not([aria-busy=true])")

    @property
    def spoken(self) -> str:
        """Text that a screen reader was given last."""
        return str(self.page.inner_text("#spoken")).replace("\u00a0", "").strip()

    def wait_spoken(self, text: str) -> None:
        """Wait until a screen reader is told something."""
        self.page.wait_for_function("t => document.getElementById('spoken').textContent.includes(t)", arg=text)

    def faults(self) -> list[str]:
        """Violations that axe-core finds on the page; the diagram has tests of its own."""
        return [fault for fault in violations(self.page) if '<g id="b' not in fault]

    def status(self, text: str) -> None:
        """Wait until the status line says something."""
        self.page.wait_for_selector(f"#status:has-text({text!r})")

    def offered(self, address: str, typed: str = "") -> list[str]:
        """Suggestions in a cell when a text is typed, or its editor is opened; the cell stays as it is."""
        self.go(address)
        return self.offered_here(typed)

    def offered_here(self, typed: str = "") -> list[str]:
        """The same in the cell with the cursor."""
        self.write(typed, then="") if typed else self.press("F2")
        found = [str(t) for t in self.page.locator("[role=option] .name").all_inner_texts()]
        while self.page.locator(".editor textarea").count():
            self.press("Escape")
        return found


class Books:
    """A folder with a server on it, and a browser with one page."""

    def __init__(self, folder: Path, url: str, browser: Any) -> None:
        self.folder, self.url, self.browser = folder, url, browser
        self.made: dict[str, Path] = {}
        self.page = self._page()
        self._pages = {"": self.page}

    def _page(self, name: str = "") -> Any:
        return PAGES.take(self.browser, self.url, name)

    def file(self, sheets: Sheets = TRACKING) -> Path:
        """A new file with a workbook; the same workbook is made only once."""
        kind = repr(sheets)
        path = self.folder / f"b{len(list(self.folder.iterdir()))}.xlsx"
        if kind in self.made:
            shutil.copy(self.made[kind], path)
        else:
            pattern = self.folder.parent / f"{self.folder.name}-{len(self.made)}.xlsx"
            make_workbook(sheets, pattern)
            self.made[kind] = pattern
            shutil.copy(pattern, path)
        return path

    def open(self, sheets: Sheets = TRACKING, *, sheet: str = "", path: Path | None = None, name: str = "") -> Shared:
        """A workbook of its own in the page; or the page of somebody of that name."""
        path = path or self.file(sheets)
        page = self._pages.get(name)
        if page is None:
            page = self._pages[name] = self._page(name)
        _go(page, f"{self.url}/book/{path.name}" + (f"/sheet/{sheet}" if sheet else ""))
        listening(page)
        return Shared(page, path)

    def two(self) -> tuple[Shared, Shared]:
        """Aya and Mika at the same workbook."""
        path = self.file()
        return self.open(path=path, name="Aya"), self.open(path=path, name="Mika")

    def close(self) -> None:
        """Close the pages; they have had no fault."""
        problems = [problem for page in self._pages.values() for problem in page.problems]
        for page in self._pages.values():
            PAGES.put_back(page)
        assert not problems, problems


def _go(page: Any, address: str) -> None:
    """Open a page; the one before may still be storing its last edit, or be loading again by itself."""
    for _ in range(3):
        with suppress(Error):
            page.wait_for_selector("body:not([data-saving])", state="attached", timeout=300_000)
            page.goto(address)
            return
    page.goto(address)
