"""Actuators of the simulated robot, by device; a wrong value is reported on its row and raises no exception."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.model.names import key
from rrp_sheets.sim.actuators.base import Parts, SimActuator
from rrp_sheets.sim.actuators.keyframed import GestureActuator, Posture
from rrp_sheets.sim.actuators.moving import SetJointPosition, Track, Walk
from rrp_sheets.sim.actuators.other import EyeBrightness, EyeColor, EyeLedColor, Later, PrintActuator, RememberFace
from rrp_sheets.sim.actuators.speech import PlaySound, SayInput, SayParameter
from rrp_sheets.sim.body import Eyes

__all__ = ["ACTUATORS", "Eyes", "Parts", "SimActuator", "make_actuator"]

ACTUATORS: Mapping[str, type[SimActuator]] = {
    "EyeLedColor": EyeLedColor, "EyeColor": EyeColor, "EyeBrightness": EyeBrightness, "SayInput": SayInput,
    "SayParameter": SayParameter, "RememberFace": RememberFace, "Tracker": Track,
    "SetJointPosition": SetJointPosition, "Print": PrintActuator,
    "Posture": Posture, "Gesture": GestureActuator, "Walk": Walk,
    "PlaySound": PlaySound,
}  # fmt: skip


def make_actuator(spec: DeviceUse, parts: Parts) -> SimActuator | None:
    """Return the object that carries out the commands of an actuator stream; None when the engine does that."""
    if parts.body.robot.devices[key(spec.device)].engine:
        return None
    return ACTUATORS.get(spec.device, Later)(spec, parts)
