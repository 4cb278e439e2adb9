"""How far runs with fewer particles deviate from those with most, and how much runs differ by their seed alone.

Noise, shift and deviation: docs/theory.md, Convergence with the number of particles.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from operator import attrgetter

import numpy as np

from billow.results.result import Result


@dataclass(frozen=True)
class Quantity:
    """name with unit; samples: count -> (runs, samples); origin: what they are at the start, a number or (samples,);
    scale: root mean square of the best samples from there, in the unit of the name."""

    name: str
    samples: dict[int, np.ndarray]
    origin: np.ndarray | float = 0.0

    @property
    def best(self) -> np.ndarray:
        """Mean over the runs with most particles, (samples,)."""
        return self.samples[max(self.samples)].mean(axis=0)

    @property
    def scale(self) -> float:
        return max(_rms(self.best - self.origin), 1e-300)


@dataclass(frozen=True)
class Convergence:
    """Of one quantity: (counts,) arrays of noise, shift and deviation, relative to scale; exponent of the deviation;
    enough: smallest sufficient count, or None if only the largest is."""

    quantity: Quantity
    counts: np.ndarray
    noise: np.ndarray
    shift: np.ndarray
    deviation: np.ndarray
    exponent: float
    enough: int | None


def quantities(runs: Mapping[int, Sequence[Result]]) -> list[Quantity]:
    """The quantities compared: pressure, volume, velocity and acceleration of every free obstacle, and the final shape.

    runs: count -> runs of one case, at least two each.
    """

    def samples(of: Callable[[Result], np.ndarray]) -> dict[int, np.ndarray]:
        return {count: np.array([of(result) for result in results]) for count, results in runs.items()}

    any_run = next(iter(runs.values()))[0]
    times = any_run.histories.time
    found = []
    for name, unit in (("pressure", "Pa"), ("volume", "m^3")):
        curve = attrgetter(f"gas.{name}")
        found.append(Quantity(f"{name} [{unit}]", samples(curve), curve(any_run)[0]))
    for name in any_run.free_obstacles:
        velocity = samples(lambda result, name=name: result.body(name).velocity.T)
        origin = np.repeat(any_run.body(name).velocity[0], len(times))
        found.append(Quantity(f"{name} velocity [m/s]", {c: _flat(v) for c, v in velocity.items()}, origin))
        change = {c: _flat(millisecond_means(times, v)[1]) for c, v in velocity.items()}
        found.append(Quantity(f"{name} acceleration [m/s^2]", change))
    shape = samples(lambda result: result.fabric.points(-1).ravel().astype(float))
    found.append(Quantity("shape at the end [m]", shape, any_run.reference.astype(float).ravel()))
    return [q for q in found if _rms(q.best - q.origin) > 0.0]


def millisecond_means(times: np.ndarray, velocity: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Middles [s] and means over about a millisecond of the acceleration [m/s^2], from velocity [m/s] (..., times).

    An instantaneous force is mostly contact chatter; injury criteria use means over 3 ms.
    """
    span = min(max(1, round(1e-3 / (times[1] - times[0]))), len(times) - 1)
    change = (velocity[..., span:] - velocity[..., :-span]) / (times[span] - times[0])
    return 0.5 * (times[span:] + times[:-span]), change


def converge(quantity: Quantity, tolerance: float) -> Convergence:
    """How a quantity converges. A count is enough if, for it and all larger ones, either the shift is at most the noise
    of one run with the largest count, or the deviation is at most `tolerance` [-]."""
    counts = np.array(sorted(quantity.samples))
    best, scale = quantity.best, quantity.scale
    most = quantity.samples[counts[-1]]
    chance = _noise(most) / scale
    noise = np.array([_noise(quantity.samples[c]) for c in counts]) / scale
    shift = np.array([_rms(quantity.samples[c].mean(axis=0) - best) for c in counts]) / scale
    square = np.array([_rms(quantity.samples[c] - best) ** 2 for c in counts]) / scale**2 - chance**2 / len(most)
    deviation = np.sqrt(np.maximum(square, 0.0))
    deviation[-1] = chance
    will_do = (shift <= chance) | (deviation <= tolerance)
    first = 1 + int(np.flatnonzero(~will_do).max(initial=-1))  # all from here on will do
    enough = int(counts[first]) if first < len(counts) - 1 else None
    return Convergence(quantity, counts, noise, shift, deviation, _exponent(counts, deviation), enough)


def _exponent(counts: np.ndarray, deviation: np.ndarray) -> float:
    """Slope of log(deviation) over log(count); nan if fewer than two are not zero."""
    known = deviation > 0.0
    if known.sum() < 2:
        return float("nan")
    return float(np.polyfit(np.log(counts[known]), np.log(deviation[known]), 1)[0])


def _noise(samples: np.ndarray) -> float:
    return float(np.sqrt(samples.var(axis=0, ddof=1).mean()))


def _rms(values: np.ndarray) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


def _flat(values: np.ndarray) -> np.ndarray:
    return values.reshape(len(values), -1).astype(float)
