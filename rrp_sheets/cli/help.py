"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

import sys

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
    command_help = _command(name)
    try:
        told = "\n\n".join(text_on(name, _names()))
        if command_help is not None and name != "help":
            told += f"\n\nThere is a command {name} too: rrp-sheets {name} --help"
    except SheetsError:
        if command_help is None:
            raise
        told = command_help
    click.echo(told)
    sys.exit(0)


def _names() -> list[str]:
    """All commands."""
    above = click.get_current_context().parent
    return above.command.list_commands(above) if above and isinstance(above.command, click.Group) else []


def _command(name: str) -> str | None:
    """Return the help text of a command; None when there is no such command."""
    above = click.get_current_context().parent
    if name not in _names() or above is None or not isinstance(above.command, click.Group):
        return None
    command = above.command.get_command(above, name)
    return None if command is None else command.get_help(click.Context(command, info_name=name, parent=above))
