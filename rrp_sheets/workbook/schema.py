"""Columns of every kind of sheet, by which a sheet is recognised: one table for reader, grid, help and all others."""

from __future__ import annotations

import re
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain

from rrp_sheets.model import japanese
from rrp_sheets.model.names import key, nearest
from rrp_sheets.texts import LANGUAGE_NAMES, N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.cleaning import clean_fields, clean_formula, clean_name, clean_prose
from rrp_sheets.workbook.raw import RawCell, RawSheet

LIST_PREFIX = "List_"
"""Prefix of the defined names of generated lists; the user's own names stay as they are."""


@dataclass(frozen=True, slots=True)
class CellKind:
    """Kind of the cells of a column.

    Attributes:
        name: the class of the cells in the grid, whose script chooses suggestions by it.
        pixels: width of the column in the grid.
        clean: folds what makes no difference.
        code: a formula or the like, shown in a fixed-width font.
        from_excel: what the spreadsheet program took for its own formula is the text.
        dates: a date is meant as a date.
        as_typed: for people only, so nothing about it is reported.
    """

    name: str
    pixels: int
    clean: Callable[[str], str] = clean_name
    code: bool = False
    from_excel: bool = False
    dates: bool = False
    as_typed: bool = False


CELLS = {
    kind.name: kind
    for kind in (
        CellKind("on", 40), CellKind("inputs", 136), CellKind("connector", 144), CellKind("output", 136),
        CellKind("formula", 232, clean_formula, code=True, from_excel=True),
        CellKind("notes", 240, str.strip, as_typed=True), CellKind("amount", 88), CellKind("text", 152),
        CellKind("stream", 152), CellKind("helper", 120), CellKind("parameters", 136),
        CellKind("device", 152), CellKind("setting", 112, clean_prose),
        CellKind("actor", 120), CellKind("verb", 104), CellKind("value", 224, clean_prose),
        CellKind("gesture", 136), CellKind("angle", 136, clean_prose),
        CellKind("tested", 136), CellKind("send", 192, clean_fields, code=True),
        CellKind("expect", 224, clean_fields, code=True),
        CellKind("fieldname", 160), CellKind("fieldvalue", 320, clean_prose, dates=True),
        CellKind("prose", 240, clean_prose, dates=True),
    )
}  # fmt: skip


@dataclass(frozen=True, slots=True)
class CellChoice:
    """A word that a cell may hold, with a line of help."""

    text: str
    help: str = ""


@dataclass(frozen=True, slots=True)
class Column:
    """A column of a kind of sheet.

    Attributes:
        name: the standard header.
        kind: a key of `CELLS`.
        width: in characters, in a new workbook.
        prompt: shown in the cells by spreadsheet programs.
        synonyms: other accepted headers; Japanese ones too, except on sheets whose headers many other tables have.
        help: the topic that F1 shows.
        offers: title of the drop-down's list.
        choices: entries of that list, when they are always the same.
        known: lists, or columns of the sheet, that hold the known names; a name in none of them is marked.
        required: a sheet without it is not of this kind; only what stands in such columns makes a row.
        offered: new sheets have it.
        effect: the robot acts on it; otherwise a changed cell leaves the behaviour the same.
    """

    name: str
    kind: str = "text"
    width: float = 16
    prompt: str = ""
    synonyms: tuple[str, ...] = ()
    help: str = ""
    offers: str = ""
    choices: tuple[CellChoice, ...] = ()
    known: tuple[str, ...] = ()
    required: bool = True
    offered: bool = True
    effect: bool = True

    @property
    def cells(self) -> CellKind:
        """The kind of its cells."""
        return CELLS[self.kind]

    def header(self, language: str) -> str:
        """Return the header of a new sheet in a language."""
        own = () if language == "en" else (s for s in self.synonyms if not s.isascii())
        return next(iter(own), self.name)


PLAIN = Column("", required=False)
"""A column of the user's own."""


@dataclass(frozen=True)
class SheetKind:
    """Columns and titles that make a sheet one of a kind.

    Attributes:
        name: in the code.
        title: name of a new sheet.
        shown: as messages call it.
        colour: of the header row and the tab.
        columns: in the order of a new sheet.
        any_name: a sheet of any name may be of this kind, so a header row that nearly fits is surely meant.
        other: pattern of the columns with headers of their own that belong to it too (the settings of devices, the
            joints of gestures), with `{header}` in its texts.
        usual: those of them that have a look of their own.
        called: Japanese names of a sheet of the kind, the first that of a new one.
    """

    name: str
    title: str
    shown: str
    colour: str
    columns: tuple[Column, ...]
    any_name: bool = False
    other: Column | None = None
    usual: tuple[Column, ...] = ()
    called: tuple[str, ...] = ()

    def names(self, sheet: str) -> bool:
        """Return whether a sheet's name tells that it is of this kind."""
        return key(sheet) in {self.name, *map(key, self.called)}

    @cached_property
    def required(self) -> tuple[Column, ...]:
        """The columns that every sheet of this kind has."""
        return tuple(c for c in self.columns if c.required)

    @cached_property
    def optional(self) -> tuple[Column, ...]:
        """The columns that may be missing."""
        return tuple(c for c in self.columns if not c.required)

    @cached_property
    def spellings(self) -> dict[str, str]:
        """The standard header for the key of every accepted spelling."""
        return {key(spelling): c.name for c in self.columns for spelling in (c.name, *c.synonyms)}

    def column(self, header: str) -> Column:
        """Return the column of a standard header, or of a header of its own."""
        known = next((c for c in (*self.columns, *self.usual) if c.name == header), None)
        usual = next((c for c in self.usual if c.name == japanese.standard(japanese.SETTINGS, header)), None)
        if usual is not None and known is None:
            return replace(usual, name=header)
        if known is not None or self.other is None or not header:
            return known or replace(PLAIN, name=header)
        setting = japanese.standard(japanese.SETTINGS, header)
        prompt, offers = N_(self.other.prompt, header=header), self.other.offers.format(header=setting)
        return replace(self.other, name=header, prompt=prompt, offers=offers)

    def header(self, others: Sequence[str] = (), language: str = "en") -> list[str]:
        """Return the header row of a new sheet with some headers of its own."""
        optional = (c.header(language) for c in self.optional if c.offered)
        return [*(c.header(language) for c in self.required), *others, *optional]


_NOTES = Column(
    "Notes", "notes", 32, N_("Anything you want to remember. The robot does not read it."),
    ("Comment", "メモ", "注記", "備考"), "keys", required=False, effect=False,
)  # fmt: skip
BEHAVIOUR = SheetKind("behaviour", "Behaviour", N_("a behaviour"), "D5E5EF", (
    Column("Input streams", "inputs", 22, N_("What this row listens to: a sensor, or the output of another row. "
           "Several are separated by commas. Blank: the output of the row above."),
           ("Inputs", "Input", "From", "入力ストリーム", "入力"), "devices", "Streams",
           known=("Output stream", "Streams", "Sensors")),
    Column("Connector", "connector", 15, N_("What this row does with the input: map calculates, filter lets "
           "pass, subscribe lets the robot act."), ("Operator", "コネクター", "コネクタ"), "connectors",
           "Connectors", known=("Connectors",)),
    Column("Formula", "formula", 36, N_("A calculation with the inputs, such as redBall.distance < 0.5. A space in a "
           "stream's name is left out: Red ball is redBall. No = is needed."),
           ("Parameter", "Parameter formula", "式", "数式"), "formulas"),
    Column("Output stream", "output", 20, N_("A new name for the result; for subscribe the actuator that acts. "
           "Blank: the next row takes it."), ("Output", "To", "出力ストリーム", "出力"), "devices", "Streams"),
    Column("On", "on", 8, N_("FALSE switches this row off. Blank is on."), ("有効",), "keys", offers="On or off",
           choices=(CellChoice("TRUE"), CellChoice("FALSE", N_("skips the row"))), required=False),
    _NOTES,
    Column("Priority", "amount", 9, N_("A number: the larger one wins when two rows want the same part of the robot. "
           "Blank is 0."), ("優先度",), "priority", required=False, offered=False),
), any_name=True, called=("ふるまい", "動作"))  # fmt: skip
DEVICES = SheetKind("devices", "Devices", N_("the list of devices"), "DDEBDD", (
    Column("Stream", "stream", 24, N_("The name you give this sensor or actuator; behaviours use it."),
           ("ストリーム",)),
    Column("Device", "device", 24, N_("Which sensor or actuator of the robot it is."), ("デバイス",), "devices",
           offers="All devices", known=("All devices",)),
    _NOTES,
), other=Column("", "setting", 18, N_("The setting {header}; blank is the usual one."), help="devices",
                offers="{header}", required=False),
   usual=(Column("Text", "setting", 38, N_("What the robot says."), help="devices"),),
   called=("デバイス",))  # fmt: skip
HELPERS = SheetKind("helpers", "Helpers", N_("the list of helpers"), "E9E2F0", (
    Column("Name", "helper", 24, N_("The helper's name; write it into the Formula of a row."), ("名前",), "helpers"),
    Column("Inputs", "parameters", 24, N_("Names for what the helper calculates with, separated by commas. Blank: a "
           "constant."), ("入力",)),
    Column("Formula", "formula", 46, N_("The calculation, with the names of Inputs."), ("式", "数式"), "formulas"),
    _NOTES,
), called=("補助の式", "ヘルパー"))  # fmt: skip
SCENE = SheetKind("scene", "Scene", N_("the scene"), "F4E8D3", (
    Column("Time (s)", "amount", 14, N_("Seconds after the start, the row above (+ 2) or an event: Ask done + 2"),
           ("時間（秒）",), "scene"),
    Column("Thing", "actor", 18, N_("Who or what: Red ball, Blue cup, Table, Person or a name, Light, Operator, …"),
           ("対象",), "scene", offers="Thing"),
    Column("Does", "verb", 18, N_("What happens: appears, moves, says, touches, …"), ("動作",), "scene", offers="Does"),
    Column("Value", "value", 34, N_("Where, what or how long. at 1, 0.2, 0.4 is in metres: forward, left, up."),
           ("値",), "scene"),
    _NOTES,
), called=("シーン", "場面"))  # fmt: skip
GESTURES = SheetKind("gestures", "Gestures", N_("the list of gestures"), "F4E8D3", (
    Column("Name", "gesture", 20, N_("The gesture's name, the same in all its rows."), ("名前",)),
    Column("Time (s)", "amount", 10, N_("When the joints are there, in seconds from the gesture's beginning."),
           ("時刻（秒）", "時間（秒）")),
    _NOTES,
), other=Column("", "angle", 15, N_("{header} at that time: rad, or degrees as 30°; a hand from 0 to 1. "
                "Blank: on its way."), required=False), called=("身ぶり", "ジェスチャー"))  # fmt: skip
TEST = SheetKind("test", "Test", N_("a test"), "F1DFDF", (
    Column("Time (ms)", "amount", 12, N_("Milliseconds after the start."), ("時間（ミリ秒）",), "tests"),
    Column("Stream", "tested", 24, N_("The stream that gets the value, or that is looked at."), ("ストリーム",),
           "tests", offers="Streams"),
    Column("Send", "send", 28, N_("What arrives: a value, or the fields of a sensor: distance=0.3; x=0"),
           ("送信",), "tests"),
    Column("Expect", "expect", 28, N_("What must come out: a value, any, or nothing."), ("期待",), "tests"),
    _NOTES,
), any_name=True, called=("テスト",))  # fmt: skip
PROTOCOL = SheetKind("protocol", "Protocol", N_("the protocol"), "E3E6E9", (
    Column("Field", "fieldname", 24, N_("The name of a field; you may add your own."), ("項目",), "protocol"),
    Column("Value", "fieldvalue", 90, "", ("内容", "値"), "protocol"),
    replace(_NOTES, offered=False),
), called=("プロトコル", "計画書", "実施計画書"))  # fmt: skip
RISKS = SheetKind("risks", "Risks", N_("the list of risks"), "F6DCE0", (
    Column("Risk", "prose", 30, N_("What could go wrong for a person, in a few words."), ("リスク", "危険"), "risks"),
    Column("For whom", "prose", 20, N_("Who could come to harm: the child, a parent, the operator."),
           ("対象者", "誰に"), "risks", required=False),
    Column("How likely", "prose", 18, N_("Unlikely, possible or likely, and when."), ("起こりやすさ", "可能性"),
           "risks", choices=(CellChoice("Unlikely"), CellChoice("Possible"), CellChoice("Likely")), required=False),
    Column("What reduces it", "prose", 44, N_("What you do, or what the rows do, so that it does not happen."),
           ("対策", "減らす方法"), "risks"),
    Column("Who ends the session when", "prose", 40, N_("Who ends the session, and at which sign."),
           ("中止の判断", "中止する人と時"), "risks", required=False),
    _NOTES,
), called=("リスク",))  # fmt: skip

OWN = SheetKind("table", "Table", N_("a table"), "ECEFF1", (), called=("表",))
"""A sheet of the user's own, which formulas may name as a table."""
SHEETS = {kind.name: kind for kind in (BEHAVIOUR, DEVICES, HELPERS, SCENE, GESTURES, TEST, PROTOCOL, RISKS)}
"""The kinds of sheets by name, in the order of a new workbook."""
TITLES = {kind.name: kind.title for kind in (*SHEETS.values(), OWN)}
"""Name of a new sheet of each kind."""


def title_of(kind: str, language: str) -> str:
    """Return the name of a new sheet of a kind, by its name, in a language."""
    own = () if language == "en" else (SHEETS.get(kind) or OWN).called
    return next(iter(own), TITLES[kind])


def setting_header(setting: str, language: str) -> str:
    """Return the header of a setting's column in a workbook of a language.

    >>> setting_header("Words", "en"), setting_header("Words", "ja")
    ('Words', '言葉')
    """
    return japanese.word_in(japanese.SETTINGS, setting, language)


def language_of(headers: Iterable[str]) -> str:
    """Return the language of headers of ours: that of most of them.

    >>> language_of(["入力", "コネクター", "Formula"]), language_of(["Stream", "Device", "メモ"])
    ('ja', 'en')
    """
    english = [header.isascii() for header in headers]
    return "ja" if 2 * sum(english) < len(english) else "en"


def is_single(kind: str) -> bool:
    """Return whether a workbook has one sheet of a kind."""
    return kind in SHEETS and not SHEETS[kind].any_name


def fixed_lists() -> dict[str, tuple[str, ...]]:
    """Return the lists for drop-downs that are the same in all workbooks, by title."""
    columns = chain.from_iterable(kind.columns for kind in SHEETS.values())
    return {c.offers: tuple(choice.text for choice in c.choices) for c in columns if c.offers and c.choices}


def list_name(title: str) -> str:
    """The defined name of a list."""
    return LIST_PREFIX + re.sub(r"\W", "_", key(title))


def list_titles() -> set[str]:
    """Return the titles of all lists that columns offer, or whose names they know."""
    columns = chain.from_iterable(kind.columns for kind in SHEETS.values())
    return {title for c in columns for title in (c.offers, *c.known) if title}


@dataclass(frozen=True, slots=True)
class ProtocolField:
    """A field of the Protocol sheet; where it is `closed`, values that are not among its choices are mistakes.

    Attributes:
        prompt: shown beside the cell by spreadsheet programs.
        synonyms: other accepted names, Japanese ones.
        also: other spellings of the choices of a closed field, each with the choice.
        asked: when an ethics board asks for it: `always`, or of studies with `children`, an `operator` who drives the
            robot by hand, `faces` that it looks for, a `real` robot, or an `undated` version; empty when it does not.
    """

    name: str
    choices: tuple[CellChoice, ...] = ()
    closed: bool = False
    prompt: str = ""
    synonyms: tuple[str, ...] = ()
    also: Mapping[str, str] = field(default_factory=dict)
    asked: str = ""

    @property
    def words(self) -> tuple[str, ...]:
        """The choices without their help."""
        return tuple(choice.text for choice in self.choices)

    def name_in(self, language: str) -> str:
        """Return the name of the field in a language."""
        return self.synonyms[0] if language == "ja" and self.synonyms else self.name

    def shown(self, choice: str, language: str) -> str:
        """Return a choice as it is written in a language; another text stays as it is."""
        spellings = (word for word, meant in self.also.items() if language == "ja" and meant == choice)
        return next(spellings, choice)

    def standard(self, text: str) -> str:
        """Return the choice that a text means; any other text stays as it is."""
        return self.meaning(text) or text

    def meaning(self, text: str) -> str:
        """Return the choice that a text means in any spelling; empty when it means none."""
        spellings = {key(word): word for word in self.words} | {key(word): meant for word, meant in self.also.items()}
        return spellings.get(key(text), "")


_FIELDS = (
    # what the session is about
    ProtocolField("Title", prompt=N_("The name of the study or session."), synonyms=("題名", "タイトル")),
    ProtocolField("Authors", prompt=N_("Who has written this workbook."), synonyms=("作成者", "著者")),
    ProtocolField("Version", prompt=N_("The version of this workbook, such as 1.0."), synonyms=("版", "バージョン"),
                  asked="always"),
    ProtocolField("Version date", prompt=N_("The date of this version, if Version does not say it."),
                  synonyms=("版の日付",), asked="undated"),
    ProtocolField("Purpose", prompt=N_("What you want to find out or reach, in one or two sentences."),
                  synonyms=("目的",), asked="always"),
    ProtocolField("What happens", prompt=N_("The session in a few sentences, as a participant sees it."),
                  synonyms=("実施内容", "内容")),
    ProtocolField("What participants do", prompt=N_("What participants do and what for, in short words that they "
                  "understand. It is printed on their page."), synonyms=("参加者がすること",), asked="always"),
    ProtocolField("Robot in sessions", (
        CellChoice("simulated", N_("participants see the robot on a screen")),
        CellChoice("real", N_("a real robot is in the room")),
    ), True, N_("Which robot participants meet: simulated or real."), ("参加者が会うロボット",),
        {"シミュレーション": "simulated", "実機": "real"}, "always"),
    ProtocolField("Ethics reference", prompt=N_("The number that the ethics board has given to the study."),
                  synonyms=("倫理審査番号",), asked="always"),
    ProtocolField("Contact", prompt=N_("Whom participants can ask: name, telephone or e-mail."), synonyms=("連絡先",),
                  asked="always"),
    # the study
    ProtocolField("Research question", prompt=N_("What is known, what you ask or expect, and why with a robot."),
                  synonyms=("研究の問い",), asked="always"),
    ProtocolField("Investigators", prompt=N_("The researchers, each with role and institution, and who supervises "
                                             "students."), synonyms=("研究者",), asked="always"),
    ProtocolField("Training and background checks", prompt=N_("What everybody who runs sessions has learned: research "
                  "ethics, safeguarding, first aid, this robot. Who has checked that they may work with children or "
                  "patients, and when."), synonyms=("研修と身元確認", "研修", "Training"), asked="always"),
    ProtocolField("Place", prompt=N_("Where sessions take place."), synonyms=("実施場所",), asked="always"),
    ProtocolField("Period", prompt=N_("When the study begins and ends."), synonyms=("実施期間",), asked="always"),
    ProtocolField("Design", prompt=N_("What you compare, and in which order each participant has what."),
                  synonyms=("研究デザイン",), asked="always"),
    ProtocolField("Measures", prompt=N_("What you measure, and which measure counts most."),
                  synonyms=("評価項目", "評価項目と分析"), asked="always"),
    ProtocolField("Analysis and publication", prompt=N_("How you analyse the data, whether the study is registered "
                  "before it begins, and where you publish the results, whatever they are."),
                  synonyms=("分析と公表",), asked="always"),
    ProtocolField("Sessions", prompt=N_("How many sessions each participant has, how far apart, how long each usually "
                                        "is, and breaks."),
                  synonyms=("回数と時間",), asked="always"),
    ProtocolField("Present", prompt=N_("Who is in the room, and who can reach the robot and the Stop button."),
                  synonyms=("立ち会う人",), asked="always"),
    ProtocolField("Distance kept", prompt=N_("How far participants stay from the robot, and how this is kept."),
                  synonyms=("ロボットとの距離",), asked="always"),
    ProtocolField("Test of Stop", prompt=N_("Who tests before each session that Stop works, and when."),
                  synonyms=("停止の確認",), asked="always"),
    ProtocolField("Changes after approval", prompt=N_("Who prevents that rows and formulas are changed between "
                  "approval and session, and who compares the checksum."), synonyms=("承認後の変更",), asked="always"),
    ProtocolField("Network", prompt=N_("Whether the program is opened to other computers (serve --lan), to whom, and "
                  "in which network."), synonyms=("ネットワーク",), asked="always"),
    ProtocolField("Robot used", prompt=N_("Which robot: version, serial number, last check. Whether it stands or sits, "
                                          "on a table or the floor, and where battery, charger and cables are."),
                  synonyms=("使用するロボット",), asked="real"),
    ProtocolField("Ending the study", prompt=N_("Who ends one person's part or the whole study, and for which "
                                                "reasons."),
                  synonyms=("研究の中止",), asked="always"),
    ProtocolField("Funding and conflicts of interest", prompt=N_("Who pays for the study, and who has another interest "
                  "in it, such as the maker of the robot."), synonyms=("資金と利益相反", "Funding"), asked="always"),
    ProtocolField("Insurance", prompt=N_("Which insurance covers participants."), synonyms=("保険",), asked="always"),
    ProtocolField("Permissions and conformity", prompt=N_("Who else has to agree: the school, the clinic, another "
                  "board. Which standards the robot conforms to (CE), and whether it is used as a medical device."),
                  synonyms=("許可と適合性", "その他の許可", "Other permissions"), asked="always"),
    ProtocolField("Attachments", prompt=N_("What belongs to this protocol: information sheets, consent forms, "
                                           "questionnaires."), synonyms=("添付書類",), asked="always"),
    # participants
    ProtocolField("Participants", prompt=N_("Who takes part: age, diagnosis, where they come from. Nobody: write "
                                            "Nobody."),
                  synonyms=("参加者",), asked="always"),
    ProtocolField("Number of participants", prompt=N_("How many people take part, and why so many."),
                  synonyms=("参加人数",), asked="always"),
    ProtocolField("Why these participants", prompt=N_("Why children or people with a diagnosis are needed, and how "
                  "they are protected."), synonyms=("この参加者を選ぶ理由",), asked="always"),
    ProtocolField("Inclusion and exclusion", prompt=N_("Who can take part and who cannot, such as people with "
                                                       "epilepsy."),
                  synonyms=("選択基準と除外基準",), asked="always"),
    ProtocolField("Recruitment", prompt=N_("How and by whom people are asked, and why they can refuse freely, even "
                                            "their therapist or teacher."),
                  synonyms=("募集方法",), asked="always"),
    ProtocolField("Compensation", prompt=N_("What participants get: money, travel costs, a present, or nothing."),
                  synonyms=("謝礼",), asked="always"),
    ProtocolField("Benefits", prompt=N_("What participants and others gain, and whether it is a treatment; write None "
                                         "if there is no direct benefit."),
                  synonyms=("期待される利益",), asked="always"),
    ProtocolField("Adverse events and safeguarding", prompt=N_("What you do and whom you tell when something goes "
                  "wrong, or when somebody tells of harm or is in danger."),
                  synonyms=("有害事象と安全確保", "有害事象への対応", "Adverse events"), asked="always"),
    ProtocolField("Incidental findings", prompt=N_("What you do when you notice something about a person's health "
                  "that you did not look for."),
                  synonyms=("偶発的所見",), asked="always"),
    ProtocolField("Feedback", prompt=N_("Whether and how participants learn the results."), synonyms=("結果の報告",),
                  asked="always"),
    # data
    ProtocolField("Data kept", prompt=N_("What is stored about a session."), synonyms=("保存するデータ",),
                  asked="always"),
    ProtocolField("Other data", prompt=N_("What is stored outside this program: questionnaires, notes, video, health "
                                          "data such as a diagnosis."), synonyms=("その他のデータ",), asked="always"),
    ProtocolField("Retention", prompt=N_("How many months or years data are kept, and who deletes them."),
                  synonyms=("保存期間",), asked="always"),
    ProtocolField("Lawful basis and impact assessment", prompt=N_("Why you may process personal data, and data on "
                  "health such as a diagnosis: consent, or another basis of your law. The result of the data "
                  "protection impact assessment (DPIA)."),
                  synonyms=("法的根拠と影響評価", "法的根拠", "Lawful basis"), asked="always"),
    ProtocolField("Responsible for the data", prompt=N_("Who is responsible by law, who is the data protection "
                  "officer, and which rights people have."),
                  synonyms=("データの責任者",), asked="always"),
    ProtocolField("Face data", prompt=N_("The lawful basis for recognising faces, and how long faces are kept."),
                  synonyms=("顔データ",), asked="faces"),
    ProtocolField("Access", prompt=N_("Who can see the data."), synonyms=("アクセスできる人",), asked="always"),
    ProtocolField("Code key", prompt=N_("Who keeps the list that links names and codes, where, and until when."),
                  synonyms=("対応表",), asked="always"),
    ProtocolField("Encryption", prompt=N_("Where the data and their backups are stored, and how they are encrypted, "
                                           "also in the network."),
                  synonyms=("暗号化",), asked="always"),
    ProtocolField("Sharing", prompt=N_("Who gets the data outside the team."),
                  synonyms=("共有", "共有と公表"), asked="always"),
    # consent
    ProtocolField("Information sheets", prompt=N_("What participants, and parents or guardians, get to read: which "
                  "sheet, from whom, when and in which language."), synonyms=("説明文書",), asked="always"),
    ProtocolField("Consent and capacity", prompt=N_("Who agrees, and how: participants, parents, and the "
                  "operator, whose actions are saved too. How long they can think, and who decides for a person who "
                  "cannot."), synonyms=("同意と同意能力", "同意", "Consent"), asked="always"),
    ProtocolField("Assent", prompt=N_("How each child is asked, in words that it understands."),
                  synonyms=("子どもへの説明と同意",), asked="children"),
    ProtocolField("Dissent", prompt=N_("The signs by which a child says no without words, and what happens then."),
                  synonyms=("子どもが嫌がるときのサイン",), asked="children"),
    ProtocolField("Withdrawal", prompt=N_("How people stop taking part, without a reason and without a disadvantage."),
                  synonyms=("同意の撤回",), asked="always"),
    ProtocolField("Deletion", prompt=N_("Until when people can have their data deleted, and how they ask for it."),
                  synonyms=("データの削除",), asked="always"),
    ProtocolField("Complaints", prompt=N_("Whom participants can complain to who is not part of the study."),
                  synonyms=("苦情の窓口",), asked="always"),
    ProtocolField("Participants are told", prompt=N_("What participants learn about what a person does by hand, and "
                                                     "when."),
                  synonyms=("参加者への説明",), asked="operator"),
    ProtocolField("Reason for concealment", prompt=N_("Why participants do not learn at once that a person controls "
                  "the robot; write Nothing is concealed if they do."), synonyms=("隠す理由",), asked="operator"),
    ProtocolField("Debriefing", prompt=N_("When and how participants learn the truth, and how they can take back their "
                  "data then."), synonyms=("事後説明",), asked="operator"),
    # how it runs
    ProtocolField("Robot", closed=True, synonyms=("ロボット",)),
    ProtocolField("Engine", (
        CellChoice("frame", N_("every frame takes all that has come: the same run every time")),
        CellChoice("event loop", N_("each value at once, as it comes")),
    ), True, N_("frame: every frame takes all that has come. event loop: each value at once."), ("エンジン",),
        {"フレーム": "frame", "イベントループ": "event loop"}),
    ProtocolField("Frame rate", tuple(CellChoice(n, N_("frames a second")) for n in ("30", "60", "20", "15")),
                  synonyms=("フレームレート",)),
    ProtocolField("Run", synonyms=("実行するふるまい", "実行する動作", "実行"), also={"すべて": "all"}),
    ProtocolField("Seed", (
        CellChoice("0", N_("a whole number that sets the random choices of PICK and the simulator")),
    ), synonyms=("乱数の種",)),
    ProtocolField("Time limit", tuple(map(CellChoice, ("30 s", "90 s", "5 min", "10 min"))),
                  synonyms=("制限時間", "時間の上限")),
    ProtocolField("Face memory", (
        CellChoice("ends with the run", N_("a blank means the same")),
        CellChoice("kept", N_("for the next runs too, in runs/faces.json")),
    ), True, N_("How long the robot remembers faces."), ("顔の記憶",),
        {"実行の終わりまで": "ends with the run", "残す": "kept", "保存する": "kept"}),
    ProtocolField("Camera pictures", (
        CellChoice("kept", N_("with the recording of a run; a blank means the same")),
        CellChoice("not kept", N_("no picture of the robot's camera is stored")),
    ), True, N_("Whether a run's recording contains pictures of the robot's camera."), ("カメラの画像",),
        {"残す": "kept", "残さない": "not kept", "保存する": "kept", "保存しない": "not kept"}),
    ProtocolField("Language", tuple(
        CellChoice(names[0], N_("the same in {language}", language=names[1]) if code != "en" else
                   N_("of explanations, diagrams and the printed protocol"))
        for code, names in LANGUAGE_NAMES.items()
    ), True, N_("In which the workbook is explained, drawn and printed. Blank: English."), ("言語",)),
)  # fmt: skip
FIELDS = {key(field.name): field for field in _FIELDS}
"""The fields of the Protocol sheet by key, in the order in which they are suggested."""
_SPELLINGS = {key(name): k for k, field in FIELDS.items() for name in (field.name, *field.synonyms)}


def field_key(name: str) -> str:
    """Return the key of the field that a name means in any spelling; of a field of the user's own, that of its name."""
    return _SPELLINGS.get(key(name), key(name))


_COMMON = frozenset(("入力", "出力", "式", "数式", "名前", "ストリーム", "送信", "期待", "対象", "動作", "値",
                     "項目", "内容", "時刻（秒）"))  # fmt: skip
"""Synonyms that tables of the user's own have too: these alone make no sheet of ours."""
_KINDS = sorted(SHEETS.values(), key=lambda kind: (-len(kind.required), not kind.any_name))
"""Those with more required headers first: a header row that fits several is of the first."""


@dataclass(frozen=True, slots=True)
class NearMiss:
    """A header row that lacks one header: which, and the column of the header that may be meant (0: none)."""

    kind: SheetKind
    wanted: str
    row: int
    column: int
    header: str
    certain: bool


@dataclass(frozen=True, slots=True)
class Recognised:
    """Kind and columns of a sheet; `kind` is None for a sheet of the user's own.

    A sheet with one misspelt header is read as if it were spelt right, so that one mistake gives one finding. `row` is
    the header row. `columns` tells a column by its standard header, `others` the header of a column that is not ours,
    and `twice` the column further left that has the same header already.
    """

    kind: SheetKind | None = None
    row: int = 0
    columns: Mapping[str, int] = field(default_factory=dict)
    others: Mapping[int, str] = field(default_factory=dict)
    twice: Mapping[int, int] = field(default_factory=dict)
    near: NearMiss | None = None


def recognise(sheet: RawSheet) -> Recognised:
    """Find the header row among the first 20 rows."""
    rows = _head(sheet)
    for number, cells in rows.items():
        headers = {c: clean_name(cell.text) for c, cell in cells.items()}
        keys = {key(h) for h in headers.values()}
        found = [kind for kind in _KINDS if all(_has(c, keys) for c in kind.required)
                 and (kind.names(sheet.name) or any(_has(c, keys, _COMMON) for c in kind.required))]  # fmt: skip
        if found:
            named = [kind for kind in found if kind.names(sheet.name)]
            return _match((named or found)[0], number, headers)
    misses = [m for number, cells in rows.items() for m in _near_misses(sheet.name, number, cells)]
    best = min(misses, key=lambda m: (not m.certain, not m.column, m.row), default=None)
    if best is None or not best.certain or not best.column:
        return Recognised(near=best)
    meant = {c: clean_name(cell.text) for c, cell in rows[best.row].items()}
    return replace(_match(best.kind, best.row, {**meant, best.column: best.wanted}), near=best)


def _head(sheet: RawSheet) -> dict[int, dict[int, RawCell]]:
    rows: dict[int, dict[int, RawCell]] = {}
    for (row, column), cell in sheet.cells.items():
        if row <= limits.HEADER_ROWS and len(cell.text) <= 100:
            rows.setdefault(row, {})[column] = cell
    return {row: dict(sorted(rows[row].items())) for row in sorted(rows)}


def _match(kind: SheetKind, row: int, headers: Mapping[int, str]) -> Recognised:
    columns, seen = dict[str, int](), dict[str, int]()
    others, twice = dict[int, str](), dict[int, int]()
    for column, header in headers.items():
        name = kind.spellings.get(key(header))
        if name is None:
            others[column] = header
            name = key(header) if kind.other else ""
        elif name not in columns:
            columns[name] = column
        if name == _NOTES.name and name in seen:
            others[column] = header  # for people as well
        elif name in seen:
            twice[column] = seen[name]
        elif name:
            seen[name] = column
    return Recognised(kind, row, columns, {c: h for c, h in others.items() if c not in twice}, twice)


def _near_misses(sheet: str, row: int, cells: Mapping[int, RawCell]) -> list[NearMiss]:
    headers = {c: clean_name(cell.text) for c, cell in cells.items()}
    keys = {key(h): c for c, h in headers.items()}
    found = []
    for kind in _KINDS:
        missing = [c for c in kind.required if not _has(c, keys)]
        if len(missing) != 1:
            continue
        wanted = missing[0]
        named = kind.names(sheet)
        sure = (named and not kind.any_name) or _COMMON.intersection(wanted.synonyms)
        # else the header that tells this kind may be the misspelt one: no other may be a common one
        if not sure and not all(_has(c, keys, _COMMON) for c in kind.required if c is not wanted):
            continue
        free = [h for h in headers.values() if key(h) not in kind.spellings]
        spellings = (wanted.name, wanted.name.partition(" (")[0], *(s for s in wanted.synonyms if s not in _COMMON))
        meant = next((n for s in spellings if (n := nearest(s, free))), None)
        certain = kind.any_name or named
        if meant or certain:
            header = wanted.header(language_of(h for h in headers.values() if key(h) in kind.spellings))
            found.append(NearMiss(kind, header, row, keys[key(meant)] if meant else 0, meant or "", certain))
    return found


def _has(column: Column, keys: Container[str], without: Container[str] = ()) -> bool:
    return any(key(header) in keys for header in (column.name, *column.synonyms) if header not in without)
