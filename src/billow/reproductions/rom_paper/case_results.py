"""One test case of the paper from our own runs: everything its tables and figures are made of."""

from __future__ import annotations

from dataclasses import dataclass
from time import process_time

import numpy as np

from billow.reproductions.rom_paper.available import Available
from billow.reproductions.rom_paper.kept import Kept, fingerprint, shared_settings
from billow.reproductions.rom_paper.nested_design import Fit, NestedDesign
from billow.reproductions.rom_paper.published import EPOCHS, MODES, PublishedCase
from billow.reproductions.rom_paper.recipe import RecipeFit, paper_recipe
from billow.rom.coupled.coupled_evaluation import CoupledEvaluation, evaluate_coupled
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.judge.errors import LearningCurve, fit_learning_curve
from billow.rom.judge.evaluate import SWEEP_MODES, Evaluation, evaluate
from billow.rom.judge.timing import Inference, measure_inference
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Announcement, Announcer
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate.surrogate import Surrogate

SEEDS = (0, 1)
"""Of the pairs of fits with and without forces: smaller differences than between seeds do not count."""


@dataclass(frozen=True, eq=False)
class Size:
    """One nested design.

    runs: used; generation: [s] what making them took of the processors; read, pod: [s]; pod in processor time
    sweep: judged with every number of modes; plain, forces: with K of the tables, one fit per seed of `SEEDS`
    sweep_forces: as sweep with the true forces of the unseen runs, for a case the paper shows so
    """

    runs: int
    generation: float
    pod: float
    sweep: Fit
    sweep_forces: Fit | None
    plain: tuple[Fit, ...]
    forces: tuple[Fit, ...]

    @property
    def training(self) -> float:
        """[s] of processor time from snapshots to networks."""
        return self.pod + self.plain[0].cpu_seconds


@dataclass(frozen=True, eq=False)
class CaseResults:
    """sizes: N_DOE -> results, rising; evaluation, inference: of a surrogate of the largest, with K of the tables."""

    case: PublishedCase
    dataset: Dataset
    notes: tuple[str, ...]
    sizes: dict[int, Size]
    evaluation: Evaluation
    inference: Inference
    coupled: Coupled | None = None
    coupled_evaluation: CoupledEvaluation | None = None
    recipe: RecipeFit | None = None

    @property
    def largest(self) -> int:
        return max(self.sizes)

    @property
    def surrogate(self) -> Surrogate:
        return self.evaluation.surrogate

    @property
    def reference_length(self) -> float:
        """[m]"""
        return self.evaluation.reference_length

    def learning_curve(self, component: int) -> LearningCurve | None:
        """Mean RMSE against runs, from the fits without forces."""
        means = [np.mean([f.summary(component).mean for f in size.plain]) for size in self.sizes.values()]
        return fit_learning_curve(list(self.sizes), means)


def case_results(
    case: PublishedCase,
    dataset: Dataset,
    there: Available,
    kept: Kept,
    *,
    recipe: str | None = None,
    recipe_epochs: int = EPOCHS,
    memory: int = DEFAULT_MEMORY,
    progress: Announcement | None = None,
) -> CaseResults:
    """Everything of one case; pieces that are kept are not made again.

    recipe: the component for which the paper's own recipe is trained too, or None; recipe_epochs: its epochs
    progress: called as progress(done, total, what) before each piece
    Errors as `train` and `evaluate`; E-CPL-001 if no training run has a contact force.
    """
    fits = len(there.sizes) * (1 + 2 * len(SEEDS) + case.forces)
    announce = Announcer(progress, fits + 3 + 2 * case.forces + (recipe is not None))
    # K of the tables, or fewer if the smallest design has not so many snapshots.
    columns = min(len(runs) for runs in there.sizes.values()) * len(dataset.times)
    sizes, modes = {}, min(MODES, columns, len(dataset.reference))
    for size, runs in there.sizes.items():
        most = min(len(runs) * len(dataset.times), len(dataset.reference))
        counts = tuple(count for count in SWEEP_MODES if count <= most)
        nested = NestedDesign(dataset, runs, there.unseen, counts[-1], memory)
        sizes[size] = _size(case, nested, size, counts, modes, kept, announce)
    largest = f"N_DOE = {there.largest}"
    recipe_fit = None
    if recipe is not None:
        inside = announce(f"the paper's recipe for {recipe}, {largest}")
        recipe_fit = paper_recipe(nested, case, recipe, kept, epochs=recipe_epochs, progress=inside)
    inside = announce(f"surrogate with intervals, {largest}")
    learned = {"of": fingerprint(dataset, runs), "modes": modes, "memory": memory} | shared_settings()
    ours = Recipe(modes=modes, memory=memory)
    surrogate = kept.model(Surrogate, "surrogate", learned, lambda: train(dataset, ours, runs=runs, progress=inside))
    announce("comparing with unseen runs and baselines")
    evaluation = evaluate(dataset, surrogate, sizes=())
    announce("measuring times")
    inference = measure_inference(evaluation.surrogate, evaluation.design[0], process_time)
    coupled = coupled_evaluation = None
    if case.forces:
        inside = announce("coupled model")

        def couple():  # without intervals, which the paper's tables do not show
            return Coupled.train(dataset, surrogate, progress=inside, calibrate=False)

        coupled = kept.model(Coupled, "coupled", learned, couple)
        announce("coupled model on unseen runs")
        informed = sizes[there.largest].forces[0].surrogate
        coupled = coupled.despite_verdict()
        coupled_evaluation = evaluate_coupled(dataset, coupled, with_forces=informed)
    models = (coupled, coupled_evaluation, recipe_fit)
    return CaseResults(case, dataset, there.notes, sizes, evaluation, inference, *models)


def _size(case, nested: NestedDesign, size: int, counts, modes: int, kept: Kept, announce: Announcer) -> Size:
    def fit(counts, seed, forces):
        what = f"networks, N_DOE = {size}, K = {counts[-1]}, seed {seed}, {'with' if forces else 'no'} forces"
        return nested.fit(counts, seed, forces, kept, announce(what))

    sweep = fit(counts, SEEDS[0], False)
    return Size(
        runs=len(nested.runs),
        generation=float(np.sum(nested.dataset.computing_seconds(nested.runs))),
        pod=sweep.surrogate.training["pod_cpu_seconds"],
        sweep=sweep,
        sweep_forces=fit(counts, SEEDS[0], True) if case.forces else None,
        plain=tuple(fit((modes,), seed, False) for seed in SEEDS),
        forces=tuple(fit((modes,), seed, True) for seed in SEEDS),
    )
