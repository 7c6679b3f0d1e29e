"""What the robot may do: its texts, its movements and their speeds, and what happens when two rows compete."""

from __future__ import annotations

import math
from collections.abc import Iterable

from rrp_sheets.devices import DeviceType, Robot
from rrp_sheets.graph import Stream
from rrp_sheets.model.names import key
from rrp_sheets.model.values import show
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack.model import Act, Labelled, Rival, Said
from rrp_sheets.render.pack.source import Driver, Source, capital, driver_refs

MOST_TEXTS = 60  # of one row
_FREE = frozenset({"memory", "all"})
_LEGS, _VOICE = "legs", "voice"
_SHARE = "of top speed"


def says(source: Source) -> tuple[Said, ...]:
    """The texts that rows can say; rows that say the same in the same voice share a line."""
    lines: dict[tuple[tuple[str, ...], str], list[Driver]] = {}
    for driver in source.drivers:
        if speaks(driver.stream) and not driver.stops:
            texts = tuple(clean(t) for t in _texts(source, driver))
            if texts:
                lines.setdefault((texts, _voice(source, driver.stream)), []).append(driver)
    return tuple(
        Said(driver_refs(drivers), texts[:MOST_TEXTS], max(0, len(texts) - MOST_TEXTS), voice)
        for (texts, voice), drivers in lines.items()
    )


def speaks(stream: Stream) -> bool:
    """Whether an actuator stream lets the robot say a text."""
    return stream.device is not None and (stream.device.type.takes == "text" or _says_its_setting(stream.device.type))


def _says_its_setting(kind: DeviceType) -> bool:
    return _VOICE in kind.resources and "text" in kind.settings


def _texts(source: Source, driver: Driver) -> list[str]:
    assert driver.stream.device is not None
    if _says_its_setting(driver.stream.device.type):
        return [str(driver.stream.settings.get("text") or "")]
    return source.speech.texts_of(driver.step)


def _voice(source: Source, stream: Stream) -> str:
    settings = stream.settings
    code = str(settings.get("language") or "")
    language = source.checked.robot.languages.get(code, code)
    if stream.device is not None:
        language = stream.device.type.words(source.words.language).value(language)
    return source.get(
        "says.voice", language=language, speed=show(settings.get("speed")), volume=show(settings.get("volume"))
    )


def all_texts(said: Iterable[Said]) -> list[str]:
    """Every text once."""
    return list(dict.fromkeys(text for line in said for text in line.words))


def acts(source: Source) -> tuple[Act, ...]:
    """A line for every other actuator stream that rows drive."""
    by_stream: dict[str, list[Driver]] = {}
    for driver in source.drivers:
        if not speaks(driver.stream):
            by_stream.setdefault(driver.stream.id, []).append(driver)
    return tuple(_act(source, drivers) for drivers in by_stream.values())


def _act(source: Source, drivers: list[Driver]) -> Act:
    stream = drivers[0].stream
    starting = next((d for d in drivers if not d.stops), drivers[0])
    parts = [source.get(f"part.{r}") for r in _uses(stream)] if stream.device else []
    does = capital(source.words.get("does.whole", does=source.rows.does(starting.step)))
    return Act(clean(stream.name), does, source.listed(parts), _speed(source, stream), driver_refs(drivers))


def _uses(stream: Stream) -> list[str]:
    """The parts of the robot that an actuator stream uses, the moving ones first."""
    if stream.device is None:
        return []
    order = ("head", "left arm", "right arm", _LEGS, "eyes", _VOICE, "memory", "all")
    return sorted(stream.device.type.resources_for(stream.settings), key=lambda r: (r not in order, order.index(r)))


def _speed(source: Source, stream: Stream) -> str:
    robot, kind = source.checked.robot, stream.device.type if stream.device else None
    if kind is None:
        return ""
    if "forward" in kind.settings:
        return _way(source, stream)
    fastest = max((robot.joints[key(j)].max_velocity for j in _joints(robot, stream)), default=0.0)
    if not fastest:
        return ""
    setting = kind.settings.get("speed")
    share = stream.settings.get("speed") if setting is not None and setting.unit == _SHARE else None
    if isinstance(share, (int, float)) and share < 1:
        degrees = round(math.degrees(fastest * share))
        return source.get("acts.share", degrees=degrees, percent=round(share * 100))
    return source.get("acts.speed", degrees=round(math.degrees(fastest)))


def _way(source: Source, stream: Stream) -> str:
    """How far one command lets it walk: its settings, or their bounds when the value decides."""
    assert stream.device is not None
    settings = stream.device.type.settings
    values = {name: stream.settings.get(name) for name in ("forward", "left", "turn")}
    if not any(values.values()):
        values = {name: settings[name].upper for name in values}
    far = {n: abs(v) if isinstance(v, (int, float)) else 0.0 for n, v in values.items()}
    turn = round(math.degrees(far["turn"]))
    return source.get("acts.walks", forward=show(far["forward"]), left=show(far["left"]), turn=turn)


def _joints(robot: Robot, stream: Stream) -> list[str]:
    """The joints that an actuator stream moves: those of its setting, of its gesture, or of all its parts."""
    named = key(str(stream.settings.get("joint") or ""))
    if named in robot.joints:
        moved = [robot.joints[named].name]
    elif named in robot.groups:
        moved = list(robot.groups[named])
    elif (gesture := robot.motions.get(key(str(stream.settings.get("name") or "")))) is not None and _is_gesture(
        stream
    ):
        moved = list(gesture.joints)
    else:
        chains = {chain for chain, part in robot.data["chains"].items() if part in _uses(stream)}
        moved = [j.name for j in robot.joints.values() if j.chain in chains]
    return [name for name in moved if robot.joints[key(name)].unit == "rad"]


def _is_gesture(stream: Stream) -> bool:
    setting = stream.device.type.settings.get("name") if stream.device else None
    return setting is not None and setting.kind == "gesture"


def moving_parts(source: Source) -> list[str]:
    """The parts of the body that rows can move."""
    used = {r for d in source.drivers if not d.stops for r in _uses(d.stream)}
    return [r for r in ("head", "left arm", "right arm", _LEGS) if r in used]


def walkers(source: Source) -> list[str]:
    """The actuator streams that let the robot walk."""
    found = [d.stream for d in source.drivers if d.stream.device and "forward" in d.stream.device.type.settings]
    return list(dict.fromkeys(clean(s.name) for s in found))


def cautions(source: Source) -> tuple[Labelled, ...]:
    """Whether it walks, and whether it could fall."""
    get, walking = source.get, walkers(source)
    legs = list(dict.fromkeys(clean(d.stream.name) for d in source.drivers if _LEGS in _uses(d.stream) and not d.stops))
    walks = get("caution.walks", list=source.quoted(walking)) if walking else get("caution.walks_not")
    falls = get("caution.falls", list=source.quoted(legs)) if legs else get("caution.falls_not")
    return (Labelled(get("caution.walking"), walks), Labelled(get("caution.falling"), falls))


def rivals(source: Source) -> tuple[Rival, ...]:
    """The parts that more than one row drives, with these rows by priority."""
    found: dict[str, list[Driver]] = {}
    for driver in source.drivers:
        if not driver.stops:
            for part in _uses(driver.stream):
                found.setdefault(part, []).append(driver)
    lines = []
    for part, drivers in found.items():
        if len(drivers) < 2 or part in _FREE:
            continue
        priorities = sorted({d.step.row.priority for d in drivers}, reverse=True)
        rows = tuple((f"{p:g}", driver_refs(d for d in drivers if d.step.row.priority == p)) for p in priorities)
        lines.append(Rival(source.get(f"part.{part}"), rows))
    return tuple(lines)
