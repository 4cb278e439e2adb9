"""What the pass over the triangles measures beside forces: area vectors and volumes, of fabric and of holes."""

import numpy as np
import pytest
from cloth import FABRICS

from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.chambers import Chambers
from billow.geometry.surface import area_vectors
from billow.parts.fabric.block import BLOCK
from billow.parts.fabric.membrane import VOLUMES, Membrane
from billow.parts.part import Loads


@pytest.mark.parametrize("law", ["linear", "curves", "curves-shear"])
def test_area_vectors_and_volumes_are_those_of_the_whole_surface(law):
    model = build_model(Case.from_dict({"bag": {"element_size": 0.06}, "fabric": {"law": law}}))
    surface, fabric = model.surface, model.fabric
    positions = model.start + 0.003 * np.random.default_rng(0).normal(size=model.start.shape)
    loads = Loads(len(fabric.assembly.entry), surface)
    for array in (loads.entries, loads.volumes):
        array.fill(np.nan)
    fabric.add_forces(fabric.start(None), positions, np.zeros_like(positions), 0.0, 0.0, loads)
    assert loads.volumes == pytest.approx(surface.chambers.volumes(surface.triangles, positions), rel=1e-12)
    assert surface.triangle_count > len(fabric.membranes[0].elements)  # there are holes
    corners = surface.triangles.astype(np.int64)
    expected = np.zeros((surface.node_count, 6))
    np.add.at(expected[:, :3], corners, fabric.corner_forces(fabric.start(None), positions, np.zeros_like(positions)))
    np.add.at(expected[:, 3:], corners, area_vectors(surface.triangles, positions)[:, None, :] / 3.0)
    assembly = fabric.assembly
    gathered = np.add.reduceat(loads.entries[assembly.entry], assembly.start[:-1])
    for columns in (slice(0, 3), slice(3, 6)):
        size = np.abs(expected[:, columns]).max()
        np.testing.assert_allclose(gathered[:, columns], expected[:, columns], atol=1e-13 * size)


@pytest.mark.parametrize("rule", FABRICS)
def test_volumes_of_chambers_whose_walls_lie_in_any_order(rule):
    """Whole blocks of elements around one chamber, blocks around several, and one that is not full."""
    rng, n = np.random.default_rng(1), 2000 + BLOCK // 3
    triangles = np.arange(3 * n, dtype=np.uint32).reshape(-1, 3)
    positions = rng.normal(size=(3 * n, 3))
    behind = np.repeat(rng.integers(0, 3, n // 50 + 1), 50)[:n].astype(np.int32)
    ahead = np.where(np.arange(n) < n // 2, -1, (behind + 1) % 3).astype(np.int32)
    chambers = Chambers(("one", "two", "three"), behind, ahead)
    flat = np.array([[0.0, 0.0], [0.01, 0.0], [0.0, 0.01]]) + np.zeros((n, 1, 1))
    membrane = Membrane.build(FABRICS[rule], np.arange(n), flat, chambers=chambers)
    _, sums = membrane.by_itself(triangles, positions, np.zeros_like(positions), membrane.fresh_history())
    within, expected = sums[:, VOLUMES + 1 :].sum(axis=0), chambers.volumes(triangles, positions)
    np.testing.assert_allclose(within, expected, atol=1e-12 * np.abs(expected).max())
