"""Drivers that connect a robot's devices to the streams of a run."""
