"""Brings the catalogues of `rrp_sheets/locale/` up to date with the texts of the program (`make texts`)."""

from __future__ import annotations

import ast
import re
import sys
from collections.abc import Iterator
from datetime import UTC, datetime
from itertools import chain
from pathlib import Path

import click
from babel.messages.catalog import Catalog
from babel.messages.extract import extract as babel_extract
from babel.messages.jslexer import tokenize, unquote_string
from babel.messages.pofile import read_po, write_po

from rrp_sheets.cli.language import language_option, paragraphs
from rrp_sheets.cli.main import COMMANDS, group
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.diagnostics.catalogue import load_page
from rrp_sheets.formulas.functions import library
from rrp_sheets.graph.device_table import COLOURS
from rrp_sheets.help.functions import words
from rrp_sheets.help.layout import sheets_of
from rrp_sheets.help.site import files, page
from rrp_sheets.model.exchange import DONE
from rrp_sheets.model.names import key
from rrp_sheets.render.texts import texts
from rrp_sheets.robots.catalogue import Robot, load_robot, robot_names
from rrp_sheets.scene.scene_words import KINDS
from rrp_sheets.texts import LANGUAGES
from rrp_sheets.web.views.workbook_list import templates
from rrp_sheets.workbook.template import in_japanese

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
from hatch_build import CATALOGUES, PAGES, compile_texts  # noqa: E402

MARKS = ("N_", "BadSoundError", "BadValueError", "CatalogueError")
"""Names of the function and the classes whose first argument is a text of the program."""
PLURAL = "plural"
"""Name of the function whose first two arguments are."""
_CLICK = {"_": None, "ngettext": (1, 2)}
_NOT_SHOWN = ("DeprecationWarning", "No options defined", "Boolean option", "Could not determine", "Arguments take",
              "Unknown color", "Name '", "(dynamic)", "Invalid start",
              "%(prog)s", "Show the version", "Confirm the action")  # fmt: skip
"""Beginnings of the texts of click that only a developer sees."""
_CLICK_MODULES = ("core", "decorators", "exceptions", "formatting", "parser", "termui", "types")
_WORDS = re.compile(r'[^=|{}≈#"]*[A-Za-z]{2}[^=|{}≈#"]*')
_CALL = re.compile(r"\btn?\(")
_CREATED = datetime(2026, 1, 1, tzinfo=UTC)  # no date that would change every file


def extract() -> Catalog:
    """Return a catalogue of all texts of the program, without translations."""
    found = _catalogue(None)
    for path in sorted((ROOT / "rrp_sheets").rglob("*.py")):
        for text in _marked(path):
            found.add(text)
    for text, context in _code_texts():
        found.add(text, context=context)
    for text in _example_texts():
        found.add(text, context="example")
    for text in {*_command_texts(), *_click_texts()}:
        found.add(text)
    for name, text in texts("en").entries.items():
        if text:
            found.add(text, context=name)
    for text, context in _help_texts():
        found.add(text, context=context)
    for connector in dict.fromkeys(connectors()):
        for message in (
            connector.help_message(),
            connector.legend_message(),
            *map(connector.sentence_for, ("", *connector.variants)),
        ):
            found.add(message.template, context=message.context)
    of_robots = chain.from_iterable(_robot_texts(load_robot(name)) for name in robot_names())
    verbs = [verb for kind in KINDS.values() for verb in kind.verbs]
    of_scenes = ((text, "scene") for verb in verbs for text in (verb.name, verb.example))
    of_templates = ((str(text), "template") for _, *about in templates()[2:] for text in about)
    for text, context in chain(of_robots, of_scenes, of_templates):
        if text:
            found.add(text, context=context)
    return found


def _command_texts() -> Iterator[str]:
    """Yield the texts of the help of commands and options."""
    yield from (summary for _, summary in COMMANDS.values())
    context = click.Context(group)
    commands: list[click.Command] = [group, *filter(None, (group.get_command(context, name) for name in COMMANDS))]
    while commands:
        command = commands.pop()
        commands += command.commands.values() if isinstance(command, click.Group) else []
        yield from (text for text in paragraphs(command.help) if "\b" not in text)
        yield from (param.help for param in command.params if isinstance(param, click.Option) and param.help)
        yield from filter(None, [command.short_help, language_option().help])


def _click_texts() -> Iterator[str | tuple[str, ...]]:
    """Yield the texts that click prints for the command line: headings of the help, errors of options, questions."""
    for name in _CLICK_MODULES:
        with (Path(click.__file__).parent / f"{name}.py").open("rb") as file:
            for _, text, _, _ in babel_extract("python", file, _CLICK):
                if not str(text).startswith(_NOT_SHOWN):
                    yield text


def _robot_texts(robot: Robot) -> Iterator[tuple[str, str | None]]:
    for device in robot.devices.values():
        for part in (
            "title",
            "help",
            "says",
            "says_given",
            "given",
            "says_fixed",
            "says_value",
            "when",
            "takes",
            "stops",
        ):
            yield getattr(device, part), f"{device.name}.{part}"
        for field in device.payload.fields if device.payload else ():
            yield field.name.replace("_", " "), f"{device.name}.{field.name}"
            yield field.help, f"{device.name}.{field.name}"
        yield device.example.partition("\n")[0].lstrip("# "), "example"
        for setting in device.settings.values():
            yield setting.name, "setting"
            yield setting.help, "setting's help"
            yield from ((choice, "value") for choice in setting.choices)
            yield setting.unit if " " in setting.unit else "", "value"  # the others are symbols
    yield from ((resource, None) for device in robot.devices.values() for resource in device.resources)
    yield from ((word, "value") for word in (*robot.touch_zones, *robot.languages.values(), *COLOURS, "TRUE", "FALSE"))
    yield from ((gesture.help, "gesture") for gesture in robot.motions.values())
    yield from ((name, "posture") for name in (*robot.postures, *robot.gestures))


def _code_texts() -> Iterator[tuple[str, str]]:
    for code in CODES.values():
        for part in ("title", "message", "remedy"):
            if getattr(code, part) != "{remedy}":  # which the finding brings
                yield getattr(code, part), f"{code.id}.{part}"
        page = load_page(code.id)
        for part in ("means", "why", "mend", "untabled"):
            if text := getattr(page, part):
                yield text, f"{code.id}.{part}"


def _help_texts() -> Iterator[tuple[str, str]]:
    for function in dict.fromkeys(library()):
        yield from ((message.template, message.context) for message in words(function))
    yield from ((field.help, "done") for field in DONE.fields)
    for kind in KINDS.values():
        yield from ((text, "scene") for text in (kind.name, kind.title, kind.help) if text)
        yield from ((line, "scene") for verb in kind.verbs for _, line in verb.examples if line)
        parts = [part for verb in kind.verbs for part in verb.parts]
        yield from ((word, "scene") for part in parts for word in (part.word, *part.choices) if word)


def _example_texts() -> Iterator[str]:
    """Yield the names, the notes and the texts of the examples of the help that Japanese examples have in Japanese."""
    robot, found = load_robot(), dict[str, None]()
    for file in files():
        for example in page(file, "en").examples:
            in_japanese(sheets_of(example.source), lambda text: found.setdefault(text) or text)
    choices = {c for d in robot.devices.values() for s in d.settings.values() for c in s.choices}
    ours = {*map(key, (*choices, *robot.touch_zones, *robot.postures, *robot.gestures, *COLOURS))}
    for text in found:
        if text.isascii() and _WORDS.fullmatch(text) and robot.find(text) is None and key(text) not in ours:
            yield text


TEMPLATES = ("templates/web/*.html", "templates/help/*.html", "templates/compare/*.html")
SCRIPTS = ("templates/web/static/**/*.js",)
_IN_TEMPLATES = {"_": None, "pgettext": ((1, "c"), 2), "ngettext": (1, 2)}
_IN_SCRIPTS = {"t": 1, "tn": 2}  # to the number of the texts that they take


def extract_pages() -> Catalog:
    """Return a catalogue of all texts of templates and scripts, without translations, with the files that have them."""
    found = _catalogue(None)
    for path in _files(*TEMPLATES):
        with path.open("rb") as file:
            for _, text, _, context in babel_extract(
                "jinja2.ext:babel_extract", file, _IN_TEMPLATES, options={"silent": "no"}
            ):
                found.add(text, context=context, locations=[(path.relative_to(ROOT).as_posix(), 1)])
    for path in _files(*SCRIPTS):
        for text in _of_script(path.read_text(encoding="utf-8"), path.name):
            found.add(text, locations=[(path.relative_to(ROOT).as_posix(), 1)])
    return found


def _files(*patterns: str) -> list[Path]:
    return sorted(path for pattern in patterns for path in ROOT.glob(pattern))


def _of_script(source: str, name: str) -> Iterator[str | tuple[str, ...]]:
    """Yield the texts of a script. (Babel's own extractor leaves out a text that stands within the call of another.)"""
    tokens = [token for token in tokenize(source, jsx=False) if not token.type.endswith("comment")]
    for at, token in enumerate(tokens):
        count = _IN_SCRIPTS.get(token.value, 0)
        call = (
            token.type == "name"
            and count
            and tokens[at + 1].value == "("
            and tokens[at - 1].value not in (".", "function")
        )
        texts = [unquote_string(one.value) for one in tokens[at + 2 : at + 2 + 2 * count : 2] if one.type == "string"]
        if (call and len(texts) != count) or (token.type == "template_string" and _CALL.search(token.value)):
            raise ValueError(
                f"{name}, line {token.lineno}: t and tn take texts as they are, and stand in no template string"
            )
        if call:
            yield texts[0] if count == 1 else tuple(texts)


def _catalogue(language: str | None) -> Catalog:
    return Catalog(
        language, project="RRP Sheets", version="1", header_comment="# Texts of RRP Sheets.", fuzzy=False,
        msgid_bugs_address="the issues of the repository", last_translator="The RRP Sheets authors",
        language_team="The RRP Sheets authors", creation_date=_CREATED, revision_date=_CREATED,
    )  # fmt: skip


def _marked(path: Path) -> Iterator[str | tuple[str, ...]]:
    for call in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if not (isinstance(call, ast.Call) and isinstance(call.func, ast.Name) and call.args):
            continue
        if call.func.id in MARKS:
            yield from _texts(call.args[0])
        elif call.func.id == PLURAL and all(isinstance(text, ast.Constant) for text in call.args[:2]):
            yield tuple(text.value for text in call.args[:2])  # type: ignore[attr-defined]


def _texts(node: ast.expr) -> Iterator[str]:
    if isinstance(node, ast.IfExp):
        yield from _texts(node.body)
        yield from _texts(node.orelse)
    elif isinstance(node, ast.Constant):
        yield node.value
    elif isinstance(node, ast.JoinedStr):
        raise ValueError(f"A marked text must be no f-string: {ast.unparse(node)}")


def update(path: Path, language: str, found: Catalog, known: Catalog | None = None) -> None:
    """Renew a language's catalogue, or begin it; what `known` has translated is taken from there."""
    catalogue = _catalogue(language)
    if path.exists():
        with path.open("rb") as file:
            catalogue = read_po(file, locale=language)
    catalogue.update(found, no_fuzzy_matching=True, update_creation_date=False)
    for message in catalogue:
        if known is not None and not message.string and (there := known.get(message.id, message.context)) is not None:
            message.string = there.string
    path.parent.mkdir(parents=True, exist_ok=True)
    with path.open("wb") as file:
        write_po(file, catalogue, width=0, include_lineno=False, sort_output=True, ignore_obsolete=True)


def renew(language: str) -> None:
    """Renew both catalogues of a language, or begin them."""
    program = ROOT / CATALOGUES.replace("*", language)
    update(program, language, extract())
    with program.open("rb") as file:
        update(ROOT / PAGES.replace("*", language), language, extract_pages(), read_po(file, locale=language))


if __name__ == "__main__":
    for language in LANGUAGES:
        if language != "en":
            renew(language)
    compile_texts(ROOT)
