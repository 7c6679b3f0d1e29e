"""`rrp-sheets faces [FOLDER]`."""

from __future__ import annotations

from pathlib import Path

import click


@click.command(name="faces")
@click.argument("folder", type=click.Path(path_type=Path), default=Path())
@click.option("--forget", metavar="NAME", help="Wipe this person's face.")
@click.option("--forget-all", is_flag=True, help="Wipe all of them.")
def command(folder: Path, forget: str | None, forget_all: bool) -> None:
    """List the faces that the robot remembers beyond a run, for the workbooks of FOLDER, or wipe them.

    They are kept only by workbooks whose Protocol says so (Face memory: kept), as numbers in runs/faces.json. Wipe when
    no run is going: it would write them again.
    """
    from rrp_sheets.runs import face_files

    if forget_all:
        click.echo(f"{face_files.forget_all(folder)} wiped.")
    elif forget is not None:
        click.echo(f"{face_files.forget(folder, forget)} is wiped.")
    else:
        names = face_files.kept(folder)
        click.echo("\n".join(names) if names else "No faces are kept here.")
