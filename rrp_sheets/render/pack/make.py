"""Makes a workbook's ethics pack as data: its tables of devices, helpers, gestures and scene, and its behaviours."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import asdict
from functools import partial
from typing import Literal

from rrp_sheets.checks import Checked
from rrp_sheets.diagnostics import Diagnostic
from rrp_sheets.errors import SheetsError
from rrp_sheets.graph import BehaviourGraph
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key
from rrp_sheets.model.values import Value, show
from rrp_sheets.model.workbook import Behaviour
from rrp_sheets.render.diagram import draw_diagram, draw_legend
from rrp_sheets.render.pack import acts, body, front, model, movements, people, study
from rrp_sheets.render.pack.front import Print
from rrp_sheets.render.pack.model import BehaviourPart, Changes, Figure, Pack, Sheet, TestSheetResult
from rrp_sheets.render.pack.source import Source
from rrp_sheets.render.sentences import Rows, explain
from rrp_sheets.render.style import clean, typeset
from rrp_sheets.render.texts import texts
from rrp_sheets.robots import Setting
from rrp_sheets.robots.catalogue import DeviceWords
from rrp_sheets.texts import capital, translate
from rrp_sheets.workbook import Reading
from rrp_sheets.workbook.schema import FIELDS

MOST_FINDINGS = 300
MOST_ROWS = 500  # of a table
MOST_DRAWN = 2_000  # rows; a hundred pages
MOST_TOLD = 8  # rows that a paragraph tells; of more the sentences are enough
_SECONDS = 20.0  # for one diagram's layout
_AUTHORS = re.compile(r"\s*[;\n]\s*")
Paper = Literal["a4", "letter"]
Pictures = dict[str, str]
"""SVG texts by file name."""
Draw = Callable[..., tuple[tuple[Figure, ...], list[str]]]


def make_pack(
    reading: Reading, checked: Checked, this: Print, *, language: str = "en", tests: Sequence[TestSheetResult] = (),
    tests_note: str = "", changes: Changes | None = None, draft: bool = False, drawn: bool = True,
    draw_poses: movements.Draw | None = None,
) -> tuple[Pack, Pictures]:  # fmt: skip
    """Make the pack of a checked workbook, and its diagrams by the names under which it refers to them.

    The workbook may have errors: then it is marked as a draft on every page, as with `draft`. The `language` is that of
    the program's own words, `tests_note` a remark on all tests; unless `drawn` it has no diagrams, only texts.
    `draw_poses` draws the robot in the poses of its gestures; without it they have words only.
    """
    words = texts(language)
    source = Source(reading, checked, words, Rows(checked.graph, checked.workbook, words))
    get, said = source.get, acts.says(source)
    behaviours, pictures = behaviour_parts(source, changes, drawn=drawn)
    left = len(source.findings) - MOST_FINDINGS
    errors = checked.report.errors
    lacks = study.missing(source)
    incomplete = get("draft_missing") if lacks else get("draft") if draft else ""
    status = source.count("draft_errors", len(errors)) if errors else incomplete
    signing = ("researcher", "operator") if status else ("researcher", "board", "operator")
    authors = _AUTHORS.split(source.protocol("Authors"))
    return (
        Pack(
            language=language, title=front.title_of(source, this.name), status=status,
            version=clean(source.protocol("Version")), reference=clean(source.protocol("Ethics reference")),
            mode=study.mode(source), digest=reading.digest, purpose=source.protocol("Purpose"),
            authors=tuple(clean(name) for name in authors if name.strip()),
            facts=front.facts(source, this), happens=source.protocol(people.HAPPENS),
            summary=front.summary(source, said), glance=front.glance(source, said),
            numbers=front.numbers(source, said),
            findings=tuple(_finding(source, n, d) for n, d in enumerate(source.findings[:MOST_FINDINGS], 1)),
            findings_left_out=get("more", n=left) if left > 0 else "",
            sensed=people.sensed(source), kept=people.kept(source), says=said,
            says_note=get("says.by_hand_open" if front.is_open(said) else "says.by_hand"),
            makes=acts.makes(source),
            movements=movements.movements(source, pictures, draw_poses), acts=acts.acts(source),
            cautions=acts.cautions(source),
            rivals=acts.rivals(source), hand=people.hand(source),
            hand_title=get("hand.title" if source.buttons else "hand.title_none"),
            hand_note=get("hand.note" if source.buttons else "hand.note_none"), always=people.always(source),
            stops=people.stops(source), tests=tuple(tests),
            tests_note=tests_note,
            behaviours=behaviours,
            connectors=tuple(sorted({s.connector.name for b in checked.graph.behaviours for s in b.steps})),
            sheets=sheets(source), changes=changes, consent=people.consent(source),
            statements=people.statements(source), meets=study.meets(source), missing=lacks,
            missing_note=study.missing_note(source, study.count(lacks)),
            missing_where=study.missing_where(source),
            study=study.stated(source, study.STUDY, marked=False, front=study.FRONT),
            benefits=study.stated(source, study.BENEFITS, marked=False), risks=study.risks(source),
            risks_note=study.risks_note(source), body=body.body(source), body_note=body.note(source),
            operator=people.operator(source),
            signatures=tuple(get(f"signatures.{who}") for who in signing),
        ),
        pictures,
    )  # fmt: skip


def _finding(source: Source, flag: int, found: Diagnostic) -> model.OpenFinding:
    where, row = (clean(found.address.sheet), found.address.row) if found.address else ("", 0)
    severity = source.get(f"open.{found.severity.value}")
    said = (clean(translate(text, source.words.language)) for text in (found.message, found.remedy))
    return model.OpenFinding(flag, severity, where, row, *said)


def sheets(source: Source) -> tuple[Sheet, ...]:
    """Return the tables that have rows."""
    made = [_run(source), _devices(source), _helpers(source), *_tables(source), _gestures(source), _scene(source)]
    return tuple(sheet for sheet in (*made, _commands(source)) if sheet.rows)


def _sheet(
    source: Source, title: str, heads: Sequence[str], rows: Sequence[Sequence[str]], widths: Sequence[float],
    mono: tuple[int, ...] = (), note: str = "",
) -> Sheet:  # fmt: skip
    left = source.get("more", n=f"{len(rows) - MOST_ROWS:,}") if len(rows) > MOST_ROWS else ""
    return Sheet(title, note, tuple(heads), tuple(map(tuple, rows[:MOST_ROWS])), tuple(widths), left, mono)


def _own_sheet(
    source: Source, title: str, columns: Mapping[str, float], rows: Sequence[Sequence[str]],
    mono: tuple[int, ...] = (), note: str = "",
) -> Sheet:  # fmt: skip
    """Return a table whose title and columns (with their relative widths) are entries of the program's texts."""
    heads = [source.get(f"c.{name}") for name in columns]
    return _sheet(source, source.get(f"material.{title}"), heads, rows, list(columns.values()), mono, note)


def _run(source: Source) -> Sheet:
    given = {n: text for n in study.RUN if (text := clean(source.protocol(n)))}
    language = source.words.language
    rows = [(study.field_label(source, n), FIELDS[key(n)].shown(text, language)) for n, text in given.items()]
    return _own_sheet(source, "run", {"name": 1, "value": 3}, rows)


def _devices(source: Source) -> Sheet:
    """Return the table of the device streams that active rows take in or drive."""
    used = dict.fromkeys([*source.sensors, *(d.stream.id for d in source.drivers)])
    rows = []
    for stream in (source.checked.graph.streams[s] for s in used):
        if stream.device is None:
            continue
        kind = stream.device.type
        words, language = kind.words(source.words.language), source.words.language
        settings = []
        for name, setting in kind.settings.items():
            if (value := stream.settings.get(name)) not in (None, "", False):
                shown = _value(source, value, setting, words)
                label = japanese.in_both(japanese.SETTINGS, setting.name, language)
                settings.append(source.get("material.setting", name=label, value=shown))
        device = japanese.in_both({words.title or stream.device.name: stream.device.name}, stream.device.name, language)
        rows.append((clean(stream.name), clean(device), clean("; ".join(settings))))
    return _own_sheet(source, "devices", {"stream": 1, "device": 1, "settings": 2}, rows)


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
    return _own_sheet(source, "helpers", {"name": 1, "inputs": 1, "formula": 3}, rows, mono=(2,))


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
        made.append(_sheet(source, title, rows[0], rows[1:], [1.0] * len(keep)))
    return made


def _gestures(source: Source) -> Sheet:
    rows = []
    for frame in source.checked.workbook.gestures:
        joints = [f"{frame.headers.get(name, name)}: {cell.text}" for name, cell in frame.joints.items() if cell.text]
        rows.append((clean(frame.name.text), clean(frame.time.text), clean("; ".join(joints))))
    return _own_sheet(source, "gestures", {"gesture": 1.5, "time": 0.5, "joints": 3}, rows)


def _scene(source: Source) -> Sheet:
    scene = source.checked.workbook.scene or ()
    rows = [[clean(cell.text) for cell in (r.time, r.thing, r.does, r.value)] for r in scene]
    if source.words.language == "ja":
        for row in rows:
            free = key(row[2]) in japanese.FREE
            row[1:] = japanese.japanese_thing(row[1]), row[2], row[3] if free else japanese.japanese_value(row[3])
            row[2] = japanese.japanese(japanese.VERBS, [row[2]])[0]
    columns = {"time": 1, "thing": 1, "does": 1, "value": 2}
    return _own_sheet(source, "scene", columns, rows, note=source.get("material.scene_note"))


def _commands(source: Source) -> Sheet:
    rows = [(source.get(f"material.command_{name}"), command) for name, command in people.commands(source).items()]
    return _own_sheet(source, "commands", {"does": 1, "command": 2}, rows, mono=(1,))


def set_pack(pack: Pack, pictures: Pictures, paper: Paper = "a4") -> tuple[bytes, list[str]]:
    """Return the pack as a PDF, and warnings in words, of a missing font for example.

    Raises:
        SheetsError: Typst could not set it.
    """
    words = texts(pack.language)
    legend, wide, _ = draw_legend(pack.language, pack.connectors)
    own = {name.removeprefix("pack."): text for name, text in words.entries.items() if name.startswith("pack.")}
    data = {
        "paper": {"a4": "a4", "letter": "us-letter"}[paper],
        "t": own,
        "quoted": own["says.quoted"],
        "page_n_of_m": words.get("page.n_of_m"),
        "legend": {"title": words.get("legend.title"), "alt": words.get("legend.alt"), "width": wide},
        "pack": asdict(pack),
    }
    return typeset("pack.typ", data, {**pictures, "legend.svg": legend}, "pdf")


def behaviour_parts(
    source: Source, changes: Changes | None, *, drawn: bool = True
) -> tuple[tuple[BehaviourPart, ...], Pictures]:
    """Return the parts of all behaviours in the order of the sheets, and their diagrams."""
    pictures: Pictures = {}
    draw: Draw = partial(_figures, pictures=pictures) if drawn else lambda *_: ((), [])
    written = {key(b.name): b for b in source.checked.workbook.behaviours}
    marks = changes.marks if changes else {}
    parts = []
    for graph in source.checked.graph.behaviours:
        behaviour = written[graph.key]
        groups = {n: capital(clean(text)) for n, text in behaviour.headings.items()}
        parts.append(_part(source, graph, behaviour, groups, marks.get(graph.key, {}), draw))
    return tuple(parts), pictures


def _part(
    source: Source, graph: BehaviourGraph, behaviour: Behaviour, groups: Mapping[int, str], marks: Mapping[int, str],
    draw: Draw,
) -> BehaviourPart:  # fmt: skip
    (said,) = explain(
        source.checked.graph, source.checked.workbook, [graph], language=source.words.language, labels=True
    )
    flags = source.flags(graph.key)
    figures, why = draw(source, graph, flags, marks)
    off = graph.key not in source.checked.run.behaviours
    notes = [source.get("behaviours.starts_off")] if off and graph.steps else []
    sentences = tuple(
        model.Sentence(
            r.number, r.text, tuple(flags.get(r.number, ())), marks.get(r.number, ""), groups.get(r.number, "")
        )
        for r in said.rows
    )
    rows = tuple(
        model.TableRow(
            r.number, clean(source.listed_cells(r.inputs)), clean(r.connector.text), r.formula.text.strip(),
            clean(r.output.text), r.on, f"{r.priority:g}" if r.priority else "",
            # notes, and before them the texts of other columns that are for people
            clean(" · ".join(text if name == "Notes" else f"{name}: {text}" for name, text in r.remarks.items())),
            marks.get(r.number, ""), groups.get(r.number, ""),
        )
        for r in behaviour.rows
    )  # fmt: skip
    paragraph = said.paragraph if len(said.rows) <= MOST_TOLD else ""
    note = source.words.sentences([*notes, *why])
    return BehaviourPart(said.name, *said.lists(source.words), paragraph, note, figures, sentences, rows)


def _figures(
    source: Source, graph: BehaviourGraph, flags: Mapping[int, list[int]], marks: Mapping[int, str], pictures: Pictures
) -> tuple[tuple[Figure, ...], list[str]]:
    """Return the diagrams, and in words why there are none."""
    if not graph.steps:
        return (), [source.get("behaviours.empty")]
    if len(graph.steps) > MOST_DRAWN:
        return (), [source.get("behaviours.too_long", n=f"{len(graph.steps):,}", most=f"{MOST_DRAWN:,}")]
    problems = {row: numbers[0] for row, numbers in flags.items()}
    words = {row: source.get(f"mark.{mark}") for row, mark in marks.items()}
    try:
        pages = draw_diagram(
            source.checked.graph, graph, problems=problems, words=words, timeout=_SECONDS,
            language=source.words.language, upright=True,
        )  # fmt: skip
    except SheetsError as error:
        return (), [source.get("behaviours.no_diagram", why=translate(error.message, source.words.language))]
    figures = []
    for page in pages:
        name = f"figure-{len(pictures) + 1}.svg"
        pictures[name] = page.svg
        first, last = page.rows
        place = {"part": page.part, "parts": page.parts, "first": first, "last": last}
        caption = source.get(f"behaviours.{'rows' if page.parts == 1 else 'part'}", name=page.title, **place)
        wide, high = page.width * page.scale, page.height * page.scale
        figures.append(Figure(name, page.alt, caption, wide, high, first, last))
    return tuple(figures), []
