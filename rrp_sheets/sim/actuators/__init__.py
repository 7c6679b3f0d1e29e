"""Actuators of the simulated robot; a wrong value is reported on its row and raises no exception."""

from __future__ import annotations

from rrp_sheets.model.exchange import DeviceUse
from rrp_sheets.model.names import key
from rrp_sheets.sim.actuators import moving, other, speech, tracker
from rrp_sheets.sim.actuators.base import ACTUATORS, Parts, SimActuator
from rrp_sheets.sim.body import Eyes

__all__ = ["ACTUATORS", "Eyes", "Parts", "SimActuator", "make_actuator"]
_MODULES = (moving, other, speech, tracker)  # their classes are registered when they are imported


def make_actuator(spec: DeviceUse, parts: Parts) -> SimActuator | None:
    """Return the object that carries out the commands of an actuator stream; None when the engine does that."""
    if parts.body.robot.devices[key(spec.device)].engine:
        return None
    return ACTUATORS.get(spec.device, other.Later)(spec, parts)
