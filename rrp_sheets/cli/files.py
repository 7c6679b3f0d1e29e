"""Commands that write workbook files: `new`, `set`, `rename`, `convert`, `pose`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.cli.terminal import quoted, say, seconds_of, speak, translated
from rrp_sheets.texts import N_

_SHOWN = 3  # findings


@click.command(name="new")
@click.argument("file", type=click.Path(path_type=Path))
@click.option(
    "--template", default="guided", show_default=True, help="guided, empty, or a workbook that comes along: greeter, …"
)
@click.option("--robot", default="nao", show_default=True, help="the robot it is for")
def new_command(file: Path, template: str, robot: str) -> None:
    """Make FILE: a workbook with a small working behaviour, drop-downs and explanations.

    The template “guided” explains itself; “empty” has the sheets without rows; the others are the workbooks that come
    with the program, ready to be changed (simple-tracking, greeter, …). An existing file is never overwritten.
    """
    from rrp_sheets import api

    made = api.new(file, robot, template)
    click.echo(f"Created {made}. Open it in Excel or LibreOffice, and try it with:")
    click.echo(f'  rrp-sheets run "{made}"')


@click.command(name="set", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("cell")
@click.argument("value")
@click.option("--sheet", default="", help="the sheet, where CELL does not name it; default: the first behaviour")
def set_command(file: Path, cell: str, value: str, sheet: str) -> None:
    """Put VALUE into one CELL of FILE (Tracking!C5, or C5) and leave everything else in the file as it is.

    A number stays a number, TRUE and FALSE too; everything else is a text, also what begins with “=”. An empty VALUE
    ("") empties the cell.
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
@click.option("--sheet", default="", help="where OLD is given, if several sheets have it; or write Tracking!Far")
@click.option("--preview", is_flag=True, help="only show which cells would change")
def rename_command(file: Path, old: str, new: str, sheet: str, preview: bool) -> None:
    """Give the stream or helper OLD the name NEW in all cells of FILE that have it.

    These are inputs, formulas and outputs of rows, the sheets Devices, Helpers and Scene, and the tests. Notes stay as
    they are.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import verdict

    done = api.rename(file, old, new, sheet, preview=preview)
    speak(done.language)
    for one in done.renaming.edits:
        say(N_("{address}: {change}", address=str(one.address), change=quoted(one.was or "", one.text)))
    for address in done.renaming.unsafe:
        say(N_("{address} stays: its formula means something else by this name too.", address=str(address)))
    count = len(done.renaming.edits)
    if preview:
        say(N_("1 cell would change.") if count == 1 else N_("{n} cells would change.", n=count))
    else:
        say(N_("1 cell changed.") if count == 1 else N_("{n} cells changed.", n=count))
        say(N_("Check: {verdict}", verdict=verdict(done.report)))


@click.command(name="convert")
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("out", required=False, type=click.Path(path_type=Path))
@click.option("-o", "--output", type=click.Path(path_type=Path), help="the same as OUT, as the other commands have it")
def convert_command(file: Path, out: Path | None, output: Path | None) -> None:
    """Write FILE in another format: OUT is an .xlsx file, a Markdown file (.md), or a folder for CSV files.

    All cells of all sheets are carried over, and the behaviour is the same. Comments, formats, pictures, drop-downs and
    their sheet Lists exist only in .xlsx; which comments are left out is told. Nothing that exists is overwritten.
    """
    from rrp_sheets import api

    targets = [target for target in (out, output) if target is not None]
    if len(targets) != 1:
        raise click.UsageError("Name one file or folder to write: OUT, or -o OUT.")
    click.echo(f"Created {api.convert(file, targets[0], replace=False)}.")
    for note in api.not_kept(file, targets[0]):
        click.echo(f"{click.style('Note:', fg='yellow')} {translated(note)}")


@click.command(name="pose", context_settings={"ignore_unknown_options": True})
@click.argument("file", type=click.Path(path_type=Path))
@click.argument("joints", nargs=-1, metavar="[JOINT=ANGLE]…")
@click.option("--name", required=True, help="the gesture's name; it may be a new one")
@click.option("--posture", default="", help="a posture to begin with  [default: the gesture's last keyframe]")
@click.option("--at", default="", help="when, for example 1.5 (s)  [default: 1 s after the gesture's last keyframe]")
@click.option("--picture", type=click.Path(path_type=Path), help="store a picture of the robot in that pose (.png)")
def pose_command(file: Path, joints: tuple[str, ...], name: str, posture: str, at: str, picture: Path | None) -> None:
    """Let the simulated robot take a pose, and write its joints into the Gestures sheet of FILE as a keyframe.

    ANGLE is in rad or degrees; a hand goes from 0 (closed) to 1 (open). The sheet and the columns of the joints are
    made when they are not there; all else in the file stays as it is. A gesture goes from keyframe to keyframe and then
    back to where it began.

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
    for note in done.notes:
        click.echo(f"{click.style('Note:', fg='yellow')} {translated(note)}")
    click.echo(f"{done.address}: “{name}” at {done.at:g} s: {', '.join(shown(done.joints))}")
    if done.added:
        click.echo(f"New columns: {', '.join(done.added)}")
    say(N_("Check: {verdict}", verdict=verdict(done.report)))
    print_findings([d for d in done.report if d.address and d.address.sheet == done.address.sheet])
    if not done.report.errors:
        click.echo(f'Make it from a row: Output stream Gesture, with the formula "{name}".')
