"""The things of a run's scene, each as it comes in: so that one that has left can be put back by hand."""

from __future__ import annotations

from collections.abc import Sequence

from rrp_sheets.devices.default_scene import default_scene
from rrp_sheets.devices.scene_draw import draw_scene
from rrp_sheets.devices.scene_words import FACE_HEIGHT
from rrp_sheets.engine.plan import Plan
from rrp_sheets.model.names import key
from rrp_sheets.model.scene import SceneAction


class SceneEntities:
    """How each thing of a scene comes in: a ball with its size and colour, a person with their number and name.

    Args:
        plan: of the run, whose scene it is.
        seed: by which the run draws what the scene leaves open.
    """

    def __init__(self, plan: Plan, seed: int = 0) -> None:
        checked = plan.checked
        scene, _ = draw_scene(checked.scene or (), seed)
        if checked.scene is None:
            scene = default_scene(plan.outer_sensors, checked.robot)
        self._entries: dict[str, SceneAction] = {}
        self.add(scene[::-1])  # as it came first

    def add(self, actions: Sequence[SceneAction]) -> None:
        """Remember things that come in."""
        for action in actions:
            if action.verb == "appear":
                self._entries[key(action.thing)] = action
            elif action.verb == "seen":
                values = {"at": (1.0, 0.0, FACE_HEIGHT), **{n: action.values.get(n) for n in ("id", "name")}}
                self._entries[key(action.thing)] = SceneAction(0, action.thing, "appear", values, kind="person")

    def entry(self, thing: str) -> SceneAction | None:
        """The action by which a thing comes in; None of one that the scene does not have."""
        return self._entries.get(key(thing))
