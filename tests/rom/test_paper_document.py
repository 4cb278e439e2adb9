"""The whole report of the paper's tables and figures, from tiny datasets made by formula."""

from __future__ import annotations

import csv
import json
import re
from dataclasses import replace

import numpy as np
import pytest
from free_synthetic import FreeDataset
from synthetic import SyntheticDataset

from billow.reproductions.rom_paper import document, nested_design
from billow.reproductions.rom_paper.available import Available
from billow.reproductions.rom_paper.case_results import case_results
from billow.reproductions.rom_paper.document import write_document
from billow.reproductions.rom_paper.jets import compare_jets
from billow.reproductions.rom_paper.kept import Kept, fingerprint
from billow.reproductions.rom_paper.published import FREE, LOCKED
from billow.reproductions.rom_paper.tables import accuracy_table, against_modes, against_size
from billow.results.floor_file import Floor
from billow.rom.coupled.coupled_evaluation import TRUE_CONTACT, TRUE_INPUTS
from billow.rom.judge.errors import snapshot_rmse
from billow.rom.judge.timing import break_even
from billow.rom.learn import network
from billow.rom.learn.train import Recipe, train


@pytest.fixture(scope="module")
def small():
    return SyntheticDataset(train=12, test=3, times=8, nodes=120)


def there(dataset, *sizes):
    return Available({size: dataset.train[:size] for size in sizes}, dataset.test, ("A note on what is missing.",))


@pytest.fixture(scope="module", autouse=True)
def quick():
    """Short trainings and coarse pictures: what is tested does not depend on how good the networks are."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(network, "EPOCHS_SHARED", (2, 4))
        patch.setattr(document, "DOTS", 40)
        yield


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("kept")


@pytest.fixture(scope="module")
def locked(small, folder):
    return case_results(LOCKED, small, there(small, 6, 12), Kept(folder), recipe="z", recipe_epochs=30)


def table(out, name):
    return list(csv.DictReader((out / "tables" / f"{name}.csv").open(encoding="utf-8")))


def test_report_holds_the_papers_tables_and_figures(small, locked, tmp_path):
    jets = compare_jets(small, small, ("one", "other"), "jet")
    text = write_document(tmp_path, [locked], jets, ["Test case 2 was not given."]).read_text(encoding="utf-8")
    figures = {path.stem for path in (tmp_path / "figures").glob("*.png")}
    assert {f"locked-figure-{n}" for n in ("4", "5", "6", "7", "11", "11-worst")} <= figures
    assert {"locked-recipes", "locked-truncation", "locked-learning-curve", "jets"} <= figures
    assert text.count('src="data:image/svg+xml;base64,') == len(figures)
    assert not re.search(r'(src|href)="(?!data:)', text)
    names = {path.stem for path in (tmp_path / "tables").glob("*.csv")}
    assert {"locked-table-1", "locked-table-2", "locked-table-3", "locked-recipes", "jets"} <= names
    assert names == set(json.loads((tmp_path / "tables.json").read_text(encoding="utf-8")))
    for sentence in ("A note on what is missing.", "Test case 2 was not given."):
        assert sentence in text
        assert sentence in (tmp_path / "README.md").read_text(encoding="utf-8")
    assert "nan" not in (tmp_path / "tables.json").read_text(encoding="utf-8").lower()
    # Numbers of tables are those of the evaluation.
    row = next(r for r in table(tmp_path, "locked-accuracy") if (r[""], r["answer"]) == ("z", "surrogate"))
    assert float(row["mean [mm]"]) == pytest.approx(1e3 * locked.evaluation.summary("surrogate", 2).mean, rel=1e-5)
    assert float(row["mean of 0.28 m [%]"]) == pytest.approx(float(row["mean [mm]"]) / 2.8, rel=1e-4)
    paper = [r for r in table(tmp_path, "locked-table-3") if r[""] == "paper"]
    assert paper == []  # the paper has no N_DOE of 6 or 12 to stand beside


def test_a_fit_judged_by_coefficients_is_a_surrogate_judged_by_fields(small, locked):
    size = locked.sizes[12]
    surrogate = train(small, Recipe(modes=16, calibrate=False), runs=small.train)
    truth = small.snapshots("displacement", list(small.test))
    errors = snapshot_rmse(surrogate.predict(small.design(small.test)), truth)
    # Float32 coefficients of 0.2 m shapes: 1e-7 of them, and the same networks by the same seed.
    assert size.sweep.rmse[-1] == pytest.approx(errors, rel=1e-3, abs=1e-6)
    assert size.sweep.counts[-1] == 16


def test_pieces_of_another_recipe_do_not_pass_for_ours(small, locked, folder, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("trained again")

    monkeypatch.setattr(nested_design, "train_networks", refuse)
    monkeypatch.setattr("billow.rom.learn.network.HIDDEN_SHARED", (8, 8))
    with pytest.raises(AssertionError, match="trained again"):
        case_results(LOCKED, small, there(small, 6, 12), Kept(folder), recipe="z", recipe_epochs=30)


def test_kept_pieces_are_not_made_again(small, locked, folder, monkeypatch):
    def refuse(*_, **__):
        raise AssertionError("trained again")

    monkeypatch.setattr(nested_design, "train_networks", refuse)
    monkeypatch.setattr("billow.reproductions.rom_paper.case_results.train", refuse)
    again = case_results(LOCKED, small, there(small, 6, 12), Kept(folder), recipe="z", recipe_epochs=30)
    assert np.array_equal(again.sizes[12].sweep.rmse, locked.sizes[12].sweep.rmse)
    assert np.array_equal(again.recipe.rmse, locked.recipe.rmse)
    with monkeypatch.context() as patch:
        patch.setattr(nested_design, "reduce_runs", refuse)  # fits that are all kept need no bases either
        case_results(LOCKED, small, there(small, 6, 12), Kept(folder))
    damaged = next(folder.glob("fit-*.safetensors"))
    damaged.write_bytes(damaged.read_bytes()[:-4])
    with pytest.raises(AssertionError, match="trained again"):
        case_results(LOCKED, small, there(small, 6, 12), Kept(folder))


def test_other_data_and_settings_are_other_pieces(small, folder):
    with_other_runs = SyntheticDataset(train=12, test=3, times=8, nodes=120, seed=2)
    assert fingerprint(small, small.train) != fingerprint(with_other_runs, with_other_runs.train)
    assert fingerprint(small, small.train) != fingerprint(small, small.train[:-1])
    kept = Kept(folder)
    assert kept.path("fit", {"seed": 0}) != kept.path("fit", {"seed": 1})


def test_free_obstacle_adds_the_coupled_model(tmp_path):
    dataset = FreeDataset()
    results = case_results(FREE, dataset, there(dataset, 12), Kept(tmp_path / "kept"))
    text = write_document(tmp_path, [results], None, []).read_text(encoding="utf-8")
    figures = {path.stem for path in (tmp_path / "figures").glob("*.png")}
    assert {f"free-figure-{n}" for n in (7, 8, 9, 10, 12)} | {"free-coupled"} <= figures
    row = next(r for r in table(tmp_path, "free-coupled") if r[""] == "velocity")
    assert float(row["median"]) == pytest.approx(results.coupled_evaluation.median("velocity"), rel=1e-5)
    found = results.coupled_evaluation
    assert float(row["true contact force: worst"]) == pytest.approx(found.worst("velocity", TRUE_CONTACT), rel=1e-5)
    assert float(row["true forces as inputs of the bag: median"]) == pytest.approx(
        found.median("velocity", TRUE_INPUTS), rel=1e-5
    )
    by_run = table(tmp_path, "free-coupled-runs")
    assert [r["run"] for r in by_run] == list(dataset.test)
    assert [float(r["CFC 180: coupled"]) for r in by_run] == pytest.approx(
        found.overall("acceleration CFC 180"), rel=1e-5
    )
    assert "ISO/TS 18571" in text
    assert results.sizes[12].sweep_forces is not None


@pytest.mark.parametrize(("making", "runs"), [(100.0, 12), (99.0, 11), (0.0, 0)])
def test_break_even_is_the_first_deployment_that_pays(making, runs):
    assert break_even(making, 10.0, 1.0) == runs
    assert making + runs * 1.0 <= runs * 10.0
    assert break_even(making, 1.0, 1.0) is None


def test_errors_are_told_in_floors_where_the_floor_was_measured(locked):
    assert "mean over floor [-]" not in accuracy_table(locked).columns
    least = np.array([2e-4, 0.0, 5e-4])
    times = locked.evaluation.surrogate.times
    floor = Floor({"run.dt_scale": "0.99"}, ("0000",), times, np.tile(least, (1, len(times), 1)))
    measured = replace(locked, evaluation=replace(locked.evaluation, floor=floor))
    for made in (accuracy_table(measured), against_size(measured), against_modes(measured)):
        for row in made.rows:
            of = 1e3 * least["xyz".index(row.get("", "z"))]  # the last table is of z alone
            assert row["mean over floor [-]"] == (pytest.approx(row["mean [mm]"] / of) if of else None)
