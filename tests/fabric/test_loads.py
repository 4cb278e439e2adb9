"""What the pass over the triangles measures beside forces: area vectors and volumes, of fabric and of holes."""

import numpy as np
import pytest

from billow.case.build import build_model
from billow.case.schema import Case
from billow.geometry.surface import area_vectors
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
