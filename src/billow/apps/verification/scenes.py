"""Models of one shape and one fabric, and their equilibrium: shared by the structural cases."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from billow.case.build import nodal_mass
from billow.geometry.bag_shapes import BagShape
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_model import Bag, GasModel, GasTotals
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.gas.uniform.pressure_load import add_pressure
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, State
from billow.solver.run import Recorder, Schedule, run


@dataclass
class LoadedVolume:
    """start and volume: enclosed at time zero and now, [m^3]; triangle_count."""

    start: float
    volume: float
    triangle_count: int


@dataclass(frozen=True)
class PrescribedPressure(GasModel):
    """A constant gauge pressure [Pa]: a gas model for cases that look for an equilibrium."""

    gauge: float
    ambient: float = 101325.0

    def start(self, bag: Bag) -> LoadedVolume:
        volume = bag.surface.volume(bag.positions)
        return LoadedVolume(volume, volume, bag.surface.triangle_count)

    def advance(self, gas: LoadedVolume, bag: Bag, time: float, dt: float, corner_force: np.ndarray) -> None:
        gas.volume = bag.surface.volume(bag.positions)
        add_pressure(bag.surface.triangles, bag.positions, self.gauge, corner_force)

    def totals(self, gas: LoadedVolume) -> GasTotals:
        grown = gas.volume - gas.start
        return GasTotals(
            pressure=self.ambient + self.gauge, temperature=295.0, volume=gas.volume, mass_by_species=np.zeros(0),
            energy=0.0, work=(self.ambient + self.gauge) * grown, ambient_work=self.ambient * grown,
        )  # fmt: skip

    def fields(self, gas: LoadedVolume) -> dict[str, np.ndarray]:
        return {"pressure": np.full(gas.triangle_count, self.gauge)}


def isotropic(
    young: float, poisson: float, density: float, thickness: float, compression: bool = False, damping: float = 0.0
) -> LinearFabric:
    """Fabric with equal moduli [Pa] in all directions; without compression it follows the principal tension field."""
    shear = 0.5 * young / (1.0 + poisson)
    return LinearFabric(density, thickness, young, young, poisson, shear, compression, damping)


def fabric_model(
    shape: BagShape, fabric: LinearFabric, gas: GasModel | None = None, *, start: np.ndarray | None = None,
    bodies: tuple[Body, ...] = (), gravity: tuple[float, float, float] = (0.0, 0.0, 0.0),
    mass_damping: float = 0.0,
) -> Model:  # fmt: skip
    """Model of a shape made of one fabric all over; start: [m], (nodes, 3), where not the shape's own positions."""
    surface = shape.surface
    membrane = Membrane.build(fabric, np.arange(surface.triangle_count), shape.reference)
    area = flat_area(shape.reference)
    start = shape.positions if start is None else np.ascontiguousarray(start)
    contact_area = nodal_share(surface.triangles.astype(np.int64), area, surface.node_count)
    return Model(
        surface=surface,
        start=start,
        mass=nodal_mass(shape, membrane, NO_STRAPS),
        fixed=shape.fixed,
        gravity=np.array(gravity),
        gas=GasPart(gas or NoGas(), surface, start),
        fabric=Fabric(surface, (membrane,)),
        straps=NO_STRAPS,
        bodies=Bodies(bodies, contact_area, np.array(gravity)),
        mass_damping=mass_damping,
    )


@dataclass
class Observer(Recorder):
    """Recorder that calls `watch(state)` at every history row."""

    watch: Callable[[State], None]

    def history(self, model: Model, state: State) -> None:
        self.watch(state)


def relax(model: Model, duration: float) -> State:
    """State after `duration` [s] of the production time loop, whose step follows the stretch in 40 intervals."""
    return run(model, Schedule(duration, 1, 40))


def tension(model: Model, state: State) -> np.ndarray:
    """Membrane force tensor of each triangle in space, [N/m], (triangles, 3, 3), from its corner forces.

    The forces f of a triangle in uniform tension N on its corners x obey sum f (x) x = -A N (divergence theorem), with
    A its present area. The corner forces of the last step must be those of the membrane alone.
    """
    corners = state.positions[model.surface.triangles]
    area = 0.5 * np.linalg.norm(np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]), axis=1)
    arm = corners - corners.mean(axis=1, keepdims=True)
    return -np.einsum("tci,tcj->tij", model.work.corner_force, arm) / area[:, None, None]
