"""Deletion of runs: shows what would be deleted and what stays, asks for a typed confirmation, and deletes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from datetime import date, datetime
from typing import Any, ClassVar

from flask import Blueprint, request

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, listed, sentences
from rrp_sheets.web.models import date_in_words, error_text, plural, show
from rrp_sheets.web.run_store import RunLine, line_of
from rrp_sheets.web.services import services
from rrp_sheets.web.workbook_repository import printable

blueprint = Blueprint("run_deletion", __name__)

_MOST_RUNS = 500  # that are chosen one by one
_MOST_NAMED = 40
_LONGEST = 300  # letters of a participant's code
_FOLDER = N_("This folder")


BelowLine = tuple[str, str, tuple[str, ...], bool]
"""Subfolder, its runs of the same participant in words, the faces wiped with them, and whether they are ticked."""


@dataclass(frozen=True, slots=True)
class DeletePage:
    """Page of runs that would be deleted, or were.

    Attributes:
        participant: whose runs; blank when they were chosen one by one.
        word: what has to be typed to confirm.
        shown: identifiers of the runs that the page shows, to be sent back with the confirmation.
        what: the number of files, pictures and sounds, in words; `stays` says what stays.
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
        return show(DeletePage(participant, "", notice=error_text(error), failed=True))


def _asked(participant: str | None) -> tuple[str, list[str]]:
    return (participant or "")[:_LONGEST], request.values.getlist("run")[:_MOST_RUNS]


def _asked_page(participant: str, names: list[str], notice: str = "") -> DeletePage:
    """Build the confirmation page; raises SheetsError when there are no such runs, or one is going."""
    return _page(participant, _of_exporter("plan_deletion", participant, names), notice, failed=bool(notice))


def _deleted_page(participant: str, names: list[str]) -> DeletePage:
    """Delete the runs, if the confirmation was typed and nothing has changed since the page was shown."""
    typed, expected = request.form.get("typed", "").strip(), request.form.getlist("shown")
    below = request.form.getlist("below")
    notice: str
    if typed != (participant or "delete"):
        notice = N_("The word “delete” was not typed; nothing was deleted.")
        if participant:
            notice = N_("The code {code} was not typed; nothing was deleted.", code=participant)
        return _asked_page(participant, names, notice)
    # what it was is told from what is there now: afterwards there is nothing to tell it from
    runs = services().runs
    answer = _of_exporter("delete_planned", participant, names, expected, below)
    if not answer["deleted"]:
        notice = N_("The list of runs has changed since it was shown, so nothing was deleted. Check the list again.")
        return _page(participant, answer, notice, failed=True)
    runs.forget({str(run["run"]) for run in answer["runs"]})
    count = len(answer["runs"]) + sum(len(d["runs"]) for d in answer.get("below", ()) if d["folder"] in below)
    notice = N_("{n} run deleted." if count == 1 else "{n} runs deleted.", n=count)
    if participant:
        of_code = N_("{n} run deleted of {code}." if count == 1 else "{n} runs deleted of {code}.")
        notice = N_(of_code, n=count, code=participant)
    if answer["begun"]:
        begun = listed([printable(str(n)) for n in answer["begun"][:_MOST_NAMED]])
        more = N_("A new run has begun and was not deleted: {runs}. Delete it when it has ended.", runs=begun)
        notice = sentences(notice, more)
    return _page(participant, answer, notice, failed=bool(answer["begun"]))


def _of_exporter(task: str, participant: str, names: list[str], *more: list[str]) -> Any:
    runs = services().runs
    busy = [*runs.going(), *runs.writing()]
    return services().exporter.ask(_FOLDER, task, str(runs.folder), participant, names, busy, *more)


def _page(participant: str, answer: Mapping[str, Any], notice: str, *, failed: bool) -> DeletePage:
    books = set(services().repository.names())
    done = bool(answer.get("deleted"))
    names = [str(run["run"]) for run in answer["runs"]]
    below = answer.get("below", ())
    ticked = request.form.getlist("below")
    gone = [answer, *(d for d in below if d["folder"] in ticked)] if done else [answer]
    return DeletePage(
        participant=participant, word=participant or "delete",
        lines=() if done else tuple(line_of(f, books) for f in services().runs.metadata(names)),
        shown=(*names, *(f"{d['folder']}/{run['run']}" for d in below for run in d["runs"])), what=_what(gone),
        wiped=tuple(name for d in gone for name in d["faces_wiped"]),
        stays=tuple(_stays(participant, answer, [d for d in below if done and d not in gone])),
        below=() if done else tuple(_below(d, d["folder"] in ticked) for d in below),
        done=done, notice=notice, failed=failed,
    )  # fmt: skip


def _what(answer: list[Mapping[str, Any]]) -> str:
    files, size, pictures, sounds = (sum(d[n] for d in answer) for n in ("files", "bytes", "pictures", "sounds"))
    one = N_("{n:,} file ({size} MB), of which {pictures:,} hold pictures or films and {sounds:,} speech or sounds")
    many = N_("{n:,} files ({size} MB), of which {pictures:,} hold pictures or films and {sounds:,} speech or sounds")
    megabytes = f"{size / 1e6:,.1f}"
    return N_(one if files == 1 else many, n=files, size=megabytes, pictures=pictures, sounds=sounds)


def _below(answer: Mapping[str, Any], ticked: bool) -> BelowLine:
    runs = answer["runs"]
    days = sorted({day for run in runs if (day := _day(str(run["began"])))})
    when = [date_in_words(day) for day in days[:1]]
    if len(days) > 1:
        when = [N_("from {first} to {last}", first=date_in_words(days[0]), last=date_in_words(days[-1]))]
    books = sorted({str(run["workbook"]) for run in runs if run["workbook"]})
    words = plural(len(runs), "run")
    if books:
        of_books = N_("{runs} of {books} and others" if len(books) > 3 else "{runs} of {books}")
        words = N_(of_books, runs=words, books=listed(books[:3]))
    return str(answer["folder"]), listed([words, *when]), tuple(answer["faces_wiped"]), ticked


def _day(began: str) -> date | None:
    try:
        return datetime.fromisoformat(began).date()
    except ValueError:
        return None


def _stays(participant: str, answer: Mapping[str, Any], below: list[Mapping[str, Any]]) -> list[str]:
    folders = [printable(str(d["folder"])) for d in below]
    stays: list[str] = [N_("The runs of {code} in “{folder}”.", code=participant, folder=name) for name in folders]
    stays += [N_("The remembered face “{name}”: {why}", name=f["name"], why=f["why"]) for f in answer["faces_kept"]]
    if answer["faces_kept"]:
        stays.append(N_("Is one of these faces theirs? Wipe it with: rrp-sheets faces --forget NAME"))
    if answer["faces_unreadable"]:
        stays.append(answer["faces_unreadable"])
    similar = answer["similar_codes"]
    stays += [N_("The runs of “{code}”, which is spelled nearly the same.", code=code) for code in similar]
    if answer["unreadable_runs"]:
        runs = listed([printable(str(n)) for n in answer["unreadable_runs"][:12]])
        stays.append(N_("Runs with unreadable recordings, so their participants are unknown: {runs}", runs=runs))
    places = answer["code_still_in"]
    stays += [N_("“{code}” in {place}", code=participant, place=place) for place in places[:_MOST_NAMED]]
    left = len(places) - _MOST_NAMED
    if left > 0:
        stays.append(N_("“{code}” in {n:,} more files; `rrp-sheets runs delete` names them.", code=participant, n=left))
    unsearched = answer["not_searched"]
    if unsearched:
        stays.append(N_("These files were not searched for “{code}”. Open them and look yourself:", code=participant))
        dated = ((printable(str(file["file"])), _day(str(file["date"] or ""))) for file in unsearched[:_MOST_NAMED])
        stays += [listed([file, *([date_in_words(day)] if day else [])]) for file, day in dated]
        left = len(unsearched) - _MOST_NAMED
        if left > 0:
            more = N_("{n:,} more files that were not searched; `rrp-sheets runs delete --json` names them.", n=left)
            stays.append(more)
    elif not answer["looked_through_everything"]:
        stays.append(N_("The folder has too many files to search all of them."))
    return [*stays, N_("Copies elsewhere: a backup, an export that was mailed, a bundle.")]
