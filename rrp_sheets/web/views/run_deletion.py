"""Deletion of runs: shows what would be deleted and what stays, asks for a typed confirmation, and deletes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, ClassVar

from flask import Blueprint, request

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.web.models import date_in_words, plural, said, show
from rrp_sheets.web.run_store import RunLine, RunStore, line_of
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import printable

blueprint = Blueprint("run_deletion", __name__)

_MOST_RUNS = 500  # that are chosen one by one
_MOST_NAMED = 40
_LONGEST = 300  # letters of a participant's code
_MEGA = 1e6
_FOLDER = N_("This folder")


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
        shown: identifiers of the runs that the page shows, to be sent back with the confirmation.
        what: the number of files, pictures and sounds, in words.
        stays: what stays, in sentences.
        below: the runs of that participant in folders below.
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
        return show(DeletePage(participant, "", notice=said(error), failed=True))


def _asked(participant: str | None) -> tuple[str, list[str]]:
    return (participant or "")[:_LONGEST], request.values.getlist("run")[:_MOST_RUNS]


def _asked_page(participant: str, names: list[str], notice: str = "") -> DeletePage:
    """Build the confirmation page; raises SheetsError when there are no such runs, or one is going."""
    runs = services().runs
    answer = services().exporter.ask(_FOLDER, "plan_deletion", str(runs.folder), participant, names, _busy(runs))
    return _page(participant, answer, notice, failed=bool(notice))


def _deleted_page(participant: str, names: list[str]) -> DeletePage:
    """Delete the runs, if the confirmation was typed and nothing has changed since the page was shown."""
    typed, expected = request.form.get("typed", "").strip(), request.form.getlist("shown")
    below = request.form.getlist("below")
    if typed != (participant or "delete"):
        notice: str = N_(
            "The code {code} was not typed; nothing was deleted."
            if participant
            else "The word “delete” was not typed; nothing was deleted.",
            code=participant,
        )
        return _asked_page(participant, names, notice)
    # what it was is told from what is there now: afterwards there is nothing to tell it from
    runs = services().runs
    folder = str(runs.folder)
    answer = services().exporter.ask(
        _FOLDER, "delete_planned", folder, participant, names, _busy(runs), expected, below
    )
    if not answer["deleted"]:
        notice = N_("Meanwhile there are other runs than were shown; nothing was deleted. Look again.")
        return _page(participant, answer, notice, failed=True)
    runs.forget({str(run["run"]) for run in answer["runs"]})
    count = len(answer["runs"]) + sum(len(d["runs"]) for d in answer.get("below", ()) if d["folder"] in below)
    if participant:
        notice = N_(
            "{n} run deleted of {code}." if count == 1 else "{n} runs deleted of {code}.", n=count, code=participant
        )
    else:
        notice = N_("{n} run deleted." if count == 1 else "{n} runs deleted.", n=count)
    if answer["begun"]:
        more = N_(
            "Meanwhile there is another one, which stays: {runs}. Delete again when it has ended.",
            runs=listed([printable(str(n)) for n in answer["begun"][:_MOST_NAMED]]),
        )
        notice = sentences(notice, more)
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
    return N_(
        "{n:,} file ({size} MB), of which {pictures:,} hold pictures or films and {sounds:,} speech or sounds"
        if files == 1
        else "{n:,} files ({size} MB), of which {pictures:,} hold pictures or films and {sounds:,} speech or sounds",
        n=files,
        size=f"{size / _MEGA:,.1f}",
        pictures=pictures,
        sounds=sounds,
    )


def _below(answer: Mapping[str, Any], ticked: bool) -> BelowLine:
    runs = answer["runs"]
    days = sorted({day for run in runs if (day := _day(str(run["began"])))})
    when = [date_in_words(day) for day in days[:1]]
    if len(days) > 1:
        when = [N_("from {first} to {last}", first=date_in_words(days[0]), last=date_in_words(days[-1]))]
    books = sorted({str(run["workbook"]) for run in runs if run["workbook"]})
    words = plural(len(runs), "run")
    if books:
        words = N_(
            "{runs} of {books} and others" if len(books) > 3 else "{runs} of {books}",
            runs=words,
            books=listed(books[:3]),
        )
    words = listed([words, *when])
    return BelowLine(str(answer["folder"]), words, tuple(answer["faces_wiped"]), ticked)


def _day(began: str) -> date | None:
    try:
        return datetime.fromisoformat(began).date()
    except ValueError:
        return None


def _dated(unsearched: Mapping[str, Any]) -> str:
    day = _day(str(unsearched["date"] or ""))
    return listed([printable(str(unsearched["file"])), *([date_in_words(day)] if day else [])])


def _stays(participant: str, answer: Mapping[str, Any], below: list[Mapping[str, Any]]) -> list[str]:
    stays: list[str] = [
        N_("The runs of {code} in “{folder}”.", code=participant, folder=printable(str(d["folder"]))) for d in below
    ]
    stays += [N_("The remembered face “{name}”: {why}", name=f["name"], why=f["why"]) for f in answer["faces_kept"]]
    if answer["faces_kept"]:
        stays.append(N_("Is one of these faces theirs? Wipe it with: rrp-sheets faces --forget NAME"))
    if answer["faces_unreadable"]:
        stays.append(answer["faces_unreadable"])
    stays += [
        N_("The runs of “{code}”, which is spelled nearly the same.", code=code) for code in answer["similar_codes"]
    ]
    if answer["unreadable_runs"]:
        runs = listed([printable(str(n)) for n in answer["unreadable_runs"][:12]])
        stays.append(N_("Runs whose record cannot be read, so that nobody knows whose they are: {runs}", runs=runs))
    places = answer["code_still_in"]
    stays += [N_("“{code}” in {place}", code=participant, place=place) for place in places[:_MOST_NAMED]]
    left = len(places) - _MOST_NAMED
    if left > 0:
        stays.append(N_("“{code}” in {n:,} more files; `rrp-sheets runs delete` names them.", code=participant, n=left))
    unsearched = answer["not_searched"]
    if unsearched:
        stays.append(N_("These files were not searched for “{code}”. Open them and look yourself:", code=participant))
        stays += [_dated(u) for u in unsearched[:_MOST_NAMED]]
        left = len(unsearched) - _MOST_NAMED
        if left > 0:
            more = N_("{n:,} more files that were not searched; `rrp-sheets runs delete --json` names them.", n=left)
            stays.append(more)
    elif not answer["looked_through_everything"]:
        stays.append(N_("The folder has too many files to search all of them."))
    return [*stays, N_("Copies elsewhere: a backup, an export that was mailed, a bundle.")]
