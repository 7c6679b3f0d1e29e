"""Style of the diagrams (colours, fonts, sizes in points), the widths of texts, and pages typeset with Typst.

Kinds differ by shape too, for grey printers. Boxes get their size from here and not from a font, so a layout is the
same on every machine.
"""

from __future__ import annotations

import html
import json
import re
import unicodedata
from bisect import bisect_right
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, Literal

from rrp_sheets.errors import SheetsError
from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, SAME, SIGN_NAMES, MarkedText
from rrp_sheets.resources import bundled, vendored
from rrp_sheets.texts import N_

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


# Narrow: the diagram stands in a panel, where height costs less.
BESIDE_A_TABLE = Wrapping(14, 4, beside=4, whole=False)
WRAPPINGS = (Wrapping(), Wrapping(beside=16), Wrapping(20, 7), Wrapping(17, 8))


# Helvetica's widths in 1/1000 em for the characters 32 to 126, which are those of Arial and Liberation Sans too.
# Noto Sans JP, Segoe UI and Roboto are at most 8 % wider in usual words, their bold faces 16 %.
_WIDTHS = (
    278, 278, 355, 556, 556, 889, 667, 191, 333, 333, 389, 584, 278, 333, 278, 278,
    556, 556, 556, 556, 556, 556, 556, 556, 556, 556, 278, 278, 584, 584, 584, 556, 1015,
    667, 667, 722, 722, 667, 611, 778, 722, 278, 500, 667, 556, 833, 722, 778, 667, 778, 722, 667, 611, 722, 667, 944,
    667, 667, 611, 278, 278, 278, 469, 556, 333,
    556, 556, 500, 556, 556, 278, 556, 556, 222, 222, 500, 222, 833, 556, 556, 556, 556, 333, 500, 278, 556, 500, 722,
    500, 500, 500, 334, 260, 334, 584,
)  # fmt: skip
OTHER_FACES = 1.25
"""Factor by which a line may exceed `width`, in a browser that has none of those faces (DejaVu Sans, Verdana)."""
_OTHER = 640  # any further narrow character
_MONO = 602
_WIDE = 1000

# What XML 1.0 forbids, lone surrogates, the C1 controls, and the marks that turn the writing direction of what follows.
_FORBIDDEN = re.compile(
    "[\x00-\x08\x0b\x0c\x0e-\x1f\x7f-\x9f\ud800-\udfff\ufdd0-\ufdef\ufffe\uffff\u202a-\u202e\u2066-\u2069]"
)
_BREAKABLE = re.compile(r"[^\s,;(&+*/<>=]*(?:\s*[-,;(&+*/<>=%]+(?=[\s\w(\"]))*[^\w\s(\"']*\s*")

_WIDER = (1.5, 2.0, 3.0)
_ALL = 200  # lines: a formula that may be longer is refused anyway
_WITHIN = re.compile(r"[._]|(?<=[a-z])(?=[A-Z])")  # where a word that is too long may be cut


def clean(text: str) -> str:
    r"""Return the text on one line and without characters that no drawing can hold.

    >>> clean("a\x00b \n c")
    'a\ufffdb c'
    """
    return " ".join(_FORBIDDEN.sub("\ufffd", text).split())


def escape(text: str) -> str:
    """Escape the text for XML, also inside attributes.

    >>> escape('<b> & "c"')
    '&lt;b&gt; &amp; &quot;c&quot;'
    """
    return html.escape(_FORBIDDEN.sub("\ufffd", text), quote=True)


def wide(character: str) -> bool:
    """Return whether a character is as wide as it is high, as Japanese letters are."""
    return unicodedata.east_asian_width(character) in "WF"


def width(text: str, size: float, *, mono: bool = False, bold: bool = False) -> float:
    """Return the width of a line of text in points, rounded up for fonts that are slightly wider."""
    total = 0
    for character in text:
        if unicodedata.combining(character):
            continue
        if wide(character):
            total += _WIDE
        elif mono:
            total += _MONO
        else:
            total += _WIDTHS[ord(character) - 32] if " " <= character <= "~" else _OTHER
    return total * size / 1000 * (1.0 if mono else 1.16 if bold else 1.08)


def columns(text: str) -> int:
    """Return the number of columns of a text in a monospaced font; Japanese letters take two.

    >>> columns("ab赤")
    4
    """
    return sum(2 if wide(c) else 0 if unicodedata.combining(c) else 1 for c in text)


def shortened(text: str, room: float, measure: Callable[[str], float] = columns) -> str:
    """Return as much of a line as fits, with `…` for the rest; blank when nothing fits.

    >>> shortened("Distance of the ball", 12), shortened("Ball", 4), shortened("Ball", 1)
    ('Distance of…', 'Ball', '')
    """
    if measure(text) <= room:
        return text
    fitting = bisect_right(range(len(text)), room, key=lambda n: measure(text[:n] + "…")) - 1
    start = text[: max(0, fitting)].rstrip()
    return start + "…" if start else ""


def cut(text: str, room: float, size: float, *, mono: bool = False, bold: bool = False) -> str:
    """Return as much of a line as fits into so many points, with `…` for the rest."""
    return shortened(text, room, partial(width, size=size, mono=mono, bold=bold))


def wrap(text: str, most_columns: int, most_lines: int) -> tuple[str, ...]:
    """Wrap a text after spaces and operators; words that are too long are cut, and lines beyond the last become `…`.

    >>> wrap("AND(distance >= 0.5, distance < 2)", 22, 3)
    ('AND(distance >= 0.5,', 'distance < 2)')
    >>> wrap("one two three four", 9, 1)
    ('one two …',)
    """
    lines, line = [], ""
    for piece in _pieces(clean(text), most_columns):
        if line and columns((line + piece).rstrip()) > most_columns:
            lines.append(line.rstrip())
            line = piece
        else:
            line += piece
    if line.strip():
        lines.append(line.rstrip())
    if len(lines) > most_lines:
        last = lines[most_lines - 1]
        while columns(last) > most_columns - 2:
            last = last[:-1]
        lines = [*lines[: most_lines - 1], last.rstrip() + " …"]
    return tuple(lines) or ("",)


def wrap_whole(text: str, most_columns: int, most_lines: int) -> tuple[str, ...]:
    """Wrap a text without cutting anything: a longer one has longer lines, and at last more of them.

    >>> wrap_whole("one two three four", 9, 2)
    ('one two three', 'four')
    """
    lines = wrap(text, most_columns, _ALL)
    for share in _WIDER:
        if len(lines) <= most_lines:
            break
        lines = wrap(text, int(most_columns * share), _ALL)
    return lines


def _pieces(text: str, most_columns: int) -> list[str]:
    """Cut the text wherever a line may end; joined, the pieces are the text."""
    pieces = []
    for whole in _BREAKABLE.findall(text):
        rest = whole
        while columns(rest.rstrip()) > most_columns:
            cut = 1
            while columns(rest[: cut + 1]) <= most_columns:
                cut += 1
            cut = max((m.end() for m in _WITHIN.finditer(rest[:cut]) if m.end() > cut // 2), default=cut)
            pieces.append(rest[:cut])
            rest = rest[cut:]
        if rest:
            pieces.append(rest)
    return pieces


Line = tuple[MarkedText, ...]  # of text, some of whose words are marked


def marked_lines(
    runs: Sequence[MarkedText], most_columns: int, most_lines: int,
    set_in_lines: Callable[[str, int, int], tuple[str, ...]] = wrap,
) -> tuple[Line, ...]:  # fmt: skip
    """Wrap a text and keep the marks on its words; `set_in_lines` decides whether it may be cut.

    >>> marked_lines(((False, "steady < "), (True, "20")), 22, 3)
    (((False, 'steady < '), (True, '20')),)
    >>> marked_lines(((False, "one two "), (True, "three four")), 9, 3)
    (((False, 'one two'),), ((True, 'three'),), ((True, 'four'),))
    """
    marks = [marked for marked, text in runs for character in text if not character.isspace()]
    whole = clean("".join(text for _, text in runs))
    if not whole:
        return ()
    out, at = [], 0
    for line in set_in_lines(whole, most_columns, most_lines):
        parts: list[tuple[bool, str]] = []
        for character in line:
            marked = marks[at] if at < len(marks) else False
            if not character.isspace():
                at += 1
            elif not parts or not parts[-1][0]:
                marked = False  # a space between what is marked and what is not belongs to neither
            if parts and parts[-1][0] == marked:
                parts[-1] = (marked, parts[-1][1] + character)
            else:
                parts.append((marked, character))
        out.append(tuple(parts))
    return tuple(out)


def text_of(line: Line) -> str:
    """Return the text of a line without its marks."""
    return "".join(text for _, text in line)


FONTS = vendored("fonts")
_JAPANESE = ("CJK UNIFIED", "HIRAGANA", "KATAKANA", "FULLWIDTH", "HALFWIDTH KATAKANA", "IDEOGRAPHIC", "CJK ")
_BUNDLED = ("LATIN", "GREEK", "CYRILLIC", "SUPERSCRIPT", "SUBSCRIPT", "MODIFIER LETTER", "COMBINING")


def typeset(
    template: str, data: Mapping[str, Any], pictures: Mapping[str, str], form: Literal["pdf", "png"], *, ppi: int = 144
) -> tuple[bytes, list[str]]:
    """Set a template of `templates/print/` and return the file's bytes, and warnings for the user.

    Args:
        template: the file's name.
        data: read by the template as `data.json`; users' texts are only ever data.
        pictures: SVG texts by the file name under which the template asks for them.
        form: a PDF is accessible (PDF/UA).
        ppi: the resolution of a PNG, in pixels per inch.

    Raises:
        SheetsError: Typst could not set it.
    """
    import typst

    files = {
        "main.typ": (bundled("templates", "print") / template).read_bytes(),
        # a file's name can hold what is no letter in this system
        "data.json": json.dumps(data, ensure_ascii=False).encode(errors="replace"),
        **{name: svg.encode(errors="replace") for name, svg in pictures.items()},
    }
    missing = scripts_without_font("".join([json.dumps(data, ensure_ascii=False), *pictures.values()]))
    options: dict[str, Any] = {"pdf_standards": ["ua-1"], "timestamp": 0} if form == "pdf" else {"ppi": ppi}
    options |= {"font_paths": [FONTS] if FONTS.is_dir() else [], "ignore_system_fonts": not missing}
    try:
        try:
            made, told = typst.compile_with_warnings(files, format=form, **options)
        except typst.TypstError:
            if options.pop("pdf_standards", None) is None:
                raise
            # A letter without any font forbids an accessible PDF, and a plain one is better than none.
            made, told = typst.compile_with_warnings(files, format=form, **options)
    except typst.TypstError as error:
        raise SheetsError(N_("The {form} could not be made: {error}", form=form.upper(), error=str(error))) from error
    warnings = [_warning(script) for script in missing]
    if any("converge" in warning.message for warning in told):
        warnings.append(N_("The page numbers may be wrong: this text has no layout in which all of them are right."))
    return bytes(made if isinstance(made, bytes) else made[0]), warnings


def scripts_without_font(text: str) -> list[str]:
    """Return the scripts in a text for which no font is bundled, so that the machine's fonts are needed.

    >>> scripts_without_font("Distance – α“é” ≥ 2")
    []
    """
    japanese = (FONTS / "NotoSansJP-Regular.ttf").is_file()
    found: dict[str, None] = {}
    for character in sorted({c for c in text if c > "\u00ff"}):
        name = unicodedata.name(character, "UNKNOWN")
        if name.startswith(_JAPANESE):
            if not japanese:
                found["Japanese"] = None
        elif unicodedata.category(character)[0] in "LM" and not name.startswith(_BUNDLED):
            found[name.split()[0].capitalize()] = None
        elif character > "\uffff":
            found["Emoji"] = None
    return list(found)


def _warning(script: str) -> str:
    if script == "Japanese":
        return N_("The Japanese font does not come with this installation: Japanese texts use this machine's fonts, "
                  "and are boxes where it has none.")  # fmt: skip
    return N_("No font for {script} comes along: such letters use this machine's fonts, and are boxes where it has "
              "none.", script=script)  # fmt: skip
