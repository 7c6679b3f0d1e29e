"""Wording of the account of a replay: verdict, rows, the robot, each difference, the end, and what it cannot know."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import groupby
from operator import attrgetter
from typing import TYPE_CHECKING, Any

from rrp_sheets.model.values import record_from_mapping, show
from rrp_sheets.replay.result import EXTRA, MISSING, ORDER, ROW, TIME, VALUE, Count, Difference
from rrp_sheets.texts import N_, listed, translate

if TYPE_CHECKING:
    from rrp_sheets.replay.play import Ends, ReplayPlayer
    from rrp_sheets.replay.record import Recorded
    from rrp_sheets.replay.result import Replayed

_KINDS = (N_("say"), N_("sound"), N_("scene"), N_("clamp"), N_("fall"), N_("person"))
"""Kinds of entries that `unknown` counts; marked as texts here, since traces hold them as plain words."""


def ending(recorded: Recorded, player: ReplayPlayer) -> str:
    """Describe in which way a replay ended otherwise than the run; empty when it did not."""
    at = N_("{n:g} s", n=player.until_us / 1e6)
    by = recorded.summary.text("by") if recorded.summary else ""
    if player.broken:
        return N_("The replay stopped at {at}: {broken}", at=at, broken=player.broken)
    if player.ended_by and recorded.ended != "end run":
        return N_("The run would have ended at {at}, by {row}.", at=at, row=in_words(player.ended_by))
    if recorded.ended == "end run" and not player.ended_by:
        words = N_("{row} ended the run at {value:g} s. It would have continued.")
        return N_(words, value=recorded.last_us / 1e6, row=in_words(by))
    if player.ended_by and player.until_us != recorded.last_us:
        return N_("The run would have ended at {at} instead of {value:g} s.", at=at, value=recorded.last_us / 1e6)
    return ""


def unknown(recorded: Recorded, world: Mapping[str, int], cut: str, ends: Ends | None = None) -> list[str]:
    """Return in words the limits of a replay of a session.

    Args:
        recorded: the session.
        world: what the robot and its world did in it, with how often.
        cut: what is left out of a run that broke off, in words.
        ends: what was made of the ends of commands, when another workbook was played.
    """
    said = [cut] if cut else []
    if recorded.ended == "cut":
        at = N_("{n:g} s", n=recorded.last_us / 1e6)
        said.append(N_("The recording has no end. It stops at {at} and is replayed up to there.", at=at))
    if recorded.engine != "frame":
        said.append(
            N_("The recording of an event loop does not say which of two events in the same microsecond came first.")
        )
    if world and ends is None:
        worlds = listed([
            N_("{what} {count:,} time" if count == 1 else "{what} {count:,} times", what=N_(what), count=count)
            for what, count in sorted(world.items())
        ])  # fmt: skip
        words = N_("The actions of the robot and its world are taken from the recording and not repeated ({listed}).")
        said.append(N_(words, listed=worlds))
    if ends is not None:
        said += _ends_said(ends)
    return said


def _ends_said(ends: Ends) -> list[str]:
    words = N_("The recorded world does not react. The robot would have moved and spoken differently, and people "
               "would have answered differently. The sensor values are those of the session.")  # fmt: skip
    said: list[str] = [words]
    if ends.dropped:
        one = N_("{commands} of the session is not sent, so its recorded end is skipped.")
        more = N_("{commands} of the session are not sent, so their recorded ends are skipped.")
        said.append(N_(one if ends.dropped == 1 else more, commands=_many(ends.dropped)))
    if ends.usual:
        said.append(N_(
            "{commands} that the session did not have at that time is taken to end after the time that the same took "
            "in it ({shown})." if len(ends.usual) == 1 else
            "{commands} that the session did not have at that time are taken to end after the time that the same took "
            "in it ({shown}).", commands=_many(len(ends.usual)),
            shown=_few(N_("{value} {seconds:.1f} s", value=show(v, 40), seconds=s) for _, v, s in ends.usual),
        ))  # fmt: skip
    if ends.unknown:
        words = N_("The session never had {commands}, so the end is unknown ({shown}). Rows that wait for it do not "
                   "act.")  # fmt: skip
        shown = _few(show(value, 40) for _, value in ends.unknown)
        said.append(N_(words, commands=_many(len(ends.unknown)), shown=shown))
    return said


def _few(texts: Iterable[str]) -> str:
    words = list(dict.fromkeys(texts))
    return listed(words) if len(words) < 5 else N_("{before}, …", before=listed(words[:4]))


def _many(count: int) -> str:
    return N_("{n} command" if count == 1 else "{n} commands", n=f"{count:,}")


MOST = 40  # lines of a list; the JSON and the table have all
Style = Callable[[str, str], str]


@dataclass(frozen=True)
class RowLine:
    """Differences at a row or of a sensor stream, in words; `row` is empty when it is not in the played workbook."""

    whose: str
    text: str
    row: str


_SAY = {
    MISSING: (N_("{n} of {of} events would not have happened"), N_("{n} of {of} events did not happen"),
        N_("{n} would not have happened"), N_("{n} did not happen")),
    VALUE: (N_("{n} of {of} events would have had another value"), N_("{n} of {of} events had another value"),
        N_("{n} would have had another value"), N_("{n} had another value")),
    TIME: (N_("{n} of {of} events would have come at another time"), N_("{n} of {of} events came at another time"),
        N_("{n} would have come at another time"), N_("{n} came at another time")),
    ROW: (N_("{n} of {of} events would have come from another row"), N_("{n} of {of} events came from another row"),
        N_("{n} would have come from another row"), N_("{n} came from another row")),
    ORDER: (N_("{n} of {of} events would have come in another order"), N_("{n} of {of} events came in another order"),
        N_("{n} would have come in another order"), N_("{n} came in another order")),
}  # fmt: skip
"""Wordings of differences by their kind, with another workbook and with the one that ran; then what follows others."""
_EXTRA = (
    N_("{n} event would have happened"), N_("{n} event happened"),
    N_("{n} events would have happened"), N_("{n} events happened"),
    N_("{n} more event would have happened"), N_("{n} more event happened"), N_("{n} more events would have happened"),
    N_("{n} more events happened"), N_("{n} more would have happened"), N_("{n} more happened"),
)  # fmt: skip
"""Wordings of events that were not recorded, each with another workbook and with the one that ran."""


def as_text(found: Replayed, style: Style | None = None, language: str = "") -> str:
    """Return the account for people to read, in a language or that of the workbook that ran.

    `style` colours a text by its role: `same`, `different`, `head`, `quiet`.
    """
    language = language or found.language

    def say(text: str, role: str = "") -> str:
        words = translate(text, language)
        return style(words, role) if role and style else words

    lines = [say(verdict(found), "same" if found.same else "different")]
    lines += [say(remark, "quiet") for remark in found.remarks]
    if found.ending:
        lines.append(say(found.ending))
    if found.differences:
        rows = (say(N_("  {whose}: {what}.", whose=line.whose, what=line.text)) for line in row_lines(found))
        lines += ["", say(N_("Row by row:"), "head"), *rows]
        robots = robot_lines(found)
        if robots:
            lines += ["", say(N_("The robot:"), "head"), *_listed(robots, language)]
        else:
            lines += ["", say(N_("The commands to the robot stay the same."), "head")]
        if not found.other:
            lines += ["", say(N_("Each difference:"), "head"), *_listed(each_line(found), language)]
    if found.unknown:
        lines += ["", say(N_("Limits of this replay:"), "head"), *(f"  {say(line)}" for line in found.unknown)]
    return "\n".join(lines)


def _listed(lines: Sequence[AccountLine], language: str) -> list[str]:
    shown = [(translate(line.when, language), translate(line.text, language)) for line in lines[:MOST]]
    wide = max(len(when) for when, _ in shown)
    found = [f"  {when:>{wide}}  {text}" for when, text in shown]
    more = N_("… and {n} more", n=f"{len(lines) - MOST:,}")
    return [*found, f"  {translate(more, language)}"] if len(lines) > MOST else found


def verdict(found: Replayed) -> str:
    """Return the one sentence that says whether it is the same."""
    count, of = found.compared, f"{found.compared:,}"
    events = N_("{n} event" if count == 1 else "{n} events", n=of)
    seconds = f"{round(found.seconds, 1):g}"
    if found.same and found.other:
        same = N_("The same: with {other}, {events} of this session would have been the same.")
        return N_(same, other=found.other, events=events)
    if found.same:
        return N_("The same: {events} in {seconds} s, as recorded.", events=events, seconds=seconds)
    extra = len(found.of(EXTRA))
    others = len(found.differences) - extra
    parts: list[str] = []
    if found.other:
        if others:
            parts.append(N_("{n} of {of} events would have been different", n=f"{others:,}", of=of))
        if extra:
            further = others or count
            parts.append(N_("{n} more would have happened" if further else "{n} would have come", n=f"{extra:,}"))
        what = listed(parts, "and") if parts else N_("the run would have ended differently")
        different = N_("Different: with {other}, {what} in these {seconds} s.")
        return N_(different, other=found.other, what=what, seconds=seconds)
    if others or not extra:
        parts.append(N_("{n} of {of} events", n=f"{others:,}", of=of))
    if extra:
        parts.append(N_("{n} that was not recorded" if extra == 1 else "{n} that were not recorded", n=f"{extra:,}"))
    if found.first is None:
        return N_("Different: {what}.", what=listed(parts, "and"))
    when, first = in_seconds(found.first.us), _each(found.first)
    return N_("Different: {what}. The first at {when}: {first}", what=listed(parts, "and"), when=when, first=first)


# ---- row by row
def row_lines(found: Replayed) -> list[RowLine]:
    """Return a line for each row or sensor stream that has differences: how many of how many, in words."""
    of: dict[tuple[str, str, str], list[Difference]] = {}
    for d in found.differences:
        of.setdefault((d.stream, d.row, d.came_row), []).append(d)
    counts = {(c.stream, c.row, c.came_row): c for c in sorted(found.counts, key=_place)}
    places = [*(place for place in counts if place in of), *(place for place in of if place not in counts)]
    lines = []
    for place in places:
        here = of[place]
        count = counts.get(place) or Count(*place, 0, len(here), 0)  # of a row in place of another one
        lines.append(RowLine(_whose(count, found), _how_many(here, count, found), count.came_row))
    return lines


def _place(count: Count) -> tuple[str, int, str]:
    sheet, _, number = (count.came_row or count.row).rpartition("!")
    return sheet, int(number) if number.isdecimal() else 0, count.stream


def _whose(count: Count, found: Replayed) -> str:
    name = _name(count.stream)
    row = count.came_row or count.row
    if not row:
        return _quoted(name) if name else N_("The engine")
    words = in_words(row)
    if found.other and not count.came_row:
        words = N_("{row} of the session's workbook", row=words)
    elif found.other and not count.row:
        words = N_("{row} (new)", row=words)
    elif found.other and count.row != count.came_row:
        words = N_("{row} (in the session {was})", row=words, was=count.row.rpartition("!")[2])
    return N_("{row} → {name}", row=words, name=name) if name else words


def _times(count: int) -> str:
    return {0: N_("never"), 1: N_("once")}.get(count) or N_("{n} times", n=f"{count:,}")


def _name(stream: str) -> str:
    """Return a stream's name without its sheet; empty for a stream without a name."""
    name = stream.rpartition("!")[2]
    return "" if name.startswith("#") else name


def _how_many(here: Sequence[Difference], count: Count, found: Replayed) -> str:
    would = bool(found.other)
    if here[0].what == "error":
        came, then = _times(count.came), _times(count.recorded)
        return N_(
            "its formula would have failed {came}, in the session {then}" if would else
            "its formula failed {came}, in the session {then}", came=came, then=then,
        )  # fmt: skip
    parts: list[str] = []
    for kind, forms in _SAY.items():
        number = sum(d.kind == kind for d in here)
        if number:
            parts.append(N_(forms[2 * bool(parts) + (not would)], n=f"{number:,}", of=f"{count.recorded:,}"))
    extra = sum(d.kind == EXTRA for d in here)
    if extra:
        form = 4 if parts else 2 * (count.recorded > 0) + (extra != 1)
        parts.append(N_(_EXTRA[2 * form + (not would)], n=f"{extra:,}"))
    return listed(parts)


# ---- one by one
def each_line(found: Replayed) -> list[AccountLine]:
    """Return every difference in words."""
    return [AccountLine(in_seconds(d.us), d.us, _each(d), d.came_row or d.row) for d in found.differences]


def _each(d: Difference) -> str:
    row, name = d.came_row or d.row, _name(d.stream)
    where = _quoted(name)
    if row:
        where = N_("{row} → {name}", row=in_words(row), name=name) if name else in_words(row)
    recorded, came = (
        N_("the error “{text}”", text=v[0]) if d.what == "error" and isinstance(v, list) and v else shown(v)
        for v in (d.recorded, d.came)
    )
    if d.kind == ROW:
        words = N_("{recorded} came from {now} instead of {then}")
        return N_(words, recorded=recorded, now=in_words(d.came_row), then=in_words(d.row))
    words = {
        MISSING: N_("{where}: {recorded} was recorded but did not happen"),
        EXTRA: N_("{where}: {came} happened but was not recorded"),
        VALUE: N_("{where}: it was {came} instead of {recorded}"),
        TIME: N_("{where}: {recorded} came at {when} instead"),
    }.get(d.kind, N_("{where}: {came} came before the recorded {recorded}"))
    return N_(words, where=where, recorded=recorded, came=came, when=in_seconds(d.came_us))


_TOGETHER_US = 2_000_000  # between two of a row that are told in one line


def robot_lines(found: Replayed) -> list[AccountLine]:
    """Describe what the robot would have done otherwise, in the order of time; what goes on is one line."""
    actuators = set(found.actuators)
    mine = [d for d in found.differences if d.stream in actuators and d.what == "event" and d.kind != ROW]
    lines: list[AccountLine] = []
    place = attrgetter("stream", "row", "came_row")
    for (stream, *_), group in groupby(sorted(mine, key=place), key=place):
        for run in _runs(sorted(group, key=_when), spoken=stream in found.spoken):
            lines.append(_robot_line(run, found))
    return sorted(lines, key=lambda t: t.us)


def _when(difference: Difference) -> int:
    return difference.came_us if difference.kind == EXTRA else difference.us


def _runs(here: Sequence[Difference], *, spoken: bool) -> Iterator[list[Difference]]:
    """Group differences of one kind that follow each other closely; every sentence of the robot counts by itself."""
    run: list[Difference] = []
    for d in here:
        if run and (spoken or d.kind != run[-1].kind or _when(d) - _when(run[-1]) > _TOGETHER_US):
            yield run
            run = []
        run.append(d)
    if run:
        yield run


def _robot_line(run: Sequence[Difference], found: Replayed) -> AccountLine:
    first, last = run[0], run[-1]
    row = first.came_row or first.row
    when = in_seconds(_when(last), 2)
    if len(run) > 1:
        when = N_("{first:.10g} to {last}", first=round(_when(first) / 1e6, 2), last=when)
    words = _spoken_words(first, found) if first.stream in found.spoken else _given_words(run, found)
    return AccountLine(when, _when(first), N_("{what} ({row})", what=words, row=in_words(row)), row)


def _spoken_words(d: Difference, found: Replayed) -> str:
    own = found.spoken[d.stream]
    recorded, came = (_quoted(own or value) for value in (d.recorded, d.came))
    would = bool(found.other)
    if d.kind == MISSING and d.recorded is None:
        return N_("would not have been silenced" if would else "was not silenced")
    if d.kind == EXTRA and d.came is None:
        return N_("would have been silenced" if would else "was silenced")
    words = {
        MISSING: (N_("would not have said {recorded}"), N_("did not say {recorded}")),
        EXTRA: (N_("would have said {came}"), N_("said {came}")),
        TIME: (N_("would have said {came} at {when} instead"), N_("said {came} at {when} instead")),
        VALUE: (N_("would have said {came} instead of {recorded}"), N_("said {came} instead of {recorded}")),
    }.get(d.kind, (N_("would have said it in another order"), N_("said it in another order")))
    return N_(words[not would], recorded=recorded, came=came, when=in_seconds(d.came_us))


def _quoted(value: Any) -> str:
    return N_("“{text}”", text=value) if isinstance(value, str) else shown(value)


_STOPPED = {
    MISSING: (N_("“{name}” would not have been stopped"), N_("“{name}” was not stopped"),
        N_("“{name}” would not have been stopped {n} times"), N_("“{name}” was not stopped {n} times")),
    EXTRA: (N_("“{name}” would have been stopped"), N_("“{name}” was stopped"),
        N_("“{name}” would have been stopped {n} times"), N_("“{name}” was stopped {n} times")),
}  # fmt: skip
_GIVEN = {
    MISSING: (N_("“{name}” would not have got {value}"), N_("“{name}” did not get {value}"),
        N_("“{name}” would not have got {n} values"), N_("“{name}” did not get {n} values")),
    EXTRA: (N_("“{name}” would have got {value}"), N_("“{name}” got {value}"),
        N_("“{name}” would have got {n} values"), N_("“{name}” got {n} values")),
    TIME: (N_("“{name}” would have got {value} at {when} instead"),
        N_("“{name}” got {value} at {when} instead"),
        N_("“{name}” would have got {n} values at other times"),
        N_("“{name}” got {n} values at other times")),
    VALUE: (N_("“{name}” would have got {value} instead of {other}"),
        N_("“{name}” got {value} instead of {other}"),
        N_("“{name}” would have got {n} other values"), N_("“{name}” got {n} other values")),
}  # fmt: skip
_OTHERWISE = 2 * (
    N_("“{name}” would have got its values in another order"),
    N_("“{name}” got its values in another order"),
)
"""Wordings of what an actuator would have been given: once and several times, as those of `_SAY`."""


def _given_words(run: Sequence[Difference], found: Replayed) -> str:
    d, many = run[0], len(run)
    blank = all((r.recorded if d.kind == MISSING else r.came) is None for r in run)
    forms = _STOPPED if blank else _GIVEN  # blank stops what it is doing
    words = forms.get(d.kind, _GIVEN.get(d.kind, _OTHERWISE))[2 * (many > 1) + (not found.other)]
    value = shown(d.recorded if d.kind == MISSING else d.came)
    when = in_seconds(d.came_us)
    return N_(words, name=d.stream, n=f"{many:,}", value=value, other=shown(d.recorded), when=when)


_LONGEST = 60  # letters of a value


def in_words(row: str) -> str:
    """Return a row as people name it.

    >>> in_words("Tracking!5"), in_words("")
    ('Tracking row 5', 'a row')
    """
    sheet, mark, number = row.rpartition("!")
    return N_("{sheet} row {number}", sheet=sheet, number=number) if mark else row or N_("a row")


@dataclass(frozen=True)
class AccountLine:
    """One sentence on a difference that a replay found.

    Attributes:
        when: in words: `12.4 s`, or `6 to 6.9 s`.
        us: when it begins.
        row: whose it is, in the workbook that was played, or in the one that ran if that has none.
    """

    when: str
    us: int
    text: str
    row: str


def shown(value: Any) -> str:
    """Return a short text of a value."""
    return show(_value(value), _LONGEST).strip()


def _value(value: Any) -> Any:
    if isinstance(value, dict):
        return record_from_mapping("", {str(n): _value(v) for n, v in value.items()})
    return [_value(v) for v in value] if isinstance(value, list) else value


def in_seconds(us: int, digits: int = 3) -> str:
    """Format a time of the run, to so many digits.

    >>> in_seconds(12_400_000), in_seconds(33_333), in_seconds(600_000_000)
    ('12.4 s', '0.033 s', '600 s')
    """
    return N_("{n:.10g} s", n=round(us / 1e6, digits))
