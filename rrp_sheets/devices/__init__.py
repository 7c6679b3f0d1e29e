"""Robots as data: the catalogue of sensors and actuators, and the scene's vocabulary."""

from rrp_sheets.devices.catalogue import Joint, Robot, load_robot, robot_names
from rrp_sheets.devices.device import DeviceType, Found, Setting

__all__ = ["DeviceType", "Found", "Joint", "Robot", "Setting", "load_robot", "robot_names"]
