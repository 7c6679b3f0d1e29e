"""The robot as a body in the ethics pack: size, weight, forces and speeds, in words that people can judge."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rrp_sheets.checks.ethics import SIMULATED
from rrp_sheets.render.pack import acts
from rrp_sheets.render.pack.model import Labelled
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.style import clean

_GRAVITY = 9.81
_ARMS = frozenset({"left arm", "right arm"})
_HEIGHTS = ((0.35, "shin"), (0.5, "knee"), (0.7, "above_knee"), (1.0, "table"), (math.inf, "above_table"))
_SPEEDS = ((0.3, "crawl"), (1.0, "stroll"), (1.5, "walk"), (3.0, "fast_walk"), (math.inf, "run"))  # m/s


def body(source: Source) -> tuple[Labelled, ...]:
    """Return the facts about the robot; nothing of a robot whose `robot.toml` does not state them."""
    get, facts = source.get, _facts(source)
    if not facts:
        return ()
    lines = [("size", _size(source, facts)), ("arms", _arms(source, facts)), ("movement", _movement(source, facts))]
    if acts.walkers(source):
        speed = float(facts["walking_speed"])
        like = _like(source, "speed", _SPEEDS, speed)
        lines.append(("walking", get("body.walks", cm=_round(speed * 100), like=like)))
    lines.append(("distance", _distance(source, facts)))
    lines.append(("stop", get("body.stops")))
    return tuple(Labelled(get(f"body.{name}"), text) for name, text in lines)


def note(source: Source) -> str:
    """Return where the facts come from; of a robot without facts, that there are none."""
    facts = _facts(source)
    if not facts:
        return source.get("body.unknown", robot=clean(source.checked.robot.title))
    not_met = [source.get("body.not_met")] if source.checked.study.meets == SIMULATED else []
    return source.words.sentences([*not_met, source.get("body.sources", sources=clean(str(facts["sources"])))])


def _facts(source: Source) -> Mapping[str, Any]:
    facts: Mapping[str, Any] = source.checked.robot.data.get("body", {})
    numbers = ("weight", "reach", "walking_speed", "hand_force", "joint_force")
    known = all(isinstance(facts.get(name), (int, float)) and facts[name] > 0 for name in numbers)
    return facts if known and isinstance(facts.get("sources"), str) else {}


def _size(source: Source, facts: Mapping[str, Any]) -> str:
    height, weight = float(source.checked.robot.data["robot"]["height"]), float(facts["weight"])
    like = _like(source, "height", _HEIGHTS, height)
    return source.get("body.is", cm=round(height * 100), like=like, kg=f"{weight:.1f}", litres=max(1, round(weight)))


def _arms(source: Source, facts: Mapping[str, Any]) -> str:
    if not _ARMS & set(acts.moving_parts(source)):
        return source.get("body.arms_rest")
    hand, joint = float(facts["hand_force"]), float(facts["joint_force"])
    near = {"near": _round(joint), "near_kg": f"{joint / _GRAVITY:.0f}"}
    return source.get("body.push", force=_round(hand), kg=f"{hand / _GRAVITY:.1f}", **near)


def _movement(source: Source, facts: Mapping[str, Any]) -> str:
    """Return the fastest movement that rows can ask for, walking aside: the turn of a joint, the way of a hand."""
    groups = acts.by_stream(source)
    speeds = {stream: acts.top_velocity(source, drivers) for stream, drivers in groups.items()}
    fastest, joint = max(speeds.values(), default=(0.0, ""))
    if not joint:
        return source.get("body.still")
    arms = [v for s, (v, _) in speeds.items() if _ARMS & set(acts.parts_of(source, groups[s]))]
    degrees, joint = acts.show_speed(fastest), acts.joint_name(source, joint)
    hand = max(arms, default=0.0) * float(facts["reach"])
    if not hand:
        return source.get("body.turns", degrees=degrees, joint=joint)
    like = _like(source, "speed", _SPEEDS, hand)
    return source.get("body.moves", degrees=degrees, joint=joint, speed=f"{hand:.1f}", like=like)


def _distance(source: Source, facts: Mapping[str, Any]) -> str:
    height, reach = float(source.checked.robot.data["robot"]["height"]), float(facts["reach"])
    raised = float(facts.get("raised", height + reach))
    cm = {"reach": math.ceil(reach * 100), "height": round(height * 100), "raised": math.ceil(raised * 100)}
    return source.get("body.keeps", **cm)


def _like(source: Source, what: str, steps: tuple[tuple[float, str], ...], amount: float) -> str:
    return source.get(f"body.{what}_{next(name for most, name in steps if amount <= most)}")


def _round(amount: float) -> str:
    """Return a number with two digits, rounded up: it is the most that there can be."""
    unit = 10 ** max(0, math.floor(math.log10(amount)) - 1) if amount >= 1 else 1
    return f"{math.ceil(amount / unit - 1e-9) * unit:,}"
