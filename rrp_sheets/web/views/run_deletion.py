"""Deletion of runs: shows what would be deleted and what stays, asks for a typed confirmation, and deletes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, ClassVar

from flask import Blueprint, request

from rrp_sheets.errors import SheetsError
from rrp_sheets.web.models import show
from rrp_sheets.web.runs.run_store import RunLine, RunStore, line_of
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import printable

blueprint = Blueprint("run_deletion", __name__)

_MOST_RUNS = 500  # that are chosen one by one
_MOST_NAMED = 40
_LONGEST = 300  # letters of a participant's code
_MEGA = 1e6


@dataclass(frozen=True, slots=True)
class BelowLine:
    """Runs of the same participant in a subfolder; `folder` is its name relative to this folder.

    Attributes:
        words: their number, workbooks and dates.
        wiped: the remembered faces that would go with them.
        ticked: whether they are to be deleted too.
    """

    folder: str
    words: str
    wiped: tuple[str, ...]
    ticked: bool


@dataclass(frozen=True, slots=True)
class DeletePage:
    """Page of runs that would be deleted, or were.

    Attributes:
        participant: whose runs; blank when they were chosen one by one.
        word: what has to be typed to confirm.
        lines: the runs.
        shown: identifiers of the runs that the page shows, to be sent back with the confirmation.
        what: the number of files, pictures and sounds, in words.
        wiped: faces that are wiped.
        stays: what stays, in sentences.
        below: the runs of that participant in folders below.
        done: it was deleted.
        notice: an error, or the result.
    """

    template: ClassVar[str] = "rundelete.html"
    longest: ClassVar[int] = _LONGEST
    participant: str
    word: str
    lines: tuple[RunLine, ...] = ()
    shown: tuple[str, ...] = ()
    what: str = ""
    wiped: tuple[str, ...] = ()
    stays: tuple[str, ...] = ()
    below: tuple[BelowLine, ...] = ()
    done: bool = False
    notice: str = ""
    failed: bool = False


@blueprint.get("/runs/delete")
def ask() -> str:
    """Show what would be deleted and what stays, and ask for the confirmation."""
    return show(_asked_page(*_asked(request.args.get("participant"))))


@blueprint.post("/runs/delete/now")
def delete() -> str:
    """Delete runs, and show what was deleted."""
    participant, names = _asked(request.form.get("participant"))
    try:
        return show(_deleted_page(participant, names))
    except SheetsError as error:  # told where it was asked for
        return show(DeletePage(participant, "", notice=str(error), failed=True))


def _asked(participant: str | None) -> tuple[str, list[str]]:
    return (participant or "")[:_LONGEST], request.values.getlist("run")[:_MOST_RUNS]


def _asked_page(participant: str, names: list[str], notice: str = "") -> DeletePage:
    """Build the confirmation page; raises SheetsError when there are no such runs, or one is going."""
    runs = services().runs
    answer = services().exporter.ask("This folder", "plan_deletion", str(runs.folder), participant, names, _busy(runs))
    return _page(participant, answer, notice, failed=bool(notice))


def _deleted_page(participant: str, names: list[str]) -> DeletePage:
    """Delete the runs, if the confirmation was typed and nothing has changed since the page was shown."""
    typed, expected = request.form.get("typed", "").strip(), request.form.getlist("shown")
    below = request.form.getlist("below")
    if typed != (participant or "delete"):
        what = f"The code {participant}" if participant else "The word “delete”"
        return _asked_page(participant, names, f"{what} was not typed; nothing was deleted.")
    # what it was is told from what is there now: afterwards there is nothing to tell it from
    runs = services().runs
    folder = str(runs.folder)
    answer = services().exporter.ask(
        "This folder", "delete_planned", folder, participant, names, _busy(runs), expected, below
    )
    if not answer["deleted"]:
        notice = "Meanwhile there are other runs than were shown; nothing was deleted. Look again."
        return _page(participant, answer, notice, failed=True)
    runs.forget({str(run["run"]) for run in answer["runs"]})
    count = len(answer["runs"]) + sum(len(d["runs"]) for d in answer.get("below", ()) if d["folder"] in below)
    notice = f"{count} run{'' if count == 1 else 's'} deleted{f' of {participant}' if participant else ''}."
    if answer["begun"]:
        named = ", ".join(printable(str(n)) for n in answer["begun"][:_MOST_NAMED])
        notice += f" Meanwhile there is another one, which stays: {named}. Delete again when it has ended."
    return _page(participant, answer, notice, failed=bool(answer["begun"]))


def _busy(runs: RunStore) -> list[str]:
    return [*runs.going(), *runs.writing()]


def _page(participant: str, answer: Mapping[str, Any], notice: str, *, failed: bool) -> DeletePage:
    books = set(services().repository.names())
    done = bool(answer.get("deleted"))
    names = [str(run["run"]) for run in answer["runs"]]
    below = answer.get("below", ())
    ticked = request.form.getlist("below")
    gone = [answer, *(d for d in below if d["folder"] in ticked)] if done else [answer]
    return DeletePage(
        participant=participant, word=participant or "delete",
        lines=() if done else tuple(line_of(f, books) for f in services().runs.facts(names)),
        shown=(*names, *(f"{d['folder']}/{run['run']}" for d in below for run in d["runs"])), what=_what(gone),
        wiped=tuple(name for d in gone for name in d["faces_wiped"]),
        stays=tuple(_stays(participant, answer, [d for d in below if done and d not in gone])),
        below=() if done else tuple(_below(d, d["folder"] in ticked) for d in below),
        done=done, notice=notice, failed=failed,
    )  # fmt: skip


def _what(answer: list[Mapping[str, Any]]) -> str:
    files, size, pictures, sounds = (sum(d[n] for d in answer) for n in ("files", "bytes", "pictures", "sounds"))
    return (
        f"{files:,} {'file' if files == 1 else 'files'} ({size / _MEGA:,.1f} MB), "
        f"of which {pictures:,} hold pictures or films and {sounds:,} speech or sounds"
    )


def _below(answer: Mapping[str, Any], ticked: bool) -> BelowLine:
    runs = answer["runs"]
    days = sorted({day for run in runs if (day := _day(str(run["began"])))})
    when = "" if not days else f", {_written(days[0])}"
    if len(days) > 1:
        when = f", from {_written(days[0])} to {_written(days[-1])}"
    books = sorted({str(run["workbook"]) for run in runs if run["workbook"]})
    shown = f" of {', '.join(books[:3])}{' and others' if len(books) > 3 else ''}" if books else ""
    words = f"{len(runs):,} {'run' if len(runs) == 1 else 'runs'}{shown}{when}"
    return BelowLine(str(answer["folder"]), words, tuple(answer["faces_wiped"]), ticked)


def _day(began: str) -> date | None:
    try:
        return datetime.fromisoformat(began).date()
    except ValueError:
        return None


def _dated(unsearched: Mapping[str, Any]) -> str:
    day = _day(str(unsearched["date"] or ""))
    return printable(str(unsearched["file"])) + (f", {_written(day)}" if day else "")


def _written(day: date) -> str:
    return f"{day.day} {day:%B %Y}"


def _stays(participant: str, answer: Mapping[str, Any], below: list[Mapping[str, Any]]) -> list[str]:
    said = [f"The runs of {participant} in “{printable(str(d['folder']))}”." for d in below]
    said += [f"The remembered face “{f['name']}”: {f['why']}" for f in answer["faces_kept"]]
    if answer["faces_kept"]:
        said.append("Is one of these faces theirs? Wipe it with: rrp-sheets faces --forget NAME")
    if answer["faces_unreadable"]:
        said.append(str(answer["faces_unreadable"]))
    said += [f"The runs of “{code}”, which is spelled nearly the same." for code in answer["similar_codes"]]
    if answer["unreadable_runs"]:
        said.append("Runs whose record cannot be read, so that nobody knows whose they are: "
                    + ", ".join(printable(str(n)) for n in answer["unreadable_runs"][:12]))  # fmt: skip
    said += [f"“{participant}” in {place}" for place in answer["code_still_in"][:_MOST_NAMED]]
    left = len(answer["code_still_in"]) - _MOST_NAMED
    if left > 0:
        said.append(f"“{participant}” in {left:,} more files; `rrp-sheets runs delete` names them.")
    unsearched = answer["not_searched"]
    if unsearched:
        said.append(f"These files were not searched for “{participant}”. Open them and look yourself:")
        said += [_dated(u) for u in unsearched[:_MOST_NAMED]]
        if len(unsearched) > _MOST_NAMED:
            said.append(f"{len(unsearched) - _MOST_NAMED:,} more files that were not searched; "
                        "`rrp-sheets runs delete --json` names them.")  # fmt: skip
    elif not answer["looked_through_everything"]:
        said.append("The folder has too many files to search all of them.")
    return [*said, "Copies elsewhere: a backup, an export that was mailed, a bundle."]
