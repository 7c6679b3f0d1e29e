"""The templates: a small behaviour that works with everything a protocol needs around it, and the same without rows.

Templates and examples are written in the reader's language.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.model import japanese
from rrp_sheets.model.names import argument_name, key
from rrp_sheets.texts import N_, LazyMessage, translate
from rrp_sheets.workbook.files import already_there, make_workbook
from rrp_sheets.workbook.maker import Offers
from rrp_sheets.workbook.raw import text_sheet
from rrp_sheets.workbook.schema import (
    BEHAVIOUR,
    DEVICES,
    FIELDS,
    HELPERS,
    PROTOCOL,
    SCENE,
    SHEETS,
    TEST,
    TITLES,
    Recognised,
    SheetKind,
    field_key,
    recognise,
    setting_header,
    title_of,
)

_READ_ME = (
    N_("Your robot's protocol"),
    "",
    N_("This workbook tells the robot what to do, one step a row. Try it out: nothing can harm the simulated robot."),
    "",
    N_("Begin with the sheet Tracking. Read its three rows from top to bottom:"),
    N_("1.  Whenever the robot sees a red ball, its distance is worked out. The result is called Distance."),
    N_("2.  Only distances below half a metre go on. They are called Near."),
    N_("3.  Whenever there is a near ball, the head follows it."),
    "",
    N_("Try it: change 0.5 to 1 in the sheet Helpers, save the workbook, and look how the simulated robot changes."),
    "",
    N_("The sheets"),
    N_("•  Tracking is a behaviour. A workbook may have several; the name of the sheet is the name of the behaviour."),
    N_("•  Devices names the robot's sensors and actuators, with their settings."),
    N_("•  Helpers keeps calculations and numbers that you use in several places."),
    N_("•  Scene is what happens in the simulator: when a ball appears, when somebody comes in."),
    N_("•  Check holds a test: values to send and what should come out; rrp-sheets test runs it."),
    N_("•  Protocol says what the session is for, who takes part and what is kept. Ethics boards ask for most fields."),
    N_("•  Risks is a sheet for an ethics board: what could go wrong. Add it; the program proposes rows for it."),
    N_("•  Lists holds the names for the drop-down lists. You may add sheets of your own, such as this one."),
    "",
    N_("Good to know"),
    N_("•  Click on a cell: a note says what belongs there. A yellow cell holds a name that is not known."),
    N_("•  Capitals, spaces, hyphens and underscores in names make no difference: Red ball and red_ball are one name."),
    N_("•  Inside a formula a name is written without spaces: Red ball is redBall."),
    N_("•  To switch a row off, write FALSE into its column On. A row that begins with # is a comment."),
    N_("•  Before every session: rrp-sheets check shows what is wrong, and in which cell."),
)

_TRACKING = (
    ("Red ball", "map", "redBall.distance", "Distance", "how far the ball is from the robot, in metres"),
    ("Distance", "filter", "distance < reach", "Near", "reach is a number in the sheet Helpers"),
    ("Near", "subscribe", "", "Head tracker", "the head follows the ball"),
)
_SETTINGS = ("Mode", "Text", "Name", "Zone")  # of a tracker, of speech, of a gesture, of a touch
_DEVICES = (
    ("Red ball", "Red ball", "", "", "", "", "a red ball in the picture of the robot's camera"),
    ("Head tracker", "Tracker", "Head", "", "", "", "follows with the head only"),
)
_HELPERS = (("Reach", "", "0.5", "metres: nearer than this the head follows the ball"),)
_SCENE = (
    ("1", "Red ball", "appears", "at 1, 0, 0.4", "metres from the robot: forward, left, up"),
    ("3", "Red ball", "moves", "to 0.4, 0.1, 0.4 in 3 s", "comes near"),
    ("9", "Red ball", "disappears", "", ""),
)
_CHECK = (
    ("0", "Red ball", "distance=0.8", "", "too far away"),
    ("100", "Near", "", "nothing", ""),
    ("1000", "Red ball", "distance=0.3", "", ""),
    ("1000", "Near", "", "0.3", ""),
)
_FIRST_VALUES = {
    "Title": "My first protocol", "Version": "0.1", "Purpose": "The robot's head follows a red ball that is near.",
    "Data kept":
        "Every value with its time, pictures of the robot's camera, a film of the robot, and the sound of what it says",
    "Robot": "nao", "Engine": "frame", "Frame rate": "30", "Run": "Tracking", "Seed": "1", "Time limit": "10 min",
    "Face memory": "ends with the run", "Camera pictures": "kept", "Language": "English",
}  # fmt: skip
_HEADINGS = {
    "Investigators": N_("The study"), "Participants": N_("The participants"), "Data kept": N_("Data"),
    "Consent and capacity": N_("Consent"), "Participants are told": N_("What a person does by hand"),
    "Robot": N_("How it runs"),
}  # fmt: skip
"""The comments that stand above some fields of a new Protocol sheet."""


def _protocol(robot: str, language: str = "en") -> list[tuple[str, str]]:
    """Every field in the order of the schema, with its first value, and the comments that group them."""
    own = _JAPANESE_PROTOCOL if language == "ja" else {}
    rows = []
    for field in FIELDS.values():
        if field.name in _HEADINGS:
            rows.append((f"# {translate(_HEADINGS[field.name], language)}", ""))
        value = robot if field.name == "Robot" else _FIRST_VALUES.get(field.name, "")
        rows.append((field.name_in(language), own.get(field.name) or field.shown(value, language)))
    return rows


_JAPANESE_TRACKING = (
    ("赤いボール", "map", "赤いボール.距離", "距離", "ロボットからボールまでの距離（メートル）"),
    ("距離", "filter", "距離 < 届く範囲", "近い", "「届く範囲」はシート「補助の式」の数です"),
    ("近い", "subscribe", "", "頭の追跡", "頭がボールを追います"),
)
_JAPANESE_SETTINGS = tuple(setting_header(name, "ja") for name in _SETTINGS)
_JAPANESE_DEVICES = (
    ("赤いボール", "赤いボール", "", "", "", "", "ロボットのカメラに映る赤いボール"),
    ("頭の追跡", "追跡", "頭", "", "", "", "頭だけで追います"),
)
_JAPANESE_HELPERS = (("届く範囲", "", "0.5", "メートル。これより近いボールを頭が追います"),)
_JAPANESE_SCENE = (
    ("1", "赤いボール", "現れる", "位置 1, 0, 0.4", "ロボットからのメートル：前、左、上"),
    ("3", "赤いボール", "動く", "行き先 0.4, 0.1, 0.4 所要時間 3秒", "近づきます"),
    ("9", "赤いボール", "消える", "", ""),
)
_JAPANESE_CHECK = (
    ("0", "赤いボール", "距離=0.8", "", "遠すぎます"),
    ("100", "近い", "", "なし", ""),
    ("1000", "赤いボール", "距離=0.3", "", ""),
    ("1000", "近い", "", "0.3", ""),
)
_JAPANESE_PROTOCOL = {
    "Title": "はじめてのプロトコル", "Purpose": "近くにある赤いボールを、ロボットの頭が追います。",
    "Data kept": "すべての値と時刻、ロボットのカメラの画像、ロボットの動画、ロボットが話した音声", "Run": "頭で追う",
    "Time limit": "10分", "Language": "日本語",
}  # fmt: skip


def _japanese_sheets(robot: str) -> dict[str, list[list[str]]]:
    """The rows of the guided template in Japanese."""
    filled = partial(_filled, language="ja")
    tables = (
        (DEVICES, filled(DEVICES, _JAPANESE_DEVICES, _JAPANESE_SETTINGS)),
        (HELPERS, filled(HELPERS, _JAPANESE_HELPERS)), (SCENE, filled(SCENE, _JAPANESE_SCENE)),
    )  # fmt: skip
    return {
        "はじめに": [[translate(line, "ja")] for line in _READ_ME],
        "頭で追う": filled(BEHAVIOUR, _JAPANESE_TRACKING),
        **{kind.called[0]: rows for kind, rows in tables},
        "確認": filled(TEST, _JAPANESE_CHECK),
        PROTOCOL.called[0]: filled(PROTOCOL, _protocol(robot, "ja")),
    }


def template_sheets(robot: str = "nao", language: str = "en") -> dict[str, list[list[str]]]:
    """The rows of the guided template by sheet name."""
    if language == "ja":
        return _japanese_sheets(robot)
    return {
        "Read me": [[line] for line in _READ_ME], "Tracking": _filled(BEHAVIOUR, _TRACKING),
        "Devices": _filled(DEVICES, _DEVICES, _SETTINGS), "Helpers": _filled(HELPERS, _HELPERS),
        "Scene": _filled(SCENE, _SCENE), "Check": _filled(TEST, _CHECK),
        "Protocol": _filled(PROTOCOL, _protocol(robot)),
    }  # fmt: skip


def _filled(
    kind: SheetKind, rows: Sequence[Sequence[str]], others: Sequence[str] = (), language: str = "en"
) -> list[list[str]]:
    """Header and rows of a new sheet; what stands behind the required columns and the others is the notes."""
    header = kind.header(others, language)
    filled = [*(c.header(language) for c in kind.required), *others, kind.column("Notes").header(language)]
    return [header, *([dict(zip(filled, row, strict=False)).get(h, "") for h in header] for row in rows)]


def empty_sheets(robot: str = "nao", language: str = "en") -> dict[str, list[list[str]]]:
    """The same sheets with their columns only, for somebody who begins anew; the scene has a ball that comes and stays.

    No test: one without rows could not fail, and the check would say so.
    """
    guided = template_sheets(robot, language)
    read_me, *_, check, _ = guided
    scene, protocol = title_of("scene", language), title_of("protocol", language)
    mine = {"title", "purpose", "datakept"}
    return {
        **{name: rows[:1] for name, rows in guided.items() if name not in (read_me, check)},
        scene: guided[scene][:-1],
        protocol: [[field, "" if field_key(field) in mine else value] for field, value in guided[protocol]],
    }


def new_workbook(
    path: Path | str, offers: Offers, *, robot: str = "nao", language: str = "en", empty: bool = False
) -> Path:
    """Make a new workbook from the guided template, or without rows; an existing file is never overwritten.

    Raises SheetsError when there is such a file, its name does not end in .xlsx, or it cannot be written.
    """
    path = Path(path)
    refuse_name(path)
    sheets = (empty_sheets if empty else template_sheets)(robot, language)
    for line in list(sheets.values())[-1]:  # the Protocol's
        if field_key(line[0]) == "title":
            line[1] = path.stem
    return make_workbook(sheets, path, offers, language=language, replace=False)


def refuse_name(path: Path) -> None:
    """Raise SheetsError when a new workbook cannot have this name: it is taken, or does not end in .xlsx."""
    if path.suffix.casefold() != ".xlsx":
        message = N_("A new workbook's name ends in .xlsx; “{name}” does not.", name=path.name)
        raise SheetsError(message, N_("Try “{name}”.", name=f"{path.stem}.xlsx"))
    if path.exists():
        raise already_there(path)


_JOINTS = (
    "HeadYaw", "HeadPitch", "RShoulderPitch", "RShoulderRoll", "RElbowYaw", "RElbowRoll", "RWristYaw", "RHand",
    "LShoulderPitch", "LShoulderRoll", "LElbowYaw", "LElbowRoll", "LWristYaw", "LHand",
)  # fmt: skip


def beginning(kind: str, robot: str = "nao", language: str = "en") -> list[list[str]]:
    """The rows that a new sheet of a kind has.

    >>> beginning("test")
    [['Time (ms)', 'Stream', 'Send', 'Expect', 'Notes']]
    """
    if kind == "table":
        return [["名前", "値"]] if language == "ja" else [["Name", "Value"]]
    others = {"devices": _JAPANESE_SETTINGS if language == "ja" else _SETTINGS, "gestures": _JOINTS}.get(kind, ())
    rows = list(empty_sheets(robot, language).values())[-1][1:] if kind == "protocol" else []
    return [SHEETS[kind].header(others, language), *([f, "" if field_key(f) == "run" else value] for f, value in rows)]


def place_of(kind: str, sheets: Mapping[str, str]) -> str:
    """The sheet that a new one of a kind stands before; empty: at the end.

    `sheets` has all sheets in their order, with the kind of each; empty for the user's own.

    >>> place_of("behaviour", {"Read me": "", "Tracking": "behaviour", "Devices": "devices", "Lists": ""})
    'Devices'
    """
    order, names = list(TITLES), list(sheets)
    alike = [i for i, name in enumerate(names) if sheets[name] == kind]
    own = order.index(kind)
    ranks = {} if kind == "table" else {i: order.index(sheets[name]) for i, name in enumerate(names) if sheets[name]}
    before = [i for i, rank in ranks.items() if rank < own]
    if last := alike or before:
        return names[last[-1] + 1] if last[-1] + 1 < len(names) else ""
    return next((names[i] for i, rank in ranks.items() if rank > own), "")


# ---- examples in Japanese
_NAMES = frozenset(("inputs", "output", "stream", "tested", "helper", "parameters", "gesture"))
"""Kinds of the cells that hold names of streams, helpers and gestures."""
_NAME = re.compile(r"[^\s,][^,\n]*")
_CUE = re.compile(r"[^\s+][^+]*?(?=\s*\+)")
_PIECE = re.compile(r"\"[^\"]*\"|'[^']*'|(?<![\w.\[])[^\W\d]\w*(\s*\()?")


def in_japanese(
    sheets: Mapping[str, Sequence[Sequence[str]]], own: Callable[[str], str] | None = None, *, declare: bool = True
) -> dict[str, list[list[str]]]:
    """Return the rows of an English example with Japanese titles, headers and words.

    Args:
        sheets: the rows by sheet name. One with a misspelt header stays as it is, as do
            headers of the user's own tables.
        own: returns the Japanese word for a name, a note or a text of the example; without it, the catalogue does.
        declare: without `own`, whether streams called as devices have Japanese names, declared in the sheet Devices.
    """
    words = {**japanese.MOVES, **(japanese.DEVICES if declare else {})}

    def of_example(text: str) -> str:
        shown = translate(LazyMessage(text, msgctxt="example"), "ja")
        return shown if shown != text else japanese.japanese_word(words, text)

    made = _Japanese(sheets, own or of_example)
    return made.sheets() if own or not declare else made.declared()


class _Japanese:
    """Writer of an example in Japanese."""

    def __init__(self, sheets: Mapping[str, Sequence[Sequence[str]]], own: Callable[[str], str]) -> None:
        self._rows, self._own = sheets, own
        self._known = {name: recognise(text_sheet(name, rows)) for name, rows in sheets.items()}
        self._titles = {name: self._title(name, what.kind) for name, what in self._known.items() if what.kind}
        self._arguments: dict[str, str] = {}  # of formulas, by key
        self._given: set[str] = set()  # keys of the names of devices, outputs and helpers
        self._helpers: set[str] = set()
        self._used: list[str] = []  # names of streams and helpers, as they are written

    def _title(self, name: str, kind: SheetKind) -> str:
        return kind.called[0] if kind.names(name) and not kind.any_name else self._own(name)

    def sheets(self) -> dict[str, list[list[str]]]:
        """Return the rows by sheet."""
        names = []
        for name, what in self._known.items():
            for line in self._lines(name, what):
                for header, text in line.items():
                    column = what.kind.column(header) if what.kind else None
                    found = _NAME.findall(text) if column is not None and column.kind in _NAMES else ()
                    names += [self._split(one.strip())[2] for one in found]
                    gives = column is not None and column.kind in ("stream", "output", "helper", "gesture")
                    self._given |= set(map(key, found)) if gives else set()
                    self._helpers |= set(map(key, found)) if header == "Name" else set()
        self._used = names
        self._arguments = {key(argument_name(name)): argument_name(self._name(name)) for name in names}
        return {self._titles.get(name, name): self._sheet(name, what) for name, what in self._known.items()}

    def declared(self) -> dict[str, list[list[str]]]:
        """Return the rows by sheet, with the devices that streams are called by: a robot knows only English names."""
        made = self.sheets()
        sheet = next((name for name, what in self._known.items() if what.kind is DEVICES), "")
        lines = self._lines(sheet, self._known[sheet]) if sheet else []
        devices = {key(name): own for own, name in reversed(japanese.DEVICES.items())}
        used = dict.fromkeys(key(name.removesuffix(" done")) for name in self._used)
        had = {key(line.get("Stream", "")) for line in lines}
        rows = [devices[k] for k in used if k in devices and k not in had]
        at = self._known[sheet].columns if sheet else {"Stream": 1, "Device": 2}
        for own in rows:
            table = made.setdefault(self._titles.get(sheet, DEVICES.called[0]), [["ストリーム", "デバイス"]])
            table.append([own if c in (at["Stream"], at["Device"]) else "" for c, _ in enumerate(table[0], 1)])
        return made

    def _lines(self, name: str, what: Recognised) -> list[dict[str, str]]:
        """Return the rows below the header, each as its texts by standard header."""
        if what.kind is None or what.near is not None:
            return []
        headers = {at: header for header, at in what.columns.items()} | dict(what.others)
        rows = self._rows[name][what.row :]
        return [{header: row[at - 1] for at, header in headers.items() if at <= len(row)} for row in rows]

    def _sheet(self, name: str, what: Recognised) -> list[list[str]]:
        rows = [list(row) for row in self._rows[name]]
        if what.near is not None:
            return rows
        if what.kind is None:
            return [rows[0], *([self._own(text) for text in row] for row in rows[1:])]
        settings = what.kind is DEVICES
        for header, at in what.columns.items():
            rows[what.row - 1][at - 1] = what.kind.column(header).header("ja")
        for at, header in what.others.items():
            rows[what.row - 1][at - 1] = setting_header(header, "ja") if settings else header
        headers = {header: at for at, header in what.others.items()} | dict(what.columns)
        for row, line in zip(rows[what.row :], self._lines(name, what), strict=True):
            if row and row[0].startswith("#"):
                row[0] = f"# {self._own(row[0].lstrip('# '))}"
                continue
            for header, text in line.items():
                row[headers[header] - 1] = self._cell(what.kind, header, line) if text else ""
        return rows

    def _cell(self, kind: SheetKind, header: str, line: Mapping[str, str]) -> str:
        text, cells = line[header], kind.column(header).kind
        if cells in _NAMES:
            return _NAME.sub(lambda match: self._name(match[0].rstrip()), text)
        if cells in ("notes", "prose"):
            return self._own(text)
        if cells == "formula":
            return _PIECE.sub(self._piece, text)
        if cells == "amount":
            return _CUE.sub(lambda match: self._name(match[0]), text) if kind is SCENE else text
        if cells in ("fieldname", "fieldvalue"):
            return self._field(header, line)
        own = self._word(header, line, cells)
        if cells in ("send", "expect"):
            return own if own != text else _PIECE.sub(self._text, self._own(text))
        return own

    def _word(self, header: str, line: Mapping[str, str], cells: str) -> str:
        """Return a word of the program's in Japanese, or what else stands in a cell for one."""
        text = line[header]
        if cells == "actor":
            return japanese.japanese_thing(text)
        if cells == "value":
            return self._own(text) if key(line.get("Does", "")) in japanese.FREE else japanese.japanese_value(text)
        moves = japanese.MOVES if header == "Name" and line.get("Device") in ("Gesture", "Posture") else {}
        tables = {"device": japanese.DEVICES, "verb": japanese.VERBS, "expect": japanese.EXPECTED}
        words = tables.get(cells) or japanese.CHOICES.get(key(header), moves)
        known = key(text) in map(key, words.values())
        return japanese.japanese_word(words, text) if known or cells != "setting" else self._own(text)

    def _field(self, header: str, line: Mapping[str, str]) -> str:
        """Return the name of a field of the Protocol, or its value."""
        text, known = line[header], FIELDS.get(field_key(line.get("Field", "")))
        if header == "Field":
            return known.name_in("ja") if known else text
        if known is FIELDS["run"]:
            return _NAME.sub(lambda match: self._titles.get(match[0]) or self._own(match[0]), text)
        shown = known.shown(text, "ja") if known else text
        return shown if shown != text else self._own(text)

    def _name(self, text: str) -> str:
        sheet, mark, name = self._split(text)
        stem = name if key(name) in self._given else name.removesuffix(" done")
        return f"{self._titles.get(sheet, sheet)}{mark}{self._own(stem)}{name[len(stem) :]}"

    def _split(self, text: str) -> tuple[str, str, str]:
        """Split a name into that of its sheet, if it has one, and its own."""
        return text.partition("!") if text.partition("!")[0] in self._titles else ("", "", text)

    def _piece(self, match: re.Match[str]) -> str:
        """Write a text or a name of a formula; functions have names of their own."""
        word = match[0].removesuffix(match[1] or "")
        if match[0][0] in "\"'" or (match[1] and key(word) not in self._helpers):
            return self._text(match)
        return f"{self._arguments.get(key(word), word)}{match[1] or ''}"

    def _text(self, match: re.Match[str]) -> str:
        quote, text = match[0][0], match[0]
        return f"{quote}{self._own(text[1:-1])}{quote}" if quote in "\"'" else text
