"""What is to be said of a replay besides its differences: another end, and what it cannot know."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.diagnostics.phrase import Phrase, listed
from rrp_sheets.model.values import show
from rrp_sheets.runs.replay.ends import Ends
from rrp_sheets.runs.replay.play import Played
from rrp_sheets.runs.replay.record import Recorded
from rrp_sheets.runs.replay.words import in_words


def ending(recorded: Recorded, played: Played) -> str:
    """How a replay ended otherwise than the run; empty when it did not."""
    at = f"{played.until_us / 1e6:g} s"
    summary = recorded.summary or {}
    by = str(summary.get("by") or "")
    if played.broken:
        return Phrase("The replay broke off at {at}: {broken}", at=at, broken=played.broken)
    if played.ended_by and recorded.ended != "end run":
        return Phrase("The run would have ended at {at}, by {row}.", at=at, row=in_words(played.ended_by))
    if recorded.ended == "end run" and not played.ended_by:
        return Phrase(
            "The run was ended at {value:g} s by {row}; it would have gone on.",
            value=recorded.last_us / 1e6,
            row=in_words(by),
        )
    if played.ended_by and played.until_us != recorded.last_us:
        return Phrase("The run would have ended at {at} instead of {value:g} s.", at=at, value=recorded.last_us / 1e6)
    return ""


def unknown(
    recorded: Recorded, world: Mapping[str, int], cut: str, ends: Ends | None = None
) -> list[str]:  # fmt: skip
    """What a replay of a session cannot know.

    Args:
        recorded: the record.
        world: what the robot and its world did in it, with how often.
        cut: what is left out of a run that broke off, in words.
        ends: what was made of the ends of commands, when another workbook was played.
    """
    told = [cut] if cut else []
    if recorded.ended == "cut":
        at = f"{recorded.last_us / 1e6:g} s"
        told.append(Phrase("The record has no end: it was cut off at {at}, and is replayed up to there.", at=at))
    if recorded.engine != "frame":
        told.append("The event loop's record does not say which of two things of the same microsecond came first.")
    if world and ends is None:
        worlds = listed(
            [
                Phrase("{what} {count:,} time" if count == 1 else "{what} {count:,} times", what=what, count=count)
                for what, count in sorted(world.items())
            ]
        )
        told.append(
            Phrase(
                "What the robot and its world did is taken from the record and not done again ({listed}).",
                listed=worlds,
            )
        )
    if ends is not None:
        told += _ends_said(ends)
    return told


def _ends_said(ends: Ends) -> list[str]:
    told = [
        "The recorded world does not react: the robot would have moved and spoken otherwise, and people would have "
        "answered otherwise. What the sensors gave is what they gave in the session."
    ]
    if ends.dropped:
        whose = "is not made; its recorded end is" if ends.dropped == 1 else "are not made; their recorded ends are"
        told.append(Phrase(f"{{commands}} of the session {whose} left out.", commands=_many(ends.dropped)))
    if ends.usual:
        shown = dict.fromkeys(f"{show(value, 40)} {seconds:.1f} s" for _, value, seconds in ends.usual)
        words = (
            "{commands} that the session did not have at that time " + ("is" if len(ends.usual) == 1 else "are")
            + " taken to end after the time that the same took in it ({shown})."
        )  # fmt: skip
        told.append(Phrase(words, commands=_many(len(ends.usual)), shown=_few(list(shown))))
    if ends.unknown:
        shown = dict.fromkeys(show(value, 40) for _, value in ends.unknown)
        words = (
            "Of {commands} that the session never had the end is not known ({shown}): what waits for it does not come."
        )
        told.append(Phrase(words, commands=_many(len(ends.unknown)), shown=_few(list(shown))))
    return told


def _few(words: list[str]) -> str:
    return ", ".join(words[:4]) + (", …" if len(words) > 4 else "")


def _many(count: int) -> str:
    return Phrase("{n} command" if count == 1 else "{n} commands", n=f"{count:,}")
