"""What the rows refer to: devices with their settings, helpers, tables, gestures, and the scene of the rehearsal."""

from __future__ import annotations

from collections.abc import Sequence

from rrp_sheets.devices import Setting
from rrp_sheets.devices.spoken import DeviceWords
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value, show
from rrp_sheets.render.measure import clean
from rrp_sheets.render.pack.model import Sheet
from rrp_sheets.render.pack.source import Source

MOST_ROWS = 500  # of a table
Rows = Sequence[Sequence[str]]


def sheets(source: Source) -> tuple[Sheet, ...]:
    """The tables that have rows."""
    made = [_devices(source), _helpers(source), *_tables(source), _gestures(source), _scene(source)]
    return tuple(sheet for sheet in made if sheet.rows)


def _sheet(
    source: Source, title: str, heads: Sequence[str], rows: Rows, *, widths: Sequence[float] = (),
    mono: Sequence[int] = (), note: str = "",
) -> Sheet:  # fmt: skip
    left = source.get("more", n=f"{len(rows) - MOST_ROWS:,}") if len(rows) > MOST_ROWS else ""
    shown = tuple(tuple(row) for row in rows[:MOST_ROWS])
    return Sheet(title, note, tuple(heads), shown, tuple(widths or [1.0] * len(heads)), left, tuple(mono))


def _devices(source: Source) -> Sheet:
    """Every device stream that rows which are on take in or drive."""
    used = dict.fromkeys([*source.sensors, *(d.stream.id for d in source.drivers)])
    rows = []
    for stream in (source.checked.graph.streams[s] for s in used):
        if stream.device is None:
            continue
        kind = stream.device.type
        words = kind.words(source.words.language)
        settings = [
            source.get(
                "material.setting",
                name=words.setting(setting.name),
                value=_value(source, stream.settings.get(name), setting, words),
            )
            for name, setting in kind.settings.items()
            if stream.settings.get(name) not in (None, "", False)
        ]
        rows.append((clean(stream.name), clean(stream.device.name), clean("; ".join(settings))))
    heads = (source.get("c.stream"), source.get("c.device"), source.get("c.settings"))
    return _sheet(source, source.get("material.devices"), heads, rows, widths=(1, 1, 2))


def _value(source: Source, value: Value, setting: Setting, words: DeviceWords) -> str:
    if setting.kind == "duration" and isinstance(value, int):
        return source.words.duration(value)
    if isinstance(value, (tuple, list)):
        return source.words.in_a_row([str(v) for v in value])
    if setting.kind == "language" and isinstance(value, str):
        return words.value(source.checked.robot.languages.get(value, value))
    if isinstance(value, str):
        return words.said(value, setting.kind)
    return f"{show(value)} {words.value(setting.unit)}".strip()


def _helpers(source: Source) -> Sheet:
    rows = [
        (clean(h.name.text), source.listed_cells(h.inputs), h.formula.text.strip())
        for h in source.checked.workbook.helpers
    ]
    heads = (source.get("c.name"), source.get("c.inputs"), source.get("c.formula"))
    return _sheet(source, source.get("material.helpers"), heads, rows, widths=(1, 1, 3), mono=(2,))


def _tables(source: Source) -> list[Sheet]:
    names = {key(n): n for n in source.checked.workbook.sheets}
    made = []
    for name, table in source.checked.workbook.tables.items():
        filled = [[clean(cell) for cell in row] for row in table if any(cell.strip() for cell in row)]
        if not filled:
            continue
        wide = max(len(row) for row in filled)
        padded = [[*row, *[""] * (wide - len(row))] for row in filled]
        keep = [i for i in range(wide) if any(row[i] for row in padded)]
        rows = [[row[i] for i in keep] for row in padded]
        title = source.get("material.table", name=clean(names.get(name, name)))
        made.append(_sheet(source, title, rows[0], rows[1:]))
    return made


def _gestures(source: Source) -> Sheet:
    rows = []
    for frame in source.checked.workbook.gestures:
        joints = [f"{frame.headers.get(name, name)}: {cell.text}" for name, cell in frame.joints.items() if cell.text]
        rows.append((clean(frame.name.text), clean(frame.time.text), clean("; ".join(joints))))
    heads = (source.get("c.gesture"), source.get("c.time"), source.get("c.joints"))
    return _sheet(source, source.get("material.gestures"), heads, rows, widths=(1.5, 0.5, 3))


def _scene(source: Source) -> Sheet:
    scene = source.checked.workbook.scene or ()
    rows = [[clean(cell.text) for cell in (r.time, r.thing, r.does, r.value)] for r in scene]
    heads = [source.get(f"c.{name}") for name in ("time", "thing", "does", "value")]
    note = source.get("material.scene_note")
    return _sheet(source, source.get("material.scene"), heads, rows, widths=(1, 1, 1, 2), note=note)
