"""The next runs to make: where the surrogate is most uncertain and no run is near."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.spatial.distance import cdist
from scipy.stats import qmc

from billow.base.errors import InputError
from billow.rom.surrogate.design_space import from_unit, levelled, to_unit
from billow.rom.surrogate.surrogate import Surrogate

NO_DESIGNS = InputError.declare(
    "E-ROM-021",
    "{count} designs cannot be suggested",
    where="recipe {recipe!r}",
    why="it takes a count from 1 to 2,048, and an ensemble that needs no contact forces",
    remedy='ask for at least one, with a surrogate of the recipe "shared": billow train FOLDER',
)

POWER = 4
"""Of the uncertainty, as a weight (docs/rom.md, More runs, and which)."""

CANDIDATES = 2_048
_AT_ONCE = 64


def suggest(
    surrogate: Surrogate,
    count: int,
    known: np.ndarray,
    seed: int = 0,
    drawable: Callable[[np.ndarray], np.ndarray] = np.asarray,
) -> np.ndarray:
    """Designs to simulate next, most useful first: (count, parameters), in each parameter's unit.

    known: (runs, parameters), every design made or planned, unseen ones too; drawable: which of some designs (designs,
    parameters) a study may have, as `StudyDefinition.drawable`

    Candidates are a scrambled Sobol sequence over the trained ranges, with factors at their levels. Each represents its
    surroundings with a power of its `uncertainty` times its distance to the nearest design known or chosen. The next
    design is the candidate that lowers the sum of these most (greedy weighted k-medians); the most uncertain ones lie
    in corners, from which little of the space is learned. Same surrogate, known designs and seed: same rows.
    Raises InputError E-ROM-021 if count is below 1 or above `CANDIDATES`, or the surrogate has no ensemble.
    """
    if not 1 <= count <= CANDIDATES or surrogate.regression.members == 1 or surrogate.forces is not None:
        raise NO_DESIGNS(count=count, recipe=surrogate.recipe)
    surrogate, parameters = surrogate.despite_verdict(), surrogate.parameters
    unit = levelled(qmc.Sobol(len(parameters), rng=seed).random(CANDIDATES), parameters)
    designs = drawable(from_unit(unit, parameters))
    if len(designs) < count:
        why = f"of {CANDIDATES} designs tried {len(designs)} keep to the constraints of the study"
        raise NO_DESIGNS(count=count, recipe=surrogate.recipe, why=why)
    unit, uncertain = to_unit(designs, parameters), uncertainty(surrogate, designs)
    nearest = np.full(len(unit), np.sqrt(len(parameters)))  # the diagonal: nothing is farther
    for point in to_unit(np.reshape(known, (-1, len(parameters))), parameters):
        nearest = np.minimum(nearest, np.linalg.norm(unit - point, axis=1))
    between = cdist(unit, unit)
    chosen = []
    for _ in range(count):
        best = int((np.maximum(nearest - between, 0.0) @ uncertain**POWER).argmax())
        chosen.append(best)
        nearest = np.minimum(nearest, between[best])
    return designs[chosen]


def uncertainty(surrogate: Surrogate, designs: np.ndarray) -> np.ndarray:
    """Spread of the ensemble as root mean square over nodes, times and components: [m], (designs,)."""
    blocks = np.split(designs, range(_AT_ONCE, len(designs), _AT_ONCE))
    return np.concatenate([np.sqrt(np.square(surrogate.spread(block)).mean(axis=(1, 2))) for block in blocks])
