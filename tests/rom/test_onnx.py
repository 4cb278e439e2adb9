"""The exported graph answers as NumPy does."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from billow.base.errors import InputError, NumericalStop
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate import onnx_export
from billow.rom.surrogate.onnx_export import export_onnx, largest_difference, onnx_bytes

onnx = pytest.importorskip("onnx", reason="export needs onnx: pip install -e '.[export]'")
runtime = pytest.importorskip("onnxruntime", reason="export needs onnxruntime: pip install -e '.[export]'")


@pytest.fixture(scope="module")
def paper(dataset):
    return train(dataset, Recipe("paper", modes=2, epochs=20), runs=dataset.train[:10])


@pytest.mark.parametrize("recipe", ["shared", "paper"])
def test_answers_agree_to_1e_5(recipe, request, dataset):
    model = request.getfixturevalue("surrogate" if recipe == "shared" else "paper")
    content = onnx_bytes(model)
    assert largest_difference(content, model, dataset.design(dataset.test)) < 1e-5
    session = runtime.InferenceSession(content)
    designs = dataset.design(dataset.test)
    (many,) = session.run(None, {"design": designs})  # several designs at once
    assert many.shape == (6, 20, 800, 3)
    np.testing.assert_allclose(many, model.predict(designs), atol=1e-5 * np.abs(many).max())


def test_the_file_says_what_it_takes(surrogate, tmp_path):
    path = tmp_path / "s.onnx"
    assert export_onnx(surrogate, path) < 1e-5
    model = onnx.load(path)
    told = {entry.key: entry.value for entry in model.metadata_props}
    assert [p["name"] for p in json.loads(told["parameters"])] == [p.name for p in surrogate.parameters]
    assert json.loads(told["times_s"]) == surrogate.times.tolist()
    assert [i.name for i in model.graph.input] == ["design"]
    assert [o.name for o in model.graph.output] == ["displacement"]


def test_a_difference_is_noticed_and_nothing_written(surrogate, tmp_path, monkeypatch):
    bent = dataclasses.replace(surrogate, bases=(surrogate.bases[1], *surrogate.bases[1:]))
    monkeypatch.setattr(onnx_export, "onnx_bytes", lambda model: onnx_bytes(bent))
    with pytest.raises(NumericalStop, match="E-ROM-020"):
        export_onnx(surrogate, tmp_path / "s.onnx")
    assert list(tmp_path.iterdir()) == []


def test_force_inputs_cannot_be_exported(surrogate):
    with pytest.raises(InputError, match="E-ROM-019"):
        onnx_bytes(dataclasses.replace(surrogate, forces=object()))
