"""A workbook with a sound, bundles of it, and bundles as strangers make them."""

from __future__ import annotations

import hashlib
import json
import struct
import wave
import zipfile
from pathlib import Path

from click.testing import CliRunner, Result

from rrp_sheets.cli.main import group

SONG = """## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | map | redBall.distance | Distance |
| Distance | filter | distance < 0.8 | Near |
| Near | throttle | 3 s | Now |
| Now | subscribe | | Tune |

## Devices
| Stream | Device | File |
|---|---|---|
| Tune | Play sound | a tune.wav |

## Scene
| Time (s) | Thing | Does | Value |
|---|---|---|---|
| 0.2 | Red ball | appears | at 0.6, 0, 0.42 |
"""


def run(*arguments: object) -> Result:
    return CliRunner().invoke(group, [str(a) for a in arguments])


def sound(path: Path) -> None:
    with wave.open(str(path), "wb") as file:
        file.setnchannels(1)
        file.setsampwidth(2)
        file.setframerate(16_000)
        file.writeframes(b"".join(struct.pack("<h", n * 37 % 2000) for n in range(1600)))


def files(path: Path) -> dict[str, bytes]:
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def remade(target: Path, content: dict[str, bytes]) -> Path:
    with zipfile.ZipFile(target, "w", zipfile.ZIP_DEFLATED) as archive:
        for name, data in content.items():
            archive.writestr(name, data)
    return target


def relisted(content: dict[str, bytes]) -> dict[str, bytes]:
    """With a list that fits what is there, as a stranger would make it."""
    told = json.loads(content["versions.json"])
    told["files"] = {
        n: {"sha256": hashlib.sha256(d).hexdigest(), "bytes": len(d)}
        for n, d in content.items()
        if n != "versions.json"
    }
    return {**content, "versions.json": json.dumps(told).encode()}
