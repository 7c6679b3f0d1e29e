"""The list of sheets and names in the document's properties (`TitlesOfParts`), kept in step with the workbook."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from rrp_sheets.workbook.patch.markup import as_utf8, find, inner_text, splice, text_xml, with_attributes
from rrp_sheets.workbook.patch.package_edit import PackageEdit
from rrp_sheets.workbook.patch.xml_lists import children

_TITLES = ("Properties", "TitlesOfParts", "vector")
_COUNTS = ("Properties", "HeadingPairs", "vector", "variant", "i4")


def titles_part(package: PackageEdit) -> str:
    """The part with the list; empty where there is none."""
    related = package.package.relations("").values()
    return next((t for kind, t in related if kind == "extended-properties" and t in package.package), "")


def keep_titles(
    package: PackageEdit, sheets: Sequence[str], named: Callable[[str], str] = str, added: Sequence[str] = ()
) -> None:
    """Write the list anew.

    Args:
        package: its book still tells the sheets there were; a list that names others is left alone.
        sheets: the names of the worksheets from now on.
        named: what the title of a name (`Mine!Print_Area`) is from now on; empty when it is gone.
        added: the titles of new names.
    """
    part = titles_part(package)
    data = as_utf8(package.read(part)) if part else b""
    titles = children(data, _TITLES) if data else []
    texts = [inner_text(data, e) if e.inner < e.inner_end else "" for e in titles]
    before = package.book.names
    if not titles or texts[: len(before)] != before:
        return
    counts = find(data, lambda at: tuple(at) == _COUNTS)
    rest = [new for text in texts[len(before) :] if (new := named(text))]
    rest += added if len(counts) > 1 else ()
    more = len(rest) - (len(texts) - len(before))
    name = titles[0].name
    written = b"".join(f"<{name}>".encode() + text_xml(t) + f"</{name}>".encode() for t in (*sheets, *rest))
    (box,) = find(data, lambda at: tuple(at) == _TITLES)
    size = {"size": str(len(sheets) + len(rest))}
    changes = [
        (box.start, box.inner, with_attributes(data[box.start : box.inner], size)),
        (titles[0].start, titles[-1].end, written),
    ]
    for e, by in ((counts[:1], len(sheets) - len(before)), (counts[1:][-1:], more)):
        changes += [(c.inner, c.inner_end, str(int(inner_text(data, c)) + by).encode()) for c in e if by]
    package.write(part, splice(data, changes))
