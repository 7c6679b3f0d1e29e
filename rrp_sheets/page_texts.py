"""Texts of pages in the language of their reader: `_("{n} rows", n=3)` in templates, and data that a page is sent."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable
from typing import Any

from jinja2 import Environment, pass_context
from jinja2.runtime import Context
from markupsafe import Markup, escape

from rrp_sheets.texts import LOCALE, LazyMessage, known_language, numbered, translate

Language = Callable[[Context], str]


def install(environment: Environment, language: Language) -> None:
    """Give the templates of an environment their texts.

    Templates say `_("Runs of {book}", book=page.book)`, `ngettext("{n} run", "{n} runs", n)` and, where one text means
    several things, `pgettext("of a moment", "Note")`. Texts and values are escaped; a value may be `Markup`. A message
    in the data of a page is shown in the language too. `language` returns the code of the one a template is shown in.
    """

    @pass_context
    def text(context: Context, message: str, /, **places: Any) -> Markup:
        return text_in(context, "", message, **places)

    @pass_context
    def text_in(context: Context, msgctxt: str, message: str, /, **places: Any) -> Markup:
        code = language(context)
        return _filled(translate(LazyMessage(message, msgctxt=msgctxt), code), places, code)

    @pass_context
    def number(context: Context, one: str, many: str, n: int, /, **places: Any) -> Markup:
        code = language(context)
        return _filled(numbered(one, many, n, code), {"n": n, **places}, code)

    @pass_context
    def finalize(context: Context, value: object) -> object:
        return translate(value, language(context)) if isinstance(value, LazyMessage) else value

    environment.globals |= {"_": text, "pgettext": text_in, "ngettext": number}
    environment.finalize = finalize


def _filled(template: str, places: dict[str, Any], language: str) -> Markup:
    escaped = Markup(str(escape(template)).replace("&#39;", "'"))  # our attributes stand in double quotes
    if not places:
        return escaped
    own = {n: translate(value, language) if isinstance(value, LazyMessage) else value for n, value in places.items()}
    return escaped.format(**own)


class Versions:
    """Text of a page that was made in several languages at once, such as a row of the grid.

    Args:
        languages: the codes of those that are made.
        make: returns the text in one of them.
    """

    def __init__(self, languages: Iterable[str], make: Callable[[str], str]) -> None:
        self._texts = {code: make(code) for code in languages}

    def text(self, language: str) -> str:
        """Return the text in a language; in another one if it was not made in that."""
        found = self._texts.get(language)
        return next(iter(self._texts.values())) if found is None else found


def in_language(data: Any, language: str) -> Any:
    """Return data for JSON with its messages and its `Versions` in a language.

    >>> in_language({"text": LazyMessage("Did you mean {guess}?", guess="Blue"), "n": [1, "Blue"]}, "ja")
    {'text': '「Blue」のことですか。', 'n': [1, 'Blue']}
    """
    if isinstance(data, str):
        return translate(data, language)
    if isinstance(data, Versions):
        return data.text(language)
    if isinstance(data, dict):
        return {in_language(name, language): in_language(value, language) for name, value in data.items()}
    return [in_language(value, language) for value in data] if isinstance(data, (list, tuple)) else data


def json_in(data: Any, language: str) -> str:
    """Format data as JSON in a language, as short as it can be."""
    return json.dumps(in_language(data, language), ensure_ascii=False, separators=(",", ":"))


def script_texts(language: str) -> dict[str, Any]:
    """Return the translations of the texts of scripts; empty for English, and for a language that has none.

    A text with a plural has one translation for each category of `Intl.PluralRules`, by the English singular.
    """
    path = LOCALE / known_language(language) / "LC_MESSAGES" / "scripts.json"
    found: dict[str, Any] = json.loads(path.read_text(encoding="utf-8")) if path.is_file() else {}
    return found
