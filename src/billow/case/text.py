"""Field types of the case schema that are words: names and titles."""

from __future__ import annotations

import re
from typing import Annotated

from pydantic import AfterValidator

from billow.case.quantity import refused


def _plain_name(value: str) -> str:
    if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_-]{0,39}", value):
        raise refused(
            "names head columns of histories.csv and lead to settings",
            "use letters, digits, - and _ (at most 40), a letter first",
        )
    return value


def _one_line(value: str) -> str:
    if not value.isprintable():
        raise refused("it holds a line break or a control character", "use plain text in one line")
    return value


Name = Annotated[str, AfterValidator(_plain_name)]
Text = Annotated[str, AfterValidator(_one_line)]
