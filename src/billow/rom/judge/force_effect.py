"""What knowing the contact forces of an unseen run would gain: the ROM paper's comparison (its Figure 7).

The paper feeds its model the contact forces that the solver found in the very run it is asked to predict. Nobody has
them before that run is made, so this is a bound on what force inputs can give, not an accuracy in use. Numbers carry it
in their name: `true_forces`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass

import numpy as np

from billow.rom.judge.rmse import Summary, snapshot_rmse
from billow.rom.learn.force_inputs import previous
from billow.rom.learn.snapshots import COMPONENTS
from billow.rom.surrogate.surrogate import Surrogate


@dataclass(frozen=True, eq=False)
class ForceEffect:
    """RMSE on unseen runs with and without the forces they really felt; both models are learned alike.

    components: of the force, such as "z"; modes: M of each
    seeds: of the pairs of models compared
    true_forces, without: [m], (seeds, runs, times, 3) float64, RMSE of each snapshot (inside paper equation 5)
    """

    components: str
    modes: int
    seeds: tuple[int, ...]
    true_forces: np.ndarray
    without: np.ndarray

    def gain(self, component: int) -> float:
        """By what part true forces lower the mean RMSE of a displacement component: [-], negative if they raise it."""
        return float(1.0 - self.true_forces[..., component].mean() / self.without[..., component].mean())

    def between_seeds(self, component: int) -> float:
        """Deviation of `gain` from seed to seed: [-]; 0 for one seed. A smaller gain says nothing."""
        gains = 1.0 - (self.true_forces.mean(axis=(1, 2)) / self.without.mean(axis=(1, 2)))[:, component]
        return float(gains.std(ddof=1)) if len(gains) > 1 else 0.0

    def record(self) -> dict:
        """For metrics.json; lengths in metres."""
        return {
            "force_components": self.components,
            "force_modes": self.modes,
            "seeds": list(self.seeds),
            "rmse_m_with_true_forces_of_the_unseen_run": _by_component(self.true_forces),
            "rmse_m_without_forces": _by_component(self.without),
            "gain": {axis: self.gain(c) for c, axis in enumerate(COMPONENTS)},
            "gain_deviation_between_seeds": {axis: self.between_seeds(c) for c, axis in enumerate(COMPONENTS)},
        }


def force_effect(
    dataset,
    *,
    force_modes: int = 3,
    force_components: str = "z",
    modes: int = 12,
    recipe: str = "shared",
    runs=None,
    seeds: tuple[int, ...] = (0, 1),
    epochs: int | None = None,
    progress: Callable[[int, int, str], None] | None = None,
) -> ForceEffect:
    """Train with and without contact forces as inputs and ask both for the unseen runs of a dataset.

    Arguments as `Surrogate.train`; for each of `seeds` a pair of models. progress: called as progress(done, total,
    what). Raises the errors of `Surrogate.train`.
    """
    rmse = {0: [], force_modes: []}
    for done, seed in enumerate(seeds):
        for count, errors in rmse.items():
            if progress is not None:
                progress(2 * done + (count > 0), 2 * len(seeds), f"training with {count} force modes, seed {seed}")
            surrogate = Surrogate.train(
                dataset, recipe, modes, runs, seed, epochs, force_modes=count, force_components=force_components
            )
            errors.append(_unseen_rmse(dataset, surrogate))
    return ForceEffect(force_components, force_modes, tuple(seeds), np.array(rmse[force_modes]), np.array(rmse[0]))


def _unseen_rmse(dataset, surrogate) -> np.ndarray:
    errors = []
    for run, design in zip(dataset.test, dataset.design(dataset.test), strict=True):
        forces = None
        if surrogate.forces is not None:
            forces = previous(dataset.snapshots("contact_force", [run]))[0]
        answer = surrogate.predict(design, previous_forces=forces)
        errors.append(snapshot_rmse(answer, dataset.snapshots("displacement", [run])[0]))
    return np.array(errors)


def _by_component(rmse) -> dict:
    return {axis: asdict(Summary.of(rmse[..., c].reshape(-1, rmse.shape[2]))) for c, axis in enumerate(COMPONENTS)}
