"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

import click

from rrp_sheets.errors import SheetsError


@click.command(name="help")
@click.argument("topic", nargs=-1)
def help_command(topic: tuple[str, ...]) -> None:
    """Explain TOPIC: connectors, formulas, functions, devices, scene, tests, codes, or a name.

    A name is that of a connector (sample), a function (CLAMP), a device (Red ball), a done stream (Say done), a finding
    of a check (FORM003), a command (replay), or helpers, Priority, total, Protocol, Engine, keys. Without TOPIC there
    is an overview.
    """
    from rrp_sheets.help.topics import text_on

    name = " ".join(topic)
    here = click.get_current_context()
    above = here.parent or here
    commands = above.command if isinstance(above.command, click.Group) else click.Group()
    command = commands.get_command(above, name)
    context = None if command is None else click.Context(command, info_name=name, parent=above)
    try:
        told = "\n\n".join(text_on(name, commands.list_commands(above)))
        if context is not None and name != "help":
            told += f"\n\nThere is a command {name} too: rrp-sheets {name} --help"
    except SheetsError:
        if context is None:
            raise
        told = context.get_help()
    click.echo(told)
