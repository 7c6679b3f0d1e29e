"""The text that lies on top of a bundle, for whoever opens the zip without knowing what it is."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rrp_sheets.runs.bundle import form

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
    """The text.

    Args:
        workbook: its name in the bundle.
        told: what the list says.
        has_paper: whether the printed protocol is in it.
    """
    entries = [(workbook, "the workbook: what the robot does, and when")]
    if has_paper:
        entries.append((form.PAPER, "the same as a document for an ethics board"))
    entries.append((f"{form.ROBOTS}/", "the robot's catalogue: its devices, its joints, its shape"))
    runs = told["runs"]
    if runs:
        count = f"{len(runs)} recorded run{'s' if len(runs) > 1 else ''}"
        entries.append((f"{form.RUNS}/", f"{count}: every event, pictures and sounds"))
    entries.append((form.LIST, f"made with RRP Sheets {told['program']}, Python {told['python']}; all other versions"))
    wide = min(30, max(len(name) for name, _ in entries))
    title = str(told["title"] or workbook)
    return _TEXT.format(
        title=f"{title}\n{'=' * min(len(title), 78)}",
        files="\n  ".join(f"{name:<{wide}}  {what}" for name, what in entries),
        paper=f", {form.PAPER} in any viewer" if has_paper else "",
        program=told["program"], replay=_REPLAY if runs else "", list=form.LIST,
    )  # fmt: skip
