"""Result of a verification case: a measured number, the expected one, and the tolerance."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass


@dataclass(frozen=True)
class Measurement:
    """One number of a case.

    measured and expected in the unit the title names; tolerance: relative to expected, or in that unit where the title
    says absolute.
    """

    title: str
    measured: float
    expected: float
    tolerance: float

    @property
    def passed(self) -> bool:
        """Whether measured lies within the tolerance; a value that is not a number never does."""
        allowed = self.tolerance if "absolute" in self.title else self.tolerance * abs(self.expected)
        return abs(self.measured - self.expected) <= allowed


@dataclass(frozen=True)
class Check:
    """A measurement with the id of its case (docs/theory.md, Verification cases) and what it cost: seconds of wall
    time."""

    id: str
    title: str
    measured: float
    expected: float
    tolerance: float
    passed: bool
    seconds: float

    def record(self) -> dict[str, str | float | bool | None]:
        """Plain values for JSON, which has no nan: such numbers become None."""
        return {
            key: None if isinstance(value, float) and not math.isfinite(value) else value
            for key, value in asdict(self).items()
        }
