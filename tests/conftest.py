"""Options and fixtures that several test files share."""

import signal
from pathlib import Path

import pytest

if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    # started in the background by a shell without job control: what the tests start would be deaf to Ctrl-C too
    signal.signal(signal.SIGINT, signal.default_int_handler)


def pytest_addoption(parser):
    parser.addoption("--regenerate-golden", action="store_true", help="write tests/golden anew, for review as a diff")


@pytest.fixture(autouse=True)
def _no_limit_here(monkeypatch):
    """A command that is called within this process must not take the memory of all other tests."""
    monkeypatch.setattr("rrp_sheets.runs.limits.limit_memory", lambda *_: None)


@pytest.fixture
def golden(request):
    """Compares a text with its file in tests/golden, or writes that file."""

    def compare(name: str, text: str) -> None:
        path = Path(__file__).parent / "golden" / name
        if request.config.getoption("--regenerate-golden"):
            path.write_text(text, encoding="utf-8")
        assert text == path.read_text(encoding="utf-8")

    return compare
