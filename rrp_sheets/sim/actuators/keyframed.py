"""Base of postures and gestures: a command that moves joints through keyframes, once, to its end."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.model.exchange import Command, DeviceUse, Notice
from rrp_sheets.model.names import key, nearest
from rrp_sheets.model.values import show
from rrp_sheets.sim.actuators.base import Base, Parts
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.keyframes import Motion


class Keyframed(Base):
    """An actuator that makes one motion after the other.

    A command that repeats the present motion lets it go on, so that a stream that repeats itself does not keep it at
    its beginning; the earlier command has then ended, not completed. Once the joints only go back to where they were, a
    command begins a motion of its own.
    """

    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._motion: Motion | None = None
        self._doing = ""
        self._next = ""

    def move(
        self,
        order: Command,
        us: int,
        what: str,
        motion: Motion,
        *,
        home: bool,
        arrived: Callable[[int], bool | None] = lambda us: True,
        during: Callable[[Motion], None] = lambda motion: None,
    ) -> None:
        """Make a motion.

        Args:
            order: the command.
            us: now.
            what: name of the motion, by which a repeated command is recognised.
            motion: made for this command.
            home: whether the joints go back to where they were when it is broken off.
            arrived: called after the motion's end, until it returns whether the command was completed.
            during: called at every step of the motion.
        """

        def begin(order: Command, us: int) -> None:
            if self._goes_on(what):
                return
            self._motion, self._doing = motion, what
            self._hold(motion)
            self.parts.motions.begin(motion)

        def cease(us: int) -> None:
            if self._motion is not None and self._next != what:
                self._motion.halt(home=home)
                self._motion = None

        def over(us: int) -> bool | None:
            going = self._motion
            self._tell_clamped(order, going)
            if going is None or not going.going:
                return arrived(us)
            during(going)
            return None

        self._next = what if self._goes_on(what) else ""
        joints = self.parts.body.robot.joints
        chains = self.parts.body.robot.data["chains"]
        uses = frozenset(chains[joints[key(j)].chain] for j in motion.joints)
        job = Job(order, uses, begin, cease, over, joints=frozenset(motion.joints), refused=self.refused)
        self.parts.arbiter.take(job, us)
        self._next = ""

    def _goes_on(self, what: str) -> bool:
        motion = self._motion
        return motion is not None and motion.going and not motion.returning and self._doing == what

    def _hold(self, motion: Motion) -> None:
        """Have the torso held while arms or legs move, as the robot does not balance by itself."""
        chains = {self.parts.body.robot.joints[key(j)].chain for j in motion.joints}
        if chains & {"LLeg", "RLeg"}:
            self.parts.stance.follow_legs()
        elif chains - {"Head"}:
            self.parts.stance.steady()

    def _tell_clamped(self, order: Command, motion: Motion | None) -> None:
        while motion is not None and motion.clamped:
            c = motion.clamped.pop(0)
            text = f"{c.joint}: {c.wanted:.4g} → {c.given:.4g} rad, its limit there."
            self.parts.tell(Notice("clamp", text, order.stream, order.row))

    def unknown(self, order: Command, what: str, name: str, names: Sequence[str]) -> None:
        """Report that no posture or gesture has a name, with the names that may be meant."""
        self.fail(order, f"{self.spec.name}: there is no {what} {show(name[:60])}. {proposal(name, names)}")


def proposal(name: str, names: Sequence[str]) -> str:
    """Return a sentence that proposes the name nearest to an unknown one, or lists all names.

    >>> proposal("Wve", ["Nod", "Wave"]), proposal("Zzz", ["Nod", "Wave"])
    ('Did you mean Wave?', 'There are: Nod, Wave.')
    """
    guess = nearest(name, names)
    return f"Did you mean {guess}?" if guess else f"There are: {', '.join(names)}."
