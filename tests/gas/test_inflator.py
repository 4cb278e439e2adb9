"""What the inflator has delivered is the exact integral of its curve, and its holes lie in its mouth."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.case.build import build_model
from billow.case.schema import Case
from billow.parts.gas.supply.curve import interpolate, interval
from billow.parts.gas.supply.inflator import Inflator

curves = st.lists(st.tuples(st.floats(1e-4, 0.02), st.floats(0.0, 3.0)), min_size=2, max_size=8).map(
    lambda points: (np.cumsum([gap for gap, _ in points]), np.array([flow for _, flow in points]))
)


def inflator(curve):
    return Inflator(*curve, np.array([0.0, 1.0]), np.array([600.0, 600.0]), np.ones(1))


@given(curve=curves, share=st.floats(-0.1, 1.2))
def test_delivered_mass_is_the_integral_of_the_flow(curve, share):
    times, flow = curve
    until = times[0] + share * (times[-1] - times[0])
    # The trapezoid rule is exact between the knots; the curve is zero outside.
    knots = np.array([*times[times < until], max(until, times[0])])
    inside = np.minimum(knots, times[-1])
    expected = np.trapezoid(np.interp(inside, times, flow), inside)
    assert inflator(curve).delivered(until) == pytest.approx(expected, rel=1e-12, abs=1e-15)


@given(st.lists(st.floats(-1.0, 1.0), min_size=2, max_size=12, unique=True).map(sorted), st.floats(0.0, 1.0))
def test_the_interval_is_the_one_that_numpy_finds(points, share):
    x = np.array(points)
    for at in (*x[:-1], max(x[0], np.nextafter(x[-1], -2.0)), x[0] + share * (x[-1] - x[0])):
        if x[0] <= at < x[-1]:
            assert interval(x, at) == np.searchsorted(x, at, side="right") - 1


@given(curve=curves, at=st.lists(st.floats(0.0, 0.2), min_size=2, max_size=20).map(sorted))
def test_delivered_mass_never_falls_and_steps_add_up(curve, at):
    source = inflator(curve)
    delivered = [source.delivered(t) for t in at]
    assert (np.diff(delivered) >= -1e-15).all()
    assert source.delivered(1.0) == source.cumulative[-1] == pytest.approx(np.trapezoid(curve[1], curve[0]), rel=1e-12)


@given(curve=curves, at=st.floats(-0.1, 0.3))
def test_interpolation_is_linear_inside_and_constant_outside(curve, at):
    assert interpolate(*curve, at) == pytest.approx(np.interp(at, *curve), rel=1e-12, abs=1e-15)


@pytest.mark.parametrize("shape", ["driver", "tube", "window", "passenger", "square"])
@pytest.mark.parametrize("radius", [None, 0.02, 0.03])
def test_a_ring_that_is_not_given_fits_into_the_mouth(shape, radius):
    """The holes of every bag, wide mouths too: within its rim, or particles are born outside."""
    bag = {"shape": shape, "element_size": 0.012} | ({} if radius is None else {"mouth_radius": radius})
    model = build_model(Case.from_dict({"bag": bag, "obstacles": []}))
    jets = model.gas.model.supply.sources[0].jets
    rim = model.start[jets.mouth_nodes]
    farthest = np.linalg.norm(rim - rim.mean(axis=0), axis=1).max()
    assert jets.ring.ring_radius < 0.85 * farthest
    assert jets.ring.ring_radius == 0.038 or jets.ring.ring_radius > 0.6 * farthest
