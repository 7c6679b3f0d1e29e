"""Installation: one PyBullet for each Python and system, and the message where there is none."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from packaging.requirements import Requirement

TREE = Path(__file__).parent.parent
PROJECT = tomllib.loads((TREE / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LOCK = (TREE / "requirements.lock").read_text(encoding="utf-8")
PYTHONS = ("3.11", "3.12", "3.13")
SYSTEMS = {
    "Linux": ("linux", "x86_64"), "Linux on ARM": ("linux", "aarch64"), "Windows": ("win32", "AMD64"),
    "macOS": ("darwin", "arm64"), "macOS on Intel": ("darwin", "x86_64"),
}  # fmt: skip
WITHOUT = {("Linux on ARM", python) for python in PYTHONS} | {("macOS on Intel", "3.13")}
"""For these no package has a wheel."""


def chosen(requirements: list[str], name: str, system: str, python: str) -> list[str]:
    """The pins of the packages whose name begins so, that are installed there."""
    platform, machine = SYSTEMS[system]
    environment = {
        "sys_platform": platform, "platform_machine": machine, "python_version": python,
        "python_full_version": f"{python}.1", "implementation_name": "cpython",
        "os_name": "nt" if platform == "win32" else "posix", "platform_python_implementation": "CPython",
    }  # fmt: skip
    wanted = [r for r in map(Requirement, requirements) if r.name.startswith(name)]
    return [f"{r.name}{r.specifier}" for r in wanted if r.marker is None or r.marker.evaluate(environment)]


@pytest.mark.parametrize("python", [*PYTHONS, "3.14"])
@pytest.mark.parametrize("system", SYSTEMS)
def test_one_pybullet_is_installed_or_none(system: str, python: str) -> None:
    both = [
        chosen(PROJECT["dependencies"], "pybullet", system, python),
        chosen(re.findall(r"^(pybullet[^\\\n]*)", LOCK, re.MULTILINE), "pybullet", system, python),
    ]
    if (system, python) in WITHOUT or python not in PYTHONS:
        expected = []
    else:  # pybullet itself where it has a wheel: it reads pictures faster
        expected = ["pybullet==3.2.7" if (system, python) == ("Linux", "3.11") else "pybullet-arm64==3.2.8"]
    assert both == [expected, expected]


@pytest.mark.parametrize("python", PYTHONS)
@pytest.mark.parametrize("system", SYSTEMS)
def test_where_there_is_a_simulator_it_hears_words(system: str, python: str) -> None:
    simulator = chosen(PROJECT["dependencies"], "pybullet", system, python)
    heard = chosen(PROJECT["dependencies"], "pocketsphinx", system, python)
    assert len(heard) == 1 or (not simulator and not heard)


def test_the_lock_names_no_registry() -> None:
    assert "://" not in LOCK


@pytest.mark.skipif(os.name == "nt", reason="make and sh are not on Windows")
@pytest.mark.parametrize("python", ["3.10", *PYTHONS, "3.14"])
def test_before_anything_is_installed_the_python_is_checked(tmp_path: Path, python: str) -> None:
    fake = tmp_path / "python3"  # prints the version that it is asked for
    fake.write_text(f'#!/bin/sh\ncase "$2" in *version_info*) echo {python};; esac\n')
    fake.chmod(0o755)
    machine = tmp_path / "uname"
    machine.write_text('#!/bin/sh\n[ "$1" = -s ] && echo Linux || echo x86_64\n')
    machine.chmod(0o755)
    path = f"{tmp_path}{os.pathsep}{os.environ['PATH']}"
    shell = shutil.which("sh")
    assert shell is not None

    def check() -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [shell, str(TREE / ".ci/python-check"), str(fake)], capture_output=True, text=True, env={"PATH": path}
        )

    done = check()
    if python in PYTHONS:
        assert (done.returncode, done.stdout, done.stderr) == (0, "", "")
        machine.write_text('#!/bin/sh\n[ "$1" = -s ] && echo Linux || echo aarch64\n')
        assert "no simulator" in check().stdout
    else:
        assert done.returncode == 1
        assert f"needs Python 3.11, 3.12 or 3.13; this is {python}" in done.stderr


def test_the_readme_names_the_pythons_of_the_package() -> None:
    named = [c.rpartition(" ")[2] for c in PROJECT["classifiers"] if re.search(r"Python :: 3\.\d+$", c)]
    assert tuple(named) == PYTHONS
    readme = (TREE / "README.md").read_text(encoding="utf-8")
    assert "with Python 3.11, 3.12 or 3.13" in readme
    systems = (TREE / "rrp_sheets" / "help" / "systems.md").read_text(encoding="utf-8")
    assert "* Linux x86-64 | with glibc 2.28 or newer, Python 3.11, 3.12 and 3.13: everything" in systems


def version(before: str = "") -> list[str]:
    program = f"import sys\n{before}\nfrom rrp_sheets.cli.main import main\nsys.argv = ['', '--version']\nmain()"
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=TREE, check=True)
    return done.stdout.splitlines()


def test_the_version_tells_whether_the_simulator_is_there() -> None:
    pytest.importorskip("pybullet")
    first, python, simulator = version()
    assert re.fullmatch(r"rrp-sheets, version \d+\.\d+\.\d+", first)
    assert python.startswith(f"Python {sys.version_info.major}.{sys.version_info.minor}.")
    assert re.fullmatch(r"Simulator: yes, pybullet(-arm64)? [\d.]+", simulator)


def test_the_version_tells_what_the_simulator_lacks() -> None:
    assert version("sys.modules['pybullet'] = None")[2] == "Simulator: no, pybullet missing"
