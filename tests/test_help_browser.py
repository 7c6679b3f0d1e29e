"""The help pages in a browser: topics, search with hits in their context, examples, both languages, published pages."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from chromium import becomes, eventually, let_in, serving
from playwright.sync_api import expect
from test_help_topics import QUERIES

from rrp_sheets.help.publishing import write_site
from rrp_sheets.help.site import page as shown_page
from rrp_sheets.help.site import place_of


@pytest.fixture(scope="module")
def books(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("books")


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("published") / "help"
    write_site(folder)
    return folder


@pytest.fixture(scope="module")
def page(browser: Any, books: Path) -> Any:
    with serving(books) as url:
        context = browser.new_context(base_url=url, viewport={"width": 1280, "height": 900}, reduced_motion="reduce")
        let_in(context, url)
        found = context.new_page()
        found.problems = []
        found.on("pageerror", lambda error: found.problems.append(str(error)))
        found.on("console", lambda said: found.problems.append(said.text) if said.type == "error" else None)
        yield found
        assert found.problems == []
        context.close()


def test_topics_lead_to_pages_and_names_to_their_sections(page: Any) -> None:
    page.goto("/help")
    page.wait_for_url("**/help/index.html")
    topics = page.get_by_role("navigation", name="Topics of help")
    topics.get_by_role("link", name="Connectors").click()
    page.wait_for_url("**/connectors.html")
    expect(topics.locator("[aria-current=page]")).to_have_text("Connectors")
    page.get_by_role("main").get_by_role("link", name="sample", exact=True).first.click()
    page.wait_for_url("**/connectors.html#sample")
    expect(page.locator("#sample")).to_be_in_viewport()
    expect(page.locator("#sample")).to_contain_text("sample (connector)")
    expect(page.locator(".marble-picture").first).to_be_attached()
    page.get_by_role("link", name="Formulas →").click()
    page.wait_for_url("**/formulas.html")
    expect(page.get_by_role("columnheader")).to_have_text(["Spreadsheet", "Python", "Meaning"])


def test_on_a_narrow_screen_the_topics_unfold(page: Any) -> None:
    page.set_viewport_size({"width": 400, "height": 800})
    page.goto("/help/tests.html")
    topics = page.get_by_role("navigation", name="Topics of help")
    expect(topics).to_have_count(0)
    page.get_by_text("All topics").click()
    topics.get_by_role("link", name="Glossary").click()
    page.wait_for_url("**/glossary.html")
    becomes(lambda: page.evaluate("document.documentElement.scrollWidth"), 400)
    page.set_viewport_size({"width": 1280, "height": 900})


def search(page: Any, words: str) -> Any:
    """The hits of a search."""
    field = page.get_by_role("searchbox", name="Search the help")
    field.fill(words)
    return page.locator(".docs-hits li")


def check_search(page: Any) -> None:
    """The search of pages in English, those of the server and published ones."""
    hits = search(page, "bumper")
    page.keyboard.press("Enter")
    page.wait_for_url("**/search.html?q=bumper")
    expect(page.locator("#found")).to_contain_text("Results for “bumper”:")
    expect(hits.first.get_by_role("link")).to_have_text("Devices › Bumper (sensor)")
    expect(hits.filter(has_text="Touch").locator("p mark").first).to_have_text("bumper")
    search(page, "closes the seed chance")  # no text has all of these
    expect(page.locator("#found")).to_contain_text("No text has all of these words")
    search(page, "xyzzy <b>")
    expect(page.locator("#found")).to_have_text("No results for “xyzzy <b>”")
    search(page, "redBall.distance < 0.8")
    expect(hits.first).to_contain_text("distance")
    search(page, "CLAMP")
    expect(hits.first.get_by_role("link")).to_have_text("Functions › CLAMP(value; low; high)")
    hits.first.get_by_role("link").click()
    page.wait_for_url("**/functions.html#CLAMP")
    expect(page.locator("#CLAMP")).to_be_in_viewport()


def test_the_search_shows_hits_in_their_context(page: Any) -> None:
    page.goto("/help/index.html")
    check_search(page)


def section_of(name: str) -> str:
    """The address of the section on a name, which may be the section of another name of the same thing."""
    file, mark, anchor = place_of(name).partition("#")
    sections = shown_page(file, "en").sections if mark else ()
    found = next(
        (section for section in sections if section.named and anchor in (section.anchor, *section.others)), None
    )
    return f"{file}#{found.anchor}" if found else f"{file}{mark}{anchor}"


@pytest.mark.parametrize("every", [4, pytest.param(1, marks=pytest.mark.slow)])
def test_the_search_finds_plain_words(page: Any, every: int) -> None:
    for language, table in QUERIES.items():
        page.goto(f"/help/search.html?lang={language}")
        field, link = page.get_by_role("searchbox").first, page.locator(".docs-hits li a")
        missed = []
        for query, pages in table[::every]:
            field.fill(query)
            hits = link.evaluate_all("links => links.slice(0, 3).map((a) => a.getAttribute('href'))")
            if not set(map(section_of, pages.split("|"))) & set(hits):
                missed.append((query, hits))
        assert not missed, str(missed)


def test_the_same_page_in_the_other_language(page: Any) -> None:
    page.goto("/help/recordings.html#Replay")
    page.get_by_role("link", name="日本語").click()
    page.wait_for_url("**/recordings.html?lang=ja")
    expect(page.locator("main")).to_have_attribute("lang", "ja")
    expect(page.locator(".docs-title")).to_have_text("実行の記録")
    page.get_by_role("link", name="English").click()
    expect(page.locator(".docs-title")).to_have_text("Recordings of runs")


def test_an_example_is_opened_as_a_workbook(page: Any, books: Path) -> None:
    page.goto("/help/devices.html#Red-ball")
    example = page.locator("#Red-ball-rows")
    expect(example.locator(".diagram svg")).to_be_attached()
    example.get_by_text("Open as a workbook").click()
    name = example.get_by_label("Name of the new workbook")
    expect(name).to_have_value("Red ball")
    name.fill("a/b")
    name.press("Enter")
    expect(example.get_by_role("alert")).to_contain_text("“a/b” cannot be the name of a file.")
    name.fill("ボール")
    example.get_by_role("button", name="Create", exact=True).click()
    page.wait_for_selector("body[data-ready]")
    expect(page.locator("[role=grid]")).to_contain_text("Red ball")
    eventually((books / "ボール.xlsx").is_file)


def test_the_panel_leads_to_the_pages(page: Any, books: Path) -> None:
    from rrp_sheets.workbook.files import make_workbook

    rows = [["Input streams", "Connector", "Formula", "Output stream"], ["Red ball", "subscribe", "", "Print"]]
    make_workbook({"T": rows}, books / "panel.xlsx")
    page.goto("/book/panel.xlsx")
    page.wait_for_selector("body[data-ready]")
    page.keyboard.press("F1")
    panel = page.locator("#help")
    panel.locator("[name=q]").fill("bumper")
    with page.context.expect_page() as opened:
        panel.get_by_role("link", name="Search all help texts for “bumper”").click()
    expect(opened.value.locator(".docs-hits li").first).to_contain_text("Bumper (sensor)")
    opened.value.close()


@pytest.mark.slow
def test_published_pages_work_from_a_disk(browser: Any, site: Path) -> None:
    context = browser.new_context(viewport={"width": 1280, "height": 900}, offline=True)
    page = context.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.on("console", lambda said: faults.append(said.text) if said.type == "error" else None)
    page.goto((site / "index.html").as_uri())
    page.get_by_role("link", name="English").click()
    page.wait_for_url("**/en/index.html")
    check_search(page)
    page.get_by_role("link", name="日本語").click()
    page.wait_for_url("**/ja/functions.html")
    field = page.get_by_role("searchbox", name="ヘルプを検索")
    field.fill("赤いボール")
    field.press("Enter")
    expect(page.locator("#found")).to_contain_text("「赤いボール」の検索結果")
    expect(page.locator(".docs-hits mark").first).to_have_text("赤いボール")
    field.fill("赤いボール 宇宙船")
    expect(page.locator("#found")).to_contain_text("一部を含む文")
    expect(page.locator(".docs-hits mark").first).to_be_attached()
    assert faults == []
    context.close()
