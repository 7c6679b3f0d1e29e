"""`rrp-sheets formula TEXT`."""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import click

from rrp_sheets.cli.terminal import say, styled, usage_error
from rrp_sheets.render.style import columns
from rrp_sheets.texts import N_, sentences

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

    With --json and without TEXT, each line of input is an object: {"formula": "x + 1", "inputs": {"x": 5}}. Each gets
    one line as answer: {"outcome": "ok", "value": 6}, or {"outcome": "rejected" (or "error"), "code": "FORM004",
    "message": "…", "column": 0}. Columns are counted from 0; -1 means none. "others" lists further problems.

    Exit code: 0 there is a value (with --json and without TEXT: every line was answered), 1 there is none.
    """
    from rrp_sheets import api

    if text is None:
        if not as_json:
            raise usage_error(N_("What is the formula? Put it between quotes."))
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
    more = answer.remedy if inputs else N_('(A text needs quotes: "{name}".)', name=name)
    return replace(answer, remedy=sentences(N_("Give it a value: --input {name}=5.", name=name), more))


def _pair(given: str) -> tuple[str, Any]:
    from rrp_sheets.formulas.trial import typed_value

    name, equals, value = given.partition("=")
    if not equals or not name.strip():
        raise usage_error(N_("“{text}” is not an input. Write --input name=value.", text=given))
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
        click.echo(f"  {' ' * columns(before)}{'^' * max(columns(marked), 1)}", err=True)
    say(styled(N_("error"), fg="red", bold=True), answer.code, answer.message, err=True)
    if answer.remedy:
        say("  →", answer.remedy, err=True)


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
