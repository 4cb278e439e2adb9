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
    loads = Loads.room(surface.triangle_count, surface.chambers.count)
    for array in (loads.corner_force, loads.thirds, loads.volumes):
        array.fill(np.nan)
    fabric.add_forces(fabric.start(None), positions, np.zeros_like(positions), 0.0, 0.0, loads)
    np.testing.assert_allclose(loads.thirds, area_vectors(surface.triangles, positions) / 3.0, atol=1e-18)
    assert loads.volumes == pytest.approx(surface.chambers.volumes(surface.triangles, positions), rel=1e-12)
    holes = np.setdiff1d(np.arange(surface.triangle_count), fabric.membranes[0].elements)
    assert len(holes)
    assert not loads.corner_force[holes].any()
