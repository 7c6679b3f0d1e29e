"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

from pathlib import Path

import click

from rrp_sheets.cli.language import spoken, translated
from rrp_sheets.cli.terminal import say, usage_error
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_, plural


@click.command(name="help")
@click.argument("topic", nargs=-1)
@click.option(
    "--html", "folder", type=click.Path(path_type=Path), metavar="DIR",
    help="write all help, in every language, as pages into the folder DIR",
)  # fmt: skip
def help_command(topic: tuple[str, ...], folder: Path | None) -> None:
    """Explain TOPIC: connectors, formulas, functions, devices, scene, tests, codes, or a name.

    A name can be a connector (sample), a function (CLAMP), a device (Red ball), a done stream (Say done), a code
    (FORM003), a command (replay), or helpers, Priority, total, Protocol, Engine, keys. A plain word (nod, undo, every
    second) shows what has to do with it. Without TOPIC you see an overview.

    The pages of --html need no server and no program: a laboratory can publish them.
    """
    from rrp_sheets.help.as_text import as_text
    from rrp_sheets.help.topics import text_on

    language = spoken()
    if folder is not None:
        _write(folder, topic, language)
        return
    name = " ".join(topic)
    here = click.get_current_context()
    above = here.parent or here
    commands = above.command if isinstance(above.command, click.Group) else click.Group()
    command = commands.get_command(above, name)
    context = None if command is None else command.context_class(command, info_name=name, parent=above)
    try:
        told = as_text(text_on(name, commands.list_commands(above), language), language)
        if context is not None and name != "help":
            also = N_("There is a command {name} too: rrp-sheets {name} --help", name=name)
            told += f"\n\n{translated(also)}"
    except SheetsError:
        if context is None:
            raise
        told = context.get_help()
    say(told)


def _write(folder: Path, topic: tuple[str, ...], language: str) -> None:
    from rrp_sheets.help.publishing import write_site

    if topic:
        raise usage_error(N_("--html writes all topics: leave TOPIC out."))
    count = write_site(folder)
    first = folder / language / "index.html"
    say(plural("{n} page is written. Open {path}", "{n} pages are written. Open {path}", n=count, path=first))
