"""How bodies look: light on their normals, dark edges between their pieces, shade where they are close together.

Colours of a field must be read off a colour bar, so light changes them little; depth is told by edges and by shade
(ambient occlusion in screen space: Mittring, Finding next gen, SIGGRAPH 2007 course notes).
"""

from __future__ import annotations

import numpy as np

from billow.base.compiled import scalar
from billow.pictures.camera import Camera
from billow.pictures.raster import NOTHING, Cut, rasterise, weights_at
from billow.pictures.scene import Scene

LIGHTS = ((-0.45, 0.60, 0.66, 0.42), (0.70, 0.10, 0.70, 0.12))
"""Direction in the picture, right, up and towards the viewer, and strength; from the upper left, and a weak one."""
AMBIENT = 0.60
INSIDE = 0.92
"""Brightness of the inside of a shell."""
SHINE, SHARPNESS = 0.07, 24
EDGE = 0.55
"""How dark edges are."""
STEP = 0.010
"""Jump in depth that makes an edge, over the height of the picture."""
SHADE, SHADE_REACH = 0.55, 0.045
"""Strength of the shade, and how far it reaches over the height of the picture."""
RAYS, GOLDEN_ANGLE, BLURS = 48, 2.39996, 3
"""Places around a pixel that are looked at, the angle from one to the next, and how often their pattern is
blurred."""
EDGE_ON = 1e-6
"""Cosine below which a plane is seen from its edge."""
SAMPLES = 3
"""Samples a side of each pixel: edges are smooth."""


def paint(scene: Scene, camera: Camera, samples: int = SAMPLES) -> np.ndarray:
    """The picture: red, green, blue and how much of each pixel is covered, from 0 to 1, (height, width, 4) float32;
    colours of a pixel that is covered in part are those of its covered part.
    """
    fine = camera.larger(samples)
    projected = fine.project(scene.points)
    buffers = rasterise(projected, scene.triangles, fine.width, fine.height, _cut(scene, fine))
    lights = np.array(LIGHTS)
    lights[:, :3] /= np.linalg.norm(lights[:, :3], axis=1, keepdims=True)
    out = np.zeros((camera.height, camera.width, 4), np.float32)
    normals = np.ascontiguousarray(scene.normals @ camera.axes.T)  # right, up, towards the viewer
    _shade(
        samples, buffers, projected, scene.triangles, normals, np.ascontiguousarray(scene.colours, float),
        scene.surface, scene.cut_colour, lights, STEP * fine.height, out,
    )  # fmt: skip
    middle = buffers.depth[samples // 2 :: samples, samples // 2 :: samples] / samples
    out[..., :3] *= _openness(np.ascontiguousarray(middle), SHADE_REACH * camera.height)[..., None]
    return np.clip(out, 0.0, 1.0)


def _cut(scene: Scene, camera: Camera) -> Cut | None:
    if scene.plane is None:
        return None
    along = abs(float(scene.plane.normal @ camera.axes[2]))
    return Cut(scene.kept, scene.solid, camera.scale / along if along > EDGE_ON else 0.0)


def _openness(depth: np.ndarray, reach: float) -> np.ndarray:
    """Brightness of each pixel from what stands before it, (height, width): 1 in the open. depth: [pixels] towards the
    viewer; reach: how far [pixels] things around a place shade it."""
    turn = GOLDEN_ANGLE * np.arange(RAYS)
    far = reach * np.sqrt((np.arange(RAYS) + 0.5) / RAYS)
    offsets = np.stack([far * np.sin(turn), far * np.cos(turn)], axis=1).round().astype(np.int64)
    hidden = np.zeros(depth.shape, np.float32)
    _look_around(depth, offsets, reach, hidden)
    return 1.0 - SHADE * _blurred(hidden)


def _blurred(values: np.ndarray) -> np.ndarray:
    """Means with weights 1, 2, 1 in both directions, several times."""
    for _ in range(BLURS):
        for axis in (0, 1):
            ends = [(1, 1) if k == axis else (0, 0) for k in (0, 1)]
            wide = np.moveaxis(np.pad(values, ends, "edge"), axis, 0)
            values = np.moveaxis(0.25 * (wide[:-2] + wide[2:]) + 0.5 * wide[1:-1], 0, axis)
    return values


@scalar
def _before(nearer, reach):
    """How much, from -1 to 1, a place that is nearer to the viewer shades; one far before hides little of the light."""
    part = max(nearer / reach, -1.0)
    return part if part < 1.0 else 1.0 / (1.0 + (0.5 * (part - 1.0)) ** 2)


@scalar
def _look_around(depth, offsets, reach, hidden_out):
    height, width = depth.shape
    for row in range(height):
        for column in range(width):
            here, total = depth[row, column], 0.0
            if here == -np.inf:
                continue
            for k in range(len(offsets)):
                above, left = row - offsets[k, 0], column - offsets[k, 1]
                below, right = row + offsets[k, 0], column + offsets[k, 1]
                if min(above, below, left, right) < 0 or max(above, below) >= height or max(left, right) >= width:
                    continue
                # Two places on opposite sides: on a slope one is as much nearer as the other is farther.
                total += max(
                    _before(depth[above, left] - here, reach) + _before(depth[below, right] - here, reach), 0.0
                )
            hidden_out[row, column] = total / len(offsets)


@scalar
def _shade(samples, buffers, projected, triangles, normals, colours, surface, cut_colour, lights, step, out):
    height, width = out.shape[:2]
    triangle, depth = buffers
    rows, columns = triangle.shape
    for row in range(height):
        for column in range(width):
            covered = 0
            red, green, blue = 0.0, 0.0, 0.0
            for i in range(row * samples, (row + 1) * samples):
                for j in range(column * samples, (column + 1) * samples):
                    t = triangle[i, j]
                    if t == NOTHING:
                        continue
                    covered += 1
                    here, piece = depth[i, j], surface[t]
                    wa, wb, wc, doubled = weights_at(projected, triangles[t], j + 0.5, i + 0.5)
                    is_inside = doubled > 0.0  # y goes down
                    nx = wa * normals[t, 0, 0] + wb * normals[t, 1, 0] + wc * normals[t, 2, 0]
                    ny = wa * normals[t, 0, 1] + wb * normals[t, 1, 1] + wc * normals[t, 2, 1]
                    nz = wa * normals[t, 0, 2] + wb * normals[t, 1, 2] + wc * normals[t, 2, 2]
                    size = max(np.sqrt(nx * nx + ny * ny + nz * nz), 1e-12)
                    if is_inside:
                        size = -size
                    nx, ny, nz = nx / size, ny / size, max(nz / size, 0.0)
                    bright = AMBIENT
                    shine = 0.0
                    for k in range(len(lights)):
                        along = nx * lights[k, 0] + ny * lights[k, 1] + nz * lights[k, 2]
                        if along > 0.0:
                            bright += lights[k, 3] * along
                            shine += lights[k, 3] * max(2.0 * along * nz - lights[k, 2], 0.0) ** SHARPNESS
                    r = wa * colours[t, 0, 0] + wb * colours[t, 1, 0] + wc * colours[t, 2, 0]
                    g = wa * colours[t, 0, 1] + wb * colours[t, 1, 1] + wc * colours[t, 2, 1]
                    b = wa * colours[t, 0, 2] + wb * colours[t, 1, 2] + wc * colours[t, 2, 2]
                    if is_inside:
                        if cut_colour[t, 0] == cut_colour[t, 0]:  # the inside of a solid that is cut
                            r, g, b = cut_colour[t, 0], cut_colour[t, 1], cut_colour[t, 2]
                            bright, shine = 1.0, 0.0
                        else:
                            bright, shine = INSIDE * bright, 0.0
                    shine *= SHINE
                    edge = 1.0
                    for di, dj in ((-1, 0), (1, 0), (0, -1), (0, 1)):
                        p, q = i + di, j + dj
                        if p < 0 or q < 0 or p >= rows or q >= columns:
                            continue
                        other = triangle[p, q]
                        if other == NOTHING or (surface[other] != piece and depth[p, q] <= here):
                            edge = 1.0 - EDGE
                            continue
                        m, n = i - di, j - dj
                        if m < 0 or n < 0 or m >= rows or n >= columns or triangle[m, n] == NOTHING:
                            continue
                        fall = here - depth[p, q]
                        if fall > 0.0 and fall - (depth[m, n] - here) > step:
                            edge = 1.0 - EDGE
                    bright *= edge
                    red += r * bright + shine
                    green += g * bright + shine
                    blue += b * bright + shine
            if covered:
                out[row, column, 0], out[row, column, 1] = red / covered, green / covered
                out[row, column, 2], out[row, column, 3] = blue / covered, covered / samples**2
