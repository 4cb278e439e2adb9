"""Reduced bases of contact forces, without the snapshots whose force is out of the ordinary.

Forces that fit into memory are read once. Larger ones are read three times, for their norms, their bases (block by
block, as `streaming` joins them) and their coefficients.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from billow.rom.learn.basis import Basis, pod
from billow.rom.learn.reduction import BLOCK_SHARE
from billow.rom.learn.snapshots import collect, snapshot_bytes
from billow.rom.learn.streaming import Sketch, bases_of, join, join_all, sketch

OUTLIERS = 3.0
"""The paper's n_std: [-]. The paper gives no value."""


def force_bases(
    dataset, runs: tuple[str, ...], modes: int, components: tuple[int, ...], seed: int, memory: int
) -> tuple[list[Basis | None], list[np.ndarray | None], np.ndarray]:
    """Of each component: the basis and the coefficients of all snapshots in it, [N], (modes, runs * times) float32,
    both None if no run felt a force; and whether each snapshot is one that bases were made from, (components, runs *
    times).

    components: index of each; memory: [byte] the snapshots and their copy without outliers fit into, or are streamed
    Raises InputError E-ROM-007 for a number of modes that cannot be made, E-ROM-009 for forces that are not finite.
    """
    size = len(components) * snapshot_bytes(dataset, runs) // 3
    if 2 * size <= memory:
        matrices = collect(dataset, runs, "contact_force", components).matrices
        usual = np.stack([ordinary(np.linalg.norm(matrix, axis=0)) for matrix in matrices])
        made = [
            pod(kept, modes, seed) if np.any(kept := m[:, u]) else None for m, u in zip(matrices, usual, strict=True)
        ]
        return made, [basis and basis.coefficients(m) for basis, m in zip(made, matrices, strict=True)], usual
    count = max(1, memory * len(runs) // (BLOCK_SHARE * size))
    blocks = [runs[first : first + count] for first in range(0, len(runs), count)]

    def read(block):
        return collect(dataset, block, "contact_force", components).matrices

    norms = np.concatenate([np.linalg.norm(read(block), axis=1) for block in blocks], axis=1)
    usual = np.stack([ordinary(of_one) for of_one in norms])
    by_block = np.split(usual, np.cumsum([len(block) * len(dataset.times) for block in blocks])[:-1], axis=1)
    parts = (_sketches(read(block), kept, modes, seed) for block, kept in zip(blocks, by_block, strict=True))
    pair = partial(join, modes=modes, seed=seed)
    whole = join_all(parts, lambda one, other: [pair(a, b) for a, b in zip(one, other, strict=True)])
    made = [bases_of(of_one, modes, seed)[0] if of_one.energy.any() else None for of_one in whole]
    parts = [[basis and basis.coefficients(m) for basis, m in zip(made, read(block), strict=True)] for block in blocks]
    return made, [None if basis is None else np.hstack(of) for basis, *of in zip(made, *parts, strict=True)], usual


def ordinary(norms: np.ndarray) -> np.ndarray:
    """Which snapshots have a norm within mean +- `OUTLIERS` deviations of all: norms [N], (columns,) -> (columns,)."""
    return np.abs(norms - norms.mean()) <= OUTLIERS * norms.std()


def _sketches(matrices, usual, modes, seed) -> list[Sketch]:
    """One of each component, whose outliers differ."""
    return [sketch(matrix[None][:, :, kept], modes, seed) for matrix, kept in zip(matrices, usual, strict=True)]
