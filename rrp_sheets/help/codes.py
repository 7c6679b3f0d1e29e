"""`help FORM003`: the page of a code; `help codes`: all of them."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.diagnostics import CODES, Code
from rrp_sheets.diagnostics.catalogue import TOPICS, completed, load_page
from rrp_sheets.help.layout import checked, entries, grids, heading, paragraph, titled


def all_codes() -> Iterator[str]:
    """Every code with its title, by topic."""
    yield paragraph("What a check can find. `rrp-sheets help FORM003`, say, explains one and shows an example.")
    for prefix, title in TOPICS.items():
        yield heading(title)
        yield entries((code.id, _titled(code)) for code in CODES.values() if code.id.rstrip("0123456789") == prefix)


def _titled(code: Code) -> str:
    return code.title if code.severity.value == "error" else f"{code.title} ({code.severity.value})"


def one_code(code: Code) -> Iterator[str]:
    """The page of a code, with what the check says of its wrong example."""
    yield heading(f"{code.id} ({code.severity.value}): {code.title}")
    page = load_page(code.id)
    for title, text in (("What it means", page.means), ("Why it matters", page.why), ("How to fix it", page.mend)):
        yield titled(title, paragraph(text, 2))
    if page.untabled:
        yield titled("For example", paragraph(page.untabled, 2))
        return
    yield titled("Wrong", *grids(page.wrong), between="\n\n")
    for finding in checked(completed(page.wrong)).report:
        if finding.code == code.id and finding.address is not None:
            said = paragraph(f"{finding.address}: {finding.message}", 2)
            yield titled("The check says", said, paragraph(f"→ {finding.remedy}", 4))
            break
    yield titled("Right", *grids(page.right), between="\n\n")
