"""Texts of the program: written in English, shown in the reader's language by gettext catalogues (`locale/`)."""

from __future__ import annotations

import gettext
import re
from collections.abc import Callable, Mapping, Sequence
from functools import lru_cache, partial
from pathlib import Path
from string import Formatter
from typing import Any

from rrp_sheets.model.names import key

LOCALE = Path(__file__).parent / "locale"
_SPECIFICATION = re.compile(r",|\.?\d{0,2}[fg]|")
_LONGEST = 100_000  # characters of a message from another process
LANGUAGE_NAMES: Mapping[str, tuple[str, ...]] = {"en": ("English", "English", "英語"), "ja": ("日本語", "Japanese")}
"""By code: what its speakers call it, its English name, and further ones."""
LANGUAGES: Mapping[str, str] = {code: names[0] for code, names in LANGUAGE_NAMES.items()}
"""By code, each as its own speakers call it."""


class LazyMessage(str):
    """Text of the program with its `str.format` template and values; as a string it is English.

    Without values the template is a text in which braces are nothing special.

    >>> LazyMessage("Did you mean {guess}?", guess="redBall")
    'Did you mean redBall?'
    """

    template: str
    context: str
    places: Mapping[str, Any]
    forms: tuple[str, str] | None = None  # of one and of many, when `n` decides between them

    def __new__(cls, template: str, /, *, msgctxt: str = "", **places: Any) -> LazyMessage:
        """Fill the places of a template; `msgctxt` tells texts apart that are the same in English."""
        self = super().__new__(cls, template.format(**places) if places else template)
        self.template = str(template)
        self.context = msgctxt
        self.places = places
        return self

    def __reduce__(self) -> tuple[Any, ...]:
        if self.forms:
            return partial(plural, *self.forms, **self.places), ()
        return partial(LazyMessage, self.template, msgctxt=self.context, **self.places), ()


N_ = LazyMessage
"""Marks a text of the program: `make texts` finds it by this name."""


def plural(one: str, many: str, /, n: int, **places: Any) -> LazyMessage:
    """Return the message for a number, of two templates with the place `{n}`: a language has as many forms as it needs.

    >>> plural("{n:,} cell changed.", "{n:,} cells changed.", 1_200)
    '1,200 cells changed.'
    """
    self = LazyMessage(one if n == 1 else many, n=n, **places)
    self.forms = one, many
    return self


class MessageError(Exception):
    """Error that says something of the program's; `make texts` knows its subclasses by name."""

    def __init__(self, template: str = "", /, **places: Any) -> None:
        super().__init__(*([LazyMessage(template, **places)] if template else []))


def translate(text: str, language: str) -> str:
    """Return a message in a language; one without a translation stays English, and any other text is the user's.

    >>> translate(N_("Did you mean {guess}?", guess="a number"), "ja"), translate("a number", "ja")
    ('「a number」のことですか。', 'a number')
    """
    if not isinstance(text, LazyMessage) or language == "en":
        return str(text)
    catalogue = _catalogue(language)
    template = _translated(text.template, text.context, catalogue)
    if text.forms and (found := catalogue.ngettext(*text.forms, text.places["n"])) not in text.forms:
        template = found
    return template.format(**places_in(text.places, language)) if text.places else template


def places_in(places: Mapping[str, Any], language: str) -> dict[str, Any]:
    """Return the values of places, those that are messages in a language.

    >>> places_in({"name": "Red", "remedy": N_("Did you mean {guess}?", guess="Blue")}, "en")
    {'name': 'Red', 'remedy': 'Did you mean Blue?'}
    """
    return {name: translate(value, language) if isinstance(value, str) else value for name, value in places.items()}


def numbered(one: str, many: str, n: int, language: str) -> str:
    """Return the template for a number in a language, of those of one and of many in English."""
    return _catalogue(language).ngettext(one, many, n)


@lru_cache(maxsize=8)
def _catalogue(language: str) -> gettext.NullTranslations:
    """Return the texts of the program, then those of its pages."""
    known = [known_language(language)]
    found = gettext.translation("messages", LOCALE, known, fallback=True)
    found.add_fallback(gettext.translation("pages", LOCALE, known, fallback=True))
    return found


def message_templates() -> frozenset[str]:
    """Return the texts of the program in English, those whose meaning depends on a context left out."""
    with (LOCALE / "ja" / "LC_MESSAGES" / "messages.mo").open("rb") as file:
        known = gettext.GNUTranslations(file)._catalog  # type: ignore[attr-defined]  # no public way to its keys
    return frozenset(text for text in known if isinstance(text, str) and text and "\x04" not in text)


def _translated(template: str, context: str, catalogue: gettext.NullTranslations) -> str:
    """Return the translation of a template, also of one whose first letter was recased."""
    for text in (template, template[:1].swapcase() + template[1:]) if template else ():  # "" names a catalogue's head
        found = catalogue.pgettext(context, text) if context else catalogue.gettext(text)
        if found == text and not context:
            found = catalogue.ngettext(text, text, 1)  # another place may have it with a plural
        if found != text:
            return found
    return template


def message_from(template: str, context: str, places: Mapping[str, Any]) -> str:
    """Return the message that another process sent; a template that no text of the program can have stays as it is."""
    if not places:
        return LazyMessage(template, msgctxt=context)
    try:
        parts = [part for part in Formatter().parse(template) if part[1] is not None]
        if not all(not conversion and _SPECIFICATION.fullmatch(str(spec)) for _, _, spec, conversion in parts):
            return template
        texts = [name for _, name, _, _ in parts if isinstance(places[str(name)], str)]
        most = _LONGEST // max(len(texts), 1)
        long = {name: f"{value[:most]}…" for name, value in places.items() if name in texts and len(value) > most}
        return LazyMessage(template, msgctxt=context, **{**places, **long})
    except (ValueError, KeyError, TypeError, OverflowError):
        return template


def known_language(code: object) -> str:
    """The code of a language as a record has it; English when there is none, or none that is known."""
    return code if isinstance(code, str) and code in LANGUAGES else "en"


def language_code(text: str) -> str:
    """The code of the language that a text means; empty when it means none that there is.

    >>> language_code("Japanese"), language_code("日本語"), language_code("EN"), language_code("Klingon")
    ('ja', 'ja', 'en', '')
    """
    return next((code for code, names in LANGUAGE_NAMES.items() if key(text) in map(key, (code, *names))), "")


_REASONS = (
    N_("No such file or directory"), N_("Permission denied"), N_("Operation not permitted"), N_("File exists"),
    N_("Not a directory"), N_("Is a directory"), N_("Directory not empty"), N_("File name too long"),
    N_("No space left on device"), N_("Disk quota exceeded"), N_("Read-only file system"), N_("Input/output error"),
    N_("Too many open files"), N_("Too many levels of symbolic links"), N_("Address already in use"),
    N_("Text file busy"), N_("Invalid argument"), N_("Device or resource busy"),
)  # fmt: skip
"""Reasons of the operating system that people meet."""


def os_reason(error: OSError) -> str:
    """Return the reason of the operating system, as a text of the program if it is one of those people meet.

    >>> os_reason(FileNotFoundError(2, "No such file or directory")), os_reason(OSError())
    ('No such file or directory', 'the system refuses it')
    """
    return LazyMessage(error.strerror) if error.strerror else N_("the system refuses it")


# ---- several in one
_JOINED = {
    "": N_("{before}, {after}"), "and": N_("{before} and {after}"), "and of": N_("{before} and of {after}"),
    "or": N_("{before} or {after}"), ", then": N_("{before}, then {after}"), "→": N_("{before} → {after}"),
}  # fmt: skip
_COUNTED = {
    "error": (N_("{n} error"), N_("{n} errors")), "warning": (N_("{n} warning"), N_("{n} warnings")),
    "info": (N_("{n} note"), N_("{n} notes")),
}  # fmt: skip


def sentences(*parts: str) -> str:
    """Join sentences, without the empty ones."""
    return _chain([part for part in parts if part], N_("{before} {after}"))


def listed(things: Sequence[str], joiner: str = "") -> str:
    """Return `a, b and c`; without joiner `a, b, c`; with `, then` or `→` it stands between all: `a → b → c`.

    >>> listed(["a", "b", "c"], "and")
    'a, b and c'
    """
    if joiner in ("", ", then", "→") or len(things) < 2:
        return _chain(things, _JOINED[joiner])
    return _chain([_chain(things[:-1], _JOINED[""]), things[-1]], _JOINED[joiner])


def counted(counts: Mapping[str, int]) -> str:
    """Return the counts with their English words, or a text that everything is in order if all are zero.

    >>> counted({"error": 2, "warning": 1}), counted({"error": 0})
    ('2 errors, 1 warning', 'Everything is in order.')
    """
    some = [N_(_COUNTED[word][n != 1], n=n) for word, n in counts.items() if n]
    return listed(some) if some else N_("Everything is in order.")


def _chain(things: Sequence[str], template: str) -> str:
    """Join texts half by half, as joining hundreds of them one by one would nest messages too deeply."""
    if len(things) < 2:
        return things[0] if things else ""
    half = len(things) // 2
    return N_(template, before=_chain(things[:half], template), after=_chain(things[half:], template))


def capital(text: str) -> str:
    """Return the text as it is written at the beginning of a sentence."""
    return _recased(text, str.upper)


def small(text: str) -> str:
    """Return the text as it is written within a sentence."""
    return _recased(text, str.lower)


_FIRST = re.compile(r"\{(\w+)\}")


def _recased(text: str, case: Callable[[str], str]) -> str:
    if not isinstance(text, LazyMessage):
        return case(text[:1]) + text[1:]
    places = dict(text.places)
    if (first := _FIRST.match(text.template)) and first[1] in places:
        value = places[first[1]]
        places[first[1]] = _recased(value if isinstance(value, str) else str(value), case)
        return LazyMessage(text.template, msgctxt=text.context, **places)
    return LazyMessage(case(text.template[:1]) + text.template[1:], msgctxt=text.context, **places)
