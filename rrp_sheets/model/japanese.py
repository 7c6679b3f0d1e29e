"""Japanese words for what workbooks say in English words of the program's: read as these, and offered in new workbooks.

The readers of sheets put the standard word in place of each, so that nothing after them knows of languages: the same
workbook in Japanese runs in the same way. What people say, name and note is never looked up, nor are names of streams
(but for those of devices that rows use by their own name) and connectors. Headers of columns are synonyms in `schema`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping

from rrp_sheets.model.names import key
from rrp_sheets.model.values import Field

DEVICES = {
    "赤いボール": "Red ball", "緑のボール": "Green ball", "青いボール": "Blue ball", "ボール": "Ball",
    "色の領域": "Blob", "顔": "Face", "関節の角度": "Joint position", "操作者のボタン": "Operator button",
    "接触": "Touch", "タッチ": "Touch", "足のバンパー": "Bumper", "バンパー": "Bumper", "胸のボタン": "Chest button",
    "ソナー": "Sonar", "体の向き": "Orientation", "言葉の認識": "Word recognized", "音声認識": "Word recognized",
    "タイマー": "Timer", "届いた色の目": "Eye LED color", "目の色": "Eye color", "目の明るさ": "Eye brightness",
    "発話": "Say", "話す": "Say", "決まった発話": "Say parameter", "決まった文を話す": "Say parameter",
    "顔を覚える": "Remember face", "追跡": "Tracker", "関節を動かす": "Set joint position", "記録への表示": "Print",
    "姿勢": "Posture", "身ぶり": "Gesture", "ジェスチャー": "Gesture", "待機": "Wait", "待つ": "Wait",
    "実行の終了": "End run", "歩行": "Walk", "歩く": "Walk", "音の再生": "Play sound",
    "ふるまいの切り替え": "Behaviour", "届いた文の発話": "Say input",
}  # fmt: skip
SETTINGS = {
    "頻度": "Rate", "色": "Colour", "しきい値": "Threshold", "関節": "Joint", "ラベル": "Label", "表示": "Label",
    "場所": "Zone", "側": "Side", "言葉": "Words", "間隔": "Every", "言語": "Language", "速さ": "Speed",
    "音量": "Volume", "話しながらの身ぶり": "Gestures", "せりふ": "Text", "文": "Text", "名前": "Name",
    "動かし方": "Mode", "使う腕": "Effector", "テンポ": "Tempo", "回数": "Times", "時間": "Time", "前へ": "Forward",
    "左へ": "Left", "回転": "Turn", "音": "Sound", "ファイル": "File", "状態": "State",
}  # fmt: skip
COLOURS = {
    "赤": "red", "緑": "green", "青": "blue", "黄": "yellow", "黄色": "yellow", "オレンジ": "orange",
    "オレンジ色": "orange", "ピンク": "pink", "桃色": "pink", "紫": "purple", "マゼンタ": "magenta", "水色": "cyan",
    "シアン": "cyan", "茶色": "brown", "白": "white", "黒": "black", "灰色": "grey",
}  # fmt: skip
ZONES = {
    "頭": "Head", "左手": "Left hand", "右手": "Right hand", "左足": "Left foot", "右足": "Right foot", "胸": "Chest",
}  # fmt: skip
CHOICES: Mapping[str, Mapping[str, str]] = {
    "colour": COLOURS, "zone": ZONES, "side": {"左": "Left", "右": "Right"},
    "mode": {"頭": "Head", "全身": "Whole body", "腕の動き": "Move"},
    "effector": {"なし": "None", "左腕": "Left arm", "右腕": "Right arm", "両腕": "Both arms",
                 "近いほうの腕": "Nearest arm"},
    "state": {"有効": "On", "オン": "On", "無効": "Off", "オフ": "Off", "切り替え": "Toggle"},
    "language": {"日本語": "Japanese", "英語": "English"},
    "howlikely": {"起こりにくい": "Unlikely", "起こりうる": "Possible", "起こりやすい": "Likely"},
    "sound": {"ベル": "Bell", "チャイム": "Chime", "太鼓": "Drum", "拍手": "Applause", "ファンファーレ": "Tada",
              "ブザー": "Buzzer", "笛": "Whistle", "ダンス音楽": "Dance music", "静かな音楽": "Calm music"},
}  # fmt: skip
"""Of settings and columns that have choices, by their key."""
MOVES = {
    "立位": "Stand", "標準の立位": "StandInit", "全関節0度の立位": "StandZero", "しゃがむ姿勢": "Crouch",
    "座位": "Sit", "楽な座位": "SitRelax", "うつ伏せ": "LyingBelly", "仰向け": "LyingBack", "手を振る": "Wave",
    "うなずく": "Nod", "首を横に振る": "Shake head", "おじぎ": "Bow", "左を指す": "Point left",
    "右を指す": "Point right", "前を指す": "Point ahead", "手を挙げる": "Raise hand", "手を上げる": "Raise hand",
    "挙手": "Raise hand", "片手を上げる": "Raise hand", "両腕を上げる": "Arms up", "両腕を広げる": "Arms wide",
    "頭に触れる": "Touch head", "おなかに触れる": "Touch tummy", "拍手": "Clap", "肩をすくめる": "Shrug",
    "わからない": "I don't know", "考える": "Thinking", "ダンス": "Dance", "ハイタッチ": "High five",
    "歓声を上げる身ぶり": "Cheer", "手招き": "Come here", "待って": "Halt", "抱きしめる身ぶり": "Hug",
    "いないいないばあ": "Peekaboo", "投げキス": "Blow a kiss", "腰に手を当てる": "Hands on hips", "力こぶ": "Strong",
    "羽ばたき": "Fly", "見回す": "Look around", "左を見る": "Look left", "右を見る": "Look right", "しょんぼり": "Sad",
}  # fmt: skip
"""Postures and gestures of the robot, as the setting Name of these devices has them."""
SENT = {"Gesture": MOVES, "Posture": MOVES, "EyeLedColor": COLOURS}
"""Words that rows send to an actuator, by its name in the catalogue."""
FIELDS = {
    "左右の角度": "x", "上下の角度": "y", "見かけの幅": "width", "幅": "width", "見かけの高さ": "height",
    "高さ": "height", "距離": "distance", "色": "colour", "面積": "area", "番号": "id", "名前": "name",
    "新しい顔": "new", "見覚えあり": "recognised", "新しい顔を確認済み": "recognized_new_face", "確からしさ": "score",
    "ラベル": "label", "回数": "count", "触れている": "pressed", "押している": "pressed", "場所": "zone",
    "左右の傾き": "roll", "前後の傾き": "pitch", "向き": "yaw", "転倒": "fallen", "言葉": "word",
    "確信度": "confidence", "秒数": "seconds", "値": "value", "完了": "completed",
}  # fmt: skip
"""Fields of what sensors and done streams give, as formulas and Send cells may name them too."""
THING_WORDS = {
    "ボール": "ball", "コップ": "cup", "カップ": "cup", "箱": "box", "テーブル": "Table", "机": "Table", "壁": "Wall",
    "人": "Person", "子ども": "Child", "こども": "Child", "子供": "Child", "大人": "Adult", "セラピスト": "Therapist",
    "療法士": "Therapist", "保護者": "Parent", "来客": "Visitor", "照明": "Light", "明かり": "Light", "騒音": "Noise",
    "雑音": "Noise", "操作者": "Operator",
}  # fmt: skip
"""Those by which a thing is recognised, whatever stands before them."""
_ADJECTIVES = {"赤い": "red", "青い": "blue", "白い": "white", "黒い": "black", "黄色い": "yellow", "茶色い": "brown"}
THINGS = {
    "赤いボール": "Red ball", "緑のボール": "Green ball", "青いボール": "Blue ball", "黄色いボール": "Yellow ball",
    "赤いコップ": "Red cup", "青いコップ": "Blue cup", "黄色いコップ": "Yellow cup", "箱": "Box",
    "緑の箱": "Green box", "テーブル": "Table", "壁": "Wall", "人": "Person", "子ども": "Child", "大人": "Adult",
    "セラピスト": "Therapist", "保護者": "Parent", "来客": "Visitor", "操作者": "Operator", "照明": "Light",
    "騒音": "Noise",
}  # fmt: skip
"""Those that drop-downs offer; any colour and a number may stand with a ball, a cup and a box."""
VERBS = {
    "現れる": "appears", "出てくる": "appears", "動く": "moves", "移動する": "moves", "回る": "circles",
    "消える": "disappears", "入ってくる": "enters", "来る": "enters", "歩く": "walks", "目をそらす": "looks away",
    "目を戻す": "looks back", "こちらを見る": "looks back", "見える": "is seen", "触る": "touches",
    "さわる": "touches", "触れる": "touches", "言う": "says", "話す": "says", "押す": "pushes",
    "ボタンを押す": "presses", "出ていく": "leaves", "去る": "leaves", "設定する": "set to", "になる": "set to",
}  # fmt: skip
FREE = frozenset(map(key, ("says", "presses", "press", "is seen")))
"""Verbs whose Value is words of people."""
VALUE = {
    "位置": "at", "行き先": "to", "所要時間": "in", "大きさ": "size", "高さ": "height", "向き": "turned",
    "半径": "radius", "周期": "period", "中心": "around", "水平": "flat", "テーブルの上": "on table",
    "床の上": "on floor", "座って": "seated", "立って": "standing", "名前": "name", "番号": "id", "声": "voice",
    "写真": "with picture", "長さ": "for", "女性": "female", "男性": "male", "子ども": "child",
    "左から": "from the left", "右から": "from the right", "後ろから": "from behind", "前から": "from the front",
    "そっと": "gently", "強く": "hard", "秒": "s", "ミリ秒": "ms", "分": "min", "メートル": "m", "センチ": "cm",
    "ミリ": "mm", "度": "°", **ZONES,
}  # fmt: skip
EXPECTED = {
    "何でも": "any", "任意": "any", "なし": "nothing", "何もなし": "nothing", "なしまたは空": "nothing or blank",
}  # fmt: skip
LISTS = {
    "コネクター": "Connectors", "センサー": "Sensors", "アクチュエーター": "Actuators",
    "すべてのデバイス": "All devices", "有効": "On or off", "対象": "Thing", "動作": "Does", **SETTINGS,
}  # fmt: skip
"""Titles of the lists for drop-downs."""
_PIECES = re.compile(
    r"(?<![^\s,、;；0-9０-９.．%°a-z])(?:"
    + "|".join(sorted(VALUE, key=len, reverse=True))
    + r")(?![^\s,、;；0-9０-９.．%°\-−+:：])"
)
KANA = re.compile("[\u3041-\u3096\u30a1-\u30fa\uff66-\uff9d]")
LETTERS = re.compile(rf"{KANA.pattern}|[\u3400-\u9fff]")  # kana and kanji
_UNITS = frozenset(("s", "ms", "min", "m", "cm", "mm", "°"))
_LONGEST_FIRST = sorted(VALUE.items(), key=lambda words: -len(words[1]))
_THING = re.compile(
    rf"(?:(?P<adjective>{'|'.join(_ADJECTIVES)})|(?P<colour>{'|'.join(sorted(COLOURS, key=len, reverse=True))})の?)?"
    rf"(?P<thing>{'|'.join(sorted(THING_WORDS, key=len, reverse=True))})\s*(?P<number>\d*)"
)


def standard(words: Mapping[str, str], text: str) -> str:
    """Return the standard word that a text means; the text itself when it is none of these words.

    >>> standard(DEVICES, "赤い ボール"), standard(DEVICES, "Red ball")
    ('Red ball', 'Red ball')
    """
    return words.get(key(text), text)


def standard_thing(text: str) -> str:
    """Return the name of a thing of the scene in standard words.

    >>> standard_thing("赤いボール"), standard_thing("オレンジ色の箱2"), standard_thing("ゆき")
    ('Red ball', 'Orange box 2', 'ゆき')
    """
    match = _THING.fullmatch(text.strip())
    if not match:
        return text
    colour = _ADJECTIVES.get(match["adjective"] or "") or COLOURS.get(match["colour"] or "", "")
    words = f"{colour} {THING_WORDS[match['thing']]} {match['number']}".strip()
    return words[:1].upper() + words[1:]


def standard_value(text: str) -> str:
    """Return a Value of the scene in standard words.

    >>> standard_value("位置 1, 0.2, 0.4 大きさ 10センチ"), standard_value("頭 長さ 2秒"), standard_value("名前 さくら")
    ('at 1, 0.2, 0.4 size 10 cm', 'Head for 2 s', 'name さくら')
    """
    return " ".join(_PIECES.sub(lambda match: f" {VALUE[match[0]]} ", text).split()) if _PIECES.search(text) else text


def japanese_value(text: str) -> str:
    """Return a Value of the scene in Japanese words.

    >>> japanese_value("at 1, 0.2, 0.4 size 10 cm"), japanese_value("Left hand for 2 s")
    ('位置 1, 0.2, 0.4 大きさ 10 センチ', '左手 長さ 2 秒')
    """
    for own, meant in _LONGEST_FIRST:
        unit = meant in _UNITS
        text = re.sub(rf"(?<=\d) ?{meant}(?!\w)" if unit else rf"(?<!\w){meant}(?!\w)", f" {own}", text)
    return " ".join(text.split())


def japanese_thing(text: str) -> str:
    """Return the name of a thing of the scene in Japanese, with its number; that of a person stays as it is.

    >>> japanese_thing("Red ball 2"), japanese_thing("Mia")
    ('赤いボール2', 'Mia')
    """
    name = text.rstrip("0123456789 ")
    own = japanese_word(THINGS, name)
    return text if own == name else f"{own}{text[len(name) :].strip()}"


def words_for(words: Mapping[str, str], *standards: str) -> list[str]:
    """Return all Japanese words that mean one of some standard ones.

    >>> words_for(VERBS, "appears", "disappears")
    ['現れる', '出てくる', '消える']
    """
    return [own for own, meant in words.items() if meant in standards]


def field_aliases(fields: Iterable[Field]) -> dict[str, str]:
    """Return the Japanese names of a record's fields, each with the field that it names."""
    names = {f.name for f in fields}
    return {own: meant for own, meant in FIELDS.items() if meant in names}


def offered(title: str, names: Iterable[str]) -> tuple[str, ...]:
    """Return the entries of a drop-down's list in Japanese, by the list's title.

    Devices come in English too: a drop-down's names are also those that are not marked as unknown.

    >>> offered("Mode", ["Head"]), offered("Connectors", ["map"]), offered("All devices", ["Red ball"])
    (('頭',), ('map',), ('赤いボール', 'Red ball'))
    """
    tables = {"All devices": DEVICES, "Thing": THINGS, "Does": VERBS, "Name": MOVES}
    own = japanese(tables.get(title) or CHOICES.get(key(title), {}), names)
    return tuple(dict.fromkeys((*own, *names))) if title == "All devices" else own


def japanese_word(words: Mapping[str, str], standard: str) -> str:
    """Return the Japanese word for a standard one by a table, or the standard one itself."""
    return japanese(words, [standard])[0]


def word_in(words: Mapping[str, str], standard: str, language: str) -> str:
    """Return the word for a standard one by a table, as workbooks of a language have it."""
    return japanese_word(words, standard) if language == "ja" else standard


def japanese(words: Mapping[str, str], standards: Iterable[str]) -> tuple[str, ...]:
    """Return the Japanese words for standard ones, the first for each; one that has none stays as it is.

    >>> japanese(CHOICES["mode"], ["Head", "Whole body", "Something"])
    ('頭', '全身', 'Something')
    """
    first: dict[str, str] = {}
    for word, meant in words.items():
        first.setdefault(key(meant), word)
    return tuple(first.get(key(one), one) for one in standards)


def in_both(words: Mapping[str, str], name: str, language: str) -> str:
    """Return a name as workbooks of a language have it, with the English one in brackets, which they may have too.

    >>> in_both(FIELDS, "colour", "ja"), in_both(FIELDS, "colour", "en")
    ('色（colour）', 'colour')
    """
    own = word_in(words, name, language)
    return name if own == name else f"{own}（{name}）"
