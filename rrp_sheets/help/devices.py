"""`help devices`: what the robot senses and does; `help "Red ball"`: one device; `help "Say done"`."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.help.functions import literal_text
from rrp_sheets.help.layout import columns, entries, example, grids, heading, paragraph, titled
from rrp_sheets.model.durations import show_duration
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import argument_name
from rrp_sheets.robots import DeviceType, FoundDevice, Robot, Setting, load_robot

_SHOWN = 3  # further names of a device that are shown in the list
_TEST = "\n## Test\n"

DONE_EXAMPLE = example("done")


def all_devices() -> Iterator[str]:
    """The sensors and actuators, each with its help."""
    robot = load_robot()
    yield paragraph(
        "The devices of the robot, for the columns Input streams and Output stream and for the Devices sheet. "
        "`rrp-sheets help \"Red ball\"`, say, shows one with its fields and settings."
    )  # fmt: skip
    for kind in ("sensor", "actuator"):
        yield heading(f"{kind.capitalize()}s")
        found = (d for d in robot.devices.values() if d.kind == kind)
        yield entries((names[0], _listed(device, names)) for device in found if (names := _names(robot, device)))


def _names(robot: Robot, device: DeviceType) -> list[str]:
    return list(dict.fromkeys(f.name for f in robot.names.values() if f.type.name == device.name and f.offered))


def _listed(device: DeviceType, names: list[str]) -> str:
    others = names[1:]
    more = f" and {len(others) - _SHOWN} more" if len(others) > _SHOWN + 1 else ""
    shown = others[:_SHOWN] if more else others
    also = f" Also: {', '.join(shown)}{more}." if others else ""
    return f"{device.help}{also}"


def one_device(found: FoundDevice) -> Iterator[str]:
    """A device: what it gives or takes, and its settings."""
    device = found.type
    yield heading(f"{found.name} ({device.kind})")
    yield paragraph(device.help)
    if not device.simulated:
        yield paragraph("The simulated robot does not carry it out yet.")
    if device.payload is not None:
        name = argument_name(found.name)
        first = device.payload.fields[0].name
        yield paragraph(f"It gives a record; {name}.{first} is a field of it in a formula. The fields:")
        yield columns([(f.name, f.unit, literal_text(f.example), f.help) for f in device.payload.fields])
    elif device.kind == "sensor" and device.unit:
        yield paragraph(f"It gives a number ({device.unit}).")
    if device.takes:
        yield paragraph(f"It takes {device.takes}.")
    if device.kind == "actuator":
        yield paragraph(
            f"The stream “{found.name} done” tells when it has finished; a row can begin with that: "
            f'`rrp-sheets help "{found.name} done"`.'
        )
    if found.preset:
        names = {k: setting.name for k, setting in device.settings.items()}
        preset = ", ".join(f"{names.get(k, k)} = {v}" for k, v in found.preset.items())
        yield paragraph(f"The name {found.name} stands for {device.name} with {preset}.")
    if any(s.kind == "gesture" for s in device.settings.values()):
        yield titled("The robot's gestures", entries((g.name, f"{g.help}.") for g in load_robot().motions.values()))
        yield paragraph(
            "Gestures of your own stand in the sheet Gestures: a row for each keyframe, with Name, Time (s) and a "
            "column for each joint (0.5 is rad, 30° are degrees); `rrp-sheets pose` writes such rows from the robot's "
            "joints."
        )
    if any(s.kind == "posture" for s in device.settings.values()):
        yield paragraph(f"The postures: {', '.join(load_robot().postures)}.")
    settings = [s for k, s in device.settings.items() if k not in found.preset]
    if settings:
        found_settings = entries((s.name, described(s)) for s in settings)
        yield titled("Settings: columns of the Devices sheet", found_settings)
    if device.example:
        shown = device.example.partition(_TEST)[0]  # its test says nothing to who only wants to see how it is used
        title = shown.partition("\n")[0].lstrip("# ")
        yield titled(f"For example: {title}", *grids(shown), between="\n\n")


def done_stream(found: FoundDevice) -> Iterator[str]:
    """Explain `Say done`: the stream that an actuator gives at the end of each of its commands."""
    yield heading(f"{found.name} done (stream)")
    yield paragraph(
        f"Every actuator has a done stream, here that of {found.name}. It needs no declaring: write "
        f"“{found.name} done” among the Input streams. It gives a value at the end of every command, also of one that "
        "was broken off. An actuator with a name of its own on the Devices sheet has its done stream under that name: "
        "“Ask done” for Ask."
    )
    yield titled("Its fields", columns([(f.name, f.unit, f.help) for f in DONE.fields]))
    title = "For example: say hello, wait for two seconds, then turn the eyes red"
    yield titled(title, *grids(DONE_EXAMPLE), between="\n\n")


def described(setting: Setting) -> str:
    """Describe a setting: its purpose, its possible values, and the meaning of a blank cell."""
    parts = [setting.help[:1].upper() + setting.help[1:]]
    if setting.kind == "duration":
        parts.append("A number alone means seconds")
    if setting.choices:
        parts.append(f"One of {', '.join(setting.choices)}")
    unit = f" {setting.unit}" if setting.unit else ""
    if setting.lower is not None and setting.upper is not None:
        parts.append(f"From {setting.lower:g} to {setting.upper:g}{unit}")
    if setting.required:
        parts.append("It must be filled in")
    elif setting.default not in (None, ""):
        parts.append(f"Blank means {_default(setting)}{unit}")
    return ". ".join(part.rstrip(".") for part in parts) + "."


def _default(setting: Setting) -> str:
    if setting.kind == "duration" and isinstance(setting.default, int):
        return show_duration(setting.default)
    if isinstance(setting.default, bool):
        return str(setting.default).upper()
    return f"{setting.default:g}" if isinstance(setting.default, float) else str(setting.default)
