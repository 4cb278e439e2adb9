"""What never changes of a mesh gas: what it is fed with, its walls, its cells."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.geometry.folding.strips import Strips
from billow.geometry.surface import Surface
from billow.parts.gas.mesh.rooms import Rooms
from billow.parts.gas.mesh.state import MeshState
from billow.parts.gas.supply.supply import Supply

DONOR, VAN_LEER = "donor", "van_leer"


@dataclass(frozen=True)
class Setup:
    """Parameters of the gas.

    supply: its sources have mouths, its passages triangles. surface: of the bag. fabric_area: as cut [m^2]. cell:
    edge of a cell [m]. advection: DONOR or VAN_LEER. flow_limit: part of a cell that gas may flow in a part of a
    step. strips: of a folded bag, or None. film_friction: whether walls brake gas between them."""

    supply: Supply
    surface: Surface
    fabric_area: float
    cell: float
    advection: str = VAN_LEER
    flow_limit: float = 1.0
    strips: Strips | None = None
    film_friction: bool = False

    @property
    def table(self) -> np.ndarray:
        return self.supply.table

    @cached_property
    def _rooms(self) -> dict[bytes, Rooms]:
        return {}

    def rooms(self, gas: MeshState) -> Rooms:
        """The rooms there are now."""
        name = gas.joined.tobytes()
        if name not in self._rooms:
            self._rooms.clear()  # strips that have joined never part
            self._rooms[name] = Rooms.of(self.supply, self.surface, self.cell, self.strips, gas.joined)
        return self._rooms[name]
