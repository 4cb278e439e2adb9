"""Bases, coefficients and force inputs of a nested design, computed once for all its fits."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np

from billow.reproductions.rom_paper.kept import Kept, Piece, fingerprint
from billow.rom.judge.errors import Projection, project
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.force_modes import learn_force_inputs
from billow.rom.learn.reduction import Reduction, reduce_runs
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.force_inputs import ForceInputs, previous

SEED = 0
FORCE_MODES = 3
"""M of the paper's second test case."""
FORCE_COMPONENTS = "z"


@dataclass(frozen=True, eq=False)
class Reduced:
    """reduction: of the training runs; unseen: the test runs in the same bases; made_of: fingerprint of both."""

    reduction: Reduction
    unseen: Projection
    unseen_design: np.ndarray
    made_of: str


@dataclass(frozen=True, eq=False)
class Forces:
    """model: from nodal forces to inputs; seen, unseen: inputs of training and test runs, (runs, times, width)."""

    model: ForceInputs
    seen: np.ndarray
    unseen: np.ndarray


def reduced(dataset: Dataset, runs, test, modes: int, kept: Kept, memory: int) -> Reduced:
    """The reduction of `runs` with `modes` modes, and `test` in it. memory: [byte], as `reduce_runs`."""
    made_of = fingerprint(dataset, [*runs, *test])
    inputs = {"of": made_of, "modes": modes, "seed": SEED, "memory": memory}
    arrays, record = kept.piece("reduction", inputs, lambda: _reduce(dataset, runs, test, modes, memory))
    bases = tuple(
        Basis(m, s, float(e))
        for m, s, e in zip(arrays["modes"], arrays["singular_values"], arrays["energy"], strict=True)
    )
    reduction = Reduction(
        bases=bases,
        coefficients=arrays["coefficients"],
        design=np.asarray(dataset.design(runs), float),
        times=np.asarray(dataset.times, float),
        runs=tuple(runs),
        lost_by_time=arrays["lost_by_time"],
        lost_by_node=arrays["lost_by_node"],
        **record["reduction"],
    )
    unseen = Projection(arrays["unseen.known"], arrays["unseen.outside"], bases[0].modes.shape[1])
    return Reduced(reduction, unseen, np.asarray(dataset.design(test), float), made_of)


def _reduce(dataset, runs, test, modes, memory) -> Piece:
    reduction = reduce_runs(dataset, runs, modes, SEED, memory)
    unseen = project((dataset.snapshots("displacement", [run])[0] for run in test), reduction.bases)
    arrays = {
        "modes": np.stack([basis.modes for basis in reduction.bases]),
        "singular_values": np.stack([basis.singular_values for basis in reduction.bases]),
        "energy": np.array([basis.energy for basis in reduction.bases]),
        "unseen.known": unseen.known,
        "unseen.outside": unseen.outside,
    }
    arrays |= {name: getattr(reduction, name) for name in ("coefficients", "lost_by_time", "lost_by_node")}
    said = ("snapshot_bytes", "read_seconds", "pod_seconds", "pod_cpu_seconds")
    return arrays, {"reduction": {name: getattr(reduction, name) for name in said}}


def force_inputs(dataset: Dataset, runs, test, reduced: Reduced, kept: Kept, memory: int) -> Forces:
    """Inputs from the contact forces of training and unseen runs, as the paper makes them; the unseen runs' are true,
    known only because these runs have been made. memory: [byte], as `force_bases`. Errors as `learn_force_inputs`."""
    inputs = {"of": reduced.made_of, "modes": FORCE_MODES, "components": FORCE_COMPONENTS, "seed": SEED}

    def make() -> Piece:
        begun = time.process_time()
        model, seen = learn_force_inputs(dataset, runs, FORCE_MODES, FORCE_COMPONENTS, SEED, memory)
        unseen = [model(previous(dataset.snapshots("contact_force", [run])))[0] for run in test]
        arrays = {"modes": model.modes, "mean": model.mean, "deviation": model.deviation}
        arrays |= {"components": np.array(model.components), "seen": seen, "unseen": np.stack(unseen)}
        return arrays, {"cpu_seconds": time.process_time() - begun}

    arrays, _ = kept.piece("forces", inputs, make)
    model = ForceInputs(tuple(arrays["components"].tolist()), arrays["modes"], arrays["mean"], arrays["deviation"])
    return Forces(model, arrays["seen"], arrays["unseen"])
