"""Gesture actuator: moves arms, head and knees through keyframes and back, or points at something."""

from __future__ import annotations

from rrp_sheets.devices.gestures import Gesture as Keyframes
from rrp_sheets.devices.gestures import Keyframe
from rrp_sheets.model.exchange import Command
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Record
from rrp_sheets.sim.actuators.base import as_number
from rrp_sheets.sim.actuators.keyframed import Keyframed
from rrp_sheets.sim.body import Vector
from rrp_sheets.sim.keyframes import Motion
from rrp_sheets.sim.pointing import Pointing
from rrp_sheets.sim.tracker import Detection

RAISED, HELD = 0.8, 1.9  # s: when an arm points, and until when


class GestureActuator(Keyframed):
    """Makes the gesture of its setting, the one that a value names, or points at what was detected."""

    def take(self, order: Command, us: int) -> None:
        """Make the gesture, or point."""
        named, motions = self.settings.get("name") or order.value, self.parts.body.robot.motions
        if isinstance(named, Record) and {"x", "y"} <= set(named.values):
            self._point(order, us, named)
            return
        if not isinstance(named, str):
            self.wrong(order, "the name of a gesture, for example Wave, or something detected to point at")
            return
        gesture = motions.get(key(named))
        if gesture is None:
            self.unknown(order, "gesture", named, self.parts.body.robot.gestures)
            return
        self._make(order, us, gesture)

    def _make(self, order: Command, us: int, gesture: Keyframes) -> None:
        tempo, times = as_number(self.settings.get("tempo")), as_number(self.settings.get("times"))
        frames = gesture.timed(tempo, max(1, round(times or 1)))
        self.move(order, us, key(gesture.name), Motion(self.parts.body, frames), home=True)

    def _point(self, order: Command, us: int, seen: Record) -> None:
        place = self._place(order, seen)
        body = self.parts.body
        pointing = Pointing(body)
        side = pointing.nearer(place, "")
        pose = pointing.joints(side, place)
        frames = (Keyframe(RAISED, pose), Keyframe(HELD, pose))
        self.move(order, us, f"point {side}", Motion(body, frames), home=True)

    def _place(self, order: Command, seen: Record) -> Vector:
        """Return where the seen thing is, from the camera's pose of its detection if that is known, else from now."""
        x, y = (as_number(seen.values[axis]) or 0.0 for axis in "xy")
        known = [self.parts.trackers.seen[s] for s in order.sensors if s in self.parts.trackers.seen]
        like = next((d for d in sorted(known, key=lambda d: -d.us) if (d.x, d.y) == (x, y)), None)
        camera = like.camera if like is not None else self.parts.body.camera()
        x, y = (min(max(angle, -1.4), 1.4) for angle in (x, y))
        return Detection(0, x, y, as_number(seen.values.get("distance")), 0.0, 0.0, camera).point()
