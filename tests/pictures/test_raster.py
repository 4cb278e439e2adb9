"""Which triangle a pixel shows: against closed forms, and against every triangle asked for every pixel."""

import numpy as np
import pytest

from billow.geometry.shapes.triangulated import sphere
from billow.pictures.camera import Camera
from billow.pictures.raster import NOTHING, Cut, rasterise


def by_force(projected, triangles, width, height):
    """Depth of the nearest triangle at the middle of every pixel, by asking all of them."""
    x, y = np.meshgrid(np.arange(width) + 0.5, np.arange(height) + 0.5)
    nearest, depth = np.full((height, width), NOTHING), np.full((height, width), -np.inf)
    for t, corners in enumerate(triangles):
        matrix = np.vstack([projected[corners, :2].T, np.ones(3)])
        if abs(np.linalg.det(matrix)) < 1e-9:
            continue
        weights = np.linalg.solve(matrix, np.stack([x.ravel(), y.ravel(), np.ones(x.size)]))
        inside = (weights >= -1e-9).all(axis=0).reshape(height, width)
        here = (projected[corners, 2] @ weights).reshape(height, width)
        nearer = inside & (here > depth)
        nearest[nearer], depth[nearer] = t, here[nearer]
    return nearest, depth


def test_the_nearest_surface_wins_everywhere():
    random = np.random.default_rng(3)
    projected = random.uniform(-5.0, 45.0, (60, 3))
    triangles = random.integers(0, 60, (40, 3))
    triangles = triangles[[len(set(t)) == 3 for t in triangles.tolist()]]
    nearest, depth = by_force(projected, triangles, 40, 30)
    found = rasterise(projected, triangles, 40, 30)
    np.testing.assert_array_equal(found.triangle, nearest)
    np.testing.assert_allclose(found.depth, depth, atol=1e-6)


def test_the_order_of_triangles_does_not_matter_but_for_equal_depths():
    projected = np.array([[0, 0, 1.0], [20, 0, 1], [0, 20, 1], [0, 0, 2], [20, 0, 2], [0, 20, 2]])
    near, far = [3, 4, 5], [0, 1, 2]
    assert rasterise(projected, np.array([near, far]), 20, 20).triangle[3, 3] == 0
    assert rasterise(projected, np.array([far, near]), 20, 20).triangle[3, 3] == 1
    assert rasterise(projected, np.array([far, far]), 20, 20).triangle[3, 3] == 0


@pytest.mark.parametrize("view", ["iso", "front", "top"])
def test_a_sphere_covers_the_area_of_its_disk(view):
    points, triangles = sphere(5)
    camera = Camera.around([points], view, 600, 600)
    found = rasterise(camera.project(points), triangles, 600, 600)
    expected = np.pi * camera.scale**2
    assert abs((found.triangle != NOTHING).sum() / expected - 1.0) < 2e-3


def test_of_a_sphere_the_half_towards_the_viewer_is_seen_at_its_depth():
    points, triangles = sphere(5)
    camera = Camera.around([points], "front", 300, 300)
    found = rasterise(camera.project(points), triangles, 300, 300)
    x, y = np.meshgrid(np.arange(300) + 0.5 - 150.0, np.arange(300) + 0.5 - 150.0)
    radius = camera.scale
    well_inside = x**2 + y**2 < (0.98 * radius) ** 2
    expected = np.sqrt(np.maximum(radius**2 - x**2 - y**2, 0.0))
    assert np.abs(found.depth - expected)[well_inside].max() < 0.01 * radius


def test_there_are_no_gaps_between_neighbours():
    """A square of many small triangles whose edges go through the middles of pixels."""
    n = 40
    grid = np.stack(np.meshgrid(np.arange(n + 1) + 0.5, np.arange(n + 1) + 0.5, indexing="ij"), axis=-1).reshape(-1, 2)
    projected = np.column_stack([grid, np.zeros(len(grid))])
    k = (np.arange(n)[:, None] * (n + 1) + np.arange(n)).ravel()
    triangles = np.concatenate([np.stack([k, k + 1, k + n + 2], 1), np.stack([k, k + n + 2, k + n + 1], 1)])
    found = rasterise(projected, triangles, n + 1, n + 1)
    assert (found.triangle[:n, :n] != NOTHING).all()


@pytest.mark.parametrize(
    "corner",
    [[np.nan, 0.0, 0.0], [1e12, 0.0, 0.0], [-1e12, 5.0, 0.0], [10.0, 10.0, np.nan]],
)
def test_what_lies_far_away_or_nowhere_does_no_harm(corner):
    projected = np.array(
        [corner, [20.0, 0.0, 0.0], [0.0, 20.0, 0.0], [5.0, 5.0, 1.0], [9.0, 5.0, 1.0], [5.0, 9.0, 1.0]]
    )
    found = rasterise(projected, np.array([[0, 1, 2], [3, 4, 5]]), 20, 20)
    assert found.triangle[6, 6] in (0, 1)


# --- planes that cut ------------------------------------------------------------------------


def cut_sphere(offset, view="front", solid=True):
    """A sphere of which the part before y = offset is left away, seen along y."""
    points, triangles = sphere(5)
    camera = Camera.around([points], view, 300, 300)
    kept = points[:, 1] - offset
    along = abs(camera.axes[2, 1])
    cut = Cut(kept, np.full(len(triangles), 0 if solid else -1), camera.scale / along if along > 1e-6 else 0.0)
    return camera, rasterise(camera.project(points), triangles, 300, 300, cut)


@pytest.mark.parametrize("offset", [-0.5, 0.0, 0.6])
def test_the_cut_face_of_a_solid_is_flat_and_as_large_as_its_section(offset):
    camera, found = cut_sphere(offset)
    face = np.abs(found.depth + offset * camera.scale) < 1e-6
    assert abs(face.sum() / (np.pi * (1.0 - offset**2) * camera.scale**2) - 1.0) < 5e-3


def test_of_a_cut_shell_the_inside_is_seen():
    camera, found = cut_sphere(0.0, solid=False)
    middle = found.depth[150, 150]
    assert middle == pytest.approx(-camera.scale, rel=5e-3)  # the far side


def test_nothing_before_the_plane_is_drawn():
    camera, found = cut_sphere(0.3, solid=False)
    assert found.depth[np.isfinite(found.depth)].max() <= -0.3 * camera.scale + 1e-6


def test_from_an_angle_the_face_hides_what_is_behind_it_and_the_outside_stays():
    """Seen from 30 degrees beside the plane's normal: the face is foreshortened, the rest of the half is outside."""
    points, triangles = sphere(5)
    camera = Camera.around([points], "iso", 300, 300)
    normal = np.array([0.0, -1.0, 0.0])
    towards = float(normal @ camera.axes[2])
    cut = Cut(points[:, 1], np.zeros(len(triangles), int), camera.scale / towards)
    found = rasterise(camera.project(points), triangles, 300, 300, cut)
    half_disk = 0.5 * np.pi * camera.scale**2
    area = (found.triangle != NOTHING).sum()
    assert abs(area / (half_disk * (1.0 + towards)) - 1.0) < 5e-3
    x, y = np.meshgrid(np.arange(300) + 0.5 - 150.0, 150.0 - np.arange(300) - 0.5)
    in_plane = -(x * camera.axes[0, 1] + y * camera.axes[1, 1]) / camera.axes[2, 1]
    on_face = np.abs(found.depth - in_plane) < 1e-6
    assert abs(on_face.sum() / (2.0 * half_disk * towards) - 1.0) < 5e-3


def test_a_plane_seen_from_its_edge_leaves_half_of_the_disk():
    camera, found = cut_sphere(0.0, view="side")
    assert abs((found.triangle != NOTHING).sum() / (0.5 * np.pi * camera.scale**2) - 1.0) < 5e-3
