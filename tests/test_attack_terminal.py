"""Names and formulas of strangers do not steer the terminal, whatever command shows them."""

from __future__ import annotations

from pathlib import Path

import forked
import pytest

from rrp_sheets.cli.terminal import plain_text

STEERING = ("\x1b]", "\x07", "\x9b", "\u202e", "\u2066", "\x1b[2J", "\x1b[8m")
BAD = "a\x1b]0;title\x07b\x1b[2Jc\x1b[8md\x9b31me\u202ef\u2066g"
WORKBOOK = f"""## {BAD}
| Input streams | Connector | Formula | Output stream | Notes |
|---|---|---|---|---|
| Red ball | map | redBall.x | {BAD} | {BAD} |
| {BAD} | map | 1 | Say | |
| X | {BAD} | {BAD} | Y | |

## Test {BAD}
| Time (ms) | Stream | Send | Expect | Notes |
|---|---|---|---|---|
| 0 | {BAD} | {BAD} | | |
"""


@pytest.mark.slow
@pytest.mark.parametrize(
    "command",
    [
        ["check"],
        ["check", "--json"],
        ["explain"],
        ["diagram"],
        ["test"],
        ["marbles"],
        ["diff", "--text"],
        ["run", "--fast"],
    ],
)
def test_nothing_steers_the_terminal(command: list[str], tmp_path: Path) -> None:
    file = tmp_path / "w.md"
    file.write_text(WORKBOOK, encoding="utf-8")
    ran = forked.run(
        [*forked.COMMAND, *command, str(file)],
        capture_output=True,
        cwd=tmp_path,
        encoding="utf-8",
        timeout=300,
    )
    shown = ran.stdout + ran.stderr
    assert shown
    assert "Traceback" not in shown
    if "--json" in command:  # data for a program: there JSON itself escapes what steers
        assert not any(c in shown for c in ("\x1b", "\x07"))
    else:
        assert not [s for s in STEERING if s in shown]


def test_what_a_command_says_in_colour_stays_in_colour() -> None:
    assert plain_text("\x1b[31m\x1b[1merror\x1b[0m 日本語\tand\r\n") == "\x1b[31m\x1b[1merror\x1b[0m 日本語\tand\r\n"
    assert plain_text("gone\rover") == "gone\ufffdover"
