"""One nested design: its runs reduced once, the networks fitted to them with and without forces, all judged alike."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.reproductions.rom_paper.kept import Kept, fingerprint, shared_settings
from billow.rom.judge.errors import ErrorsByModes, Projection, project
from billow.rom.learn.dataset import Dataset, read_run
from billow.rom.learn.force_modes import learn_force_inputs
from billow.rom.learn.progress import Progress
from billow.rom.learn.reduction import Reduction, reduce_runs
from billow.rom.learn.train import Recipe, train_networks
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.force_inputs import ForceInputs, previous
from billow.rom.surrogate.surrogate import Surrogate

SEED = 0
FORCE_MODES = 3
"""M of the paper's second test case."""
FORCE_COMPONENTS = "z"


@dataclass(frozen=True, eq=False)
class Fit(ErrorsByModes):
    """One surrogate of the recipe `shared`, judged on unseen runs."""

    surrogate: Surrogate

    @property
    def cpu_seconds(self) -> float:
        """[s] of training the networks."""
        return self.surrogate.training["network_cpu_seconds"]


class NestedDesign:
    """runs: of the design; unseen: test runs; modes: the most that any fit has; memory: [byte], as `Recipe`.

    Runs are reduced when the first fit has to be made.
    """

    def __init__(self, dataset: Dataset, runs: tuple[str, ...], unseen: tuple[str, ...], modes: int, memory: int):
        self.dataset, self.runs, self.unseen, self.modes, self.memory = dataset, tuple(runs), unseen, modes, memory
        self._projection: Projection | None = None

    @cached_property
    def made_of(self) -> dict:
        """What a fit depends on besides its recipe."""
        return {"of": fingerprint(self.dataset, self.runs), "most_modes": self.modes, "memory": self.memory}

    @cached_property
    def reduction(self) -> Reduction:
        """Bases and coefficients with all modes."""
        return reduce_runs(self.dataset, self.runs, self.modes, SEED, self.memory)

    @cached_property
    def forces(self) -> tuple[ForceInputs, np.ndarray]:
        """Force inputs of the runs, as `learn_force_inputs` returns them: E-CPL-001 if no run has a force."""
        return learn_force_inputs(self.dataset, self.runs, FORCE_MODES, FORCE_COMPONENTS, SEED, self.memory)

    def projection(self, bases: tuple[Basis, ...]) -> Projection:
        """The unseen runs in bases of this design; projected once, with the most modes so far."""
        if self._projection is None or self._projection.known.shape[3] < len(bases[0].modes):
            self._projection = project((read_run(self.dataset, run) for run in self.unseen), bases)
        return self._projection

    def fit(self, counts: tuple[int, ...], seed: int, forces: bool, kept: Kept, progress: Progress | None) -> Fit:
        """Train with `counts[-1]` modes and judge with each of `counts`.

        forces: contact forces of the previous time are inputs too; of the unseen runs they are the true ones, known
        only because these runs have been made. Errors as `train`.
        """
        # Without a clock, which models with forces cannot have: what forces gain is to be seen.
        how = Recipe(
            modes=counts[-1],
            seed=seed,
            force_modes=FORCE_MODES * forces,
            force_components=FORCE_COMPONENTS,
            clock=False,
        )

        def make() -> Surrogate:
            given = self.forces if forces else None
            return train_networks(self.dataset, self.reduction.cut(how.modes), how, given, progress)

        inputs = self.made_of | {"modes": how.modes, "seed": seed, "force_modes": how.force_modes} | shared_settings()
        surrogate = kept.model(Surrogate, "fit", inputs, make)
        learned = []
        for run, design in zip(self.unseen, self.dataset.design(self.unseen), strict=True):
            true = previous(self.dataset.snapshots("contact_force", [run]))[0] if forces else None
            learned.append(surrogate.coefficients(design, previous_forces=true))
        judged = ErrorsByModes.of(counts, self.projection(surrogate.bases), np.array(learned))
        return Fit(counts, judged.truncation, judged.regression, surrogate)
