"""The texts of pages and scripts: all come through the catalogue. A pseudo-language shows it: each text in brackets, with accents."""

from __future__ import annotations

import dataclasses
import json
import re
import sys
from collections.abc import Collection, Iterable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from typing import Any

import pytest
import recorded
from babel.messages.catalog import Catalog
from babel.messages.jslexer import tokenize
from babel.messages.pofile import read_po, write_po
from browser import GOOD, HEADER, TOKEN, book, get, let_in
from jinja2 import Environment, nodes, pass_context
from markupsafe import Markup
from playwright.sync_api import Browser, Page, expect
from recorded import write_run
from translations import SCRIPTS, TEMPLATES, extract_pages

import rrp_sheets
from rrp_sheets import page_texts, texts
from rrp_sheets.compare import as_html
from rrp_sheets.page_texts import script_texts
from rrp_sheets.texts import LOCALE, N_, LazyMessage, translate
from rrp_sheets.web import models
from rrp_sheets.web.app import create_app
from rrp_sheets.web.requests import Lan, Password
from rrp_sheets.web.views import help as help_view

ROOT = Path(rrp_sheets.__file__).parents[1]
sys.path.insert(0, str(ROOT))
from hatch_build import CATALOGUES, PAGES, compile_texts  # noqa: E402

PSEUDO = "ja"  # the code of the pseudo-language, as only languages that are listed are found
READ = {"title", "aria-label", "placeholder", "alt", "data-head", "data-looks", "label"}
"""Attributes that people read."""
NAMES = {
    "RRP Sheets", "Devices", "SHA-256", "SVG", "Esc", "Esc Esc", ".pdf", ".svg", ".csv", "trace.csv", "plots.pdf", "plots.svg",
    "rrp-sheets replay … -o differences.xlsx",
}  # fmt: skip
"""Names and code in templates, which are the same in all languages."""
CODE = {"ended is-"}  # classes
FROM, TO = "\ue000", "\ue001"  # around data in a page


def accented(text: str) -> str:
    """A text as the pseudo-language has it, with its places."""
    parts = re.split(r"(\{[^{}]*\})", text)
    return "⟦" + "".join(p if p.startswith("{") else p.translate(str.maketrans("aeiou", "áéíóú")) for p in parts) + "⟧"


@pytest.fixture(scope="module")
def pseudo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of the compiled catalogues of the pseudo-language."""
    root = tmp_path_factory.mktemp("pseudo")
    with (LOCALE / "ja" / "LC_MESSAGES" / "messages.po").open("rb") as file:
        known = {CATALOGUES: read_po(file), PAGES: extract_pages()}
    for pattern, found in known.items():
        catalogue = Catalog(PSEUDO)
        for message in found:
            if message.pluralizable:
                catalogue.add(message.id, (accented(message.id[1]),), message.locations)
            elif message.id:
                catalogue.add(message.id, accented(message.id), message.locations, context=message.context)
        path = root / pattern.replace("*", PSEUDO)
        path.parent.mkdir(parents=True, exist_ok=True)
        with path.open("wb") as out:
            write_po(out, catalogue, include_lineno=False)
    compile_texts(root)
    return root / "rrp_sheets" / "locale"


@pytest.fixture
def in_pseudo(pseudo: Path) -> Iterator[None]:
    """Pages are in the pseudo-language for browsers that prefer it."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(texts, "LOCALE", pseudo)
        patch.setattr(page_texts, "LOCALE", pseudo)
        texts._catalogue.cache_clear()
        yield
    texts._catalogue.cache_clear()


class Texts(HTMLParser):
    """Collects what people read of a page, apart from code and what is in the pseudo-language."""

    def __init__(self) -> None:
        super().__init__(convert_charrefs=True)
        self.found: list[str] = []
        self.depth = 0
        self.code = 0

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.code += tag in ("script", "style", "code", "kbd")
        for name, value in attrs:
            if name in READ:
                outside, _ = self.outside(value or "", 0)
                self.take(outside)

    def handle_endtag(self, tag: str) -> None:
        self.code -= tag in ("script", "style", "code", "kbd")

    def handle_data(self, data: str) -> None:
        outside, self.depth = self.outside(data, self.depth)
        if not self.code:
            self.take(outside)

    def take(self, text: str) -> None:
        if any(letter.isalpha() for letter in text) and text.strip(" –") not in NAMES:
            self.found.append(text.strip())

    @staticmethod
    def outside(text: str, depth: int) -> tuple[str, int]:
        """The letters that stand in no bracket, and in how many brackets the end of the text is."""
        left = ""
        for letter in text:
            depth += (letter == "⟦") - (letter == "⟧")
            left += letter if depth == 0 and letter != "⟧" else ""
        return left, depth


def literal(html: str) -> list[str]:
    """Return the visible texts of a page that are neither in the pseudo-language nor data."""
    reader = Texts()
    reader.feed(re.sub(f"{FROM}[^{TO}]*{TO}", "", html))
    reader.close()
    return reader.found


# ---- templates
def texts_of(template: str) -> list[str]:
    """Return the visible texts in the source of a template, of all its branches, without the values of expressions."""
    return literal("".join(text for _, kind, text in Environment().lex(template) if kind == "data"))


def constants(node: nodes.Node) -> Iterator[str]:
    """The texts in expressions of a template that do not go through the catalogue."""
    inner: Iterable[nodes.Node] = node.iter_child_nodes()
    if isinstance(node, nodes.Call) and isinstance(node.node, nodes.Name):
        first = {"_": 1, "pgettext": 2, "ngettext": 2, "url_for": 99}.get(node.node.name, 0)
        inner = [*node.args[first:], *([] if first == 99 else node.kwargs)]
    if isinstance(node, nodes.Const) and isinstance(node.value, str) and re.search(r"\w \w|^[A-Z][a-z]", node.value):
        yield node.value
    for child in inner:
        yield from constants(child)


@pytest.mark.parametrize("path", [p for pattern in TEMPLATES for p in sorted(ROOT.glob(pattern))], ids=lambda p: p.name)
def test_every_text_of_a_template_goes_through_the_catalogue(path: Path) -> None:
    template = path.read_text(encoding="utf-8")
    attributes = re.compile(r'^(?:\s*(?:class|data-[\w-]+)="[^"]*")+$')  # of the block `body_attributes`
    assert [text for text in texts_of(template) if not all(attributes.match(t) for t in text.split("\n") if t)] == []
    assert set(constants(Environment().parse(template))) <= NAMES | CODE


def test_a_text_outside_the_catalogue_is_found() -> None:
    assert texts_of('<p title="{{ x }}">Hello <b>{{ name }}</b></p><p title="Yes">{{ _("No") }}</p>') == [
        "Hello",
        "Yes",
    ]
    assert list(constants(Environment().parse('{{ _("Yes", n=f("Well then")) }}{{ "Not so" if x }}'))) == [
        "Well then",
        "Not so",
    ]


# ---- scripts
_TEXT = re.compile(r"[^\W\d_]{2,}[,;:]? [^\W\d_]{2,}|^[A-Z][a-z]+ |^[A-Z][a-z]+(?: ?…|\.|:)$|^[A-Z][a-z]{2,}$")
_CODE = re.compile(
    r"\n|^\(|[\[#>=]|:\w|\w \.\w|::|^\.|(?:is|only|run|line|cell)-[a-z]|^button |^t(?:body|r|h|d) |^svg "
)
"""Shaders, media queries, selectors, classes."""
_NO_TEXTS = {"className", "class", "font", "told", "help", "section"}
"""Properties that no text is for; the last three make the help on keys, which is a topic of `help/`."""
_WORDS = {
    "api.js": {"Somebody"}, "commands.js": {"Space", "Character", "Del"}, "shelf.js": {"Files"},
    "pending.js": {"Dead", "Process", "Shift", "Control", "Alt", "Meta"},
    "session.js": {"looks away", "looks back", "set to", "Light", "Noise"}, "robot.js": {"Head"},
}  # fmt: skip
"""Words of some scripts: a name in requests that is shown translated, names of keys, a type of the browser's, words of a Scene sheet,
a zone of the robot."""
_LISTS = {
    "input, button, select",
    "•, button, summary, a",
    "figcaption span",
    "busy now",
    "quiet nothing",
    "bubble past",
    "no model: •",
}
"""Selectors and classes with nothing that shows it, and an error that only the console tells."""


def is_key(values: list[str], at: int) -> bool:
    """Return whether a literal is the name of a key: compared with `key`, alone or in a list, or in the `keys` of a command."""
    if values[at - 1] == "=" and values[at - 2] in ("==", "!="):  # the tokens of === and !==
        return values[at - 3].split(".")[-1] == "key"
    first = next((n for n in range(at, 1, -1) if values[n] == "["), 0)
    last = next((n for n in range(at, len(values)) if values[n] == "]"), at)
    if not first or not all(value == "," or value[0] in "\"'" for value in values[first + 1 : last]):
        return False
    asked = values[last + 1 : last + 4] == [".", "includes", "("] and values[last + 4].split(".")[-1] == "key"
    return asked or values[first - 2 : first] == ["keys", ":"]


def unmarked(source: str, words: Collection[str] = ()) -> list[str]:
    """Literals of a script that look like a text and do not go through the catalogue, without those `words` and keys."""
    tokens = [token for token in tokenize(source, jsx=False) if not token.type.endswith("comment")]
    marked = {
        place
        for at, token in enumerate(tokens[:-1])
        if token.type == "name" and tokens[at + 1].value == "("
        for place in {"t": [at + 2], "tn": [at + 2, at + 4]}.get(token.value, [])
    }
    values = [token.value for token in tokens]
    found = []
    for at, token in enumerate(tokens):
        if token.type not in ("string", "template_string") or at in marked:
            continue
        text = re.sub(r"\$\{.*\}", "•", token.value[1:-1], flags=re.DOTALL)
        is_property = at > 1 and tokens[at - 1].value in ("=", ":") and tokens[at - 2].value in _NO_TEXTS
        is_known = is_property or text in words or text in _LISTS or is_key(values, at)
        if _TEXT.search(text) and not _CODE.search(text) and not is_known:
            found.append(text)
    return found


def test_every_text_of_a_script_goes_through_the_catalogue() -> None:
    paths = [path for pattern in SCRIPTS for path in sorted(ROOT.glob(pattern))]
    found = {path.name: unmarked(path.read_text(encoding="utf-8"), _WORDS.get(path.name, ())) for path in paths}
    assert len(paths) > 40 and {name: left for name, left in found.items() if left} == {}


def test_a_text_of_a_script_outside_the_catalogue_is_found() -> None:
    source = 'say("Not so."); say(`Row ${n} is gone`); say(t("Well then")); make("p", { className: "very plain" });'
    assert unmarked(source) == ["Not so.", "Row • is gone"]


def test_names_of_keys_are_texts_but_where_keys_are_meant() -> None:
    keys = 'if (key === "Delete" || ["End", "Tab"].includes(event.key)) f({ at: "cell", keys: ["Escape Escape", "Home"] });'
    assert unmarked(keys) == []
    shown = 'button("Delete", go); const words = ["End", "Tab"]; f({ keys: ["Home"], label: "Enter" }); g(["Process"])'
    assert unmarked(shown) == ["Delete", "End", "Tab", "Enter", "Process"]
    assert unmarked('g("Files")', {"Files"}) == [] and unmarked('g("Files")') == ["Files"]


# ---- pages
def shown(page: Any, found: dict[int, Markup]) -> None:
    """Collect the markup in the data of a page: pictures and rows."""
    if isinstance(page, Markup):
        found[id(page)] = page  # kept, so that no other object gets its id
    elif dataclasses.is_dataclass(page):
        for field in dataclasses.fields(page):
            shown(getattr(page, field.name), found)
    elif isinstance(page, (tuple, list)):
        for one in page:
            shown(one, found)


@pytest.fixture
def marked(in_pseudo: None, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """Mark all data that a page shows, so that texts of templates can be told from it."""
    markup: dict[int, Markup] = {}

    @pass_context
    def finalize(context: Any, value: object) -> object:
        if isinstance(value, LazyMessage):
            return translate(value, PSEUDO)
        if isinstance(value, Markup) and id(value) not in markup:  # of a macro, or of a text
            return value
        return Markup(FROM + "{}" + TO).format(value) if isinstance(value, str) else value

    def rendered(template: str, page: Any) -> str:
        shown(page, markup)
        return render_template(template, page=page)

    render_template = models.render_template
    for module in (models, help_view):
        monkeypatch.setattr(module, "render_template", rendered)
    install = page_texts.install

    def install_marking(environment: Environment, language: Any) -> None:
        install(environment, language)
        environment.finalize = finalize

    monkeypatch.setattr(page_texts, "install", install_marking)
    as_html._templates.cache_clear()
    yield
    as_html._templates.cache_clear()  # else other tests would get the marks


def asked(client: Any, address: str) -> str:
    return get(client, address, Accept_Language="ja", Sec_Fetch_Dest="document").text


def test_pages_have_no_text_outside_the_catalogue(marked: None, tmp_path: Path) -> None:
    client = let_in(create_app(tmp_path, TOKEN))
    pages = {"empty shelf": asked(client, "/")}
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    (tmp_path / "wrong.md").write_text("## Tracking\n" + HEADER + "| Nothing | map | x | Y | | |\n", encoding="utf-8")
    (tmp_path / "unreadable.md").write_bytes(b"\xff\xfe\x00")
    for name in ("good.md", "wrong.md"):
        pages |= {f"{name}{part}": asked(client, book(name) + part) for part in ("", "/run", "/versions", "/print")}
    for run in ("one", "two"):
        write_run(tmp_path, run, recorded.HEADER, recorded.EVENT, recorded.END)
    of_runs = (
        "/runs/one",
        "/runs/one/lookback",
        "/runs/one/replay",
        "/runs/pair?first=one&second=two",
        "/runs/delete?run=one",
    )
    for address in ("/", "/runs", *of_runs, "/compare", "/nothing"):
        pages[address] = asked(client, address)
    assert {name: literal(html) for name, html in pages.items() if literal(html)} == {}
    assert all(f'lang="{FROM}ja{TO}"' in html for html in pages.values())


def test_login_and_comparison_have_no_text_outside_the_catalogue(marked: None, tmp_path: Path) -> None:
    app = create_app(tmp_path, TOKEN, Lan(Password("green otter lamp"), ("127.0.0.1",)))
    html = app.test_client().get("/login", base_url="http://127.0.0.1:8000", headers={"Accept-Language": "ja"}).text
    assert literal(html) == [] and html.count("⟦") > 5
    part = as_html.render("comparison.html", language=PSEUDO, same=True, verdict="", cautions=[], versions=[], later="/x", drawn=None,
                  sections=[], signs=[], footed=True)  # fmt: skip
    assert literal(part) == [] and part.count("⟦") > 3


def test_pages_are_english_by_default(tmp_path: Path) -> None:
    html = get(let_in(create_app(tmp_path, TOKEN)), "/", Sec_Fetch_Dest="document").text
    assert '<html lang="en">' in html and "New workbook" in html and 'id="texts"' not in html


@pytest.mark.parametrize(
    ("accepted", "language"),
    [
        ("ja", PSEUDO),
        ("de, ja;q=0.5, en;q=0.4", PSEUDO),
        ("en, ja", "en"),
        ("fr", "en"),
        ("", "en"),
        ("ja-JP", PSEUDO),
        ("\udcff", "en"),
    ],
)
def test_the_language_is_the_browsers_choice(in_pseudo: None, tmp_path: Path, accepted: str, language: str) -> None:
    html = get(
        let_in(create_app(tmp_path, TOKEN)), "/", Accept_Language=accepted.encode("utf-8", "replace").decode()
    ).text
    assert f'<html lang="{language}">' in html and ('id="texts"' in html) == (language != "en")


def test_values_of_texts_are_escaped_and_messages_in_them_translated(in_pseudo: None) -> None:
    environment = Environment(autoescape=True)
    page_texts.install(environment, lambda _: PSEUDO)
    template = environment.from_string(
        '{{ _("Open {book}", book=name) }} {{ ngettext("{n:,} error", "{n:,} errors", 2000) }} {{ said }}'
    )
    said = template.render(name="<b>{0}", said=N_("a number"))
    assert said == "⟦Opén &lt;b&gt;{0}⟧ ⟦2,000 érrórs⟧ ⟦á númbér⟧"


def test_scripts_get_their_texts_by_category_of_plural(tmp_path: Path) -> None:
    catalogue = Catalog("pl")
    catalogue.add(("{n} row", "{n} rows"), ("{n} wiersz", "{n} wiersze", "{n} wierszy"), [("a.js", 1)])
    catalogue.add("Close", "Zamknij", [("a.js", 1), ("b.html", 1)])
    catalogue.add("Only a page", "Tylko strona", [("b.html", 1)])
    catalogue.add("Not translated", "", [("a.js", 1)])
    path = tmp_path / PAGES.replace("*", "pl")
    path.parent.mkdir(parents=True)
    with path.open("wb") as file:
        write_po(file, catalogue)
    compile_texts(tmp_path)
    rows = {"one": "{n} wiersz", "few": "{n} wiersze", "many": "{n} wierszy"}
    assert json.loads(path.with_name("scripts.json").read_text(encoding="utf-8")) == {
        "{n} row": rows,
        "Close": "Zamknij",
    }


def test_a_language_without_texts_of_scripts_has_none() -> None:
    assert script_texts("en") == {} == script_texts("../../ja")


# ---- in a browser
BOOKS = {
    "a.xlsx": {
        "T": [["Input streams", "Connector", "Formula", "Output stream", "On", "Notes"], ["Red ball", "map", "x", "X"]]
    }
}


def test_scripts_say_their_texts_in_the_language_of_the_page(in_pseudo: None, browser: Browser, url: str) -> None:
    from chromium import let_in as let_browser_in

    context = browser.new_context(base_url=url, locale="ja")
    let_browser_in(context, url)
    page: Page = context.new_page()
    problems: list[str] = []
    page.on("pageerror", lambda error: problems.append(str(error)))
    page.goto("/book/a.xlsx")
    expect(page.locator("#run-phase")).to_have_text("⟦Nó rún⟧")
    page.click("[data-do=rows]")
    expect(page.get_by_role("menuitem").first).to_contain_text("⟦Cút⟧")
    texts = page.evaluate(  # read once: what the functions of a script return
        """async () => {
            const { t, tn, listed } = await import(document.querySelector("script[src*='grid/main.js']").src.replace("grid/main.js", "texts.js"));
            return [t("Found in {cell}.", { cell: "{n}" }), tn("{n} row is gone", "{n} rows", { n: 1 }), listed(["a", "b"]),
                    tn("A row inserted.", "{n} rows inserted.", { n: 1 }), tn("A row inserted.", "{n} rows inserted.", { n: 2 })];
        }"""
    )
    assert texts == ["⟦Fóúnd ín {n}.⟧", "1 row is gone", "a、b", "⟦1 róws ínsértéd.⟧", "⟦2 róws ínsértéd.⟧"]
    page.goto("/book/a.xlsx/run")
    expect(page.locator("#plots .quiet").first).to_have_text(
        accented("Streams with numbers are plotted here during a run.")
    )
    assert problems == []
    context.close()
