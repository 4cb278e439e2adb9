"""What a run is made of: `Model` never changes, `State` is everything that does.

Copying a state and continuing from the copy gives the same bits as not stopping.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from billow.geometry.surface import Surface
from billow.parts.bodies.bodies import Bodies, BodiesState
from billow.parts.driven_nodes import DrivenNodes, DrivenState
from billow.parts.fabric.fabric import Fabric, FabricState
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.gas_part import GasPart, GasState
from billow.parts.layers.layers import Layers
from billow.parts.layers.pairs import Pairs as LayerPairs
from billow.parts.part import DAMPING, GRAVITY_WORK, KINETIC, VARYING, Account, Loads, Moment, Part, Setting
from billow.parts.self_contact import Pairs, SelfContact
from billow.parts.straps import Straps
from billow.parts.tear_seams import TearSeams
from billow.solver.ledger import Ledger

PARTS = ("gas", "fabric", "straps", "bodies", "self_contact", "layers", "driven", "tear_seams")
"""Fields of `Model` and of `State` that hold the parts and what changes of them."""


@dataclass(frozen=True)
class Model:
    """Everything constant during a run: the nodes and the parts.

    start: positions at time zero, [m], (nodes, 3). mass: [kg], (nodes,). fixed: (nodes,) bool. gravity: [m/s^2], (3,).
    mass_damping: rate alpha of -2 alpha m v, [1/s], used to find equilibria and off in deployments. self_contact:
    springs between layers of fabric, and layers: impulses between them; at most one of both. driven: None if no node is
    moved from outside; tear_seams: None if there are none. start_velocity: of nodes that are not fixed [m/s], (nodes,
    3), None if the bag rests.
    """

    surface: Surface
    start: np.ndarray
    mass: np.ndarray
    fixed: np.ndarray
    gravity: np.ndarray
    gas: GasPart
    fabric: Fabric
    straps: Straps
    bodies: Bodies
    self_contact: SelfContact | None = None
    layers: Layers | None = None
    driven: DrivenNodes | None = None
    tear_seams: TearSeams | None = None
    mass_damping: float = 0.0
    start_velocity: np.ndarray | None = None

    @cached_property
    def parts(self) -> tuple[tuple[str, Part], ...]:
        """The parts there are, each with the name of its field."""
        return tuple((name, getattr(self, name)) for name in PARTS if getattr(self, name) is not None)

    @cached_property
    def guarded(self) -> tuple[tuple[str, Part], ...]:
        """Of the parts, the gas first, those that have something to guard."""
        gas, *others = self.parts
        return (gas, *((name, part) for name, part in others if type(part).guard is not Part.guard))

    @cached_property
    def accounts(self) -> tuple[Account, ...]:
        """Of the solver and of all parts."""
        gas, *others = (part.accounts for _, part in self.parts)
        return (*gas, KINETIC, DAMPING, GRAVITY_WORK, *(account for accounts in others for account in accounts))

    @cached_property
    def inverse_mass(self) -> np.ndarray:
        """[1/kg], (nodes,); zero for fixed nodes and nodes without fabric."""
        free = ~self.fixed & (self.mass > 0.0)
        return np.where(free, 1.0 / np.where(free, self.mass, 1.0), 0.0)

    @cached_property
    def rate_of_straps(self) -> float:
        """1/dt^2 of the largest step that straps and tear seams allow [1/s^2]; they may share nodes."""
        inverse_mass = self.inverse_mass
        if self.driven is not None:  # which yield in the directions in which they are not held
            inverse_mass = inverse_mass.copy()
            inverse_mass[self.driven.nodes] = self.driven.yielding
        seams = self.tear_seams.squared_rate(inverse_mass) if self.tear_seams is not None else 0.0
        return self.straps.squared_rate(inverse_mass) + seams

    @cached_property
    def has_gravity(self) -> bool:
        return bool(self.gravity.any())

    @cached_property
    def work(self) -> Work:
        surface = self.surface
        assembly = self.fabric.assembly
        gathering = (assembly.start, assembly.entry, assembly.sides, assembly.pair)
        corners = surface.corner_start, surface.corners
        looks_back = self.gas.model.looks_back or self.layers is not None
        before = np.zeros_like(self.start) if looks_back else np.empty((0, 3))
        return Work(Loads(len(assembly.entry), surface), gathering, corners, before)

    def setting(self, end_time: float) -> Setting:
        """What parts see when they look for what is probably not meant."""
        return Setting(self.surface, self.start, self.fabric.area, end_time)


@dataclass(frozen=True)
class Work:
    """Arrays a step works in; nothing in them outlives it. before: positions at its start [m], (nodes, 3), or
    (0, 3) where nobody asks for them. gathering, corners: what `gather_and_kick` reads of the assembly and of the
    surface."""

    loads: Loads
    gathering: tuple[np.ndarray, ...]
    corners: tuple[np.ndarray, ...]
    before: np.ndarray


@dataclass
class Pace:
    """How long steps are. share: of the stable step [-]. step, residual: number of steps taken and residual of the
    energy balance [J] when it was chosen; lost: what a stable step would lose, as last seen [J]."""

    share: float = 1.0
    step: int = 0
    residual: float = 0.0
    lost: float = 0.0


@dataclass
class State:
    """Everything that changes.

    positions [m], velocities [m/s], nodal_force [N]: (nodes, 3) at `time` [s]. step: number of steps taken. gas to
    tear_seams: of the parts. interval: history intervals that are over; steps_left of `dt` [s] to the end of the
    present one; first_dt: the first step [s].
    """

    time: float
    step: int
    positions: np.ndarray
    velocities: np.ndarray
    nodal_force: np.ndarray
    gas: GasState
    fabric: FabricState
    straps: np.ndarray
    bodies: BodiesState
    self_contact: Pairs | None = field(metadata=VARYING)
    layers: LayerPairs | None
    driven: DrivenState | None
    tear_seams: np.ndarray | None
    ledger: Ledger
    interval: int = 0
    steps_left: int = 0
    dt: float = 0.0
    first_dt: float = 0.0
    pace: Pace = field(default_factory=Pace)

    def of(self, part: str):
        """What changes of a part, by the name of its field."""
        return getattr(self, part)

    @property
    def moment(self) -> Moment:
        return Moment(self.time, self.step, self.dt, self.positions, self.velocities)


def start_state(model: Model) -> State:
    """State at time zero; forces are not evaluated yet."""
    positions, velocities = model.start.copy(), np.zeros_like(model.start)
    if model.start_velocity is not None:
        velocities[...] = model.start_velocity
    bag = Bag(model.surface, positions, velocities)
    parts = dict.fromkeys(PARTS) | {name: part.start(bag) for name, part in model.parts}
    return State(
        time=0.0, step=0, positions=positions, velocities=velocities, nodal_force=np.zeros_like(positions),
        ledger=Ledger.of(model.accounts), **parts,
    )  # fmt: skip
