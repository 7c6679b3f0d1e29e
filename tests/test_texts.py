"""The texts of the program and their catalogues: what is marked, what translators may write, what others send."""

from __future__ import annotations

import ast
import json
import re
import sys
from copy import deepcopy
from gettext import GNUTranslations
from pathlib import Path

import pytest
from babel.messages.catalog import Catalog, Message
from babel.messages.pofile import read_po, write_po
from translations import MARKS, PLURAL, extract, extract_pages, update

import rrp_sheets
from rrp_sheets import texts
from rrp_sheets.diagnostics import Diagnostic, Report
from rrp_sheets.texts import LANGUAGES, LOCALE, N_, LazyMessage, capital, plural, small, translate
from rrp_sheets.workers.codec import pack, unpack

ROOT = Path(rrp_sheets.__file__).parents[1]
sys.path.insert(0, str(ROOT))
from hatch_build import CATALOGUES, PAGES, compile_texts, faults, script_texts  # noqa: E402

OTHERS = [language for language in LANGUAGES if language != "en"]


def name(message: Message) -> tuple[str, str]:
    """The context and the text; of one with a plural that for one."""
    return message.context or "", message.id if isinstance(message.id, str) else message.id[0]


def entries(catalogue: Catalog) -> dict[tuple[str, str], str]:
    """The translations; of a text with a plural all, joined."""
    return {name(m): "".join(m.string or ()) for m in catalogue if m.id}


def translated(message: Message) -> bool:
    return bool(message.string) and all(message.string)


@pytest.fixture(scope="module", params=OTHERS)
def written(request):
    with (LOCALE / request.param / "LC_MESSAGES" / "messages.po").open("rb") as file:
        return request.param, read_po(file)


@pytest.fixture(scope="module", params=OTHERS)
def pages(request):
    with (ROOT / PAGES.replace("*", request.param)).open("rb") as file:
        return request.param, read_po(file, locale=request.param)


@pytest.fixture(scope="module")
def program():
    """The catalogue of all texts of the program: to look for them takes longer than all that is done with them."""
    return extract()


@pytest.fixture(scope="module")
def extracted(program):
    return entries(program)


@pytest.fixture(scope="module")
def of_pages():
    """The catalogue of all texts of templates and scripts."""
    return extract_pages()


# ---- catalogues
def test_catalogue_has_every_text_of_the_program_translated(written, extracted):
    _, catalogue = written
    there = entries(catalogue)
    assert len(extracted) > 1_000 and sorted(there) == sorted(extracted)  # else: make texts
    assert [text for text, own in there.items() if not own] == []
    assert not any(message.fuzzy for message in catalogue)


def test_compiled_catalogue_is_there_and_up_to_date(written):
    language, catalogue = written
    assert (LOCALE / language / "LC_MESSAGES" / "messages.mo").is_file()  # else: make setup
    for (context, text), own in entries(catalogue).items():
        assert translate(LazyMessage(text, msgctxt=context), language) == (own or text)


def test_translations_keep_the_places_of_the_english_texts(written, pages):
    assert [*faults(written[1]), *faults(pages[1])] == []


def test_japanese_texts_name_sheets_in_japanese(written, pages):
    english = re.compile(
        r"(?:シート|「)[ 「]?(?:Devices|Helpers|Risks|Scene|Protocol)\b|\b(?:Devices|Helpers|Risks|Scene|Protocol)(?:シート| で)"
    )
    texts_of = [text for _, catalogue in (written, pages) for text in entries(catalogue).values()]
    assert [text for text in texts_of if english.search(text)] == []


def test_catalogue_of_pages_has_every_text_of_templates_and_scripts(pages, of_pages):
    there, wanted = (
        {(m.context, m.id): sorted({name for name, _ in m.locations}) for m in c if m.id} for c in (pages[1], of_pages)
    )
    assert len(wanted) > 700 and there == wanted  # else: make texts
    assert not any(message.fuzzy for message in pages[1])
    assert [m.id for m in pages[1] if m.id and not translated(m)] == []


def test_compiled_catalogue_of_pages_is_up_to_date(pages):
    language, catalogue = pages
    folder = (ROOT / PAGES.replace("*", language)).parent
    with (folder / "pages.mo").open("rb") as file:
        compiled = GNUTranslations(file)
    for message in (m for m in catalogue if m.id and translated(m)):  # else: make setup
        if message.pluralizable:
            assert compiled.ngettext(*message.id, 1_000) in message.string
        else:
            own = compiled.pgettext(message.context, message.id) if message.context else compiled.gettext(message.id)
            assert own == message.string
    assert json.loads((folder / "scripts.json").read_text(encoding="utf-8")) == script_texts(catalogue)


def test_a_text_has_one_translation(written, pages):
    """`make texts` takes the translations of texts of pages from those of the program."""
    known = entries(written[1])
    assert [
        m.id
        for m in pages[1]
        if m.id and translated(m) and not m.pluralizable and known.get(name(m), m.string) != m.string
    ] == []


def test_a_text_with_a_translation_is_marked(extracted):
    known = {text for context, text in extracted if not context and " " in text}
    unmarked = []
    for package in (
        "checks",
        "compare",
        "connectors",
        "drivers",
        "engine",
        "robots",
        "scene",
        "formulas",
        "graph",
        "perception",
        "replay",
        "sim",
        "testing",
        "workbook",
        "workers",
    ):
        for path in Path(rrp_sheets.__file__).parent.joinpath(package).rglob("*.py"):
            tree = ast.parse(path.read_text(encoding="utf-8"))
            marked = {
                inner
                for call in ast.walk(tree)
                if isinstance(call, ast.Call) and getattr(call.func, "id", "") in (*MARKS, PLURAL)
                for inner in ast.walk(call)
            }
            unmarked += [
                f"{path.name}:{node.lineno}"
                for node in ast.walk(tree)
                if isinstance(node, ast.Constant) and node.value in known and node not in marked
            ]
    assert unmarked == []


def test_update_keeps_translations_adds_new_texts_and_drops_old_ones(tmp_path, program, extracted):
    path = tmp_path / "messages.po"
    old = Catalog("de")
    old.add("a number", "eine Zahl")
    old.add("nobody says this", "niemand")
    with path.open("wb") as file:
        write_po(file, old)
    update(path, "de", deepcopy(program))
    once = path.read_bytes()
    with path.open("rb") as file:
        there = entries(read_po(file))
    assert sorted(there) == sorted(extracted)
    assert {text: own for (_, text), own in there.items() if own} == {"a number": "eine Zahl"}
    update(path, "de", deepcopy(program))
    assert path.read_bytes() == once


def test_update_takes_translations_that_another_catalogue_has(tmp_path, of_pages):
    known = Catalog("de")
    known.add("Close", "Schließen")
    known.add("Row", "")
    path = tmp_path / "pages.po"
    update(path, "de", deepcopy(of_pages), known)
    with path.open("rb") as file:
        assert [(m.id, m.string) for m in read_po(file) if m.id and translated(m)] == [("Close", "Schließen")]


def test_without_compiled_catalogue_texts_are_english(monkeypatch, tmp_path):
    monkeypatch.setattr(texts, "LOCALE", tmp_path)
    texts._catalogue.cache_clear()
    try:
        finding = Report().add("GRAPH011", None, name="Near")
        assert translate(finding.message, "ja") == str(finding.message) and "Near" in finding.message
        assert finding.as_dict("ja") == finding.as_dict("en")
    finally:
        texts._catalogue.cache_clear()


def test_a_language_that_a_file_names_is_no_path(tmp_path):
    catalogue = Catalog("ja")
    catalogue.add("a number", "hostile")
    path = tmp_path / CATALOGUES.replace("*", "ja")
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        write_po(file, catalogue)
    compile_texts(tmp_path)
    assert translate(N_("a number"), f"../../../../../../../../../..{path.parents[1]}") == "a number"


# ---- what translators may write
def test_a_text_for_one_need_not_say_the_number(tmp_path):
    catalogue = Catalog("de")
    catalogue.add(("One row", "{n} rows"), ("Eine Zeile", "{n} Zeilen"))
    catalogue.add(("{n} run of {book}", "{n} runs of {book}"), ("{n} Lauf", "{n} Läufe von {book}"))
    catalogue.add(("{n} cell", "{n} cells"), ("", ""))
    assert [fault.partition(":")[0] for fault in faults(catalogue)] == ["'{n} runs of {book}'"]


@pytest.mark.parametrize(
    "own",
    [
        "{many} Zeilen", "Zeilen", "{n!r} Zeilen", "{n.real} Zeilen", "{n[0]} Zeilen", "{n:>99999999} Zeilen", "{} Zeilen",
        "{0} Zeilen", "{n:{n}} Zeilen", "{n Zeilen", "{n} Zeilen\x00", "{n} \u202eZeilen", "{n} Zei\nlen",
    ],
)  # fmt: skip
def test_a_translation_that_cannot_be_shown_is_refused(tmp_path, own):
    catalogue = Catalog("de")
    catalogue.add("{n} rows", own)
    assert len(list(faults(catalogue))) == 1
    path = tmp_path / CATALOGUES.replace("*", "de")
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        write_po(file, catalogue)
    with pytest.raises(ValueError, match="rows"):
        compile_texts(tmp_path)
    assert not path.with_suffix(".mo").exists()


def test_a_translation_may_leave_out_specifications_and_take_details_of_its_finding():
    catalogue = Catalog("de")
    catalogue.add("{n:g} s", "{n} Sekunden")
    catalogue.add("Too many rows: {n:,}.", "{sheet}: {n:,} Zeilen.", context="SHEET019.message")
    catalogue.add("Shorten {sheet}.", "{sheet} kürzen.", context="SHEET019.remedy")
    catalogue.add("Write } to end it.", "} beendet es.")
    catalogue.add("A text { }", "Text { }")
    assert list(faults(catalogue)) == []


# ---- what users type
@pytest.mark.parametrize("typed", ["{name.__class__}", "{0}", "{}", "{", "{guess!r:>99}", "a number", "%(name)s"])
def test_what_users_type_is_no_template_and_is_never_looked_up(typed):
    inner = N_("Did you mean {guess}?", guess=typed)
    outer = N_("{before} {after}", before=inner, after=typed)
    assert outer == f"Did you mean {typed}? {typed}"
    assert translate(outer, "ja") == f"「{typed}」のことですか。{typed}"
    assert translate(typed, "ja") == typed


@pytest.mark.parametrize("typed", ["{rows}", "{n} rows", "{"])
def test_a_text_without_values_may_begin_with_a_brace(typed):
    assert capital(N_(typed)) == small(N_(typed)) == typed


# ---- what other processes send
def sent(template: object, **places: object) -> str:
    """The message of a finding from a child that wrote another template into its frame."""
    finding = Report().add("GRAPH001", None, name="x", remedy=N_("{n} rows", n="5"))
    packed = json.loads(json.dumps(pack(finding)).replace('"{n} rows"', json.dumps(template)))
    packed[3]["remedy"]["places"] |= places
    return str(unpack(Diagnostic, packed).details["remedy"])


def test_messages_from_other_processes_are_filled():
    assert sent("{n} rows") == "5 rows" and sent("{n:,} rows", n=1_000) == "1,000 rows"
    long = sent("{n} rows", n="y" * 200_000)
    assert long.endswith("y… rows") and 50_000 < len(long) < 110_000
    assert sent("{n:,} rows", n="1000") == "{n:,} rows"  # a number of NumPy, say, comes as a text


@pytest.mark.parametrize(
    "template",
    [
        "{n:>999999999}",
        "{n:999999999}",
        "{n!r}",
        "{n.__class__}",
        "{n[0]}",
        "{m}",
        "{}",
        "{0}",
        "{n:{n}}",
        "{n",
        "{n:.999f}",
    ],
)
def test_a_template_that_is_none_of_ours_is_shown_as_it_is(template):
    assert sent(template) == template


def test_a_plural_keeps_its_forms_on_the_way_from_another_process() -> None:
    packed = json.loads(json.dumps(pack(Report().add("GRAPH001", None, name="x", remedy=plural("{n} a", "{n} b", 2)))))
    assert unpack(Diagnostic, packed).details["remedy"].forms == ("{n} a", "{n} b")
    for forms in (["{n:>999999999}", "{n} b"], ["{n} a"], "{n} a", [1, 2], [None, "{m}"]):
        packed[3]["remedy"]["forms"] = forms
        packed[3]["remedy"]["places"]["n"] = 1
        assert len(unpack(Diagnostic, packed).details["remedy"]) < 10


def test_messages_from_other_processes_do_not_grow_without_end():
    template = "{n}" * 1_000
    assert sent(template, n="y" * 1_000) == ("y" * 100 + "…") * 1_000
    packed: object = "x" * 1_000
    for _ in range(60):
        packed = {"said": "{n}{n}", "places": {"n": packed}, "context": ""}
    finding = pack(Report().add("GRAPH001", None, name="x", remedy="y"))
    finding[3]["remedy"] = packed
    assert len(unpack(Diagnostic, finding).remedy) < 1_000_000
    assert sent("{n}", msgctxt="x") == "{n}"
