"""Drawn changes: every mark of the pictures, the rows beside them, the files, and the page in the browser."""

from __future__ import annotations

import html.parser
import re
from pathlib import Path
from typing import Any

import pytest
from browser import get, visit
from chromium import becomes
from click.testing import CliRunner, Result
from compared import BASE, edited

from rrp_sheets import api
from rrp_sheets.cli.main import group
from rrp_sheets.model.changed import ADDED, CHANGED, REMOVED, ChangedBehaviour
from rrp_sheets.render.change_diagram import MOST_DRAWN, draw_changes, drawn_rows, legend_page
from rrp_sheets.render.diagram import draw_legend
from rrp_sheets.render.style import SANS, escape
from rrp_sheets.services.changes_drawn import Compared, compared

ROW_5 = "| | | Steady | filter | steady < 20 | Close ball | |\n"
AFTER = edited(
    (ROW_5, ROW_5.replace("< 20", "< 15") + "| | | Distance | map | 1 | One | |\n"),
    ("| | | Any | subscribe | | Print | |\n", ""),
    ("Twice, Distance | merge", "Distance, Steady | merge"),
    ("| | 2 | Close", "| | 3 | Close"),
    ("| limit | | 0.5 |", "| limit | | 0.8 |"),
    ("Say parameter | Hello |", "Say parameter | Good day |"),
)


@pytest.fixture(scope="module")
def pair(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Path]:
    folder = tmp_path_factory.mktemp("pair")
    paths = folder / "before.md", folder / "after.md"
    for path, text in zip(paths, (BASE, AFTER), strict=True):
        path.write_text(text, encoding="utf-8")
    return paths


@pytest.fixture(scope="module")
def found(pair: tuple[Path, Path]) -> Compared:
    return api.diff_in_detail(*pair)


@pytest.fixture(scope="module")
def picture(found: Compared) -> str:
    return draw_changes(found.behaviours[0])[0].svg


def written(folder: Path, before: str, after: str) -> Compared:
    for name, text in (("a.md", before), ("b.md", after)):
        (folder / name).write_text(text, encoding="utf-8")
    return api.diff_in_detail(folder / "a.md", folder / "b.md")


def run(*arguments: object) -> Result:
    return CliRunner().invoke(group, ["diff", *map(str, arguments)])


def group_of(svg: str, title: str) -> str:
    """The part of a picture with that title."""
    match = re.search(rf"<title>{re.escape(title)}</title>.*?(?=<g id=|</svg>)", svg, re.DOTALL)
    assert match, title
    return match[0]


# ---- what is drawn


def test_only_the_behaviour_that_changed_is_drawn(found: Compared) -> None:
    assert [(b.name, b.sign) for b in found.behaviours] == [("Tracking", "")]


@pytest.mark.parametrize(
    "title",
    [
        "Row 5, map, new", "One, new", "Row 12, subscribe, gone", "Print, gone", "Row 4, filter, changed",
        "Row 3, sample, as before", "Red ball, as before", "Hello, changed", "Row 6, subscribe, changed",
    ],
)  # fmt: skip
def test_every_box_says_what_became_of_it(picture: str, title: str) -> None:
    assert f"<title>{title}</title>" in picture


def test_a_changed_formula_stands_before_and_after_with_its_words_marked(picture: str) -> None:
    box = group_of(picture, "Row 4, filter, changed")
    assert 'steady &lt; <tspan text-decoration="line-through">20</tspan>' in box
    assert re.search(r'steady &lt; <tspan font-weight="bold" text-decoration="underline">15</tspan>', box)


def test_every_line_of_the_formula_before_a_change_is_struck_out(tmp_path: Path) -> None:
    before = ROWS.format('| Red ball | map | IF(redBall.distance < 0.5, "a word for near", "a word for far") | One |\n')
    (behaviour,) = written(tmp_path, before, ROWS.format("| Red ball | map | 7 | One |\n")).behaviours
    box = group_of(draw_changes(behaviour)[0].svg, "Row 2, map, changed")
    gone = re.findall(r'<tspan text-decoration="line-through">([^<]+)</tspan>', box)
    assert len(gone) > 1 and "far" in gone[-1]


def test_told_in_grey_too(picture: str) -> None:
    assert "stroke-dasharray" in group_of(picture, "Row 12, subscribe, gone")
    assert 'stroke-width="2.2"' in group_of(picture, "Row 5, map, new")
    assert 'stroke-width="0.9"' in group_of(picture, "Row 3, sample, as before")
    assert "stroke-dasharray" not in group_of(picture, "Row 3, sample, as before")


def test_a_setting_a_priority_and_a_helper(picture: str) -> None:
    assert "Text: Good day" in group_of(picture, "Hello, changed")
    row = group_of(picture, "Row 6, subscribe, changed")
    assert "priority 2 → 3" in row and "helper near" not in row and "helper limit changed" in row


def test_inputs_that_came_and_went(found: Compared) -> None:
    merge = next(r for r in found.behaviours[0].rows if r.connector.after == "merge")
    assert {(link.stream, link.sign) for link in merge.takes} == {
        ("tracking!distance", ""), ("tracking!steady", ADDED), ("tracking!twice", REMOVED),
    }  # fmt: skip


ROWS = "## A\n| Inputs | Connector | Formula | Output |\n|---|---|---|---|\n{}"


@pytest.mark.parametrize(
    ("before", "after", "signs"),
    [
        ("| Red ball | map | 1 | One |\n", "| Red ball | map | 1 | One |\n", None),
        ("| Red ball | map | 1 | One |\n", "| Red ball | map | 1 | Two |\n", [""]),  # only a stream's name
        ("| Red ball | map | 1 | One |\n", "| Red ball | map | 2 | One |\n", [CHANGED]),
        ("| Red ball | map | 1 | |\n| | subscribe | | Print |\n", "| Red ball | map | 1 | |\n", ["", REMOVED]),
        ("| Red ball | map | 1 | |\n", "| Red ball | map | 1 | |\n| | subscribe | | Print |\n", ["", ADDED]),
        ("| Red ball | map | 1+ | One |\n", "| Red ball | mapp | 1+ | One |\n", [CHANGED]),  # both have errors
    ],
)
def test_signs_of_rows(tmp_path: Path, before: str, after: str, signs: list[str] | None) -> None:
    behaviours = written(tmp_path, ROWS.format(before), ROWS.format(after)).behaviours
    assert [[r.sign for r in b.rows] for b in behaviours] == ([] if signs is None else [signs])
    for behaviour in behaviours:
        assert draw_changes(behaviour)


def test_a_behaviour_that_came_is_drawn_whole(tmp_path: Path) -> None:
    after = BASE + "\n" + ROWS.format("| Red ball | map | 1 | One |\n").replace("## A", "## New")
    (behaviour,) = written(tmp_path, BASE, after).behaviours
    assert (behaviour.sign, [r.sign for r in behaviour.rows]) == (ADDED, [ADDED])


def chain(rows: int, changed: frozenset[int]) -> str:
    lines = [f"| D{i - 1} | map | d{i - 1} {'*' if i in changed else '+'} 1 | D{i} |\n" for i in range(1, rows)]
    return ROWS.format("| Red ball | map | redBall.x | D0 |\n" + "".join(lines))


def behaviour_of(folder: Path, rows: int, changed: frozenset[int]) -> ChangedBehaviour:
    return written(folder, chain(rows, frozenset()), chain(rows, changed)).behaviours[0]


def test_of_a_long_behaviour_what_changed_and_what_is_joined_with_it(tmp_path: Path) -> None:
    behaviour = behaviour_of(tmp_path, 40, frozenset({10, 30}))
    assert [r.number for r in drawn_rows(behaviour)] == [11, 12, 13, 31, 32, 33]
    (page,) = draw_changes(behaviour)
    assert page.caption == "not drawn: rows 2–10, 14–30 and 34–41, unchanged"
    assert "from row 10" in page.svg


@pytest.mark.slow
def test_a_thousand_changed_rows_are_bounded(tmp_path: Path) -> None:
    behaviour = behaviour_of(tmp_path, 1_000, frozenset(range(1_000)))
    assert len(drawn_rows(behaviour)) == MOST_DRAWN


# ---- files and exit codes


class Page(html.parser.HTMLParser):
    def __init__(self, text: str) -> None:
        super().__init__()
        self.tags: list[str] = []
        self.names: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.names += [name for name, _ in attrs]


def test_html_has_the_pictures_in_it_and_loads_nothing(pair: tuple[Path, Path], tmp_path: Path) -> None:
    result = run(*pair, "-o", tmp_path / "x.html")
    assert result.exit_code == 1, result.output
    text = (tmp_path / "x.html").read_text(encoding="utf-8")
    page = Page(text)
    assert page.tags.count("svg") == 2 and "script" not in page.tags  # the legend and the behaviour
    assert not {"src", "href", "onload", "onclick"} & set(page.names)
    ids = re.findall(r'\bid="([^"]+)"', text)
    assert len(ids) == len(set(ids))
    for said in ("<del>20</del>", "<ins>15</ins>", "Rows 8 to 10: unchanged", "priority 2 → 3"):
        assert said in text


def test_svg_by_its_flag_or_by_the_files_name(pair: tuple[Path, Path], tmp_path: Path) -> None:
    printed = run(*pair, "--svg")
    assert printed.exit_code == 1 and printed.output.startswith("<svg ") and "before.md → after.md" in printed.output
    assert "., " not in printed.output.split("</title>")[0]
    assert run(*pair, "-o", tmp_path / "x.svg").exit_code == 1
    assert (tmp_path / "x.svg").read_text(encoding="utf-8") == printed.output


def test_nothing_to_draw_is_said_in_the_picture(pair: tuple[Path, Path]) -> None:
    result = run(pair[0], pair[0], "--svg")
    assert result.exit_code == 0 and "there is nothing to draw" in result.output
    drawn = compared(pair[0], pair[0]).svg("ja")
    assert "違う行がない" in drawn and "No row" not in drawn and "Same behaviour" not in drawn


@pytest.mark.parametrize(
    ("flags", "said"),
    [
        (["--svg", "-o", "x.html"], "The picture's file ends with .svg"),
        (["--html", "-o", "x.svg"], "The page's file ends with .html"),
        (["-o", "x.png"], "The page's file ends with .html"), (["--svg", "--html"], "Leave out --svg"),
    ],
)  # fmt: skip
def test_wishes_that_do_not_fit(pair: tuple[Path, Path], flags: list[str], said: str) -> None:
    result = run(*pair, *flags)
    assert result.exit_code == 2 and said in result.output


HOSTILE = "<script>alert(1)</script>\"'&amp;" + "長い名前" * 70


def test_hostile_names_are_texts(tmp_path: Path) -> None:
    before = ROWS.format(f'| Red ball | map | "{HOSTILE}" | {HOSTILE} |\n| {HOSTILE} | subscribe | | Print |\n')
    found = written(tmp_path, before, before.replace("alert", "prompt").replace("## A", f"## {HOSTILE[:25]}"))
    page = Page(found.html())
    assert "script" not in page.tags and "svg" in page.tags
    assert not [name for name in page.names if name.startswith("on")]


# ---- in the browser


@pytest.mark.slow
def test_compare_draws_after_its_text(pair: tuple[Path, Path], tmp_path: Path) -> None:
    for path in pair:
        api.convert(path, tmp_path / f"{path.stem}.xlsx")
    client = visit(tmp_path)
    refs = "first=book/before.xlsx&second=book/after.xlsx"
    page = get(client, f"/compare?{refs}").text
    assert "Different behaviour" in page and "Drawing the changes" in page and "<svg xmlns" not in page
    asked = re.search(r'hx-get="(/compare/drawn\?[^"]+)"', page)
    assert asked
    drawn = get(client, asked[1].replace("&amp;", "&")).text
    assert "Row 4, filter, changed" in drawn and "<ins>15</ins>" in drawn
    assert "There is no run" in get(client, "/compare/drawn?first=run/no&second=book/after.xlsx").text
    assert "Drawing the changes" not in get(client, "/compare?first=book/after.xlsx&second=book/after.xlsx").text


def test_no_legend_is_cut_in_a_browser_without_the_fonts_that_it_was_measured_for(browser: Any) -> None:
    """DejaVu Sans is the widest of those that Linux systems have."""
    pictures = [legend_page("A").svg, draw_legend("en")[0], draw_legend("ja")[0].replace("legend-", "ja-")]
    page = browser.new_page(viewport={"width": 1000, "height": 900})
    page.set_content("".join(f"<div>{p.replace(escape(SANS), 'DejaVu Sans, Noto Sans JP')}</div>" for p in pictures))
    script = """() => [...document.querySelectorAll('svg')].flatMap((svg) => {
        const edge = svg.getBoundingClientRect();
        return [...svg.querySelectorAll('text')].filter((text) => {
            const box = text.getBoundingClientRect();
            return box.right > edge.right || box.bottom > edge.bottom;
        }).map((text) => text.textContent);
    })"""
    becomes(lambda: page.evaluate(script), [])
    page.close()
