"""Finds and lists help: on a topic, a word of the sheets, or the name of a connector, function, device or finding."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from functools import lru_cache

from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.functions import library
from rrp_sheets.help.functions import first_line
from rrp_sheets.help.layout import FOR_EXAMPLE, Block, entries, example, from_file, paragraph, titled, workbook
from rrp_sheets.model import japanese
from rrp_sheets.model.names import key, nearest
from rrp_sheets.robots import DeviceType, FoundDevice, Robot, load_robot
from rrp_sheets.texts import N_, listed, translate
from rrp_sheets.workbook.schema import SHEETS, SheetKind

_OVERVIEW = ("overview", "help", "index")
WORDS = {
    "connectors": "connector operator operators コネクター コネクタ",
    "formulas": "formula language calculate calculation 式 数式 計算",
    "functions": "function 関数",
    "helpers": "helper 補助の式 ヘルパー",
    "total": "count score 合計 数える 点数",
    "priority": "priorities 優先度 優先",
    "protocol": "framerate duration long lasts 長さ 計画書 プロトコル",
    "engine": "engines timing エンジン",
    "devices": "device sensor sensors actuator actuators デバイス センサー アクチュエーター",
    "robot": "nao robots ロボット",
    "scene": "scenes room person child シーン 場面 部屋 子ども",
    "tests": "test testing try テスト 試す 確認",
    "codes": "code error errors warning warnings message messages problem problems エラー 警告 問題",
    "compare": "comparing difference differences diff git explain check 比較 比べる 違い 説明 点検",
    "sheets": "workbook workbooks sheet file files excel csv column row add save "
              "ワークブック シート ファイル 列 行 追加 保存",
    "serve": "server browser grid password login share together people comment comments start stop run pause rename "
             "version versions パスワード 共有 一緒に コメント 実行 始める 開始 止める 停止 一時停止 版 名前を変える",
    "keys": "key shortcut shortcuts keyboard undo redo copy paste cut rename find replace insert add delete bold "
            "元に戻す 取り消す やり直す コピー 貼り付け 検索 置換 キー ショートカット 名前を変える 挿入 追加 削除",
    "recordings": "record records recording long lasts film video camera picture pictures look export data save delete "
                  "replay 長さ 記録 録画 動画 映像 カメラ 振り返り 振り返る 書き出す 再生 データ 削除",
    "ethics": "paper print board approval consent participant participants 倫理 印刷 審査 同意 参加者",
    "risks": "risk danger safety safe リスク 危険 安全",
    "bundles": "bundle share send zip 共有 送る バンドル",
    "systems": "installation install windows macos linux computer インストール パソコン",
    "glossary": "words word stream streams event events field fields frame seed rad trace units state states instant "
                "meaning 用語 言葉 意味 ストリーム",
}  # fmt: skip
"""Plain words of each topic, in all languages, by which people look for it; one of a single topic is a name of it."""
TITLES = {
    "": N_("Overview"), "sheets": N_("Sheets and files"), "serve": N_("The grid and runs"), "keys": N_("Keys"),
    "glossary": N_("Glossary"), "connectors": N_("Connectors"), "formulas": N_("Formulas"),
    "functions": N_("Functions"), "helpers": N_("Helpers"), "total": N_("The total"), "priority": N_("Priority"),
    "engine": N_("Engine"), "devices": N_("Devices"), "robot": N_("The robot"), "scene": N_("The scene"),
    "tests": N_("Tests"), "codes": N_("Problems that a check finds"), "compare": N_("Check and compare"),
    "protocol": N_("The Protocol sheet"), "risks": N_("The Risks sheet"), "ethics": N_("Print for the ethics board"),
    "recordings": N_("Recordings"),
    "bundles": N_("Bundles"), "systems": N_("Systems"),
}  # fmt: skip
"""The short title of each topic, by which lists and links name it."""
GROUPS = {
    N_("To begin with"): {
        "": N_("what a workbook is, and all topics"),
        "sheets": N_("the sheets of a workbook, and the files it may be in"),
        "serve": N_("the grid in the browser: who may use it, editing together, operating a run"),
        "keys": N_("the keys of the grid"),
        "glossary": N_("what the words mean: stream, event, connector, subscribe, field, frame, seed, rad"),
    },
    N_("Rows and formulas"): {
        "connectors": N_("what a row can do with its input streams"),
        "formulas": N_("how formulas are written"),
        "functions": N_("the functions of formulas"),
        "helpers": N_("formulas with a name of their own"),
        "total": N_("the value of accumulate so far"),
        "priority": N_("which command wins when two want the same joints"),
        "engine": N_("how rows follow each other in time"),
    },
    N_("Robot and room"): {
        "devices": N_("what the robot senses and does"),
        "robot": N_("what the simulated robot senses, does, and cannot do"),
        "scene": N_("what happens in the simulated room"),
    },
    N_("Checking and testing"): {
        "tests": N_("test sheets: what is sent, and what must come out"),
        "codes": N_("what a check can find, and how to fix it"),
        "compare": N_("check, explain and compare workbooks; git"),
    },
    N_("Studies"): {
        "protocol": N_("the Protocol sheet: title, engine, seed, time limit"),
        "risks": N_("the Risks sheet: what could go wrong for people"),
        "ethics": N_("the protocol on paper, for the ethics board"),
        "recordings": N_("what a run leaves: look back, export, delete, replay"),
        "bundles": N_("a workbook with all that belongs to it, in one file"),
        "systems": N_("where the program runs, and what is measured"),
    },
}  # fmt: skip
"""The topics in the order of the help's pages, each with a line on it. The overview is the topic without a name."""
TOPICS = {topic: line for topics in GROUPS.values() for topic, line in topics.items() if topic}
EXAMPLES = {name: example(name) for name in ("helpers", "priority", "total", "protocol")}
"""A workbook for each word that needs one; a test holds that they are in order."""
SMALL_WORDS = frozenset((
    "how", "can", "does", "did", "the", "and", "what", "why", "when", "where", "which", "who", "that", "this", "with",
    "for", "from", "into", "make", "robot", "want", "should", "are", "has", "have", "not", "its", "there", "get", "let",
))  # fmt: skip
"""Words of questions that tell nothing of what is asked for."""


def text_on(name: str, others: Sequence[str] = (), language: str = "en") -> Iterator[Block]:
    """Return the blocks on a topic, a name or a plain word; raises SheetsError for an unknown one.

    The error proposes `others`, further names, too, and a plain word of one topic is left to them. A word of several
    things gives their list.
    """
    topic, elsewhere = topic_of(name), key(name) in map(key, others)
    if topic is not None and (not elsewhere or topic in (key(name), f"{key(name)}s")):
        return page_of(topic, language)
    found = list(_named(english(name), language))
    if found:
        return iter(block for blocks in found for block in blocks)
    meanings = _by_word().get(key(name), []) or _meant(name)
    if len(meanings) == 1 and elsewhere:
        raise _unknown(name, None)
    if len(meanings) == 1:
        return text_on(meanings[0].name, others, language)
    guess = "" if meanings else _guess(name, others)
    hits = meanings if meanings or guess else search(name, language, _LISTED) or near(name, language, _LISTED)
    if not hits:
        raise _unknown(name, guess)
    return _listed(name, hits, language)


_LISTED = 8
_SENTENCE = re.compile(r".*?(?:[.](?= )|。|$)")


def _listed(name: str, hits: Sequence[HelpEntry], language: str) -> Iterator[Block]:
    """Yield a list of entries, each with the first sentence about it."""
    yield paragraph(N_("Help that has to do with “{name}”:", name=name))
    names = [japanese.in_both(japanese.DEVICES, hit.name, language) for hit in hits]
    lines = (_SENTENCE.findall(translate(hit.line, language))[0] for hit in hits)
    yield entries(zip(names, lines, strict=True))
    first = japanese.word_in(japanese.DEVICES, hits[0].name, language)
    yield paragraph(N_("For one of these: `rrp-sheets help {name}`", name=first))


def topic_of(name: str) -> str | None:
    """Return the topic that a name means; None if it means none, or something else as well.

    >>> topic_of("Sensors"), topic_of("records"), topic_of("overview"), topic_of("Red ball"), topic_of("start")
    ('devices', 'recordings', '', None, None)
    """
    k = key(name)
    if k in TOPICS or not k or k in _OVERVIEW:
        return k if k in TOPICS else ""
    meanings = _by_word().get(k, [])
    named = k in _by_key() or load_robot().find(name) is not None
    return meanings[0].name if len(meanings) == 1 and meanings[0].what == "topic" and not named else None


def page_of(topic: str, language: str) -> Iterator[Block]:
    """Yield the blocks of a topic, with an example where one helps."""
    from rrp_sheets.help.codes import all_codes
    from rrp_sheets.help.connectors import all_connectors
    from rrp_sheets.help.devices import all_devices
    from rrp_sheets.help.functions import all_functions
    from rrp_sheets.help.recording_columns import explained
    from rrp_sheets.help.scene_page import scene

    lists: dict[str, Callable[[], Iterator[Block]]] = {
        "connectors": all_connectors, "functions": all_functions, "devices": lambda: all_devices(language),
        "codes": all_codes,
    }  # fmt: skip
    if topic in lists:
        yield from lists[topic]()
    elif topic == "scene":
        yield from scene(language)
    else:
        made = {}
        if topic == "sheets":
            made = {kind.name: _columns(kind, language) for kind in SHEETS.values()}
        elif topic == "recordings":
            made = {"columns": "\n".join(f"| {' | '.join(line)} |" for line in explained(language))}
        yield from from_file(topic or "overview", language, **made)
    if topic in EXAMPLES:
        yield titled(FOR_EXAMPLE, workbook(topic, EXAMPLES[topic], language))


def _columns(kind: SheetKind, language: str) -> str:
    """Return the columns of a kind of sheet; notes, which all sheets may have, are named beside other optional ones."""
    required, optional = (listed([c.header(language) for c in columns]) for columns in (kind.required, kind.optional))
    both = N_("{before}; {after}", before=required, after=optional)
    return translate(both if len(kind.optional) > 1 else required, language)


def _named(name: str, language: str) -> Iterator[Iterator[Block]]:
    """Yield the help pages under a name: it may be a function and a device, say."""
    from rrp_sheets.graph.device_table import done_of
    from rrp_sheets.help.codes import one_code
    from rrp_sheets.help.connectors import one_connector
    from rrp_sheets.help.devices import done_stream, one_device
    from rrp_sheets.help.functions import one_function

    if (code := CODES.get(name.upper())) is not None:
        yield one_code(code, language)
    if (connector := connectors().get(name)) is not None:
        yield one_connector(connector, language)
    if (function := library().get(name.removesuffix("()"))) is not None:
        yield one_function(function)
    if (device := load_robot().find(name)) is not None:
        yield one_device(device, language)
    elif (found := load_robot().find(done_of(name))) is not None and found.type.kind == "actuator":
        yield done_stream(found, language)


def _guess(name: str, others: Sequence[str]) -> str | None:
    found = list(load_robot().names.values())
    devices = [*(f.name for f in found), *(f"{f.name} done" for f in found if f.type.kind == "actuator")]
    return nearest(name, [*TOPICS, *connectors().names(), *library().names(), *devices, *CODES, *others])


def _unknown(name: str, guess: str | None) -> SheetsError:
    topics = listed(list(TOPICS))
    remedy = N_("Did you mean {guess}?", guess=guess) if guess else N_("Try: {topics}.", topics=topics)
    return SheetsError(N_("There is no help on “{name}”.", name=name), remedy)


@dataclass(frozen=True, slots=True)
class HelpEntry:
    """Something there is help on.

    `what` is topic, connector, function, sensor, actuator, stream, error, warning or info.
    `words` are plain ones, in all languages, by which people look for it.
    """

    name: str
    what: str
    line: str
    words: tuple[str, ...] = ()


@lru_cache(maxsize=1)
def all_names() -> tuple[HelpEntry, ...]:
    """Every name, topics first."""
    return (
        *(HelpEntry(topic, "topic", line, tuple(WORDS[topic].split())) for topic, line in TOPICS.items()),
        *(HelpEntry(c.name, "connector", c.help_message(), c.words) for c in dict.fromkeys(connectors())),
        *(HelpEntry(f.name, "function", first_line(f), f.words) for f in dict.fromkeys(library())),
        *(HelpEntry(f.name, f.type.kind, N_(f.type.help, msgctxt=f"{f.type.name}.help"), _words_if_shortest(f))
          for f in _devices()),
        *(HelpEntry(c.id, c.severity.value, c.text("title", {})) for c in CODES.values()),
    )  # fmt: skip


def _devices() -> list[FoundDevice]:
    return [found for found in load_robot().names.values() if found.offered]


def _words_if_shortest(found: FoundDevice) -> tuple[str, ...]:
    """Return the plain words of a device, for the shortest of its names only."""
    robot, kind = load_robot(), found.type
    names = [f.name for f in robot.names.values() if f.offered and f.type.name == kind.name and "joint" not in f.preset]
    return plain_words(kind, robot) if found.name == min(names, key=len) else ()


def plain_words(device: DeviceType, robot: Robot) -> tuple[str, ...]:
    """Return the words by which people look for a device: also Japanese names of it, and the movements that it makes.

    >>> {"speak", "話す"} <= {*plain_words(load_robot().names["say"].type, load_robot())}
    True
    """
    makes = {"posture": robot.postures, "gesture": robot.gestures}
    moves = [move for setting in device.settings.values() for move in makes.get(setting.kind, ())]
    own = [word for word, name in japanese.DEVICES.items() if (f := robot.find(name)) and f.type.name == device.name]
    own += [word for word, meant in japanese.MOVES.items() if meant in moves]
    return tuple(dict.fromkeys((*device.synonyms, *moves, *own)))


def english(term: str) -> str:
    """Return the English name that a term means, without what stands in brackets behind it.

    >>> english("CLAMP(value; low; high)"), english("接触（Touch）"), english("発話 done")
    ('CLAMP', 'Touch', 'Say done')
    """
    name = re.split("[(（]", term)[0]
    stem = name.removesuffix(" done")
    return japanese.standard(japanese.DEVICES, stem) + name[len(stem) :]


def known(term: str) -> str:
    """The name that a term of a help text stands for, or an empty text.

    >>> known("CLAMP(value; low; high)"), known("Red ball"), known("say done"), known("whatever")
    ('CLAMP', 'Red ball', 'Say done', '')
    """
    name = english(term)
    return next((entry.name for entry in _done_entries(name)), _by_key().get(key(name), ""))


def _done_entries(name: str) -> Iterator[HelpEntry]:
    """Yield the entry of a done stream, if a name is that of one; they are not among `all_names`."""
    from rrp_sheets.graph.device_table import done_of

    found = load_robot().find(done_of(name))
    if found is not None and found.type.kind == "actuator":
        line = N_("The stream that gives a value at the end of every command of {name}.", name=found.name)
        yield HelpEntry(f"{found.name} done", "stream", line)


@lru_cache(maxsize=1)
def _by_key() -> dict[str, str]:
    return {key(n.name): n.name for n in reversed(all_names())}


@lru_cache(maxsize=1)
def _by_word() -> dict[str, list[HelpEntry]]:
    """Return what each plain word means, by its key."""
    found: dict[str, list[HelpEntry]] = {}
    for entry in all_names():
        for word in dict.fromkeys(map(key, entry.words)):
            found.setdefault(word, []).append(entry)
    return found


def _meant(text: str) -> list[HelpEntry]:
    """Return the entries of whose names and plain words several words are (“end the run”)."""
    asked = query_words(text)
    return [e for e in all_names() if len(asked) > 1 and name_words((e.name, *e.words)).issuperset(asked)]


def search(text: str, language: str = "en", most: int = 20) -> list[HelpEntry]:
    """Return the entries under all words of a query, the best first: names and plain words count more than texts.

    >>> search("clam")[0].name, search("赤い", "ja")[0].name, search("nodding")[0].name
    ('CLAMP', 'Red ball', 'Gesture')
    """
    return [*_done_entries(english(text)), *_ranked(text, language, all_names(), whole=True)][:most]


def near(text: str, language: str = "en", most: int = 8) -> list[HelpEntry]:
    """Return the entries under some words of a question, when there is none under all of them.

    >>> near("How do I make the robot sleep or speak a text?")[0].name in {n.name for n in all_names()}
    True
    >>> near("how do I xyzzy"), near("ロボットの手をどうやって上げますか", "ja") != []
    ([], True)
    """
    entries = [n for n in all_names() if n.what not in ("error", "warning", "info")]
    return _ranked(text, language, entries, whole=False)[:most]


def _ranked(text: str, language: str, entries: Sequence[HelpEntry], *, whole: bool) -> list[HelpEntry]:
    """Return the entries under all words, or (not `whole`) under some. search.js of the pages does the same."""
    found: dict[str, tuple[tuple[bool, int, int], HelpEntry]] = {}
    words = query_words(text)
    split = [piece for word in words for piece in (_SPLIT.findall(word) if not word.isascii() else [word])]
    for asked in (words, split):  # Japanese has no blanks between words
        for entry in entries if not found else ():
            inside = f"{entry.name} {entry.what} {entry.line} {translate(entry.line, language)}".casefold()
            names = name_words((entry.name, *entry.words))
            points = [_points(word, names, inside) for word in asked]
            lacks = points.count(0)
            if asked and lacks < (1 if whole else len(asked)):
                by = entry.name if max(points) > 1 else entry.line  # the joints of a robot have one line
                found.setdefault(by, ((key(entry.name) != key(text), lacks, -sum(points)), entry))
    return [entry for _, entry in sorted(found.values(), key=lambda pair: pair[0])]


_WORD = re.compile(r"[一-龯々ぁ-んァ-ヴー]+|[^\W_一-龯々ぁ-んァ-ヴー]+")
_SPLIT = re.compile("[一-龯々]+|[ァ-ヴー]+|[ぁ-ん]{4,}")


def query_words(text: str) -> list[str]:
    """Return the words of a query that tell what is asked for, each without its ending.

    >>> query_words("How does the robot stop nodding?"), query_words("手を振る"), query_words("if")
    (['stop', 'nod'], ['手を振る'], ['if'])
    """
    words = _WORD.findall(unicodedata.normalize("NFKC", text).casefold())
    telling = [w for w in words if w not in SMALL_WORDS and (len(w) > 2 or not w.isascii())]
    return list(dict.fromkeys(_stem(w) for w in telling or words))


def _stem(word: str) -> str:
    """Return a word without its English ending."""
    bare = _ENDING.sub("", word)
    if len(bare) < 3:
        return word
    return bare[:-1] if bare != word and len(bare) > 3 and bare[-1] == bare[-2] else bare


_ENDING = re.compile("(?:ing|(?<!e)ed|s)$")


def name_words(names: Sequence[str]) -> frozenset[str]:
    """Return the words of names, each without its ending, and whole Japanese ones."""
    return frozenset(_stem(word) for name in names for word in _WORD.findall(_spaced(name).casefold()))


def _spaced(name: str) -> str:
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", unicodedata.normalize("NFKC", name)) + " " + name


def _points(word: str, names: frozenset[str], inside: str) -> int:
    """Return how well a word of a query fits: 4 for a word of the names, 0 when it is nowhere."""
    if word in names:
        return 4
    if any(name.startswith(word) for name in names):
        return 3
    if not word.isascii() and any(_is_like(word, name) for name in names):
        return 2
    return int(word in inside)


def _is_like(word: str, name: str) -> bool:
    """Return whether a Japanese word holds another one, or begins as it does: うなずいて and うなずく."""
    return (
        word in name or (len(name) > 1 and name in word) or (len(word) > 3 and len(name) > 3 and word[:3] == name[:3])
    )
