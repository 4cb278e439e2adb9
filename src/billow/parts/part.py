"""The contract of a part: whatever acts in a step owns everything about itself.

Fabric, straps, self-contact, bodies with their contact, the gas and driven nodes are parts. How each of them acts is a
line of `solver/step.py`; what all of them answer is below. The solver, the recorder, the guards, the verdict of a run,
`billow check` and checkpoints ask these questions of every part and know no part by its type.

A part never writes an energy. It returns `Booking`s, and the ledger adds them up. It never names a column of a file
either: it gives a `Quantity`, and `results/history.py` writes and reads it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from billow.base.errors import Concern
from billow.base.quality import Criterion
from billow.geometry.assembly import COLUMNS
from billow.geometry.surface import Surface

MOTION, STORED, LOST, RECEIVED = "motion", "stored", "lost", "received"
"""Sides of the energy balance: kinetic energy, recoverable energy, heat, and work received from outside."""

VARYING = {"varying": True}
"""Metadata of a field of a part's state whose arrays may have more or fewer rows than at the start."""


class Account(NamedTuple):
    """Where a kind of energy is booked.

    side: MOTION, STORED, LOST or RECEIVED. renewed: each step's bookings say how much there is now, and replace those
    of the step before; otherwise they say what one step has added.
    """

    name: str
    side: str
    renewed: bool


class Booking(NamedTuple):
    """An energy [J] for an account. What is booked in every step may be a plain pair instead, which is made in a fifth
    of the time."""

    account: Account
    energy: float


KINETIC = Account("kinetic", MOTION, renewed=True)
"""Kinetic energy of the fabric's nodes."""
DAMPING = Account("damping", LOST, renewed=False)
"""Heat of viscous damping: fabric, straps and mass damping."""
HYSTERESIS = Account("hysteresis", LOST, renewed=True)
"""Heat of fabric that unloads below the curve it was loaded on, and what torn straps held."""
FRICTION = Account("friction", LOST, renewed=False)
"""Heat of contact: friction and damping, of bodies and between layers of fabric."""
GRAVITY_WORK = Account("gravity_work", RECEIVED, renewed=False)
DRIVE_WORK = Account("drive_work", RECEIVED, renewed=False)
"""Work of whatever moves driven nodes and obstacles."""

WORKING_PRESSURE = 20e3
"""Gauge pressure [Pa] at which vents, fabric and obstacles are judged before a run."""

MYLAR_VOLUME = 1.21852
"""Volume of two sewn inextensible discs of radius a, in a^3 (Paulsen, Am. Math. Monthly 101, 1994)."""


class Quantity(NamedTuple):
    """One value of the histories.

    of: name of what it belongs to, empty for the whole model. value: a number, a vector (3,) or a quaternion (4,), w
    first.
    """

    of: str
    name: str
    unit: str
    value: float | np.ndarray


WHOLE_MODEL = "the whole model"
"""Kind of the owner without a name."""


class Owner(NamedTuple):
    """Something that quantities belong to. kind: what a user calls it, "vent" or "free obstacle"; name: the user's;
    quantities: names of those it may have."""

    kind: str
    name: str
    quantities: tuple[str, ...]


class Moment(NamedTuple):
    """A run between two steps: time [s], number of the step, its length dt [s]; positions [m] and velocities [m/s]:
    (nodes, 3)."""

    time: float
    step: int
    dt: float
    positions: np.ndarray
    velocities: np.ndarray

    @property
    def when(self) -> str:
        return f"t = {1e3 * self.time:.4f} ms, step {self.step}"


class Loads:
    """What acts on the nodes of a bag in a step: fabric sets `entries` and `volumes`, and the parts after it add to the
    rest.

    entries: forces of fabric [N] and a third of the area vectors [m^2] of the triangles, (entries, COLUMNS), as an
    `Assembly` sums them up. volumes: of the chambers [m^3], (chambers,). gauge: uniform pressure in the chambers above
    ambient [Pa], (chambers + 1,), the last one, of the surroundings, zero; who sets it sets it in every step.
    node_force: other forces [N], (nodes, 3), of the few who act on few nodes; zero at the start of a step, because who
    gives it to the nodes leaves zeros. corner_force: forces on the corners of the triangles [N], (triangles, 3, 3), of
    those who act everywhere; (0, 3, 3) as long as nobody does.
    """

    def __init__(self, entries: int, surface: Surface):
        self.entries = np.zeros((entries, COLUMNS))
        self.volumes = np.zeros(surface.chambers.count)
        self.gauge = np.zeros(surface.chambers.count + 1)
        self.node_force = np.zeros((surface.node_count, 3))
        self.corner_force = self._none = np.empty((0, 3, 3))
        self._room = None
        self._triangles = surface.triangle_count

    def open(self) -> None:
        """No force but what is set."""
        self.gauge.fill(0.0)
        self.node_force.fill(0.0)
        self.corner_force = self._none

    def taken(self) -> None:
        """The nodes have received all of it, and `node_force` is zero again."""
        self.corner_force = self._none

    def at_corners(self) -> np.ndarray:
        """`corner_force`, to be added to."""
        if not len(self.corner_force):
            if self._room is None:
                self._room = np.empty((self._triangles, 3, 3))
            self._room.fill(0.0)
            self.corner_force = self._room
        return self.corner_force


@dataclass(frozen=True)
class Setting:
    """What a part may see when it looks for what is probably not meant.

    surface and start: the bag and its positions at time zero [m], (nodes, 3). fabric_area: [m^2], as cut. end_time [s].
    """

    surface: Surface
    start: np.ndarray
    fabric_area: float
    end_time: float

    @property
    def across(self) -> float:
        """Size of the bag [m]."""
        return extent(self.start)

    @property
    def inflated_volume(self) -> float:
        """About the volume [m^3] the bag will have: that of two sewn discs of each chamber's share of the fabric."""
        chambers = self.surface.chambers.count
        radius = np.sqrt(self.fabric_area / chambers / (2.0 * np.pi))
        return float(chambers * MYLAR_VOLUME * radius**3)


def extent(points: np.ndarray) -> float:
    """Size [m] of points [m] (n, 3), however they are turned: across the sphere about their middle that holds all."""
    return 2.0 * float(np.linalg.norm(points - points.mean(axis=0), axis=1).max()) if len(points) else 0.0


@dataclass
class Frame:
    """Fields of an output frame by name: at nodes, on triangles, and on bars of straps; (n,) or (n, 3) each."""

    point: dict[str, np.ndarray] = field(default_factory=dict)
    cell: dict[str, np.ndarray] = field(default_factory=dict)
    bar: dict[str, np.ndarray] = field(default_factory=dict)


class Part:
    """What every part answers; a part overrides the questions to which it has something to say.

    `state` is the part's own: whatever of it changes, in arrays, numbers, tuples and dataclasses of them, so that it
    can be saved and restored. Fields whose arrays change their length carry the metadata VARYING.
    """

    accounts: tuple[Account, ...] = ()
    """Accounts it books to."""

    def start(self, bag):
        """Its state at time zero; bag: surface, positions and velocities of the nodes then."""
        return None

    def owners(self) -> Iterator[Owner]:
        """What its quantities belong to."""
        return iter(())

    def quantities(self, state, moment: Moment) -> Iterator[Quantity]:
        """Its share of a row of the histories."""
        return iter(())

    def frame(self, state, moment: Moment) -> Frame:
        """Its share of an output frame."""
        return Frame()

    def guard(self, state, moment: Moment) -> None:
        """Raise NumericalStop if its state has become meaningless. Called after every step: a few comparisons."""

    def books(self, state, moment: Moment, history) -> dict[str, float]:
        """Its entries in the ledger of run.json at the end of a run. history: `results.history.History` of the run."""
        return {}

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        """Criteria by which a run is judged. books: entries of all parts and of the solver."""
        return iter(())

    def remarks(self, state) -> list[str]:
        """Lines for the log when a run ends."""
        return []

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        """What of it is allowed but probably not meant."""
        return iter(())

    def seconds_per_step(self, state, dt: float, end: float) -> float:
        """Rough cost of a step of dt [s], mean over a run to `end` [s], on one core of a 2020s processor [s]."""
        return 0.0
