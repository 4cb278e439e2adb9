"""Flow through an orifice and through porous fabric, from the side of higher pressure (docs/theory.md, Vents, leakage
and openings)."""

from __future__ import annotations

import math

from billow.base.compiled import scalar
from billow.parts.gas.supply.mixture import mixture_gamma, mixture_gas_constant

LINEAR_BELOW = 50.0
"""Pressure difference [Pa] below which flow is linear in it."""

ORIFICE, GRAEFE, POROUS_MEDIUM, VELOCITY, PERMEABILITY = range(5)
"""Laws of flow per area, and the unit of their coefficient: isentropic orifice, also Wang and Nefske's leakage (FVOPT
1) [-]; Graefe's sqrt(2 rho dp) (FVOPT 3) [-]; dp times a conductance (FVOPT 5) [s/m]; a leak speed times rho (FVOPT 7)
[m/s]; a leak speed of 1 m/s at TEST_DIFFERENCE that grows with the root of dp [-]."""

TEST_DIFFERENCE = 500.0
"""Pressure difference [Pa] of the standard permeability test (ISO 9237), at which the leak speed is 1 m/s."""


@scalar
def orifice_flux(upstream, downstream, gamma, gas_constant_times_temperature):
    """Isentropic mass flow per effective area [kg/(s m^2)] from upstream [Pa] to downstream [Pa] <= upstream.

    De Saint-Venant and Wantzel; choked below the critical ratio (docs/theory.md, Vents, leakage and openings).
    """
    difference = upstream - downstream
    if difference <= 0.0:
        return 0.0
    slope = 1.0
    if difference < LINEAR_BELOW:
        slope = difference / LINEAR_BELOW
        downstream = upstream - LINEAR_BELOW
    critical = (2.0 / (gamma + 1.0)) ** (gamma / (gamma - 1.0))
    ratio = max(downstream / upstream, critical)
    shape = ratio ** (2.0 / gamma) - ratio ** ((gamma + 1.0) / gamma)
    return slope * upstream * math.sqrt(2.0 * gamma / ((gamma - 1.0) * gas_constant_times_temperature) * shape)


@scalar
def jet_speed(table, mass_fractions, temperature):
    """Speed [m/s] of a choked jet from a total temperature [K]: sqrt(2 g/(g+1) R T)."""
    gamma = mixture_gamma(table, mass_fractions, temperature)
    gas_constant = mixture_gas_constant(table, mass_fractions)
    return math.sqrt(2.0 * gamma / (gamma + 1.0) * gas_constant * temperature)


@scalar
def porous_flux(difference, density):
    """Mass flow per fabric area [kg/(s m^2)] at a pressure difference [Pa] and upstream density [kg/m^3].

    The leak speed is sqrt(difference / TEST_DIFFERENCE) m/s for a permeability of 1 (docs/theory.md, Permeability).
    """
    if difference <= 0.0:
        return 0.0
    if difference < LINEAR_BELOW:
        return difference / math.sqrt(LINEAR_BELOW * TEST_DIFFERENCE) * density
    return math.sqrt(difference / TEST_DIFFERENCE) * density


@scalar
def conductance(law, upstream, downstream, gamma, gas_constant_times_temperature):
    """Mass flow per effective area and pressure difference [kg/(s m^2 Pa)] at upstream [Pa] >= downstream [Pa].

    It is the chord of the law, flow over difference, which is finite at equal pressures. The effective area is the area
    times the law's coefficient.
    """
    difference = max(upstream - downstream, LINEAR_BELOW)
    density = upstream / gas_constant_times_temperature
    if law == ORIFICE:
        flux = orifice_flux(upstream, upstream - difference, gamma, gas_constant_times_temperature)
    elif law == GRAEFE:
        flux = math.sqrt(2.0 * density * difference)
    elif law == POROUS_MEDIUM:
        flux = difference
    elif law == VELOCITY:
        flux = density
    else:
        flux = porous_flux(difference, density)
    return flux / difference
