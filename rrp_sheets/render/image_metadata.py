"""What a picture says of itself to programs: in an SVG's metadata, a PNG's texts, a GIF's XMP; a PDF has a description.

All of it is plain text in the file, for programs that look for it.
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Mapping

from rrp_sheets.render.measure import clean, escape

_SIGNATURE, _HEAD = 8, 25  # bytes at the begin of a PNG: texts may come behind them
_XMP = b"\x21\xff\x0bXMP DataXMP"  # in a GIF; what follows is no sub-block, and so has a trailer that ends as one
_TRAILER = b"\x01" + bytes(range(255, -1, -1)) + b"\x00"
_END = b"\x3b"


def words_of(about: Mapping[str, str]) -> str:
    """As one line of text.

    >>> words_of({"Workbook": "greeter.xlsx", "Seed": "7"})
    'Workbook: greeter.xlsx; Seed: 7'
    """
    return "; ".join(f"{name}: {value}" for name, value in about.items())


def metadata(about: Mapping[str, str]) -> str:
    """As an element for an SVG."""
    told = "".join(f'<entry name="{escape(clean(n))}">{escape(clean(v))}</entry>' for n, v in about.items())
    return f'<metadata><about xmlns="urn:rrp-sheets:about">{told}</about></metadata>' if told else ""


def svg_with(svg: str, about: Mapping[str, str]) -> str:
    """An SVG of ours with that in it, behind its description."""
    begin, found, rest = svg.partition("</desc>\n")
    return f"{begin}{found}{metadata(about)}{rest}" if found else svg


def png_with(png: bytes, texts: Mapping[str, str]) -> bytes:
    """A PNG with texts in it (as iTXt chunks), which image programs show."""
    begin = _SIGNATURE + _HEAD
    chunks = b""
    for name, text in texts.items():
        data = b"iTXt" + name.encode("latin-1", "replace")[:79] + b"\0\0\0\0\0" + text.encode("utf-8", "replace")
        chunks += struct.pack(">I", len(data) - 4) + data + struct.pack(">I", zlib.crc32(data))
    return png[:begin] + chunks + png[begin:]


def gif_with(gif: bytes, about: Mapping[str, str]) -> bytes:
    """A GIF with that in it, as XMP; one that does not end as it should is left as it is."""
    if not gif.endswith(_END) or not about:
        return gif
    told = escape(clean(words_of(about)))
    xmp = (
        '<x:xmpmeta xmlns:x="adobe:ns:meta/"><rdf:RDF xmlns:rdf="http://www.w3.org/1999/02/22-rdf-syntax-ns#">'
        '<rdf:Description xmlns:dc="http://purl.org/dc/elements/1.1/"><dc:description><rdf:Alt>'
        f'<rdf:li xml:lang="x-default">{told}</rdf:li></rdf:Alt></dc:description>'
        "</rdf:Description></rdf:RDF></x:xmpmeta>"
    )
    return gif[: -len(_END)] + _XMP + xmp.encode("utf-8", "replace") + _TRAILER + _END
