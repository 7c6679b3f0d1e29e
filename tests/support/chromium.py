"""A real browser on a real server, for the tests of the grid."""

from __future__ import annotations

import fcntl
import json
import os
import random
import shutil
import subprocess
import threading
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from functools import lru_cache
from pathlib import Path
from typing import Any

from browser import COOKIE, TOKEN

from rrp_sheets.web.app import create_app
from rrp_sheets.web.requests import Lan
from rrp_sheets.web.serving import bind, make_server, run

CHROMIUM = next(
    (path for name in ("chromium", "chromium-browser", "google-chrome") if (path := shutil.which(name))), ""
)
SHELL = shutil.which("chromium-headless-shell") or CHROMIUM
"""The same browser without what is around a page: a new page takes it a third of the processor's time."""
_PLAIN = ("--no-sandbox", "--no-first-run", "--disable-background-networking", "--disable-component-update",
          "--disable-sync", "--disable-quic")  # fmt: skip
FLAGS = (*_PLAIN, "--disable-gpu", "--disable-3d-apis")
"""Of a browser that draws nothing in 3D: without a graphics card that takes a whole core."""
FLAGS_3D = (*_PLAIN, "--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
            "--disable-gpu-rasterization", "--disable-gpu-compositing")  # fmt: skip
"""Of one that draws 3D without a graphics card, and all else as plainly as it can: that takes a third."""


LATEST_ANSWER = float(os.environ.get("LATEST_ANSWER", "0"))
"""Seconds, up to which each answer is late by a random time; 0 answers at once. Set by who wants to try that."""


TWICE = 1500  # ms within which two presses of a key are one command, as in commands.js
LONGEST_WAIT = 300.0
"""Seconds that a test waits for what must come: more than a machine needs that has many other things to do."""


def _late(answer: Callable[..., Any]) -> Callable[..., Any]:
    def answer_late(environ: Any, start_response: Any) -> Any:
        time.sleep(random.uniform(0, LATEST_ANSWER))
        return answer(environ, start_response)

    return answer_late


@contextmanager
def serving(folder: Path, lan: Lan | None = None) -> Iterator[str]:
    """A server on a folder; gives its address."""
    app = create_app(folder, TOKEN, lan)
    if LATEST_ANSWER:
        app.wsgi_app = _late(app.wsgi_app)  # type: ignore[method-assign]
    server = make_server(app, bind(["127.0.0.1"], None))
    thread = threading.Thread(target=run, args=(server,), daemon=True)
    thread.start()
    try:
        yield f"http://127.0.0.1:{server.effective_port}"
    finally:
        app.extensions["services"].close()
        server.close()
        server.task_dispatcher.shutdown(timeout=1)


class OneServer:
    """A server on one port, for one folder after the other: what a browser keeps of its addresses stays good."""

    def __init__(self) -> None:
        self._app: Any = None
        self._server = make_server(self._answer, bind(["127.0.0.1"], None))  # type: ignore[arg-type]
        self.url = f"http://127.0.0.1:{self._server.effective_port}"
        threading.Thread(target=run, args=(self._server,), daemon=True).start()

    def _answer(self, environ: Any, start_response: Any) -> Any:
        if self._app is None:
            start_response("503 Service Unavailable", [("Content-Length", "0")])
            return [b""]
        return self._app(environ, start_response)

    @contextmanager
    def serving(self, folder: Path) -> Iterator[str]:
        """Serve a folder; gives the address, which is always the same."""
        app = create_app(folder, TOKEN)
        self._app = _late(app.wsgi_app) if LATEST_ANSWER else app
        try:
            yield self.url
        finally:
            self._app = None
            app.extensions["services"].close()

    def close(self) -> None:
        self._server.close()
        self._server.task_dispatcher.shutdown(timeout=1)


class Browsers:
    """Browsers that are started when they are wanted, one for each set of flags, and used again.

    Args:
        shell: whether they may be without what is around a page.
    """

    def __init__(self, *, shell: bool = True) -> None:
        self._shell = shell
        self._started = ExitStack()
        self._chromium: Any = None
        self._open: dict[tuple[str, ...], Any] = {}

    def browser(self, flags: Sequence[str] = FLAGS) -> Any:
        """A browser without anything in it."""
        found = self._open.get(tuple(flags))
        if found is None or not found.is_connected():
            if self._chromium is None:
                from playwright.sync_api import expect, sync_playwright

                expect.set_options(timeout=LONGEST_WAIT * 1000)
                self._chromium = self._started.enter_context(sync_playwright()).chromium
            program = SHELL if self._shell else CHROMIUM
            found = self._open[tuple(flags)] = self._chromium.launch(executable_path=program, args=list(flags))
            found.new_context, found.new_page = _patient(found.new_context), _patient(found.new_page)
        return found

    def close(self) -> None:
        """End them all."""
        for browser in self._open.values():
            browser.close()
        self._started.close()


def _patient(new: Callable[..., Any]) -> Callable[..., Any]:
    """Wrap a browser's `new_context` or `new_page`, so that pages wait up to LONGEST_WAIT and not Playwright's 30 s."""

    def opened(**options: Any) -> Any:
        made = new(**options)
        made.set_default_timeout(LONGEST_WAIT * 1000)
        return made

    return opened


def press_twice(page: Any, key: str = "Escape") -> None:
    """Press a key twice in a row; again where the page took the second press too late, as a busy machine may."""
    page.evaluate(
        """key => { const times = window.presses = [];
            window.addEventListener("keydown", (event) => event.key === key && times.push(event.timeStamp), true); }""",
        key,
    )
    pause = None
    while pause is None or pause >= TWICE:
        page.keyboard.press(key)
        pause = page.evaluate("(([a, b]) => b === undefined ? null : b - a)(window.presses.slice(-2))")


@contextmanager
def browsing() -> Iterator[Any]:
    """A browser of its own, for what measures; tests share theirs (`browser` in conftest.py)."""
    browsers = Browsers(shell=False)
    try:
        yield browsers.browser()
    finally:
        browsers.close()


_NEW_LOOK = {
    "color_scheme": "light", "reduced_motion": "no-preference", "forced_colors": "none", "contrast": "no-preference",
}  # fmt: skip
"""Media features of a new page; `take` sets them again, as a test may have emulated others."""


class Pages:
    """Pages of the worker's server that are used again: a new one takes longer than most of what is done in it.

    Whoever has done with a page puts it back: as if it were new, but that its browser has the server's scripts already.
    Who adds an init script or a handler of events to one spoils it.
    """

    def __init__(self) -> None:
        self.url = ""  # of the worker's server: no other stays
        self._free: dict[str, list[Any]] = {}
        self._made: dict[Any, str] = {}

    def take(self, browser: Any, url: str, name: str = "", **options: Any) -> Any:
        """A page of somebody's who is let in; `problems` are the errors of its scripts."""
        options = {"viewport": {"width": 1280, "height": 800}, **_NEW_LOOK} | options
        kind = repr((id(browser), url, name, sorted(options.items())))
        if free := self._free.get(kind):
            page = free.pop()
            page.set_viewport_size(options["viewport"])
            page.emulate_media(media="null", **{name: options[name] for name in _NEW_LOOK})
            _give_cookie(page.context, url)
        else:
            context = browser.new_context(**options)
            let_in(context, url, name)
            page = context.new_page()
            page.on("pageerror", lambda error: page.problems.append(str(error)))
            if url == self.url:
                self._made[page] = kind
                page.on("close", self.spoil)
        page.problems = []
        page.context.grant_permissions(["clipboard-read", "clipboard-write"])
        return page

    def put_back(self, page: Any) -> None:
        """Let another use the page, or close it when it is not as it was when it was made."""
        kind = self._made.get(page)
        if kind is None:
            page.context.close()
            return
        for other in page.context.pages:
            if other is not page:
                other.close()
        leave(page, self.url)
        page.mouse.up()
        for key in ("Alt", "Control", "Meta", "Shift"):
            page.keyboard.up(key)
        page.context.clear_cookies()
        page.context.clear_permissions()
        self._free.setdefault(kind, []).append(page)

    def spoil(self, page: Any) -> None:
        """Let a page not be used again: it was closed, or something was done to it that cannot be undone."""
        free = self._free.get(self._made.pop(page, ""), [])
        if page in free:
            free.remove(page)

    def spoil_taken(self) -> None:
        """Let no page that somebody has now be used again."""
        free = {page for pages in self._free.values() for page in pages}
        self._made = {page: kind for page, kind in self._made.items() if page in free}

    def are_kept(self, context: Any) -> bool:
        """True for a context whose page was put back."""
        return any(page.context is context for pages in self._free.values() for page in pages)


PAGES = Pages()


def leave(page: Any, url: str) -> None:
    """Let a page forget what it keeps and what is done with its requests; nothing runs in it then."""
    page.unroute_all()
    page.context.unroute_all()
    page.goto(f"{url}/static/login.css")
    page.evaluate("() => { localStorage.clear(); sessionStorage.clear(); window.name = ''; }")


def set_clock(page: Any, **begin: Any) -> None:
    """Give a page a clock that is set by hand; nobody else uses that page."""
    PAGES.spoil(page)
    page.clock.install(**begin)


@contextmanager
def requests_of(page: Any) -> Iterator[list[str]]:
    """Addresses that a page asks for meanwhile."""
    asked: list[str] = []

    def note(request: Any) -> None:
        asked.append(request.url)

    page.on("request", note)
    try:
        yield asked
    finally:
        page.remove_listener("request", note)


def _give_cookie(context: Any, url: str) -> None:
    cookie, value = COOKIE.split("=")
    context.add_cookies([{"name": cookie, "value": value, "url": url, "httpOnly": True, "sameSite": "Strict"}])


def let_in(context: Any, url: str, name: str = "") -> None:
    """Give a browser the cookie that it would get with a link, and its user a name."""
    _give_cookie(context, url)
    if name:
        script = "if (location.protocol === 'http:') localStorage.getItem('name') ?? localStorage.setItem('name', %s)"
        context.add_init_script(script % json.dumps(name))


@lru_cache(maxsize=1)
def axe() -> str:
    """The script of axe-core, fetched with npm as package-lock.json pins it; into a folder that git ignores."""
    root = Path(__file__).parents[2]
    folder = root / "node_modules" / ".axe"
    script = folder / "node_modules" / "axe-core" / "axe.min.js"
    npm = shutil.which("npm")
    if npm:
        folder.mkdir(parents=True, exist_ok=True)
        with (folder / "lock").open("w") as lock:
            fcntl.flock(lock, fcntl.LOCK_EX)  # one test worker at a time: npm empties the folder before it fills it
            if not script.is_file():
                for name in ("package.json", "package-lock.json"):
                    shutil.copy(root / name, folder)
                command = [npm, "ci", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
                subprocess.run(command, cwd=folder, check=False, timeout=600)
    return script.read_text(encoding="utf-8") if script.is_file() else ""


def violations(page: Any, without: Sequence[str] = ()) -> list[str]:
    """Violations that axe-core finds on a page `without` some parts of it, a line for each element."""
    if not page.evaluate("() => 'axe' in window"):
        assert axe(), "npm could not fetch axe-core: what it would find is not known"
        page.evaluate(axe())
    script = """async (exclude) => (await axe.run(exclude.length ? { exclude } : document, {
        resultTypes: ['violations'], preload: false, selectors: false, iframes: document.querySelector('iframe') !== null,
      })).violations.flatMap((rule) => rule.nodes.map((node) => `${rule.id}: ${node.html.slice(0, 120)}`))"""
    found: list[str] = page.evaluate(script, list(without))
    return found


LOOKS = [("light", 1280), ("dark", 400)]  # each colour and each width; crossed by `make soak`


def violations_by_look(
    page: Any, looks: Sequence[tuple[str, int]] = LOOKS, without: Sequence[str] = ()
) -> dict[str, list[str]]:
    """Violations that axe-core finds on a page in some colours and widths, by the look; the page is wide then."""
    found = {}
    for scheme, width in looks:
        page.set_viewport_size({"width": width, "height": 900})
        page.emulate_media(color_scheme=scheme)
        page.wait_for_function(
            "() => !document.getAnimations().some((a) => a instanceof CSSTransition && a.playState === 'running')"
        )
        if wrong := violations(page, without):
            found[f"{scheme} {width}"] = wrong
    page.set_viewport_size({"width": 1280, "height": 900})
    return found


def frames(page: Any, count: int = 1) -> None:
    """Let the browser draw so many pictures."""
    for _ in range(count):
        page.evaluate("() => new Promise((done) => requestAnimationFrame(() => done()))")


def until(page: Any, holds: Callable[[], object], seconds: float = LONGEST_WAIT) -> None:
    """Wait, picture by picture, until something holds that the page does not know."""
    deadline = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < deadline, f"it does not hold after {seconds:g} s"
        frames(page)


def eventually(holds: Callable[[], object], about: object = "", seconds: float = LONGEST_WAIT) -> None:
    """Wait until something that is read from a page holds: what a page shows may come a moment later."""
    assert _waited(holds, bool, seconds), f"it does not hold after {seconds:g} s {about}"


def becomes(read: Callable[[], object], wanted: object, about: object = "", seconds: float = LONGEST_WAIT) -> None:
    """Wait until what is read from a page is as wanted."""
    now = _waited(read, lambda found: found == wanted, seconds)
    assert now == wanted, about


def some(read: Callable[[], Any]) -> Any:
    """Wait until there is something to be read from a page, and give it."""
    now = _waited(read, bool, LONGEST_WAIT)
    assert now, f"there is nothing after {LONGEST_WAIT:g} s but {now!r}"
    return now


def _waited(read: Callable[[], Any], wanted: Callable[[Any], bool], seconds: float) -> Any:
    """Read again and again until the value is as wanted or the time is over; return the last value."""
    deadline = time.monotonic() + seconds
    pause = 0.02
    while not wanted(now := read()) and time.monotonic() < deadline:
        time.sleep(pause)  # another process is waited for, and each look takes it time
        pause = min(1.3 * pause, 0.2)
    return now


def listening(page: Any) -> None:
    """Wait until a page is told what happens; one that never is says what it is instead."""
    from playwright.sync_api import TimeoutError

    try:
        page.wait_for_selector("#listen[data-htmx-powered]", state="attached")
    except TimeoutError as error:
        script = """() => [document.readyState, typeof htmx, document.getElementById('listen')?.outerHTML ?? 'no #listen',
          document.body.innerText.slice(0, 300), ...performance.getEntriesByType('resource').map((e) =>
          [e.name.replace(/.*:\\d+/, ''), e.responseStatus, Math.round(e.startTime), Math.round(e.duration)].join(' '))]"""
        raise AssertionError(f"{page.url} does not listen: " + "\n".join(page.evaluate(script))) from error


class GridPage:
    """A page with a grid, and what one does with it."""

    def __init__(
        self,
        browser: Any,
        url: str,
        book: str,
        *,
        sheet: str = "",
        name: str = "",
        recorder: Any = None,
        **context: Any,
    ) -> None:
        self.page = PAGES.take(browser, url, name, **context)
        self.context, self.errors = self.page.context, self.page.problems
        if recorder:
            PAGES.spoil(self.page)
            recorder.watch(self.context)
        self.page.goto(f"{url}/book/{book}" + (f"/sheet/{sheet}" if sheet else ""))
        listening(self.page)

    def press(self, *keys: str) -> None:
        for key in keys:
            self.page.keyboard.press(key)

    def type(self, text: str, then: str = "Enter") -> None:
        """Type a text key by key."""
        self.page.keyboard.type(text)
        self.page.keyboard.press(then)

    def write(self, text: str, then: str = "Enter") -> None:
        """Begin a text with a key; the rest comes at once: a browser draws a picture for each key."""
        self.page.keyboard.type(text[:1])
        if text[1:]:
            self.page.keyboard.insert_text(text[1:])
        if then:
            self.page.keyboard.press(then)

    def cell(self, address: str) -> Any:
        """A cell by its address, such as C4."""
        letter, number = address[0], address[1:]
        return self.page.locator(f"tbody tr:has(th.number:text-is('{number}')) > *").nth(self._place(letter))

    def _place(self, letter: str) -> int:
        script = "l => document.querySelector(`thead th[data-letter='${l}']`).cellIndex"
        return int(self.page.evaluate(script, letter))

    def text(self, address: str) -> str:
        """Text that was typed into a cell."""
        return self.cell(address).get_attribute("data-v") or ""

    def expect(self, address: str, text: str) -> None:
        """Wait until a cell holds a text."""
        from playwright.sync_api import expect

        cell = self.cell(address)
        if text:
            expect(cell).to_have_attribute("data-v", text)
        else:
            expect(cell).not_to_have_attribute("data-v", "x")

    def go(self, address: str) -> None:
        self.cell(address).click(position={"x": 3, "y": 3})

    @property
    def here(self) -> str:
        """The address of the cell with the cursor."""
        return str(self.page.inner_text("#formula-bar b"))

    def saved(self) -> None:
        """Wait until everything is stored."""
        self.page.wait_for_selector("body:not([data-saving])")

    def close(self) -> None:
        assert not self.errors, self.errors
        PAGES.put_back(self.page)
