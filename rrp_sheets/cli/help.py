"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

import click

from rrp_sheets.cli.language import translated
from rrp_sheets.cli.terminal import say
from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_


@click.command(name="help")
@click.argument("topic", nargs=-1)
def help_command(topic: tuple[str, ...]) -> None:
    """Explain TOPIC: connectors, formulas, functions, devices, scene, tests, codes, or a name.

    A name can be a connector (sample), a function (CLAMP), a device (Red ball), a done stream (Say done), a code
    (FORM003), a command (replay), or helpers, Priority, total, Protocol, Engine, keys. Without TOPIC you see an
    overview.
    """
    from rrp_sheets.help.topics import text_on

    name = " ".join(topic)
    here = click.get_current_context()
    above = here.parent or here
    commands = above.command if isinstance(above.command, click.Group) else click.Group()
    command = commands.get_command(above, name)
    context = None if command is None else command.context_class(command, info_name=name, parent=above)
    try:
        told = [*text_on(name, commands.list_commands(above))]
        if context is not None and name != "help":
            more = N_("There is a command {name} too: rrp-sheets {name} --help", name=name)
            told.append(more)
    except SheetsError:
        if context is None:
            raise
        told = [context.get_help()]
    say("\n\n".join(map(translated, told)))
