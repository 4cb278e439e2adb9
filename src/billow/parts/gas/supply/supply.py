"""The supply of a bag: what feeds its gas and where it can go. Every gas model works from this one object."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from billow.geometry.chambers import OUTSIDE, Chambers
from billow.parts.gas.supply.ambient import Ambient, InitialGas
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.jets import Jets
from billow.parts.gas.supply.passages import FABRIC, NO_PASSAGES, Passages


@dataclass(frozen=True)
class Source:
    """An inflator in its mouth.

    jets: its holes, and None for a diffuse source in a chamber without a mouth. diffuse: gas comes out of half the
    mouth in all directions, with no thrust that models without flow would have to add.
    """

    inflator: Inflator
    jets: Jets | None = None
    diffuse: bool = False


@dataclass(frozen=True)
class Supply:
    """table: (species, 16), species.thermo_table. chambers: of the bag; the indices in sources and passages are theirs.

    initial: ambient air by default. heat_conductance: heat transfer coefficient times outer area of each chamber [W/K],
    (chambers,); none by default.
    """

    table: np.ndarray
    species_names: tuple[str, ...]
    sources: tuple[Source, ...]
    ambient: Ambient
    chambers: Chambers
    passages: Passages = NO_PASSAGES
    initial: InitialGas | None = None
    heat_conductance: np.ndarray | None = None

    @property
    def inflators(self) -> tuple[Inflator, ...]:
        return tuple(source.inflator for source in self.sources)

    @property
    def start_gas(self) -> InitialGas:
        return self.initial or InitialGas.like(self.ambient, self.chambers.count)

    def start_amount(self, volume: np.ndarray) -> np.ndarray:
        """Gas in each chamber at the start [kg], (chambers,), by its volume [m^3], (chambers,)."""
        start = self.start_gas
        return start.pressure * volume / (start.mass_fractions @ self.table[:, 0] * start.temperature)

    def delivered(self, time: float) -> np.ndarray:
        """What inflators have delivered into each chamber up to a time [s]: [kg], (chambers, species)."""
        masses = np.zeros((self.chambers.count, len(self.table)))
        for inflator in self.inflators:
            masses[inflator.chamber] += inflator.delivered(time) * inflator.mass_fractions
        return masses

    def outflow_by_name(self, flows: Iterable[tuple[float, float]]) -> tuple[dict[str, float], ...]:
        """Flow of each passage by name: vented, leaked, passed between chambers [kg], as in GasTotals.

        flows: of each passage, mass [kg] that went from behind to ahead, and back.
        """
        vented, leaked, passed = {}, {}, {}
        for row, (forth, back) in zip(self.passages.rows, flows, strict=True):
            if OUTSIDE not in (row.behind, row.ahead):
                passed[row.name] = forth - back
            else:
                (leaked if row.kind == FABRIC else vented)[row.name] = forth if row.ahead == OUTSIDE else back
        return vented, leaked, passed
