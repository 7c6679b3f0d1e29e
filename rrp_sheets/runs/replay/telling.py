"""What is to be said of a replay besides its differences: another end, and what it cannot know."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from rrp_sheets.model.values import show
from rrp_sheets.runs.replay.ends import Ends
from rrp_sheets.runs.replay.play import Played
from rrp_sheets.runs.replay.record import HAPPENING, Entry, Recorded
from rrp_sheets.runs.replay.words import in_words


def ending(recorded: Recorded, played: Played) -> str:
    """How a replay ended otherwise than the run; empty when it did not."""
    at = f"{played.until_us / 1e6:g} s"
    summary = recorded.summary or {}
    by = str(summary.get("by") or "")
    if played.broken:
        return f"The replay broke off at {at}: {played.broken}"
    if played.ended_by and recorded.ended != "end run":
        return f"The run would have ended at {at}, by {in_words(played.ended_by)}."
    if recorded.ended == "end run" and not played.ended_by:
        return f"The run was ended at {recorded.last_us / 1e6:g} s by {in_words(by)}; it would have gone on."
    if played.ended_by and played.until_us != recorded.last_us:
        return f"The run would have ended at {at} instead of {recorded.last_us / 1e6:g} s."
    return ""


def unknown(
    recorded: Recorded, entries: Sequence[Entry], is_engines: Callable[[Entry], bool], cut: str,
    ends: Ends | None = None,
) -> list[str]:  # fmt: skip
    """What a replay of a session cannot know.

    Args:
        recorded: the record.
        entries: what of it is replayed.
        is_engines: whether the engine itself has told something.
        cut: what is left out of a run that broke off, in words.
        ends: what was made of the ends of commands, when another workbook was played.
    """
    told = [cut] if cut else []
    if recorded.ended == "cut":
        at = f"{recorded.last_us / 1e6:g} s"
        told.append(f"The record has no end: it was cut off at {at}, and is replayed up to there.")
    if recorded.engine != "frame":
        told.append("The event loop's record does not say which of two things of the same microsecond came first.")
    world = Counter(e.what for e in entries if e.kind == HAPPENING and not is_engines(e))
    if world and ends is None:
        listed = ", ".join(f"{what} {count:,} time{'' if count == 1 else 's'}" for what, count in sorted(world.items()))
        told.append(f"What the robot and its world did is taken from the record and not done again ({listed}).")
    if ends is not None:
        told += _ends_said(ends)
    return told


def _ends_said(ends: Ends) -> list[str]:
    told = [
        "The recorded world does not react: the robot would have moved and spoken otherwise, and people would have "
        "answered otherwise. What the sensors gave is what they gave in the session."
    ]
    if ends.dropped:
        whose = "its recorded end is" if ends.dropped == 1 else "their recorded ends are"
        words = f"{_many(ends.dropped, 'command')} of the session {_was(ends.dropped)} not made"
        told.append(f"{words}; {whose} left out.")
    if ends.usual:
        shown = dict.fromkeys(f"{show(value, 40)} {seconds:.1f} s" for _, value, seconds in ends.usual)
        told.append(
            f"{_many(len(ends.usual), 'command')} that the session did not have at that time {_was(len(ends.usual))} "
            f"taken to end after the time that the same took in it ({_few(list(shown))})."
        )
    if ends.unknown:
        shown = dict.fromkeys(show(value, 40) for _, value in ends.unknown)
        told.append(
            f"Of {_many(len(ends.unknown), 'command')} that the session never had the end is not known "
            f"({_few(list(shown))}): what waits for it does not come."
        )
    return told


def _few(words: list[str]) -> str:
    return ", ".join(words[:4]) + (", …" if len(words) > 4 else "")


def _many(count: int, what: str) -> str:
    return f"{count:,} {what}{'' if count == 1 else 's'}"


def _was(count: int) -> str:
    return "is" if count == 1 else "are"
