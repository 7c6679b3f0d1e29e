"""`help FORM003`: the page of a code; `help codes`: all of them."""

from __future__ import annotations

from collections.abc import Iterator

from rrp_sheets.diagnostics import CODES, Code
from rrp_sheets.diagnostics.catalogue import TOPICS, load_page
from rrp_sheets.help.layout import Block, checked, entries, heading, paragraph, remark, titled, workbook
from rrp_sheets.texts import N_, LazyMessage

_KINDS = {
    "error": N_("{code} (error): {title}"), "warning": N_("{code} (warning): {title}"),
    "info": N_("{code} (note): {title}"),
}  # fmt: skip
_LISTED = {"error": N_("{title}"), "warning": N_("{title} (warning)"), "info": N_("{title} (note)")}


def all_codes() -> Iterator[Block]:
    """Yield every code with its title, by topic."""
    yield paragraph(N_("What a check can find. For one with an example: `rrp-sheets help FORM003`."))
    for prefix, title in TOPICS.items():
        yield heading(title, prefix)
        yield entries((code.id, _titled(code)) for code in CODES.values() if code.id.rstrip("0123456789") == prefix)


def _titled(code: Code) -> str:
    return LazyMessage(_LISTED[code.severity.value], title=code.text("title", {}))


def one_code(code: Code, language: str = "en") -> Iterator[Block]:
    """Yield the page of a code, with what the check says of its wrong example, which is written in a language."""
    title = LazyMessage(_KINDS[code.severity.value], code=code.id, title=code.text("title", {}))
    yield heading(title, code.id)
    page = load_page(code.id)
    yield titled(N_("What it means"), remark(page.text("means")))
    yield titled(N_("Why it matters"), remark(page.text("why")))
    yield titled(N_("How to fix it"), remark(page.text("mend")))
    if page.untabled:
        yield titled(N_("For example"), remark(page.text("untabled")))
        return
    wrong = workbook(f"{code.id} wrong", page.wrong, language, drawn=False)
    yield titled(N_("Wrong"), wrong)
    for finding in checked(wrong.source).report:
        if finding.code == code.id and finding.address is not None:
            said = remark(N_("{address}: {message}", address=finding.address, message=finding.message))
            yield titled(N_("The check says"), said, remark(N_("→ {remedy}", remedy=finding.remedy)))
            break
    yield titled(N_("Right"), workbook(f"{code.id} right", page.right, language, drawn=False))
