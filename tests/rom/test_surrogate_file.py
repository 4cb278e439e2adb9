"""A saved surrogate: the same answers, no torch, and never a damaged byte."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.base.errors import BillowError, InputError, IntegrityError
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.surrogate import Surrogate

WITHOUT_TORCH = """
import json, sys
class Blocked:
    def find_spec(self, name, path=None, target=None):
        if name.split(".")[0] == "torch":
            raise ImportError("torch is blocked")
sys.meta_path.insert(0, Blocked())
import numpy as np
from billow.base.errors import ResourceError
from billow.rom.surrogate.surrogate import Surrogate
surrogate = Surrogate.load(sys.argv[1])
np.save(sys.argv[2], surrogate.predict([[0.5 * (p.low + p.high) for p in surrogate.parameters]]))
heavy = sorted({"torch", "scipy", "matplotlib", "numba", "h5py", "jinja2"} & set(sys.modules))
class Dataset:
    trusted = ()
from billow.rom.learn.train import train
try:
    train(Dataset())
except ResourceError as error:
    print(json.dumps([heavy, error.code]))
"""


def test_round_trip_gives_the_same_bits(surrogate, saved, dataset):
    loaded = Surrogate.load(saved)
    design = dataset.design(dataset.test)
    assert loaded.predict(design).tobytes() == surrogate.predict(design).tobytes()
    assert loaded.spread(design).tobytes() == surrogate.spread(design).tobytes()
    assert (loaded.parameters, loaded.title, loaded.training) == (
        surrogate.parameters,
        surrogate.title,
        json.loads(json.dumps(surrogate.training)),
    )
    assert np.array_equal(loaded.reference, dataset.reference)
    assert np.array_equal(loaded.triangles, dataset.triangles)


def test_prediction_needs_no_torch(surrogate, saved, tmp_path):
    answer = tmp_path / "answer.npy"
    process = subprocess.run(
        [sys.executable, "-c", WITHOUT_TORCH, str(saved), str(answer)], capture_output=True, text=True, check=True
    )
    assert json.loads(process.stdout) == [[], "E-ROM-006"]
    middle = [[0.5 * (p.low + p.high) for p in surrogate.parameters]]
    assert np.load(answer).tobytes() == surrogate.predict(middle).tobytes()


@pytest.fixture(scope="module")
def small_file(dataset, tmp_path_factory):
    surrogate = train(dataset, Recipe(modes=1, epochs=1), runs=dataset.train[:2])
    return surrogate.save(tmp_path_factory.mktemp("small") / "surrogate.safetensors")


@settings(max_examples=400)
@given(data=st.data())
def test_any_changed_byte_is_refused(small_file, tmp_path_factory, data):
    content = bytearray(small_file.read_bytes())
    # Half of the changes hit the header, where lengths, names, types and the sum itself stand.
    header = 8 + int.from_bytes(content[:8], "little")
    end = data.draw(st.sampled_from([header, len(content)]))
    content[data.draw(st.integers(0, end - 1))] ^= data.draw(st.integers(1, 255))
    damaged = tmp_path_factory.getbasetemp() / "mutated.safetensors"
    damaged.write_bytes(content)
    with pytest.raises(IntegrityError, match=r"E-ROM-004(?s:.*)mutated\.safetensors"):
        Surrogate.load(damaged)


@settings(max_examples=60)
@given(part=st.floats(0.0, 0.9999))
def test_any_cut_file_is_refused(small_file, tmp_path_factory, part):
    content = small_file.read_bytes()
    cut = tmp_path_factory.getbasetemp() / "cut.safetensors"
    cut.write_bytes(content[: int(part * len(content))])
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(cut)


@pytest.mark.parametrize("content", [b"", b"\x80\x04\x95pickle", b"\xff" * 64, b"{}" * 500])
def test_other_files_are_refused(tmp_path, content):
    path = tmp_path / "other.safetensors"
    path.write_bytes(content)
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(path)


def test_absent_file_and_later_format(small_file, tmp_path):
    with pytest.raises(InputError, match="E-ROM-005"):
        Surrogate.load(tmp_path / "absent.safetensors")
    tensors, record = read_tensors(small_file, IntegrityError)
    del record["sha256"]
    later = write_tensors(tmp_path / "later.safetensors", tensors, record | {"format": 3})
    with pytest.raises(InputError, match="format 3"):
        Surrogate.load(later)


@pytest.mark.parametrize(
    "change",
    [
        lambda t, r: t.update(modes=t["modes"][:, :, :-1]),
        lambda t, r: t.update(modes=t["modes"].astype(float)),
        lambda t, r: t.update(triangles=t["triangles"] + 1),
        lambda t, r: t.update(times=t["times"][::-1]),
        lambda t, r: t.update({"weights.1": t["weights.1"][:, :-1]}),
        lambda t, r: t.update({"biases.0": t["biases.0"] * np.nan}),
        lambda t, r: t.pop("energy"),
        lambda t, r: t.pop("weights.4"),
        lambda t, r: r.update(recipe="other"),
        lambda t, r: r["parameters"].pop(),
        lambda t, r: r["parameters"][0].pop("low"),
        lambda t, r: r.pop("training"),
    ],
)
def test_well_formed_files_that_make_no_sense_are_refused(small_file, tmp_path, change):
    tensors, record = read_tensors(small_file, IntegrityError)
    del record["sha256"]
    change(tensors, record)
    path = write_tensors(tmp_path / "senseless.safetensors", tensors, record)
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(path)


def test_failed_save_keeps_the_old_file(surrogate, saved, tmp_path, monkeypatch):
    path = tmp_path / "kept.safetensors"
    path.write_bytes(saved.read_bytes())
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("disk full")))
    with pytest.raises((OSError, BillowError)):
        surrogate.save(path)
    assert path.read_bytes() == saved.read_bytes()
    assert list(tmp_path.iterdir()) == [path]
