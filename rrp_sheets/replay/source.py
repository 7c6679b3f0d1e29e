"""Workbook that a record is replayed with: the copy beside the trace, or another one; and its plan."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from rrp_sheets import __version__
from rrp_sheets.checks import Checked
from rrp_sheets.compare.side import open_checked
from rrp_sheets.engine.plan import Plan, make_plan
from rrp_sheets.engine.trace import stream_label
from rrp_sheets.errors import SheetsError, UnreadableFile
from rrp_sheets.model.run_files import WORKBOOK
from rrp_sheets.replay.record import Recorded
from rrp_sheets.texts import N_
from rrp_sheets.workbook import Reading

_KEPT = ("robot.toml", "gestures.toml")


@dataclass(frozen=True)
class ReplaySource:
    """A workbook that can be played.

    Attributes:
        name: of its file, for people.
        reading, checked: as it was read; it has no errors.
        plan: what of it runs.
        everything: whether behaviours that no row can switch on are loaded too, as in the recorded run.
    """

    name: str
    reading: Reading
    checked: Checked
    plan: Plan
    everything: bool

    @property
    def labels(self) -> dict[str, str]:
        """Names of the streams as traces have them, by their ids."""
        return {s.id: stream_label(s) for s in self.plan.streams}


def the_one_that_ran(recorded: Recorded) -> ReplaySource | None:
    """Read the workbook of the run's folder; return None when it is not there.

    Raises:
        UnreadableFile: when it is there and cannot be read.
        SheetsError: when it has errors now.
    """
    path = recorded.path.with_name(WORKBOOK)
    if not path.is_file():
        return None
    try:
        reading, checked = open_checked(path)
    except UnreadableFile as error:
        raise UnreadableFile(
            error.code,
            N_("The workbook of this run, “{name}”, cannot be read: {message}", name=path.name, message=error.message),
            N_("Copy the run's folder again, or name the workbook: --with FILE."),
        ) from None
    if checked.report.errors:
        first, program = checked.report.errors[0], recorded.header.text("program")
        raise SheetsError(
            N_(
                "The workbook of this run has errors for this version of the program ({version}): {message}",
                version=__version__,
                message=first.message,
            ),
            N_("Replay it with the version that made it ({program}), or --with a mended workbook.", program=program),
        )
    plan, everything = _plan(checked, recorded)
    return ReplaySource(recorded.header.text("name") or path.name, reading, checked, plan, everything)


def another(path: Path, recorded: Recorded, like: ReplaySource | None) -> ReplaySource:
    """Read another workbook, to be played with a record.

    Args:
        path: of it.
        recorded: the record.
        like: the workbook that ran, where it is known.

    Raises:
        UnreadableFile: when it cannot be read.
        SheetsError: when it has errors.
    """
    reading, checked = open_checked(path)
    if checked.report.errors:
        first = checked.report.errors[0]
        words = N_("“{name}” has errors and cannot run: {message}")
        if first.address:
            words = N_("“{name}” has errors and cannot run ({address}): {message}")
        raise SheetsError(
            N_(words, name=path.name, address=str(first.address or ""), message=first.message),
            N_("See `rrp-sheets check`, mend them, and replay again."),
        )
    if like is None:
        plan, everything = _plan(checked, recorded)
    else:
        plan, everything = make_plan(checked, everything=like.everything), like.everything
    if not plan.steps:
        raise SheetsError(
            N_("No row of “{name}” is switched on.", name=path.name), N_("Write TRUE in the On cells of some rows.")
        )
    return ReplaySource(path.name, reading, checked, plan, everything)


def _plan(checked: Checked, recorded: Recorded) -> tuple[Plan, bool]:
    """Return the plan whose streams are those of the record, and whether all behaviours are in it."""
    whole = make_plan(checked, everything=True)
    if {stream_label(s) for s in whole.streams} == set(recorded.streams):  # of two that fit: more can be switched on
        return whole, True
    return make_plan(checked), False


def remarks(recorded: Recorded, source: ReplaySource, *, own: bool) -> list[str]:
    """Return in words what to know of a record and the workbook it is replayed with, before anything is compared."""
    found: list[str] = []
    program = recorded.header.text("program") or "unknown"
    if program != __version__:
        found.append(
            N_(
                "The run was made with version {program} of the program, and is replayed with {version}.",
                program=program,
                version=__version__,
            )
        )
    digest = recorded.header.text("workbook")
    if own and digest != source.reading.digest and _was_xlsx(recorded):
        words = N_("The copy of the workbook beside the trace is not the one that ran (its SHA-256 is {own}…, "
                   "the run's {ran}…).")  # fmt: skip
        found.append(N_(words, own=source.reading.digest[:12], ran=digest[:12]))
    if own:
        found += _catalogue(recorded, source)
    return found


def _was_xlsx(recorded: Recorded) -> bool:
    return recorded.header.text("name").casefold().endswith(".xlsx")


def _catalogue(recorded: Recorded, source: ReplaySource) -> list[str]:
    """Return a remark when the robot's catalogue is not the one that the run was made with."""
    changed = []
    for name in _KEPT:
        kept, now = recorded.place / name, source.checked.robot.folder / name
        try:
            if kept.is_file() and now.is_file() and kept.read_bytes() != now.read_bytes():
                changed.append(name)
        except OSError:
            continue
    if not changed:
        return []
    return [
        N_(
            "The robot's catalogue ({changed}) has changed since the run; the one of now is used.",
            changed=", ".join(changed),
        )
    ]
