"""The languages that explanations, diagrams and printed protocols can be in."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.model.names import key

LANGUAGES: Mapping[str, str] = {"en": "English", "ja": "日本語"}
"""By code, each as its own speakers call it."""

_MEANT = {"en": "en", "english": "en", "英語": "en", "ja": "ja", "japanese": "ja", "日本語": "ja"}


def known_language(code: object) -> str:
    """The code of a language as a record has it; English when there is none, or none that is known."""
    return code if isinstance(code, str) and code in LANGUAGES else "en"


def language_code(text: str) -> str:
    """The code of the language that a text means; empty when it means none that there is.

    >>> language_code("Japanese"), language_code("日本語"), language_code("EN"), language_code("Klingon")
    ('ja', 'ja', 'en', '')
    """
    return {key(name): code for name, code in _MEANT.items()}.get(key(text), "")
