"""Finds the help on a topic, on a word of the sheets, or on the name of a connector, function, device or finding."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.topics.layout import from_markdown, titled
from rrp_sheets.topics.workbooks import grids
from rrp_sheets.workbook.schema import SHEETS, SheetKind

_WORDS = ("words", "stream", "streams", "event", "events", "field", "fields", "frame", "seed", "rad", "trace", "units")
TOPICS = ("connectors", "formulas", "functions", "devices", "scene", "tests", "codes")
_SYNONYMS = {
    "connector": "connectors", "operators": "connectors", "operator": "connectors",
    "formula": "formulas", "language": "formulas", "function": "functions", "helper": "helpers",
    "priorities": "priority", "framerate": "protocol", "engines": "engine",
    "device": "devices", "sensors": "devices", "sensor": "devices", "actuators": "devices", "actuator": "devices",
    "test": "tests", "testing": "tests", "scenes": "scene", "errors": "codes", "error": "codes",
    "warnings": "codes", "messages": "codes", "code": "codes", "overview": "", "help": "",
    "workbook": "sheets", "workbooks": "sheets", "sheet": "sheets", "record": "records", "recordings": "records",
    "server": "serve", "browser": "serve", "grid": "serve", "paper": "ethics", "comparing": "compare", "git": "compare",
    "bundle": "bundles", "installation": "systems", "windows": "systems", "macos": "systems",
    **dict.fromkeys(_WORDS, "glossary"),
}  # fmt: skip


def text_on(name: str, others: Sequence[str] = ()) -> Iterator[str]:
    """The blocks of text on a topic or a name; `others`: names that can be proposed too.

    Raises:
        SheetsError: when there is nothing on it, with the nearest name proposed.
    """
    from rrp_sheets.model.names import key

    topic = _SYNONYMS.get(key(name), key(name))
    if topic == "" or topic in TOPICS:
        return _topics()[topic]()
    if topic in WORDS:
        return word(topic)
    found = list(_named(name))
    if found:
        return iter(block for blocks in found for block in blocks)
    raise _unknown(name, others)


def _topics() -> dict[str, Callable[[], Iterator[str]]]:
    from rrp_sheets.topics.codes import all_codes
    from rrp_sheets.topics.connectors import all_connectors
    from rrp_sheets.topics.devices import all_devices
    from rrp_sheets.topics.functions import all_functions
    from rrp_sheets.topics.scene_page import scene

    return {
        "": lambda: _file("overview"), "formulas": lambda: _file("formulas"), "tests": lambda: _file("tests"),
        "connectors": all_connectors, "functions": all_functions, "devices": all_devices, "scene": scene,
        "codes": all_codes,
    }  # fmt: skip


def _file(name: str) -> Iterator[str]:
    text = (Path(__file__).parent / f"{name}.md").read_text(encoding="utf-8")
    for kind in SHEETS.values() if name == "sheets" else ():
        text = text.replace(f"{{{kind.name}}}", _columns(kind))
    return from_markdown(text)


def _columns(kind: SheetKind) -> str:
    """Return the columns of a kind of sheet; notes, which all sheets may have, are named beside other optional ones."""
    required, optional = (", ".join(c.name for c in columns) for columns in (kind.required, kind.optional))
    return f"{required}; {optional}" if len(kind.optional) > 1 else required


def _named(name: str) -> Iterator[Iterator[str]]:
    """Yield the help pages under a name: it may be a function and a device, say."""
    from rrp_sheets.connectors import connectors
    from rrp_sheets.devices import load_robot
    from rrp_sheets.diagnostics import CODES
    from rrp_sheets.formulas.functions import library
    from rrp_sheets.graph.device_table import done_of
    from rrp_sheets.topics.codes import one_code
    from rrp_sheets.topics.connectors import one_connector
    from rrp_sheets.topics.devices import done_stream, one_device
    from rrp_sheets.topics.functions import one_function

    if (code := CODES.get(name.upper())) is not None:
        yield one_code(code)
    if (connector := connectors().get(name)) is not None:
        yield one_connector(connector)
    if (function := library().get(name.removesuffix("()"))) is not None:
        yield one_function(function)
    if (device := load_robot().find(name)) is not None:
        yield one_device(device)
    elif (found := load_robot().find(done_of(name))) is not None and found.type.kind == "actuator":
        yield done_stream(found)


def _unknown(name: str, others: Sequence[str]) -> SheetsError:
    from rrp_sheets.connectors import connectors
    from rrp_sheets.devices import load_robot
    from rrp_sheets.diagnostics import CODES
    from rrp_sheets.formulas.functions import library
    from rrp_sheets.model.names import nearest

    found = list(load_robot().names.values())
    devices = [*(f.name for f in found), *(f"{f.name} done" for f in found if f.type.kind == "actuator")]
    guess = nearest(name, [*TOPICS, *WORDS, *connectors().names(), *library().names(), *devices, *CODES, *others])
    remedy = f"Did you mean {guess}?" if guess else f"Try: {', '.join(TOPICS)}."
    return SheetsError(f"There is no help on “{name}”.", remedy)


WORDS = (
    "helpers", "priority", "total", "protocol", "engine", "keys", "glossary",
    "sheets", "robot", "serve", "records", "ethics", "compare", "bundles", "systems",
)  # fmt: skip
EXAMPLES = {
    "helpers": """
## Helpers
| Name | Inputs | Formula |
|---|---|---|
| limit | | 0.8 |
| near | distance | distance < limit |

## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | filter | near(redBall.distance) | Close ball |
| Close ball | subscribe | | Head tracker |
""",
    "priority": """
## Talk
| Input streams | Connector | Formula | Output stream | Priority |
|---|---|---|---|---|
| Start | subscribe | "Hello, I am a robot." | Say | |
| Touch | subscribe | "That is my head." | Say | 5 |

## Devices
| Stream | Device | Label |
|---|---|---|
| Start | Operator button | Start |
""",
    "total": """
## Counting
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Touch | accumulate | total + 1 | Touches |
| Touches | subscribe | | Say |
""",
    "protocol": """
## Protocol
| Field | Value |
|---|---|
| Title | Follow the ball |
| Purpose | Does a child look where the robot looks? |
| Engine | frame |
| Seed | 7 |
| Time limit | 5 min |

## Tracking
| Input streams | Connector | Formula | Output stream |
|---|---|---|---|
| Red ball | subscribe | | Head tracker |
""",
}
"""A workbook for each word that needs one; a test holds that they are in order."""


def word(name: str) -> Iterator[str]:
    """Yield the meaning of a word of the sheets, with an example where one helps."""
    yield from _file(name)
    if name in EXAMPLES:
        yield titled("For example", *grids(EXAMPLES[name]), between="\n\n")
