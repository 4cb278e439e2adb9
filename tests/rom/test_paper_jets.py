"""The effect of the jet direction, against shapes whose effect is known."""

from __future__ import annotations

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.base.errors import InputError
from billow.reproductions.rom_paper.jets import compare_jets

NAMES = ("one", "other")


class Plane(SyntheticDataset):
    """z = slope(t, node) * jet + something of the other parameters, all affine: the fit is exact."""

    def __init__(self, strength: float, turned: bool = False):
        super().__init__(train=12, test=2, times=6, nodes=90)
        x, y = (self.reference[:, k].astype(float) for k in (0, 1))
        self.field = strength * np.linspace(0.2, 1.0, 6)[:, None] * (y if turned else x)

    def snapshots(self, field, runs):
        low, high = (np.array([getattr(p, side) for p in self.parameters]) for side in ("low", "high"))
        unit = (self.design(runs) - low) / (high - low)
        shape = np.zeros((len(runs), 6, 90, 3))
        shape[..., 2] = 0.1 + unit[:, 2, None, None] * self.field + 0.05 * unit[:, 0, None, None]
        return shape.astype(np.float32)


def test_a_linear_effect_is_found_exactly():
    one, other = Plane(0.2), Plane(0.1)
    found = compare_jets(one, other, NAMES, "jet")
    # Shapes are float32 of 0.2 m, and the plane's weights of 14 runs add up to a few.
    assert found.effect[0] == pytest.approx(one.field, abs=1e-6)
    assert found.effect[1] == pytest.approx(other.field, abs=1e-6)
    assert found.strength[0] == pytest.approx(2.0 * found.strength[1], rel=1e-4)
    assert found.likeness == pytest.approx(np.ones(6), abs=1e-6)
    assert found.strongest == 5
    jet = (one.design(found.runs)[:, 2] - 30.0) / 30.0
    expected = np.abs(jet)[:, None] * np.sqrt(np.square(0.5 * one.field).mean(axis=1))
    assert found.difference == pytest.approx(expected, abs=1e-6)


def test_effects_of_another_shape_are_told_apart():
    found = compare_jets(Plane(0.2), Plane(0.2, turned=True), NAMES, "jet")
    # x and y of nodes spread evenly over a disc are uncorrelated but for the last few nodes.
    assert found.likeness == pytest.approx(np.zeros(6), abs=0.1)


def test_table_figure_and_words_hold_the_numbers():
    found = compare_jets(Plane(0.2), Plane(0.1), NAMES, "jet")
    last = found.table().rows[-1]
    assert last["one [mm]"] == pytest.approx(1e3 * found.strength[0, -1])
    assert "cosine of 1.00" in found.sentences()[0]
    assert len(found.figure().axes) == 2


def changed(**fields):
    """A study like the others, but for some of its fields."""
    dataset = Plane(0.1)
    for name, value in fields.items():
        setattr(dataset, name, value(getattr(dataset, name)))
    return dataset


@pytest.mark.parametrize(
    ("other", "parameter", "why"),
    [
        (Plane(0.1), "no such", "same parameters"),
        (changed(parameters=lambda known: known[:5]), "jet", "same parameters"),
        (SyntheticDataset(train=12, test=2, times=6, nodes=80), "jet", "meshes"),
        (changed(reference=lambda nodes: nodes + np.float32(1e-4)), "jet", "meshes"),
        (SyntheticDataset(train=12, test=2, times=7, nodes=90), "jet", "times"),
        (changed(times=lambda times: 1.01 * times), "jet", "times"),
        (SyntheticDataset(train=3, test=2, times=6, nodes=90), "jet", "5 runs in common"),
        (changed(train=lambda runs: runs[:5]), "jet", "7 runs in common, and 6 parameters need 8"),
        (changed(_design=lambda rows: {run: row + 1e-3 for run, row in rows.items()}), "jet", "different designs"),
    ],
)
def test_studies_that_do_not_belong_together(other, parameter, why):
    with pytest.raises(InputError) as raised:
        compare_jets(Plane(0.2), other, NAMES, parameter)
    assert raised.value.code == "E-ROM-022"
    assert why in raised.value.why


def test_the_fewest_runs_that_hold_a_plane_are_enough():
    # Six parameters and a constant leave one run of eight over; unseen runs count like the others.
    one, other = Plane(0.2), changed(train=lambda runs: runs[:6])
    found = compare_jets(one, other, NAMES, "jet")
    assert found.runs == (*one.train[:6], *one.test)
    # Eight designs at random: the weights of the plane may add up to ten and more, of float32 rounding 2e-8 m.
    assert found.effect[1] == pytest.approx(other.field, abs=1e-5)
