"""Speaking."""

from __future__ import annotations

from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.sim.actuators.base import Base, Parts, as_number
from rrp_sheets.sim.actuators.talking import Talking
from rrp_sheets.sim.arbitration import Job


class _Say(Base):
    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._talking = Talking(parts) if self.settings.get("gestures") else None

    def say(self, text: str, order: Command, us: int) -> None:
        """Say a text, at once or after what is being said."""
        voice, settings = self.parts.voice, self.settings
        if not text.strip():
            self.parts.arbiter.at_once(order)
            return

        def begin(order: Command, us: int) -> None:
            voice.say(text, order, settings, us)
            if self._talking is not None:
                self._talking.begin(order, us)

        refused = f"“{text}” is not said: what is being said has a higher priority."
        self.parts.arbiter.take(Job(order, self.uses, begin, voice.stop, voice.over, refused=refused), us)


class SayInput(_Say):
    """Says what arrives."""

    def take(self, order: Command, us: int) -> None:
        """Say a text or a number."""
        value = order.value
        number = as_number(value)
        if isinstance(value, str):
            self.say(value, order, us)
        elif number is not None:
            self.say(f"{number:.6g}", order, us)
        else:
            self.wrong(order, "a text to say")


class SayParameter(_Say):
    """Says the text of its setting."""

    def take(self, order: Command, us: int) -> None:
        """Say it."""
        self.say(str(self.settings.get("text") or ""), order, us)
