"""What `billow predict` says of an answer beside the answer: where the design stands, and how far it may be off."""

from __future__ import annotations

import json
from dataclasses import replace

import h5py
import numpy as np
import pytest
from synthetic import PARAMETERS, SyntheticDataset

from billow.base.errors import IntegrityError
from billow.results.dataset_files import MeshParts
from billow.results.vtkhdf import FabricFile
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.prediction import write_prediction
from billow.rom.surrogate.surrogate import Surrogate


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


def test_a_predicted_file_has_the_parts_of_the_runs(calibrated, tmp_path):
    """They go from the dataset into the surrogate and its file, and from there into answers."""

    class WithParts(SyntheticDataset):
        @property
        def parts(self):
            return MeshParts(np.arange(len(self.triangles)) % 2, ("front", "vent_1"))

    learned = train(WithParts(train=4, test=1, times=4, nodes=60), Recipe(modes=2, epochs=1, calibrate=False))
    kept = Surrogate.load(learned.save(tmp_path / "surrogate.safetensors"))
    write_prediction(kept, design(0.5), tmp_path / "shape.vtkhdf", False)
    fabric = FabricFile(tmp_path / "shape.vtkhdf")
    assert fabric.part_names == ["front", "vent_1"]
    np.testing.assert_array_equal(fabric.part, np.arange(len(fabric.triangles)) % 2)
    write_prediction(calibrated, design(0.5), tmp_path / "old.vtkhdf", False)
    assert FabricFile(tmp_path / "old.vtkhdf").part_names == ["fabric"]
    wrong = replace(learned, parts=MeshParts(learned.parts.part + 1, ("front", "vent_1")))
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(wrong.save(tmp_path / "wrong.safetensors"))


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
