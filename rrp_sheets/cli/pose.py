"""`rrp-sheets pose FILE --name NAME [JOINT=ANGLE …]`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.model.durations import parse_duration


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

    done = api.pose(file, name, joints, posture=posture, at=_seconds(at), picture=picture)
    for note in done.notes:
        click.echo(f"{click.style('Note:', fg='yellow')} {note}")
    click.echo(f"{done.address}: “{name}” at {done.at:g} s: {', '.join(shown(done.joints))}")
    if done.added:
        click.echo(f"New columns: {', '.join(done.added)}")
    click.echo(f"Check: {verdict(done.report)}")
    print_findings([d for d in done.report if d.address and d.address.sheet == done.address.sheet])
    if not done.report.errors:
        click.echo(f'Make it from a row: Output stream Gesture, with the formula "{name}".')


def _seconds(text: str) -> float | None:
    if not text:
        return None
    us = parse_duration(text, bare="s")
    if us is None or us == 0:
        raise click.BadParameter(f"“{text}” is no time. Write seconds, for example 1.5.", param_hint="--at")
    return us / 1e6
