"""Draws checked workbooks; writes diagrams as .svg, .pdf or .png, marbles as .txt too, metadata into them and GIFs."""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from rrp_sheets.diagnostics.catalogue import Severity
from rrp_sheets.errors import SheetsError
from rrp_sheets.model.names import key, nearest
from rrp_sheets.render import style
from rrp_sheets.render.diagram import Page, draw_diagram, draw_legend, to_dot
from rrp_sheets.render.marble_diagram import MarbleDiagram, marble_text
from rrp_sheets.render.marble_drawing import draw_marbles
from rrp_sheets.render.svg import frame, text
from rrp_sheets.render.texts import texts
from rrp_sheets.texts import N_, listed
from rrp_sheets.workbook.files import write_atomically

if TYPE_CHECKING:
    from rrp_sheets.checks import Checked
    from rrp_sheets.graph import BehaviourGraph

MOST_ROWS = 2_000  # a hundred pages; Graphviz takes half a minute for them
SUFFIXES = (".svg", ".pdf", ".png")
NOTHING = N_("There is nothing to draw: no behaviour has a row.")
NOT_WRITTEN = N_("A diagram cannot be written as “{suffix}”.")
_HEADING = 15.0  # points above a picture
_GAP = 14.0
_TALLEST = 1500.0  # points; a longer stack goes on in a further column, as no program shows taller pictures well
_PPI = 144
_MOST_PIXELS = 40_000_000


def draw(checked: Checked, target: Path, behaviour: str = "", language: str = "") -> list[str]:
    """Draw the behaviours (or one) into a file; return what the picture lacks (a font, say), in words.

    The language is the Protocol's unless another one is given.

    Raises:
        SheetsError: when it cannot be written or drawn.
    """
    path, suffix = target_of(target, NOT_WRITTEN, (*SUFFIXES, ".dot"))
    behaviours = chosen(checked, behaviour)
    if suffix == ".dot":  # one graph: programs that read it draw the first of several and are silent on the others
        if not any(b.steps for b in behaviours):
            raise SheetsError(NOTHING)
        write_atomically(path, to_dot(checked.graph, behaviours).encode())
        return []
    pages = []
    for graph in behaviours:
        if len(graph.steps) > MOST_ROWS:
            raise SheetsError(
                N_("The behaviour “{name}” has {n} rows; at most {most} can be drawn.",
                   name=graph.name, n=len(graph.steps), most=MOST_ROWS),
                N_("Split it into several behaviours."),
            )  # fmt: skip
        flags = {
            d.address.row: n
            for n, d in enumerate(checked.report, 1)
            if d.address and key(d.address.sheet) == graph.key and d.severity is not Severity.INFO
        }
        pages += draw_diagram(checked.graph, graph, problems=flags, language=language or checked.run.language)
    return write_diagram(pages, target)


def explain(checked: Checked, behaviour: str = "", language: str = "") -> str:
    """Explain the behaviours (or one) in plain words, in the Protocol's language or the one that is given."""
    from rrp_sheets.render.sentences import explain_text

    behaviours = chosen(checked, behaviour)
    return explain_text(checked.graph, checked.workbook, behaviours, language=language or checked.run.language)


def chosen(checked: Checked, name: str) -> list[BehaviourGraph]:
    """Return all behaviours, or the one of that name; raise SheetsError when there is none."""
    behaviours = checked.graph.behaviours
    found = [b for b in behaviours if not name or b.key == key(name)]
    if name and not found:
        names = [b.name for b in behaviours]
        guess = nearest(name, names)
        others = N_("The behaviours are: {names}.", names=listed(names))
        hint = N_("Did you mean {guess}?", guess=guess) if guess else others
        raise SheetsError(N_("There is no behaviour “{name}” in this workbook.", name=name), hint)
    return found


def write_diagram(pages: Sequence[Page], path: str | os.PathLike[str]) -> list[str]:
    """Write diagram pages into a file whose suffix gives the format; return warnings for the user.

    The file appears whole or not at all. An .svg or .png stacks all pages into one picture; a .pdf has one page each.

    Raises:
        SheetsError: an unknown suffix, nothing to draw, a folder that cannot be written, or Typst failed.
    """
    target, suffix = target_of(path, NOT_WRITTEN, SUFFIXES)
    if not pages:
        raise SheetsError(NOTHING)
    content, warnings = render_diagram(pages, suffix)
    write_atomically(target, content)
    return warnings


def target_of(path: str | os.PathLike[str], refusal: str, suffixes: Sequence[str]) -> tuple[Path, str]:
    """Return the file to write and its suffix; raise SheetsError with that refusal when no format has such a suffix."""
    target = Path(path)
    suffix = target.suffix.casefold()
    if suffix not in suffixes:
        raise SheetsError(
            N_(refusal, suffix=target.suffix or target.name),
            N_("Let the file's name end with one of: {suffixes}.", suffixes=listed(suffixes)),
        )
    return target, suffix


def render_diagram(
    pages: Sequence[Page], suffix: str, *, legend: bool = True, about: Mapping[str, str] | None = None
) -> tuple[bytes, list[str]]:
    """Return the bytes of a diagram file of that suffix, and warnings for the user.

    With `legend` the last page of a .pdf has one where there is room; `about` is what the file says of itself.
    """
    about = about or {}
    if suffix == ".svg":
        return svg_with(stack(pages)[0], about).encode("utf-8", "replace"), []
    if suffix == ".png":
        return render_picture(*stack(pages), suffix, _title(pages), about)
    return _pdf(pages, legend, about)


def render_picture(
    svg: str, wide: float, high: float, suffix: str, title: str, about: Mapping[str, str]
) -> tuple[bytes, list[str]]:
    """Return the bytes of a file of that suffix with one picture, and warnings for the user.

    The size is in points; `about` is what the file says of itself, which an SVG has already.
    """
    if suffix == ".svg":
        return svg.encode("utf-8", "replace"), []
    data = {"title": title, "about": words_of(about), "width": wide, "height": high}
    if suffix == ".pdf":
        return style.typeset("picture.typ", data, {"picture.svg": svg}, "pdf")
    ppi = min(_PPI, int(72 * (_MOST_PIXELS / (wide * high)) ** 0.5))
    png, warnings = style.typeset("picture.typ", data, {"picture.svg": svg}, "png", ppi=ppi)
    return png_with(png, {"Title": title, "Description": words_of(about)} if about else {}), warnings


def stack(pages: Sequence[Page]) -> tuple[str, float, float]:
    """Stack all pages in one SVG under their headings; return it with its width and height in points."""
    pieces: list[str] = []
    x = y = column = highest = 0.0
    for page in pages:
        need = _HEADING + page.height + _GAP
        if y and y + need > _TALLEST:
            x, y, column = x + column + _GAP, 0.0, 0.0
        heading = page.title if page.part == 1 else ""
        caption_x = x + style.PADDING + (len(heading) * style.NAME_PT * 0.75 + 10 if heading else 0)
        if heading:
            pieces.append(text(x + style.PADDING, y + 13, heading, style.NAME_PT + 2, bold=True))
        if page.caption:
            pieces.append(text(caption_x, y + 13, page.caption, style.SMALL_PT, fill=style.SOFT, italic=True))
        size = f' width="{page.width:.1f}" height="{page.height:.1f}"'
        inner = re.sub(r' width="\d+pt" height="\d+pt"', size, page.svg, count=1)
        pieces.append(inner.replace("<svg ", f'<svg x="{x:.1f}" y="{y + _HEADING:.1f}" ', 1).strip())
        y += need
        column = max(column, page.width, caption_x - x + 160)
        highest = max(highest, y)
    wide, high = x + column, highest - _GAP + style.PADDING
    title = _title(pages)
    alt = " ".join(page.alt for page in pages)
    return frame("\n".join(pieces), wide, high, ident="all", title=title, description=alt), wide, high


def _pdf(pages: Sequence[Page], with_legend: bool, about: Mapping[str, str]) -> tuple[bytes, list[str]]:
    last = pages[-1]
    legend, wide, high = draw_legend(last.language)
    room = (style.PAGE[1] if not last.landscape else 0) - last.height * last.scale
    words = texts(last.language)
    data = {
        "title": _title(pages),
        **({"about": words_of(about)} if about else {}),
        "lang": words.language,
        "page_n_of_m": words.get("page.n_of_m"),
        "legend": {"width": wide, "alt": words.get("legend.alt")},
        "pages": [
            {
                "title": page.title, "caption": page.caption, "part": page.part, "alt": page.alt,
                "landscape": page.landscape, "width": page.width * page.scale,
                "legend": with_legend and page is last and room > high,
            }
            for page in pages
        ],
    }  # fmt: skip
    pictures = {f"page-{n}.svg": page.svg for n, page in enumerate(pages)}
    return style.typeset("diagram.typ", data, {**pictures, "legend.svg": legend}, "pdf")


def _title(pages: Sequence[Page]) -> str:
    """Join the titles of all pages; no comma follows one that is a sentence."""
    return ", ".join(dict.fromkeys(page.title for page in pages)).replace("., ", ". ")


MARBLE_SUFFIXES = (".svg", ".pdf", ".png", ".txt")


def write_marbles(scores: Sequence[MarbleDiagram], path: str | os.PathLike[str]) -> list[str]:
    """Write marble diagrams into a file whose suffix gives the format; return warnings for the user.

    An .svg or .png stacks all into one picture, a .pdf has A4 pages. What the diagrams are about stands in the file's
    metadata, and as their foot in the picture.

    Raises:
        SheetsError: an unknown suffix, nothing to draw, a folder that cannot be written, or Typst failed.
    """
    target, suffix = target_of(path, N_("Marble diagrams cannot be written as “{suffix}”."), MARBLE_SUFFIXES)
    if suffix == ".txt":
        write_atomically(target, text_of(scores).encode())
        return []
    pages = draw_marbles(scores)
    if not pages:
        raise SheetsError(N_("There is nothing to draw: no value came on any stream."))
    content, warnings = render_diagram(pages, suffix, legend=False, about=dict(scores[0].about))
    write_atomically(target, content)
    return warnings


def text_of(scores: Sequence[MarbleDiagram], width: int = 110) -> str:
    """Return all diagrams as plain text, each under its title."""
    lines: list[str] = []
    for score in scores:
        lines += [score.title, *marble_text(score, width), *filter(None, [style.clean(score.foot)]), ""]
    return "\n".join(lines)


_SIGNATURE, _HEAD = 8, 25  # bytes at the begin of a PNG: texts may come behind them
_XMP = b"\x21\xff\x0bXMP DataXMP"  # in a GIF; what follows is no sub-block, and so has a trailer that ends as one
_TRAILER = b"\x01" + bytes(range(255, -1, -1)) + b"\x00"
_END = b"\x3b"


def words_of(about: Mapping[str, str]) -> str:
    """Return metadata as one line of text.

    >>> words_of({"Workbook": "greeter.xlsx", "Seed": "7"})
    'Workbook: greeter.xlsx; Seed: 7'
    """
    return "; ".join(f"{name}: {value}" for name, value in about.items())


def metadata(about: Mapping[str, str]) -> str:
    """Return metadata as an element for an SVG."""
    cleaned = [(style.escape(style.clean(n)), style.escape(style.clean(v))) for n, v in about.items()]
    told = "".join(f'<entry name="{name}">{value}</entry>' for name, value in cleaned)
    return f'<metadata><about xmlns="urn:rrp-sheets:about">{told}</about></metadata>' if told else ""


def svg_with(svg: str, about: Mapping[str, str]) -> str:
    """Insert metadata into an SVG of ours, behind its description."""
    begin, found, rest = svg.partition("</desc>\n")
    return f"{begin}{found}{metadata(about)}{rest}" if found else svg


def png_with(png: bytes, texts: Mapping[str, str]) -> bytes:
    """Insert texts into a PNG as iTXt chunks, which image programs show."""
    begin = _SIGNATURE + _HEAD
    chunks = b""
    for name, content in texts.items():
        data = b"iTXt" + name.encode("latin-1", "replace")[:79] + b"\0\0\0\0\0" + content.encode("utf-8", "replace")
        chunks += struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    return png[:begin] + chunks + png[begin:]


def gif_with(gif: bytes, about: Mapping[str, str]) -> bytes:
    """Insert metadata into a GIF as XMP; one that does not end as it should is left as it is."""
    if not gif.endswith(_END) or not about:
        return gif
    told = style.escape(style.clean(words_of(about)))
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        '<rdf:Description xmlns:dc="http://purl.org/dc/elements/1.1/"><dc:description><rdf:Alt>'
        f'<rdf:li xml:lang="x-default">{told}</rdf:li></rdf:Alt></dc:description>'
        "</rdf:Description></rdf:RDF></x:xmpmeta>"
    )
    return gif[: -len(_END)] + _XMP + xmp.encode("utf-8", "replace") + _TRAILER + _END
