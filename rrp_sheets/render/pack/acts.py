"""Actions of the robot in the ethics pack: its texts, movements and speeds, and rows that compete for a part."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Sequence

from rrp_sheets.checks.speech_texts import OPEN
from rrp_sheets.graph import Stream
from rrp_sheets.model.names import key
from rrp_sheets.model.values import show
from rrp_sheets.render.pack.model import Act, Labelled, Rival, Said
from rrp_sheets.render.pack.movements import named_moves
from rrp_sheets.render.pack.source import Driver, Source, driver_refs
from rrp_sheets.render.style import clean
from rrp_sheets.robots import DeviceType, Robot
from rrp_sheets.robots.catalogue import Gesture
from rrp_sheets.robots.trajectory import Planner
from rrp_sheets.texts import capital

MOST_TEXTS = 60  # of one row
_CHOICE = re.compile("‹[^›]*›")
_FREE = frozenset({"memory", "all"})
_LEGS, _VOICE = "legs", "voice"
Lines = dict[tuple[tuple[str, ...], str], list[Driver]]
"""Rows by what they say or do, and by voice or stream."""


def says(source: Source) -> tuple[Said, ...]:
    """Return the texts that rows can say; rows that say the same in the same voice share a line."""
    lines: Lines = {}
    for driver in source.drivers:
        if not speaks(driver.stream) or driver.stops:
            continue
        assert driver.stream.device is not None
        says_its_setting = _says_its_setting(driver.stream.device.type)
        setting = str(driver.stream.settings.get("text") or "")
        texts = [setting] if says_its_setting else source.speech.texts_of(driver.step)
        if texts:
            line = tuple(clean(t) for t in texts), _voice(source, driver.stream)
            lines.setdefault(line, []).append(driver)
    return _in_lines(lines)


def _in_lines(lines: Lines) -> tuple[Said, ...]:
    return tuple(
        Said(driver_refs(drivers), texts[:MOST_TEXTS], max(0, len(texts) - MOST_TEXTS), voice)
        for (texts, voice), drivers in lines.items()
    )


def speaks(stream: Stream) -> bool:
    """Return whether an actuator stream lets the robot say a text."""
    return stream.device is not None and (stream.device.type.takes == "text" or _says_its_setting(stream.device.type))


def _says_its_setting(kind: DeviceType) -> bool:
    return _VOICE in kind.resources and "text" in kind.settings


def _voice(source: Source, stream: Stream) -> str:
    settings = stream.settings
    code = str(settings.get("language") or "")
    language = source.checked.robot.languages.get(code, code)
    if stream.device is not None:
        language = stream.device.type.words(source.words.language).value(language)
    entry = "says.voice_gestures" if _talks_with_its_arms(stream) else "says.voice"
    return source.get(entry, language=language, speed=show(settings.get("speed")), volume=show(settings.get("volume")))


def _talks_with_its_arms(stream: Stream) -> bool:
    """Return whether small gestures accompany the speech of an actuator stream."""
    return speaks(stream) and stream.settings.get("gestures") is True


def count_texts(said: Iterable[Said]) -> int:
    """Return how many different texts there can be; of `‹a | b›` each possibility counts.

    >>> count_texts([Said((), ("‹Hello ‹name› | Bye ‹name› | Hi›!", "Well done"), 0, "")])
    4
    """
    texts = (OPEN.sub("", text) for text in all_texts(said))
    return sum(math.prod(choice.count("|") + 1 for choice in _CHOICE.findall(text)) for text in texts)


def all_texts(said: Iterable[Said]) -> list[str]:
    """Return every text once, in order of appearance."""
    return list(dict.fromkeys(text for line in said for text in line.words))


def acts(source: Source) -> tuple[Act, ...]:
    """Return a line for every actuator stream that rows drive and that does not speak."""
    lines = []
    for drivers in by_stream(source).values():
        starting = next((d for d in drivers if not d.stops), drivers[0])
        does = capital(source.words.get("does.whole", does=source.rows.does(starting.step)))
        parts = source.words.listed([source.get(f"part.{r}") for r in parts_of(source, drivers)])
        name, used = clean(drivers[0].stream.name), driver_refs(drivers)
        lines.append(Act(name, does, parts, top_speed(source, drivers), used))
    return tuple(lines)


def by_stream(source: Source) -> dict[str, list[Driver]]:
    """Return the rows that drive each actuator stream, without those that let the robot speak."""
    found: dict[str, list[Driver]] = {}
    for driver in source.drivers:
        if not speaks(driver.stream):
            found.setdefault(driver.stream.id, []).append(driver)
    return found


def makes(source: Source) -> tuple[Said, ...]:
    """Return the gestures that rows can make and the postures that they can take, with their streams."""
    lines: Lines = {}
    for driver, kind, names in named_moves(source):
        assert driver.stream.device is not None
        words = driver.stream.device.type.words(source.words.language)
        if names:
            line = tuple(words.said(clean(name), kind) for name in names), clean(driver.stream.name)
            lines.setdefault(line, []).append(driver)
    return _in_lines(lines)


def moving_parts(source: Source) -> list[str]:
    """Return the parts of the body that rows can move."""
    drivers = [d for d in source.drivers if not d.stops]
    used = {r for d in drivers for r in parts_of(source, [d])}
    if any(_talks_with_its_arms(d.stream) for d in drivers):
        used |= {"left arm", "right arm"}
    return [r for r in ("head", "left arm", "right arm", _LEGS) if r in used]


def walkers(source: Source) -> list[str]:
    """Return the actuator streams that let the robot walk."""
    found = [d.stream for d in source.drivers if d.stream.device and "forward" in d.stream.device.type.settings]
    return list(dict.fromkeys(clean(s.name) for s in found))


def cautions(source: Source) -> tuple[Labelled, ...]:
    """Return the cautions about walking and falling."""
    get, walking = source.get, walkers(source)
    standing = [d for d in source.drivers if _LEGS in parts_of(source, [d]) and not d.stops]
    legs = dict.fromkeys(clean(d.stream.name) for d in standing)
    walks = get("caution.walks", list=source.quoted(walking)) if walking else get("caution.walks_not")
    still = "caution.falls_touched" if source.checked.study.is_touched else "caution.falls_not"
    falls = get("caution.falls", list=source.quoted(legs)) if legs else get(still)
    return (Labelled(get("caution.walking"), walks), Labelled(get("caution.falling"), falls))


def rivals(source: Source) -> tuple[Rival, ...]:
    """Return the parts that more than one row drives, with these rows by priority."""
    found: dict[str, list[Driver]] = {}
    for driver in source.drivers:
        if not driver.stops:
            for part in parts_of(source, [driver]):
                found.setdefault(part, []).append(driver)
    lines = []
    for part, drivers in found.items():
        if len(drivers) < 2 or part in _FREE:
            continue
        priorities = sorted({d.step.row.priority for d in drivers}, reverse=True)
        rows = tuple((f"{p:g}", driver_refs(d for d in drivers if d.step.row.priority == p)) for p in priorities)
        lines.append(Rival(source.get(f"part.{part}"), rows))
    return tuple(lines)


_SHARE = "of top speed"
_IN_PLACE = "wrist"  # a joint that turns the hand about itself: it is the fastest, and nothing goes anywhere by it
_ORDER = ("head", "left arm", "right arm", "legs", "eyes", "voice", "memory", "all")


def parts_of(source: Source, drivers: Sequence[Driver]) -> list[str]:
    """Return the parts of the robot that rows of one actuator stream use, the moving ones first."""
    stream = drivers[0].stream
    if stream.device is None:
        return []
    used = stream.device.type.resources_for(stream.settings)
    gestures = _gestures(source, drivers)
    if gestures:  # those that the values can name
        used = frozenset().union(*(stream.device.type.resources_for({"name": g.name}) for g in gestures))
    return sorted(used, key=lambda r: (r not in _ORDER, _ORDER.index(r) if r in _ORDER else 0, r))


def top_speed(source: Source, drivers: Sequence[Driver]) -> str:
    """Return the top speed at which an actuator stream moves the robot, in words; empty when it moves nothing."""
    stream = drivers[0].stream
    if stream.device is not None and "forward" in stream.device.type.settings:
        return _way(source, stream)
    fastest, joint = top_velocity(source, drivers)
    if not joint:
        return ""
    share = 1.0 if _gestures(source, drivers) else _share(stream)
    entry = "acts.share" if share < 1 else "acts.speed"
    words = joint_name(source, joint)
    return source.get(entry, degrees=show_speed(fastest), percent=round(share * 100), joint=words)


_JOINT = re.compile("(?P<side>[LR]?)(?P<part>Head|Shoulder|Elbow|Hip|Knee|Ankle)")


def joint_name(source: Source, joint: str) -> str:
    """Return where a joint is, `left shoulder` of `LShoulderRoll`; its name when that is not known."""
    if not (found := _JOINT.match(joint)):
        return clean(joint)
    side = source.get(f"joint.{found['side']}") if found["side"] else ""
    return source.get(f"joint.{found['part']}", side=side)


def show_speed(velocity: float) -> int:
    """Return a speed (rad/s) in degrees a second, rounded up: it is the most that there can be."""
    return math.ceil(math.degrees(velocity) - 1e-6)


def top_velocity(source: Source, drivers: Sequence[Driver]) -> tuple[float, str]:
    """Return the top speed (rad/s) of the joints that an actuator stream moves, and the fastest of them."""
    stream, robot = drivers[0].stream, source.checked.robot
    if stream.device is None or "forward" in stream.device.type.settings:
        return 0.0, ""  # walking aside
    if gestures := _gestures(source, drivers):
        return max(_fastest(robot, stream, g) for g in gestures)
    share, joints = _share(stream), _joints(source, drivers)
    return max(((robot.joints[key(j)].max_velocity * share, j) for j in joints), default=(0.0, ""))


def _share(stream: Stream) -> float:
    """Return the share of the top speed that a stream's setting allows."""
    setting = stream.device.type.settings.get("speed") if stream.device else None
    share = stream.settings.get("speed")
    if setting is None or setting.unit != _SHARE or not isinstance(share, (int, float)):
        return 1.0
    return min(float(share), 1.0)


def _way(source: Source, stream: Stream) -> str:
    """Return how far one command lets the robot walk: its settings, or their bounds when the value decides."""
    assert stream.device is not None
    settings = stream.device.type.settings
    values = {name: stream.settings.get(name) for name in ("forward", "left", "turn")}
    if not any(values.values()):
        values = {name: settings[name].upper for name in values}
    far = {n: abs(v) if isinstance(v, (int, float)) else 0.0 for n, v in values.items()}
    turn = round(math.degrees(far["turn"]))
    return source.get("acts.walks", forward=show(far["forward"]), left=show(far["left"]), turn=turn)


def _gestures(source: Source, drivers: Sequence[Driver]) -> list[Gesture]:
    """Return the gestures that a stream can be told to make; none when they are not all known."""
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
    standard = [source.checked.robot.standard("Gesture", name) for name in names]
    found = [motions.get(key(name)) if isinstance(name, str) else None for name in standard]
    return [g for g in found if g is not None] if None not in found else []


def _fastest(robot: Robot, stream: Stream, gesture: Gesture) -> tuple[float, str]:
    """Return the top speed (rad/s) of a gesture, begun and ended in the posture in which runs begin, and the joint."""
    tempo = stream.settings.get("tempo")
    start = dict(robot.data["postures"][robot.data["robot"]["start_posture"]])
    frames = gesture.timed(float(tempo) if isinstance(tempo, (int, float)) and tempo else None)
    ways = Planner(robot, start, start).plan(frames).ways
    moved = set(_through_the_room(robot, ways))
    pieces = [(j, way, i) for j, way in ways.items() if j in moved for i in range(len(way.times) - 1)]
    return max(((way.fastest(i), joint) for joint, way, i in pieces), default=(0.0, ""))


def _joints(source: Source, drivers: Sequence[Driver]) -> list[str]:
    """Return the joints that an actuator stream moves: those of its setting, or of all its parts."""
    robot = source.checked.robot
    named = key(str(drivers[0].stream.settings.get("joint") or ""))
    if named in robot.joints:
        return [robot.joints[named].name] if robot.joints[named].unit == "rad" else []
    if named in robot.groups:
        return _through_the_room(robot, robot.groups[named])
    chains = {chain for chain, part in robot.data["chains"].items() if part in parts_of(source, drivers)}
    return _through_the_room(robot, [j.name for j in robot.joints.values() if j.chain in chains])


def _through_the_room(robot: Robot, joints: Iterable[str]) -> list[str]:
    """Return the joints that move a limb or the head: not fingers, and not those that turn the hand in place."""
    return [j for j in joints if robot.joints[key(j)].unit == "rad" and _IN_PLACE not in key(j)]
