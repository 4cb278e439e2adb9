"""How much of what networks say of a design is believed at each time.

What a design does can be learned until the bag crumples; later, networks follow single runs. On runs held out, the
factor by which their departure from the mean trajectory has the least squared error is 1 while they know, and falls to
0 where nobody does. It is found for each component and time, over all modes together, and becomes part of the output
scaling: an answer costs nothing more. (A linear shrinkage of predictions: Copas, Journal of the Royal Statistical
Society B 45 (1983) 311-354.)
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.rom.surrogate.regression import Regression
from billow.rom.surrogate.surrogate import Surrogate

NEIGHBOURS = 0.1
"""Part of the times on either side that count with a time: single times of few runs say little."""


@dataclass(frozen=True, eq=False)
class Agreement:
    """One run held out, [m2], (times, 3) each. common: sum over modes of the predicted departure times the true one;
    own: of the square of the predicted one, both at the times of the output scaling, 0 beyond the run; spread: mean
    over nodes of the variance over members, at the trained times, which by the run's clock are `at` [s]; scaled: [s],
    times of the output scaling, with a clock as far as common time may go: clocks of other runs reach otherwise"""

    common: np.ndarray
    own: np.ndarray
    spread: np.ndarray
    at: np.ndarray
    scaled: np.ndarray

    @classmethod
    def of(cls, surrogate: Surrogate, design: np.ndarray, truth: np.ndarray) -> Agreement:
        """surrogate: that has not seen the run; design: (parameters,); truth: [m], (times, nodes, 3)."""
        regression = surrogate.regression
        scaled = _whole(regression)
        at = np.broadcast_to(regression.common(design[None], surrogate.times), (1, len(surrogate.times)))[0]
        mean = regression.outputs.at(at)[0].reshape(len(at), 3, surrogate.modes)
        known = np.stack([truth[:, :, c] @ basis.modes.T for c, basis in enumerate(surrogate.bases)], axis=1)
        away = (surrogate.coefficients(design, extrapolate=True) - mean).astype(float)
        members = regression.members
        spread = np.square(surrogate.spread(design, extrapolate=True)) * (members / (members - 1))
        sums = (away * (known - mean)).sum(axis=2), np.square(away).sum(axis=2)
        return cls(*(_along(scaled, at, of_run, 0.0) for of_run in sums), spread, at, scaled)


def factors(agreements: list[Agreement]) -> np.ndarray:
    """[-], (times of the output scaling, 3) in [0, 1], by least squares over runs held out; one more run that agrees is
    assumed."""
    common, own = (_pooled(sum(getattr(one, name) for one in agreements)) for name in ("common", "own"))
    assumed = own / len(agreements)
    total = own + assumed
    found = np.divide(common + assumed, total, out=np.ones_like(total), where=total > 0.0)
    return np.clip(found, 0.0, 1.0)


def disbelieved(agreements: list[Agreement], by: np.ndarray) -> np.ndarray:
    """[m2], (3, trained times): variance that members no longer show for being shrunk by `factors`, for intervals: what
    is not believed is not known any better."""
    shrunk_by = [_along(one.at, one.scaled, by) for one in agreements]
    return np.mean([(1.0 - np.square(f)) * one.spread for f, one in zip(shrunk_by, agreements, strict=True)], axis=0).T


def _whole(regression: Regression) -> np.ndarray:
    """Times of the output scaling, continued to the end of common time: [s]."""
    times = regression.outputs.times
    if regression.clock is None:
        return times
    step = times[1] - times[0]
    return step * np.arange(round(regression.clock.end / step) + 2)  # rounding may cost one


def _along(asked: np.ndarray, times: np.ndarray, values: np.ndarray, outside: float | None = None) -> np.ndarray:
    """Values (times, 3) at the times asked, linear in between."""
    return np.stack([np.interp(asked, times, v, left=outside, right=outside) for v in values.T], axis=1)


def _pooled(sums: np.ndarray) -> np.ndarray:
    """Sums over each time and its neighbours."""
    reach = max(1, round(NEIGHBOURS * len(sums)))
    total = np.concatenate([np.zeros((1, 3)), sums.cumsum(axis=0)])
    index = np.arange(len(sums))
    return total[np.minimum(index + reach + 1, len(sums))] - total[np.maximum(index - reach, 0)]


def shrunk(surrogate: Surrogate, by: np.ndarray) -> Surrogate:
    """The surrogate whose departures from the mean trajectory are multiplied by [-], (times, 3), of which there may be
    more than the output scaling has (`Agreement.scaled`)."""
    regression = surrogate.regression
    by = by[: len(regression.outputs.times)]
    each = np.repeat(by, surrogate.modes, axis=1).astype(np.float32)  # modes of x, then of y, then of z
    outputs = replace(regression.outputs, deviation=regression.outputs.deviation * each)
    return replace(surrogate, regression=replace(regression, outputs=outputs))
