"""Rewording of texts that mention terminal commands, for readers in the browser."""

from __future__ import annotations

import re

_HELP = re.compile(r"`rrp-sheets help ([^`]+)`", re.DOTALL)
_WORDS = (
    (re.compile(r"\s*`rrp-sheets --help` lists the commands\."), ""),
    (re.compile(r" \(`rrp-sheets (?:serve|new FILE)`(?: makes one)?\)"), ""),
    (re.compile(r" with\s+`rrp-sheets new FILE`"), " on the shelf"),
    (re.compile(r"made with `rrp-sheets new`"), "made on the shelf"),
    (re.compile(r"`rrp-sheets check --fix`"), "The button below the message"),
    (re.compile(r" \(`rrp-sheets help [^`]+`\)"), ""),
    (re.compile(r"`rrp-sheets help`"), "Help (F1)"),
    (re.compile(r", or name another folder with --out"), ""),
    (re.compile(r"Name another folder with --out"), "See to it that runs can be kept beside the workbook"),
)  # fmt: skip


def in_browser(text: str) -> str:
    """Reword a message or a remedy for a page, where commands in backticks cannot be followed.

    >>> in_browser("See `rrp-sheets help devices`."), in_browser("Make one with `rrp-sheets new FILE`.")
    ('See Help (F1): devices.', 'Make one on the shelf.')
    >>> in_browser("Make room, or name another folder with --out.")
    'Make room.'
    """
    return _HELP.sub(r"Help (F1): \1", of_help(text))


def of_help(text: str) -> str:
    """Reword a text of the help; its links to topics stay.

    >>> of_help("The grid in the browser (`rrp-sheets serve`) has keys. `rrp-sheets --help` lists the commands.")
    'The grid in the browser has keys.'
    """
    for pattern, new in _WORDS if "rrp-sheets" in text or "--out" in text else ():
        text = pattern.sub(new, text)
    return text
