"""Everything about the corpuscular gas that changes: particles, what pushes on the fabric, and the books."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from billow.parts.gas.corpuscular.cells import Cells
from billow.parts.gas.corpuscular.impact_bank import ImpactBank
from billow.parts.gas.corpuscular.injection import Delivery
from billow.parts.gas.corpuscular.merging import Remainder
from billow.parts.gas.corpuscular.particles import Particles
from billow.parts.gas.corpuscular.wall_load import WallLoad
from billow.parts.part import VARYING


@dataclass
class CorpuscularState:
    """Everything about the gas that changes.

    molecules: that a particle stands for, twice as many after each of the `merges`. positions: of the surface at
    gas_time [s], [m] (nodes, 3). steps_to_go: of the structure until the next gas step. pass_probability and patch
    (triangles,), is_open (passages,). owed: air to be drawn in that is no particle yet [kg] (passages, species).
    wanted: mass flow to the surroundings [kg/s], and short: of it, what has not left yet [kg] (passages,). pool: energy
    owed to the gas of each chamber [J]. Of the chambers: volume [m^3], now, and volume_struck, in the middle of the
    last gas step; pressure [Pa], temperature [K], gamma (cp/cv), masses in particles [kg] (chambers, species).

    Books, sums since the start: left [kg] (passages, species), drawn [kg] (species,), passed from behind to ahead [kg]
    (passages,), impulse: of all that came in less that of all that left [N s] (3,); energies [J]; escaped: particles
    found outside their chamber and put back; parked: put beside a wall after too many hits.
    """

    molecules: float
    particles: Particles = field(metadata=VARYING)
    cells: Cells = field(metadata=VARYING)
    bank: ImpactBank
    load: WallLoad
    deliveries: tuple[Delivery, ...]
    remainder: Remainder
    positions: np.ndarray
    pass_probability: np.ndarray
    patch: np.ndarray
    is_open: np.ndarray
    owed: np.ndarray
    wanted: np.ndarray
    short: np.ndarray
    pool: np.ndarray
    volume: np.ndarray
    volume_struck: np.ndarray
    pressure: np.ndarray
    temperature: np.ndarray
    gamma: np.ndarray
    masses: np.ndarray
    left: np.ndarray
    drawn: np.ndarray
    passed: np.ndarray
    impulse: np.ndarray
    start_masses: np.ndarray
    start_momentum: np.ndarray
    start_energy: float = 0.0
    start_volume: float = 0.0
    particle_energy: float = 0.0
    energy_at_walls: float = 0.0
    energy_returned: float = 0.0
    energy_waiting: float = 0.0
    enthalpy_in: float = 0.0
    enthalpy_out: float = 0.0
    heat_lost: float = 0.0
    blocked_area: float = 0.0
    collision_time: float = 0.0
    merges: int = 0
    since_collisions: float = 0.0
    sorts: int = 0
    gas_time: float = 0.0
    gas_step: int = 0
    steps_to_go: int = 0
    next_audit: float = 0.0
    next_patches: float = 0.0
    escaped: int = 0
    parked: int = 0
    mass_error: float = 0.0
    energy_error: float = 0.0
    momentum_error: float = 0.0

    # What can be made anew from the rest, and is kept because that takes time.
    grid = None
    hits = None
    sums = None
    patches = None

    @property
    def in_bank(self) -> float:
        """Energy the particles have given to the walls, less what the structure has received or given back [J]."""
        return self.energy_at_walls - self.load.work - self.energy_returned
