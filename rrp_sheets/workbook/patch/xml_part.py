"""Parts of a package as trees, which keep what other programs wrote: prefixes, comments, attribute order, encoding."""

from __future__ import annotations

import codecs
import re
from collections.abc import Iterator, Mapping

from lxml import etree

from rrp_sheets.errors import SheetsError
from rrp_sheets.texts import N_
from rrp_sheets.workbook import limits
from rrp_sheets.workbook.package import DECLARED

_UNICODE = {codecs.BOM_UTF16_LE: "utf-16", codecs.BOM_UTF16_BE: "utf-16", codecs.BOM_UTF8: "utf-8-sig"}
_DECLARATION = re.compile(rb"\A\s*<\?xml\s[^>]*\?>\s*")
_DOCTYPE = re.compile(rb"(?>\s+|<\?(?>.*?(?:\?>|\Z))|<!--(?>.*?(?:-->|\Z)))*+<!DOCTYPE", re.DOTALL)
_TOO_DEEP = etree.XPath(f"boolean({'/*' * (limits.XML_DEPTH + 1)})")


def broken() -> SheetsError:
    """The error for XML that cannot be changed safely."""
    return SheetsError(
        N_("A part of the file cannot be understood, so it is left as it is."),
        N_("Open the workbook in Excel or LibreOffice, save it under a new name, and use that."),
    )


def parse(data: bytes) -> etree._Element:
    """Parse UTF-8 without a declaration; raises SheetsError for broken or unsafe XML."""
    if _DOCTYPE.match(data):
        raise SheetsError(
            N_("A part of the file declares its own document type."), N_("Save the workbook anew in Excel.")
        )
    refuse_endless(data)
    parser = etree.XMLParser(
        encoding="utf-8", resolve_entities=False, no_network=True, huge_tree=False, load_dtd=False, strip_cdata=False
    )
    try:
        root = etree.fromstring(data, parser)
    except etree.XMLSyntaxError as error:
        raise broken() from error
    if _TOO_DEEP(root):
        raise broken()
    return root


def refuse_endless(data: bytes) -> None:
    """Raise SheetsError for more elements than may be read."""
    if data.count(b"<") - data.count(b"</") > limits.XML_ELEMENTS:
        raise broken()


class Touchable:
    """XML that is parsed to be looked at or changed; `touched` tells which."""

    touched = False

    def touch(self) -> None:
        """Note a change."""
        self.touched = True


class XmlPart(Touchable):
    """A part of a package; raises SheetsError for broken or unsafe XML."""

    def __init__(self, data: bytes) -> None:
        declared = DECLARED.search(data)
        self._encoding = next(
            (name for mark, name in _UNICODE.items() if data.startswith(mark)),
            declared[1].decode("ascii", "replace").casefold() if declared else "utf-8",
        )
        if self._encoding not in ("utf-8", "utf8"):
            try:
                data = data.decode(self._encoding).encode()
            except (UnicodeError, LookupError) as error:
                raise broken() from error
        found = _DECLARATION.match(data)
        self._declaration = found[0] if found else b""
        self.root = self._parse(data[len(self._declaration) :])

    def _parse(self, body: bytes) -> etree._Element:
        return parse(body)

    def container(self, *path: str) -> etree._Element | None:
        """The element at a path of local names, which begins with that of the first element."""
        found: etree._Element | None = self.root if local(self.root) == path[0] else None
        for name in path[1:]:
            found = child(found, name) if found is not None else None
        return found

    def children(self, *path: str) -> list[etree._Element]:
        """The elements inside of the one at a path."""
        container = self.container(*path)
        return [] if container is None else list(container.iterchildren("*"))

    def find(self, *names: str) -> Iterator[tuple[Touchable, etree._Element]]:
        """All elements of these local names, each with what is to be touched when it is changed."""
        for element in list(self.root.iter(*(f"{{*}}{name}" for name in names))):
            yield self, element

    def to_bytes(self) -> bytes:
        """The part as it is now, in its own encoding."""
        data = self._declaration + self._body()
        if self._encoding in ("utf-8", "utf8"):
            return data
        return data.decode().encode(self._encoding, "xmlcharrefreplace")

    def _body(self) -> bytes:
        return etree.tostring(self.root.getroottree(), encoding="UTF-8", xml_declaration=False)


def local(element: etree._Element) -> str:
    """An element's name without its namespace."""
    return str(element.tag).rpartition("}")[2]


def named_like(element: etree._Element, name: str) -> str:
    """A name in the namespace of an element."""
    space, bracket, _ = str(element.tag).rpartition("}")
    return f"{space}{bracket}{name}"


def child(element: etree._Element, name: str) -> etree._Element | None:
    """The first element of that local name inside of another."""
    return next(element.iterchildren(f"{{*}}{name}"), None)


def text_of(element: etree._Element) -> str:
    """The text of an element and all within it.

    >>> text_of(parse(b"<a>1 &lt; <b>2</b><!-- no --><![CDATA[ < 3]]></a>"))
    '1 < 2 < 3'
    """
    return "".join(map(str, element.itertext()))


def set_text(element: etree._Element, text: str) -> None:
    """Have a text alone inside of an element."""
    for inside in list(element):
        element.remove(inside)
    element.text = text or None


def set_attributes(element: etree._Element, changes: Mapping[str, str | None]) -> bool:
    """Change attributes, add them at the end, or (None) take them out; False when they were so already.

    >>> c = parse(b'<c r="A1" t="s"/>')
    >>> set_attributes(c, {"r": "A2", "t": None, "s": "3"}), etree.tostring(c)
    (True, b'<c r="A2" s="3"/>')
    """
    changes = {name: value for name, value in changes.items() if element.get(name) != value}
    for name, value in changes.items():
        if value is None:
            del element.attrib[name]
        else:
            element.set(name, value)
    return bool(changes)


def add(
    container: etree._Element, name: str, attributes: Mapping[str, str], text: str = "", at: int | None = None
) -> etree._Element:
    """Add an element of the container's namespace, at the end or at a place."""
    new = etree.SubElement(container, named_like(container, name), dict(attributes))
    new.text = text or None
    if at is not None:
        container.insert(at, new)
    return new


def new_element(like: etree._Element, name: str, attributes: Mapping[str, str]) -> etree._Element:
    """Return an element that is in no tree yet, with the namespaces of another one."""
    return etree.Element(named_like(like, name), dict(attributes), like.nsmap)  # type: ignore[arg-type]


def remove(element: etree._Element) -> None:
    """Take an element out of its tree."""
    parent = element.getparent()
    if parent is not None:
        parent.remove(element)


def canonical(element: etree._Element) -> bytes:
    """Return the canonical form (C14N) of an element, the same for equal ones."""
    return etree.tostring(element, method="c14n", exclusive=True, with_tail=False)
