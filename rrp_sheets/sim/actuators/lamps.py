"""The lamps of the robot."""

from __future__ import annotations

from rrp_sheets.sim.body import Body
from rrp_sheets.sim.colours import RGB


class Eyes:
    """Both eyes: a colour and a brightness."""

    def __init__(self, body: Body) -> None:
        self._body = body
        self.colour: RGB = (1.0, 1.0, 1.0)
        self.brightness = 1.0
        self.show()

    @property
    def shining(self) -> RGB:
        """The colour as it is seen."""
        red, green, blue = (round(c * self.brightness, 4) for c in self.colour)
        return red, green, blue

    def show(self) -> None:
        """Paint the eyes."""
        self._body.shine(*self.shining)
