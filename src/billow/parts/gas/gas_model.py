"""The contract every gas fulfils.

A gas fills the bag and pushes on it. It sees the bag's surface and how it moved (`Bag`), and answers with forces on
nodes: it adds to `Loads`, a uniform pressure to `gauge`, and to nothing else. It promises, and
tests/contracts/test_gas_contract.py checks for every implementation:

1. mass closes: injected = inside + vented + leaked - what was there at the start, to rounding;
2. energy closes: U - U0 = enthalpy in - enthalpy out - work - heat lost, to rounding;
3. a sealed rigid bag obeys p V = m R T;
4. gas at rest puts no net force on a closed bag;
5. a scene moving at constant velocity changes nothing beyond the scheme's order;
6. work given equals work received: what the gas books as p dV is what the nodal forces do, to the scheme's order;
7. same seed, same bits, for any number of threads.

Inflators with their jets, passages, ambient, initial gas and heat loss are the same objects for all gases
(`supply.supply.Supply`). `NoGas` is an ordinary implementation.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NamedTuple

import numpy as np

from billow.base.errors import Concern
from billow.base.quality import Criterion
from billow.geometry.surface import Surface
from billow.parts.part import Loads, Setting


@dataclass
class Bag:
    """All a gas may see.

    positions: [m] at the end of the step, before: at its start, velocities: [m/s] at its middle, all (nodes, 3). before
    is positions where no step was made, and (0, 3) for a gas that does not look back. touched: (shapes, nodes) bool,
    nodes in contact with each shape of a body, and in a last row with other layers of fabric; None where nothing can be
    touched. measured: volumes of the chambers [m^3], (chambers,), None where nobody has measured them.
    """

    surface: Surface
    positions: np.ndarray
    velocities: np.ndarray
    touched: np.ndarray | None = None
    before: np.ndarray | None = None
    measured: np.ndarray | None = None

    @property
    def volumes(self) -> np.ndarray:
        """Of the chambers [m^3], (chambers,)."""
        if self.measured is not None:
            return self.measured
        return self.surface.chambers.volumes(self.surface.triangles, self.positions)

    def __post_init__(self):
        if self.before is None:
            self.before = self.positions


@dataclass(frozen=True)
class ChamberTotals:
    """State of the gas in one chamber: pressure [Pa] absolute, temperature [K], volume [m^3], mass [kg], energy [J]."""

    name: str
    pressure: float
    temperature: float
    volume: float
    mass: float
    energy: float


@dataclass(slots=True)  # not frozen: one is made in every step, which costs a frozen one three times the time
class GasTotals:
    """State of the whole gas.

    pressure [Pa] absolute, temperature [K], volume [m^3], mass_by_species [kg] (species,), energy [J], and running sums
    since the start: injected, vented, leaked, drawn_in [kg]; enthalpy_in, enthalpy_out [J]; work [J] done on the fabric
    including against the ambient; ambient_work [J] = p_amb (V - V0); jet_work [J]; jet_impulse_in, jet_impulse_out [N
    s]: thrust of all jets over time, and the part of it that found fabric in line of sight; mass_error, energy_error:
    largest relative ledger error of any step so far [-]; heat_lost [J] to the surroundings. blocked_area: of vents and
    fabric, by contact, now [m^2].

    Of several chambers pressure is the mean over volume and temperature the mean over mass; `chambers` has them one by
    one, and is empty for a single one. vented_by, leaked_by [kg] split the outflow by vent and by part of the fabric;
    passed [kg] is what went through passages between chambers, back flow subtracted.
    """

    pressure: float
    temperature: float
    volume: float
    mass_by_species: np.ndarray
    energy: float
    injected: float = 0.0
    vented: float = 0.0
    leaked: float = 0.0
    drawn_in: float = 0.0
    enthalpy_in: float = 0.0
    enthalpy_out: float = 0.0
    work: float = 0.0
    ambient_work: float = 0.0
    jet_work: float = 0.0
    jet_impulse_in: float = 0.0
    jet_impulse_out: float = 0.0
    mass_error: float = 0.0
    energy_error: float = 0.0
    heat_lost: float = 0.0
    blocked_area: float = 0.0
    vented_by: Mapping[str, float] = field(default_factory=dict)
    leaked_by: Mapping[str, float] = field(default_factory=dict)
    passed: Mapping[str, float] = field(default_factory=dict)
    chambers: tuple[ChamberTotals, ...] = ()

    @property
    def mass(self) -> float:
        """Mass inside [kg]."""
        return float(self.mass_by_species.sum())

    @property
    def work_on_fabric(self) -> float:
        """Net work on the fabric [J]: pressure against ambient, plus jets."""
        return self.work - self.ambient_work + self.jet_work


class Vitals(NamedTuple):
    """What is looked at after every step: net work on the fabric [J], pressure [Pa], temperature [K] and energy [J] of
    all gas, volume of each chamber [m^3]."""

    work_on_fabric: float
    pressure: float
    temperature: float
    energy: float
    volumes: list[float]


class GasModel(ABC):
    """A gas: parameters only; everything that changes is in the state it hands out.

    looks_back: whether it reads `Bag.before`, which a run keeps only for those who do.
    """

    looks_back: ClassVar[bool] = True

    @abstractmethod
    def start(self, bag: Bag) -> object:
        """State at time zero for the bag's start shape."""

    @abstractmethod
    def advance(self, gas, bag: Bag, time: float, dt: float, loads: Loads) -> None:
        """From `time` to `time + dt` [s]; the bag has already moved. Changes `gas`, adds to `loads`."""

    @abstractmethod
    def totals(self, gas) -> GasTotals:
        """Totals of the state."""

    def vitals(self, gas) -> Vitals:
        """The few of the totals that every step asks for."""
        now = self.totals(gas)
        volumes = [chamber.volume for chamber in now.chambers] or [now.volume]
        return Vitals(now.work_on_fabric, now.pressure, now.temperature, now.energy, volumes)

    @abstractmethod
    def fields(self, gas) -> dict[str, np.ndarray]:
        """What users want to see on triangles, (triangles,) or (triangles, 3): at least "gauge_pressure" [Pa], behind
        minus ahead. `pressure` is absolute wherever it stands. Units are those of `results.vtkhdf.UNITS`."""

    def stable_dt(self, gas, limit: float) -> float:
        """Step [s] of the structure that the gas takes now, of those up to the limit that all else has; that one, for a
        gas that acts at the end of a step on where the fabric is then."""
        return limit

    def view(self) -> LocalGas | None:
        """How a gas that differs from place to place shows it; None for one that is the same everywhere."""
        return None

    def books(self, gas) -> dict[str, float]:
        """Its own entries in the ledger of run.json."""
        return {}

    def verdicts(self, books: Mapping[str, float]) -> Iterator[Criterion]:
        """Its own criteria for the verdict of a run; books: entries of the ledger."""
        return iter(())

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        """What of it is allowed but probably not meant."""
        return iter(())

    def remarks(self, gas) -> list[str]:
        """Lines for the log when a run ends."""
        return []

    def seconds_per_step(self, gas, dt: float, end: float) -> float:
        """Rough cost of a step of dt [s], mean over a run to `end` [s], on one core of a 2020s processor [s]."""
        return 0.0


@dataclass(frozen=True)
class Content:
    """All the gas that is in the chambers, as one gas hands it to another.

    masses: [kg], (chambers, species); energy [J], volume [m^3] and temperature [K], a guess: (chambers,). is_open:
    (passages,) bool, passages that have opened for good.
    """

    masses: np.ndarray
    energy: np.ndarray
    volume: np.ndarray
    temperature: np.ndarray
    is_open: np.ndarray


class LocalGas(GasModel):
    """A gas that differs from place to place, and says how.

    on_lattice: whether its cells are those of a cubic lattice of which every chamber has its own; they then say which
    "chamber" each is of, (n,).
    """

    on_lattice: ClassVar[bool] = False

    def view(self) -> LocalGas:
        return self

    @abstractmethod
    def cells(self, gas) -> dict[str, np.ndarray]:
        """Boxes to look at: "centre" and "size" [m], (n, 3); "pressure" [Pa] absolute, "temperature" [K], "density"
        [kg/m^3], (n,); "velocity" [m/s], (n, 3); and what else there is."""

    @abstractmethod
    def at(self, gas, places: np.ndarray) -> dict[str, np.ndarray]:
        """Readings at places [m], (m, 3): "pressure" [Pa] absolute, "temperature" [K], "density" [kg/m^3], (m,);
        "velocity" [m/s], (m, 3). Outside the bag those of the surroundings."""

    def points(self, gas) -> dict[str, np.ndarray]:
        """The particles, if it has any: "position" [m], (n, 3), and what is known of each by name, (n,) or (n, 3)."""
        return {}


class SwitchableGas(LocalGas):
    """A local gas that can hand all it holds to uniform pressure."""

    @abstractmethod
    def can_hand_over(self, gas) -> bool:
        """Whether every chamber holds gas."""

    @abstractmethod
    def hand_over(self, gas, bag: Bag, time: float, dt: float) -> Content:
        """The last step, from `time` to `time + dt` [s]: books the half of the step's work that belongs to the force at
        its beginning, gives away all it holds, and keeps nothing but its books."""

    @abstractmethod
    def book_work(self, gas, work: float, ambient_work: float) -> None:
        """Book the work [J] of the force at the end of that step, which is another gas'; ambient_work: the part of it
        against the ambient."""

    @abstractmethod
    def outside(self, positions: np.ndarray, places: np.ndarray, chamber: int) -> np.ndarray:
        """Whether places [m], (m, 3), are not in a chamber of the bag as it stands, (m,) bool; positions: [m], (nodes,
        3)."""
