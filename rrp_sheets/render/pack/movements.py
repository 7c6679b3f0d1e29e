"""Gestures and postures in the ethics pack: their drawings in key poses, how far they go and how long they take."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from rrp_sheets.model.names import key
from rrp_sheets.render.pack.model import DrawnMovement
from rrp_sheets.render.pack.source import Driver, Source
from rrp_sheets.render.style import clean
from rrp_sheets.resources import bundled
from rrp_sheets.robots import Robot
from rrp_sheets.robots.trajectory import CALM, BodyPose, JointPlan, Planner, posture_frames
from rrp_sheets.texts import N_, capital, translate

Draw = Callable[[Robot, Sequence[Sequence[BodyPose]]], Sequence[Sequence[str]]]
"""Draws poses of a robot, strip by strip, as SVG texts."""
MOST = 40  # movements
_UNLIKE = 0.8  # rad: a third pose is drawn if it differs from the others by more, in the sum of all joints
_LEAST = 5  # degrees: movements of a part by less are left out
_UPRIGHT = 0.5  # rad: a robot that would lean further does not stand on its soles
_SAMPLES = 20  # per second: poses in which a movement is measured


def movements(source: Source, pictures: dict[str, str], draw: Draw | None) -> tuple[DrawnMovement, ...]:
    """Return the known gestures and postures that rows can make; `draw` adds their drawings to the pictures."""
    robot, found = source.checked.robot, list(_planned(source).values())[:MOST]
    ours = robot.folder == bundled("robots", robot.name)  # another model is a stranger's file
    strips = draw(robot, [poses for _, _, poses in found]) if draw and ours and found else [() for _ in found]
    made = []
    for n, ((name, text, _), strip) in enumerate(zip(found, strips, strict=True), 1):
        names = tuple(f"pose-{n}-{k}.svg" for k in range(1, len(strip) + 1))
        pictures |= dict(zip(names, strip, strict=True))
        made.append(DrawnMovement(name, text, names))
    return tuple(made)


def named_moves(source: Source) -> Iterator[tuple[Driver, str, list[str]]]:
    """Yield the rows that make gestures or take postures, `gesture` or `posture`, and the names as far as known."""
    for driver in source.drivers:
        device = driver.stream.device
        setting = device.type.settings.get("name") if device else None
        if driver.stops or setting is None or setting.kind not in ("gesture", "posture"):
            continue
        fixed = driver.stream.settings.get("name")
        yield driver, setting.kind, [str(fixed)] if fixed else source.speech.texts_of(driver.step)


def _planned(source: Source) -> dict[object, tuple[str, str, list[BodyPose]]]:
    """Return the name, the description and the key poses of each movement, once for each tempo, speed and count."""
    robot, made = source.checked.robot, dict[object, tuple[str, str, list[BodyPose]]]()
    own = {key(frame.name.text) for frame in source.checked.workbook.gestures}
    first = str(robot.data["robot"]["start_posture"])
    start = {joint: float(angle) for joint, angle in robot.data["postures"][first].items()}
    for driver, kind, names in named_moves(source):
        assert driver.stream.device is not None
        words, settings = driver.stream.device.type.words(source.words.language), driver.stream.settings
        tempo, times, speed = (_number(settings.get(name)) for name in ("tempo", "times", "speed"))
        for name in (str(robot.standard("Gesture", name)) for name in names):
            gesture, lean, help_text = robot.motions.get(key(name)), 0.0, ""
            posture = next((p for p in robot.postures if key(p) == key(name)), "")
            if kind == "gesture" and gesture is not None:
                plan = Planner(robot, start, start).plan(gesture.timed(tempo, max(1, round(times or 1))))
                shown = gesture.name
                if key(name) not in own:
                    help_text = translate(N_(gesture.help, msgctxt="gesture"), source.words.language)
            elif kind == "posture" and posture:
                frames, share = posture_frames(robot, first, posture), speed or 1.0
                plan = Planner(robot, start, share=share, peak=CALM * share).plan(frames)
                shown, lean = posture, float(robot.data.get("posture_leans", {}).get(posture, 0.0))
            else:
                continue
            if (which := (kind, key(shown), tempo, times, speed)) not in made:
                about = _described(source, plan, start, help_text)
                made[which] = words.said(clean(shown), kind), about, _key_poses(plan, start, lean, kind == "posture")
    return made


def _number(value: object) -> float | None:
    return float(value) if isinstance(value, (int, float)) and value else None


def _key_poses(plan: JointPlan, start: Mapping[str, float], lean: float, stays: bool) -> list[BodyPose]:
    """Return two or three poses in order: the start, the pose farthest from it, and one that is unlike both.

    If the robot `stays` in the last pose, that one takes the place of the farthest.
    """
    frames = _poses(plan, start, plan.times)

    def apart(one: Mapping[str, float], other: Mapping[str, float]) -> float:
        return math.fsum(abs(one[j] - other[j]) for j in plan.ways if "Hand" not in j)

    chosen: list[Mapping[str, float]] = [start]
    if frames:
        chosen.append(frames[-1] if stays else max(frames, key=lambda frame: apart(frame, start)))
        other = max(frames, key=lambda frame: min(apart(frame, one) for one in chosen))
        if min(apart(other, one) for one in chosen) > _UNLIKE:
            chosen.insert(1 + (frames.index(other) > frames.index(chosen[1])), other)
    last = chosen[-1]
    return [(pose, lean if pose is last and lean else _lean(pose)) for pose in chosen]


def _poses(plan: JointPlan, start: Mapping[str, float], times: Sequence[float]) -> list[Mapping[str, float]]:
    return [{**start, **{joint: way.at(time)[0] for joint, way in plan.ways.items()}} for time in times]


def _lean(joints: Mapping[str, float]) -> float:
    """Return how far the torso leans forward (rad) with the soles flat on the floor; 0 if it cannot stand like that."""
    lean = -math.fsum(joints.get(f"L{joint}Pitch", 0.0) for joint in ("Hip", "Knee", "Ankle"))
    return lean if abs(lean) <= _UPRIGHT else 0.0


def _described(source: Source, plan: JointPlan, start: Mapping[str, float], help_text: str) -> str:
    get, moments = source.get, max(1, math.ceil(plan.length * _SAMPLES))
    poses = _poses(plan, start, [plan.length * k / moments for k in range(moments + 1)])
    degrees = dict[str, int]()
    for entry, angle_in in _ANGLES.items():
        most = round(math.degrees(max(map(angle_in, poses))))
        if most - math.degrees(angle_in(start)) >= _LEAST:
            degrees[entry] = most
    for part in ("arm", "elbow"):
        if degrees.get(f"left_{part}", -1) == degrees.get(f"right_{part}"):
            degrees[f"both_{part}s"] = degrees.pop(f"left_{part}")
            del degrees[f"right_{part}"]
    farthest = capital(source.words.listed([get(f"range.{entry}", n=n) for entry, n in degrees.items()]))
    lines = [
        get("range.does", does=capital(help_text)) if help_text else "",
        get("range.far", list=farthest) if farthest else "",
        get("range.takes", seconds=f"{plan.length:.1f}"),
    ]
    return source.words.sentences([line for line in lines if line])


def _raised(side: str) -> Callable[[Mapping[str, float]], float]:
    """Return the function that gives an upper arm's angle in a pose: 0 hanging down, a right angle when level."""

    def angle(joints: Mapping[str, float]) -> float:
        pitch, roll = joints.get(f"{side}ShoulderPitch", math.pi / 2), joints.get(f"{side}ShoulderRoll", 0.0)
        return math.acos(min(max(math.sin(pitch) * math.cos(roll), -1.0), 1.0))

    return angle


def _of(joint: str, sign: float) -> Callable[[Mapping[str, float]], float]:
    return lambda joints: sign * joints.get(joint, 0.0)


_ANGLES: Mapping[str, Callable[[Mapping[str, float]], float]] = {
    "turn_left": _of("HeadYaw", 1), "turn_right": _of("HeadYaw", -1),
    "down": _of("HeadPitch", 1), "up": _of("HeadPitch", -1),
    "left_arm": _raised("L"), "right_arm": _raised("R"),
    "left_elbow": _of("LElbowRoll", -1), "right_elbow": _of("RElbowRoll", 1),
    "forward": _lean, "back": lambda joints: -_lean(joints), "knees": _of("LKneePitch", 1),
}  # fmt: skip
"""Angle (rad) of a part of the body in a pose, by the entry of the text that says its largest value in a movement."""
