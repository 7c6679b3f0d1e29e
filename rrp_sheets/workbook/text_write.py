"""Writing a workbook as a Markdown text, or as a folder of CSV files; reading it back gives the same sheets."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.atomic import write_atomically
from rrp_sheets.workbook.text_books import ORDER, SUFFIXES, csv_delimiter, natural
from rrp_sheets.workbook.text_cells import to_csv, to_markdown

Rows = Sequence[Sequence[str]]
NO_FILE_NAME = re.compile(r"[/\\\x00-\x1f]|^[.~ ]|[. ]$")
"""What keeps a sheet's name from being a file's."""


def markdown_text(sheets: Mapping[str, Rows]) -> str:
    r"""The sheets as Markdown tables, each below its name.

    >>> print(markdown_text({"T": [["From", "To"], ["a|b"]]}))
    ## T
    <BLANKLINE>
    | From | To |
    |------|----|
    | a\|b |    |
    <BLANKLINE>
    """
    return "\n".join(_markdown_table(name, rows) for name, rows in sheets.items())


def _markdown_table(name: str, rows: Rows) -> str:
    rows = rows or [[]]
    width = max(1, *(len(row) for row in rows), 0)
    cells = [[to_markdown(text) for text in row] + [""] * (width - len(row)) for row in rows]
    widths = [min(max(2, *(len(row[c]) for row in cells)), 60) for c in range(width)]
    lines = ["| " + " | ".join(t.ljust(w) for t, w in zip(row, widths, strict=True)) + " |" for row in cells]
    lines.insert(1, "|" + "|".join("-" * (w + 2) for w in widths) + "|")
    heading = " ".join(name.split()) + (" #" if name.rstrip().endswith("#") else "")
    return f"## {heading}\n\n" + "\n".join(lines) + "\n"


def csv_text(rows: Rows, delimiter: str = ",") -> str:
    r"""Rows as CSV; where another delimiter than the comma could be taken for the right one, the first line names it.

    With the tab as delimiter the text is for a .tsv file.

    >>> csv_text([["a", "1,5"], [], ["=b"]])
    'a,"1,5"\n\n\'=b\n'
    """
    body = "".join(delimiter.join(to_csv(text, delimiter) for text in row) + "\n" for row in rows)
    if delimiter == "\t":
        return body
    return body if csv_delimiter(body, "") == "," else "sep=,\n" + body


def write_markdown(sheets: Mapping[str, Rows], path: Path, *, replace: bool = True) -> Path:
    """Write a Markdown file; raises SheetsError when it cannot be written, or there is one and `replace` is False."""
    data = markdown_text(sheets).encode()
    _refuse_large(data)
    write_atomically(path, data, replace=replace)
    return path


def write_csv(sheets: Mapping[str, Rows], folder: Path) -> Path:
    """Write a folder of CSV files, one a sheet, and where needed the file `order.txt` with the order of the sheets.

    Raises:
        SheetsError: when there are CSV files in the folder already, a sheet's name cannot be a file's name, or
            something cannot be written.
    """
    if folder.is_dir() and any(p.suffix.casefold() in SUFFIXES for p in folder.iterdir()):
        raise SheetsError(f"There are CSV files in “{folder.name}” already.", "Name another folder, or empty that one.")
    for name in sheets:
        if NO_FILE_NAME.search(name) or len(name.encode()) > 200:
            raise SheetsError(f"The sheet “{name}” cannot be a file of that name.", "Rename the sheet.")
    # the mark of UTF-8 is for Excel
    files = {f"{name}.csv": csv_text(rows).encode("utf-8-sig") for name, rows in sheets.items()}
    _refuse_large(b"".join(files.values()))
    made = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        why = error.strerror or "the system refuses it"
        raise SheetsError(f"“{folder}” cannot be made: {why}.", "Name another folder.") from error
    if list(sheets) != sorted(sheets, key=natural):
        files[ORDER] = ("\n".join(sheets) + "\n").encode()
    with ExitStack() as undo:  # all files or none: half a workbook would be taken for a whole one
        if made:
            undo.callback(_remove_empty, folder)
        for name, data in files.items():
            write_atomically(folder / name, data, replace=name == ORDER)
            undo.callback((folder / name).unlink, missing_ok=True)
        undo.pop_all()
    return folder


def _remove_empty(folder: Path) -> None:
    with suppress(OSError):
        folder.rmdir()


def _refuse_large(data: bytes) -> None:
    if len(data) > limits.FILE_BYTES:
        raise SheetsError(
            f"As text the workbook has {len(data) / 1e6:.1f} MB; {limits.FILE_BYTES / 1e6:g} MB can be read again.",
            "Take out the sheets that the robot does not need.",
        )
