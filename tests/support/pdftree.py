"""Tags of an accessible PDF, read with a library that did not make it."""

from __future__ import annotations

import io
from collections.abc import Iterator
from dataclasses import dataclass, field

from pypdf import PageObject, PdfReader
from pypdf.generic import ArrayObject, DictionaryObject


@dataclass
class Tag:
    """An element of the structure: what it is, what stands for a picture, and what is in it."""

    name: str
    alt: str = ""
    scope: str = ""
    children: list[Tag] = field(default_factory=list)

    def all(self, *names: str) -> Iterator[Tag]:
        """The elements of these kinds in it, in reading order."""
        for child in self.children:
            if child.name in names:
                yield child
            yield from child.all(*names)


def read_pdf(data: bytes) -> PdfReader:
    return PdfReader(io.BytesIO(data))


def tags(pdf: PdfReader) -> Tag:
    """The document's tags; standard names for those that the file names otherwise."""
    root = pdf.trailer["/Root"]["/StructTreeRoot"]
    roles = {k: str(v) for k, v in root.get("/RoleMap", {}).items()}
    return Tag("root", children=list(_kids(root, roles)))


def _kids(node: DictionaryObject, roles: dict[str, str]) -> Iterator[Tag]:
    for kid in _entries(node, "/K"):
        if "/S" in kid:
            name = str(kid["/S"])
            scopes = [str(a["/Scope"]) for a in _entries(kid, "/A") if "/Scope" in a]
            children = list(_kids(kid, roles))
            yield Tag(roles.get(name, name)[1:], str(kid.get("/Alt", "")), "".join(scopes), children)


def _entries(node: DictionaryObject, name: str) -> list[DictionaryObject]:
    """The dictionaries under a name: one, or several in a list; references followed."""
    found = node.get(name, ArrayObject()).get_object()
    several = [one.get_object() for one in (found if isinstance(found, ArrayObject) else [found])]
    return [one for one in several if isinstance(one, DictionaryObject)]


def texts_of(pdf: PdfReader) -> list[str]:
    """The text of every page, in one line."""
    return [" ".join(page.extract_text().split()) for page in pdf.pages]


def unspaced(text: str) -> str:
    """The text without spaces and line ends: where a column is narrow, a line may end within a long word."""
    return "".join(text.split())


def filled(page: PageObject) -> float:
    """Part of a page that its words fill above the foot, from 0 to 1; those of diagrams count."""
    high, lowest = float(page.mediabox.height), [float(page.mediabox.height)]

    def visit(text: str, matrix: list[float], inner: list[float], *_: object) -> None:
        y = inner[4] * matrix[1] + inner[5] * matrix[3] + matrix[5]
        if text.strip() and y > 0.085 * high:
            lowest.append(y)

    page.extract_text(visitor_text=visit)
    return (0.92 * high - min(lowest)) / (0.835 * high)
