"""TOML files of users, bounded in size, depth and time."""

from __future__ import annotations

import re
import tomllib
from pathlib import Path
from typing import Any

from billow.base.input_file import LARGEST_TEXT, read_text

DEEPEST_KEY = 10
"""Parts of a dotted key; Billow's own have at most five. The reader's memory grows with their square."""

_PART = r"""(?:[A-Za-z0-9_-]++|"[^"\n]*+"|'[^'\n]*+')"""
_DEEP = re.compile(rf"(?:^|[\[{{,])[ \t]*+{_PART}(?:[ \t]*+\.[ \t]*+{_PART}){{{DEEPEST_KEY}}}", re.MULTILINE)
_MOST_DIGITS = 1000
"""Of a number; the largest double has 309 before its point."""
_LONG = re.compile(rf"[0-9_]{{{_MOST_DIGITS + 1}}}")


def read_toml(path: str | Path, largest: int = LARGEST_TEXT) -> dict[str, Any]:
    """Content of a TOML file. OSError if it cannot be read; ValueError, with a sentence, if it is not TOML."""
    return parse_toml(read_text(path, largest))


def parse_toml(text: str) -> dict[str, Any]:
    """Content of TOML text. ValueError, with a sentence for the user, if it is not TOML."""
    deep = _DEEP.search(text)
    if deep is not None:
        raise ValueError(f"line {_line(text, deep)} has a key of more than {DEEPEST_KEY} parts")
    long = _LONG.search(text)
    if long is not None:
        raise ValueError(f"line {_line(text, long)} has a number of more than {_MOST_DIGITS} digits")
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise ValueError("it is nested too deeply") from None


def _line(text: str, found: re.Match) -> int:
    return text.count("\n", 0, found.start()) + 1
