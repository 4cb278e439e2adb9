"""Networks fitted to a nested design and judged on unseen runs, for any number of modes at once."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from billow.reproductions.rom_paper.kept import Kept, Piece
from billow.reproductions.rom_paper.reductions import Forces, Reduced
from billow.rom.judge.rmse import Summary
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.training import Plan, Progress, learn_networks, shared_settings
from billow.rom.surrogate.surrogate import Surrogate


@dataclass(frozen=True, eq=False)
class Fit:
    """One training of the recipe `shared`.

    counts: numbers of modes it was judged with, rising; the last is the number it was trained with
    truncation, regression: [m], (counts, runs, times, 3), RMSE over nodes of unseen snapshots; their squares add up
    cpu_seconds: [s] of training the networks; epochs
    """

    counts: tuple[int, ...]
    truncation: np.ndarray
    regression: np.ndarray
    cpu_seconds: float
    epochs: int

    @property
    def rmse(self) -> np.ndarray:
        """[m], (counts, runs, times, 3), RMSE inside paper equation 5."""
        return np.hypot(self.truncation, self.regression)

    def summary(self, component: int, row: int = -1) -> Summary:
        """Distribution over unseen snapshots of one component, with `counts[row]` modes."""
        return Summary.of(self.rmse[row, :, :, component])


def fit(
    dataset,
    reduced: Reduced,
    counts: tuple[int, ...],
    kept: Kept,
    *,
    seed: int = 0,
    forces: Forces | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Train with `counts[-1]` modes and judge with each of `counts`: fewer modes are the first of more, and every
    coefficient has its own output.

    forces: also an input, and then known of the unseen runs too. Errors as `Surrogate.train`.
    """
    inputs = {"of": reduced.made_of, "counts": counts, "seed": seed, "forces": forces is not None} | shared_settings()
    if forces is not None:
        inputs |= {"force_modes": forces.model.width}

    def make() -> Piece:
        modes = counts[-1]
        reduction = reduced.reduction.cut(modes)
        plan = Plan("shared", modes, seed, None, 0, "z", DEFAULT_MEMORY)
        given = None if forces is None else (forces.model, forces.seen)
        begun = time.process_time()
        surrogate = Surrogate(**learn_networks(dataset, reduction, plan, given, progress))
        spent = time.process_time() - begun
        design, times = reduced.unseen_design, reduction.times
        learned = surrogate.regression(design, times, None if forces is None else forces.unseen)
        learned = learned.reshape(len(design), len(times), 3, modes)
        arrays = {
            "truncation": np.stack([reduced.unseen.truncation(count) for count in counts]),
            "regression": np.stack([reduced.unseen.regression(learned, count) for count in counts]),
        }
        return arrays, {"cpu_seconds": spent, "epochs": surrogate.training["epochs"]}

    arrays, record = kept.piece("fit", inputs, make)
    return Fit(counts, arrays["truncation"], arrays["regression"], record["cpu_seconds"], record["epochs"])
