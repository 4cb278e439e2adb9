"""What `billow predict` says of an answer beside the answer: where the design stands, and how far it may be off."""

from __future__ import annotations

import json

import h5py
import numpy as np
import pytest
from synthetic import PARAMETERS, SyntheticDataset

from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.prediction import write_prediction


@pytest.fixture(scope="module")
def calibrated():
    return train(SyntheticDataset(train=12, test=1, times=6, nodes=80), Recipe(modes=4, epochs=4)).despite_verdict()


def design(part: float) -> dict:
    return {p.name: p.low + part * (p.high - p.low) for p in PARAMETERS}


def test_answer_says_where_it_stands_and_how_far_it_may_be_off(calibrated, tmp_path):
    out = tmp_path / "shape.vtkhdf"
    text = write_prediction(calibrated, design(0.5), out, extrapolate=False)
    assert "inside the trained ranges" in text
    assert "0 to 40 ms, all trained" in text
    kept = json.loads((tmp_path / "shape.vtkhdf.json").read_text(encoding="utf-8"))
    standing = calibrated.standing(design(0.5))
    assert kept["standing"]["distance_to_nearest_training_design"] == standing.nearest
    widths = calibrated.half_width(design(0.5), level=0.9)
    mean = widths.mean(axis=(0, 1), dtype=float)
    assert list(kept["interval"]["mean_half_width_m"].values()) == pytest.approx(mean.tolist())
    assert f"z ± {1e3 * mean[2]:.2g} mm" in text
    with h5py.File(out) as file:
        stored = file["VTKHDF/PointData/half_width"][:].reshape(widths.shape)
    assert np.array_equal(stored, widths)


def test_a_design_outside_is_warned_of(calibrated):
    text = write_prediction(calibrated, design(1.6), None, extrapolate=True)
    assert "outside the trained ranges" in text
    assert "warning: permeability, temperature" in text
    assert "no support in the data" in text


def test_without_calibration_no_interval_is_claimed(tmp_path):
    bare = train(SyntheticDataset(train=4, test=1, times=4, nodes=60), Recipe(modes=2, epochs=1))
    out = tmp_path / "shape.vtkhdf"
    assert "no interval: the surrogate was not calibrated" in write_prediction(bare, design(0.5), out, False)
    with h5py.File(out) as file:
        assert "half_width" not in file["VTKHDF/PointData"]
    assert json.loads((tmp_path / "shape.vtkhdf.json").read_text(encoding="utf-8"))["interval"] is None
