"""Commands, as a user types them."""

from __future__ import annotations

import io
from contextlib import redirect_stderr, redirect_stdout
from unittest import mock

import pytest

from rrp_sheets.cli.main import main


def run(*arguments: object) -> tuple[int, str]:
    """Exit code and output of a command, as the entry point gives them."""
    out = io.StringIO()
    typed = mock.patch("sys.argv", ["rrp-sheets", *map(str, arguments)])
    with typed, redirect_stdout(out), redirect_stderr(out), pytest.raises(SystemExit) as left:
        main()
    return int(left.value.code or 0), out.getvalue()
