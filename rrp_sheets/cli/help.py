"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

import sys

import click


@click.command(name="help")
@click.argument("topic", nargs=-1)
def command(topic: tuple[str, ...]) -> None:
    """Explain TOPIC: connectors, formulas, functions, devices, scene, tests, codes, or a name.

    A name is that of a connector (sample), a function (CLAMP), a device (Red ball), a done stream (Say done), a finding
    of a check (FORM003), or helpers, Priority, total, Protocol, Engine, keys. Without TOPIC there is an overview.
    """
    from rrp_sheets.topics.finding import text_on

    click.echo("\n\n".join(text_on(" ".join(topic))))
    sys.exit(0)
