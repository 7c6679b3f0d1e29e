"""The words for true and false in cells: those of spreadsheet programs in many languages, and yes, no, on and off.

One list for the reader of the workbook, for settings of devices, and for the grid, which gets it as data.
"""

from __future__ import annotations

import re
import unicodedata

_INVISIBLE = re.compile("[\u00ad\u200b-\u200f\u2060\ufeff]")
_TRUE = """
    true yes on 1 wahr ja ein an vrai oui verdadero sí si vero sì verdadeiro sim waar aan sant sann sand tosi kyllä
    prawda tak pravda ano igaz igen doğru evet истина да αληθησ ναι はい オン 真 有効 是 开 開 예 참
"""
_FALSE = """
    false no off 0 falsch nein aus faux non falso não nao onwaar nee uit falskt falsk nej nei usann epätosi ei fałsz nie
    nepravda ne hamis nem yanlış yanliş hayır hayir ложь нет ψευδησ όχι いいえ オフ 偽 無効 否 关 關 아니요 거짓
"""


def _folded(text: str) -> str:
    """A cell's text as it is compared; `isOff` of the grid's table.js does the same."""
    return _INVISIBLE.sub("", unicodedata.normalize("NFKC", text)).strip().removeprefix("'").strip().casefold()


TRUE_WORDS = frozenset(_folded(word) for word in _TRUE.split())
FALSE_WORDS = frozenset(_folded(word) for word in _FALSE.split())


def truth_of(text: str) -> bool | None:
    """Return whether a cell says true or false; None when it says neither.

    >>> truth_of("Yes"), truth_of(" ＦＡＬＳＥ"), truth_of("いいえ"), truth_of("maybe"), truth_of("")
    (True, False, False, None, None)
    """
    word = _folded(text)
    return True if word in TRUE_WORDS else False if word in FALSE_WORDS else None
