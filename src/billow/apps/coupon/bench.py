"""The bench: takes a specimen through loading and unloading with the production solver and records what clamps feel.

The clamps move along a raised cosine, so that they start, turn and stop without a jerk; the test lasts long enough for
waves to cross the specimen many times, and the kinetic energy says how static it was.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.apps.coupon.specimen import Specimen
from billow.geometry.surface import nodal_share
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, State
from billow.solver.run import Schedule, begin, plan
from billow.solver.step import advance

SAMPLES = 400


@dataclass(frozen=True)
class Measured:
    """What a test gave, one entry a sample.

    curves: names; strain (samples, curves) [-] or [rad], stress (samples, curves) [Pa]: force per current width and
    thickness; machine_force [N]; time [s]. work: done by the clamps, stored: recoverable in the fabric at the end
    less that at the start, lost: damping and hysteresis, [J]; kinetic_share: largest kinetic energy over the largest
    work [-].
    """

    curves: tuple[str, ...]
    time: np.ndarray
    strain: np.ndarray
    stress: np.ndarray
    machine_force: np.ndarray
    work: float
    stored: float
    lost: float
    kinetic_share: float

    @property
    def peak(self) -> int:
        """Sample at which unloading begins."""
        return int(np.argmax(self.strain[:, 0]))


def run_test(
    specimen: Specimen,
    fabric,
    amount: float,
    duration: float = 0.05,
    progress: Callable[[float], None] | None = None,
) -> Measured:
    """Load to `amount` and back within `duration` [s]; fabric: a fabric law. Raises NumericalStop."""
    model = build_model(specimen, fabric)
    schedule = Schedule(duration, 1, SAMPLES)
    state = begin(model, schedule)
    rows, mounted = [_sample(specimen, model, state, 0.0)], state.ledger.strain
    work, most_work, kinetic = 0.0, 0.0, 0.0
    clamps = np.flatnonzero(specimen.clamped)
    for sample in range(SAMPLES):
        target = duration * (sample + 1) / SAMPLES
        plan(model, schedule, state, target)
        for _ in range(state.steps_left):
            now = path(amount, duration, state.time + state.dt)
            moves = specimen.places(now) - state.positions[clamps, :2]
            state.velocities[clamps, :2] = moves / state.dt
            before = state.nodal_force[clamps, :2].copy()
            advance(model, state, state.dt)
            work -= 0.5 * float(np.sum((before + state.nodal_force[clamps, :2]) * moves))
            most_work = max(most_work, work)
            free = state.velocities[~specimen.clamped]
            kinetic = max(kinetic, 0.5 * float(model.mass[~specimen.clamped] @ np.sum(free * free, axis=1)))
        state.steps_left = 0
        rows.append(_sample(specimen, model, state, path(amount, duration, target)))
        if progress is not None:
            progress((sample + 1) / SAMPLES)
    table = np.array(rows)
    count = len(specimen.curves)
    strain, force = table[:, 2 : 2 + count], table[:, 2 + count :]
    ledger = state.ledger
    return Measured(
        specimen.curves, table[:, 0], strain, force / fabric.thickness, table[:, 1], work, ledger.strain - mounted,
        ledger.damping + ledger.hysteresis, kinetic / max(most_work, 1e-300),
    )  # fmt: skip


def path(amount: float, duration: float, time: float) -> float:
    """Where the machine is at a time [s]: up to `amount` and back."""
    return amount * 0.5 * (1.0 - np.cos(2.0 * np.pi * time / duration))


def build_model(specimen: Specimen, fabric) -> Model:
    """Model of a specimen of a fabric in still air."""
    surface, flat = specimen.sheet.surface, specimen.sheet.flat
    membrane = Membrane.build(fabric, np.arange(surface.triangle_count), flat[surface.triangles])
    triangles = surface.triangles.astype(np.int64)
    return Model(
        surface=surface,
        start=np.column_stack([specimen.mounted * flat, np.zeros(len(flat))]),
        membranes=(membrane,),
        straps=NO_STRAPS,
        gas=NoGas(),
        obstacles=(),
        mass=nodal_share(triangles, membrane.mass, surface.node_count),
        contact_area=np.zeros(surface.node_count),
        fixed=specimen.clamped,
        gravity=np.zeros(3),
    )


def _sample(specimen: Specimen, model: Model, state: State, amount: float) -> list[float]:
    strain, stress = specimen.measure(amount, state.positions, state.nodal_force)
    return [state.time, specimen.machine_force(amount, state.nodal_force), *strain, *stress]
