"""Evaluation of trained networks with NumPy alone.

Both recipes are a stack of fully connected networks of equal shape that see the same inputs:

- `shared`: the networks are members of an ensemble, each gives all coefficients; the answer is their mean
- `paper`: each network gives one coefficient; the answer is all of them side by side
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.rom.surrogate.scaling import InputScaling, OutputScaling


def silu(x: np.ndarray) -> np.ndarray:
    """x / (1 + exp(-x)), in place."""
    gate = np.negative(x)
    with np.errstate(over="ignore"):  # exp(-x) = inf gives the right limit, 0
        np.exp(gate, out=gate)
    gate += 1.0
    x /= gate
    return x


def tanh(x: np.ndarray) -> np.ndarray:
    """Hyperbolic tangent, in place."""
    return np.tanh(x, out=x)


ACTIVATIONS = {"shared": silu, "paper": tanh}
"""Recipes and their activation functions."""


@dataclass(frozen=True)
class Regression:
    """Maps a design and a time to basis coefficients: paper equation 3.

    recipe: "shared" or "paper"
    weights: one (networks, inputs, outputs) float32 per layer
    biases: one (networks, 1, outputs) float32 per layer
    inputs, outputs: the scalings
    """

    recipe: str
    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    inputs: InputScaling
    outputs: OutputScaling

    @property
    def members(self) -> int:
        """Independent answers to one question: ensemble size, or 1."""
        return len(self.weights[0]) if self.recipe == "shared" else 1

    def __call__(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Coefficients, averaged over members: [m], (runs, times, outputs) float32.

        design: (runs, parameters); times: [s], (times,); further: [-], (runs, times, further), as `InputScaling`
        """
        if self.recipe == "paper":
            return self.by_member(design, times, further)[0]
        hidden = self._hidden(design, times, further)
        # The last layer is linear: the mean over members is one product with all their last layers.
        joined = hidden.transpose(1, 0, 2).reshape(hidden.shape[1], -1)
        answer = joined @ self._mean_weight + self._mean_bias
        return self.outputs.back(answer.reshape(len(design), len(times), -1), times)

    def by_member(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Coefficients by each member: [m], (members, runs, times, outputs) float32."""
        answer = self._hidden(design, times, further) @ self.weights[-1] + self.biases[-1]
        if self.recipe == "paper":
            answer = answer.transpose(2, 1, 0)
        return self.outputs.back(answer.reshape(self.members, len(design), len(times), -1), times)

    @cached_property
    def _mean_weight(self):
        return (self.weights[-1] / self.members).reshape(-1, self.weights[-1].shape[2])

    @cached_property
    def _mean_bias(self):
        return self.biases[-1].mean(axis=0)

    def _hidden(self, design, times, further):
        """Last hidden layer: (networks, runs * times, neurons)."""
        activation = ACTIVATIONS[self.recipe]
        hidden = activation(self._first(design, times, further))
        for weight, bias in zip(self.weights[1:-1], self.biases[1:-1], strict=True):
            hidden = hidden @ weight  # one small product per network
            hidden += bias
            hidden = activation(hidden)
        return hidden

    def _first(self, design, times, further):
        """First layer before its activation: (networks, runs * times, neurons).

        It is linear, so that the shares of designs, times and further inputs are found apart and added: a product for
        every design instead of one for every design and time, and that of the trained times once for all.
        """
        trained = np.array_equal(times, self.outputs.times)
        of_time = self.of_trained_times if trained else self._of_times(times)
        of_design = self.inputs.design(design).astype(np.float32) @ self.first_weights[0]
        first = of_design[:, :, None] + of_time[:, None]  # (networks, runs, times, neurons)
        if further is not None:
            flat = np.asarray(further, np.float32).reshape(-1, self.inputs.further)
            first += (flat @ self.first_weights[2]).reshape(first.shape)
        return first.reshape(len(first), -1, first.shape[-1])

    def _of_times(self, times):
        return self.inputs.time(times).astype(np.float32) @ self.first_weights[1] + self.biases[0]

    @cached_property
    def of_trained_times(self) -> np.ndarray:
        """Share of the trained times and the bias in the first layer: (networks, times, neurons)."""
        return self._of_times(self.outputs.times)

    @cached_property
    def first_weights(self) -> list[np.ndarray]:
        """Of the first layer, for design, time and further inputs: each (networks, inputs, neurons)."""
        return np.split(self.weights[0], (len(self.inputs.low), self.inputs.width - self.inputs.further), axis=1)
