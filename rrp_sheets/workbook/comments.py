"""Comments of cells: their threads as an .xlsx file has them, and the changes of a thread.

A file has them twice: as notes, which every spreadsheet program shows, and since Excel 2019 as threads with replies.
The note of a thread holds its texts for programs that do not know threads.

>>> first = Comment("{1}", "Aya", "2026-11-02T09:05:00Z", "Faster?")
>>> both = replied((first,), Comment("{2}", "Mika", "2026-11-02T09:06:00Z", "Yes"))
>>> fallback(both).splitlines()[-2:]
['Reply (Mika, 2026-11-02 09:06 UTC):', '    Yes']
"""

from __future__ import annotations

import re
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.xlsx import Handler, Stop, XlsxBook, place, truth, unescape

NOTE = "note"
"""The id of a comment that is no thread: spreadsheet programs call it a note. A cell has one at most."""
MOST_TEXT = 10_000
"""Letters of a comment that is written here."""
MOST_REPLIES = 200
_MOST_COMMENTS = 20_000  # of a sheet
_HEAD = "[Threaded comment]"
_TOLD = (
    "Your version of Excel allows you to read this threaded comment; however, any edits to it will get removed if the "
    "file is opened in a newer version of Excel. Learn more: https://go.microsoft.com/fwlink/?linkid=870924"
)  # as Excel writes it
_PIECE = re.compile(
    r"(?:\A|\n)(?:Comment|Reply)(?: \((?P<author>[^\n]*?)(?:, (?P<at>\d{4}-\d\d-\d\d \d\d:\d\d) UTC)?\))?:\n {4}"
)
_TIME = re.compile(r"\d{4}-\d\d-\d\dT\d\d:\d\d")
_IMPOSSIBLE = re.compile("[\x00-\x08\x0b\x0c\x0e-\x1f\ud800-\udfff\ufffe\uffff]")


@dataclass(frozen=True, slots=True)
class Comment:
    """A comment of a cell.

    Attributes:
        id: a GUID in braces, or `NOTE`.
        at: its time (ISO 8601, UTC); empty where the file does not tell it.
        done: its thread is resolved; of the first comment of a thread only.
    """

    id: str
    author: str
    at: str
    text: str
    done: bool = False


Thread = tuple[Comment, ...]
"""Comments of one cell in their order; the others are replies to the first."""
Threads = dict[tuple[int, int], Thread]
"""Threads by row and column."""


def new_id() -> str:
    """Return the id of a new comment."""
    return f"{{{str(uuid.uuid4()).upper()}}}"


def with_new_ids(thread: Thread) -> Thread:
    """Return a copy of a thread for another cell; a note stays one."""
    return tuple(c if c.id == NOTE else replace(c, id=new_id()) for c in thread)


def checked_text(text: str) -> str:
    """Return the text of a comment as it can be stored; raise SheetsError for one that cannot."""
    text = text.replace("\r\n", "\n").replace("\r", "\n").strip()
    if not text:
        raise SheetsError(N_("The comment is empty."), N_("Type a text first."))
    if len(text) > MOST_TEXT:
        message = N_("A comment has at most {most:,} characters; this one has {n:,}.", most=MOST_TEXT, n=len(text))
        raise SheetsError(message, N_("Split it into several comments."))
    if match := _IMPOSSIBLE.search(text):
        message = N_("The comment contains something that is no character ({code}).", code=f"U+{ord(match[0]):04X}")
        raise SheetsError(message, N_("Type the text again instead of pasting it."))
    return text


# ---- changes of a thread


def replied(thread: Thread, new: Comment) -> Thread:
    """Return the thread with one more comment; a resolved one is open again, and a note becomes a thread."""
    if len(thread) > MOST_REPLIES:
        message = N_("This thread has {n} comments already.", n=len(thread))
        raise SheetsError(message, N_("Start a new one in another cell."))
    return (*(replace(c, id=new_id() if c.id == NOTE else c.id, done=False) for c in thread), new)


def rewritten(thread: Thread, id: str, author: str, text: str) -> Thread:
    """Return the thread with another text of one's own comment."""
    _own(thread, id, author)
    return tuple(replace(c, text=text) if c.id == id else c for c in thread)


def removed(thread: Thread, id: str, author: str) -> Thread:
    """Return the thread without one's own comment; without its first one nothing is left of it.

    Raises SheetsError when others have replied to that.
    """
    found = _own(thread, id, author)
    if found is thread[0]:
        if others := sorted({c.author for c in thread[1:]} - {author}):
            message = N_("{name} has replied to this comment.", name=others[0])
            raise SheetsError(message, N_("Delete the whole thread, or edit the comment."))
        return ()
    return tuple(c for c in thread if c is not found)


def resolved(thread: Thread, done: bool) -> Thread:
    """Return the thread marked as resolved, or open again."""
    if not thread:
        raise _gone()
    first = replace(thread[0], id=new_id() if thread[0].id == NOTE else thread[0].id, done=done)
    return (first, *thread[1:])


def merged(now: Thread, before: Thread, after: Thread) -> Thread:
    """Make the change from `before` to `after` in a thread that others may have changed.

    Raises SheetsError when they have changed the same comment.

    >>> a, b, c = (Comment(str(i), "A", "", str(i)) for i in range(3))
    >>> merged((a, b, c), (a, b), (a,)) == (a, c), merged((a, c), (a,), (a, b)) == (a, b, c)
    (True, True)
    """
    if now == before:
        return after
    was, new = {c.id: c for c in before}, {c.id: c for c in after}
    there = {c.id: c for c in now}
    for id, old in was.items():
        mine, theirs = new.get(id), there.get(id)
        rewrites = mine is None or mine.text != old.text
        if mine != old and (theirs is None or (rewrites and theirs.text != old.text)):
            raise SheetsError(N_("This comment was changed since."), N_("Look at it again."))
    if before and (not after or after[0].id != before[0].id) and any(id not in was for id in there):
        name = next(c.author for c in now if c.id not in was)
        raise SheetsError(N_("{name} has replied to this comment.", name=name), N_("Delete the whole thread instead."))
    if now and not before:
        raise SheetsError(N_("Another comment is there now."), N_("Reply to it."))
    made = [_with_change(c, was.get(c.id), new.get(c.id)) for c in now if c.id in new or c.id not in was]
    for place_, comment in enumerate(after):
        if comment.id not in was and comment.id not in there:
            before_it = {c.id for c in after[:place_]}
            at = max((i + 1 for i, c in enumerate(made) if c.id in before_it), default=0)
            made.insert(at, comment)
    return tuple(made)


def _with_change(now: Comment, was: Comment | None, new: Comment | None) -> Comment:
    """A comment with what is another in `new` than it was."""
    if was is None or new is None:
        return now
    text = new.text if new.text != was.text else now.text
    return replace(now, text=text, done=new.done if new.done != was.done else now.done)


def _own(thread: Thread, id: str, author: str) -> Comment:
    found = next((c for c in thread if c.id == id), None)
    if found is None:
        raise _gone()
    if found.author != author:
        message = N_("This comment is by {name}: only {name} can change it.", name=found.author or N_("somebody else"))
        raise SheetsError(message, N_("Reply to it, or resolve the thread."))
    return found


def _gone() -> SheetsError:
    return SheetsError(N_("This comment was deleted."), N_("Write a new one."))


# ---- notes that hold a thread


def fallback(thread: Thread) -> str:
    """Return the text of a thread's note: Excel's, and with the names and times, which LibreOffice keeps only there."""
    whole = f"{_HEAD}\n\n{_TOLD}\n\n" + "\n".join(_piece(c, is_reply=bool(i)) for i, c in enumerate(thread))
    while len(whole.encode("utf-16-le")) // 2 > limits.CELL_CHARACTERS:
        whole = f"{whole[: len(whole) * 9 // 10]}…"
    return whole


def _piece(comment: Comment, *, is_reply: bool) -> str:
    at = f", {comment.at[:10]} {comment.at[11:16]} UTC" if _TIME.match(comment.at) else ""
    about = f"{' '.join(comment.author.split())}{at}"
    return f"{'Reply' if is_reply else 'Comment'}{f' ({about})' if about else ''}:\n    {comment.text}"


def _of_fallback(text: str, id: str) -> Thread:
    """The thread in the text of its note: a program that does not know threads has saved the file."""
    found = list(_PIECE.finditer(text))
    ends = [*(m.start() for m in found[1:]), len(text)]
    ids = [id, *(str(uuid.uuid5(uuid.NAMESPACE_OID, f"{id}{i}")) for i in range(1, len(found)))]
    return tuple(
        Comment(
            _braced(i), m["author"] or "", f"{m['at'].replace(' ', 'T')}:00Z" if m["at"] else "", text[m.end() : end]
        )
        for i, m, end in zip(ids, found, ends, strict=True)
    )


def _braced(id: str) -> str:
    return f"{{{id.strip('{}').upper()}}}"


# ---- reading


class _NotesHandler(Handler):
    """Collects the notes: author, text and id by cell; the first one of a cell."""

    def __init__(self) -> None:
        super().__init__()
        self.authors: list[str] = []
        self.notes: dict[str, tuple[int, str]] = {}
        self._ref, self._author, self._texts, self._phonetic = "", 0, list[str](), False

    def start(self, name: str, attributes: Any) -> None:
        if name == "rPh":
            self._phonetic = True
        elif name == "comment":
            self._ref, author = attributes.get("ref", ""), attributes.get("authorId", "")
            self._author = int(author) if author.isascii() and author.isdigit() and len(author) < 10 else -1
            self._texts = []
        elif name in ("author", "t") and not self._phonetic:
            self.take_text()
            self.wanted = True

    def end(self, name: str) -> None:
        if name == "rPh":
            self._phonetic = False
        elif name == "author":
            self.authors.append(self._taken())
        elif name == "t":
            self._texts.append(self._taken())
        elif name == "comment":
            self.notes.setdefault(self._ref, (self._author, "".join(self._texts)))
            if len(self.notes) > _MOST_COMMENTS:
                raise Stop

    def _taken(self) -> str:
        text, self.wanted = self.take_text() if self.wanted else "", False
        return text


class _ThreadsHandler(Handler):
    """Collects the comments of threads by cell, each with its person, and the names of persons."""

    def __init__(self) -> None:
        super().__init__()
        self.found: dict[str, list[tuple[bool, Comment]]] = {}
        self.persons: dict[str, str] = {}
        self._count, self._now = 0, dict[str, str]()

    def start(self, name: str, attributes: Any) -> None:
        if name == "person":
            self.persons[attributes.get("id", "")] = attributes.get("displayName", "")
        elif name == "threadedComment":
            self._now = dict(attributes.items())
        elif name == "text":
            self.take_text()
            self.wanted = True

    def end(self, name: str) -> None:
        if name == "text" and self.wanted:
            self.wanted = False
            now, self._now = self._now, {}
            if not now:
                return
            text = self.take_text()[: limits.CELL_CHARACTERS]
            at = now.get("dT", "")
            comment = Comment(now.get("id", ""), now.get("personId", ""), f"{at}Z" if at and at[-1] != "Z" else at,
                              text, truth(now.get("done")))  # fmt: skip
            self.found.setdefault(now.get("ref", ""), []).append((not now.get("parentId"), comment))
            self._count += 1
            if self._count > _MOST_COMMENTS:
                raise Stop


def read_threads(book: XlsxBook, index: int) -> Threads:
    """Read the comments of a sheet; parts that are missing or broken have none."""
    part = book.entries[index].part
    related = _related(book, part)
    if not related:
        return {}
    found: Threads = {}
    for ref, thread in _read_notes(book, related.get("comments", ())).items():
        if at := place(ref):
            found[at] = thread
    handler = _ThreadsHandler()
    for target in (*_related(book, book.part).get("person", ()), *related.get("threadedcomment", ())):
        _parse(book, target, handler)
    for ref, comments in handler.found.items():
        if at := place(ref):
            named = [(root, replace(c, author=handler.persons.get(c.author, ""))) for root, c in comments]
            first, *replies = [c for root, c in sorted(named, key=lambda one: not one[0])]
            found[at] = (first, *(replace(c, done=False) for c in replies))
    return found


def _related(book: XlsxBook, part: str) -> Mapping[str, Sequence[str]]:
    related: dict[str, list[str]] = {}
    for kind, target in book.relations(part).values():
        if kind in ("comments", "threadedcomment", "person") and target in book:
            related.setdefault(kind, []).append(target)
    return related


def _read_notes(book: XlsxBook, parts: Sequence[str]) -> dict[str, Thread]:
    found: dict[str, Thread] = {}
    for target in parts:
        handler = _NotesHandler()
        _parse(book, target, handler)
        for ref, (number, text) in handler.notes.items():
            author = unescape(handler.authors[number]) if 0 <= number < len(handler.authors) else ""
            found.setdefault(ref, note_thread(author, text, ref))
    return found


def note_thread(author: str, text: str, ref: str) -> Thread:
    """Return what the note of a cell says: a comment, or the thread that it holds."""
    text = unescape(text)[: limits.CELL_CHARACTERS]
    if text.startswith(_HEAD):
        id = (
            author.removeprefix("tc=")
            if author.startswith("tc=")
            else str(uuid.uuid5(uuid.NAMESPACE_OID, f"{ref} {text}"))
        )
        return _of_fallback(text, id) or (Comment(NOTE, "", "", text),)
    author = author.strip()  # LibreOffice writes a space for none
    head = f"{author}:\n"  # as Excel begins a new note
    return (Comment(NOTE, author, "", text.removeprefix(head) if author else text),)


def _parse(book: XlsxBook, part: str, handler: Handler) -> None:
    try:
        book.parse(part, handler)
    except UnreadableFile:  # what is wrong with a comment does not keep anybody from the rows
        return
