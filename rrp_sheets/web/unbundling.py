"""A bundle that is uploaded on the shelf: its workbook, what lies beside it, and its runs come into the folder."""

from __future__ import annotations

import shutil
import tempfile
from pathlib import Path

from rrp_sheets import api
from rrp_sheets.devices.scene_pictures import SUFFIXES as PICTURES
from rrp_sheets.devices.sound_files import SUFFIX as SOUND
from rrp_sheets.errors import SheetsError
from rrp_sheets.private import private_folder
from rrp_sheets.runs.bundle import form
from rrp_sheets.runs.bundle.catalogues import catalogue_note
from rrp_sheets.runs.bundle.unpacking import Bundle, unpack
from rrp_sheets.runs.records.listing import runs_place
from rrp_sheets.web.workbook_repository import SUFFIXES
from rrp_sheets.workbook.atomic import write_atomically

_MOST_BYTES = 200_000_000  # unpacked; what is sent may have 8 MB
_OTHER_ROBOT = (
    "The robot's catalogue in it is another one than this program's, which is used here; "
    "`rrp-sheets run` on the bundle itself takes the bundle's."
)


def take_in(folder: Path, name: str, data: bytes) -> tuple[str, str]:
    """Put what is in a bundle into a folder of workbooks: all of it, or nothing.

    Args:
        folder: of the workbooks.
        name: of the bundle, for messages.
        data: its bytes.

    Returns:
        The workbook's name, and what is to be known of the bundle.

    Raises:
        SheetsError: it is no bundle, or there are other files of these names already.
    """
    with tempfile.TemporaryDirectory(prefix="rrp-bundle-") as scratch:
        packed = Path(scratch) / "upload" / name
        packed.parent.mkdir()
        packed.write_bytes(data)
        bundle = unpack(packed, Path(scratch) / "files", _MOST_BYTES)
        book = bundle.workbook
        if not book.is_file() or book.suffix.casefold() not in SUFFIXES or book.name[0] in ".~":
            raise SheetsError("The workbook in this bundle cannot be shown here.", "Use `rrp-sheets run` for it.")
        api.read(book)
        runs_place(folder)  # refuses one that leads elsewhere, before anything is stored
        _move(folder, _new_files(folder, bundle))
        other = catalogue_note(bundle.folder)
        kept = _take_runs(folder, bundle, with_robot=bool(other))
        notes = [note for note in bundle.notes if note not in other]
    return book.name, " ".join([*notes, *([_OTHER_ROBOT] if other else []), *kept])


def _new_files(folder: Path, bundle: Bundle) -> list[Path]:
    """The workbook, and the sounds and pictures beside it, that are not there yet."""
    beside = [p for p in sorted(bundle.folder.iterdir()) if p.suffix.casefold() in (SOUND, *PICTURES) and p.is_file()]
    new = []
    for path in (bundle.workbook, *(p for p in beside if p != bundle.workbook and p.name[0] not in ".~")):
        target = folder / path.name
        if not target.exists():
            new.append(path)
        elif not target.is_file() or target.read_bytes() != path.read_bytes():
            raise SheetsError(f"There is already another file “{path.name}”.", "Rename that one, and upload again.")
    return new


def _move(folder: Path, files: list[Path]) -> None:
    done: list[Path] = []
    try:
        for path in files:
            write_atomically(folder / path.name, path.read_bytes(), replace=False)
            done.append(folder / path.name)
    except (SheetsError, OSError):
        for path in done:
            path.unlink(missing_ok=True)
        raise


def _take_runs(folder: Path, bundle: Bundle, *, with_robot: bool) -> list[str]:
    """Put its runs beside those that are there; what was not taken, in words."""
    notes = []
    for run in bundle.runs:
        target = folder / form.RUNS / run.name
        if target.exists():
            notes.append(f"There is a run “{run.name}” already, which stays as it is.")
            continue
        making = target.with_name(f".{run.name}.part")
        shutil.rmtree(making, ignore_errors=True)
        try:
            private_folder(making)
            run.chmod(0o700)  # which the copy takes over
            shutil.copytree(
                run, making, dirs_exist_ok=True, ignore=None if with_robot else shutil.ignore_patterns(form.ROBOTS)
            )
            making.rename(target)
        except OSError as error:  # no room, or another upload was quicker
            shutil.rmtree(making, ignore_errors=True)
            notes.append(f"The run “{run.name}” could not be stored ({error.strerror or 'is there room for it?'}).")
    return notes
