"""The verdict of a run, criterion by criterion."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.quality import judge

HISTORIES = {
    name: np.zeros(2) for name in ("strain [J]", "strap [J]", "contact [J]", "pressure [Pa]")
} | {"time [s]": np.array([0.0, 0.05])}  # fmt: skip
BOOKS = dict.fromkeys(
    (
        "energy_residual_of_largest", "energy_gain_of_largest", "gas_mass_error", "gas_energy_error", "shooting_nodes",
        "inverted_elements", "plausibility_warnings",
    ),
    0.0,
)  # fmt: skip


@pytest.mark.parametrize(
    ("escaped", "verdict"), [(0, "PASS"), (1, "PASS"), (10, "PASS"), (11, "REVIEW"), (1000, "FAIL")]
)
def test_few_particles_outside_are_no_fault_and_many_are(escaped, verdict):
    """Of 100,000: up to one in 10,000 no book and no curve notices, one in a hundred means broken walls."""
    criteria = judge(HISTORIES, BOOKS | {"leaked_particles_share": escaped / 100_000}, {}, 0.05)
    (found,) = (c for c in criteria if "particles" in c.name)
    assert found.verdict == verdict
    assert {c.verdict for c in criteria if c is not found} == {"PASS"}
