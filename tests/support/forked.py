"""Commands of the program, each a process of its own, forked from one that has imported the program.

Most of a short command is the start of its interpreter. A forked one is a real process nevertheless, a child of the
tests' with its own arguments, environment, folder, files and signals, and ends as an interpreter does; so are the
workers that it starts. What is about the start itself is started: `subprocess` does that; so is what the order of a set
could change, as all forked ones have the hash seed of that one process.
"""

from __future__ import annotations

import atexit
import ctypes
import functools
import gc
import importlib
import json
import os
import signal
import socket
import subprocess
import sys
import tempfile
import threading
import weakref
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

if TYPE_CHECKING:
    from rrp_sheets.workers.worker_process import Task

PROGRAM = "from rrp_sheets.cli.main import main; main()"
COMMAND = [sys.executable, "-c", PROGRAM]
SUBREAPER = 36  # of prctl: who becomes the parent of a process whose own has ended
MOST = 1 << 20  # bytes of a request
FORK_WITHIN = 300.0  # s, the imports of the fork server included
MODULES = (
    *(f"rrp_sheets.cli.{name}" for name in ("check", "files", "formula", "help", "recordings", "run", "serve", "show")),
    "rrp_sheets.api", "rrp_sheets.runs.run_process", "rrp_sheets.web.app", "rrp_sheets.web.serving",
    "rrp_sheets.workers.__main__", "rrp_sheets.replay.output", "rrp_sheets.services.printing", "openpyxl",
)  # fmt: skip


class Forked(subprocess.Popen[Any]):
    """A process with the arguments `python -c CODE …`, or of a worker, that is forked."""

    def _execute_child(
        self, args: Any, executable: Any, preexec_fn: Any, close_fds: Any, pass_fds: Sequence[int], cwd: Any, env: Any,
        _info: Any, _flags: Any, _shell: Any, p2cread: int, p2cwrite: int, c2pread: int, c2pwrite: int, errread: int,
        errwrite: int, _signals: Any, _gid: Any, _gids: Any, _uid: Any, _umask: Any, new_session: bool, group: int,
    ) -> None:  # fmt: skip
        files = [own if given < 0 else given for own, given in enumerate((p2cread, c2pwrite, errwrite))]
        request = {
            "arguments": [os.fsdecode(a) for a in args[1:]], "environment": dict(os.environ if env is None else env),
            "folder": os.fsdecode(cwd or "."), "session": new_session, "group": group,
            "cores": sorted(os.sched_getaffinity(0)),
        }  # fmt: skip
        self.pid = self._fork(request, [*files, *pass_fds])
        self._child_created = True
        self._close_pipe_fds(p2cread, p2cwrite, c2pread, c2pwrite, errread, errwrite)  # type: ignore[attr-defined]

    def _fork(self, request: dict[str, Any], files: Sequence[int]) -> int:
        return fork_server().fork({**request, "folder": os.path.abspath(request["folder"])}, files)


class Worker(Forked):
    """A worker of a forked program."""

    def _fork(self, request: dict[str, Any], files: Sequence[int]) -> int:
        if pid := os.fork():
            return pid
        try:
            for left in list(weakref.finalize._registry):  # type: ignore[attr-defined]
                left.atexit = False  # temporary folders are the starter's
            _become(request, files)()
        except BaseException:
            sys.excepthook(*sys.exc_info())  # type: ignore[arg-type]
            sys.stderr.flush()
        finally:
            os._exit(1)


def run(command: Sequence[Any], *, timeout: float = 120, check: bool = False, **options: Any) -> Any:
    """Do what `subprocess.run` does, in a forked process."""
    if options.pop("capture_output", False):
        options |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    with Forked(list(command), **options) as process:
        try:
            output, errors = process.communicate(timeout=timeout)
        except BaseException:
            process.kill()
            raise
    done = subprocess.CompletedProcess(command, process.returncode, output, errors)
    if check:
        done.check_returncode()
    return done


class ForkServer:
    """The process with everything imported."""

    def __init__(self) -> None:
        self._link, theirs = socket.socketpair(socket.AF_UNIX, socket.SOCK_SEQPACKET)
        self._link.settimeout(FORK_WITHIN)
        self._lock = threading.Lock()
        self._prctl = ctypes.CDLL(None).prctl
        place = str(Path(__file__).parent)
        code = f"import sys; sys.path.insert(0, {place!r}); import forked; del sys.path[0]; forked.serve()()"
        with theirs:
            command = [sys.executable, "-c", code, str(theirs.fileno())]
            self._process = subprocess.Popen(command, pass_fds=[theirs.fileno()], stdin=subprocess.DEVNULL)

    def fork(self, request: dict[str, Any], files: Sequence[int]) -> int:
        """Fork a process that is a child of this one; raises OSError when it cannot, and the next has a new server."""
        with self._lock:
            self._prctl(SUBREAPER, 1)
            try:
                socket.send_fds(self._link, [json.dumps(request).encode()], files)
                if pid := self._link.recv(32):
                    return int(pid)
                raise ChildProcessError("the tests' fork server has ended, or could not fork")
            except OSError:
                fork_server.cache_clear()
                self._process.kill()
                self.close()
                raise
            finally:
                self._prctl(SUBREAPER, 0)

    def close(self) -> None:
        """End it; what it has forked goes on."""
        self._link.close()
        self._process.wait()


@functools.cache
def fork_server() -> ForkServer:
    """The process of these tests."""
    found = ForkServer()
    atexit.register(found.close)
    return found


# ---- in the process with everything imported, and in those that are forked from it
def serve() -> Callable[[], object]:
    """Fork until the connection closes; return what this process, which may be a forked one, then is to do."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C is for the program
    os.sched_setaffinity(0, range(os.cpu_count() or 1))  # whoever was first may have kept to one core
    from rrp_sheets.web.services import WORKER_MODULES
    from rrp_sheets.workers import worker_process

    for module in (*WORKER_MODULES, *MODULES):
        importlib.import_module(module)
    worker_process._start_process = functools.partial(start_worker, Worker)
    gc.freeze()
    link = socket.socket(fileno=int(sys.argv[1]))
    while True:
        request, files, _, _ = socket.recv_fds(link, MOST, 16)
        if not request:
            return lambda: None
        told, telling = os.pipe()
        if not (between := os.fork()):
            if pid := os.fork():
                os.write(telling, str(pid).encode())
                os._exit(0)
            link.detach()
            return _become(json.loads(request), files)
        os.waitpid(between, 0)  # from now on the tests' process is the parent
        os.close(telling)  # else a fork that has failed would be waited for
        link.send(os.read(told, 32))
        for file in (told, *files):
            os.close(file)


def start_worker(
    kind: type[Forked], task: Task, environment: dict[str, str], log: IO[bytes], files: Sequence[int]
) -> Forked:
    """Fork a worker process where the program would start one."""
    return kind(
        [sys.executable, "-P", "-m", "rrp_sheets.workers", task.name, json.dumps(task.limits), *map(str, files)],
        pass_fds=files, env=environment, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=log,
        process_group=0,
    )  # fmt: skip


def _become(request: Mapping[str, Any], files: Sequence[int]) -> Callable[[], object]:
    """Make this process what was asked for; return what it is to do."""
    standard, shared = files[:3], files[3:]
    for own, file in enumerate([os.dup(file) for file in standard]):
        os.dup2(file, own)
    last = 2
    for number in (*sorted(shared), os.sysconf("SC_OPEN_MAX")):
        os.closerange(last + 1, number)
        last = number
    if request["session"]:
        os.setsid()
    if request["group"] >= 0:
        os.setpgid(0, request["group"])
    os.sched_setaffinity(0, request["cores"])
    os.chdir(request["folder"])
    before, after = dict(os.environ), request["environment"]
    os.environ.clear()
    os.environ.update(after)
    for path in reversed(after.get("PYTHONPATH", "").split(os.pathsep)):
        if path and path not in before.get("PYTHONPATH", "").split(os.pathsep):
            sys.path.insert(1, path)
    tempfile.tempdir = None
    signal.signal(signal.SIGINT, signal.default_int_handler)
    encoding, _, errors = after.get("PYTHONIOENCODING", "").partition(":")
    for name, number, mode, how in (
        ("stdin", 0, "r", "strict"), ("stdout", 1, "w", "strict"), ("stderr", 2, "w", "backslashreplace"),
    ):  # fmt: skip
        stream: Any = open(number, mode, encoding=encoding or None, errors=errors or how, closefd=False)  # noqa: SIM115
        if name == "stderr":
            stream.reconfigure(line_buffering=True)
        setattr(sys, name, stream)
        setattr(sys, f"__{name}__", stream)
    if request["arguments"][0] == "-c":
        _, code, *arguments = request["arguments"]
        sys.argv = ["-c", *arguments]
        return functools.partial(_end_after, functools.partial(exec, code, {"__name__": "__main__"}))
    from rrp_sheets.workers.worker_loop import do_task

    _, _, _, task, limits, *_ = request["arguments"]
    return functools.partial(_end_after, functools.partial(do_task, task, json.loads(limits), *shared))


def _end_after(work: Callable[[], object]) -> None:
    """Work, and end as an interpreter does, but without taking down what is imported: that takes longer than most work."""
    code: Any = None
    try:
        work()
    except SystemExit as end:
        code = end.code
        if not isinstance(code, int | None):
            raise
    threading._shutdown()  # type: ignore[attr-defined]
    atexit._run_exitfuncs()
    with suppress(OSError, ValueError):
        sys.stdout.flush()
        sys.stderr.flush()
        os._exit(code or 0)
    sys.exit(code)  # the interpreter tells that it could not write


if sys.platform != "linux":  # elsewhere nobody can adopt a process
    Forked, run = subprocess.Popen, subprocess.run  # type: ignore[misc]
