"""Seams and reinforcements weigh what their area says, whatever the mesh."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model, flat_area
from billow.case.schema import Case
from billow.geometry.disc_mesh import rim_count
from billow.geometry.local_thickness import covered_share, line_depth
from billow.geometry.rectangle_mesh import mesh_rectangle


@given(seed=st.integers(0, 1000), offset=st.floats(-1.5, 1.5))
def test_a_straight_line_cuts_a_triangle_exactly(seed, offset):
    """Against the area of the clipped polygon."""
    flat = np.random.default_rng(seed).normal(size=(3, 2))
    share = covered_share(flat[None], lambda points: points[:, 0] - offset)[0]
    kept = []
    for a, b in zip(flat, np.roll(flat, -1, axis=0), strict=True):
        kept += [a] if a[0] >= offset else []
        if (a[0] - offset) * (b[0] - offset) < 0.0:
            kept.append(a + (b - a) * (offset - a[0]) / (b[0] - a[0]))

    def area(polygon):
        x, y = np.array(polygon).T
        return 0.5 * abs(x @ np.roll(y, -1) - y @ np.roll(x, -1))

    assert share == pytest.approx(area(kept) / area(flat) if len(kept) > 2 else 0.0, abs=1e-9)


@pytest.mark.parametrize("size", [0.02, 0.05])
def test_a_driver_bag_with_seam_and_reinforcement(size):
    """A ring of area A in n layers adds (n - 1) A: 1 % for circles on straight edges."""
    rings = [{"panel": "rear", "inner": 0.05, "outer": 0.12, "layers": 3}]
    shape = build_shape(
        Case.from_dict(
            {"bag": {"element_size": size, "seam": {"width": 0.01, "layers": 2}, "reinforcements": rings}}
        ).bag
    )
    extra = flat_area(shape.reference) * (shape.layers - 1.0)
    front, rear = (extra[shape.surface.triangles_of(name)].sum() for name in ("front", "rear"))
    n = rim_count(0.35, size)
    outer = 0.5 * n * 0.35**2 * np.sin(2.0 * np.pi / n)
    apothem = 0.35 * np.cos(np.pi / n)
    seam = outer * (1.0 - (1.0 - 0.01 / apothem) ** 2)
    assert front == pytest.approx(seam, rel=0.01)
    k = 12 * max(1, round(0.05 / (2.0 * size)))  # the retainer ring is a polygon
    inner = 0.5 * k * 0.05**2 * np.sin(2.0 * np.pi / k)
    ring = np.pi * 0.12**2 - max(inner, np.pi * 0.05**2)
    assert rear - front == pytest.approx(2.0 * ring, rel=0.02)


def test_mass_and_stiffness_follow():
    thin, thick = (
        build_model(Case.from_dict({"bag": {"shape": "square", "element_size": 0.05, "seam": {"layers": n}}}))
        for n in (1, 5)
    )
    extra = 2.0 * (0.6**2 - (0.6 - 0.016) ** 2) * 4.0
    assert thick.mass.sum() - thin.mass.sum() == pytest.approx(extra * 800.0 * 3e-4, rel=0.01)
    more = thick.fabric.membranes[0].volume.sum() - thin.fabric.membranes[0].volume.sum()
    assert more == pytest.approx(extra * 3e-4, rel=0.01)


def test_lines_have_round_ends():
    lines = np.linspace(-1.0, 1.0, 9)
    square = mesh_rectangle(lines, lines, 0.25)
    cut = line_depth(np.array([[[0.0, 0.0], [5.0, 0.0]]]), 0.5)
    share = covered_share(square.points[square.triangles], cut).mean()
    assert share * 4.0 == pytest.approx(1.0 * 1.0 + 0.5 * np.pi * 0.25, rel=0.01)
