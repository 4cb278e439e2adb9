"""Whether a run can be trusted: PASS, REVIEW or FAIL for each criterion, from its histories and books.

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
    """One line of the verdict: measured value, largest value that passes, value from which it fails, in `unit`."""

    name: str
    measured: float
    passes: float
    fails: float
    unit: str
    verdict: str

    def record(self) -> dict:
        """Plain dictionary, for run.json."""
        return asdict(self)


def judge(
    histories: Mapping[str, np.ndarray],
    books: Mapping[str, float],
    obstacles: Mapping[str, bool],
    end_time: float,
) -> list[Criterion]:
    """All criteria of a run.

    histories: columns of histories.csv. books: `ledger` of run.json. obstacles: name -> whether it is meant to be
    rigid; the spring of a locked obstacle with a contact characteristic is physics, not penalty. end_time: asked for
    [s].
    """
    internal = histories["strain [J]"] + histories["strap [J]"] + histories["contact [J]"]
    rigid = [histories[f"{name}_contact [J]"] for name, is_rigid in obstacles.items() if is_rigid]
    penalty = float(np.sum(rigid, axis=0).max()) if rigid else 0.0
    peak_internal = max(float(internal.max()), 1e-300)
    time = histories["time [s]"]
    peak = float(time[np.argmax(histories["pressure [Pa]"])])
    reached = float(time[-1])
    return [
        _line("energy residual, of the largest energy", 100 * books["energy_residual_of_largest"], 1.0, 5.0, "%"),
        _line("energy gain, of the largest energy", 100 * books["energy_gain_of_largest"], 1.0, 2.0, "%"),
        _line("penalty energy of rigid contact, of peak internal", 100 * penalty / peak_internal, 5, 10, "%"),
        _line("mass added to fabric", 0.0, 2.0, 5.0, "%"),
        _line("mass error of the gas", books["gas_mass_error"], 1e-12, 1e-9, "-"),
        _line("energy error of the gas", books["gas_energy_error"], 1e-12, 1e-9, "-"),
        _line("shooting nodes", books["shooting_nodes"], 0, 1, "-"),
        _line("inverted elements at the end", books["inverted_elements"], 0, 1, "-"),
        _line("particles found outside, of all", 100 * books["leaked_particles_share"], 0.01, 1.0, "%"),
        _line("plausibility warnings", books["plausibility_warnings"], 0, np.inf, "-"),
        _line("time asked for and not simulated", 1e3 * max(0.0, end_time - reached), 1e-9, 1e-6, "ms"),
        _line(SHORT, 1e3 * max(0.0, 1.2 * peak - reached), 1e-9, np.inf, "ms"),
    ]


def overall(criteria: list[Criterion]) -> str:
    """The worst verdict."""
    return max((c.verdict for c in criteria), key=VERDICTS.index, default="PASS")


def doubts(quality: Mapping) -> tuple[str, ...]:
    """Names of the criteria that a run did not pass. quality: of its run.json; empty where it carries no verdict."""
    return tuple(line["name"] for line in quality.get("criteria", ()) if line["verdict"] != "PASS")


def _line(name: str, measured: float, passes: float, fails: float, unit: str) -> Criterion:
    verdict = "PASS" if measured <= passes else "FAIL" if measured >= fails else "REVIEW"
    if not np.isfinite(measured):
        verdict = "FAIL"
    return Criterion(name, float(measured), float(passes), float(fails), unit, verdict)
