"""The stress law in strain space: one convex energy, whatever compression does."""

from __future__ import annotations

import numpy as np
import pytest
from cloth import FABRICS
from hypothesis import given
from hypothesis import strategies as st

from billow.parts.fabric.linear_law import (
    KEEP,
    PRINCIPAL,
    YARN,
    taut_stress,
    tension_field_stress,
    yarn_stress,
)

RULES = pytest.mark.parametrize("rule", [KEEP, PRINCIPAL, YARN])
strain = st.floats(-0.1, 0.1)
strains = st.tuples(strain, strain, strain)
# Steps from far across to within rounding of a transition.
steps = st.tuples(strains, st.sampled_from([1.0, 1e-3, 1e-6, 1e-9, 1e-12]))


STRESS = {KEEP: taut_stress, PRINCIPAL: tension_field_stress, YARN: yarn_stress}


def stress(rule, e):
    return np.array(STRESS[rule](*FABRICS[rule].stiffness, *map(float, e)))


def paired(s, e):
    """s : e, shear counting twice."""
    return s[0] * e[0] + s[1] * e[1] + 2.0 * s[2] * e[2]


def stiffest(rule):
    """Largest modulus in any direction of strain space [Pa]."""
    c11, c22, c12, c66 = FABRICS[rule].stiffness
    return np.linalg.eigvalsh([[c11, c12, 0.0], [c12, c22, 0.0], [0.0, 0.0, 2.0 * c66]]).max()


def on_a_transition(rule, e):
    """A strain like this one at which one tension just vanishes."""
    c11, c22, c12, _ = FABRICS[rule].stiffness
    if rule == PRINCIPAL:
        # Principal strains (E1, -c12/c22 E1) turned by an angle.
        angle, largest = 30.0 * e[2], abs(e[0])
        other = -c12 / c22 * largest
        mean, radius = 0.5 * (largest + other), 0.5 * (largest - other)
        return mean + radius * np.cos(angle), mean - radius * np.cos(angle), radius * np.sin(angle)
    return (e[0], -c12 / c22 * e[0], e[2]) if e[2] > 0.0 else (-c12 / c11 * e[1], e[1], e[2])


@RULES
@given(start=strains, step=steps, at_transition=st.booleans())
def test_stress_never_jumps_and_never_softens(rule, start, step, at_transition):
    """Two strains a step apart: stress changes by at most the largest modulus times the step, and not against it."""
    start = np.array(on_a_transition(rule, start) if at_transition else start)
    end = start + np.array(step[0]) * step[1]
    moved, answer = end - start, stress(rule, end) - stress(rule, start)
    noise = 1e-15 * stiffest(rule)
    size = np.sqrt(paired(moved, moved))
    assert np.sqrt(paired(answer, answer)) <= stiffest(rule) * size * (1.0 + 1e-9) + noise
    assert paired(answer, moved) >= -noise * size - 1e-30


@RULES
@given(e=strains)
def test_energy_is_never_negative(rule, e):
    assert paired(stress(rule, e), e) >= -1e-15 * stiffest(rule) * paired(e, e)


@given(e=strains)
def test_without_compression_there_is_none(e):
    s11, s22, s12 = stress(PRINCIPAL, e)
    smaller = 0.5 * (s11 + s22) - np.hypot(0.5 * (s11 - s22), s12)
    assert smaller >= -1e-12 * stiffest(PRINCIPAL)
    s11, s22, _ = stress(YARN, e)
    assert min(s11, s22) >= 0.0


@given(e=strains)
def test_taut_fabric_is_linear_under_every_rule(e):
    """Where both tensions are positive, all three rules are the plain linear law."""
    for rule in (PRINCIPAL, YARN):
        plain = np.array(taut_stress(*FABRICS[rule].stiffness, *e))
        smaller = 0.5 * (plain[0] + plain[1]) - np.hypot(0.5 * (plain[0] - plain[1]), plain[2])
        if rule == YARN:
            smaller = plain[:2].min()
        if smaller > 1e-9 * stiffest(rule):
            assert stress(rule, e) == pytest.approx(plain, rel=1e-12)
        elif smaller < -1e-9 * stiffest(rule):
            assert np.abs(stress(rule, e) - plain).max() > 0.0


@RULES
@given(
    centre=strains,
    radii=st.tuples(st.floats(0.01, 0.1), st.floats(0.01, 0.1), st.floats(0.01, 0.1)),
    shifts=st.tuples(st.floats(0.0, 6.0), st.floats(0.0, 6.0)),
)
def test_a_closed_loop_creates_no_energy(rule, centre, radii, shifts):
    """Midpoint sum of s : de around a closed curve through taut, wrinkled and slack.

    A step over a kink, of which a loop has at most eight, errs by up to stiffness |de|^2 / 8, however small the taut
    part of the loop is.
    """
    phase = 2.0 * np.pi * np.arange(401) / 400
    loop = np.column_stack([c + r * np.sin(phase + d) for c, r, d in zip(centre, radii, (0.0, *shifts), strict=True)])
    middle, moved = 0.5 * (loop[1:] + loop[:-1]), np.diff(loop, axis=0)
    work = np.array([paired(stress(rule, e), d) for e, d in zip(middle, moved, strict=True)])
    if np.abs(work).sum() > 0.0:
        kinks = stiffest(rule) * np.sum(moved**2, axis=1).max()
        assert abs(work.sum()) <= 2e-4 * np.abs(work).sum() + kinks
