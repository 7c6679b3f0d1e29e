"""`rrp-sheets run FILE`."""

from __future__ import annotations

import json
import signal
import sys
import threading
from pathlib import Path
from types import FrameType

import click

from rrp_sheets.cli.bundled import Workbook, home_of
from rrp_sheets.cli.main import BROKEN, INTERRUPTED
from rrp_sheets.cli.watch import Watch
from rrp_sheets.model.durations import parse_duration


@click.command(name="run")
@click.argument("file", type=Workbook())
@click.option(
    "--for",
    "duration",
    default="",
    help="how long, for example 20s or 2 min  [default: the end of the scene and 5 s more; 30 s without]",
)
@click.option("--fast", is_flag=True, help="as fast as the machine can, instead of in real time")
@click.option("--out", type=click.Path(path_type=Path), help="the folder to leave everything in")
@click.option("--json", "as_json", is_flag=True, help="print a summary as JSON on the last line")
@click.option("--seed", type=int, help="of everything random; the Protocol's otherwise")
@click.option("--mode", type=click.Choice(["simulated", "pilot"]), default="simulated", show_default=True,
              help="pilot: a rehearsal whose data never counts as a session")  # fmt: skip
@click.option(
    "--no-camera", is_flag=True, help="keep no picture of the robot's camera  [default: as the Protocol says]"
)
@click.option("--participant", default="", help="the participant's code")
@click.option("--condition", default="", help="the experimental condition")
@click.option("--operator", default="", help="who operates the session")
def command(
    file: Path, duration: str, fast: bool, out: Path | None, as_json: bool, seed: int | None, mode: str,
    no_camera: bool, participant: str, condition: str, operator: str,
) -> None:  # fmt: skip
    """Check FILE, run it on the simulated robot, and leave a folder with all there is to see of the run.

    Shown as it happens: what the robot says and does, and what goes wrong. Ctrl-C stops the run in order.

    Exit code: 0 the run came to its end, 1 the workbook has errors, 2 it cannot be read, 3 the run broke off,
    130 stopped with Ctrl-C.
    """
    from rrp_sheets import api
    from rrp_sheets.cli.check import print_findings

    settings = api.RunSettings(
        home=home_of(click.get_current_context()),
        seconds=_seconds(duration), fast=fast, out=out, seed=seed, mode=mode, participant=participant,
        condition=condition, operator=operator, camera=not no_camera,
    )  # fmt: skip
    watch = Watch()
    _stop_on_interrupt(watch)
    ended = api.run_apart(file, settings, watch)
    result = ended.result
    if result is None and watch.interrupted:
        sys.exit(INTERRUPTED)
    if result is None:
        print_findings(ended.findings, err=True)
        click.echo("The workbook has errors, so the run does not begin.", err=True)
        if as_json:
            click.echo(json.dumps({"findings": [d.as_dict() for d in ended.findings]}, ensure_ascii=False))
        sys.exit(1)
    watch.ended(result)
    if as_json:
        summary = {"folder": str(result.folder), **result.summary.as_dict(wall=True)}
        if result.broken is not None:
            summary["broken"] = result.broken.message
        click.echo(json.dumps(summary, ensure_ascii=False))
    if result.broken is not None:
        sys.exit(BROKEN)
    sys.exit(INTERRUPTED if watch.interrupted else 0)


def _seconds(text: str) -> float | None:
    if not text:
        return None
    us = parse_duration(text, bare="s")
    if not us:
        raise click.BadParameter(f"“{text}” is not a duration; write for example 20s or 2 min.", param_hint="--for")
    return us / 1e6


def _stop_on_interrupt(watch: Watch) -> None:
    """Ctrl-C (or a polite kill) asks the run to stop: the robot halts at once, and everything is written."""
    if threading.current_thread() is not threading.main_thread():
        return

    def ask(number: int, frame: FrameType | None) -> None:
        watch.interrupted = True

    signal.signal(signal.SIGINT, ask)
    signal.signal(signal.SIGTERM, ask)
    if hasattr(signal, "SIGHUP"):  # the terminal's window was closed
        signal.signal(signal.SIGHUP, ask)
