"""Short texts of values and times for the displays of a run."""

from __future__ import annotations

import re

from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.values import Record, Value, show

LONGEST = 80  # letters of a value
_TELLING = ("name", "label", "word", "colour", "zone", "pressed", "distance", "value", "new", "count")
_UNIT = re.compile(r"^\(?-?[\d.,]+(?:e-?\d+)? ([^\s\d()]{1,8})\)?$")


def value_text(value: Value, unit: str = "") -> str:
    """Return a short text of a value; of a record one or two telling fields.

    >>> value_text(0.4567, "m"), value_text("left"), value_text(None)
    ('0.457 m', '“left”', 'blank')
    >>> value_text(DONE.make(value=1, completed=True, seconds=2.21))
    'completed after 2.2 s'
    """
    if isinstance(value, Record):
        return _record(value)
    text = show(value, LONGEST)
    number = isinstance(value, (int, float)) and not isinstance(value, bool)
    return f"{text} {unit}" if unit and number else text


def _record(value: Record) -> str:
    fields = value.as_dict()
    if value.type == DONE:
        seconds = fields.get("seconds")
        after = f" after {seconds:.1f} s" if isinstance(seconds, (int, float)) else ""
        return f"{'completed' if fields.get('completed') else 'broken off'}{after}"
    units = {f.name: f.unit for f in value.type.fields}
    telling = [n for n in _TELLING if fields.get(n) not in (None, "")][:2] or list(fields)[:2]
    text = ", ".join(f"{n} {value_text(fields[n], units.get(n, ''))}" for n in telling)
    return text if len(text) <= LONGEST else text[: LONGEST - 1] + "…"


def unit_of(example: str) -> str:
    """Return the unit of an example value as the check shows it.

    >>> unit_of("0.48 m"), unit_of("(12 °)"), unit_of("“left”"), unit_of("0.5")
    ('m', '°', '', '')
    """
    found = _UNIT.match(example)
    return found[1] if found else ""


def clock(us: int) -> str:
    """Format a time on the run's clock.

    >>> clock(42_340_000), clock(3_723_000_000)
    ('0:42.3', '1:02:03.0')
    """
    tenths = us // 100_000
    minutes, rest = divmod(tenths, 600)
    hours, minutes = divmod(minutes, 60)
    seconds = f"{rest / 10:04.1f}"
    return f"{hours}:{minutes:02}:{seconds}" if hours else f"{minutes}:{seconds}"
