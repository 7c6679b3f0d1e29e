"""The page that is printed, and the PDF that it gives: both say the same, in both languages, and compared."""

from __future__ import annotations

import html
import re
import shutil
from pathlib import Path
from typing import Any

import pytest
from browser import GOOD, HEADER, HOME, book, get, visit
from chromium import becomes, eventually, let_in, violations
from processes import killed

from rrp_sheets import api
from rrp_sheets.resources import bundled
from rrp_sheets.services.printing import gather
from rrp_sheets.web.protocol_printer import ProtocolPrinter, Wanted

LETTER = b"/MediaBox[0 0 612 792]"
HOSTILE = "<script>alert(1)</script>\"'"
LONG = "## Tracking\n" + HEADER + "| Red ball | map | redBall.distance | Distance 1 | | |\n" + "".join(
    f"| Distance {n - 1} | map | distance{n - 1} * 1.01 | Distance {n} | {'FALSE' if n == 30 else ''} | |\n"
    for n in range(2, 60)
) + "| Distance 59 | subscribe | | Head tracker | | |\n"  # fmt: skip
GREETING = f"""## あいさつ
{HEADER}| 顔 | filter | value.new | 新しい人 | | 初めて |
| 新しい人 | subscribe | | こんにちは | | |

## Devices
| Stream | Device | Text |
|---|---|---|
| 顔 | Face | |
| こんにちは | Say parameter | こんにちは。 |

## Protocol
| Field | Value |
|---|---|
| Title | あいさつの練習 |
| Version | 2 |
| Language | 日本語 |
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    made = tmp_path_factory.mktemp("books")
    shutil.copy(bundled("workbooks", "complex-tracking.xlsx"), made)
    (made / "long.md").write_text(LONG, encoding="utf-8")
    (made / "挨拶.md").write_text(GREETING, encoding="utf-8")
    wrong = "| Red ball | mapp | redBall.x | | | |\n| | subscribe | | Say | | |\n"
    (made / "wrong.md").write_text(f"## Tracking\n{HEADER}{wrong}", encoding="utf-8")
    rows = f"| Red ball | map | redBall.x + '{HOSTILE}' | {HOSTILE} | | {HOSTILE} |\n| {HOSTILE} | subscribe | | Say | | |\n"
    protocol = f"\n## Protocol\n| Field | Value |\n|---|---|\n| Title | {HOSTILE} |\n| {HOSTILE} | {HOSTILE} |\n"
    (made / "hostile.md").write_text(f"## A {HOSTILE}\n{HEADER}{rows}{protocol}", encoding="utf-8")
    return made


@pytest.fixture(scope="module")
def client(folder: Path) -> Any:
    return visit(folder)


def protocol(client: Any, name: str, **choice: str) -> str:
    asked = "&".join(f"{k}={v}" for k, v in choice.items())
    answer = get(client, f"{book(name)}/print/protocol?{asked}")
    assert answer.status_code == 200
    return str(answer.text)


# ---- what it says ----


@pytest.mark.slow
def test_the_page_says_everything_that_the_pdf_says(client: Any, folder: Path) -> None:
    text = protocol(client, "complex-tracking.xlsx")
    pack = gather(folder / "complex-tracking.xlsx").pack
    plain = re.sub(r"\s+", " ", re.sub(r"<[^>]+>", "", text))
    told = [pack.title, pack.digest, pack.summary, pack.hand_note, *(g.text for g in pack.glance), *pack.always]
    told += [s.notices for s in pack.sensed] + [k.text for k in pack.kept] + [a.does for a in pack.acts]
    told += [s.how for s in pack.stops] + [f.text for f in pack.findings] + [t.counted for t in pack.tests]
    told += [r.formula for b in pack.behaviours for r in b.rows] + [c for s in pack.sheets for r in s.rows for c in r]
    told += [k.text for k in pack.consent] + list(pack.signatures)
    missing = [t for t in told if re.sub(r"\s+", " ", t) not in html.unescape(plain)]
    assert missing == [] and len(told) > 50
    assert all(name in text for b in pack.behaviours for name in (f'data-row="{r.row}"' for r in b.rows))
    assert not re.search(r"<style|\sstyle=|\son\w+=|javascript:", text)


def test_the_page_asks_for_the_protocol_with_what_is_chosen(client: Any) -> None:
    text = get(client, f"{book('complex-tracking.xlsx')}/print?language=ja&paper=letter&against=book/long.md").text
    assert "/print/protocol?language=ja&amp;against=book/long.md&amp;paper=letter" in text
    assert '<option value="ja" selected>' in text and '<option value="book/long.md" selected>long.md' in text
    assert 'value="book/complex-tracking.xlsx"' not in text  # it is not compared with itself
    text = get(client, f"{book('long.md')}/print?language=xx&paper=a0").text
    assert "/print/protocol?language=" in text and "/print/protocol?language=xx" not in text


def test_its_language_is_the_protocols_or_the_chosen_one(client: Any) -> None:
    text = protocol(client, "挨拶.md")
    assert '<div class="protocol" lang="ja">' in text and "倫理審査用プロトコル" in text
    assert "「新しい人」が届くたびに、『こんにちは。』と話します。" in text and ">センサー<" in text
    english = protocol(client, "挨拶.md", language="en")
    assert 'lang="en"' in english and "When “新しい人” arrives, say “こんにちは。”" in english
    assert "as the Protocol says: 日本語" in get(client, f"{book('挨拶.md')}/print").text


def test_page_shows_the_sheet_for_participants(client: Any) -> None:
    text = protocol(client, "complex-tracking.xlsx", reader="participants")
    assert "for-participants" in text and "Meet NAO" in text and '<svg xmlns="http' in text and "SHA-256" not in text
    assert "NAOに会おう" in protocol(client, "complex-tracking.xlsx", reader="participants", language="ja")
    assert "DRAFT" in protocol(client, "wrong.md", reader="participants")
    hostile = protocol(client, "hostile.md", reader="participants")
    assert "<script>alert" not in hostile and "The page lacks the field Contact" in hostile
    page = get(client, f"{book('long.md')}/print?reader=participants").text
    assert '<option value="participants" selected>participants (one page)' in page
    assert '<option value="board" selected>' in get(client, f"{book('long.md')}/print?reader=everybody").text


def test_pdf_for_participants_has_a_name_of_its_own(client: Any) -> None:
    choice = "reader=participants&paper=letter"
    ready = get(client, f"{book('long.md')}/print/ready?{choice}")
    assert any("Contact" in note for note in ready.json["notes"])
    answer = get(client, f"{book('long.md')}/print/protocol.pdf?{choice}")
    assert LETTER in answer.data and "long-participants.pdf" in answer.headers["Content-Disposition"]


def test_a_workbook_with_mistakes_is_a_draft(client: Any) -> None:
    text = protocol(client, "wrong.md")
    assert "Did you mean map?" in text and ">mapp</td>" in text and "DRAFT" in text
    assert "Download the PDF (draft)" in get(client, f"{book('wrong.md')}/print").text
    assert get(client, "/book/nothing.md/print").status_code == 404
    assert get(client, "/book/nothing.md/print/protocol.pdf").status_code == 404


def test_hostile_texts_are_shown_as_text(client: Any) -> None:
    for address in ("print", "print/protocol"):
        answer = get(client, f"{book('hostile.md')}/{address}")
        assert answer.status_code == 200 and "<script>alert" not in answer.text
        assert "&lt;script&gt;" in answer.text


def test_the_foot_of_every_sheet_has_file_and_hash(client: Any, folder: Path, tmp_path: Path) -> None:
    answer = get(client, f"{book('complex-tracking.xlsx')}/paper.css")
    digest = api.read(folder / "complex-tracking.xlsx").digest
    assert answer.mimetype == "text/css"
    assert f"SHA-256 {digest[:4]} {digest[4:8]} " in answer.text and 'counter(page) " / " counter(pages)' in answer.text
    name = 'a"; } * { color: red } \\ \n.md'
    (tmp_path / name).write_text(GOOD, encoding="utf-8")
    style = get(visit(tmp_path), f"{book(name)}/paper.css").text
    assert style.count("{") == style.count("}") == 4 and "color: red" not in style


# ---- the approved version ----


def test_it_is_compared_with_the_version_that_was_approved(tmp_path: Path) -> None:
    path = tmp_path / "protocol.md"
    path.write_text(GREETING.replace("日本語", "English"), encoding="utf-8")
    client = visit(tmp_path)
    before = get(client, f"{book('protocol.md')}/print").text
    assert "save it as a version</a> with “approved”" in before
    sent = {"data": {"title": "Approved, 倫2026-041, 1 May 2026"}, "headers": {"X-RRP": "grid", "Origin": HOME}}
    assert client.post(f"{book('protocol.md')}/versions/keep", base_url=HOME, **sent).status_code == 200
    path.write_text(path.read_text(encoding="utf-8").replace("こんにちは。", "はじめまして。"), encoding="utf-8")
    after = get(client, f"{book('protocol.md')}/print").text
    assert '<option value="version/1/protocol.md" selected>Approved, 倫2026-041' in after
    text = protocol(client, "protocol.md", against="version/1/protocol.md")
    assert "1 difference changes the behaviour." in text and "こんにちは。" in text and 'id="changes"' in text
    assert 'id="changes"' not in protocol(client, "protocol.md", against="none")
    for gone in ("version/99/protocol.md", "run/nothing", "book/nothing.md", "../x", "x" * 2000):
        assert "is-error" in protocol(client, "protocol.md", against=gone)
        assert get(client, f"{book('protocol.md')}/print/ready?against={gone}").json["trouble"]


# ---- the PDF ----


@pytest.mark.slow
def test_the_pdf_is_made_in_a_process_of_its_own_and_kept(folder: Path) -> None:
    press = ProtocolPrinter()
    path = folder / "挨拶.md"
    wanted = Wanted(path, api.read(path).digest)
    first, notes = press.pdf(wanted, "a4")
    assert first.startswith(b"%PDF") and notes == []
    assert press.pdf(wanted, "a4")[0] is first and press.preview(wanted) is press.preview(wanted)
    letter, _ = press.pdf(wanted, "letter")
    assert LETTER in letter and LETTER not in first
    assert press.preview(wanted).pack == gather(path).pack
    assert press.pid is not None
    killed(press.pid)
    assert press.pdf(wanted, "a4")[0] is first
    assert press.pdf(Wanted(path, "another"), "a4")[0].startswith(b"%PDF")  # the process is started anew
    press.close()


# ---- in the browser, and on paper ----


@pytest.fixture(scope="module")
def page(browser: Any, url: str) -> Any:
    context = browser.new_context(viewport={"width": 1280, "height": 800}, color_scheme="dark")
    let_in(context, url)
    opened = context.new_page()
    opened.url_of = lambda name: f"{url}/book/{name}/print"
    return opened


def drawn(page: Any, name: str) -> None:
    page.goto(page.url_of(name))
    page.wait_for_selector("[data-print]:enabled")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "paper", "width"),  # px at 96 dpi, without the margins of 14 mm
    [("complex-tracking.xlsx", "A4", 794 - 106), ("挨拶.md", "Letter", 816 - 106)],
)
def test_nothing_is_cut_on_paper(page: Any, name: str, paper: str, width: int) -> None:
    drawn(page, name)
    assert violations(page) == []
    assert len(re.findall(rb"/Type\s*/Page\b", page.pdf(format=paper))) in (4, 5, 6, 7, 8, 9)
    page.emulate_media(media="print")
    page.set_viewport_size({"width": width, "height": 900})
    eventually(lambda: page.evaluate("document.documentElement.scrollWidth") <= width)
    eventually(lambda: not page.locator(".topbar").is_visible() and not page.locator(".print-choices").is_visible())
    eventually(page.locator(".drawn svg").first.is_visible)
    rights = "[...document.querySelectorAll('.drawn svg')].map((e) => e.getBoundingClientRect().right)"
    eventually(lambda: max(page.evaluate(rights)) <= width)
    becomes(lambda: page.evaluate("getComputedStyle(document.querySelector('.paper-table')).display"), "table")
    becomes(lambda: page.evaluate("getComputedStyle(document.body).color"), "rgb(0, 0, 0)")
    page.emulate_media(media="screen")
    page.set_viewport_size({"width": 1280, "height": 800})


@pytest.mark.slow
def test_sixty_rows_are_printed_whole(page: Any) -> None:
    drawn(page, "long.md")
    becomes(lambda: page.locator(".of-behaviour tbody tr").count(), 60)
    becomes(lambda: page.locator(".of-behaviour tbody tr.off").count(), 1)
    rows = "new Set([...document.querySelectorAll('.drawn [data-row]')].map((e) => e.dataset.row)).size"
    becomes(lambda: page.evaluate(rows), 60)
    page.emulate_media(media="print")
    high = "Math.max(...[...document.querySelectorAll('.drawn')].map((e) => e.getBoundingClientRect().height))"
    eventually(
        lambda: page.evaluate(high) < 263 * 96 / 25.4
    )  # mm of A4 between its margins: no picture is cut by the end of a sheet
    page.emulate_media(media="screen")


def test_the_buttons_print_and_give_the_pdf(page: Any, tmp_path: Path) -> None:
    drawn(page, "挨拶.md")
    page.evaluate("window.print = () => { window.printed = true }")
    page.get_by_role("button", name="Print this page").click()
    eventually(lambda: page.evaluate("window.printed") is True)
    page.get_by_label("Paper").select_option("letter")
    with page.expect_download() as download:
        page.get_by_role("button", name="Download the PDF").click()
    assert download.value.suggested_filename == "挨拶-protocol.pdf"
    download.value.save_as(tmp_path / "made.pdf")
    assert LETTER in (tmp_path / "made.pdf").read_bytes()
    becomes(lambda: page.locator("[data-said]").inner_text(), "The PDF is ready.")
    page.get_by_label("Language").select_option("en")
    page.wait_for_selector(".protocol[lang=en]")
    page.get_by_label("Compared with").select_option("book/complex-tracking.xlsx")
    page.wait_for_selector("#changes")


@pytest.mark.slow
def test_trouble_with_the_pdf_is_told(page: Any) -> None:
    drawn(page, "挨拶.md")
    page.evaluate("document.querySelector('[name=against] option').value = 'version/99/挨拶.md'")
    page.get_by_role("button", name="Download the PDF").click()
    page.wait_for_selector("[data-said].is-error")
    eventually(lambda: "no longer exists" in page.locator("[data-said]").inner_text())
