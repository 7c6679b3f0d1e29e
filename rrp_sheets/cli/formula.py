"""`rrp-sheets formula TEXT`."""

from __future__ import annotations

import json
import sys
import unicodedata
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rrp_sheets.formulas.trial import Answer

_LONGEST_LINE = 2_000_000  # characters


@click.command(name="formula", context_settings={"ignore_unknown_options": True})  # -x^2 is a formula
@click.argument("text", required=False)
@click.option("--input", "inputs", multiple=True, metavar="NAME=VALUE", help="an input of the formula; may be repeated")
@click.option("--json", "as_json", is_flag=True, help="answer in JSON; without TEXT, one answer to each line of input")
def formula_command(text: str | None, inputs: tuple[str, ...], as_json: bool) -> None:
    """Try the formula TEXT: rrp-sheets formula "IF(x > 3; 1; 0)" --input x=5.

    A VALUE is a number, TRUE or FALSE, a text, or JSON: --input 'ball={"distance": 0.4}' is a record.

    With --json and without TEXT: reads objects {"formula": "x + 1", "inputs": {"x": 5}}, one a line, and answers
    one object a line: {"outcome": "ok", "value": 6}, or {"outcome": "rejected" (or "error"), "code": "FORM004",
    "message": "…", "column": 0}; columns are counted from 0, -1 is none; "others" has what else is wrong, if anything.

    Exit code: 0 it has a value (with --json and without TEXT: every line was answered), 1 it has none.
    """
    from rrp_sheets import api

    if text is None:
        if not as_json:
            raise click.UsageError("What is the formula? Put it between quotes.")
        _answer_lines()
        sys.exit(0)
    answer = api.formula(text, dict(_pair(given) for given in inputs))
    if as_json:
        click.echo(json.dumps(answer.as_dict()))
    else:
        for one in (answer, *answer.others):
            _show(text, _with_input(text, one, inputs))
    sys.exit(0 if answer.outcome == "ok" else 1)


def _with_input(text: str, answer: Answer, inputs: tuple[str, ...]) -> Answer:
    """An unknown name is mostly an input that was not given: say how to give it, unless another name is near."""
    if answer.code != "FORM004" or answer.guess:
        return answer
    name = text[answer.column : answer.column + answer.length]
    if not name.isidentifier() or name.startswith("_") or "__" in name:
        return answer
    more = f" {answer.remedy}" if inputs else f' (A text needs quotes: "{name}".)'
    return replace(answer, remedy=f"Give it a value: --input {name}=5.{more}")


def _pair(given: str) -> tuple[str, Any]:
    from rrp_sheets.formulas.trial import typed_value

    name, equals, value = given.partition("=")
    if not equals or not name.strip():
        raise click.UsageError(f"“{given}” is no input: write --input name=value.")
    return name.strip(), typed_value(value)


def _answer_lines() -> None:
    from rrp_sheets.formulas.evaluator import GuardedInterpreter
    from rrp_sheets.formulas.trial import answer_line

    interpreter = GuardedInterpreter()
    if sys.stdin is None:  # closed: there is nothing to answer
        return
    source = sys.stdin.buffer
    while line := source.readline(_LONGEST_LINE):
        cut = not line.endswith(b"\n")
        while cut and (rest := source.readline(_LONGEST_LINE)):  # a line without end is answered once
            line, cut = b"", not rest.endswith(b"\n")
        text = line.decode("utf-8", errors="replace")
        if text.strip() or not line:
            print(json.dumps(answer_line(text, interpreter).as_dict()), flush=True)


def _show(text: str, answer: Answer) -> None:
    if answer.outcome == "ok":
        click.echo(_person(answer.value))
        return
    if answer.column >= 0:
        click.echo(f"  {''.join(c if c.isprintable() else ' ' for c in text)}", err=True)
        before, marked = text[: answer.column], text[answer.column : answer.column + answer.length]
        click.echo(f"  {' ' * _width(before)}{'^' * max(_width(marked), 1)}", err=True)
    click.echo(f"{click.style('error', fg='red', bold=True)} {answer.code} {answer.message}", err=True)
    if answer.remedy:
        click.echo(f"  → {answer.remedy}", err=True)


def _width(text: str) -> int:
    """Return the number of columns that a text takes in a terminal."""
    wide = {"W": 2, "F": 2}
    return sum(0 if unicodedata.combining(c) else wide.get(unicodedata.east_asian_width(c), 1) for c in text)


def _person(value: Any) -> str:
    """A value with all its digits; texts between quotes, as a formula would have it."""
    from rrp_sheets.model.values import Record

    if value is None:
        return "BLANK"
    if isinstance(value, bool):
        return "TRUE" if value else "FALSE"
    if isinstance(value, float):
        return f"{value:.15g}"
    if isinstance(value, str):
        return '"' + value.replace('"', '""') + '"'
    if isinstance(value, (list, tuple)):
        return f"[{'; '.join(_person(v) for v in value)}]"
    if isinstance(value, Record):
        return f"{value.type.name}: " + ", ".join(f"{n} {_person(v)}" for n, v in value.as_dict().items())
    return str(value)
