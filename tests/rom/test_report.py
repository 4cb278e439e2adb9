"""The report: self-contained, true to the numbers, and honest when they are bad."""

from __future__ import annotations

import dataclasses
import re
import sys

import numpy as np
import pytest
from synthetic import SyntheticDataset

from billow.base.errors import ResourceError
from billow.cli.demo import run_demo
from billow.pictures.section import cut
from billow.results.floor_file import Floor
from billow.results.obstacles import outline
from billow.rom.judge import figures
from billow.rom.judge.effects import effects
from billow.rom.judge.errors import fit_learning_curve
from billow.rom.judge.evaluate import evaluate
from billow.rom.judge.figures import MIDDLE
from billow.rom.judge.findings import acceptance, verdict, weaknesses
from billow.rom.judge.report import metrics, page, write_report
from billow.rom.judge.unseen import UnseenRuns
from billow.rom.learn.train import Recipe, train


@pytest.fixture(scope="module")
def evaluation(dataset, surrogate):
    return evaluate(dataset, surrogate, sizes=(4, 8), modes=(1, 4, 8))


def test_report_holds_everything_it_shows(dataset, surrogate, evaluation, tmp_path):
    text = write_report(dataset, evaluation, tmp_path / "report").read_text(encoding="utf-8")
    names = sorted(path.stem for path in (tmp_path / "report" / "figures").iterdir())
    assert names == [
        "effects",
        "error-against-modes",
        "error-against-time",
        "error-distribution",
        "evaluation-time",
        "sections-typical",
        "sections-worst",
        "singular-values",
    ]
    assert text.count('src="data:image/svg+xml;base64,') == len(names)
    assert not re.search(r'(src|href)="(?!data:|#)', text)
    assert f"{evaluation.summary('surrogate', 2).mean * 1e3:.3g} mm" in text
    assert (tmp_path / "report" / "metrics.json").is_file()
    assert "36 of 36" in text  # all ledgers of training and unseen runs within their limits


def test_the_strongest_parameter_comes_first(surrogate):
    found = effects(surrogate)
    assert len(found) == len(surrogate.parameters)
    assert [effect.moved for effect in found] == sorted((effect.moved for effect in found), reverse=True)
    middle = [0.5 * (p.low + p.high) for p in surrogate.parameters]
    ends = np.array([middle, middle])
    first = next(k for k, p in enumerate(surrogate.parameters) if p.label == found[0].label)
    ends[:, first] = surrogate.parameters[first].low, surrogate.parameters[first].high
    low, high = surrogate.predict(ends)
    assert found[0].moved == pytest.approx(np.sqrt(np.square(high - low).sum(axis=2).mean()), rel=1e-5)


def test_page_without_sweep_and_without_records(evaluation):
    bare = dataclasses.replace(evaluation, sweep=(), ledgers={})
    assert figures.draw(figures.evaluation_time, {30: 125.0}, 4.0, 1e-3, 30).startswith(b"<?xml")
    text = page(bare, {})
    assert "came without balances" in text
    assert "Figure 4" not in text


def test_runs_made_elsewhere_may_know_no_times_and_move_in_one_direction_only(tmp_path):
    dataset = SyntheticDataset(train=8, test=2, times=5, nodes=60)
    real = dataset.snapshots
    dataset.snapshots = lambda field, runs: real(field, runs) * np.array([0, 0, 1], np.float32)
    dataset.computing_seconds = lambda runs: np.zeros(len(runs))
    surrogate = train(dataset, Recipe(modes=2, epochs=2))
    evaluation = evaluate(dataset, surrogate, sizes=(4, 8), modes=(1, 2))
    text = write_report(dataset, evaluation, tmp_path / "report").read_text(encoding="utf-8")
    assert "how long the runs took is not known" in text
    assert "faster than the solver" not in text
    assert "In x the surrogate does not beat" not in text


def test_a_lost_comparison_is_said_first(evaluation):
    worse = evaluation.errors | {"surrogate": 1.5 * evaluation.errors["nearest run"]}
    lost = dataclasses.replace(evaluation, errors=worse)
    assert acceptance(evaluation).startswith("Accepted")
    assert acceptance(lost).startswith("Not accepted")
    assert "the nearest run (" in acceptance(lost)
    assert any("ABOVE" in sentence for sentence in verdict(lost))
    assert "does not beat" in weaknesses(lost)[0]
    assert not any("does not beat" in sentence for sentence in weaknesses(evaluation))


def test_a_loss_is_said_as_people_say_it(evaluation):
    worse = evaluation.errors | {"surrogate": 1.1 * evaluation.errors["nearest run"]}
    text = page(dataclasses.replace(evaluation, errors=worse), {})
    assert "10 % more" in text
    assert not re.search(r">-\d+ %", text)


@pytest.mark.parametrize(
    ("runs", "errors", "said"),
    [
        ((2, 4, 8), (3.0, 2.0, 1.5), "So few runs do not show"),
        ((10, 20, 40), (4e-3, 3e-3, 2.25e-3), "with every doubling it fell by 25 %. If this continues"),
        ((10, 20, 40), (4e-3, 3.9e-3, 3.8e-3), "More runs would help little"),
        ((10, 20, 40), (4e-3, 4.1e-3, 4.2e-3), "more runs did not lower it"),
    ],
)
def test_what_more_runs_would_bring_is_said_when_the_runs_show_it(evaluation, monkeypatch, runs, errors, said):
    curve = fit_learning_curve(runs, errors)
    monkeypatch.setattr(type(evaluation), "learning_curve", lambda self, component: curve)
    assert any(said in sentence for sentence in weaknesses(evaluation))


def test_the_error_is_said_in_floors(evaluation):
    times = evaluation.surrogate.times
    floor = Floor({"run.dt_scale": "0.99"}, ("0003",), times, np.full((1, len(times), 3), 1e-4))
    z = evaluation.summary("surrogate", 2).mean
    found = dataclasses.replace(evaluation, floor=floor)
    assert any(f"The error is {z / 1e-4:.1f} floors" in sentence for sentence in verdict(found))
    assert metrics(found)["floor"]["error_over_floor"]["z"] == pytest.approx(z / 1e-4)
    assert metrics(evaluation)["floor"] is None


def test_the_demo_asks_for_pytorch_before_it_simulates(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "billow.rom.learn.network", None)
    monkeypatch.delattr("billow.rom.learn.network", raising=False)
    with pytest.raises(ResourceError, match=r"E-ROM-006(?s:.*)billow\[train\]"):
        run_demo(tmp_path / "demo", 4, 2, 1, None)
    assert not (tmp_path / "demo").exists()


def test_a_bad_ledger_is_shown_as_bad(evaluation):
    ledgers = evaluation.ledgers | {"0007": evaluation.ledgers["0007"] | {"gas_mass_error": np.nan}}
    text = page(dataclasses.replace(evaluation, ledgers=ledgers), {})
    assert "35 of 36" in text
    assert re.search(r'class="worse">inf</td><td>0007', text)


def test_worst_run_is_named_and_a_cause_only_when_shown(evaluation):
    errors = 1e-3 * np.broadcast_to(np.linspace(1.0, 3.0, 12)[:, None, None], (12, 4, 3))
    design = np.random.default_rng(0).random((12, 6))

    def told():
        doctored = dataclasses.replace(
            evaluation,
            errors=dict.fromkeys(evaluation.errors, errors),
            spread=errors,
            unseen=UnseenRuns(tuple("abcdefghijkl"), {}, {}),
            design=design,
        )
        return next(sentence for sentence in weaknesses(doctored) if sentence.startswith("The worst unseen run"))

    assert "unseen run is l " in told()
    assert "do not show a single parameter" in told()
    design[:, 3] = np.linspace(1.0, 0.0, 12)
    assert "Errors are larger where Impactor radius is low" in told()


def test_section_of_a_box_is_its_rectangle():
    # A box of 2 x 2 x 1 m whose side nodes lie exactly on the plane y = 0: the hard case for a plane cut.
    points = np.array([(x, y, z) for x in (-1, 1) for y in (-1, 0, 1) for z in (0, 1)], float)
    index = {tuple(point): k for k, point in enumerate(points)}
    quads = [[(x, y, 0), (x, y + 1, 0), (x, y + 1, 1), (x, y, 1)] for x in (-1, 1) for y in (-1, 0)]
    quads += [[(-1, y, z), (1, y, z), (1, y + 1, z), (-1, y + 1, z)] for z in (0, 1) for y in (-1, 0)]
    quads += [[(-1, y, 0), (1, y, 0), (1, y, 1), (-1, y, 1)] for y in (-1, 1)]
    corners = np.array([[index[corner] for corner in quad] for quad in quads])
    segments, _ = cut(points, np.vstack([corners[:, [0, 1, 2]], corners[:, [0, 2, 3]]]), MIDDLE)
    segments = segments[..., [0, 2]]
    assert np.linalg.norm(segments[:, 1] - segments[:, 0], axis=1).sum() == pytest.approx(2 * (2 + 1))
    ends, count = np.unique(segments.reshape(-1, 2).round(9), axis=0, return_counts=True)
    assert (count[(np.abs(ends[:, 0]) == 1) & (ends[:, 1] % 1 == 0)] % 2 == 0).all()  # closed: corners join two lines


def test_section_of_a_slanted_triangle():
    points = np.array([(0.0, -1.0, 0.0), (2.0, 3.0, 4.0), (4.0, 1.0, 0.0)])
    (segment,), _ = cut(points, np.array([[0, 1, 2]]), MIDDLE)
    assert sorted(map(tuple, segment)) == [(0.5, 0.0, 1.0), (2.0, 0.0, 0.0)]
    assert len(cut(points + np.array([0.0, 5.0, 0.0]), np.array([[0, 1, 2]]), MIDDLE)[0]) == 0


def test_obstacle_outline_follows_radii_degree_and_rotation():
    cosine, sine = 0.8, 0.6
    turned = np.array([[cosine, 0.0, sine], [0.0, 1.0, 0.0], [-sine, 0.0, cosine]])  # body to space
    shape = {"kind": "super-ellipsoid", "radii": [0.1, 0.2, 0.3], "degree": 4.0}
    obstacle = shape | {"center": [1.0, 0.0, 2.0], "rotation": turned}
    body_x, body_z = 1.5 * 0.1, 0.5 * 0.3
    x = 1.0 + cosine * body_x + sine * body_z
    z = 2.0 - sine * body_x + cosine * body_z
    assert outline(obstacle, np.array([[x, 0.0, z]]))[0] == pytest.approx(1.5**4 + 0.5**4 - 1.0)
    end = turned @ [0.0, 0.0, 0.3]
    assert outline(obstacle, np.array([[1.0, 0.0, 2.0]]) + end)[0] == pytest.approx(0.0, abs=1e-12)
