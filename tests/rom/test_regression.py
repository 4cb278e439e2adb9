"""Evaluation of the networks against their definition: all inputs side by side, layer by layer, in float64."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.rom.surrogate.regression import InputScaling, OutputScaling, Regression

TIMES = np.linspace(1e-3, 5e-2, 7)
OUTPUTS = 6

ACTIVATIONS = {"shared": lambda x: x / (1.0 + np.exp(-x)), "paper": np.tanh}


def regression(recipe: str, parameters: int, further: int, random) -> Regression:
    inputs = InputScaling(np.zeros(parameters), np.arange(1.0, parameters + 1), TIMES[0], TIMES[-1], recipe, further)
    networks, last = (3, OUTPUTS) if recipe == "shared" else (OUTPUTS, 1)
    sizes = (inputs.width, 8, 5, last)

    def values(*shape):
        return random.standard_normal(shape).astype(np.float32)

    layers = list(itertools.pairwise(sizes))
    weights = tuple(values(networks, rows, columns) for rows, columns in layers)
    biases = tuple(values(networks, 1, columns) for _, columns in layers)
    scale = OutputScaling(TIMES, values(len(TIMES), OUTPUTS), 1.0 + np.abs(values(len(TIMES), OUTPUTS)))
    return Regression(recipe, weights, biases, inputs, scale)


def by_definition(model: Regression, design, times, further) -> np.ndarray:
    """(members, runs, times, outputs)."""
    layer = model.inputs(design, times, further).astype(float)
    for weight, bias in zip(model.weights[:-1], model.biases[:-1], strict=True):
        layer = ACTIVATIONS[model.recipe](layer @ weight + bias)
    answer = layer @ model.weights[-1] + model.biases[-1]  # (networks, runs * times, outputs)
    if model.recipe == "paper":
        answer = answer.transpose(2, 1, 0)
    mean, deviation = model.outputs.at(times)
    return answer.reshape(len(answer), len(design), len(times), OUTPUTS) * deviation + mean


@pytest.mark.parametrize("recipe", ["shared", "paper"])
@pytest.mark.parametrize("times", [TIMES, TIMES[2:5] + 1e-3], ids=["trained times", "times between"])
@given(seed=st.integers(0, 2**32 - 1), runs=st.integers(1, 4), parameters=st.integers(1, 5), further=st.integers(0, 3))
def test_the_answer_is_that_of_the_networks(recipe, times, seed, runs, parameters, further):
    random = np.random.default_rng(seed)
    model = regression(recipe, parameters, further, random)
    design = random.random((runs, parameters)) * np.arange(1.0, parameters + 1)
    others = random.random((runs, len(times), further)) if further else None
    expected = by_definition(model, design, times, others)
    # float32 against float64: three layers of sums of at most 22 terms of order one.
    tolerance = {"rtol": 1e-4, "atol": 1e-4}
    np.testing.assert_allclose(model.by_member(design, times, others), expected, **tolerance)
    np.testing.assert_allclose(model(design, times, others), expected.mean(axis=0), **tolerance)


def test_sums_beyond_the_reach_of_exp_saturate():
    random = np.random.default_rng(3)
    model = regression("shared", 2, 0, random)
    model = replace(model, weights=(300.0 * model.weights[0], *model.weights[1:]))  # first sums of some hundred
    design = np.array([[0.1, 1.9], [0.9, 0.2]])
    with np.errstate(over="ignore"):
        expected = by_definition(model, design, TIMES, None)
    np.testing.assert_allclose(model.by_member(design, TIMES), expected, rtol=1e-4, atol=1e-4 * np.abs(expected).max())
