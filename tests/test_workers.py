"""Worker processes: their tasks exist, and what arrives is what was sent, or nothing."""

from __future__ import annotations

import errno
import json
import os
import re
import resource
import select
import signal
import socket
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any, Literal

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import rrp_sheets
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.exchange import Command, Notice, WorldSnapshot, WorldState
from rrp_sheets.robots.catalogue import load_robot
from rrp_sheets.sim.process import Spec
from rrp_sheets.web.services import WORKER_MODULES
from rrp_sheets.workers.codec import pack, unpack
from rrp_sheets.workers.transport import MessageReader, encode
from rrp_sheets.workers.worker_loop import MOST_MEMORY, named
from rrp_sheets.workers.worker_process import (
    ForkedProcess,
    ForkServer,
    RestartingWorker,
    Task,
    WorkerError,
    WorkerProcess,
    fork_workers,
)

PACKAGE = Path(rrp_sheets.__file__).parent
TASK = re.compile(r'"(rrp_sheets(?:\.\w+){2,})"|f"\{__name__\}\.(\w+)"')


def tasks() -> list[str]:
    """The dotted names that are written in the program as texts."""
    found = set()
    for file in PACKAGE.rglob("*.py"):
        module = ".".join(file.relative_to(PACKAGE.parent).with_suffix("").parts)
        for whole, own in TASK.findall(file.read_text(encoding="utf-8")):
            found.add(whole or f"{module}.{own}")
    return sorted(found)


@pytest.mark.parametrize("name", sorted(set(tasks()) - set(WORKER_MODULES)))
def test_task_is_a_function(name: str) -> None:
    assert callable(named(name))


@pytest.mark.slow
@pytest.mark.parametrize("name", WORKER_MODULES)
def test_module_of_the_fork_server_exists(name: str) -> None:
    assert find_spec(name) is not None


# ---- forked
@pytest.fixture
def fork_server(monkeypatch: pytest.MonkeyPatch) -> Iterator[ForkServer]:
    """A fork server of its own."""
    made = ForkServer(["fractions"])
    monkeypatch.setattr(WorkerProcess, "fork_server", made)
    yield made
    made.close()


def forked(worker: WorkerProcess) -> bool:
    return isinstance(worker._process, ForkedProcess)


def test_worker_is_forked_with_the_modules_environment_and_folder_of_its_starter(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("RRP_TRIED", "yes")
    worker = WorkerProcess(scratch=True)
    assert forked(worker) and worker.pid != fork_server.pid and not worker.ended
    assert worker.ask(["os.getcwd"], 300) == str(tmp_path) and worker.ask(["os.getenv", "RRP_TRIED"], 300) == "yes"
    assert worker.ask(["tempfile.gettempdir"], 300) == worker._scratch.name != tempfile.gettempdir()  # type: ignore[union-attr]
    assert worker.ask(["os.getpgid", 0], 300) == worker.pid == worker.ask(["os.getpid"], 300)
    worker.close(300)
    assert worker.ended


def test_end_of_a_forked_worker_is_told(fork_server: ForkServer) -> None:
    worker = WorkerProcess()
    with pytest.raises(WorkerError, match=r"exit code 7"):
        worker.ask(["os._exit", 7], 300)
    killed = WorkerProcess()
    os.kill(killed.pid, signal.SIGKILL)
    assert killed.receive(300) is None and killed.exit_summary() == " (signal 9)"
    slow = WorkerProcess()
    with pytest.raises(WorkerError, match=r"did not end within 0\.2 s"):
        slow.ask(["signal.pause"], 0.2)
    assert slow.ended and slow.exit_summary() == " (signal 9)"
    failing = WorkerProcess(Task("os.nothing"))
    assert failing.receive(300) is None and "AttributeError" in failing.exit_summary()
    full = WorkerProcess(Task("os.fchdir"))
    assert full.receive(300) is None and "NotADirectoryError" in full.exit_summary(), "an OSError too is its own"
    for each in (worker, killed, slow, failing, full):
        each.close()


def test_process_that_ends_at_once_is_not_begun_twice(fork_server: ForkServer) -> None:
    worker = WorkerProcess(Task("os.nothing"))
    assert forked(worker) and WorkerProcess.fork_server is fork_server
    worker.close(300)


def test_exit_code_that_nobody_tells_is_not_called_a_signal(fork_server: ForkServer) -> None:
    worker = WorkerProcess()
    os.kill(fork_server.pid, signal.SIGKILL)
    with pytest.raises(WorkerError) as error:
        worker.ask(["os._exit", 7], 300)
    assert "signal" not in str(error.value) and worker.ended
    worker.close()


def test_worker_begins_in_a_folder_that_was_deleted(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    gone = tmp_path / "gone"
    gone.mkdir()
    monkeypatch.chdir(gone)
    gone.rmdir()
    worker = WorkerProcess()
    assert forked(worker) and worker.ask(["os.getpid"], 300) == worker.pid
    worker.close()


def test_worker_with_a_large_environment_is_started(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(3):
        monkeypatch.setenv(f"RRP_LONG_{number}", "x" * 60_000)
    started = WorkerProcess()
    assert not forked(started) and started.ask(["os.getpid"], 300) == started.pid
    monkeypatch.undo()
    monkeypatch.setattr(WorkerProcess, "fork_server", fork_server)
    worker = WorkerProcess()
    assert forked(worker)
    for each in (worker, started):
        each.close()


def test_request_that_cannot_be_granted_leaves_the_fork_server(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    with open(os.devnull) as no_folder:
        monkeypatch.setattr("os.open", lambda *_: os.dup(no_folder.fileno()))
        worker = WorkerProcess()
    monkeypatch.undo()
    monkeypatch.setattr(WorkerProcess, "fork_server", fork_server)
    again = WorkerProcess()
    assert not forked(worker) and forked(again)
    for each in (worker, again):
        each.close()


def test_forked_worker_whose_pidfd_does_not_fit_is_not_begun_twice(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    receive, begun = socket.recv_fds, list[int]()

    def receive_no_file(*of: Any) -> tuple[bytes, list[int], int, None]:
        pid, files, *_ = receive(*of)
        begun.extend(files)
        return pid, [], 0, None

    monkeypatch.setattr("socket.recv_fds", receive_no_file)
    with pytest.raises(OSError, match=os.strerror(errno.EMFILE)):
        WorkerProcess()
    assert select.select(begun, [], [], 300)[0] == begun != [], "the process that has begun ends"
    os.close(begun[0])


def test_libraries_of_the_fork_server_take_no_memory_from_formulas(monkeypatch: pytest.MonkeyPatch) -> None:
    made = ForkServer(["cv2"])
    monkeypatch.setattr(WorkerProcess, "fork_server", made)
    worker = WorkerProcess()
    limit, taken = worker.ask(["resource.getrlimit", resource.RLIMIT_AS], 300)[0], address_space(worker.pid)
    assert forked(worker) and limit - taken > 0.95 * MOST_MEMORY and taken > 100_000_000
    worker.close()
    made.close()


def address_space(pid: int) -> int:
    """The bytes of address space that a process has taken."""
    return int(Path(f"/proc/{pid}/statm").read_text().split()[0]) * resource.getpagesize()


def test_without_pidfds_workers_are_started(monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: int) -> int:
        raise OSError(errno.ENOSYS, "not here")

    monkeypatch.setattr(WorkerProcess, "fork_server", None)
    monkeypatch.setattr("os.pidfd_open", refuse)
    fork_workers(["fractions"])
    assert WorkerProcess.fork_server is None


def test_without_its_fork_server_a_worker_is_started(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    before = WorkerProcess()
    os.kill(fork_server.pid, signal.SIGKILL)
    assert not before.ended and before.ask(["os.getpid"], 300) == before.pid, "it goes on"
    started = WorkerProcess()
    assert not forked(started) and started.ask(["os.getppid"], 300) == os.getpid()
    started.close(300)
    before.kill()
    assert started.ended and before.ended
    before.close()


def test_fork_server_that_hangs_is_ended_and_the_worker_started(
    fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("rrp_sheets.workers.worker_process._FORK_WITHIN", 0.5)
    os.kill(fork_server.pid, signal.SIGSTOP)
    worker = WorkerProcess()
    assert not forked(worker) and worker.ask(["os.getpid"], 300) == worker.pid
    assert fork_server._process.ended and WorkerProcess.fork_server is None
    worker.close()


def test_fork_server_does_without_modules_that_are_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    made = ForkServer(["rrp_sheets.is_no_module", "fractions"])
    monkeypatch.setattr(WorkerProcess, "fork_server", made)
    worker = WorkerProcess()
    assert forked(worker) and worker.ask(["os.getpid"], 300) == worker.pid
    worker.close()
    made.close()


def test_worker_of_another_interpreter_is_started(fork_server: ForkServer, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("PYTHONHASHSEED", "1")
    worker = WorkerProcess()
    assert not forked(worker) and worker.ask(["os.getpid"], 300) == worker.pid
    worker.close()


@given(st.lists(st.binary(max_size=300), max_size=3), st.integers(1, 40))
@settings(max_examples=60, deadline=None)
def test_messages_arrive_whole_in_whatever_pieces(pictures: list[bytes], size: int) -> None:
    here, there = socket.socketpair()
    with here, there:
        messages = [["a", 1], ["pictures", *pictures], ["b\n", {"bytes": 2, "x": None}],
                    ["c", b"d", {"bytes": 0}, [{"bytes": {"bytes": [1]}}]]]  # fmt: skip
        data = b"".join(map(encode, messages))
        reader, got = MessageReader(there), []
        for begin in range(0, len(data), size):
            here.sendall(data[begin : begin + size])
            got += reader.receive() or []
    assert got == messages


def test_values_keep_their_types() -> None:
    command = Command("s", ("a", [1, 2.0, None], {"x": (True,)}), sensors=("t",))
    state = WorldState({"HeadYaw": 0.5}, (0.0,), (), "", {"bytes": (1.0, 0.0)}, looks={"Ball": {"size": [0.1]}})
    for thing in (command, WorldSnapshot(state, b"\n[]\0"), Notice("say", "Grüß \udce9")):
        here, there = socket.socketpair()
        with here, there:
            here.sendall(encode([pack(thing)]))
            [[got]] = MessageReader(there).receive() or []
        assert unpack(type(thing), got) == thing


def test_a_robot_arrives_as_it_was_sent() -> None:
    spec = Spec(load_robot(), seed=3, beside="a folder")
    assert unpack(Spec, json.loads(encode(pack(spec)))) == spec


@pytest.mark.parametrize("hint", [set, object, str | Notice | Path, Literal["a"]])
def test_what_has_no_codec_is_refused_at_once(hint: object) -> None:
    with pytest.raises(TypeError, match="there is no codec"):
        pack("a", hint)


def test_what_cannot_be_sent_is_named() -> None:
    with pytest.raises(TypeError, match="set cannot be sent"):
        encode([{1}])


def test_an_answer_that_takes_too_much_memory_is_told_as_that() -> None:
    worker = WorkerProcess()
    try:
        with pytest.raises(WorkerError, match="needed more memory") as told:
            worker.ask(["operator.mul", "x" * 1_000_000, 900], 300)
        assert not told.value.gone
    finally:
        worker.close()
    assert worker.receive(0) is None


def test_another_object_than_was_expected_is_refused() -> None:
    with pytest.raises(ValueError, match="Notice is no Command"):
        unpack(Command, pack(Notice("say", "Hello")))


def test_an_error_of_a_task_is_raised_here() -> None:
    worker = RestartingWorker()
    try:
        with pytest.raises(SheetsError, match="cannot be read"):
            worker.ask(["rrp_sheets.services.query_worker.course", "/nowhere", "en"], 300)
    finally:
        worker.close()
