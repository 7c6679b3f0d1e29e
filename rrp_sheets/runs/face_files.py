"""Faces that the robot remembers beyond a run: listing and deleting them."""

from __future__ import annotations

from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key
from rrp_sheets.runs.folder import faces_file
from rrp_sheets.sim.face_memory import FaceMemory, read_memory, write_memory


def kept(folder: Path) -> list[str]:
    """Return the names of the persons who are remembered for the workbooks of a folder.

    Raises:
        SheetsError: the file that keeps them is broken.
    """
    return [person.name for person in read_memory(faces_file(folder / "any")).persons]


def forget(folder: Path, name: str) -> str:
    """Delete one remembered person; return the name as it was stored.

    Raises:
        SheetsError: nobody has that name, or the file cannot be read or written.
    """
    memory = read_memory(faces_file(folder / "any"))
    gone = [p for p in memory.persons if key(p.name) == key(name)]
    if not gone:
        names = ", ".join(p.name for p in memory.persons)
        raise SheetsError(
            f"Nobody called “{name}” is remembered.",
            f"Remembered are: {names}." if names else "No faces are kept here.",
        )
    write_memory(faces_file(folder / "any"), FaceMemory([p for p in memory.persons if p not in gone]))
    return gone[0].name


def forget_all(folder: Path) -> str:
    """Delete all remembered faces, also when the file is broken; return in words how many."""
    try:
        count = len(kept(folder))
        words = "1 face is" if count == 1 else f"{count} faces are"
    except SheetsError:
        words = "All faces are"
    write_memory(faces_file(folder / "any"), FaceMemory())
    return words
