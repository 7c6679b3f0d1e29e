"""Robots as data: the catalogue of sensors and actuators, and the scene's vocabulary."""

from rrp_sheets.devices.catalogue import DeviceType, FoundDevice, Joint, Robot, Setting, load_robot, robot_names

__all__ = ["DeviceType", "FoundDevice", "Joint", "Robot", "Setting", "load_robot", "robot_names"]
