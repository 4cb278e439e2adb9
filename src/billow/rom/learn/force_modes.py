"""Learning the force inputs of a surrogate from its training runs (docs/theory.md, Contact forces as inputs).

Forces that fit into memory are read once, larger ones three times: for their norms, bases and coefficients.
"""

from __future__ import annotations

from functools import cache, partial

import numpy as np

from billow.base.errors import InputError
from billow.rom.learn.dataset import Dataset, collect, snapshot_bytes
from billow.rom.learn.pod import bases_of, join, join_all, pod, sketch
from billow.rom.learn.reduction import BLOCK_SHARE, DEFAULT_MEMORY, blocks_of
from billow.rom.surrogate.basis import COMPONENTS, Basis
from billow.rom.surrogate.force_inputs import ForceInputs, previous

NO_SUCH_FORCES = InputError.declare(
    "E-CPL-001",
    "contact forces {components!r} cannot be inputs",
    where="force_components",
    cause="another letter than x, y or z, or a component in which no run has a force",
    remedy='choose among "x", "y" and "z" those in which the obstacle pushes, or train without forces',
)

OUTLIERS = 3.0
"""The paper's n_std: [-]. The paper gives no value."""


def learn_force_inputs(
    dataset: Dataset, runs, modes: int, components: str, seed: int, memory: int = DEFAULT_MEMORY
) -> tuple[ForceInputs, np.ndarray]:
    """Force modes from the recorded forces of `runs`, and the inputs of these runs: [-], (runs, times, width).

    modes: M of each component; components: letters, such as "z" or "xyz"; memory: [byte], as `force_bases`
    Raises InputError E-CPL-001 for components that do not exist or carry no force, E-ROM-007 for a number of
    modes that cannot be made, E-ROM-009 for forces that are not finite.
    """
    chosen = tuple(COMPONENTS.index(letter) for letter in components if letter in COMPONENTS)
    if not chosen or len(set(chosen)) != len(components):
        raise NO_SUCH_FORCES(components=components, why="components are x, y and z, each at most once")
    bases, coefficients, usual = force_bases(dataset, tuple(runs), modes, chosen, seed, memory)
    if None in bases:
        empty = COMPONENTS[chosen[bases.index(None)]]
        raise NO_SUCH_FORCES(components=empty, why="no training run has a force in it")
    learned = [known[:, kept].astype(float) for known, kept in zip(coefficients, usual, strict=True)]
    # A mode that the rank of the data does not reach has coefficients of rounding only.
    least = [1e-6 * basis.singular_values[0] for basis in bases]
    mean = np.array([known.mean(axis=1) for known in learned])
    deviation = np.array([np.maximum(known.std(axis=1), low) for known, low in zip(learned, least, strict=True)])
    found = ForceInputs(chosen, np.stack([basis.modes for basis in bases]), mean, deviation)
    # (components, modes, runs * times) -> (runs, times, components, modes)
    by_run = np.stack(coefficients).reshape(len(chosen), modes, len(runs), -1).transpose(2, 3, 0, 1)
    return found, found.scaled(previous(by_run))


def force_bases(
    dataset: Dataset, runs: tuple[str, ...], modes: int, components: tuple[int, ...], seed: int, memory: int
) -> tuple[list[Basis | None], list[np.ndarray | None], np.ndarray]:
    """Of each component: the basis and the coefficients of all snapshots in it, [N], (modes, runs * times), both None
    if no run has a force; and which snapshots the bases were made from, (components, runs * times) bool.

    components: index of each; memory: [byte]; snapshots that do not fit, with their copy without outliers, are streamed
    Raises InputError E-ROM-007 for a number of modes that cannot be made, E-ROM-009 for forces that are not finite.
    """
    size = len(components) * snapshot_bytes(dataset, runs) // 3
    in_memory = 2 * size <= memory
    blocks = [runs] if in_memory else blocks_of(runs, memory * len(runs) // (BLOCK_SHARE * size))
    read = lambda block: collect(dataset, block, "contact_force", components)  # noqa: E731
    read = cache(read) if in_memory else read
    norms = np.concatenate([[np.linalg.norm(m, axis=0) for m in read(block)] for block in blocks], axis=1)
    usual = np.stack([ordinary(of_one) for of_one in norms])
    if in_memory:
        pairs = zip(read(runs), usual, strict=True)
        made = [pod(kept, modes, seed) if np.any(kept := matrix[:, inside]) else None for matrix, inside in pairs]
    else:
        by_block = np.split(usual, np.cumsum([len(block) * len(dataset.times) for block in blocks])[:-1], axis=1)
        parts = (
            [sketch(matrix[None][:, :, inside], modes, seed) for matrix, inside in zip(read(block), kept, strict=True)]
            for block, kept in zip(blocks, by_block, strict=True)
        )
        pair = partial(join, modes=modes, seed=seed)
        whole = join_all(parts, lambda one, other: [pair(a, b) for a, b in zip(one, other, strict=True)])
        made = [bases_of(of_one, modes, seed)[0] if of_one.energy.any() else None for of_one in whole]
    known = [[basis and basis.coefficients(m) for basis, m in zip(made, read(block), strict=True)] for block in blocks]
    return made, [basis and np.hstack(of) for basis, *of in zip(made, *known, strict=True)], usual


def ordinary(norms: np.ndarray) -> np.ndarray:
    """Which snapshots have a norm within mean +- `OUTLIERS` deviations of all: norms [N], (columns,) -> (columns,)."""
    return np.abs(norms - norms.mean()) <= OUTLIERS * norms.std()
