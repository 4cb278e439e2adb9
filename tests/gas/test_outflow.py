"""Orifice and porous flow as functions: continuous, monotone, from high to low pressure only."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.parts.gas.supply.outflow import (
    GRAEFE,
    LINEAR_BELOW,
    ORIFICE,
    PERMEABILITY,
    POROUS_MEDIUM,
    VELOCITY,
    conductance,
    orifice_flux,
    porous_flux,
)

AMBIENT = 101325.0
LAWS = (ORIFICE, GRAEFE, POROUS_MEDIUM, VELOCITY, PERMEABILITY)
gamma = st.floats(1.1, 1.67)
specific = st.floats(5e4, 5e5)  # R T [J/kg]: 200 to 1000 K of anything but hydrogen
difference = st.one_of(st.floats(0.0, 200.0), st.floats(49.9, 50.1), st.floats(0.0, 5e5))


@given(difference=difference, step=st.sampled_from([1e-9, 1e-3, 1.0, 1e3]), gamma=gamma, specific=specific)
def test_outflow_grows_with_the_bags_pressure(difference, step, gamma, specific):
    here = orifice_flux(AMBIENT + difference, AMBIENT, gamma, specific)
    more = orifice_flux(AMBIENT + difference + step, AMBIENT, gamma, specific)
    assert 0.0 <= here <= more
    assert (here > 0.0) == (difference + AMBIENT > AMBIENT)
    # No jump: the slope is at most that of the linear part, which is the steepest.
    steepest = orifice_flux(AMBIENT + LINEAR_BELOW, AMBIENT, gamma, specific) / LINEAR_BELOW
    assert more - here <= 1.01 * steepest * step + 1e-12 * more


@given(difference=difference, step=st.sampled_from([1e-9, 1e-3, 1.0, 1e3]), permeability=st.floats(0.001, 10.0))
def test_leakage_grows_with_the_pressure_difference(difference, step, permeability):
    here = permeability * porous_flux(difference, 1.2)
    more = permeability * porous_flux(difference + step, 1.2)
    assert 0.0 <= here <= more
    steepest = permeability * porous_flux(LINEAR_BELOW, 1.2) / LINEAR_BELOW
    assert more - here <= 1.01 * steepest * step + 1e-12 * more


@given(gamma=gamma, specific=specific)
def test_both_laws_are_continuous_where_they_change(gamma, specific):
    above, below = LINEAR_BELOW * (1.0 + 1e-9), LINEAR_BELOW * (1.0 - 1e-9)
    flux = [orifice_flux(AMBIENT + d, AMBIENT, gamma, specific) for d in (below, LINEAR_BELOW, above)]
    assert np.ptp(flux) <= 1e-8 * flux[1]
    leak = [porous_flux(d, 1.2) for d in (below, LINEAR_BELOW, above)]
    assert np.ptp(leak) <= 1e-8 * leak[1]


@pytest.mark.parametrize("difference", [0.0, -1.0, -1e5])
def test_nothing_flows_without_a_pressure_difference(difference):
    assert orifice_flux(AMBIENT + difference, AMBIENT, 1.4, 1e5) == 0.0
    assert porous_flux(difference, 1.2) == 0.0


@given(gamma=gamma, specific=specific, pressure=st.floats(2.2 * AMBIENT, 10.0 * AMBIENT))
def test_choked_flow_knows_nothing_of_what_is_behind_the_hole(gamma, specific, pressure):
    choked = orifice_flux(pressure, AMBIENT, gamma, specific)
    assert orifice_flux(pressure, 0.5 * AMBIENT, gamma, specific) == choked
    assert orifice_flux(2.0 * pressure, AMBIENT, gamma, specific) == pytest.approx(2.0 * choked, rel=1e-14)


def test_small_orifice_flow_is_that_of_bernoulli_and_leak_speed_its_definition():
    density = AMBIENT / 85000.0
    flux = orifice_flux(AMBIENT + 60.0, AMBIENT, 1.4, 85000.0)
    assert flux == pytest.approx(np.sqrt(2.0 * density * 60.0), rel=1e-3)
    assert porous_flux(500.0, 1.2) == pytest.approx(1.2, rel=1e-15)
    assert porous_flux(2000.0, 1.2) == pytest.approx(2.0 * 1.2, rel=1e-15)


@given(
    law=st.sampled_from(LAWS), gamma=gamma, specific=specific, pressure=st.floats(1.05, 4.0).map(lambda r: r * AMBIENT)
)
def test_conductance_is_flow_over_difference(law, gamma, specific, pressure):
    difference, density = pressure - AMBIENT, pressure / specific
    expected = {
        ORIFICE: orifice_flux(pressure, AMBIENT, gamma, specific),
        GRAEFE: np.sqrt(2.0 * density * difference),
        POROUS_MEDIUM: difference,
        VELOCITY: density,
        PERMEABILITY: density * np.sqrt(difference / 500.0),
    }[law]
    assert conductance(law, pressure, AMBIENT, gamma, specific) * difference == pytest.approx(expected, rel=1e-12)


@given(law=st.sampled_from(LAWS), gamma=gamma, specific=specific, difference=difference)
def test_every_law_is_linear_near_equal_pressures_and_continuous(law, gamma, specific, difference):
    at = lambda d: conductance(law, AMBIENT + d, AMBIENT, gamma, specific)  # noqa: E731
    if difference <= LINEAR_BELOW:
        assert at(difference) == pytest.approx(at(0.0), rel=2e-3)  # the density changes by 50 Pa of 1 bar
    assert at(LINEAR_BELOW * (1.0 - 1e-9)) == pytest.approx(at(LINEAR_BELOW * (1.0 + 1e-9)), rel=1e-8)
    assert np.isfinite(at(difference))
    assert at(difference) > 0.0
