"""The robot's model: generated from data, and standing."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from rrp_sheets.resources import bundled
from rrp_sheets.robots import load_robot

pytest.importorskip("pybullet")


def test_the_model_in_the_repository_is_the_generated_one(tmp_path: Path) -> None:
    folder = bundled("robots", "nao")
    subprocess.run([sys.executable, str(folder / "make_urdf.py"), str(tmp_path)], check=True)
    made = sorted(p.name for p in tmp_path.iterdir())
    assert made == ["caps.obj", "ell.obj", "nao.urdf", "rbox.obj"]
    for name in made:
        assert (tmp_path / name).read_bytes() == (folder / name).read_bytes(), f"run {folder / 'make_urdf.py'}"


def test_the_model_has_every_joint_of_the_catalogue() -> None:
    robot = load_robot()
    urdf = (robot.folder / robot.data["robot"]["urdf"]).read_text(encoding="utf-8")
    assert [j.name for j in robot.joints.values() if f'<joint name="{j.name}"' not in urdf] == []
    for eye in ("LeftEye", "RightEye"):
        assert f'<link name="{eye}">' in urdf
