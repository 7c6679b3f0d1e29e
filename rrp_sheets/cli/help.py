"""`rrp-sheets help TOPIC`."""

from __future__ import annotations

import re
import sys
from collections.abc import Iterator

import click

from rrp_sheets.errors import SheetsError

TOPICS = ("connectors", "functions", "devices", "scene")


@click.command(name="help")
@click.argument("topic", nargs=-1)
def command(topic: tuple[str, ...]) -> None:
    """Explain TOPIC: connectors, functions, devices, scene, a code such as FORM007, or a name.

    A name is that of a connector (sample), a function (CLAMP), or a device (Red ball).
    """
    from rrp_sheets.model.names import key

    name = " ".join(topic)
    if not name:
        click.echo(f"Ask for one of: {', '.join(TOPICS)}, a code such as FORM007, or a name: rrp-sheets help sample")
        sys.exit(0)
    lists = {"connectors": _connectors, "functions": _functions, "devices": _devices, "scene": _scene}
    text = "\n".join(lists[key(name)]()) if key(name) in lists else _one(name)
    click.echo(text)
    sys.exit(0)


def _connectors() -> Iterator[str]:
    from rrp_sheets.connectors import connectors

    for connector in connectors():
        yield f"{connector.name:<15}{connector.help}"


def _functions() -> Iterator[str]:
    from rrp_sheets.formulas.functions import library

    seen = set()
    for function in library():
        if function.name not in seen:
            seen.add(function.name)
            yield f"{function.usage:<45} {function.help.splitlines()[0]}"


def _devices() -> Iterator[str]:
    from rrp_sheets.devices import load_robot

    robot = load_robot()
    for kind in ("sensor", "actuator"):
        yield f"{kind.capitalize()}s"
        for name in robot.device_names(kind):
            found = robot.find(name)
            assert found is not None
            yield f"  {name:<22}{found.type.help}"


def _scene() -> Iterator[str]:
    from rrp_sheets.devices.scene import thing_names, verb_names

    yield "A Scene row says when (seconds), which thing, does what, with which value."
    yield f"Things: {', '.join(thing_names())}, or the name of a person."
    yield f"They do: {', '.join(verb_names())}."
    yield "For example:"
    yield "  1     Red ball   appears      at 1, 0.2, 0.4    (metres: x ahead, y to the left, z up)"
    yield "  3     Red ball   moves        to 0.5, 0, 0.4 in 2 s"
    yield "  6     Red ball   circles      radius 0.2 around 0.8, 0, 0.4 period 4 s"
    yield "  9     Red ball   disappears"
    yield "  10    Mia        enters       at 1, 0"


def _one(name: str) -> str:
    from rrp_sheets.connectors import connectors
    from rrp_sheets.devices import load_robot
    from rrp_sheets.diagnostics import CODES
    from rrp_sheets.formulas.functions import library
    from rrp_sheets.model.names import nearest

    code = CODES.get(name.upper())
    if code is not None:
        message, remedy = (re.sub(r"\{\w+\}", "…", text) for text in (code.message, code.remedy))
        return f"{code.id} ({code.severity.value}): {code.title}\n\n{message}\n→ {remedy}"
    connector = connectors().get(name)
    if connector is not None:
        return f"{connector.name} ({connector.parameter.value})\n\n{connector.help}"
    function = library().get(name)
    if function is not None:
        return f"{function.usage}\n\n{function.help}"
    found = load_robot().find(name)
    if found is not None:
        device = found.type
        lines = [f"{found.name} ({device.kind})", "", device.help]
        if device.payload is not None:
            lines += ["", "Gives a record of:", *(f"  {f.name:<22}{f.help} {f'({f.unit})' if f.unit else ''}".rstrip()
                                                  for f in device.payload.fields)]  # fmt: skip
        if device.takes:
            lines += ["", f"Takes {device.takes}."]
        if device.settings:
            lines += ["", "Settings (columns of the Devices sheet):"]
            lines += [f"  {s.name:<22}{s.help}" for s in device.settings.values()]
        return "\n".join(lines)
    known = [*TOPICS, *connectors().names(), *library().names(), *(f.name for f in load_robot().names.values())]
    guess = nearest(name, known)
    raise SheetsError(
        f"There is no help on “{name}”.", f"Did you mean {guess}?" if guess else f"Try: {', '.join(TOPICS)}."
    )
