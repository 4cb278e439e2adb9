"""Several goals at once: the front of a problem whose front is known."""

from dataclasses import replace

import numpy as np
import pytest

from billow.design.optimum import pareto
from billow.design.surface import Surface, Verdict
from billow.design.surfaces import ResponseSurfaces
from billow.design.table import ResponseTable
from billow.results.dataset_files import Parameter
from billow.study.responses import StudyResponse

pytest.importorskip("pymoo", reason="several goals need the extra billow[design]")


@pytest.fixture(scope="module")
def surfaces():
    """f = a^2 + b^2 and g = (a - 1)^2 + b^2: best for b = 0, where the roots of f and g add up to 1."""
    designs = np.random.default_rng(0).uniform([0.0, -0.5], [1.0, 0.5], (60, 2))
    values = np.column_stack([(designs**2).sum(axis=1), ((designs - [1.0, 0.0]) ** 2).sum(axis=1)])
    parameters = Parameter("a", "a", "m", 0.0, 1.0), Parameter("b", "b", "m", -0.5, 0.5)
    tables = ({"name": name, "measure": "final", "quantity": "volume", "scale": "identity"} for name in "fg")
    runs = tuple(f"{k:04d}" for k in range(60))
    responses = tuple(map(StudyResponse.model_validate, tables))
    table = ResponseTable("Two goals", parameters, responses, ("-", "-"), runs, 0, designs, values, {})
    return ResponseSurfaces.learn(table)


def test_the_front_is_the_known_one(surfaces):
    designs, found = pareto(surfaces, ("f", "g"), seed=0)
    roots = np.sqrt(np.maximum(found, 0.0)).sum(axis=1)
    assert roots == pytest.approx(np.ones(len(roots)), abs=0.02)
    assert np.abs(designs[:, 1]).max() < 0.1  # b^2 / 2a (1 - a), by which the sum exceeds 1, is below 0.02
    assert found[0, 0] < 0.01  # it reaches
    assert found[-1, 1] < 0.01  # both ends
    assert np.diff(designs[:, 0]).max() < 0.1  # without a gap
    better = (found[:, None] <= found[None]).all(axis=2) & (found[:, None] < found[None]).any(axis=2)
    assert not better.any()


def test_a_limit_cuts_the_front_and_the_same_seed_gives_the_same_bits(surfaces):
    designs, found = pareto(surfaces, ("f", "g"), seed=1, below={"g": 0.25})
    again = pareto(surfaces, ("f", "g"), seed=1, below={"g": 0.25})
    assert designs[:, 0].min() == pytest.approx(0.5, abs=0.03)
    assert np.array_equal(designs, again[0])
    assert np.array_equal(found, again[1])


def test_goals_that_agree_have_a_front_of_one_design(surfaces):
    designs, found = pareto(surfaces, ("f", "f"))
    assert designs.shape == (1, 2)
    assert found.shape == (1, 2)
    assert designs[0] == pytest.approx([0.0, 0.0], abs=0.02)


class Exact(Surface):
    """Of a function that a surface knows without error; process: that function."""

    def value(self, points):
        return self.process(points)


def volume(found, corner):
    """Area between a front (designs, 2) in rising order of its first goal and a corner beyond it."""
    kept = found[(found < corner).all(axis=1)]
    kept = kept[np.lexsort(kept.T[::-1])]
    lowest = np.minimum.accumulate(kept[:, 1])
    right = np.append(kept[1:, 0], corner)
    return float(((right - kept[:, 0]) * (corner - lowest)).sum())


def test_the_front_of_zdt1_covers_its_hypervolume(surfaces, monkeypatch):
    """Zitzler, Deb and Thiele (2000), of six variables: f2 = 1 - sqrt(f1) on the front."""

    def first(unit):
        return unit[:, 0]

    def second(unit):
        g = 1.0 + 9.0 * unit[:, 1:].mean(axis=1)
        return g * (1.0 - np.sqrt(unit[:, 0] / g))

    verdict = Verdict("usable", "", 1.0, 0.0, 60)
    known = tuple(Exact(f, "identity", np.ones(4), verdict, np.empty((0, 2))) for f in (first, second))
    six = tuple(Parameter(f"p{k}", f"p{k}", "-", 0.0, 1.0) for k in range(6))
    designs = np.random.default_rng(0).random((60, 6))
    exact = replace(surfaces, surfaces=known, parameters=six, designs=designs)
    monkeypatch.setattr(ResponseSurfaces, "beyond", lambda self, unit: np.zeros(len(unit)))
    for seed in range(3):
        _, found = pareto(exact, ("f", "g"), seed=seed)
        assert volume(found, 1.1) == pytest.approx(0.1 + 2.0 / 3.0 + 0.11, rel=0.02)
