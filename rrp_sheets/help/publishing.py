"""Writes the help as static pages that need no server: `rrp-sheets help --html DIR`."""

from __future__ import annotations

import json
import re
from pathlib import Path

from rrp_sheets.errors import SheetsError
from rrp_sheets.help.as_html import render
from rrp_sheets.help.layout import rows_to_open
from rrp_sheets.help.site import files, framed, other_language, page, search_index
from rrp_sheets.resources import bundled
from rrp_sheets.texts import LANGUAGES, N_
from rrp_sheets.workbook.maker import workbook_bytes

STYLES = ("style.css", "diagram.css", "help.css")
_LIST = "rrp-sheets-help.json"  # names the files that were written, by which a folder is known as one of ours
_ASSETS = {**{name: name for name in STYLES}, "icon.svg": "icon.svg", "help/search.js": "search.js"}
_NAME = re.compile(r"(?:[\w-]+/)?[\w-]+\.\w+")  # of a file that may be deleted: within the folder


def write_site(folder: Path) -> int:
    """Write all pages in every language into a folder, in place of those that were written there before.

    Returns:
        The number of pages.

    Raises:
        SheetsError: something else is in the folder, or it cannot be written.
    """
    try:
        old = _written(folder)
        made = dict(_files())
        _note(folder, {*old, *made})  # so that one which breaks off can be written again
        for name, data in made.items():
            path = folder / name
            path.parent.mkdir(exist_ok=True)
            path.write_bytes(data)
        for name in old - set(made):
            (folder / name).unlink(missing_ok=True)
        _note(folder, set(made))
    except OSError as error:
        why = error.strerror or str(error)
        message = N_("The help cannot be written into “{folder}”: {why}.", folder=str(folder), why=why)
        raise SheetsError(message, N_("Name another folder.")) from error
    return sum(name.endswith(".html") for name in made)


def _written(folder: Path) -> set[str]:
    """Return the names of the files that were written into a folder before; raises SheetsError when it has others."""
    if not folder.exists() or (folder.is_dir() and not any(folder.iterdir())):
        return set()
    try:
        names = json.loads((folder / _LIST).read_text(encoding="utf-8"))["files"]
        if all(_NAME.fullmatch(name) for name in names):
            return set(names)
    except (OSError, ValueError, TypeError, KeyError):
        pass
    message = N_("“{folder}” is not empty, and this command has not written what is in it.", folder=str(folder))
    raise SheetsError(message, N_("Name a folder that is empty or new."))


def _note(folder: Path, names: set[str]) -> None:
    folder.mkdir(parents=True, exist_ok=True)
    (folder / _LIST).write_text(json.dumps({"files": sorted(names)}, indent=0), encoding="utf-8")


def _files() -> list[tuple[str, bytes]]:
    """Return the names and contents of all files of the site."""
    found = [("index.html", render("start.html", "en", languages=LANGUAGES).encode())]
    for language in LANGUAGES:
        other = other_language(language)
        for file in files():
            there = {"language": other, "name": LANGUAGES[other], "href": f"../{other}/{file}"}
            books = f"../examples-{language}"
            shown = framed("site.html", file, language, opens=books, level=1, other=there, styles=STYLES)
            found.append((f"{language}/{file}", shown.encode()))
        found.append((f"{language}/search-index.js", search_index(language).encode()))
        examples = [example for file in files() for example in page(file, language).examples if example.drawn]
        found += [
            (f"examples-{language}/{example.anchor}.xlsx", workbook_bytes(rows_to_open(example), language=language))
            for example in examples
        ]
    static = bundled("templates", "web", "static")
    return [*found, *((f"assets/{name}", (static / source).read_bytes()) for source, name in _ASSETS.items())]
