"""Actuators that say texts, and the small gestures of free arms during a sentence."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from rrp_sheets.model.exchange import Command, DeviceUse
from rrp_sheets.robots.media_files import BadSoundError, read_wave
from rrp_sheets.sim.actuators.base import Parts, SimActuator, as_number
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.body import Motion
from rrp_sheets.sim.sounds import RATE, Audio, from_wave, own_sound
from rrp_sheets.texts import N_


class _Say(SimActuator):
    def __init__(self, spec: DeviceUse, parts: Parts) -> None:
        super().__init__(spec, parts)
        self._talking = Talking(parts) if self.settings.get("gestures") else None

    def say(self, text: str, command: Command, us: int) -> None:
        """Say a text, at once or after what is being said."""
        voice, settings = self.parts.voice, self.settings
        if not text.strip():
            self.parts.arbiter.at_once(command)
            return

        def begin(command: Command, us: int) -> None:
            voice.say(text, command, settings, us)
            if self._talking is not None:
                self._talking.begin(command, us)

        refused = N_("“{text}” is not said: the current speech has a higher priority.", text=text)
        self.parts.arbiter.take(Job(command, self.uses, begin, voice.stop, voice.over, refused=refused), us)


class SayInput(_Say, device="SayInput"):
    """Says what arrives."""

    def take(self, command: Command, us: int) -> None:
        """Say a text or a number."""
        if isinstance(command.value, str):
            self.say(command.value, command, us)
        elif (number := as_number(command.value)) is not None:
            self.say(f"{number:.6g}", command, us)
        else:
            self.wrong(command, N_("a text to say"))


class SayParameter(_Say, device="SayParameter"):
    """Says the text of its setting."""

    def take(self, command: Command, us: int) -> None:
        """Say the text of the setting."""
        self.say(str(self.settings.get("text") or ""), command, us)


LOWEST = float("-inf")  # priority: any other command takes the arm
PAUSE_US = 250_000  # between two of them
OFFSET_US = 300_000  # the right arm begins later: two arms that always move alike look like a machine's


class Talking:
    """Moves the free arms in small gestures while a sentence is spoken."""

    def __init__(self, parts: Parts) -> None:
        self._parts = parts
        self._count = 0  # of small gestures so far

    def begin(self, command: Command, us: int) -> None:
        """Begin the gestures for the sentence of this command; they end when nothing is said any more."""
        busy, robot = self._parts.arbiter.driving(), self._parts.body.robot
        for side in "LR" if robot.talking else "":
            arm = robot.data["chains"].get(f"{side}Arm")
            if arm and arm not in busy:
                self._arm(side, arm, replace(command, stream=f"{command.stream} {arm}", priority=LOWEST), us)

    def _arm(self, side: str, arm: str, command: Command, us: int) -> None:
        body, talking = self._parts.body, self._parts.body.robot.talking
        joints = frozenset(talking[0].of_side(side).joints)
        now: Motion | None = None
        due = us + (OFFSET_US if side == "R" else 0)

        def over(us: int) -> bool | None:
            nonlocal now, due
            if now is not None and now.going:
                return None
            if not self._parts.voice.saying:
                return True
            if now is not None:
                now, due = None, us + PAUSE_US
            if us >= due:
                gesture = talking[self._count % len(talking)].of_side(side)
                self._count += 1
                now = Motion(body, gesture.timed())
                self._parts.motions.begin(now)
            return None

        def cease(us: int) -> None:
            if now is not None:
                now.halt(home=True)

        self._parts.stance.steady()
        self._parts.arbiter.take(Job(command, frozenset((arm,)), lambda _, us: None, cease, over, joints=joints), us)


own = cache(own_sound)  # made once; a game plays them again and again


class PlaySound(SimActuator, device="PlaySound"):
    """Plays the sound of its settings, at once or after what is being said or played."""

    def take(self, command: Command, us: int) -> None:
        """Play the sound."""
        file = str(self.settings.get("file") or "").strip()
        name = file or str(self.settings.get("sound") or "Bell")
        try:
            audio, rate = self._read(file) if file else (own(name), RATE)
        except BadSoundError as error:
            text = N_("{name}: the file “{file}” {reason}.", name=self.spec.name, file=file, reason=error.args[0])
            self.fail(command, text)
            return
        voice, volume = self.parts.voice, float(self.settings.get("volume", 100))

        def begin(command: Command, us: int) -> None:
            voice.play(name, audio, rate, volume, command, us)

        refused = N_("“{name}” is not played: the current speech or sound has a higher priority.", name=name)
        self.parts.arbiter.take(Job(command, self.uses, begin, voice.stop, voice.over, refused=refused), us)

    def _read(self, file: str) -> tuple[Audio, int]:
        if self.parts.beside is None:
            raise BadSoundError("cannot be found: the workbook has no folder")
        read = read_wave(self.parts.beside, file)
        return from_wave(read), read.rate
