"""Kept versions of a workbook, bringing one back, and comparing any two workbooks."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from browser import GOOD, HEADER, HOME, TOKEN, get, post, visit
from flask.testing import FlaskClient

from rrp_sheets import api
from rrp_sheets.web.app import create_app

HOSTILE = "<script>alert(1)</script>\"'"
PAGE = "/book/good.md/versions"


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    (tmp_path / "good.md").write_text(GOOD, encoding="utf-8")
    return tmp_path


@pytest.fixture
def client(folder: Path) -> FlaskClient:
    return visit(folder)


def keep(client: FlaskClient, title: str, author: str = "Aya") -> str:
    return post(client, f"{PAGE}/keep", title=title, author=author).text


def versions(client: FlaskClient) -> dict[str, str]:
    """The numbers of the versions by their names, the newest first."""
    text = get(client, PAGE).text
    found = re.findall(r'<tr><th scope="row"><b>(.*?)</b>.*?/versions/(\d+)/file', text, re.DOTALL)
    return dict(found)


def restore(client: FlaskClient, number: str, author: str = "Aya") -> str:
    return post(client, f"{PAGE}/restore", version=number, author=author).text


def change(folder: Path, text: str = "Say") -> None:
    """Another program changes the file."""
    path = folder / "good.md"
    path.write_text(path.read_text(encoding="utf-8").replace("Head tracker", text), encoding="utf-8")


def test_no_version_yet_says_what_they_are_for(client: FlaskClient) -> None:
    assert "No saved versions yet" in get(client, PAGE).text


def test_versions_are_kept_with_name_and_author_and_survive_a_restart(folder: Path, client: FlaskClient) -> None:
    assert "Saved as “before the pilot”." in keep(client, "  before the   pilot ")
    keep(client, "approved", "Ken")
    for visitor in (client, visit(folder)):
        text = get(visitor, PAGE).text
        assert list(versions(visitor)) == ["approved", "before the pilot"]
        assert "Aya" in text and "Ken" in text and "today " in text and text.count("as it is now</span>") == 2


@pytest.mark.parametrize("title", ["", "   ", "\u202e", "\x07"])
def test_a_version_needs_a_name(client: FlaskClient, title: str) -> None:
    assert "A version needs a name." in keep(client, title)
    assert versions(client) == {}


def test_a_version_is_compared_with_now_and_brought_back(folder: Path, client: FlaskClient) -> None:
    keep(client, "first")
    before = (folder / "good.md").read_bytes()
    change(folder)
    after = (folder / "good.md").read_bytes()
    text = get(client, PAGE).text
    assert "as it is now</span>" not in text
    address = re.search(r'href="(/compare\?[^"]*first=version[^"]*)"', text)
    assert address
    compared = get(client, address[1].replace("&amp;", "&")).text
    assert "Different behaviour" in compared and "Head tracker" in compared and "first, today" in compared
    session = _session(client)
    listener = session.join("c1", "Ken")
    assert "“first” is restored." in restore(client, versions(client)["first"])
    assert (folder / "good.md").read_bytes() == before
    assert list(versions(client)) == ["Before first came back", "first"]
    assert any("event: reload" in m and "Aya has restored the version “first”." in m for m in told(listener))
    assert "Head tracker" in get(client, "/book/good.md").text
    restore(client, versions(client)["Before first came back"])
    assert (folder / "good.md").read_bytes() == after
    assert list(versions(client)) == ["Before first came back", "first"]  # nothing is kept twice


def test_nothing_is_brought_back_into_a_file_that_excel_has_open(folder: Path, client: FlaskClient) -> None:
    keep(client, "first")
    change(folder)
    now = (folder / "good.md").read_bytes()
    lock = folder / "~$good.md"
    lock.write_text("")
    assert "is open in Excel" in restore(client, versions(client)["first"])
    assert (folder / "good.md").read_bytes() == now and list(versions(client)) == ["first"]
    lock.unlink()
    assert "“first” is restored." in restore(client, versions(client)["first"])


def test_bringing_back_waits_for_who_edits_a_cell(folder: Path, client: FlaskClient) -> None:
    keep(client, "first")
    change(folder)
    now = (folder / "good.md").read_bytes()
    session = _session(client)
    grid = session.document.grids["Tracking"]
    place = ("Tracking", grid.rows[0], 1)
    session.lock("c1", "Ken", place)
    number = versions(client)["first"]
    assert "Ken is editing a cell just now. Restore it when they have finished." in restore(client, number)
    assert (folder / "good.md").read_bytes() == now
    session.unlock("c1", place)
    assert "“first” is restored." in restore(client, number)


def test_what_excel_has_written_meanwhile_is_what_is_kept(folder: Path, client: FlaskClient) -> None:
    get(client, "/book/good.md")
    change(folder, "Say")
    keep(client, "from Excel")
    change(folder, "Head tracker")
    number = versions(client)["from Excel"]
    assert get(client, f"{PAGE}/{number}/file").data == (folder / "good.md").read_bytes()


def test_a_version_can_be_taken_along(client: FlaskClient) -> None:
    keep(client, "a/b: c")
    answer = get(client, f"{PAGE}/{versions(client)['a/b: c']}/file")
    assert answer.data.decode() == GOOD
    assert answer.headers["Content-Disposition"] == 'attachment; filename="good (a b c).md"'
    assert get(client, f"{PAGE}/999/file").status_code == 404


def test_a_version_that_is_not_there(client: FlaskClient) -> None:
    for number in ("999", "x", "", "-1"):
        assert "This version no longer exists." in restore(client, number)
    for address in ("/book/nothing.md/versions", "/book/..%2fgood.md/versions"):
        assert get(client, address).status_code == 404


def test_versions_go_with_a_new_name(folder: Path, client: FlaskClient) -> None:
    keep(client, "first")
    post(client, "/shelf/rename", book="good.md", name="better")
    assert "first" in get(client, "/book/better.md/versions").text


def test_in_a_folder_that_cannot_be_written_nothing_is_offered(folder: Path) -> None:
    (folder / ".rrp-sheets").write_text("in the way")
    client = visit(folder)
    text = get(client, PAGE).text
    assert "Versions cannot be saved here." in text and "Save version</button>" not in text
    assert "You cannot change this workbook here." in keep(client, "x")


def test_versions_are_changed_by_our_own_pages_only(client: FlaskClient) -> None:
    for action in ("keep", "restore"):
        assert client.post(f"{PAGE}/{action}", base_url=HOME, data={"title": "x", "version": "1"}).status_code == 403


# ---- comparing ----


def test_two_workbooks_of_the_shelf(folder: Path, client: FlaskClient) -> None:
    api.new(folder / "simple.xlsx", template="simple-tracking")
    (folder / "near.md").write_text(GOOD.replace("Head tracker | |", "Head tracker | | a note"), encoding="utf-8")
    text = get(client, "/compare").text
    assert '<option value="book/good.md">good.md</option>' in text and "Two workbooks side by side" in text
    assert (
        "Same behaviour. There is no difference." in get(client, "/compare?first=book/good.md&second=book/good.md").text
    )
    text = get(client, "/compare?first=book/good.md&second=book/simple.xlsx").text
    assert "Different behaviour" in text and 'value="book/simple.xlsx" selected' in text
    assert not re.search(r"<style|\sstyle=|\son\w+=", text)
    assert "Only notes are different." in get(client, "/compare?first=book/good.md&second=book/near.md").text


@pytest.mark.slow
@pytest.mark.parametrize("ref", ["book/none.md", "book/../good.md", "version/1/good.md", "version/x/good.md", "run/none", "x",
                                 "version/1/none.md", "run/..", "book/", "version/99999999999999999999/good.md"])  # fmt: skip
def test_what_cannot_be_compared_is_told(client: FlaskClient, ref: str) -> None:
    answer = get(client, f"/compare?first={ref}&second=book/good.md")
    assert answer.status_code == 200 and 'class="notice is-error" role="status"' in answer.text


def test_a_file_that_is_no_workbook_is_told(folder: Path, client: FlaskClient) -> None:
    (folder / "broken.xlsx").write_bytes(b"PK broken")
    text = get(client, "/compare?first=book/broken.xlsx&second=book/good.md").text
    assert "is damaged" in text and "repair it and save it again" in text


def test_hostile_texts_are_shown_as_text(folder: Path, client: FlaskClient) -> None:
    keep(client, HOSTILE, HOSTILE)
    rows = f"| Red ball | map | redBall.x + '{HOSTILE}' | {HOSTILE} | | {HOSTILE} |\n| {HOSTILE} | subscribe | | Say | | |\n"
    (folder / "hostile.md").write_text(f"## {HOSTILE}\n{HEADER}{rows}", encoding="utf-8")
    number = next(iter(versions(client).values()))
    for address in (
        PAGE,
        "/compare?first=book/good.md&second=book/hostile.md",
        f"/compare?first=version/{number}/good.md&second=book/hostile.md",
    ):
        text = get(client, address).text
        assert "<script>" not in text and "&lt;script&gt;" in text, address
    assert "<script>" not in restore(client, number)


def test_formulas_are_not_evaluated_in_the_server(
    folder: Path, client: FlaskClient, monkeypatch: pytest.MonkeyPatch
) -> None:
    def never(*_: object) -> None:
        raise AssertionError("a formula is evaluated in the server")

    (folder / "other.md").write_text(GOOD.replace("subscribe | |", "map | redBall.x * 2 |"), encoding="utf-8")
    monkeypatch.setattr("asteval.Interpreter.__init__", never)
    monkeypatch.setattr("rrp_sheets.checks.check.check_workbook", never)
    assert "Different behaviour" in get(client, "/compare?first=book/good.md&second=book/other.md").text


def _session(client: FlaskClient):  # type: ignore[no-untyped-def]
    """The session behind the pages, as the grid's routes have it."""
    services = client.application.extensions["services"]
    return services.open_workbooks.session(services.repository.path("good.md"))


def told(listener) -> list[str]:  # type: ignore[no-untyped-def]
    return [m if isinstance(m, str) else str(m) for m in listener.messages]


def test_the_token_is_needed(folder: Path) -> None:
    stranger = create_app(folder, TOKEN).test_client()
    for address in (PAGE, "/compare", "/runs", "/runs/x", "/book/good.md/print", "/compare/changes.css"):
        assert stranger.get(address, base_url=HOME).status_code == 403
