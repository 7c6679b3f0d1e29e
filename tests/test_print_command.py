"""`rrp-sheets print`: changes since the approved version, drafts, hostile texts, large workbooks."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from packs import DAY, workbook
from pdftree import filled, read_pdf, tags, texts_of, unspaced
from typed import run

from rrp_sheets import api
from rrp_sheets.errors import SheetsError
from rrp_sheets.resources import bundled
from rrp_sheets.services.printing import MOST_ROWS, make

WORKBOOKS = sorted(p.stem for p in bundled("workbooks").glob("*.xlsx"))
GOLDEN = Path(__file__).parent / "golden" / "print"


@pytest.mark.slow
def test_changes_since_the_approved_version_on_letter_paper(tmp_path, monkeypatch):
    rows = (
        "| Red ball | map | redBall.distance | Near | |\n| Near | filter | near < 1 | Close | |\n"
        "| Close | subscribe | | Head tracker | |\n"
    )
    before = workbook(tmp_path, rows, "approved.md", protocol="| Version | 1.0 |")
    more = rows.replace("near < 1", "near < 2") + "| Close | subscribe | | Nod | |\n"
    devices = "## Devices\n| Stream | Device | Name |\n|---|---|---|\n| Nod | Gesture | Nod |\n"
    workbook(tmp_path, more, "now.md", protocol="| Version | 1.1 |", rest=devices)
    monkeypatch.chdir(tmp_path)
    done = run("print", "now.md", "--against", before, "--paper", "letter", "--date", "2026-01-02")
    assert done == (0, "Printed: now.pdf\n")
    pdf = read_pdf((tmp_path / "now.pdf").read_bytes())
    assert [round(float(x)) for x in pdf.pages[0].mediabox[2:]] == [612, 792]
    pages = texts_of(pdf)
    assert "3 differences change the behaviour. See section 8." in pages[0]
    text = " ".join(pages)
    assert "Compared row by row with approved.md, version 1.0" in text
    assert re.search(r"changed Play row 3 formula: near < 1 formula: near < 2", text)
    assert re.search(r"added Play row 5", text)
    assert re.search(r"send “Close”\. changed", text)


def test_a_workbook_with_errors_is_printed_as_a_draft_only(tmp_path, monkeypatch):
    broken = workbook(tmp_path, "| Red ball | mapp | redBall.distance | Near | |\n")
    monkeypatch.chdir(tmp_path)
    code, said = run("print", broken)
    assert code == 1
    assert "There is no connector “mapp”" in said and "--draft" in said
    assert not (tmp_path / "w.pdf").exists()
    with pytest.raises(SheetsError, match="has errors"):
        api.print_pack(broken, tmp_path / "w.pdf")
    code, said = run("print", "w.md", "--draft")
    assert code == 1 and "Printed: w.pdf" in said
    pages = texts_of(read_pdf((tmp_path / "w.pdf").read_bytes()))
    assert all("DRAFT" in page for page in pages)
    assert "DRAFT with an open error: it cannot run as it is, and what is said below is incomplete" in pages[0]


@pytest.mark.slow
def test_texts_of_strangers_print_as_texts(tmp_path):
    evil = '<script>x</script> #panic("x") $x$ \\u{41} @problems {n} `a'
    rows = f"| Red ball | map | redBall.distance | N{'o' * 250} | |\n| Red ball | map | 1 | {evil} | |\n"
    path = workbook(
        tmp_path, rows, protocol=f"| Purpose | {evil} |\n| Ethics reference | {'long ' * 60} |\n| {evil} | = x |"
    )
    made = make(path, today=DAY, draft=True)
    text = " ".join(texts_of(read_pdf(made.data)))
    assert evil in text
    assert "N" + "o" * 20 in text


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["-o", "w.xlsx"], "The file ends with .pdf"),
        (["-o", "no/such/w.pdf"], "cannot be written"),
        (["--against", "gone.xlsx"], "gone.xlsx"),
    ],
)
def test_what_cannot_be_done_is_told(tmp_path, monkeypatch, arguments, message):
    workbook(tmp_path, "| Red ball | subscribe | | Print | |\n")
    monkeypatch.chdir(tmp_path)
    code, said = run("print", "w.md", *arguments)
    assert code == 2
    assert message in said and "Traceback" not in said


@pytest.mark.soak
@pytest.mark.parametrize("paper", ["a4", "letter"])
@pytest.mark.parametrize("name", WORKBOOKS)
def test_every_workbook_as_a_pdf(name, paper, request):
    path = bundled("workbooks", f"{name}.xlsx")
    pdf = read_pdf(make(path, today=DAY, paper=paper).data)
    pages = texts_of(pdf)
    assert all(f"{n} of {len(pages)}" in text or f"{n} / {len(pages)}" in text for n, text in enumerate(pages, 1))
    assert all(api.read(path).digest[:16] in text for text in pages)
    assert all(figure.alt for figure in tags(pdf).all("Figure"))
    whole, copied = " ".join(pages), unspaced(" ".join(pages))
    assert "\u200b" not in whole and api.read(path).digest in pages[0]
    formulas = [row.formula.text for b in api.read(path).workbook.behaviours for row in b.rows]
    assert all(unspaced(formula) in copied for formula in formulas)
    signed = next(i for i, text in enumerate(pages) if "Responsible researcher" in text or "研究責任者" in text)
    assert min(filled(p) for i, p in enumerate(pdf.pages[:-1]) if i not in (0, signed)) > 0.45  # the annex begins anew
    if paper == "a4":  # what a reader of the PDF gets out of it, the diagrams' words included
        golden, text = GOLDEN / f"{name}.pdf.txt", "\n\f\n".join(pages) + "\n"
        if request.config.getoption("--regenerate-golden"):
            golden.write_text(text, encoding="utf-8")
        assert text == golden.read_text(encoding="utf-8")


def test_too_many_rows_are_refused(tmp_path):
    rows = "".join(f"| Red ball | map | redBall.distance + {n} | D{n} | |\n" for n in range(MOST_ROWS + 1))
    with pytest.raises(SheetsError, match="1,001 rows; at most 1,000 can be printed"):
        make(workbook(tmp_path, rows), draft=True)


@pytest.mark.soak
def test_a_thousand_rows_are_printed_in_bounded_time(tmp_path):
    rows = "".join(f"| Red ball | map | redBall.distance + {n} | D{n} | |\n" for n in range(1_000))
    assert len(read_pdf(make(workbook(tmp_path, rows), today=DAY).data).pages) > 50
