"""Playing sounds: the robot's own, and files beside the workbook."""

from __future__ import annotations

from functools import cache

from rrp_sheets.devices.sound_files import BadSoundError, read_wave
from rrp_sheets.model.exchange import Command
from rrp_sheets.sim.actuators.base import Base
from rrp_sheets.sim.arbitration import Job
from rrp_sheets.sim.espeak import Audio
from rrp_sheets.sim.sounds import RATE, from_wave, own_sound

own = cache(own_sound)  # made once; a game plays them again and again


class PlaySound(Base):
    """Plays the sound of its settings, at once or after what is being said or played."""

    def take(self, order: Command, us: int) -> None:
        """Play the sound."""
        file = str(self.settings.get("file") or "").strip()
        name = file or str(self.settings.get("sound") or "Bell")
        try:
            audio, rate = self._read(file) if file else (own(name), RATE)
        except BadSoundError as error:
            self.fail(order, f"{self.spec.name}: the file “{file}” {error}.")
            return
        voice, volume = self.parts.voice, float(self.settings.get("volume", 100))

        def begin(order: Command, us: int) -> None:
            voice.play(name, audio, rate, volume, order, us)

        refused = f"“{name}” is not played: what is being said or played has a higher priority."
        self.parts.arbiter.take(Job(order, self.uses, begin, voice.stop, voice.over, refused=refused), us)

    def _read(self, file: str) -> tuple[Audio, int]:
        if self.parts.beside is None:
            raise BadSoundError("cannot be found: the workbook has no folder")
        read = read_wave(self.parts.beside, file)
        return from_wave(read), read.rate
