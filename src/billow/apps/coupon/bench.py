"""The bench: takes a specimen through loading and unloading with the production solver and records what clamps feel.

The clamps move along a raised cosine, so that they start, turn and stop without a jerk; the test lasts long enough for
waves to cross the specimen many times, and the kinetic energy says how static it was.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.apps.coupon.specimen import Specimen
from billow.geometry.surface import nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.driven_nodes import DrivenNodes
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, State
from billow.solver.run import Recorder, Schedule, run

SAMPLES = 400


@dataclass(frozen=True)
class Measured:
    """What a test gave, one entry a sample.

    curves: names; strain (samples, curves) [-] or [rad], stress (samples, curves) [Pa]: force per current width and
    thickness; machine_force [N]; time [s]. work: done by the clamps, stored: recoverable in the fabric at the end
    less that at the start, lost: damping and hysteresis, created: by a law that gives back more than it took (FORM 4),
    [J]; kinetic_share: largest kinetic energy over the largest work [-].
    """

    curves: tuple[str, ...]
    time: np.ndarray
    strain: np.ndarray
    stress: np.ndarray
    machine_force: np.ndarray
    work: float
    stored: float
    lost: float
    created: float
    kinetic_share: float


class Samples(Recorder):
    """Reads the specimen at every history row, and the largest energies of all steps."""

    def __init__(self, specimen: Specimen, path: Callable[[float], float], progress: Callable[[float], None] | None):
        self.specimen, self.path, self.progress = specimen, path, progress
        self.rows: list[list[float]] = []
        self.mounted = self.most_work = self.most_kinetic = 0.0

    def history(self, model: Model, state: State) -> None:
        specimen, force = self.specimen, state.nodal_force
        if not self.rows:
            self.mounted = state.ledger["strain"]
        amount = self.path(state.time)
        strain, stress = specimen.measure(amount, state.positions, force)
        self.rows.append([state.time, specimen.machine_force(amount, force), *strain, *stress])
        if self.progress is not None:
            self.progress(state.interval / SAMPLES)

    def step(self, model: Model, state: State) -> None:
        free = ~self.specimen.clamped
        velocity = state.velocities[free]
        self.most_work = max(self.most_work, state.ledger["drive_work"])
        self.most_kinetic = max(self.most_kinetic, 0.5 * float(model.mass[free] @ np.sum(velocity * velocity, axis=1)))


def run_test(
    specimen: Specimen,
    fabric,
    amount: float,
    duration: float = 0.05,
    progress: Callable[[float], None] | None = None,
) -> Measured:
    """Load to `amount` and back within `duration` [s]; fabric: a fabric law. Raises NumericalStop."""

    def path(time: float) -> float:
        """Where the machine is at a time [s]: up to `amount` and back."""
        return amount * 0.5 * (1.0 - np.cos(2.0 * np.pi * time / duration))

    samples = Samples(specimen, path, progress)
    # What a law does is looked at here, the energy that it creates included: no gain stops the test.
    schedule = Schedule(duration, 1, SAMPLES, largest_gain=math.inf)
    state = run(build_model(specimen, fabric, path), schedule, samples)
    table, count, ledger = np.array(samples.rows), len(specimen.curves), state.ledger
    return Measured(
        curves=specimen.curves,
        time=table[:, 0],
        strain=table[:, 2 : 2 + count],
        stress=table[:, 2 + count :] / fabric.thickness,
        machine_force=table[:, 1],
        work=ledger["drive_work"],
        stored=ledger["strain"] - samples.mounted,
        lost=ledger["damping"] + ledger["hysteresis"],
        created=ledger.residual,
        kinetic_share=samples.most_kinetic / max(samples.most_work, 1e-300),
    )


def build_model(specimen: Specimen, fabric, path: Callable[[float], float]) -> Model:
    """Model of a specimen of a fabric in still air, its clamps driven along a path."""
    surface, flat = specimen.sheet.surface, specimen.sheet.flat
    membrane = Membrane.build(fabric, np.arange(surface.triangle_count), flat[surface.triangles])
    mass = nodal_share(surface.triangles.astype(np.int64), membrane.mass, surface.node_count)
    start = np.column_stack([specimen.mounted * flat, np.zeros(len(flat))])
    clamps, gravity = np.flatnonzero(specimen.clamped), np.zeros(3)

    def places(time: float) -> np.ndarray:
        return np.column_stack([specimen.places(path(time)), np.zeros(len(clamps))])

    return Model(
        surface=surface,
        start=start,
        mass=mass,
        fixed=specimen.clamped,
        gravity=gravity,
        gas=GasPart(NoGas(), surface, start),
        fabric=Fabric(surface, (membrane,)),
        straps=NO_STRAPS,
        bodies=Bodies((), np.zeros(surface.node_count), gravity),
        driven=DrivenNodes(clamps, mass[clamps], places),
    )
