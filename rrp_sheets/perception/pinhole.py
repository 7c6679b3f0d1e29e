"""Geometry of a pinhole camera: poses in the world, its lens, and the pictures that it takes."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Floats = NDArray[np.float32]
Pixels = NDArray[np.uint8]
"""A picture, (height, width, 3), 0 to 255, red first."""


@dataclass(frozen=True)
class Pose:
    """A place and an orientation: position in m, rotation as a matrix whose columns are the frame's axes."""

    position: Vector
    rotation: Vector


@dataclass(frozen=True)
class Lens:
    """A pinhole camera: opening angles in rad, size in pixels."""

    hfov: float
    vfov: float
    width: int
    height: int

    @property
    def focal(self) -> tuple[float, float]:
        """Focal lengths in pixels, horizontally and vertically."""
        return self.width / 2 / math.tan(self.hfov / 2), self.height / 2 / math.tan(self.vfov / 2)

    def rays(self, scale: int = 1) -> Floats:
        """A ray per pixel in the camera's frame, (height, width, 3), with x = 1; `scale` leaves pixels out."""
        fx, fy = self.focal
        u = (np.arange(0, self.width, scale, dtype=np.float32) + scale / 2 - self.width / 2) / np.float32(fx)
        v = (np.arange(0, self.height, scale, dtype=np.float32) + scale / 2 - self.height / 2) / np.float32(fy)
        ahead = np.ones((len(v), len(u)), np.float32)
        rays: Floats = np.stack([ahead, *np.broadcast_arrays(-u[None, :], -v[:, None])], axis=2).astype(np.float32)
        return rays
