"""Examples of packing: a press that keeps its order, and a cover that is sound at the start."""

from __future__ import annotations

from pathlib import Path

import pytest

from billow.case.schema import Case
from billow.run.check import describe
from billow.run.simulate import simulate

FOLDER = Path(__file__).parents[1] / "examples" / "packing"


@pytest.mark.parametrize("path", sorted(FOLDER.glob("*.toml")), ids=lambda path: path.stem)
def test_an_example_of_packing_starts_without_crossings(path):
    assert "crossings 0 of fabric" in str(describe(Case.load(path)))


def test_a_pressed_stack_keeps_the_order_of_its_layers(tmp_path):
    """Elements of 20 mm; the press goes on to its height, and its work is booked."""
    coarse = {"bag.element_size": 0.02, "bag.mouth_radius": 0.03}
    result = simulate(Case.load(FOLDER / "press.toml").vary(coarse), tmp_path / "run")
    assert result.status == "completed"
    assert result.ledger["crossings_at_worst"] == 0.0
    assert result.ledger["energy_residual_of_largest"] < 0.02
    h = result.histories
    assert result.obstacles == {"plate": False, "press": True}
    assert result.free_obstacles == ()  # nothing to be injured
    assert h["press_centre_z [m]"][-1] == pytest.approx(0.005, abs=1e-12)
    assert h["press_force_z [N]"].max() > 1.0
    assert h["drive_work [J]"][-1] == h["press_drive_work [J]"][-1] > 0.0
    # The fabric holds next to nothing: what the cushion holds is judged against the work of the press.
    driven = (h["drive_work [J]"] - h["body_kinetic [J]"]).max()
    assert driven > 2.0 * result.ledger["largest_internal_energy_joule"]
    assert result.ledger["penalty_scale_joule"] == pytest.approx(driven)
    criteria = {line["name"]: line for line in result.record["quality"]["criteria"]}
    cushion = criteria["penalty energy of self-contact, of peak internal"]
    assert cushion["measured"] == pytest.approx(100.0 * h["self_contact [J]"].max() / driven)
    assert cushion["measured"] < 25.0  # 84 % of what is stored
    top = (result.reference + result.displacement[-1])[:, 2].max()
    assert 0.002 < top < 0.0051
