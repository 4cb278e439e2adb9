"""A published data set: precision, checksums, layout, and the loader on its card."""

import json
import re
import subprocess

import fake_solver
import numpy as np
import pytest

from billow.base.errors import InputError
from billow.design import publish as publishing
from billow.design.publish import publish, rounded
from billow.results.dataset import Dataset


@pytest.fixture
def folder(study):
    study.run(workers=1, runner=fake_solver.simulate)
    return study.folder


def loaded(place, split):
    """What the ten lines on the card say."""
    names = {}
    exec(re.search(r"```python\n(.*?)```", (place / "README.md").read_text(), re.DOTALL)[1], names)
    return names["load"](place, split)


def test_the_loader_of_the_card_gives_the_runs_within_the_stated_precision(folder, tmp_path):
    place, dataset = publish(folder, tmp_path / "open", precision=3e-4), Dataset.open(folder)
    for split, runs in (("train", dataset.train), ("test", dataset.test)):
        parameters, positions = loaded(place, split)
        truth = dataset.reference + dataset.snapshots("displacement", runs)
        assert np.array_equal(parameters, dataset.design(runs))
        assert positions.shape == (len(runs), 3, 4, 3)
        assert np.abs(positions[:, 1:].astype(float) - truth).max() <= 3e-4
        assert (positions[:, 1:] != truth).any()  # it was rounded
    record = json.loads((place / "dataset.json").read_text())
    assert record["times_s"] == [0.0, 0.01, 0.02]
    assert record["content_sha256"] == dataset.content_sha256()
    assert {run: of["split"] for run, of in record["runs"].items()}["0004"] == "test"


@pytest.mark.parametrize("precision", [1e-6, 3e-5, 5e-5, 1e-2])
def test_rounding_keeps_to_the_precision(precision):
    values = np.random.default_rng(0).uniform(-3.0, 3.0, 100_000)
    error = np.abs(rounded(values, precision).astype(float) - values).max()
    assert 0.4 * precision < error <= precision


def test_what_was_copied_can_be_checked(folder, tmp_path):
    place = publish(folder, tmp_path / "open")
    check = ["sha256sum", "--quiet", "-c", "SHA256SUMS"]
    assert subprocess.run(check, cwd=place).returncode == 0
    listed = {line.split("  ")[1] for line in (place / "SHA256SUMS").read_text().splitlines()}
    assert listed == {str(p.relative_to(place)) for p in place.rglob("*") if p.is_file()} - {"SHA256SUMS"}
    (place / "runs.csv").write_text("run\n")
    assert subprocess.run(check, cwd=place, capture_output=True).returncode == 1


def test_the_reader_of_zarr_and_the_layout_of_the_crash_example(folder, tmp_path):
    zarr = pytest.importorskip("zarr", reason="zarr reads what is written here by hand")
    place, dataset = publish(folder, tmp_path / "open"), Dataset.open(folder)
    _, positions = loaded(place, "train")
    stores = sorted((place / "train").iterdir())
    assert [store.name for store in stores] == [f"{run}.zarr" for run in dataset.train]
    for store, truth, design in zip(stores, positions, dataset.design(dataset.train), strict=True):
        group = zarr.open(str(store), mode="r")
        assert np.array_equal(group["mesh_pos"][:], truth)
        assert {tuple(edge) for edge in group["edges"][:].tolist()} == {(0, 1), (0, 2), (0, 3), (1, 2), (2, 3)}
        # whatever else is there and is no connectivity is read as a feature of the nodes
        features = {name for name in group.keys() if name not in ("mesh_pos", "edges")}  # noqa: SIM118
        features -= {name for name in features if name.startswith("mesh_connectivity_")}
        assert features == {"lift", "slope"}
        assert np.array_equal(group["lift"][:], np.full(4, design[0], np.float32))
    features = json.loads((place / "global_features.json").read_text())
    assert features["0000"] == dict(zip(("lift", "slope"), dataset.design(["0000"])[0].tolist(), strict=True))


def test_a_run_in_doubt_is_named_and_left_out(study, tmp_path):
    def doubtful(case, folder, *, threads):
        bad = {"verdict": "REVIEW", "criteria": [{"name": "energy", "verdict": "REVIEW"}]}
        fake_solver.simulate(case, folder, threads=threads, quality=bad if folder.name == "0001" else None)

    study.run(workers=1, runner=doubtful)
    place = publish(study.folder, tmp_path / "open")
    assert not (place / "train" / "0001.zarr").exists()
    card = (place / "README.md").read_text()
    assert "\n\nLeft out:\n\n- 0001: REVIEW" in card
    assert "\n- `end_volume` [l]: final of volume\n" in card
    assert "\n\nAn empty cell" in card


def test_arguments_are_checked_and_nothing_is_left_behind(folder, tmp_path, monkeypatch):
    for wrong in ({"precision": 0.05}, {"precision": float("nan")}, {"licence": "do what you want"}):
        with pytest.raises(InputError) as caught:
            publish(folder, tmp_path / "open", **wrong)
        assert caught.value.code == "E-DES-170"
    monkeypatch.setattr(publishing, "_sums", lambda place: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        publish(folder, tmp_path / "open")
    assert not (tmp_path / "open").exists()
