"""Robots as data: the catalogue of sensors and actuators, gestures, trajectories, pictures and sounds."""

from rrp_sheets.robots.catalogue import DeviceType, FoundDevice, Joint, Robot, Setting, load_robot, robot_names

__all__ = ["DeviceType", "FoundDevice", "Joint", "Robot", "Setting", "load_robot", "robot_names"]
