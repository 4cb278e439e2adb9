"""What never changes of a corpuscular gas: species, inflators, walls, passages, how many particles there may be."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from billow.geometry.chambers import OUTSIDE, Chambers
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import Surface
from billow.parts.gas.corpuscular.internal_energy import ParticleKinds
from billow.parts.gas.corpuscular.outlets import Outlets
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.corpuscular.wall_load import Squares
from billow.parts.gas.corpuscular.walls import Walls
from billow.parts.gas.supply.passages import OPENING
from billow.parts.gas.supply.supply import Supply


@dataclass(frozen=True)
class Setup:
    """Parameters of the gas.

    supply: its sources all have jets; a diffuse one is a hole that blows in all directions. surface: of the bag, its
    chambers and kinds of parts. reference: flat corner coordinates [m], (triangles, 3, 2). particles: the most there
    are (to 2 %); at the start at least half of them, unless there is hardly any gas. seed: of the random numbers.
    """

    supply: Supply
    surface: Surface
    reference: np.ndarray
    particles: int = 100_000
    seed: int = 1

    @property
    def table(self) -> np.ndarray:
        return self.supply.table

    @property
    def chambers(self) -> Chambers:
        return self.supply.chambers

    @property
    def room(self) -> int:
        """Particles there may be; more than `particles`, lest the last ones to come, one too many, cause a merge."""
        return self.particles + self.particles // 50 + 64

    @cached_property
    def walls(self) -> Walls:
        return Walls.build(self.surface.triangles, self.chambers, self.group)

    @cached_property
    def group(self) -> np.ndarray | None:
        """(chambers,) int32, the same for chambers that openings join; None if there are no openings."""
        ends = [
            (row.behind, row.ahead) for row in self.supply.passages.rows if row.kind == OPENING and len(row.triangles)
        ]
        if not ends:
            return None
        one, other = np.array(ends).T
        n = self.chambers.count
        return connected_components(coo_array((np.ones(len(one)), (one, other)), (n, n)), directed=False)[1]

    @cached_property
    def outlets(self) -> Outlets:
        return Outlets.build(self.supply, self.surface.triangles)

    @cached_property
    def solid(self) -> np.ndarray:
        """(triangles,) bool: whether there is anything to push on."""
        return np.array([kind in ("fabric", "mouth") for kind in self.surface.part_kinds])[self.surface.part]

    @cached_property
    def ambient_load(self) -> np.ndarray:
        """Ambient pressure against the normal of each triangle [Pa], (triangles,): on fabric and mouth from outside."""
        behind, ahead = self.chambers.behind, self.chambers.ahead
        side = (ahead == OUTSIDE) * 1.0 - (behind == OUTSIDE) * 1.0
        return np.where(self.solid, side * self.supply.ambient.pressure, 0.0)

    @cached_property
    def flat_area(self) -> np.ndarray:
        """Of each triangle of the flat cut [m^2], (triangles,)."""
        return flat_area(self.reference)

    @cached_property
    def edge(self) -> float:
        """Mean edge of the mesh [m], as if all triangles were equilateral."""
        return math.sqrt(4.0 / math.sqrt(3.0) * float(self.flat_area.mean()))

    @cached_property
    def squares(self) -> Squares:
        return Squares.of(self.reference.mean(axis=1), self.surface.part, self.edge)

    def kinds(self, gas: CorpuscularState) -> ParticleKinds:
        """What particles of each species are at present."""
        return ParticleKinds(self.table, gas.molecules)
