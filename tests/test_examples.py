"""Every example loads, and runs: on a coarse mesh, until its obstacle has felt the bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from billow.case.schema import Case
from billow.run.simulate import simulate

FOLDER = Path(__file__).parents[1] / "examples"
FOLDED = FOLDER / "driver_folded.toml"
FLAT = sorted(set(FOLDER.glob("*.toml")) - {FOLDED})


def test_there_are_examples():
    assert len(FLAT) >= 2


@pytest.mark.parametrize("path", FLAT, ids=lambda path: path.stem)
def test_an_example_runs(deploy, path, tmp_path):
    case = Case.load(path)
    coarse = {"bag.element_size": 0.05, "run.end_time": 0.03, "run.frames": 3, "run.histories_per_frame": 100}
    result = deploy(case.vary(coarse), tmp_path / "run")
    assert result.status == "completed"
    assert result.ledger["gas_mass_error"] <= 1e-12
    assert result.ledger["gas_energy_error"] <= 1e-12
    assert result.ledger["energy_residual_of_injected"] <= 0.02
    curves = result.histories
    pushed = curves["impactor_force_z [N]"]
    assert pushed[0] == 0.0
    assert pushed.max() > 50.0
    assert 0.03 < curves["volume [m^3]"][-1] < 0.08
    free = next(o for o in case.obstacles if o.name == "impactor" and not o.locked) if "free" in path.stem else None
    if free:
        # Newton: the impulse it got is its mass times its velocity. Rows are near enough to sum the force.
        impulse = np.trapezoid(pushed, curves["time [s]"])
        speed = curves["impactor_velocity_z [m/s]"][-1]
        assert speed > 0.1
        assert free.mass * speed == pytest.approx(impulse, rel=0.05)


def test_the_folded_example_opens_and_nothing_passes_through_anything(tmp_path):
    """Elements of 25 mm, until the obstacle has felt the bag; stopping and resuming layers has tests of its own."""
    coarse = {"bag.element_size": 0.025, "run.end_time": 0.0065, "run.frames": 5}
    result = simulate(Case.load(FOLDED).vary(coarse), tmp_path / "run")
    assert result.status == "completed"
    assert result.ledger["crossings_at_worst"] == 0.0
    assert result.ledger["gas_mass_error"] <= 1e-12
    assert result.ledger["energy_residual_of_largest"] <= 0.01
    assert result.histories["impactor_force_z [N]"].max() > 50.0
    assert result.histories["volume [m^3]"][-1] > 0.01
