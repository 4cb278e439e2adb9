"""Heat that the gas of a chamber loses through its walls, by the law of uniform pressure.

The chamber as a whole owes the loss, and its thermal energy pays (`balance`): a coefficient of the whole wall does not
say where gas cools.
"""

from __future__ import annotations

from billow.parts.gas.corpuscular.setup import Setup
from billow.parts.gas.corpuscular.state import CorpuscularState
from billow.parts.gas.supply.heat_loss import heat_lost
from billow.parts.gas.supply.mixture import mixture_cp, mixture_gas_constant


def lose_heat(setup: Setup, gas: CorpuscularState, span: float) -> None:
    """Owe what is lost in `span` [s] at the temperatures of the last gas step."""
    for c, conductance in enumerate(() if setup.supply.heat_conductance is None else setup.supply.heat_conductance):
        masses, temperature = gas.masses[c], gas.temperature[c]
        if conductance > 0.0 and masses.any():
            capacity = mixture_cp(setup.table, masses, temperature) - mixture_gas_constant(setup.table, masses)
            heat = heat_lost(capacity, temperature - setup.ambient.temperature, conductance, span)
            gas.pool[c] -= heat
            gas.heat_lost += float(heat)
