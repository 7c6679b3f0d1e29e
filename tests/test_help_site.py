"""The help as pages: whole in both languages, every link leads somewhere, and a folder of others' files is left alone."""

from __future__ import annotations

import json
import re
from collections import Counter
from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote

import pytest
from browser import get, post, visit
from click.testing import CliRunner

from rrp_sheets import api
from rrp_sheets.cli.help import help_command
from rrp_sheets.cli.main import group
from rrp_sheets.connectors import connectors
from rrp_sheets.diagnostics import CODES
from rrp_sheets.diagnostics.catalogue import load_page
from rrp_sheets.errors import SheetsError
from rrp_sheets.formulas.functions import library
from rrp_sheets.help import layout, publishing, site
from rrp_sheets.help.topics import TITLES, all_names
from rrp_sheets.model import japanese
from rrp_sheets.robots import load_robot
from rrp_sheets.texts import LANGUAGES, translate

FILES = sorted(path.stem for path in layout.FILES.glob("*.md"))
OTHERS = [language for language in LANGUAGES if language != "en"]
_COMMAND = re.compile(r"`([^`]+)`")


class Page(HTMLParser):
    """Ids and links of a page of the site."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.ids: list[str] = []
        self.links: list[str] = []
        self.images: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for name, value in attrs:
            if name == "id":
                self.ids.append(value or "")
            elif name in ("href", "src", "action"):
                self.links.append(value or "")


@pytest.fixture(scope="module")
def written(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("help") / "site"
    publishing.write_site(folder)
    return folder


# ---- both languages
def commands(text: str) -> Counter[str]:
    """The commands and names in a text, with English names of devices and without quotes."""
    own = re.compile("|".join(sorted(japanese.DEVICES, key=len, reverse=True)))
    found = _COMMAND.findall(text)
    return Counter(own.sub(lambda match: japanese.DEVICES[match[0]], one).replace('"', "") for one in found)


def form(name: str, language: str) -> list[tuple[object, ...]]:
    """The form of a topic's file, the same in every language: kinds of blocks, sizes of tables, examples."""
    blocks = layout.from_markdown((layout.FILES / language / f"{name}.md").read_text(encoding="utf-8"))
    return [
        (b.kind, len(b.rows), {len(row) for row in b.rows}, b.source, b.rows if b.kind == "lines" else ())
        for b in blocks
    ]


@pytest.mark.parametrize("language", OTHERS)
@pytest.mark.parametrize("name", FILES)
def test_a_topic_is_the_same_in_every_language(name: str, language: str) -> None:
    texts = [(layout.FILES / place / f"{name}.md").read_text(encoding="utf-8") for place in ("", language)]
    assert form(name, language) == form(name, "")
    assert commands(texts[1]) == commands(texts[0])
    assert Counter(re.findall(r"\{\w+\}", texts[1])) == Counter(re.findall(r"\{\w+\}", texts[0]))


@pytest.mark.parametrize("language", OTHERS)
def test_no_topic_is_of_one_language_only(language: str) -> None:
    assert sorted(path.stem for path in (layout.FILES / language).glob("*.md")) == FILES


def test_a_topic_without_a_translation_is_english(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    (tmp_path / "only.md").write_text("# One\n\nA text.\n", encoding="utf-8")
    monkeypatch.setattr(layout, "FILES", tmp_path)
    assert [block.head for block in layout.from_file("only", "ja")] == ["One", "A text."]


@pytest.mark.parametrize("language", OTHERS)
def test_texts_of_codes_have_the_same_commands_in_every_language(language: str) -> None:
    wrong = {}
    for code in CODES:
        page = load_page(code)
        for text in (page.text(part) for part in ("means", "why", "mend", "untabled") if getattr(page, part)):
            if commands(text) != commands(translate(text, language)):
                wrong[text.context] = _COMMAND.findall(text)
    assert wrong == {}


@pytest.mark.slow
def test_headings_have_the_same_anchors_in_every_language() -> None:
    for file in site.files():
        assert len({tuple(s.anchor for s in site.page(file, language).sections) for language in LANGUAGES}) == 1, file


# ---- pages
def test_every_name_has_its_place() -> None:
    anchors = {file: {s.anchor for s in site.page(file, "en").sections} for file in site.files()}
    others = {o for file in site.files() for s in site.page(file, "en").sections for o in s.others}
    for name in (
        *connectors().names(),
        *library().names(),
        *(n.name for n in all_names()),
        *TITLES,
        "Say done",
        *CODES,
    ):
        file, _, anchor = site.place_of(name).partition("#")
        assert file in anchors and (not anchor or anchor in anchors[file] | others), name
    for code in CODES:
        assert site.place_of(code) == f"{code}.html"


@pytest.mark.slow
def test_the_list_of_codes_has_an_anchor_for_each(written: Path) -> None:
    assert set(CODES) <= set(Page((written / "en" / "codes.html").read_text(encoding="utf-8")).ids)


@pytest.mark.slow
def test_every_link_of_the_written_pages_leads_to_what_is_there(written: Path) -> None:
    pages = {path: Page(path.read_text(encoding="utf-8")) for path in written.rglob("*.html")}
    assert len(pages) == 1 + len(LANGUAGES) * len(site.files())
    wrong = []
    for path, page in pages.items():
        assert max(Counter(page.ids).values()) == 1, (path, Counter(page.ids).most_common(3))
        for link in page.links:
            file, _, anchor = unquote(link).partition("#")
            target = (path.parent / file).resolve() if file else path
            missing = anchor and target in pages and anchor not in pages[target].ids
            if (
                missing
                or ":" in file
                or file.startswith("/")
                or not target.is_file()
                or not target.is_relative_to(written)
            ):
                wrong.append((path.name, link))
    assert wrong == []


@pytest.mark.slow
def test_the_hits_of_the_search_are_pages_and_anchors_that_there_are(written: Path) -> None:
    for language in LANGUAGES:
        script = (written / language / "search-index.js").read_text(encoding="utf-8")
        sections = json.loads(script.partition("helpSections = ")[2].rstrip(";\n"))
        assert len(sections) > 300 and all(section["text"] or section["part"] for section in sections)
        for page in {section["page"] for section in sections}:
            ids = Page((written / language / page).read_text(encoding="utf-8")).ids
            assert {s["anchor"] for s in sections if s["page"] == page} <= {*ids, ""}


@pytest.mark.slow
def test_written_pages_take_nothing_from_elsewhere_and_need_no_script(written: Path) -> None:
    for path in written.rglob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"https?:(?!//www\.w3\.org/2000/svg)|style=|onclick", text), path
        assert ("<script" in text) == (path.name == "search.html"), path
        assert "<code>rrp-sheets help" not in text, path  # a link instead


@pytest.mark.slow
@pytest.mark.parametrize("language", LANGUAGES)
def test_examples_to_download_are_workbooks_in_order(written: Path, language: str) -> None:
    books = sorted((written / f"examples-{language}").iterdir())
    assert len(books) > 30
    assert {b.name: e for b in books if (e := [d.code for d in api.check(b).report.errors])} == {}


@pytest.mark.slow
def test_every_device_and_topic_has_a_diagram_of_its_example(written: Path) -> None:
    for language in LANGUAGES:
        devices = (written / language / "devices.html").read_text(encoding="utf-8")
        assert devices.count('<div class="diagram"') >= len(load_robot().devices)
        for topic in ("index", "tests", "helpers", "priority", "total", "protocol"):
            assert '<div class="diagram"' in (written / language / f"{topic}.html").read_text(encoding="utf-8")


# ---- the command
def write(*arguments: str) -> str:
    done = CliRunner().invoke(group, ["help", "--html", *arguments])
    assert done.exit_code == 0, done.exception
    return done.output


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """Only some of the pages are written."""
    for module in (site, publishing):
        monkeypatch.setattr(module, "files", lambda: ("index.html", "formulas.html", "search.html"))


def test_the_pages_are_written_anew_and_old_ones_go(few: None, tmp_path: Path) -> None:
    folder = tmp_path / "あ help"
    assert write(str(folder)) == f"7 pages are written. Open {folder}/en/index.html\n"
    (folder / "en" / "formulas.html").write_text("of before", encoding="utf-8")
    listed = json.loads((folder / "rrp-sheets-help.json").read_text(encoding="utf-8"))["files"]
    (folder / "en" / "gone.html").write_text("old", encoding="utf-8")
    (folder / "rrp-sheets-help.json").write_text(json.dumps({"files": [*listed, "en/gone.html"]}), encoding="utf-8")
    (folder / "mine.txt").write_text("mine", encoding="utf-8")
    assert "7ページを書き出しました" in write(str(folder), "--language", "ja")
    assert "of before" not in (folder / "en" / "formulas.html").read_text(encoding="utf-8")
    assert not (folder / "en" / "gone.html").exists()
    assert (folder / "mine.txt").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize(
    "listed",
    [
        None,
        "no JSON",
        "[]",
        "{}",
        '{"files": 5}',
        '{"files": [5]}',
        '{"files": ["../outside.txt"]}',
        '{"files": ["/etc/x.y"]}',
    ],
)
def test_a_folder_that_has_something_else_is_left_alone(few: None, tmp_path: Path, listed: str | None) -> None:
    (tmp_path / "outside.txt").write_text("mine", encoding="utf-8")
    folder = tmp_path / "folder"
    folder.mkdir()
    (folder / "mine.txt").write_text("mine", encoding="utf-8")
    if listed is not None:
        (folder / "rrp-sheets-help.json").write_text(listed, encoding="utf-8")
    with pytest.raises(SheetsError, match="is not empty"):
        publishing.write_site(folder)
    assert {path.name for path in folder.iterdir()} <= {"mine.txt", "rrp-sheets-help.json"}
    assert (tmp_path / "outside.txt").read_text(encoding="utf-8") == "mine"


def test_a_folder_that_cannot_be_made_is_told(few: None, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine", encoding="utf-8")
    for place in (tmp_path / "file", tmp_path / "file" / "below"):
        done = CliRunner().invoke(help_command, ["--html", str(place)])
        assert isinstance(done.exception, SheetsError) and done.exception.remedy


def test_html_takes_no_topic(tmp_path: Path) -> None:
    done = CliRunner().invoke(help_command, ["formulas", "--html", str(tmp_path / "x")])
    assert done.exit_code == 2 and "leave TOPIC out" in done.output and not (tmp_path / "x").exists()


def test_the_old_name_of_a_topic_leads_to_it() -> None:
    told = {
        CliRunner().invoke(help_command, [name]).output for name in ("records", "recordings", "recording", "record")
    }
    assert len(told) == 1 and told.pop().startswith("Recordings of runs")


# ---- the server
def test_pages_of_the_server_link_to_pages_and_files_that_it_has(tmp_path: Path) -> None:
    client = visit(tmp_path)
    for file in ("index.html", "devices.html", "FORM003.html", "search.html"):
        answer = get(client, f"/help/{file}")
        assert answer.status_code == 200
        for link in Page(answer.text).links:
            name, _, query = link.partition("#")[0].partition("?")
            if name and not name.startswith("/"):
                assert name in site.files() and (not query or query in ("lang=ja", "lang=en")), link
    assert get(client, "/help/nothing.html").status_code == 404 and get(client, "/help/FORM003").status_code == 404
    assert '<main class="docs-main" id="main" lang="en">' in get(client, "/help/index.html?lang=xx").text
    assert '<main class="docs-main" id="main" lang="ja">' in get(client, "/help/index.html?lang=ja").text


@pytest.mark.parametrize(
    ("asked", "address"),
    [("", "/help/index.html"), ("?topic=records", "/help/recordings.html"), ("?topic=Red+ball", "/help/devices.html#Red-ball"),
     ("?q=a+%26+b", "/help/search.html?q=a+%26+b"), ("?topic=<b>", "/help/index.html")],
)  # fmt: skip
def test_a_link_of_the_panel_leads_to_the_page(tmp_path: Path, asked: str, address: str) -> None:
    client = visit(tmp_path)
    for headers in ({"Sec_Fetch_Dest": "document"}, {"Accept": "text/html,*/*"}):
        answer = get(client, f"/help{asked}", **headers)
        assert answer.status_code == 302 and answer.headers["Location"].endswith(address)
    assert get(client, f"/help{asked}", Sec_Fetch_Dest="empty").status_code == 200


@pytest.mark.parametrize("words", ["Gesture done", "gesture DONE"])
def test_a_done_stream_is_found_and_linked(tmp_path: Path, words: str) -> None:
    client = visit(tmp_path)
    found = get(client, f"/help?q={words}", Sec_Fetch_Dest="empty").text
    assert "Results for" in found and "Gesture done (stream)" in found
    link = re.escape('href="devices.html#Say-done" data-help="Gesture done">Gesture done</a>')
    assert re.search(link, get(client, "/help/devices.html").text)


def test_an_example_becomes_a_workbook(tmp_path: Path) -> None:
    client = visit(tmp_path)

    def made(name: str, page: str = "devices.html", example: str = "Red-ball") -> tuple[int, str, str]:
        answer = post(client, "/help/open", page=page, example=example, name=name)
        return answer.status_code, answer.headers.get("HX-Redirect", ""), answer.text

    assert made("Red ball") == (200, "/book/Red%20ball.xlsx", "")
    assert made("Red ball")[1] == "/book/Red%20ball%20(2).xlsx"  # as it was proposed: a number makes it another one
    assert "There is already a file" in made("Red ball.xlsx")[2]
    for bad in ("", "../outside", "a/b", "CON", ".hidden", "x" * 101, "a\x00b", "\u202ea"):
        assert "cannot be the name of a file" in made(bad)[2], bad
    assert made("<b>")[2].count("&lt;b&gt;") == 1
    assert made("mine", "FORM007.html", "FORM007-wrong")[1]
    assert [d.code for d in api.check(tmp_path / "mine.xlsx").report] == ["FORM007"]
    assert made("scene", "scene.html", "Scene")[1] and api.check(tmp_path / "scene.xlsx").workbook.behaviours
    assert made("x", "nothing.html")[0] == made("x", "devices.html", "none")[0] == 404
    assert not (tmp_path / "x.xlsx").exists() and not (tmp_path.parent / "outside.xlsx").exists()
