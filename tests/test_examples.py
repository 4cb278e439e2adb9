"""Every example loads, and runs: on a coarse mesh, until its obstacle has felt the bag."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from billow.case.schema import Case

EXAMPLES = sorted((Path(__file__).parents[1] / "examples").glob("*.toml"))


def test_there_are_examples():
    assert len(EXAMPLES) >= 2


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_an_example_runs(deploy, path, tmp_path):
    case = Case.load(path)
    coarse = {"bag.element_size": 0.05, "run.end_time": 0.03, "run.frames": 3}
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
        # Newton: the impulse it got is its mass times its velocity.
        impulse = np.trapezoid(pushed, curves["time [s]"])
        speed = curves["impactor_velocity_z [m/s]"][-1]
        assert speed > 0.1
        assert free.mass * speed == pytest.approx(impulse, rel=0.1)
