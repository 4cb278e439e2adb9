"""A run that has become meaningless is stopped, with the place and the likely cause.

The check of every step is a handful of scalars, because a bad number anywhere reaches the energy sums at once; only
when they trip is the first bad entity looked for.
"""

from __future__ import annotations

import math

import numpy as np

from billow.base.errors import NumericalStop
from billow.geometry.surface import area_vectors
from billow.parts.fabric.membrane import Membrane
from billow.solver.model import Model, State

COLDEST, HOTTEST = 150.0, 3000.0  # K, gas temperatures outside mean a wrong input
SMALLEST_STEP = 1e-4  # of the first step
SMALLEST_VOLUME = 1e-3  # of a chamber at the start; even a flat bag holds air
SQUEEZED = 0.1  # likewise; gas that is too hot in there is hot because of it
LARGEST_STRETCH = 3.0  # nylon tears at 1.3
LARGEST_GAIN = 0.2  # of the largest energy so far
DEEPEST = 0.5  # of an obstacle's smallest radius; for a plate, of its PLATE_DEPTH


def check_state(model: Model, state: State) -> None:
    """Raises NumericalStop: E-NUM-001 non-finite, -002 gas temperature, -003 energy gain, -005 fabric stretched beyond
    tearing, -006 penetration, -009 a chamber without volume.
    """
    ledger = state.ledger
    # Before what a lack of volume does to pressure and temperature.
    smallest = SQUEEZED if ledger.gas_temperature >= HOTTEST else SMALLEST_VOLUME
    if ledger.gas_volume < smallest:
        _stop_collapsed(model, state)
    if not math.isfinite(ledger.residual):
        _stop_non_finite(model, state)
    if not COLDEST < ledger.gas_temperature < HOTTEST:
        totals = model.gas.totals(state.gas)
        raise NumericalStop(
            "E-NUM-002",
            f"the gas left its range: {totals.temperature:.1f} K (allowed {COLDEST:.0f} to {HOTTEST:.0f} K)",
            where=_when(state),
            why=f"pressure {totals.pressure:.4g} Pa, volume {totals.volume:.4g} m^3, mass {totals.mass:.4g} kg",
            remedy="check inflator.mass_flow (kg/s, seconds) and inflator.temperature (K)",
        )
    if ledger.residual > LARGEST_GAIN * ledger.largest_energy and ledger.largest_energy > 1.0:
        _stop_energy_gain(model, state)
    if state.largest_stretch > LARGEST_STRETCH:
        _stop_torn(model, state)
    for obstacle, deepest in zip(model.obstacles, state.contact.deepest.tolist(), strict=True):
        if deepest > DEEPEST * obstacle.size:
            _stop_penetration(obstacle.name, deepest, state)


def check_step_size(state: State, limit: float) -> None:
    """Raises NumericalStop E-NUM-004 when the stable step collapses."""
    if not limit > SMALLEST_STEP * state.first_dt:
        raise NumericalStop(
            "E-NUM-004",
            f"the stable step collapsed to {limit:.3g} s (it began at {state.first_dt:.3g} s)",
            where=_when(state),
            why=f"the largest stretch of the fabric is {state.largest_stretch:.3g}",
            remedy="check the fabric's moduli and inflator.mass_flow",
        )


def _stop_collapsed(model: Model, state: State) -> None:
    totals = model.gas.totals(state.gas)
    chambers = model.surface.chambers
    volumes = [room.volume for room in totals.chambers or (totals,)]
    worst = min(range(len(volumes)), key=lambda k: volumes[k] / model.start_volumes[k])
    pressure = (totals.chambers or (totals,))[worst].pressure
    raise NumericalStop(
        "E-NUM-009",
        f"chamber {chambers.names[worst]} is all but gone: {1e3 * volumes[worst]:.3g} l of "
        f"{1e3 * model.start_volumes[worst]:.3g} l at the start",
        where=f"chamber {chambers.names[worst]}, {_when(state)}",
        why="its walls passed through each other, or were pushed together by more than the gas can bear; its pressure, "
        f"{pressure:.4g} Pa, means nothing any more",
        remedy="look at the last frames; reduce run.dt_scale, or raise bag.initial_gap",
    )


def _when(state: State) -> str:
    return f"t = {1e3 * state.time:.4f} ms, step {state.step}"


def _stop_energy_gain(model: Model, state: State) -> None:
    ledger = state.ledger
    fastest = int(np.argmax(model.mass * np.sum(state.velocities**2, axis=1)))
    stop = NumericalStop(
        "E-NUM-003",
        f"energy appeared from nowhere: {ledger.residual:.3g} J of {ledger.largest_energy:.3g} J",
        where=f"most of the motion is at node {fastest}, part {_parts(model, fastest)}, {_when(state)}",
        why=f"the step ({state.dt:.3g} s) is too large for the stiffest part, or a load changed its sign",
        remedy="reduce run.dt_scale",
    )
    stop.nodes = (fastest,)
    raise stop


def _stop_torn(model: Model, state: State) -> None:
    membrane, element, stretch = max(
        ((m, *worst_stretch(m, model, state.positions)) for m in model.membranes), key=lambda found: found[2]
    )
    triangle = int(membrane.elements[element])
    nodes = tuple(int(n) for n in model.surface.triangles[triangle])
    stop = NumericalStop(
        "E-NUM-005",
        f"fabric is stretched {stretch:.3g} times its length",
        where=f"triangle {triangle} (nodes {nodes}), part {_parts(model, nodes[0])}, {_when(state)}",
        why="real fabric tears at 1.3; the load is too high or the fabric too soft",
        remedy="check fabric.young_warp, fabric.young_weft, fabric.thickness and inflator.mass_flow",
    )
    stop.nodes = nodes
    raise stop


def worst_stretch(membrane: Membrane, model: Model, positions: np.ndarray) -> tuple[int, float]:
    """The element of a membrane, counted from 0, that is stretched most, and its principal stretch [-]; positions: [m],
    (nodes, 3)."""
    corners = positions[model.surface.triangles[membrane.elements]]
    u, w = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    d = membrane.reference_inverse[:, :, None]
    f1, f2 = u * d[0] + w * d[2], u * d[1] + w * d[3]
    c1, c2, c12 = (np.einsum("ij,ij->i", a, b) for a, b in ((f1, f1), (f2, f2), (f1, f2)))
    stretch = np.sqrt(0.5 * (c1 + c2) + np.sqrt((0.5 * (c1 - c2)) ** 2 + c12**2))
    return int(stretch.argmax()), float(stretch.max())


def _stop_penetration(name: str, depth: float, state: State) -> None:
    raise NumericalStop(
        "E-NUM-006",
        f"fabric went {1e3 * depth:.3g} mm into {name}",
        where=f"obstacle {name}, {_when(state)}",
        why="the obstacle is too soft for the load, so its surface means nothing any more",
        remedy=f"raise obstacles.{name}.slope (N/m per cm^2 of fabric)",
    )


def _parts(model: Model, node: int) -> str:
    around = (model.surface.triangles == node).any(axis=1)
    return ", ".join(sorted({model.surface.part_names[p] for p in model.surface.part[around]}))


def _stop_non_finite(model: Model, state: State) -> None:
    what, place, why, bad = _first_bad(model, state)
    stop = NumericalStop(
        "E-NUM-001",
        f"{what} is not a finite number",
        where=f"{place}, {_when(state)}",
        why=why,
        remedy="reduce run.dt_scale, or check the moduli of the fabric and the slope of the obstacles",
    )
    stop.nodes = tuple(int(node) for node in bad[:8])
    raise stop


def _first_bad(model: Model, state: State) -> tuple[str, str, str, np.ndarray]:
    """What went bad first, where, why, and its nodes. Gas couples all nodes: within one step the whole bag is bad."""
    # A step moves nodes before it evaluates forces: a bad position is older than what it has spoiled since.
    bad = np.flatnonzero(~np.isfinite(state.positions).all(axis=1))
    totals = model.gas.totals(state.gas)
    if not len(bad) and not math.isfinite(totals.pressure + totals.temperature):
        return "a state of the gas", "gas", "all positions are finite, so the gas went bad first", bad
    if not len(bad):
        bad = np.flatnonzero(~np.isfinite(state.velocities).all(axis=1))
    if not len(bad):
        return "a state", "gas or rigid body", "a state of the gas or of a rigid body is not finite", bad
    around = np.flatnonzero((model.surface.triangles == bad[0]).any(axis=1))
    start_area = np.linalg.norm(area_vectors(model.surface.triangles[around], model.start), axis=1).min()
    return (
        "a position or velocity",
        f"node {bad[0]} ({len(bad)} nodes in all), part {_parts(model, int(bad[0]))}",
        f"the step of {state.dt:.3g} s was too large there, or its elements are too small "
        f"(smallest {start_area:.3g} m^2)",
        bad,
    )
