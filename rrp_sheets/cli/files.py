"""Commands that write workbook files: `new`, `set`, `rename`, `convert`, `pose`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.cli.language import readers_language, speak
from rrp_sheets.cli.terminal import print_notes, quoted, say, seconds_of, usage_error
from rrp_sheets.texts import LANGUAGES, N_, listed, plural

_SHOWN = 3  # findings


@click.command(name="new")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--template", default="guided", show_default=True, help="guided, empty, or an example workbook: greeter, …"
)
@click.option("--robot", default="nao", show_default=True, help="the robot it is for")
@click.option("--language", type=click.Choice(list(LANGUAGES)), default=None,
              help="the language of the workbook  [default: your computer's]")  # fmt: skip
def new_command(file: Path, template: str, robot: str, language: str | None) -> None:
    """Create FILE: a workbook with a small working behaviour, drop-down lists and explanations.

    The template “guided” explains itself. “empty” has the sheets without rows. The others are the example workbooks of
    the program (simple-tracking, greeter, …). An existing file is never overwritten.
    """
    from rrp_sheets import api

    made = api.new(file, robot, template, language or readers_language() or "en")
    say(N_("Created {path}. Open it in Excel or LibreOffice, and try it with:", path=made))
    click.echo(f'  rrp-sheets run "{made}"')


@click.command(name="set", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("cell")
@click.argument("value")
@click.option("--sheet", default="", help="the sheet, if CELL does not name it  [default: the first behaviour]")
def set_command(file: Path, cell: str, value: str, sheet: str) -> None:
    """Write VALUE into one CELL of FILE (Tracking!C5, or C5). Everything else in the file stays as it is.

    Numbers stay numbers, and TRUE and FALSE stay as they are. Everything else is text, even when it begins with “=”. An
    empty VALUE ("") clears the cell.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings, verdict

    done = api.set_cell(file, cell, value, sheet)
    speak(done.language)
    address, after = str(done.address), quoted(done.after)
    same = N_("{address} is {after} already.", address=address, after=after)
    change = quoted(done.before, done.after)
    say(same if done.before == done.after else N_("{address}: {change}", address=address, change=change))
    say(N_("Check: {verdict}", verdict=verdict(done.report)))
    found = [d for d in done.report if d.severity.value != "info"]
    found.sort(key=lambda d: (d.severity.value != "error", d.address != done.address))  # those of this cell first
    print_findings(found[:_SHOWN])
    if len(found) > _SHOWN:
        say(N_('All of them: rrp-sheets check "{file}"', file=file))


@click.command(name="rename")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("old")
@click.argument("new")
@click.option("--sheet", default="", help="the sheet of OLD, if several sheets have it; or write Tracking!Far")
@click.option("--also", "also", multiple=True, metavar="CELL",
              help="also change this cell, which only perhaps reads the column, such as Helpers!C2")  # fmt: skip
@click.option("--preview", is_flag=True, help="only show which cells would change")
def rename_command(file: Path, old: str, new: str, sheet: str, also: tuple[str, ...], preview: bool) -> None:
    """Rename the stream, helper or column of a table OLD to NEW in all cells of FILE.

    This changes inputs, formulas and outputs of rows, the sheets Devices, Helpers and Scene, and the tests. Notes are
    not changed.

    A column is written with its table, as in formulas: "Parts[Zone]". Its header changes, and the formulas and tests
    that read it. Formulas that only perhaps read it are shown: name those that do with --also.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import verdict

    done = api.rename(file, old, new, sheet, also, preview=preview)
    speak(done.language)
    for one in done.renaming.edits:
        say(N_("{address}: {change}", address=str(one.address), change=quoted(one.was or "", one.text)))
    for address in done.renaming.unsafe:
        say(N_("{address} stays: its formula means something else by this name too.", address=str(address)))
    for one in done.renaming.unsure:
        change = quoted(one.was or "", one.text)
        words = N_("{address} perhaps reads this column: {change}. If it does, add --also {address}.")
        say(N_(words, address=str(one.address), change=change))
    count = len(done.renaming.edits)
    if preview:
        say(plural("{n} cell would change.", "{n} cells would change.", count))
    else:
        say(plural("{n} cell changed.", "{n} cells changed.", count))
        say(N_("Check: {verdict}", verdict=verdict(done.report)))


@click.command(name="convert")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("out", required=False, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the same as OUT, as the other commands have it")
def convert_command(file: Path, out: Path | None, output: Path | None) -> None:
    """Write FILE in another format: OUT is an .xlsx file, a Markdown file (.md), or a folder for CSV files.

    All cells of all sheets are copied, and the behaviour is the same. Comments, formats, pictures, drop-down lists and
    their sheet Lists exist only in .xlsx; it says which comments are left out. Existing files are never overwritten.
    """
    from rrp_sheets import api

    targets = [target for target in (out, output) if target is not None]
    if len(targets) != 1:
        raise usage_error(N_("Name one file or folder to write: OUT, or -o OUT."))
    say(N_("Created {path}.", path=api.convert(file, targets[0], replace=False)))
    for note in api.not_kept(file, targets[0]):
        say(N_("Note: {note}", note=note))


@click.command(name="pose", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("joints", nargs=-1, metavar="[JOINT=ANGLE]…")
@click.option("--name", required=True, help="the gesture's name; it may be a new one")
@click.option("--posture", default="", help="a posture to begin with  [default: the gesture's last keyframe]")
@click.option("--at", default="", help="when, for example 1.5 (s)  [default: 1 s after the gesture's last keyframe]")
@click.option("--picture", type=click.Path(path_type=Path), help="store a picture of the robot in that pose (.png)")
def pose_command(file: Path, joints: tuple[str, ...], name: str, posture: str, at: str, picture: Path | None) -> None:
    """Pose the simulated robot, and save its joints as a keyframe on the sheet Gestures of FILE.

    ANGLE is in rad or degrees; a hand goes from 0 (closed) to 1 (open). The sheet and its columns are added when they
    are missing. A gesture moves from keyframe to keyframe, and then back to where it began.

    For example, a gesture of two keyframes, with a picture of the second:

    \b
      rrp-sheets pose my.xlsx --name "High five" RShoulderPitch=-20° RElbowRoll=60° RHand=1
      rrp-sheets pose my.xlsx --name "High five" RElbowRoll=10° --at 1.5 --picture pose.png
    """  # noqa: D301 - the sign keeps the lines as they are
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings, verdict
    from rrp_sheets.services.posing import shown

    done = api.pose(file, name, joints, posture=posture, at=seconds_of(at, "--at"), picture=picture)
    speak(done.language)
    print_notes(done.notes, err=False)
    words = N_("{address}: “{name}” at {seconds:g} s: {joints}")
    say(N_(words, address=str(done.address), name=name, seconds=done.at, joints=listed([*shown(done.joints)])))
    if done.added:
        say(N_("New columns: {names}", names=listed(done.added)))
    say(N_("Check: {verdict}", verdict=verdict(done.report)))
    print_findings([d for d in done.report if d.address and d.address.sheet == done.address.sheet])
    if not done.report.errors:
        say(N_('Make it from a row: Output stream Gesture, with the formula "{name}".', name=name))
