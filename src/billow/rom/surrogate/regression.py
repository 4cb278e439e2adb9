"""Evaluation of trained networks with NumPy alone: their scalings, and a stack of fully connected networks of equal
shape that see the same inputs.

- `shared`: the networks are members of an ensemble, each gives all coefficients; the answer is their mean
- `paper`: each network gives one coefficient; the answer is all of them side by side
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.errors import NumericalStop
from billow.rom.surrogate.clock import Clock

FREQUENCIES = (1, 2, 4, 8)
"""k of the time features sin(pi k t), cos(pi k t), with t from 0 at the first recorded time to 1 at the last."""
BY_CLOCK = (*FREQUENCIES, 16, 32)
"""Those in the common time of a clock, by which bounces of all designs come at the same times."""


NOT_FINITE = NumericalStop.declare(
    "E-ROM-024",
    "the networks give no finite answer",
    where="the answer",
    why="a number inside them, or in the answer, is too large",
    cause="a file by another program, or a question far outside the trained ranges",
    remedy="ask inside the trained ranges; if that fails too, train again: billow train FOLDER",
)

LARGEST = 1e12
"""[m] or [N]: beyond, sums of squares overflow in single precision."""


def _finite(answer: np.ndarray) -> np.ndarray:
    if not np.abs(answer).max() < LARGEST:
        raise NOT_FINITE()
    return answer


@dataclass(frozen=True)
class InputScaling:
    """Turns designs and times into network inputs.

    low, high: [as the parameters], (parameters,) float64, the ranges of the design of experiments
    start, end: [s], first and last trained time
    recipe: "shared": design in [-1, 1], t in [0, 1] with sines and cosines; "paper": design and t in [0, 1]
    further: number of inputs besides design and time, each about [0, 1] (`force_inputs`)
    frequencies: of the time features of "shared"
    """

    low: np.ndarray
    high: np.ndarray
    start: float
    end: float
    recipe: str
    further: int = 0
    frequencies: tuple[int, ...] = FREQUENCIES

    @property
    def width(self) -> int:
        """Number of inputs of the network."""
        return len(self.low) + 1 + (2 * len(self.frequencies) if self.recipe == "shared" else 0) + self.further

    def design(self, design: np.ndarray) -> np.ndarray:
        """(..., parameters) -> [-], the same shape float64 in [-1, 1] (or [0, 1])."""
        unit = (design - self.low) / (self.high - self.low)
        return 2.0 * unit - 1.0 if self.recipe == "shared" else unit

    def time(self, times: np.ndarray) -> np.ndarray:
        """[s], (..., times) -> [-], (..., times, time features) float64."""
        unit = ((times - self.start) / (self.end - self.start))[..., None]
        if self.recipe == "paper":
            return unit
        angle = unit * self._rates
        return np.concatenate([unit, np.sin(angle), np.cos(angle)], axis=-1)

    @cached_property
    def _rates(self) -> np.ndarray:
        return np.pi * np.array(self.frequencies)

    def __call__(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Every design at every time: (runs, parameters), (times,) or (runs, times) -> (runs * times, width)
        float32. further: [-], (runs, times, further), the inputs besides design and time."""
        features = np.empty((len(design), times.shape[-1], self.width), np.float32)
        known = self.width - self.further
        features[:, :, : len(self.low)] = self.design(design)[:, None]
        features[:, :, len(self.low) : known] = self.time(times)
        if self.further:
            features[:, :, known:] = further
        return features.reshape(-1, self.width)


@dataclass(frozen=True)
class OutputScaling:
    """Coefficients as deviations of order one from what is typical at each time, by a clock if there is one.

    times: [s], (times,) float64, rising
    mean, deviation: [m], (times, outputs) float32; outputs are the modes of x, then of y, then of z
    """

    times: np.ndarray
    mean: np.ndarray
    deviation: np.ndarray

    @classmethod
    def of(cls, coefficients: np.ndarray, times: np.ndarray, recipe: str) -> OutputScaling:
        """Scaling of training coefficients: [m], (runs, times, components, modes).

        `shared`: the mean trajectory is taken off, so that networks learn only what the design does. The rest is
        divided, for each component and time, by the deviation of its strongest mode: modes then weigh in the loss as
        much as in the displacement, and the quiet start is learned as well as the loud end (down to a hundredth of
        the deviation over all times).
        `paper`: every coefficient of every network has mean 0 and deviation 1 over all times.
        """
        wide = coefficients.astype(float)
        if recipe == "paper":
            mean, deviation = wide.mean(axis=(0, 1)), wide.std(axis=(0, 1))
        else:
            mean = wide.mean(axis=0)
            squares = np.square(wide - mean)
            overall = squares.mean(axis=(0, 1)).max(axis=-1)  # (components,)
            at_time = squares.mean(axis=0).max(axis=-1)  # (times, components)
            deviation = np.sqrt(np.maximum(at_time, 1e-4 * overall))[:, :, None]
        # An output that never changes stays constant, whatever the networks answer.
        deviation = np.maximum(deviation, max(1e-9 * np.abs(wide).max(), 1e-30))
        each = (np.broadcast_to(values, wide.shape[1:]) for values in (mean, deviation))
        return cls(times, *(values.reshape(len(times), -1).astype(np.float32) for values in each))

    def forward(self, coefficients: np.ndarray) -> np.ndarray:
        """[m], (runs, times, outputs) at `times` -> [-], the same shape float32."""
        return (coefficients - self.mean) / self.deviation

    def back(self, outputs: np.ndarray, times: np.ndarray) -> np.ndarray:
        """[-], (..., times, outputs) -> [m], the same shape, by `at(times)`."""
        mean, deviation = self.at(times)
        return outputs * deviation + mean

    def at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation at any times, linear between `times`: [m], (..., times, outputs) float32 each."""
        if np.array_equal(times, self.times):
            return self.mean, self.deviation
        both, rise = self._both
        place = np.interp(times, self.times, self._count)
        before = np.minimum(place.astype(int), len(rise) - 1)
        found = rise.take(before, axis=0)
        found *= (place - before).astype(np.float32)[..., None]
        found += both.take(before, axis=0)
        return found[..., : self.mean.shape[1]], found[..., self.mean.shape[1] :]

    @cached_property
    def _both(self) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation side by side, (times, 2 outputs), and their differences from one time to the next."""
        both = np.concatenate([self.mean, self.deviation], axis=1)
        return both, np.diff(both, axis=0)

    @cached_property
    def _count(self) -> np.ndarray:
        """0, 1, 2, ... of `times`."""
        return np.arange(len(self.times), dtype=float)


def silu(minus: np.ndarray) -> np.ndarray:
    """-y / (1 + exp(-y)) of minus = -y, in place. Layers hand on minus their values (`SIGN`), which saves the pass that
    would change the sign; exp takes half as long as tanh, and where it overflows the quotient is 0, as it should be."""
    gate = np.exp(minus)
    gate += 1.0
    minus /= gate
    return minus


ACTIVATIONS = {"shared": silu, "paper": lambda x: np.tanh(x, out=x)}
"""Recipes and their activation functions; they work in place."""
SIGN = {"shared": -1.0, "paper": 1.0}
"""Of a hidden layer's sums and values, as its activation function takes and gives them."""


@dataclass(frozen=True)
class Regression:
    """Maps a design and a time to basis coefficients: paper equation 3.

    recipe: "shared" or "paper"; inputs, outputs: the scalings
    weights, biases: one (networks, inputs, outputs) and one (networks, 1, outputs) float32 per layer
    clock: of each design, in whose common time the scalings are then; None if all go by their own time
    """

    recipe: str
    weights: tuple[np.ndarray, ...]
    biases: tuple[np.ndarray, ...]
    inputs: InputScaling
    outputs: OutputScaling
    clock: Clock | None = None

    @property
    def members(self) -> int:
        """Independent answers to one question: ensemble size, or 1."""
        return len(self.weights[0]) if self.recipe == "shared" else 1

    def __call__(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Coefficients, averaged over members: [m], (runs, times, outputs) float32. design: (runs, parameters); times:
        [s], (times,); further: [-], (runs, times, further), as `InputScaling`. NumericalStop E-ROM-024 if one is beyond
        `LARGEST`."""
        if self.recipe == "paper":
            return self.by_member(design, times, further)[0]
        with np.errstate(over="ignore", invalid="ignore"):  # an overflow stays one to the end and is raised below
            centred = self.inputs.design(design)
            at = self._common(centred, times)
            # The last layer is linear: the mean over members is one product with all their last layers.
            weight, bias = self._mean_layer
            answer = self._hidden(centred, at, further) @ weight
            answer += bias
            return _finite(self.outputs.back(answer.reshape(len(design), len(times), -1), at))

    def by_member(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Coefficients by each member: [m], (members, runs, times, outputs) float32."""
        with np.errstate(over="ignore", invalid="ignore"):
            centred = self.inputs.design(design)
            at = self._common(centred, times)
            answer = self._side_by_side(self._hidden(centred, at, further)) @ self._last_weight + self.biases[-1]
            if self.recipe == "paper":
                answer = answer.transpose(2, 1, 0)
            return _finite(self.outputs.back(answer.reshape(self.members, len(design), len(times), -1), at))

    def common(self, design: np.ndarray, times: np.ndarray) -> np.ndarray:
        """The times by which scalings go: [s], (times,) as they are, or (runs, times) by the clock of each design."""
        return self._common(self.inputs.design(design), times)

    def _common(self, centred, times):
        return times if self.clock is None else self.clock(centred, times)

    @cached_property
    def _mean_layer(self):
        weight = (self._last_weight / self.members).reshape(-1, self.weights[-1].shape[2])
        return weight, self.biases[-1].mean(axis=0)

    @cached_property
    def _last_weight(self) -> np.ndarray:
        return np.float32(SIGN[self.recipe]) * self.weights[-1]

    def _hidden(self, centred, times, further):
        """Last hidden layer: (runs * times, networks * neurons). The networks' neurons stand side by side, so that all
        of them are one array to activation functions and to the last layer."""
        activation = ACTIVATIONS[self.recipe]
        hidden = activation(self._first(centred, times, further))
        for weight, bias in self._inner:
            after = np.empty((len(hidden), bias.size), np.float32)
            np.matmul(self._side_by_side(hidden), weight, out=self._side_by_side(after))  # a small product per network
            after += bias
            hidden = activation(after)
        return hidden

    def _side_by_side(self, layer):
        """A view of a layer (rows, networks * neurons) as (networks, rows, neurons)."""
        return layer.reshape(len(layer), len(self.weights[0]), -1).transpose(1, 0, 2)

    def _first(self, centred, times, further):
        """First layer before its activation, times `SIGN`: (runs * times, networks * neurons).

        It is linear, so that the shares of designs, times and further inputs are found apart and added: a product for
        every design instead of one for every design and time, and, without a clock, that of the trained times once for
        all.
        """
        of_design = centred.astype(np.float32) @ self._outer[0]
        of_design += self._outer[3]
        if times.ndim > 1:
            first = self._of_times(times.ravel()).reshape(*times.shape, -1)
            first += of_design[:, None]
        else:
            trained = np.array_equal(times, self.outputs.times)
            first = of_design[:, None] + (self._of_trained if trained else self._of_times(times))
        if further is not None:
            flat = np.asarray(further, np.float32).reshape(-1, self.inputs.further)
            first += (flat @ self._outer[2]).reshape(first.shape)
        return first.reshape(-1, first.shape[-1])

    def _of_times(self, times):
        """Share of some times in the first layer, times `SIGN`: (times, networks * neurons)."""
        return self.inputs.time(times).astype(np.float32) @ self._outer[1]

    @cached_property
    def _of_trained(self) -> np.ndarray:
        return self._of_times(self.outputs.times)

    @cached_property
    def of_trained_times(self) -> np.ndarray:
        """Share of the trained times and the bias in the first layer: (networks, times, neurons)."""
        return self.inputs.time(self.outputs.times).astype(np.float32) @ self.first_weights[1] + self.biases[0]

    @cached_property
    def first_weights(self) -> list[np.ndarray]:
        """Of the first layer, for design, time and further inputs: each (networks, inputs, neurons)."""
        return np.split(self.weights[0], (len(self.inputs.low), self.inputs.width - self.inputs.further), axis=1)

    @cached_property
    def _outer(self) -> list[np.ndarray]:
        """`first_weights` and the bias, times `SIGN`, of all networks: each (inputs, networks * neurons)."""
        sign, networks = np.float32(SIGN[self.recipe]), len(self.weights[0])
        return [
            np.ascontiguousarray(sign * values.transpose(1, 0, 2).reshape(values.shape[1], networks * values.shape[2]))
            for values in (*self.first_weights, self.biases[0])
        ]

    @cached_property
    def _inner(self) -> list[tuple[np.ndarray, np.ndarray]]:
        """Weights (networks, inputs, neurons), and biases (networks * neurons,) times `SIGN`, of the layers between."""
        layers = zip(self.weights[1:-1], self.biases[1:-1], strict=True)
        return [(weight, np.float32(SIGN[self.recipe]) * bias.ravel()) for weight, bias in layers]
