"""What each parameter of a design does, as the surrogate says it: one goes through its range, the others stay in the
middle of theirs, factors at a level."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.rom.surrogate.basis import Z
from billow.rom.surrogate.design_space import from_unit, levelled
from billow.rom.surrogate.surrogate import Surrogate

STEPS = 9
"""Values of a parameter, from the lower end of its range to the upper."""


@dataclass(frozen=True)
class Effect:
    """label: of the parameter. heights: [m], (steps,), largest z of the bag in a deployment. moved: [m], root mean
    square distance between the shapes at the two ends of the range, over all nodes and times."""

    label: str
    heights: np.ndarray
    moved: float


def effects(surrogate: Surrogate) -> list[Effect]:
    """Of every parameter, the strongest first; none for a surrogate that needs contact forces."""
    if surrogate.forces is not None:
        return []
    asked, found = surrogate.despite_verdict(), []
    start = surrogate.reference[:, Z]
    for k, parameter in enumerate(surrogate.parameters):
        unit = np.full((STEPS, len(surrogate.parameters)), 0.5)
        unit[:, k] = np.linspace(0.0, 1.0, STEPS)
        designs = from_unit(levelled(unit, surrogate.parameters), surrogate.parameters)
        shapes = [asked.predict(design) for design in designs]
        heights = np.array([(start + shape[..., Z]).max() for shape in shapes])
        squares = np.square(shapes[-1] - shapes[0]).sum(axis=2, dtype=float)
        found.append(Effect(parameter.label, heights, float(np.sqrt(squares.mean()))))
    return sorted(found, key=lambda effect: -effect.moved)
