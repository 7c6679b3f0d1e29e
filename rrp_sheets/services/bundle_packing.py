"""Packing a workbook with its files, its printed protocol, its runs and a readme as a bundle."""

from __future__ import annotations

import hashlib
import json
import os
import zipfile
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from io import BytesIO
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any

from rrp_sheets.checks import Checked, check_workbook
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.run_files import RUNS, TRACE
from rrp_sheets.recording.folder import material
from rrp_sheets.robots.own_robot import files_of
from rrp_sheets.services import bundles
from rrp_sheets.services.bundles import is_safe, manifest
from rrp_sheets.services.printing import HasErrors, make
from rrp_sheets.services.query_worker import QueryWorker
from rrp_sheets.texts import N_, os_reason, sentences
from rrp_sheets.workbook import Reading, read
from rrp_sheets.workbook.files import refuse_open_file
from rrp_sheets.workbook.text_books import ORDER, SUFFIXES
from rrp_sheets.workbook.xlsx import BROKEN_ZIP

_FIXED = (1980, 1, 1, 0, 0, 0)  # the same bytes whenever it is packed; a zip knows no earlier time
_MODE = 0o100644 << 16
_PIECE = 1 << 20
_PACKED_WITHIN = 90.0  # s; the tests of the workbook may take 20
_DRAFT = N_("The workbook has errors: protocol.pdf is marked as a draft.")
Content = Path | bytes
Printer = Callable[[Path], tuple[bytes, Sequence[str]]]
"""Prints a workbook's protocol: its path in, the PDF out, and what that lacks, in words."""


@dataclass(frozen=True)
class Packed:
    """A bundle that was made: its zip, the sizes in bytes of the files in it by name, and the workbook's language.

    `notes` tell what it lacks, or what to think of before it is passed on.
    """

    path: Path
    files: Mapping[str, int]
    notes: tuple[str, ...]
    language: str


def pack(path: Path, target: Path | None = None, runs: Sequence[str] = (), printer: Printer | None = None) -> Packed:
    """Make a bundle of a workbook; see `api.pack`. Without a printer the protocol is left out.

    Raises:
        UnreadableFile: when the workbook cannot be read.
        SheetsError: when there is no such run, a file's name is not valid on every system, or nothing can be written.
    """
    _refuse_bundle(path)
    reading = read(path)
    checked = check_workbook(reading.workbook, reading.report)
    target = target or Path(f"{path.absolute().stem if path.is_file() else path.absolute().name}{bundles.SUFFIX}")
    _refuse_target(target, path)
    notes: list[str] = []
    content = _workbook(path, reading)
    name = next(iter(content)) if path.is_file() else path.absolute().name
    home = "" if path.is_file() else f"{name}/"
    content |= _beside(checked, home, notes)
    folders = _run_folders(path, runs)
    for folder in folders:
        content |= _run(folder, notes)
    _refuse_names(content)
    if count := len(checked.report.errors):
        one = N_("The workbook has {n} error; it cannot run before it is fixed.")
        more = N_("The workbook has {n} errors; it cannot run before they are fixed.")
        notes.append(N_(more if count > 1 else one, n=count))
    if printer is not None:
        try:
            content[bundles.PROTOCOL_FILE], lacks = printer(path)
            notes += lacks
        except UnreadableFile:  # the approved version: whoever named it wants to see what changed
            raise
        except SheetsError as error:
            why = sentences(error.message, error.remedy)
            notes.append(N_("{file} is not in it: {why}", file=bundles.PROTOCOL_FILE, why=why))
    told = manifest(name, reading, checked, folders)
    content[bundles.README] = readme(name, told, bundles.PROTOCOL_FILE in content).encode()
    files = _write(target, content, told)
    return Packed(target, files, tuple(notes), checked.run.language)


def pack_with_protocol(
    path: Path, target: Path | None, runs: Sequence[str], against: Path | None, today: date | None
) -> Packed:
    """Make a bundle with the printed protocol in it; see `api.pack`."""

    def printed(book: Path) -> tuple[bytes, Sequence[str]]:
        try:
            found = make(book, against=against, today=today)
            return found.data, found.notes
        except HasErrors:
            found = make(book, against=against, today=today, draft=True)
            return found.data, [*found.notes, _DRAFT]

    return pack(path, target, runs, printed)


class Packer(QueryWorker):
    """Query worker that packs bundles; usable from any thread, one request at a time."""

    def __init__(self) -> None:
        super().__init__(_PACKED_WITHIN, __name__)

    def pack(self, path: Path, runs: list[Path], target: Path) -> None:
        """Create a bundle of a workbook and the runs in those folders.

        Raises:
            SheetsError: it cannot be made, or not in time.
        """
        self.ask(path.name, "pack_apart", str(path), [str(run) for run in runs], str(target))


def pack_apart(path: str, runs: Sequence[str], target: str) -> None:
    """Make a bundle in a worker process."""
    pack_with_protocol(Path(path), Path(target), runs, None, None)


def _refuse_bundle(path: Path) -> None:
    """Raise SheetsError when the file is a bundle already, which can be passed on as it is."""
    if path.suffix.casefold() != bundles.SUFFIX or not path.is_file():
        return
    with suppress(*BROKEN_ZIP), zipfile.ZipFile(path) as packed:
        if bundles.VERSIONS_FILE in packed.namelist():
            remedy = N_("Run it with: rrp-sheets run {name}. To change it, unpack it, and pack the workbook in it "
                        "again.")  # fmt: skip
            message = N_("“{name}” is a bundle already: it can be passed on as it is.", name=path.name)
            raise SheetsError(message, N_(remedy, name=path.name))


def _refuse_target(target: Path, path: Path) -> None:
    if target.suffix.casefold() != bundles.SUFFIX:
        message = N_("A bundle's name ends with {suffix}, not “{other}”.", suffix=bundles.SUFFIX, other=target.suffix)
        raise SheetsError(message, N_("Name it so with -o."))
    if target.is_dir() or (target.exists() and path.exists() and target.samefile(path)):
        raise SheetsError(N_("“{path}” cannot be the bundle.", path=target), N_("Name another file with -o."))
    if not target.absolute().parent.is_dir():
        words = N_("“{path}” cannot be written: there is no folder “{folder}”.")
        raise SheetsError(N_(words, path=target, folder=target.parent), N_("Make it first."))
    refuse_open_file(target)


def _workbook(path: Path, reading: Reading) -> dict[str, Content]:
    """Return the files of the workbook byte for byte; refuse an .xlsx that has changed since it was read."""
    if path.is_file():
        data = path.read_bytes()
        if reading.format == "xlsx" and hashlib.sha256(data).hexdigest() != reading.digest:
            raise SheetsError(N_("“{name}” was changed just now.", name=path.name), N_("Pack it again."))
        return {path.name: data}
    files = sorted(p for p in path.iterdir() if p.is_file() and (p.suffix.casefold() in SUFFIXES or p.name == ORDER))
    return {f"{path.absolute().name}/{p.name}": p.read_bytes() for p in files}


def _beside(checked: Checked, home: str, notes: list[str]) -> dict[str, Content]:
    """Return the robot's catalogue, and the sounds and pictures that the workbook names."""
    robot = checked.robot
    content: dict[str, Content] = {f"{home}{bundles.ROBOTS}/{robot.name}/{p.name}": p for p in files_of(robot)}
    found, lacks = material(checked)
    content |= {f"{home}{name}": place for name, place in found.items()}
    notes += lacks
    return content


def _run_folders(path: Path, runs: Sequence[str]) -> list[Path]:
    folders = list(dict.fromkeys(_run_folder(path, run) for run in runs))
    if len({f.name.casefold() for f in folders}) < len(folders):
        raise SheetsError(
            N_("Two of the runs' folders have the same name."), N_("Rename one of them, or make two bundles.")
        )
    return folders


def _refuse_names(content: Mapping[str, Content]) -> None:
    """Raise SheetsError when the bundle could not be unpacked on another system."""
    for name in content:
        if not is_safe(name):
            message = N_("“{name}” is not a valid name on every system.", name=name[:100])
            raise SheetsError(message, N_('Rename that file: shorter, and without \\ : * ? " < > |.'))
    if len({name.casefold() for name in content}) < len(content):
        raise SheetsError(N_("Two files have names that only differ in capital letters."), N_("Rename one of them."))


def _run_folder(path: Path, run: str) -> Path:
    beside = path.absolute().parent / RUNS
    for folder in (Path(run), beside / run) if run not in ("", ".", "..") else ():
        if (folder / TRACE).is_file():
            return folder.resolve()
    names: list[str] = []
    with suppress(OSError):
        names = sorted(p.name for p in beside.iterdir() if (p / TRACE).is_file())
    here = N_("The runs of this folder: {names}.", names=", ".join(names[-5:]))
    raise SheetsError(N_("There is no run “{run}”.", run=run), here if names else N_("Run the workbook first."))


def _run(folder: Path, notes: list[str]) -> dict[str, Content]:
    content: dict[str, Content] = {}
    for path in sorted((*folder.iterdir(), *folder.glob(f"{bundles.ROBOTS}/*/*"))):
        if path.is_file() and not path.is_symlink():
            content[f"{RUNS}/{folder.name}/{path.relative_to(folder).as_posix()}"] = path
        elif path != folder / bundles.ROBOTS:
            words = N_("“{file}” of the run {run} is not included: it is not a file of that folder.")
            notes.append(N_(words, file=path.name, run=folder.name))
    return content


def _write(target: Path, content: Mapping[str, Content], told: Mapping[str, object]) -> dict[str, int]:
    """Write the zip, whole or not at all, with its files in the order of their names; return their sizes."""
    files: dict[str, dict[str, Any]] = {}
    folder, made = target.absolute().parent, ""
    mask = os.umask(0)  # it cannot be read in another way
    os.umask(mask)
    try:
        with NamedTemporaryFile(dir=folder, prefix=f".{target.stem[:40]}-", suffix=".tmp", delete=False) as file:
            made = file.name
            with zipfile.ZipFile(file, "w", zipfile.ZIP_DEFLATED, compresslevel=6, strict_timestamps=False) as archive:
                for name in sorted(content, key=lambda n: (n != bundles.README, n)):
                    files[name] = _add(archive, name, content[name])
                everything = {**told, "files": dict(sorted(files.items()))}
                text = json.dumps(everything, ensure_ascii=False, indent=1) + "\n"
                files[bundles.VERSIONS_FILE] = _add(archive, bundles.VERSIONS_FILE, text.encode())
            file.flush()
            os.fsync(file.fileno())
        os.chmod(made, 0o666 & ~mask)
        os.replace(made, target)
    except OSError as error:
        raise _unwritable(target, error) from None
    finally:
        with suppress(OSError):
            os.unlink(made)
    return {name: about["bytes"] for name, about in files.items()}


def _unwritable(target: Path, error: OSError) -> SheetsError:
    words = N_("“{path}” cannot be written: {reason}.")
    if error.filename and Path(str(error.filename)).name != target.name:
        words = N_("“{path}” cannot be written: {reason} ({file}).")
    message = N_(words, path=target, reason=os_reason(error), file=error.filename)
    return SheetsError(message, N_("Make room, or name another file with -o."))


def _add(archive: zipfile.ZipFile, name: str, content: Content) -> dict[str, Any]:
    """Add a file to the zip; return hash and size of the bytes that were written."""
    info = zipfile.ZipInfo(name, _FIXED)
    info.compress_type, info.external_attr, info.create_system = zipfile.ZIP_DEFLATED, _MODE, 3
    total, size = hashlib.sha256(), 0
    source = content.open("rb") if isinstance(content, Path) else BytesIO(content)
    with source, archive.open(info, "w", force_zip64=False) as into:
        while piece := source.read(_PIECE):
            into.write(piece)
            total.update(piece)
            size += len(piece)
    return {"sha256": total.hexdigest(), "bytes": size}


_TEXT = """\
{title}

This zip is a bundle of RRP Sheets, a program with which a robot's behaviour is
written as rows of a spreadsheet. Everything is in it that is needed to look at
this workbook, to run it again, and to compare.

What is in it
  {files}

To look at it, nothing else is needed: the workbook opens in Excel or LibreOffice{paper}.

To run it on the simulated robot, with RRP Sheets {program} installed, type where
this zip is (BUNDLE.zip stands for its name):

  rrp-sheets run BUNDLE.zip
{replay}
The zip need not be unpacked for that. Unpacked it is a folder to work in.
Every file's SHA-256 is in {list}: one that was changed is told when it runs.
"""
_REPLAY = """
To let the recorded sessions happen again from what their sensors gave, without
the simulator, and compare every event:

  rrp-sheets replay BUNDLE.zip
"""


def readme(workbook: str, told: Mapping[str, Any], has_paper: bool) -> str:
    """Return the text of the file that explains the bundle; `told` is the content of its list of versions."""
    entries = [(workbook, "the workbook: what the robot does, and when")]
    if has_paper:
        entries.append((bundles.PROTOCOL_FILE, "the same as a document for an ethics board"))
    entries.append((f"{bundles.ROBOTS}/", "the robot's catalogue: its devices, its joints, its shape"))
    runs = told["runs"]
    if runs:
        count = f"{len(runs)} recorded run{'s' if len(runs) > 1 else ''}"
        entries.append((f"{RUNS}/", f"{count}: every event, pictures and sounds"))
    entries.append(
        (bundles.VERSIONS_FILE, f"made with RRP Sheets {told['program']}, Python {told['python']}; all other versions")
    )
    wide = min(30, max(len(name) for name, _ in entries))
    title = str(told["title"] or workbook)
    return _TEXT.format(
        title=f"{title}\n{'=' * min(len(title), 78)}",
        files="\n  ".join(f"{name:<{wide}}  {what}" for name, what in entries),
        paper=f", {bundles.PROTOCOL_FILE} in any viewer" if has_paper else "",
        program=told["program"], replay=_REPLAY if runs else "", list=bundles.VERSIONS_FILE,
    )  # fmt: skip
