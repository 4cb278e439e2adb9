"""What a response depends on: Sobol' indices, main effects, and correlation of the runs."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.rom.surrogate.design_space import levelled, to_unit

NOT_A_POWER = InputError.declare(
    "E-DES-020",
    "{samples} samples cannot be used",
    where="sensitivity",
    why="Sobol' indices need a power of two, from 64 to 65,536",
    remedy="ask for 1024, or another power of two",
)
RESAMPLES, CONFIDENCE = 199, 0.9
GRID, OTHERS = 21, 256
"""Values of a parameter, and designs of the others, of a main effect."""


@dataclass(frozen=True, eq=False)
class Sensitivity:
    """Sobol' indices of a response: parts of its variance, for independent uniform parameters.

    names: of the parameters; first, total: (parameters, 3): index of what a parameter does alone, and of all it takes
    part in, each with the ends of a 90 % interval by bootstrap. An index near zero may come out negative.
    """

    response: str
    names: tuple[str, ...]
    first: np.ndarray
    total: np.ndarray


@one_blas_thread()
def sensitivity(surfaces, name: str, samples: int = 1024, seed: int = 0) -> Sensitivity:
    """Sobol' indices of a surface (Saltelli et al., Computer Physics Communications 181 (2010) 259-270, table 2).

    samples: base samples, a power of two; (parameters + 2) times as many answers. InputError E-DES-010: no usable
    surface; -020: samples.
    """
    if samples not in {1 << k for k in range(6, 17)}:
        raise NOT_A_POWER(samples=samples)
    surface = surfaces.usable(name)
    first, total = indices(lambda unit: surface.value(levelled(unit, surfaces.parameters)), len(surfaces.parameters),
                           samples, seed)  # fmt: skip
    return Sensitivity(name, tuple(p.name for p in surfaces.parameters), first, total)


def indices(answer, dimensions: int, samples: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """First and total indices with their ends, (dimensions, 3) each; answer: (designs, dimensions) in [0, 1] to
    (designs,)."""
    from scipy.stats import qmc, sobol_indices

    random = np.random.default_rng(seed)
    points = qmc.Sobol(2 * dimensions, rng=random).random(samples)
    one, other = points[:, :dimensions], points[:, dimensions:]
    mixed = np.tile(one, (dimensions, 1, 1))
    for k in range(dimensions):
        mixed[k, :, k] = other[:, k]
    whole = answer(np.concatenate([one, other, mixed.reshape(-1, dimensions)])).reshape(dimensions + 2, samples)

    def of(rows: np.ndarray) -> np.ndarray:  # (2, dimensions)
        part = whole[:, rows]
        made = sobol_indices(func={"f_A": part[:1], "f_B": part[1:2], "f_AB": part[2:, None]}, n=samples)
        return np.stack([made.first_order.ravel(), made.total_order.ravel()])

    # Resampled here and not by scipy, whose resampling takes no seed.
    again = np.array([of(random.integers(0, samples, samples)) for _ in range(RESAMPLES)])
    low, high = np.quantile(again, [0.5 * (1.0 - CONFIDENCE), 0.5 * (1.0 + CONFIDENCE)], axis=0)
    found = of(np.arange(samples))
    return tuple(np.column_stack([found[k], low[k], high[k]]) for k in range(2))


@one_blas_thread()
def main_effects(surfaces, name: str, seed: int = 0) -> tuple[np.ndarray, np.ndarray]:
    """Mean response at values of each parameter over all others: (parameters, GRID) in [0, 1] of their ranges, and
    (parameters, GRID, 3) with the mean ends of 90 % intervals. A factor's values repeat."""
    from scipy.stats import qmc

    surface, count = surfaces.usable(name), len(surfaces.parameters)
    others = levelled(qmc.Sobol(count, rng=np.random.default_rng(seed)).random(OTHERS), surfaces.parameters)
    places, effects = np.empty((count, GRID)), np.empty((count, GRID, 3))
    for k in range(count):
        grid = np.tile(np.linspace(0.0, 1.0, GRID)[:, None], (1, count))
        places[k] = levelled(grid, surfaces.parameters)[:, k]
        asked = np.tile(others, (GRID, 1))
        asked[:, k] = np.repeat(places[k], OTHERS)
        effects[k] = surface.interval(asked).reshape(GRID, OTHERS, 3).mean(axis=1)
    return places, effects


def correlations(surfaces) -> np.ndarray:
    """Spearman's rank correlation of parameters and responses over the training runs, (columns, columns); NaN where a
    column is constant or has gaps."""
    from scipy.stats import rankdata

    columns = np.column_stack([to_unit(surfaces.designs, surfaces.parameters), surfaces.values])
    ranks = np.array(
        [rankdata(column) if np.isfinite(column).all() else np.full(len(column), np.nan) for column in columns.T]
    )
    ranks -= ranks.mean(axis=1, keepdims=True)
    length = np.linalg.norm(ranks, axis=1)
    with np.errstate(divide="ignore", invalid="ignore"):
        return (ranks @ ranks.T) / np.outer(length, length)
