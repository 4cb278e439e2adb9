"""The energy balance of a run can be recomputed from histories.csv by whoever reads it."""

from __future__ import annotations

import numpy as np
import pytest

from billow.case.schema import Case

FOLDED = {
    "bag": {"element_size": 0.06, "straps": {"length": "start"}},
    "fabric": {"self_contact": True, "law": "curves-shear"},
    "obstacles": [
        {"shape": "plate"},
        {"shape": "super-ellipsoid", "clearance": 0.02, "locked": False, "velocity": [0.0, 0.0, -8.0]},
    ],
    "run": {"end_time": 0.012, "frames": 2, "histories_per_frame": 6, "gravity": [0.0, 0.0, -9.81]},
}
MOTION = ("kinetic", "body_kinetic")
STORED = ("strain", "strap", "contact", "self_contact")
LOST = ("damping", "hysteresis", "friction")
RECEIVED = ("gas_work", "gravity_work")


@pytest.fixture(scope="module")
def run(deploy, tmp_path_factory):
    """Layers in contact, hysteresis, a free body, gravity: every account is used."""
    return deploy(Case.from_dict(FOLDED), tmp_path_factory.mktemp("folded") / "run")


def test_the_residual_follows_from_the_columns_of_energy(run):
    h = run.histories
    assert all(h[f"{name} [J]"].any() for name in (*MOTION, *STORED, *LOST, *RECEIVED))
    there = sum(h[f"{name} [J]"] for name in (*MOTION, *STORED, *LOST))
    received = sum(h[f"{name} [J]"] for name in RECEIVED)
    start = sum(h[f"{name} [J]"][0] for name in (*MOTION, *STORED))
    residual = there - start - received
    np.testing.assert_allclose(residual, h["energy_residual [J]"], atol=1e-12 * np.abs(there).max())
    assert run.ledger["energy_residual_joule"] == h["energy_residual [J]"][-1]


def test_self_contact_counts_as_internal_energy_and_is_judged(run):
    """Its springs hold energy like any others; a run in which they hold much of it is not to be trusted."""
    h, criteria = run.histories, {line["name"]: line for line in run.record["quality"]["criteria"]}
    stored = sum(h[f"{name} [J]"] for name in STORED)
    assert run.ledger["largest_internal_energy_joule"] == pytest.approx(stored.max(), rel=1e-12)
    share = h["self_contact [J]"].max() / stored.max()
    line = criteria["penalty energy of self-contact, of peak internal"]
    assert line["measured"] == pytest.approx(100.0 * share, rel=1e-9)
    assert (line["passes"], line["fails"]) == (5.0, 20.0)
