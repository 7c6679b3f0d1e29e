"""Style of the diagrams: colours, fonts, sizes (points). Kinds differ by shape too, for grey printers."""

from __future__ import annotations

from dataclasses import dataclass

from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME, SIGN_NAMES

# The faces of our pages; for PDF and PNG, Noto Sans JP comes along.
SANS = "-apple-system, Segoe UI, Roboto, Liberation Sans, Arial, Noto Sans JP, sans-serif"
MONO = "DejaVu Sans Mono, Noto Sans JP, Liberation Mono, monospace"

INK = "#1a1a1a"
SOFT = "#444"
EDGE = "#4a4a4a"
BOX = "#6b6b6b"
BADGE = "#3a3a3a"  # behind the row's number
FLAG = "#9a3300"
OFF_LINE = "#8a8a8a"
OFF_FILL = "#f5f5f5"
OFF_INK = "#5f5f5f"
FILL_AND_LINE = {
    "sensor": ("#dbe8f8", "#1f5fa8"),
    "done": ("#eef4fb", "#1f5fa8"),
    "stream": ("#e4f3e2", "#2e7d32"),
    "actuator": ("#fadff1", "#a0176f"),
}
DASHES = "3 2.2"


@dataclass(frozen=True)
class StatusStyle:
    """Look of what was added, removed, changed or stayed: statuses differ by line and sign too."""

    line: str
    fill: str
    ink: str
    thick: float
    word: str


STATUS_STYLES = {
    SAME: StatusStyle("#a2a2a2", "#fff", "#5c5c5c", 0.9, SIGN_NAMES[SAME][1]),
    ADDED: StatusStyle("#1b6e2f", "#e2f3e4", "#123f1c", 2.2, SIGN_NAMES[ADDED][1]),
    REMOVED: StatusStyle("#a11d1d", "#fff", "#6e1414", 1.4, SIGN_NAMES[REMOVED][1]),
    CHANGED: StatusStyle("#8a5a00", "#fff3d2", "#4d3300", 1.7, SIGN_NAMES[CHANGED][1]),
}
QUIET_BADGE, QUIET_OFF = "#7d7d7d", "#bdbdbd"  # of rows that stayed as they were, and of arrows of those that are off
SIGN = 7.0  # half the size of a status's sign

NAME_PT = 10.0
SMALL_PT = 8.5
MONO_PT = 8.0
LEAST_PT = 7.0  # nothing is printed smaller

NAME_LINE = 12.0  # from line to line
FORMULA_LINE = 10.0
VALUE_LINE = 11.0  # room under a stream's name for its newest value
VALUE_ROOM = 52.0  # and at least so wide
NAME_COLUMNS = 16  # a name longer than this is broken into two lines
RANK_GAP = 14.0
NODE_GAP = 10.0
NODE_GAP_NARROW = 6.0
PADDING = 9.0  # around a whole drawing

MOST_ROWS = 18  # per page, before a behaviour is split into parts
FEWEST_ROWS = 6
PAGE = (482.0, 640.0)  # an A4 page's width of text, and the height that a diagram may take
LANDSCAPE = (728.0, 400.0)
LEAST_SCALE = LEAST_PT / MONO_PT


@dataclass(frozen=True)
class Wrapping:
    """Line lengths and limits for the formulas in boxes.

    Attributes:
        columns: characters per line.
        lines: how many; a formula that needs more gets longer lines.
        beside: up to how many characters stand beside the connector's name.
        whole: False where a long formula may be cut, as it stands beside the drawing.
    """

    columns: int = 22
    lines: int = 6
    beside: int = 8
    whole: bool = True


BESIDE_A_TABLE = Wrapping(
    14, 4, beside=4, whole=False
)  # narrow: the diagram stands in a panel, where height costs less
WRAPPINGS = (Wrapping(), Wrapping(beside=16), Wrapping(20, 7), Wrapping(17, 8))
