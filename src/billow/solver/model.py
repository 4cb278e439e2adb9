"""What a run is made of: `Model` never changes, `State` is everything that does.

Copying a state and continuing from the copy gives the same bits as not stopping.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.compiled import CHUNK
from billow.geometry.surface import Surface
from billow.parts.bodies.rigid_body import RigidBody, RigidState
from billow.parts.bodies.rigid_contact import ContactState, ObstacleTable, Plate, SuperEllipsoid, SurfaceLaw
from billow.parts.fabric.birth import Birth
from billow.parts.fabric.fabric_law import SUMS
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_model import Bag, GasModel
from billow.parts.self_contact import Pairs, SelfContact
from billow.parts.straps import Straps
from billow.solver.ledger import Ledger

PLATE_DEPTH = 0.1
"""Thickness [m] that a plate is taken to have."""


@dataclass(frozen=True)
class Obstacle:
    """Something rigid the fabric can touch."""

    name: str
    shape: Plate | SuperEllipsoid
    law: SurfaceLaw
    body: RigidBody
    start: RigidState

    @cached_property
    def size(self) -> float:
        """Smallest radius [m]; PLATE_DEPTH for a plate."""
        return PLATE_DEPTH if isinstance(self.shape, Plate) else float(self.shape.radii.min())


@dataclass(frozen=True)
class Model:
    """Everything constant during a run.

    start: positions at time zero, [m], (nodes, 3). mass: [kg], (nodes,). contact_area: tributary reference area, [m^2],
    (nodes,). fixed: (nodes,) bool. gravity: [m/s^2], (3,). mass_damping: rate alpha of -2 alpha m v, [1/s], used to
    find equilibria and off in deployments. birth: for a start shape that is stretched against the flat cut.
    self_contact: None if layers of fabric may pass through each other.
    """

    surface: Surface
    start: np.ndarray
    membranes: tuple[Membrane, ...]
    straps: Straps
    gas: GasModel
    obstacles: tuple[Obstacle, ...]
    mass: np.ndarray
    contact_area: np.ndarray
    fixed: np.ndarray
    gravity: np.ndarray
    mass_damping: float = 0.0
    birth: Birth | None = None
    self_contact: SelfContact | None = None

    @cached_property
    def obstacle_table(self) -> ObstacleTable:
        """Shapes and laws of the obstacles, as kernels need them."""
        return ObstacleTable.build([o.shape for o in self.obstacles], [o.law for o in self.obstacles])

    @cached_property
    def start_volumes(self) -> list[float]:
        """Volume of each chamber at time zero [m^3]."""
        return self.surface.chambers.volumes(self.surface.triangles, self.start).tolist()

    @cached_property
    def has_gravity(self) -> bool:
        return bool(self.gravity.any())

    @property
    def inverse_mass(self) -> np.ndarray:
        """[1/kg], (nodes,); zero for fixed nodes and nodes without fabric."""
        free = ~self.fixed & (self.mass > 0.0)
        return np.where(free, 1.0 / np.where(free, self.mass, 1.0), 0.0)


@dataclass
class State:
    """Everything that changes.

    positions [m], velocities [m/s], nodal_force [N]: (nodes, 3) at `time` [s]. corner_force: [N], (triangles, 3, 3),
    of the last evaluation. membrane_history: what each membrane's fabric remembers, (elements, width). gas: the gas
    model's own state. bodies: one per obstacle. step: number of steps taken.
    """

    time: float
    step: int
    positions: np.ndarray
    velocities: np.ndarray
    nodal_force: np.ndarray
    corner_force: np.ndarray
    inverse_mass: np.ndarray
    bar: np.ndarray
    membrane_history: tuple[np.ndarray, ...]
    membrane_sums: tuple[np.ndarray, ...]
    gas: object
    bodies: tuple[RigidState, ...]
    contact: ContactState
    pairs: Pairs
    ledger: Ledger
    largest_stretch: float = 1.0
    interval: int = 0
    steps_left: int = 0
    dt: float = 0.0
    first_dt: float = 0.0


def start_state(model: Model) -> State:
    """State at time zero, at rest; forces are not evaluated yet."""
    n = len(model.start)
    positions = model.start.copy()
    velocities = np.zeros((n, 3))
    return State(
        time=0.0,
        step=0,
        positions=positions,
        velocities=velocities,
        nodal_force=np.zeros((n, 3)),
        corner_force=np.zeros((model.surface.triangle_count, 3, 3)),
        inverse_mass=model.inverse_mass,
        bar=model.straps.fresh(),
        membrane_history=tuple(m.fresh_history() for m in model.membranes),
        membrane_sums=tuple(np.zeros((-(-len(m.elements) // CHUNK), SUMS)) for m in model.membranes),
        gas=model.gas.start(Bag(model.surface, positions, velocities)),
        bodies=tuple(
            RigidState(
                o.start.centre.copy(),
                o.start.quaternion.copy(),
                o.start.velocity.copy(),
                o.start.angular_momentum.copy(),
            )
            for o in model.obstacles
        ),
        contact=ContactState.none(len(model.obstacles), n),
        pairs=model.self_contact.fresh() if model.self_contact else Pairs.none(0, 0),
        ledger=Ledger(),
    )
