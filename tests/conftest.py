"""Options and fixtures that several test files share, and how the tests share the machine's cores."""

from __future__ import annotations

import atexit
import gc
import os
import shutil
import signal
import sys
import tempfile
from pathlib import Path

import hypothesis
import pytest
from _pytest.doctest import DoctestModule
from jinja2.bccache import Bucket, BytecodeCache

# Property tests try the same examples each time, so that a run is red for what was changed; `make soak` draws others.
# How long one example takes says more about the machine than about the program.
hypothesis.settings.register_profile("same", deadline=None, derandomize=True)
hypothesis.settings.register_profile("drawn", deadline=None)
hypothesis.settings.load_profile("same")

if os.environ.pop("PYTHONDONTWRITEBYTECODE", ""):
    # The hundreds of processes that the tests start would each compile the program anew. (Not PYTHONPYCACHEPREFIX: what
    # the libraries have compiled would not be found.)
    sys.dont_write_bytecode = False

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # started in the background by a shell without job control: what the tests start would be deaf to Ctrl-C too
    signal.signal(signal.SIGINT, signal.default_int_handler)

for variable in ("LANGUAGE", "LC_ALL", "LC_MESSAGES"):
    os.environ.pop(variable, None)
os.environ["LANG"] = "C.UTF-8"  # commands speak the language of the workbook, or English

os.environ["OPENPYXL_LXML"] = "False"  # as in the program, also where a test imports openpyxl first

MEMORY, ENOUGH = Path("/dev/shm"), 4_000_000_000  # bytes
_OURS = "rrp-sheets-tests-"


def _files_in_memory() -> None:
    """Keep the tests' files in memory where there is enough: a disk takes longer to store an edit than we to make it.

    What a run leaves that has failed stays until the next one.
    """
    if "PYTEST_DEBUG_TEMPROOT" in os.environ or not MEMORY.is_dir() or shutil.disk_usage(MEMORY).free < ENOUGH:
        return
    for old in MEMORY.glob(f"{_OURS}*"):
        if not Path("/proc", old.name.removeprefix(_OURS)).exists():
            shutil.rmtree(old, ignore_errors=True)
    place = MEMORY / f"{_OURS}{os.getpid()}"
    place.mkdir(exist_ok=True)
    os.environ["PYTEST_DEBUG_TEMPROOT"] = os.environ["TMPDIR"] = str(place)


_files_in_memory()
os.environ["XDG_STATE_HOME"] = tempfile.mkdtemp(prefix="rrp-sheets-tests-state-")  # servers keep their secrets there
atexit.register(shutil.rmtree, os.environ["XDG_STATE_HOME"], ignore_errors=True)

# The files that take longest go first, so that no worker is left with one of them while the others have ended.
LONGEST = (
    "test_watchdog.py", "test_words.py", "test_run_panel.py", "test_records.py", "test_stop.py",
    "test_grid_comments.py", "test_workbooks.py", "test_grid_renaming.py", "test_lessons.py", "test_run_robot.py",
    "test_grid_filter.py", "test_gestures_grid.py", "test_help_browser.py", "test_command_language.py", "test_run.py",
    "test_tutorial.py", "test_lookback_page.py", "test_run_panel_changes.py", "test_first_rows.py", "test_print.py",
    "test_web_attack_texts.py", "test_grid_devices.py", "test_findings_in_japanese.py", "test_diff_laws.py",
    "test_grid_table_columns.py", "test_hostile_files.py", "test_grid_menu.py", "test_run_control.py",
    "test_sheets_web.py", "test_bundle.py", "test_japanese_workbooks.py", "test_event_loop.py",
    "test_runs_command.py", "test_records_pages.py", "test_web_attack_bodies.py", "test_house.py",
    "test_writing_text.py", "test_failed_requests.py", "test_writing_commands.py", "test_grid_looks.py",
    "test_grid.py", "test_web_attack_paths.py", "test_sim_run.py", "test_killed_server.py", "test_help_topics.py",
    "test_run_control_live.py", "test_house_tests.py", "test_diagram_parts.py", "test_grid_long.py",
    "test_session_in_japanese.py", "test_full_disk.py", "test_grid_frozen.py", "test_grid_help.py",
    "test_sim_dones.py", "test_gestures.py", "test_workers.py", "test_gesture_sheet.py", "test_grid_ranges.py",
    "test_grid_find.py", "test_formula_safety.py", "test_tasks.py", "test_documents.py", "test_walk.py",
    "test_run_views.py", "test_replay.py",
)  # fmt: skip


def pytest_addoption(parser):
    parser.addoption("--regenerate-golden", action="store_true", help="write tests/golden anew, for review as a diff")


class _Collection:
    """Hooks of how tests are collected."""

    @pytest.hookimpl(wrapper=True)
    def pytest_collect_file(self, file_path):
        """Look for examples only in modules that have any: to look through every module took a fifth of a start."""
        found = yield
        if file_path.suffix == ".py" and b">>>" not in file_path.read_bytes():
            found = [collector for collector in found if not isinstance(collector, DoctestModule)]
        return found

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector):
        """Begin with another file in each worker, so that each compiles a part of the files and reads the rest."""
        report = yield
        worker = getattr(collector.config, "workerinput", None)
        if worker and isinstance(collector, pytest.Dir):
            first = len(report.result) * int(worker["workerid"].removeprefix("gw")) // worker["workercount"]
            report.result = [*report.result[first:], *report.result[:first]]
        return report


def pytest_configure(config):
    """Registered as a plug-in: hooks of this file are only asked about files below tests/."""
    config.pluginmanager.register(_Collection())


def pytest_collection_modifyitems(items):
    """Order the files, in each worker alike, not the tests within one."""
    places = {name: place for place, name in enumerate(LONGEST)}
    items.sort(key=lambda item: (places.get(item.path.name, len(places)), item.path))


def pytest_collection_finish():
    """Thousands of tests and their modules stay until the end: looking through them for garbage took a fifth of the time."""
    gc.freeze()
    gc.set_threshold(20_000, 20, 50)


def pytest_runtest_logreport(report):
    """A failed test may leave a page in any state."""
    if report.failed and (chromium := sys.modules.get("chromium")):
        chromium.PAGES.spoil_taken()


def pytest_terminal_summary(terminalreporter):
    """In CI a test that was left out is a failure: `.ci/run` sets NOTHING_SKIPPED."""
    skipped = terminalreporter.stats.get("skipped", [])
    if skipped and os.environ.get("NOTHING_SKIPPED"):
        terminalreporter.section("skipped, which is a failure here")
        for report in skipped:
            terminalreporter.write_line(f"{report.nodeid}: {report.longrepr[-1] if report.longrepr else ''}")


@pytest.hookimpl(trylast=True)
def pytest_sessionfinish(session, exitstatus):
    reporter = session.config.pluginmanager.get_plugin("terminalreporter")
    if exitstatus == 0 and (ours := MEMORY / f"{_OURS}{os.getpid()}").is_dir():
        shutil.rmtree(ours, ignore_errors=True)
    if reporter and exitstatus == 0 and reporter.stats.get("skipped") and os.environ.get("NOTHING_SKIPPED"):
        session.exitstatus = pytest.ExitCode.TESTS_FAILED


@pytest.fixture(autouse=True)
def _no_limit_here(monkeypatch):
    """A command that is called within this process must not take the memory of all other tests."""
    monkeypatch.setattr("rrp_sheets.workers.worker_loop.limit_memory", lambda *_: None)


@pytest.fixture(scope="session", autouse=True)
def _workers_are_forked():
    """Engines, simulators and other workers are forked, as those of a server are: half of a short run is its start."""
    from rrp_sheets.web.services import WORKER_MODULES
    from rrp_sheets.workers.worker_process import WorkerProcess, fork_workers

    fork_workers(WORKER_MODULES)
    with pytest.MonkeyPatch.context() as patch:  # else a busy machine ends what all tests share
        patch.setattr("rrp_sheets.workers.worker_process._FORK_WITHIN", 300.0)
        yield
    if WorkerProcess.fork_server is not None:
        WorkerProcess.fork_server.close()
        WorkerProcess.fork_server = None


@pytest.fixture(params=["forked", "started"])
def process_start(request, monkeypatch):
    """Processes are forked, as those of a server on Linux; or started, as those of a command and of other systems."""
    from rrp_sheets.web.services import WORKER_MODULES
    from rrp_sheets.workers.worker_process import WorkerProcess, fork_workers

    if request.param == "started":
        monkeypatch.setattr(WorkerProcess, "fork_server", None)
    elif sys.platform != "linux":
        pytest.skip("processes are forked on Linux only")
    else:
        if WorkerProcess.fork_server is not None and WorkerProcess.fork_server.ended:
            WorkerProcess.fork_server.close()
            WorkerProcess.fork_server = None
        fork_workers(WORKER_MODULES)  # unless they are already
        assert WorkerProcess.fork_server is not None


@pytest.fixture(scope="session", autouse=True)
def _one_checker():
    """The servers of all tests check workbooks in one process: to start it takes longer than most checks."""
    from rrp_sheets.runs.check_worker import CheckWorker

    class Kept(CheckWorker):
        def close(self) -> None:
            """Keep the process: the fixture closes it when the last test has ended."""

    kept = Kept(within=300.0)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rrp_sheets.web.services.CheckWorker", lambda: kept)
        patch.setattr(CheckWorker.__init__, "__defaults__", (300.0,))  # a busy machine is no finding
        yield
    CheckWorker.close(kept)


class _Compiled(BytecodeCache):
    """Page templates as they were compiled for the first server."""

    def __init__(self) -> None:
        self._kept: dict[str, bytes] = {}

    def load_bytecode(self, bucket: Bucket) -> None:
        if bucket.key in self._kept:
            bucket.bytecode_from_string(self._kept[bucket.key])

    def dump_bytecode(self, bucket: Bucket) -> None:
        self._kept[bucket.key] = bucket.bytecode_to_string()


@pytest.fixture(scope="session", autouse=True)
def _templates_compiled_once():
    """The servers of all tests share their compiled templates: to compile them takes longer than most tests."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("flask.Flask.jinja_options", {"bytecode_cache": _Compiled()})
        yield


@pytest.fixture(scope="session")
def office(tmp_path_factory):
    """An option of LibreOffice's: the profile of this worker; a new one takes longer to make than a file to convert."""
    return f"-env:UserInstallation=file://{tmp_path_factory.mktemp('office')}/profile"


@pytest.fixture(scope="session")
def browsers():
    """The browsers of this worker: starting one takes longer than most tests."""
    from chromium import CHROMIUM, Browsers

    if not CHROMIUM:
        pytest.skip("there is no Chromium on this machine")
    found = Browsers()
    yield found
    found.close()


@pytest.fixture(scope="module")
def browser(browsers, request):
    """A browser; pages of a file's tests that nobody put back are closed. A module may ask for other `BROWSER_FLAGS`."""
    from chromium import FLAGS, PAGES

    found = browsers.browser(getattr(request.module, "BROWSER_FLAGS", FLAGS))
    yield found
    for context in list(found.contexts):
        if not PAGES.are_kept(context):
            context.close()


@pytest.fixture(scope="module")
def folder(tmp_path_factory, request):
    """A folder for the workbooks of a file's tests, with the module's `BOOKS` (sheets by file name), if any, in it."""
    from rrp_sheets.workbook.files import make_workbook

    made = tmp_path_factory.mktemp("books") / "books"
    made.mkdir()
    for name, sheets in getattr(request.module, "BOOKS", {}).items():
        make_workbook(sheets, made / name)
    return made


@pytest.fixture(scope="session")
def server():
    """The server of this worker: what its browsers have of its scripts is good for all files."""
    from chromium import PAGES, OneServer

    made = OneServer()
    PAGES.url = made.url
    yield made
    made.close()


@pytest.fixture(scope="module")
def url(server, folder):
    """The address of the server while it serves the folder of a file's tests."""
    with server.serving(folder) as address:
        yield address


@pytest.fixture(scope="module")
def page(browser, url):
    """A page of that server for all tests of a file; `problems` are the errors of its scripts."""
    from chromium import PAGES

    opened = PAGES.take(browser, url, base_url=url)
    yield opened
    PAGES.put_back(opened)


@pytest.fixture(scope="module")
def unfilmed():
    """Runs that are started from pages make no film, which takes as long as a short run."""
    from functools import partial

    from rrp_sheets.runs import RunSettings

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rrp_sheets.web.run_session.RunSettings", partial(RunSettings, film=False))
        yield


@pytest.fixture(scope="module")
def shelf(folder, url, browser):
    """Workbooks to be opened in one page, for all tests of a file."""
    from grid_books import Books

    found = Books(folder, url, browser)
    yield found
    found.close()


@pytest.fixture
def golden(request):
    """Compares a text with its file in tests/golden, or writes that file."""

    def compare(name: str, text: str) -> None:
        path = Path(__file__).parent / "golden" / name
        if request.config.getoption("--regenerate-golden"):
            path.write_text(text, encoding="utf-8")
        assert text == path.read_text(encoding="utf-8")

    return compare
