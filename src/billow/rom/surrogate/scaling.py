"""What the networks see: designs and times as numbers of order one, coefficients as deviations."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

FREQUENCIES = (1, 2, 4, 8)
"""k of the time features sin(pi k t), cos(pi k t), with t from 0 at the first recorded time to 1 at the last."""


@dataclass(frozen=True)
class InputScaling:
    """Turns designs and times into network inputs.

    low, high: [as the parameters], (parameters,) float64, the ranges of the design of experiments
    start, end: [s], first and last trained time
    recipe: "shared": design in [-1, 1], t in [0, 1] with sines and cosines; "paper": design and t in [0, 1]
    further: number of inputs besides design and time, each about [0, 1] (`force_inputs`)
    """

    low: np.ndarray
    high: np.ndarray
    start: float
    end: float
    recipe: str
    further: int = 0

    @property
    def width(self) -> int:
        """Number of inputs of the network."""
        return len(self.low) + 1 + (2 * len(FREQUENCIES) if self.recipe == "shared" else 0) + self.further

    def design(self, design: np.ndarray) -> np.ndarray:
        """(..., parameters) -> [-], the same shape float64 in [-1, 1] (or [0, 1])."""
        unit = (design - self.low) / (self.high - self.low)
        return 2.0 * unit - 1.0 if self.recipe == "shared" else unit

    def time(self, times: np.ndarray) -> np.ndarray:
        """[s], (times,) -> [-], (times, time features) float64."""
        unit = ((times - self.start) / (self.end - self.start))[:, None]
        if self.recipe == "paper":
            return unit
        angle = np.pi * unit * np.array(FREQUENCIES)
        return np.hstack([unit, np.sin(angle), np.cos(angle)])

    def __call__(self, design: np.ndarray, times: np.ndarray, further: np.ndarray | None = None) -> np.ndarray:
        """Every design at every time: (runs, parameters), (times,) -> (runs * times, width) float32.

        further: [-], (runs, times, further), the inputs besides design and time
        """
        features = np.empty((len(design), len(times), self.width), np.float32)
        known = self.width - self.further
        features[:, :, : len(self.low)] = self.design(design)[:, None]
        features[:, :, len(self.low) : known] = self.time(times)
        if self.further:
            features[:, :, known:] = further
        return features.reshape(-1, self.width)


@dataclass(frozen=True)
class OutputScaling:
    """Coefficients as deviations of order one from what is typical at each time.

    times: [s], (times,) float64
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
        the deviation over all times). Standardising every coefficient on its own, which spends the networks on the
        weakest modes, gave unseen runs a z RMSE of 9.7, 7.4, 4.2 mm with 24, 48, 96 training runs; this gives 7.8,
        5.4, 2.1 mm (membrane bag of another solver, K = 12).
        `paper`: every coefficient of every network has mean 0 and deviation 1 over all times.
        """
        wide = coefficients.astype(float)
        if recipe == "paper":
            mean = np.broadcast_to(wide.mean(axis=(0, 1)), wide.shape[1:])
            deviation = np.broadcast_to(wide.std(axis=(0, 1)), wide.shape[1:])
        else:
            mean = wide.mean(axis=0)
            squares = np.square(wide - mean)
            overall = squares.mean(axis=(0, 1)).max(axis=-1)  # (components,)
            at_time = squares.mean(axis=0).max(axis=-1)  # (times, components)
            deviation = np.sqrt(np.maximum(at_time, 1e-4 * overall))[:, :, None]
            deviation = np.broadcast_to(deviation, wide.shape[1:])
        # An output that never changes stays constant, whatever the networks answer.
        deviation = np.maximum(deviation, max(1e-9 * np.abs(wide).max(), 1e-30))
        return cls(times, *(values.reshape(len(times), -1).astype(np.float32) for values in (mean, deviation)))

    def forward(self, coefficients: np.ndarray) -> np.ndarray:
        """[m], (runs, times, outputs) at the trained times -> [-], the same shape float32."""
        return (coefficients - self.mean) / self.deviation

    def back(self, outputs: np.ndarray, times: np.ndarray) -> np.ndarray:
        """[-], (..., times, outputs) -> [m], the same shape, by `at(times)`."""
        mean, deviation = self.at(times)
        return outputs * deviation + mean

    def at(self, times: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Mean and deviation at any times, linear between the trained ones: [m], (times, outputs) float32 each."""
        if np.array_equal(times, self.times):
            return self.mean, self.deviation
        after = np.clip(np.searchsorted(self.times, times), 1, len(self.times) - 1)
        start, stop = self.times[after - 1], self.times[after]
        part = np.clip((times - start) / (stop - start), 0.0, 1.0).astype(np.float32)[:, None]
        return tuple(a[after - 1] + part * (a[after] - a[after - 1]) for a in (self.mean, self.deviation))
