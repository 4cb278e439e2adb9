"""One test case of the paper from our own runs: everything its tables and figures are made of."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from billow.reproductions.rom_paper.available import Available
from billow.reproductions.rom_paper.fits import Fit, fit
from billow.reproductions.rom_paper.inference import Inference, measure_inference
from billow.reproductions.rom_paper.kept import Kept, fingerprint
from billow.reproductions.rom_paper.published import EPOCHS, MODES, PublishedCase
from billow.reproductions.rom_paper.recipe import RecipeFit, paper_recipe
from billow.reproductions.rom_paper.reductions import FORCE_COMPONENTS, FORCE_MODES, Reduced, force_inputs, reduced
from billow.rom.coupled.coupled_evaluation import CoupledEvaluation, evaluate_coupled
from billow.rom.coupled.coupled_model import Coupled
from billow.rom.judge.evaluate import SWEEP_MODES, Evaluation, evaluate
from billow.rom.judge.learning_curve import LearningCurve
from billow.rom.judge.learning_curve import fit as fit_learning_curve
from billow.rom.learn.reduction import DEFAULT_MEMORY
from billow.rom.learn.training import Plan, learn_networks, shared_settings
from billow.rom.surrogate.surrogate import Surrogate

SEEDS = (0, 1)
"""Of the pairs of fits with and without forces: what differs less than they do is no difference."""


@dataclass(frozen=True, eq=False)
class Size:
    """One nested design.

    runs: used; generation: [s] their wall times together; read, pod: [s]; pod in processor time
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
    """sizes: N_DOE -> results, rising; evaluation, surrogate, inference: of the largest, with K of the tables."""

    case: PublishedCase
    dataset: object
    notes: tuple[str, ...]
    sizes: dict[int, Size]
    surrogate: Surrogate
    evaluation: Evaluation
    inference: Inference
    coupled: Coupled | None = None
    coupled_evaluation: CoupledEvaluation | None = None
    recipe: RecipeFit | None = None

    @property
    def largest(self) -> int:
        return max(self.sizes)

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
    dataset,
    there: Available,
    kept: Kept,
    *,
    recipe: str | None = None,
    recipe_epochs: int = EPOCHS,
    memory: int = DEFAULT_MEMORY,
    progress: Callable[[int, int, str], None] | None = None,
) -> CaseResults:
    """Everything of one case; pieces that are kept are not made again.

    recipe: the component for which the paper's own recipe is trained too, or None; recipe_epochs: its epochs
    progress: called as progress(done, total, what) before each piece
    Errors as `Surrogate.train` and `evaluate`; E-CPL-001 if no training run felt a force.
    """
    fits_each = 1 + 2 * len(SEEDS) + case.forces
    announce = _Announcer(progress, len(there.sizes) * (fits_each + 2) + 3 + 3 * case.forces + (recipe is not None))
    sizes, last = {}, None
    for size, runs in there.sizes.items():
        sizes[size], last = _size(case, dataset, there, size, runs, kept, memory, announce)
    recipe_fit = None
    if recipe is not None:
        said = announce(f"the paper's recipe for {recipe}, N_DOE = {there.largest}")
        recipe_fit = paper_recipe(dataset, last, case, recipe, kept, epochs=recipe_epochs, progress=said)
    said = announce(f"surrogate with intervals, N_DOE = {there.largest}")
    surrogate = _surrogate(dataset, there.sizes[there.largest], _modes(dataset, there), kept, memory, said)
    announce("comparing with unseen runs and baselines")
    evaluation = evaluate(dataset, surrogate, sizes=())
    announce("measuring times")
    inference = measure_inference(surrogate, evaluation.design[0])
    coupled = coupled_evaluation = None
    if case.forces:
        said = announce("coupled model")
        coupled = _coupled(dataset, surrogate, there, kept, said)
        said = announce(f"surrogate with true forces, N_DOE = {there.largest}")
        informed = _with_forces(dataset, there, last, surrogate.modes, kept, memory, said)
        announce("coupled model on unseen runs")
        coupled_evaluation = evaluate_coupled(dataset, coupled, with_forces=informed)
    return CaseResults(
        case, dataset, there.notes, sizes, surrogate, evaluation, inference, coupled, coupled_evaluation, recipe_fit
    )


def _modes(dataset, there: Available) -> int:
    """K of the tables, or fewer if the smallest design has not so many snapshots."""
    columns = min(len(runs) for runs in there.sizes.values()) * len(dataset.times)
    return min(MODES, columns, len(dataset.reference))


def _size(case, dataset, there, size, runs, kept, memory, announce) -> tuple[Size, Reduced]:
    most = min(len(runs) * len(dataset.times), len(dataset.reference))
    counts = tuple(count for count in SWEEP_MODES if count <= most)
    announce(f"bases, N_DOE = {size}")
    made = reduced(dataset, runs, there.unseen, counts[-1], kept, memory)
    announce(f"force inputs, N_DOE = {size}")
    known = force_inputs(dataset, runs, there.unseen, made, kept, memory)
    modes = (_modes(dataset, there),)

    def trained(counts, seed, forces):
        said = announce(f"networks, N_DOE = {size}, K = {counts[-1]}, seed {seed}, {'with' if forces else 'no'} forces")
        return fit(dataset, made, counts, kept, seed=seed, forces=known if forces else None, progress=said)

    return Size(
        runs=len(runs),
        generation=float(np.sum(dataset.wall_seconds(runs))),
        pod=made.reduction.pod_cpu_seconds,
        sweep=trained(counts, SEEDS[0], False),
        sweep_forces=trained(counts, SEEDS[0], True) if case.forces else None,
        plain=tuple(trained(modes, seed, False) for seed in SEEDS),
        forces=tuple(trained(modes, seed, True) for seed in SEEDS),
    ), made


def _surrogate(dataset, runs, modes, kept, memory, said) -> Surrogate:
    inputs = {"of": fingerprint(dataset, runs), "modes": modes, "memory": memory} | shared_settings()
    path = kept.path("surrogate", inputs)
    if not path.is_file():
        Surrogate.train(dataset, modes=modes, runs=runs, memory=memory, progress=said).save(path)
    return Surrogate.load(path)


def _coupled(dataset, surrogate, there, kept, said) -> Coupled:
    runs = there.sizes[there.largest]
    path: Path = kept.path("coupled", {"of": fingerprint(dataset, runs), "modes": surrogate.modes} | shared_settings())
    if not path.is_file():
        Coupled.train(dataset, surrogate, progress=said).save(path)
    return Coupled.load(path)


def _with_forces(dataset, there, made: Reduced, modes, kept, memory, said) -> Surrogate:
    """A surrogate of the largest design that sees the contact forces of the time before."""
    runs = there.sizes[there.largest]
    known = force_inputs(dataset, runs, there.unseen, made, kept, memory)
    inputs = {"of": made.made_of, "modes": modes, "force_modes": known.model.width} | shared_settings()
    path = kept.path("surrogate-with-forces", inputs)
    if not path.is_file():
        plan = Plan("shared", modes, SEEDS[0], None, FORCE_MODES, FORCE_COMPONENTS, memory)
        given = known.model, known.seen
        Surrogate(**learn_networks(dataset, made.reduction.cut(modes), plan, given, said)).save(path)
    return Surrogate.load(path)


class _Announcer:
    """Says what is done next, and makes of a piece's own progress part of the whole."""

    def __init__(self, progress, total):
        self._progress, self._done, self._total = progress, 0, total

    def __call__(self, what):
        if self._progress is None:
            return None
        done, self._done = self._done, self._done + 1
        self._progress(done, self._total, what)

        def inside(epoch, epochs, loss):
            if epoch % 250 == 0:  # only the paper's recipe trains so long
                self._progress(done, self._total, f"{what}: epoch {epoch:,} of {epochs:,}")

        return inside
