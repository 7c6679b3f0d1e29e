"""The bytes of a made workbook: the same workbook always gives the same bytes."""

from __future__ import annotations

import io
import re
import zipfile
from typing import Any

_MOMENT = (2026, 1, 1, 0, 0, 0)
_MODIFIED = re.compile(rb"(<dcterms:(?:created|modified)[^>]*>)[^<]*(</)")
_STAMP = rb"\g<1>2026-01-01T00:00:00Z\g<2>"
# Numbers are stored as text on purpose; without this Excel marks each with a green corner.
_AS_TEXT = b'<ignoredErrors><ignoredError sqref="A1:XFD1048576" numberStoredAsText="1"/></ignoredErrors></worksheet>'


def packed(book: Any) -> bytes:
    """Save an openpyxl workbook with a fixed date in its properties and in its zip entries."""
    first, second = io.BytesIO(), io.BytesIO()
    book.save(first)
    with zipfile.ZipFile(first) as source, zipfile.ZipFile(second, "w") as target:
        for name in source.namelist():
            data = source.read(name)
            if name == "docProps/core.xml":
                data = _MODIFIED.sub(_STAMP, data)
            elif name.startswith("xl/worksheets/") and data.endswith(b"</worksheet>"):
                # A height without this attribute is adapted when the row's text changes.
                data = data.replace(b' customHeight="1"', b"").removesuffix(b"</worksheet>") + _AS_TEXT
            entry = zipfile.ZipInfo(name, _MOMENT)
            entry.compress_type = zipfile.ZIP_DEFLATED
            entry.external_attr = 0o644 << 16
            target.writestr(entry, data)
    return second.getvalue()
