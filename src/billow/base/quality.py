"""Whether a run can be trusted: PASS, REVIEW or FAIL for each criterion; parts and solver say by which.

Thresholds and their sources: docs/quality.md. A run is as good as its worst criterion.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass

import numpy as np

VERDICTS = ("PASS", "REVIEW", "FAIL")

SHORT = "time missing to 1.2 times the pressure peak"
"""The criterion that says where a run ends, and nothing against what it holds until then."""


@dataclass(frozen=True)
class Criterion:
    """One line of the verdict: measured value, largest value that passes, value from which it fails, in `unit`; remedy:
    what to try if it does not pass."""

    name: str
    measured: float
    passes: float
    fails: float
    unit: str
    verdict: str
    remedy: str

    @property
    def line(self) -> str:
        """For the log, if it does not pass."""
        measured = f"{self.name} = {self.measured:.4g} {self.unit} (passes up to {self.passes:g})"
        return f"{self.verdict}: {measured}; try: {self.remedy}"

    def record(self) -> dict:
        """Plain dictionary, for run.json."""
        return asdict(self)


def overall(criteria: list[Criterion]) -> str:
    """The worst verdict."""
    return max((c.verdict for c in criteria), key=VERDICTS.index, default="PASS")


def doubts(quality: Mapping) -> tuple[str, ...]:
    """Names of the criteria that a run did not pass. quality: of its run.json; empty where it carries no verdict."""
    return tuple(line["name"] for line in quality.get("criteria", ()) if line["verdict"] != "PASS")


SMALLER_STEPS = "a smaller run.dt_scale; 0.5 is often enough"
"""What helps against most errors of a run."""


def criterion(name: str, measured: float, passes: float, fails: float, unit: str, remedy: str) -> Criterion:
    """PASS up to `passes`, FAIL from `fails` on or if not finite, REVIEW between them."""
    verdict = "PASS" if measured <= passes else "FAIL" if measured >= fails else "REVIEW"
    if not np.isfinite(measured):
        verdict = "FAIL"
    return Criterion(name, float(measured), float(passes), float(fails), unit, verdict, remedy)
