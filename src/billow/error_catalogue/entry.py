"""What the catalogue says about one code."""

from __future__ import annotations

from dataclasses import dataclass

from billow.base.errors import BillowError


@dataclass(frozen=True)
class Entry:
    """kind: class of the error, None for a warning; meaning, cause, remedy: one sentence each."""

    kind: type[BillowError] | None
    meaning: str
    cause: str
    remedy: str
