"""How fast the robot may move: of a gesture by its keyframes, of all else by the catalogue and the setting Speed."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence

from rrp_sheets.devices import Robot
from rrp_sheets.devices.gestures import Gesture
from rrp_sheets.devices.trajectory import Planner
from rrp_sheets.graph import Stream
from rrp_sheets.model.names import key
from rrp_sheets.model.values import show
from rrp_sheets.render.pack.source import Driver, Source

_SHARE = "of top speed"
_IN_PLACE = "wrist"  # a joint that turns the hand about itself: it is the fastest, and nothing goes anywhere by it
_ORDER = ("head", "left arm", "right arm", "legs", "eyes", "voice", "memory", "all")


def parts_of(source: Source, drivers: Sequence[Driver]) -> list[str]:
    """The parts of the robot that rows which drive one actuator stream use, the moving ones first."""
    stream = drivers[0].stream
    if stream.device is None:
        return []
    used = stream.device.type.resources_for(stream.settings)
    gestures = _gestures(source, drivers)
    if gestures:  # those that the values can name
        used = frozenset().union(*(stream.device.type.resources_for({"name": g.name}) for g in gestures))
    return sorted(used, key=lambda r: (r not in _ORDER, _ORDER.index(r) if r in _ORDER else 0, r))


def top_speed(source: Source, drivers: Sequence[Driver]) -> str:
    """How fast an actuator stream moves the robot at most, in words; empty when it moves nothing."""
    stream, robot = drivers[0].stream, source.checked.robot
    if stream.device is None:
        return ""
    settings = stream.device.type.settings
    if "forward" in settings:
        return _way(source, stream)
    gestures = _gestures(source, drivers)
    if gestures:
        return source.get("acts.speed", degrees=round(math.degrees(max(_fastest(robot, stream, g) for g in gestures))))
    fastest = max((robot.joints[key(j)].max_velocity for j in _joints(source, drivers)), default=0.0)
    if not fastest:
        return ""
    setting, share = settings.get("speed"), stream.settings.get("speed")
    if setting is not None and setting.unit == _SHARE and isinstance(share, (int, float)) and share < 1:
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


def _gestures(source: Source, drivers: Sequence[Driver]) -> list[Gesture]:
    """The gestures that a stream can be told to make; none when they are not all known."""
    stream, motions = drivers[0].stream, source.checked.robot.motions
    setting = stream.device.type.settings.get("name") if stream.device else None
    if setting is None or setting.kind != "gesture":
        return []
    names: list[object] = [stream.settings["name"]] if stream.settings.get("name") else []
    for driver in drivers if not names else ():
        fact = source.checked.facts.get(driver.step.ref)
        if fact is None or fact.known.choices is None:
            return []
        names += [name for name in fact.known.choices if name]
    found = [motions.get(key(name)) if isinstance(name, str) else None for name in names]
    return [g for g in found if g is not None] if None not in found else []


def _fastest(robot: Robot, stream: Stream, gesture: Gesture) -> float:
    """The largest speed (rad/s) that a gesture has, begun and ended in the posture in which runs begin."""
    tempo = stream.settings.get("tempo")
    start = dict(robot.data["postures"][robot.data["robot"]["start_posture"]])
    frames = gesture.timed(float(tempo) if isinstance(tempo, (int, float)) and tempo else None)
    ways = Planner(robot, start, start).plan(frames).ways
    moved = set(_through_the_room(robot, ways))
    return max(
        (way.fastest(i) for joint, way in ways.items() if joint in moved for i in range(len(way.times) - 1)),
        default=0.0,
    )


def _joints(source: Source, drivers: Sequence[Driver]) -> list[str]:
    """The joints that an actuator stream moves: those of its setting, or of all its parts."""
    robot = source.checked.robot
    named = key(str(drivers[0].stream.settings.get("joint") or ""))
    if named in robot.joints:
        return [robot.joints[named].name] if robot.joints[named].unit == "rad" else []
    if named in robot.groups:
        return _through_the_room(robot, robot.groups[named])
    chains = {chain for chain, part in robot.data["chains"].items() if part in parts_of(source, drivers)}
    return _through_the_room(robot, [j.name for j in robot.joints.values() if j.chain in chains])


def _through_the_room(robot: Robot, joints: Iterable[str]) -> list[str]:
    """The joints by which something moves through the room: not fingers, and not what turns the hand in its place."""
    return [j for j in joints if robot.joints[key(j)].unit == "rad" and _IN_PLACE not in key(j)]
