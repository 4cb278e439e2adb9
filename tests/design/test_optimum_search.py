"""The search for an optimum finds the deepest valley of functions with several, and of surfaces of 100 points."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize
from scipy.stats import qmc

from billow.design.optimum import Goal, optimise
from billow.design.surface import Surface, Verdict
from billow.design.surfaces import ResponseSurfaces
from billow.design.table import ResponseTable
from billow.results.dataset_files import Parameter
from billow.study.responses import StudyResponse


def branin(unit):
    x, y = 15.0 * unit[:, 0] - 5.0, 15.0 * unit[:, 1]
    hill = y - 5.1 / (4.0 * np.pi**2) * x**2 + 5.0 / np.pi * x - 6.0
    return hill**2 + 10.0 * (1.0 - 1.0 / (8.0 * np.pi)) * np.cos(x) + 10.0


def hartmann(unit):
    """Hartmann's function of six variables, upside down: its highest hill is 3.32237, the next 3.20316."""
    steep = np.array(
        [[10, 3, 17, 3.5, 1.7, 8], [0.05, 10, 17, 0.1, 8, 14], [3, 3.5, 1.7, 10, 17, 8], [17, 8, 0.05, 10, 0.1, 14]]
    )
    place = 1e-4 * np.array(
        [
            [1312, 1696, 5569, 124, 8283, 5886],
            [2329, 4135, 8307, 3736, 1004, 9991],
            [2348, 1451, 3522, 2883, 3047, 6650],
            [4047, 8828, 8732, 5743, 1091, 381],
        ]
    )
    return np.exp(-(steep * (unit[:, None] - place) ** 2).sum(axis=2)) @ np.array([1.0, 1.2, 3.0, 3.2])


def surfaces_of(function, dimensions: int, seed: int, scale: str) -> ResponseSurfaces:
    """From 100 points; whatever its verdict, the surface is used: it is the search that is tried."""
    points = qmc.LatinHypercube(dimensions, rng=seed).random(100)
    parameters = tuple(Parameter(f"p{k}", f"p{k}", "-", 0.0, 1.0) for k in range(dimensions))
    response = {"name": "f", "measure": "final", "quantity": "volume", "scale": scale}
    responses, runs = (StudyResponse.model_validate(response),), tuple(f"{k:04d}" for k in range(100))
    table = ResponseTable("Known", parameters, responses, ("-",), runs, 0, points, function(points)[:, None], {})
    made = ResponseSurfaces.learn(table)
    only = made.surfaces[0]
    return replace(made, surfaces=(replace(only, verdict=replace(only.verdict, word="indicative")),))


def deepest(surfaces, sign: float) -> float:
    """Least of sign times a surface within reach: local searches from the 40 best of 8,192 points and all runs."""
    surface, count = surfaces.surfaces[0], len(surfaces.parameters)
    points = np.concatenate([qmc.Sobol(count, rng=9).random(8_192), surfaces.designs])
    points = points[surfaces.beyond(points) == 0.0]
    values, best = sign * surface.value(points), np.inf
    for start in points[np.argsort(values)[:40]]:
        found = minimize(lambda x: sign * surface.value(x[None])[0], start, method="L-BFGS-B", bounds=[(0, 1)] * count)
        if surfaces.beyond(found.x[None])[0] == 0.0:
            best = min(best, found.fun)
    return best


@pytest.mark.parametrize("seed", [2, 5])
def test_the_search_finds_the_deepest_valley_of_hartmanns_surface(seed):
    surfaces = surfaces_of(hartmann, 6, seed, "root")
    found = optimise(surfaces, Goal(maximise="f", seed=seed))
    assert -found.responses["f"][0] <= deepest(surfaces, -1.0) + 0.01 * np.ptp(surfaces.values)
    assert (np.diff(found.generations) >= 0.0).all()  # the best so far, over all starts


def test_the_search_finds_the_deepest_valley_of_branins_surface_and_that_is_the_functions():
    surfaces = surfaces_of(branin, 2, 0, "identity")
    found = optimise(surfaces, Goal(minimise="f"))
    assert found.responses["f"][0] <= deepest(surfaces, 1.0) + 0.01 * np.ptp(surfaces.values)
    there = branin(np.array([list(found.design.values())]))[0]
    assert there == pytest.approx(0.397887, abs=0.01 * np.ptp(surfaces.values))


class Exact(Surface):
    """Hartmann's function as if a surface knew it."""

    def value(self, points):
        return hartmann(points)

    def interval(self, points, level=0.9):
        return np.repeat(hartmann(points)[:, None], 3, axis=1)


def test_the_search_finds_the_highest_hill_of_hartmanns_function_with_any_seed(monkeypatch):
    known = Exact(None, "identity", np.ones(4), Verdict("usable", "", 1.0, 0.0, 100), np.empty((0, 2)))
    surfaces = replace(surfaces_of(hartmann, 6, 2, "root"), surfaces=(known,))
    monkeypatch.setattr(ResponseSurfaces, "beyond", lambda self, unit: np.zeros(len(unit)))
    for seed in range(5):
        found = optimise(surfaces, Goal(maximise="f", seed=seed))
        assert found.responses["f"][0] == pytest.approx(3.32237, rel=0.01)
