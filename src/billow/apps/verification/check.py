"""Result of a verification case: a measured number, the expected one, and the tolerance."""

from __future__ import annotations

import math
from dataclasses import dataclass


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
class Check(Measurement):
    """id: of its case (docs/theory.md, Verification cases); seconds: of wall time that it cost."""

    id: str
    seconds: float

    def record(self) -> dict[str, str | float | bool | None]:
        """Plain values for JSON, which has no nan: such numbers become None."""
        names = ("id", "title", "measured", "expected", "tolerance", "passed", "seconds")
        values = {name: getattr(self, name) for name in names}
        return {name: None if isinstance(v, float) and not math.isfinite(v) else v for name, v in values.items()}
