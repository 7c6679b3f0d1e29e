"""The languages that explanations, diagrams and printed protocols can be in."""

from __future__ import annotations

from collections.abc import Mapping

from rrp_sheets.model.names import key

NAMES: Mapping[str, tuple[str, ...]] = {"en": ("English", "English", "英語"), "ja": ("日本語", "Japanese")}
"""By code: what its speakers call it, its English name, and further ones."""
LANGUAGES: Mapping[str, str] = {code: names[0] for code, names in NAMES.items()}
"""By code, each as its own speakers call it."""


def known_language(code: object) -> str:
    """The code of a language as a record has it; English when there is none, or none that is known."""
    return code if isinstance(code, str) and code in LANGUAGES else "en"


def language_code(text: str) -> str:
    """The code of the language that a text means; empty when it means none that there is.

    >>> language_code("Japanese"), language_code("日本語"), language_code("EN"), language_code("Klingon")
    ('ja', 'ja', 'en', '')
    """
    return next((code for code, names in NAMES.items() if key(text) in map(key, (code, *names))), "")
