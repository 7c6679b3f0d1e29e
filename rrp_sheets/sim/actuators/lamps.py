"""LEDs of the robot's eyes."""

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
        """Colour of the eyes as it is seen: dimmed by the brightness."""
        red, green, blue = (round(c * self.brightness, 4) for c in self.colour)
        return red, green, blue

    def show(self) -> None:
        """Apply colour and brightness to the robot's model."""
        self._body.shine(*self.shining)
