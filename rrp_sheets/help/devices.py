"""`help devices`: what the robot senses and does; `help "Red ball"`: one device; `help "Say done"`."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.help.functions import literal_text
from rrp_sheets.help.layout import Block, columns, entries, example, heading, paragraph, titled, workbook
from rrp_sheets.model import japanese
from rrp_sheets.model.durations import show_duration
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import argument_name
from rrp_sheets.robots import DeviceType, FoundDevice, Robot, Setting, load_robot
from rrp_sheets.texts import N_, capital, listed, sentences

_SHOWN = 3  # further names of a device that are shown in the list
_TEST = "\n## Test\n"
DONE_EXAMPLE = example("done")


def all_devices(language: str = "en") -> Iterator[Block]:
    """Yield the sensors and actuators, each with its help."""
    robot = load_robot()
    yield paragraph(N_("The devices of the robot. Use them in the columns Input streams and Output stream, and on the "
                       "Devices sheet. For one with its fields and settings: `rrp-sheets help "
                       '"Red ball"`.'))  # fmt: skip
    yield paragraph(N_("On the Devices sheet each setting has a column, with the setting's name as its header. To add "
                       "one in the grid, right-click a header and choose “Add a column …”."))  # fmt: skip
    for kind, title in (("sensor", N_("Sensors")), ("actuator", N_("Actuators"))):
        yield heading(title)
        found = ((d, names_of(robot, d, language)) for d in robot.devices.values() if d.kind == kind)
        yield entries((japanese.in_both(japanese.DEVICES, n[0], language), _listed(d, n)) for d, n in found if n)


def names_of(robot: Robot, device: DeviceType, language: str = "en") -> list[str]:
    """Return the names under which a device is offered; in Japanese the one that has a Japanese name comes first."""
    names = dict.fromkeys(f.name for f in robot.names.values() if f.type.name == device.name and f.offered)
    return sorted(names, key=lambda name: language == "ja" and name != device.title)


def _listed(device: DeviceType, names: list[str]) -> str:
    others = names[1:]
    about = device_help(device)
    if not others:
        return about
    if len(others) > _SHOWN + 1:
        shown, more = ", ".join(others[:_SHOWN]), len(others) - _SHOWN
        return N_("{before} {after}", before=about, after=N_("Also: {names} and {n} more.", names=shown, n=more))
    return N_("{before} {after}", before=about, after=N_("Also: {names}.", names=", ".join(others)))


def device_help(device: DeviceType) -> str:
    """Return what a device does, as a message."""
    return N_(device.help, msgctxt=f"{device.name}.help")


def one_device(found: FoundDevice, language: str = "en") -> Iterator[Block]:
    """Yield a device: what it gives or takes, its settings, and an example that is written in a language."""
    device, name = found.type, found.name
    main = device.title if language == "ja" and not found.preset else name
    own = japanese.word_in(japanese.DEVICES, main, language)  # as streams are called
    title = N_("{name} (sensor)" if device.kind == "sensor" else "{name} (actuator)",
               name=japanese.in_both(japanese.DEVICES, main, language))  # fmt: skip
    yield heading(title, name.replace(" ", "-"))
    yield paragraph(device_help(device))
    if not device.simulated:
        yield paragraph(N_("The simulated robot does not carry it out yet."))
    if device.payload is not None:
        about = f"{device.name}."
        fields = [
            (japanese.in_both(japanese.FIELDS, f.name, language), f.unit, literal_text(f.example),
             N_(f.help, msgctxt=about + f.name))
            for f in device.payload.fields
        ]  # fmt: skip
        field = f"{argument_name(own)}.{japanese.word_in(japanese.FIELDS, device.payload.fields[0].name, language)}"
        yield paragraph(N_("It gives a record. In a formula, {field} is one of its fields. The fields:", field=field))
        yield columns([(N_("Field"), N_("Unit"), N_("Example"), N_("Meaning")), *fields], headed=True)
    elif device.kind == "sensor" and device.unit:
        yield paragraph(N_("It gives a number ({unit}).", unit=device.unit))
    if device.takes:
        yield paragraph(N_("It takes {what}.", what=N_(device.takes, msgctxt=f"{device.name}.takes")))
    if device.kind == "actuator":
        yield paragraph(N_("The stream “{name} done” tells when it has finished. A row can begin with that: "
                           '`rrp-sheets help "{name} done"`.', name=own))  # fmt: skip
    if found.preset:
        names = {k: japanese.in_both(japanese.SETTINGS, s.name, language) for k, s in device.settings.items()}
        preset = ", ".join(f"{names.get(k, k)} = {v}" for k, v in found.preset.items())
        kind = japanese.in_both(japanese.DEVICES, device.title, language)
        yield paragraph(N_("The name {name} means {device} with {settings}.", name=name, device=kind, settings=preset))
    if any(s.kind == "gesture" for s in device.settings.values()):
        gestures = load_robot().motions.values()
        made = ((N_(g.name, msgctxt="posture"), N_(g.help, msgctxt="gesture")) for g in gestures)
        yield titled(N_("The robot's gestures"), entries(made))
        yield paragraph(N_("You can make your own gestures on the sheet Gestures: a row for each keyframe, with "
                           "Name, Time (s) and a column for each joint (0.5 is rad, 30° are degrees). `rrp-sheets "
                           "pose` writes such rows from the robot's joints."))  # fmt: skip
    if any(s.kind == "posture" for s in device.settings.values()):
        postures = listed([N_(name, msgctxt="posture") for name in load_robot().postures])
        yield paragraph(N_("The postures: {names}.", names=postures))
    settings = [s for k, s in device.settings.items() if k not in found.preset]
    if settings:
        found_settings = entries(
            (japanese.in_both(japanese.SETTINGS, s.name, language), described(s)) for s in settings
        )
        yield titled(N_("Settings: columns of the Devices sheet"), found_settings)
    if device.example:
        shown = device.example.partition(_TEST)[0]  # its test says nothing to who only wants to see how it is used
        about = N_(shown.partition("\n")[0].lstrip("# "), msgctxt="example")
        yield titled(N_("For example: {about}", about=about), workbook(name, shown, language))


def done_stream(found: FoundDevice, language: str = "en") -> Iterator[Block]:
    """Explain `Say done`: the stream that an actuator gives at the end of each of its commands."""
    name = japanese.word_in(japanese.DEVICES, found.name, language)
    yield heading(N_("{name} (stream)", name=f"{name} done"), f"{found.name} done".replace(" ", "-"))
    yield paragraph(N_("Every actuator has a done stream. This is the one of {name}. You need not declare it: write "
                       "“{name} done” among the Input streams. It gives a value at the end of every command, also "
                       "of one that was stopped. An actuator with its own name on the Devices sheet has its done "
                       "stream under that name: “Ask done” for Ask.", name=name))  # fmt: skip
    fields = [
        (japanese.in_both(japanese.FIELDS, f.name, language), f.unit, N_(f.help, msgctxt="done")) for f in DONE.fields
    ]
    yield titled(N_("Its fields"), columns([(N_("Field"), N_("Unit"), N_("Meaning")), *fields], headed=True))
    about = N_("say hello, wait for two seconds, then turn the eyes red")
    yield titled(N_("For example: {about}", about=about), workbook("Say done", DONE_EXAMPLE, language))


def described(setting: Setting) -> str:
    """Describe a setting: its purpose, its possible values, and the meaning of a blank cell."""
    parts = [N_("{text}.", text=capital(N_(setting.help, msgctxt="setting's help")))]
    if setting.kind == "duration":
        parts.append(N_("A number alone means seconds."))
    if setting.choices:
        parts.append(N_("One of {names}.", names=listed([N_(c, msgctxt="value") for c in setting.choices])))
    unit = N_(setting.unit, msgctxt="value") if " " in setting.unit else setting.unit
    if setting.lower is not None and setting.upper is not None:
        parts.append(N_("From {low} to {high}.", low=f"{setting.lower:g}", high=_measured(f"{setting.upper:g}", unit)))
    if setting.required:
        parts.append(N_("It must be filled in."))
    elif setting.kind == "language":
        parts.append(
            N_("Blank means {value}, or ja where the headers of the workbook are Japanese.", value=_default(setting))
        )
    elif setting.default not in (None, ""):
        parts.append(N_("Blank means {value}.", value=_measured(_default(setting), unit)))
    return sentences(*parts)


def _measured(number: str, unit: str) -> str:
    return N_("{number} {unit}", number=number, unit=unit) if unit else number


def _default(setting: Setting) -> str:
    if setting.kind == "duration" and isinstance(setting.default, int):
        return show_duration(setting.default)
    if isinstance(setting.default, bool):
        return str(setting.default).upper()
    if setting.choices:
        return N_(str(setting.default), msgctxt="value")
    return f"{setting.default:g}" if isinstance(setting.default, float) else str(setting.default)
