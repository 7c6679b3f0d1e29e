"""The tutorial, done as a newcomer does it: in the real grid, by the keyboard, lesson by lesson until all tests pass."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from chromium import GridPage, becomes, eventually, set_clock, some
from playwright.sync_api import TimeoutError, expect

from rrp_sheets import api
from rrp_sheets.help import tutorial
from rrp_sheets.resources import bundled
from rrp_sheets.texts import translate
from rrp_sheets.workbook import read
from rrp_sheets.workbook.files import read_sheets
from rrp_sheets.workbook.reading import to_rows

TUTORIAL = bundled("templates", "workbooks", "tutorial.xlsx")
LESSONS = ["Hello", "Near", "Name it", "Slip", "Wave", "Together", "Forget", "Silence", "Calm", "Cheer"]
TUTORIALS = {"tutorial": tutorial.LESSONS, "tutorial.ja": tutorial.japanese_lessons()}
DONE = [f"Lesson {n} {name}" for n, name in enumerate(LESSONS, 1)]


def source(name: str = "tutorial") -> str:
    return bundled("templates", "workbooks", "source", f"{name}.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("name", TUTORIALS)
def test_it_comes_as_its_source_says(tmp_path: Path, name: str) -> None:
    made = api.convert(bundled("templates", "workbooks", "source", f"{name}.md"), tmp_path / "tutorial.xlsx")
    there = bundled("templates", "workbooks", f"{name}.xlsx")
    assert made.read_bytes() == there.read_bytes(), "run `python templates/workbooks/make.py`"


@pytest.mark.parametrize("name", TUTORIALS)
def test_it_begins_without_problems_and_with_every_lesson_open(name: str) -> None:
    checked, report = api.test(bundled("templates", "workbooks", f"{name}.xlsx"))
    assert not list(checked.report)
    assert report is not None and [c.case.name for c in report.cases if not c.passed] == [
        b.test for b in TUTORIALS[name]
    ]


@pytest.mark.parametrize(
    ("name", "heading"), [("tutorial", "Lesson {n}: {title}"), ("tutorial.ja", "レッスン{n}：{title}")]
)
def test_its_headings_and_tests_are_those_of_the_lessons(name: str, heading: str) -> None:
    text, language = source(name), "ja" if name.endswith("ja") else "en"
    assert language == "ja" or [lesson.test for lesson in tutorial.LESSONS] == DONE
    tests = re.findall(r"^## ((?:Lesson|レッスン).*)$", text, re.MULTILINE)
    assert [lesson.test for lesson in TUTORIALS[name]] == tests
    titles = [translate(lesson.title, language) for lesson in TUTORIALS[name]]
    headings = [heading.format(n=number, title=title) for number, title in enumerate(titles, 1)]
    assert re.findall(r"^\| # ((?:Lesson|レッスン)[^|]*?) \|", text, re.MULTILINE) == headings


def test_the_japanese_one_has_the_rows_of_the_english_one_in_japanese() -> None:
    english, own = (read(bundled("templates", "workbooks", f"{name}.xlsx")).workbook for name in TUTORIALS)
    assert len(own.scene) == len(english.scene) and [t.rows[-1].time.text for t in own.tests] == [
        t.rows[-1].time.text for t in english.tests
    ]
    first, second = ([r.connector.text for b in one.behaviours for r in b.rows] for one in (english, own))
    assert second == [*first[:5], "map", *first[5:]]  # a row that gives the place of a touch in Japanese
    words = [cell for rows in to_rows(read_sheets(bundled("templates", "workbooks", "source", "tutorial.ja.md"))).values()
             for row in rows for cell in row]  # fmt: skip
    connectors = {"subscribe", "map", "filter", "changes", "forgetAfter"}
    assert {w for w in words if re.search(r"[a-z]{4}", w) and w.isascii()} - connectors <= {
        "hello robot", 'word="hello robot"', '"Wave"', "Wave", "Arms up", "value", "distance=2", "distance=0.3",
        "pressed=TRUE", 'zone="Head"; pressed=TRUE', 'zone="Left hand"; pressed=TRUE',
    }  # fmt: skip


def test_the_texts_of_the_steps_name_what_their_workbook_has() -> None:
    lessons = [tutorial.lesson_of(b[0].test) for b in TUTORIALS.values()]
    said = [translate(lesson.said(lesson.steps[0]), "ja") for lesson in lessons if lesson]
    assert "「Lesson 1」" in said[0] and "`Hello heard`" in said[0]
    assert "「レッスン1」" in said[1] and "`呼びかけ`" in said[1]


def test_each_lesson_has_few_steps_and_each_step_writes_something() -> None:
    for lesson in tutorial.LESSONS:
        assert 1 <= len(lesson.steps) <= tutorial.MOST_STEPS and lesson.about.count(".") <= 2
        assert all(step.cells for step in lesson.steps)


EMPTY = "|  |  |  |  |  |  |\n"
SOLVED = (
    (EMPTY, '|  | Hello heard | subscribe | "Hello!" | Say |  |\n'),
    ("redBall.distance < 5", "redBall.distance < 0.5"),
    ('| "?" |', '| "That is my " & touched.zone |'),
    ("| FALSE | Pressed", "| TRUE | Pressed"),
    ("| Sey |", "| Say |"),
    ("| Hello heard | changes |", "| Hello heard, Pressed | merge |"),
    ("Blue ball | map |", "Blue ball | combineLatest |"),
    ("forgetAfter | 1 h", "forgetAfter | 1 s"),
    (EMPTY, "|  | Touched | timeout | 10 s | Quiet |  |\n"),
    (EMPTY, '|  | Quiet | subscribe | "Shall we play?" | Say |  |\n'),
    ("| FALSE | Close ball |", "| TRUE | Close ball |"),
    ("| FALSE | Remark |", "| TRUE | Remark | throttle | 10 s |  |  |\n|  |  |"),
    (EMPTY, "|  | Touched | accumulate |  | Touches |  |\n"),
    (EMPTY, "|  | Touches | filter | touches = 3 | Three |  |\n"),
    (EMPTY, '|  | Three | subscribe | "Arms up" | Gesture |  |\n'),
    (EMPTY, '|  | Three | subscribe | "Hooray, three touches!" | Say |  |\n'),
)
"""What one does in the lessons, from top to bottom."""
SOLVED_IN_JAPANESE = (
    (EMPTY, '|  | 呼びかけ | subscribe | "こんにちは！" | 話す |  |\n'),
    ("赤いボール.distance < 5", "赤いボール.distance < 0.5"),
    ('| "?" |', '| "ここは" & 場所 |'),
    ("| FALSE | 押された", "| TRUE | 押された"),
    ("| 話すす |", "| 話す |"),
    ("| 呼びかけ | changes |", "| 呼びかけ, 押された | merge |"),
    ("青いボール | map |", "青いボール | combineLatest |"),
    ("forgetAfter | 1 h", "forgetAfter | 1 s"),
    (EMPTY, "|  | 触られた | timeout | 10 s | 静か |  |\n"),
    (EMPTY, '|  | 静か | subscribe | "いっしょに遊ぼう。" | 話す |  |\n'),
    ("| FALSE | 近いボール |", "| TRUE | 近いボール |"),
    ("| FALSE | ひとこと |", "| TRUE | ひとこと | throttle | 10 s |  |  |\n|  |  |"),
    (EMPTY, "|  | 触られた | accumulate |  | 接触の回数 |  |\n"),
    (EMPTY, "|  | 接触の回数 | filter | 接触の回数 = 3 | 三回 |  |\n"),
    (EMPTY, '|  | 三回 | subscribe | "Arms up" | 身ぶり |  |\n'),
    (EMPTY, '|  | 三回 | subscribe | "やった、3回！" | 話す |  |\n'),
)
LESSON_9 = 10  # of these are done before it


def write_solved(path: Path, name: str, most: int | None = None) -> Path:
    """A copy of a source in which some of the lessons are done."""
    text = source(name)
    for before, after in (SOLVED_IN_JAPANESE if name.endswith("ja") else SOLVED)[:most]:
        assert before in text
        text = text.replace(before, after, 1)
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def solved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write_solved(tmp_path_factory.mktemp("solved") / "tutorial.md", "tutorial")


@pytest.mark.parametrize("name", TUTORIALS)
def test_no_mark_of_a_later_lesson_is_taken_for_a_slip_of_ones_own(tmp_path: Path, name: str) -> None:
    assert not list(api.check(write_solved(tmp_path / "tutorial.md", name, LESSON_9)).report)


@pytest.mark.parametrize("name", TUTORIALS)
def test_no_other_row_looks_like_one_to_be_written_in(name: str) -> None:
    text = source(name)
    assert text.count(EMPTY) == 7 and f"{EMPTY}| # |" not in text


@pytest.mark.parametrize("name", TUTORIALS)
def test_it_is_solved_by_doing_what_it_says(tmp_path: Path, name: str) -> None:
    checked, report = api.test(write_solved(tmp_path / "tutorial.md", name))
    assert report is not None and report.passed and len(report.cases) == 10
    assert {d.severity.value for d in checked.report} == {"info"}


@pytest.mark.soak
def test_the_solved_one_plays_with_the_child(solved: Path, tmp_path: Path) -> None:
    api.run(solved, api.RunSettings(fast=True, out=tmp_path / "o", film=False))
    trace = (tmp_path / "o" / "trace.jsonl").read_text(encoding="utf-8")
    entries = [json.loads(line) for line in trace.splitlines()]
    said = [e["value"] for e in entries if e.get("stream") == "Say" and "value" in e]
    assert said == [
        "Hello!", "I see your ball.", "They kiss!", "That is my Head", "That is my Left hand", "That is my Right hand",
        "Hooray, three touches!", "That is my Chest", "That tickles!", "Shall we play?",
    ]  # fmt: skip
    assert [e["value"] for e in entries if e.get("stream") == "Gesture" and "value" in e] == ["Wave", "Arms up", "Wave"]


@pytest.fixture(scope="module")
def page(folder: Path, url: str, browser: Any) -> Iterator[GridPage]:
    (folder / "tutorial.xlsx").write_bytes(TUTORIAL.read_bytes())
    made = GridPage(browser, url, "tutorial.xlsx", name="Aya")
    yield made
    assert not made.errors


def row_of(page: GridPage, text: str, below: str) -> int:
    """The number of the first row with a text (or of the first empty one) below another."""
    script = """([text, below]) => { const rows = [...document.querySelectorAll("[role=grid] tbody tr")];
      const told = rows.map((row) => [...row.querySelectorAll("td:not(.example)")].map((cell) => cell.dataset.v ?? "").join("|"));
      const begin = told.findIndex((line) => line.includes(below));
      const empty = (line) => !line.replaceAll("|", "");
      return begin < 0 ? 0 : Number(rows.slice(begin + 1).find((row, i) => text
        ? told[begin + 1 + i].includes(text) && !told[begin + 1 + i].startsWith("#")
        : empty(told[begin + 1 + i])).cells[0].textContent); }"""
    found = some(lambda: page.page.evaluate(script, [text, below]))
    return int(found)


def go(page: GridPage, letter: str, row: int) -> None:
    """The cursor to a cell, with the arrows; again when an answer of the server has moved it meanwhile."""
    bar = page.page.locator("#formula-bar b")
    for _ in range(60):
        at, number = re.fullmatch(r"([A-Z])(\d+)", bar.inner_text()).groups()
        down, right = row - int(number), ord(letter) - ord(at)
        page.press(*["ArrowDown" if down > 0 else "ArrowUp"] * abs(down))
        page.press(*["ArrowRight" if right > 0 else "ArrowLeft"] * abs(right))
        with suppress(TimeoutError):
            page.page.wait_for_selector(f"#formula-bar b:text-is('{letter}{row}')", timeout=5_000)
            return
    raise AssertionError(f"the cursor does not come to {letter}{row}")


def write(page: GridPage, row: int, *cells: str, begin: str = "B") -> None:
    """A row, cell by cell with Tab, as everybody types it."""
    go(page, begin, row)
    for cell in cells[:-1]:
        if cell:
            page.page.keyboard.type(cell)
        page.press("Tab")
    page.write(cells[-1])


def holds(page: GridPage, count: int) -> None:
    """Wait until so many tests pass, as it is shown."""
    words = f"{count} of 10 lessons done" if count < 10 else "All 10 lessons are done"
    try:
        page.page.wait_for_selector(f".tests-count:text-is('{words}')")
    except Exception:
        print(page.page.locator("#panels").inner_text()[:1500])
        raise


def mend(page: GridPage, code: str, letter: str = "", row: int = 0) -> None:
    """The fix that the message at the cursor, or at another cell, offers, with its key."""
    if letter:
        page.page.wait_for_selector(f"tr:has(th:text-is('{row}')) .mend[data-code={code}]", state="attached")
        go(page, letter, row)
    page.page.wait_for_selector(f"td.at .mend[data-code={code}] [data-fix]", state="attached")
    page.press("Control+.")


def first_lessons(page: GridPage) -> None:
    """A row that is written, and a cell that is changed."""
    page.page.wait_for_selector("body[data-words]", state="attached")
    holds(page, 0)
    write(page, row_of(page, "", "Lesson 1:"), "Hello heard", "subscribe", '"Hello!"', "Say")
    holds(page, 1)
    row = row_of(page, "filter", "Lesson 2:")
    write(page, row, "redBall.distance < 0.5", begin="D")
    holds(page, 2)


def test_the_first_lessons_by_the_keyboard(page: GridPage) -> None:
    first_lessons(page)
    eventually(lambda: "Lesson 2 Near is done. 2 of 10 lessons done." in page.page.locator("#status").inner_text())
    shown = page.page.locator(".tests-list li")
    becomes(lambda: [shown.nth(n).get_attribute("class") for n in range(3)], ["is-passes", "is-passes", "is-now"])
    eventually(lambda: shown.nth(3).get_attribute("class") == "is-later" and not page.page.locator(".is-fails").count())
    expect(page.page.locator(".tests-first")).to_contain_text("Now: Lesson 3 Name it")


def test_a_lesson_that_does_not_hold_any_more_is_told_as_such(page: GridPage) -> None:
    row = row_of(page, "filter", "Lesson 2:")
    write(page, row, "redBall.distance < 0,5", begin="D")  # the comma of many countries
    page.page.wait_for_selector(".tests-list .is-waits, .tests-list .is-fails")
    mend(page, "FORM003", "D", row)
    holds(page, 2)
    page.page.click(".tests-list li:nth-child(2) a")
    becomes(lambda: page.here, f"B{row}")
    write(page, row, "redBall.distance < 5", begin="D")
    page.page.wait_for_selector(".tests-first:has-text('Lesson 2 Near now fails')")
    eventually(
        lambda: (
            page.page.locator(".tests-list .is-fails").count() == 1
            and page.page.locator(".tests-list .is-now").count() == 1
        )
    )
    page.press("Control+z")
    holds(page, 2)


def test_a_row_typed_into_a_comment_is_told_and_put_into_a_row_of_its_own(page: GridPage, folder: Path) -> None:
    row = row_of(page, "filter", "Lesson 2:") - 1
    go(page, "D", row)
    page.write('"blue"', "Tab")
    page.write("Chest LED color")
    go(page, "B", row)
    page.page.keyboard.type("Blue ball")
    eventually(lambda: "the robot skips it" in page.page.inner_text(".editor .is-comment"))
    page.press("Tab")
    page.write("subscribe")
    mend(page, "SHEET022", "C", row)
    page.page.wait_for_selector(f"tr.comment:has(th:text-is('{row}')):not(.buried)")
    page.expect(f"B{row + 1}", "Blue ball")
    page.press("Control+z")
    page.page.wait_for_selector(f"tr.buried:has(th:text-is('{row}'))")
    for letter in "BCDE":
        go(page, letter, row)
        page.press("Delete")
    bare = row_of(page, "", "Lesson 8:")
    write(page, bare, "#", begin="A")
    go(page, "B", bare)
    page.page.keyboard.type("Red ball")
    page.press("Control+.")
    page.page.wait_for_selector(f"tr:not(.comment):has(th:text-is('{bare}'))")
    page.press("Escape", "Control+z")
    page.page.wait_for_selector(f"tr.comment:has(th:text-is('{bare}'))")
    go(page, "A", bare)
    page.press("Delete")
    holds(page, 2)


def test_the_table_follows_the_rows_that_act_but_nobody_who_is_at_it(page: GridPage, browser: Any, url: str) -> None:
    page = GridPage(browser, url, "tutorial.xlsx")  # one of its own: clock and listeners stay
    page.page.emulate_media(reduced_motion="reduce")
    tell = """([phase, n, at]) => { const say = (name, detail) => document.dispatchEvent(new CustomEvent(name, { detail }));
      const rows = [...document.querySelectorAll("[role=grid] tbody tr")];
      const scroll = document.getElementById("grid-scroll");
      if (n < 0) scroll.scrollTop = 0;
      say("rrp:run", { phase, id: "a", book: "", t: at });
      if (n > 0) say("rrp:live", { t: at, rows: { [rows.find((r) => r.cells[0].textContent === String(n)).id]: { v: "x", at, n: at } } });
      return scroll.scrollTop; }"""

    def told(phase: str, number: int, at: float) -> float:
        return float(page.page.evaluate(tell, [phase, number, at]))

    go(page, "B", 8)
    # The server says that nothing runs whenever the page joins again, as it does after so long: here it is told otherwise.
    page.page.evaluate("""() => { for (const told of ["run", "live"]) document.getElementById("listen")
        .addEventListener(told, (event) => event.stopImmediatePropagation(), true); }""")
    set_clock(page.page)
    page.page.clock.run_for(120_000)  # nobody has touched the table for a while
    assert told("running", -1, 0.0) == 0
    eventually(lambda: page.page.locator("#run-follow").is_visible())
    assert told("running", 8, 1.0) == 0, "it is in sight"
    assert told("running", 42, 1.5) > 100
    becomes(lambda: page.here, "B8", "the cursor stays")
    page.page.clock.run_for(3_000)
    page.press("F2")
    page.page.clock.run_for(9_000)
    told("running", -1, 2.0)
    assert told("running", 43, 5.0) == 0, "somebody is writing"
    page.press("Escape")
    page.page.clock.run_for(9_000)
    page.page.uncheck("#run-follow input")
    assert told("running", 44, 6.0) == 0
    page.page.check("#run-follow input")
    assert told("running", 40, 7.0) > 100
    page.page.clock.run_for(3_000)
    told("running", -1, 8.0)
    assert told("running", 40, 8.5) == 0, "what comes all the time is no news"
    told("none", 0, 0.0)
    eventually(lambda: not page.page.locator("#run-follow").is_visible())
    page.close()


def test_a_lesson_is_read_on_a_narrow_screen_without_moving_the_table(page: GridPage) -> None:
    size = page.page.viewport_size
    page.page.set_viewport_size({"width": 400, "height": 800})
    script = """() => [...document.querySelectorAll("tr.comment:not(.buried) td.remark .word")]
      .every((word) => word.getBoundingClientRect().width <= innerWidth - 80)"""
    eventually(lambda: page.page.evaluate(script))
    page.page.set_viewport_size(size)


@pytest.mark.soak
def test_all_lessons_by_the_keyboard(page: GridPage, folder: Path) -> None:
    if "2 of 10" not in page.page.locator("#panels").inner_text():
        first_lessons(page)
    write(page, row_of(page, "map", "Lesson 3:"), '"That is my " & touched.zone', begin="D")
    holds(page, 3)
    row = row_of(page, "Sey", "Lesson 4:")
    go(page, "A", row)
    page.press("Space")
    go(page, "E", row)
    mend(page, "GRAPH006")
    holds(page, 4)
    write(page, row_of(page, "changes", "Lesson 5:"), "Hello heard, Pressed", "merge")
    holds(page, 5)
    write(page, row_of(page, "map", "Lesson 6:"), "combineLatest", begin="C")
    holds(page, 6)
    write(page, row_of(page, "forgetAfter", "Lesson 6:"), "1 s", begin="D")
    holds(page, 7)
    row = row_of(page, "", "Lesson 8:")
    write(page, row, "Touched", "timeout", "10 s", "Quiet")
    write(page, row + 1, "Quiet", "subscribe", '"Shall we play?"', "Say")
    holds(page, 8)
    row = row_of(page, "Remark|subscribe", "Lesson 9:")
    for tick in (row - 1, row):
        go(page, "A", tick)
        page.press("Space")
    go(page, "C", row)
    mend(page, "LINT002")
    page.press("Enter")  # the first of its two fixes
    holds(page, 9)
    row = row_of(page, "", "Lesson 10:")
    write(page, row, "Touched", "accumulate", "", "Touches")
    write(page, row + 1, "Touches", "filter", "touches = 3", "Three")
    write(page, row + 2, "Three", "subscribe", '"Arms up"', "Gesture")
    write(page, row + 3, "Three", "subscribe", '"Hooray, three touches!"', "Say")
    holds(page, 10)
    checked, report = api.test(folder / "tutorial.xlsx")
    assert report is not None and report.passed and [d.code for d in checked.report] == ["LINT004", "LINT004"]
