"""What never changes of a mesh gas: what it is fed with, its walls, its cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.geometry.surface import Surface
from billow.parts.gas.mesh.exchange import Ways
from billow.parts.gas.mesh.sheet import Walls
from billow.parts.gas.supply.supply import Supply

DONOR, VAN_LEER = "donor", "van_leer"


@dataclass(frozen=True)
class Setup:
    """Parameters of the gas.

    supply: its sources have mouths, its passages triangles. surface: of the bag. fabric_area: as cut [m^2]. cell:
    edge of a cell [m]. advection: DONOR or VAN_LEER. flow_limit: part of a cell that gas may flow in a part of a
    step."""

    supply: Supply
    surface: Surface
    fabric_area: float
    cell: float
    advection: str = VAN_LEER
    flow_limit: float = 1.0

    @property
    def table(self) -> np.ndarray:
        return self.supply.table

    @cached_property
    def walls(self) -> tuple[Walls, ...]:
        chambers = self.supply.chambers
        return tuple(Walls.of(self.surface, chambers, c) for c in range(chambers.count))

    @cached_property
    def ways(self) -> Ways:
        return Ways(self.supply, self.surface, self.walls, self.cell)
