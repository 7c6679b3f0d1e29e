"""Whom the robot knows when a run begins: those whom an earlier run has kept, and those whom the scene names."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from rrp_sheets.sim.camera import Lens
from rrp_sheets.sim.face_models import FaceModels
from rrp_sheets.sim.faces import Faces
from rrp_sheets.sim.heads import Heads
from rrp_sheets.sim.looks import Looks
from rrp_sheets.sim.messages import Spec
from rrp_sheets.sim.portraits import studied
from rrp_sheets.sim.sensors import Sight
from rrp_sheets.sim.stage import Stage

USERS = ("FaceDetection", "RememberFace")
"""The devices that look at faces; without them no network is loaded."""
PICTURE = (640, 480)  # pixels, for faces: with half of that they are found to half the distance


def make_faces(
    spec: Spec, sight: Sight, stage: Stage, heads: Heads, lens: Lens, models: Callable[[], FaceModels]
) -> Faces:
    """What the robot knows of faces, at the beginning.

    Raises:
        SheetsError: a picture that the scene names, or the file of remembered faces, cannot be used.
        MissingPart: the networks are missing, and a device needs them.
    """
    for action in spec.scene:
        if picture := str(action.values.get("picture") or ""):
            heads.portrait(0, picture)
    faces = Faces(sight.look_closely, sight.pose, lambda: stage.us, lens, models)
    if any(use.device in USERS for use in (*spec.sensors, *spec.actuators)):
        if spec.faces:
            faces.know_from(Path(spec.faces))
        for known in Looks(spec.scene).known:
            # As if the robot had been shown this person's picture before.
            views = studied(heads.portrait(known.face, known.picture), models())
            faces.memory.know(known.number, known.name, views)
        models()
    return faces
