"""Files with a right checksum and a wrong content are refused at once, with a code, and without a warning of NumPy."""

from __future__ import annotations

import json
import os
import warnings

import numpy as np
import pytest

from billow.base.errors import BillowError, InputError, IntegrityError, NumericalStop
from billow.results import tensor_file
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.surrogate import surrogate_file
from billow.rom.surrogate.surrogate import Surrogate


@pytest.fixture(autouse=True)
def no_warnings():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def forged(path, change, to, monkeypatch):
    """A copy of a file with its content changed, and a checksum that is right."""
    tensors, record = read_tensors(path, IntegrityError)
    del record["sha256"]
    tensors = {name: array.copy() for name, array in tensors.items()}
    change(tensors, record)
    with monkeypatch.context() as patch, np.errstate(all="ignore"):
        patch.setattr(tensor_file.json, "dumps", lambda told, allow_nan=False, _dumps=json.dumps: _dumps(told))
        return write_tensors(to / "forged.safetensors", tensors, record)


def filled(name, value):
    def change(tensors, record):
        tensors[name] = np.full_like(tensors[name], value)

    return change


@pytest.mark.parametrize(
    "change",
    [
        filled("weights.0", 3e38),
        filled("weights.2", np.inf),
        filled("times", -1e300),
        lambda t, r: t.update(times=np.linspace(-1e300, 1e300, len(t["times"]))),
        lambda t, r: t.update(times=np.linspace(0.0, 1e-300, len(t["times"]))),
        lambda t, r: t.update(reference=t["reference"][:0], modes=t["modes"][:, :, :0]),
        lambda t, r: t.update({name: t[name][:0] for name in t if name.startswith(("weights", "biases"))}),
        lambda t, r: t.update(modes=t["modes"][:, :0]),
        lambda t, r: t.update({f"weights.{k}": np.zeros((2, 8, 8), np.float32) for k in range(100)}),
        lambda t, r: r["parameters"][0].update(low=-1e299, high=1e299),
        lambda t, r: r["parameters"][0].update(low=1.0, high=np.nextafter(1.0, 2.0)),
        lambda t, r: r["parameters"][0].update(low=0.0, high=1e-320),
        lambda t, r: r["parameters"][0].update(low=float("nan")),
        lambda t, r: r["parameters"].append(r["parameters"][0]),
        lambda t, r: r["training"].update(epochs=-1),
        lambda t, r: r["training"].update(seed="\x1b[31m"),
        lambda t, r: r["training"].update(runs=[]),
        lambda t, r: r["training"].update(runs=[1, 2]),
        lambda t, r: r["training"].update(pod_seconds=float("inf")),
        lambda t, r: r["training"].pop("mesh_sha256"),
        lambda t, r: r.update(title="two\nlines"),
        lambda t, r: r.update(judgement=[[[]]]),
        lambda t, r: r["judgement"]["comparisons"][0].update(own=float("nan")),
        lambda t, r: r.pop("parameters"),
    ],
)
def test_a_surrogate_that_makes_no_sense_is_refused(saved, tmp_path, monkeypatch, change):
    path = forged(saved, change, tmp_path, monkeypatch)
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(path)


@pytest.fixture(scope="module")
def coupled_file(judged, tmp_path_factory):
    return judged.save(tmp_path_factory.mktemp("coupled") / "coupled.safetensors")


@pytest.mark.parametrize(
    "change",
    [
        filled("coupled.times", 1e300),
        lambda t, r: t.update({"coupled.times": np.cumsum(1.0 + np.arange(len(t["coupled.times"])))}),
        lambda t, r: t.update({"coupled.times": np.arange(200_000) * 1e-4}),
        filled("coupled.state_deviation", 1e-300),
        filled("coupled.injury.factors", -1.0),
        filled("coupled.injury.smallest", 0.0),
        filled("coupled.half_widths", np.nan),
        lambda t, r: t.pop("coupled.injury.inverse"),
        lambda t, r: r["coupled"].update(name=["head"]),
    ],
)
def test_a_coupled_model_that_makes_no_sense_is_refused(coupled_file, tmp_path, monkeypatch, change):
    path = forged(coupled_file, change, tmp_path, monkeypatch)
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Coupled.load(path)


@pytest.mark.parametrize(
    ("code", "change"),
    [
        ("E-ROM-024", filled("coupled.weights.1", 9e14)),
        ("E-ROM-024", filled("coupled.gravity", 1e14)),
        ("E-CPL-008", filled("coupled.affine", -1.0)),
        ("E-CPL-008", filled("coupled.affine", 0.0)),
    ],
)
def test_a_coupled_model_beyond_all_bounds_gives_no_answer(coupled_file, tmp_path, monkeypatch, code, change):
    model = Coupled.load(forged(coupled_file, change, tmp_path, monkeypatch)).despite_verdict()
    with pytest.raises(BillowError, match=code):
        model.answer({"pressure": 17.0, "radius": 0.13})


def test_networks_that_overflow_give_no_answer(saved, tmp_path, monkeypatch):
    path = forged(saved, filled("weights.1", 9e14), tmp_path, monkeypatch)
    surrogate = Surrogate.load(path)
    middle = [0.5 * (p.low + p.high) for p in surrogate.parameters]
    for ask in (surrogate.predict, surrogate.spread, surrogate.half_width):
        with pytest.raises(NumericalStop, match="E-ROM-024"):
            ask(middle)


def test_a_record_nested_without_end_is_refused(saved, tmp_path, monkeypatch):
    text = '{"sha256": "' + "0" * 64 + '", "deep": ' + "[" * 100_000 + "]" * 100_000 + "}"
    monkeypatch.setattr(tensor_file.json, "dumps", lambda *told, **more: text)
    path = write_tensors(tmp_path / "deep.safetensors", {"times": np.zeros(3)}, {})
    with pytest.raises(IntegrityError, match=r"E-ROM-004(?s:.*)nested too deeply"):
        Surrogate.load(path)


@pytest.mark.parametrize("text", ['["{zeros}"]', '"{zeros}"'])
def test_a_record_that_is_no_table_is_refused(tmp_path, monkeypatch, text):
    zeros = '\\"sha256\\": \\"' + "0" * 64 + '\\"'
    monkeypatch.setattr(tensor_file.json, "dumps", lambda *told, **more: f'["a", {{"sha256": "{"0" * 64}"}}]')
    path = write_tensors(tmp_path / "list.safetensors", {"times": np.zeros(3)}, {})
    assert zeros.encode()[:10] in path.read_bytes()
    with pytest.raises(IntegrityError, match=r"E-ROM-004(?s:.*)no table"):
        Surrogate.load(path)


def test_what_is_no_file_or_too_large_is_not_read(saved, tmp_path, monkeypatch):
    os.mkfifo(tmp_path / "pipe")
    for path in (tmp_path / "pipe", "/dev/zero", tmp_path, "no\0path"):
        with pytest.raises(InputError, match="E-ROM-005"):
            Surrogate.load(path)
    monkeypatch.setattr(surrogate_file, "MOST_BYTES", 1000)
    with pytest.raises(InputError, match=r"E-ROM-005(?s:.*)at most 1000 are read"):
        Surrogate.load(saved)


def test_an_answer_that_no_machine_holds_is_refused(saved, tmp_path, monkeypatch):
    monkeypatch.setattr(surrogate_file, "MOST_BYTES", 10**8)

    def long(tensors, record):
        tensors["times"] = np.arange(1.0, 90_000.0)

    with pytest.raises(IntegrityError, match=r"E-ROM-004(?s:.*)an answer would take"):
        Surrogate.load(forged(saved, long, tmp_path, monkeypatch))


@pytest.mark.parametrize("times", [[], [[0.01]], [np.nan], [np.inf], ["soon"], [None], 1e300])
@pytest.mark.parametrize("extrapolate", [False, True])
def test_times_that_are_none_are_refused(surrogate, times, extrapolate):
    middle = [0.5 * (p.low + p.high) for p in surrogate.parameters]
    for ask in (surrogate.predict, surrogate.half_width, surrogate.spread, surrogate.coefficients):
        with pytest.raises(InputError, match="E-ROM-025"):
            ask(middle, times, extrapolate=extrapolate)


def test_times_and_designs_far_outside_get_an_answer_or_a_code(surrogate):
    middle = np.array([0.5 * (p.low + p.high) for p in surrogate.parameters])
    with pytest.raises(InputError, match="E-ROM-003"):
        surrogate.predict(middle, [1.0])
    assert np.isfinite(surrogate.predict(middle, [1.0, -1.0], extrapolate=True)).all()
    for wild in (middle * 1e20, middle * -1e24):
        surrogate.standing(wild)
        with pytest.raises(BillowError, match="E-ROM-024"):
            surrogate.predict(wild, [1e20], extrapolate=True)
    for design in ([], np.zeros((0, 6)), middle * 1e300, middle * np.nan):
        with pytest.raises(InputError, match="E-ROM-001"):
            surrogate.predict(design, extrapolate=True)
