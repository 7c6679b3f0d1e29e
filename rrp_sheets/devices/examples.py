"""A small example workbook for every device: shown by its help, checked and run by the tests."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.devices import DeviceType, Robot

FOLDER = "examples"
_TEST = "\n## Test\n"


@dataclass(frozen=True)
class Example:
    """An example: `examples/<device>.md` in the robot's folder.

    Attributes:
        title: what it shows, from its first line.
        text: the whole workbook, in Markdown.
    """

    title: str
    text: str

    @property
    def shown(self) -> str:
        """The workbook without its test, which says nothing to who only wants to see how the device is used."""
        return self.text.partition(_TEST)[0]


def example_of(device: DeviceType, robot: Robot) -> Example | None:
    """The example of a device; None where there is none.

    >>> from rrp_sheets.devices import load_robot
    >>> robot = load_robot()
    >>> example_of(robot.find("Say").type, robot).title
    'The robot says what it worked out'
    """
    path = robot.folder / FOLDER / f"{device.name}.md"
    if not path.is_file():
        return None
    text = path.read_text(encoding="utf-8")
    return Example(text.partition("\n")[0].lstrip("# "), text)
