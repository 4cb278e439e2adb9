"""Networks fitted to a nested design and judged on unseen runs, for any number of modes at once."""

from __future__ import annotations

import time
from dataclasses import dataclass

from billow.reproductions.rom_paper.kept import Kept, Piece, shared_settings
from billow.reproductions.rom_paper.reductions import Forces, Reduced
from billow.rom.judge.errors import ErrorsByModes
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Progress
from billow.rom.learn.train import Recipe, train_networks


@dataclass(frozen=True, eq=False)
class Fit(ErrorsByModes):
    """One training of the recipe `shared`, judged on unseen runs. cpu_seconds: [s] of training the networks; epochs"""

    cpu_seconds: float
    epochs: int


def fit(
    dataset: Dataset,
    reduced: Reduced,
    counts: tuple[int, ...],
    kept: Kept,
    *,
    seed: int = 0,
    forces: Forces | None = None,
    progress: Progress | None = None,
) -> Fit:
    """Train with `counts[-1]` modes and judge with each of `counts`.

    forces: also an input, and then known of the unseen runs too. Errors as `train`.
    """
    inputs = {"of": reduced.made_of, "counts": counts, "seed": seed, "forces": forces is not None} | shared_settings()
    if forces is not None:
        inputs |= {"force_modes": forces.model.width}

    def make() -> Piece:
        modes = counts[-1]
        given = None if forces is None else (forces.model, forces.seen)
        begun = time.process_time()
        surrogate = train_networks(
            dataset, reduced.reduction.cut(modes), Recipe(modes=modes, seed=seed), given, progress
        )
        spent = time.process_time() - begun
        design, times = reduced.unseen_design, surrogate.times
        learned = surrogate.regression(design, times, None if forces is None else forces.unseen)
        errors = ErrorsByModes.of(counts, reduced.unseen, learned.reshape(len(design), len(times), 3, modes))
        arrays = {"truncation": errors.truncation, "regression": errors.regression}
        return arrays, {"cpu_seconds": spent, "epochs": surrogate.training["epochs"]}

    arrays, record = kept.piece("fit", inputs, make)
    return Fit(counts, arrays["truncation"], arrays["regression"], record["cpu_seconds"], record["epochs"])
