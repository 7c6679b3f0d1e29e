"""Typesets pages into PDF and PNG with Typst, where possible with bundled fonts and not the machine's."""

from __future__ import annotations

import json
import unicodedata
from collections.abc import Mapping
from typing import Any, Literal

from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled, vendored

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
        made = _compiled(typst, files, form, options)
    except typst.TypstError as error:
        raise SheetsError(f"The {form.upper()} could not be made: {error}") from error
    return made, [_warning(script) for script in missing]


def _compiled(typst: Any, files: Mapping[str, bytes], form: str, options: Mapping[str, Any]) -> bytes:
    try:
        made = typst.compile(files, format=form, **options)
    except typst.TypstError:
        if "pdf_standards" not in options:
            raise
        # A letter without any font forbids an accessible PDF, and a plain one is better than none.
        made = typst.compile(files, format=form, **{k: v for k, v in options.items() if k != "pdf_standards"})
    return bytes(made if isinstance(made, bytes) else made[0])


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
        return (
            "The Japanese font does not come with this installation: Japanese texts use this machine's fonts, "
            "and are boxes where it has none."
        )
    return f"No font for {script} comes along: such letters use this machine's fonts, and are boxes where it has none."
