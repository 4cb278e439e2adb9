"""Several goals at once: the front of a problem whose front is known."""

import numpy as np
import pytest

from billow.design.optimum import pareto
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
