"""The moving surface has no gaps: lines through it change sides exactly as often as their ends say."""

from __future__ import annotations

import numpy as np
import pytest
from flights import box, winding

from billow.base.compiled import kernel
from billow.geometry.chambers import Chambers
from billow.parts.gas.corpuscular.crossing import BOTH, INWARD, NEVER, OUTWARD, crossing, piece_normal
from billow.parts.gas.corpuscular.walls import SWEPT_NUMBERS, Walls, may_cross, stays_away, sweep

PIECES = (((0, 0), (1, 0), (2, 0), (2, 1)), ((0, 0), (1, 0), (1, 1), (2, 1)), ((0, 0), (0, 1), (1, 1), (2, 1)))
"""Corners of each piece: which node, at which end of the step."""


@kernel
def _cross_all(n, nodes, orientation, start, end, x0, x1, sides_out, met_out):
    for p in range(n):
        for t in range(len(nodes)):
            for way in (OUTWARD, INWARD):
                after = -1.0
                while True:  # a line can cross two pieces of a triangle in the same way
                    when, _, piece, _, _, _ = crossing(
                        nodes, orientation, t, start, end, x0[p, 0], x0[p, 1], x0[p, 2], x1[p, 0], x1[p, 1], x1[p, 2],
                        way, after,
                    )  # fmt: skip
                    if when == NEVER:
                        break
                    sides_out[p] += 1 if way == OUTWARD else -1
                    met_out[p, 0], met_out[p, 1], met_out[p, 2] = t, piece, when
                    after = when + 1e-12


@kernel
def _compare_all(n, nodes, orientation, start, end, swept, x0, x1, may_out, does_out):
    for p in range(n):
        for t in range(len(nodes)):
            may_out[p, t] = may_cross(
                swept, t, x0[p, 0], x0[p, 1], x0[p, 2], x1[p, 0], x1[p, 1], x1[p, 2], 1e-9
            )  # fmt: skip
            when, _, _, _, _, _ = crossing(
                nodes, orientation, t, start, end, x0[p, 0], x0[p, 1], x0[p, 2], x1[p, 0], x1[p, 1], x1[p, 2], BOTH,
                -1.0,
            )  # fmt: skip
            does_out[p, t] = when != NEVER


@kernel
def _reflect_all(n, nodes, orientation, start, end, swept, x0, x1, away_out, again_out):
    """Reflect each line by each triangle that it crosses outward: whether it is said to stay away, and whether it does
    not."""
    for p in range(n):
        for t in range(len(nodes)):
            when, _, piece, _, _, _ = crossing(
                nodes, orientation, t, start, end, x0[p, 0], x0[p, 1], x0[p, 2], x1[p, 0], x1[p, 1], x1[p, 2], OUTWARD,
                -1.0,
            )  # fmt: skip
            if when == NEVER:
                continue
            nx, ny, nz, travel = piece_normal(nodes, orientation, t, piece, start, end)
            v = x1[p] - x0[p]
            approach = v[0] * nx + v[1] * ny + v[2] * nz - travel
            met = x0[p] + when * v
            v = v - 2.0 * approach * np.array([nx, ny, nz])
            y0, y1 = met - when * v, met + (1.0 - when) * v
            away_out[p, t] = 1 + stays_away(swept, t, approach, np.sqrt(np.sum(v * v)))
            when, _, _, _, _, _ = crossing(
                nodes, orientation, t, start, end, y0[0], y0[1], y0[2], y1[0], y1[1], y1[2], OUTWARD, when + 1e-9
            )
            again_out[p, t] = when != NEVER


def moving_box(rng, strength):
    triangles, start, _, _ = box(divisions=3)
    walls = Walls.build(triangles, Chambers.single(len(triangles)))
    return triangles, walls, start, start + rng.normal(0.0, strength, start.shape) + rng.normal(0.0, 0.2, 3)


def cross(walls, start, end, x0, x1):
    sides, met = np.zeros(len(x0), np.int64), np.full((len(x0), 3), -1.0)
    _cross_all.serial(len(x0), walls.nodes, walls.orientation, start, end, x0, x1, sides, met)
    return sides, met


def test_crossings_add_up_to_the_change_of_side():
    """Net outward crossings of a line = winding number at its start - at its end, whatever the surface does."""
    rng = np.random.default_rng(1)
    for strength in (0.0, 0.01, 0.06):
        triangles, walls, start, end = moving_box(rng, strength)
        x0, x1 = rng.uniform(-0.4, 1.4, (2, 1500, 3))
        sides, _ = cross(walls, start, end, x0, x1)
        before, after = (np.round(winding(x, triangles, y)) for x, y in ((x0, start), (x1, end)))
        assert len(np.unique(before - after)) == 3
        assert np.array_equal(sides, before - after), np.count_nonzero(sides != before - after)


def test_lines_through_nodes_and_edges_are_seen():
    """From inside through every node, edge and middle of a standing or flying box to outside: at least one crossing."""
    triangles, walls, start, _ = moving_box(np.random.default_rng(2), 0.0)
    edges = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]])
    targets = np.concatenate([start, start[edges].mean(axis=1), start[triangles].mean(axis=1)])
    x0 = np.full_like(targets, 0.5)
    for drift in (np.zeros(3), np.array([0.25, -0.5, 3.0])):
        sides, _ = cross(walls, start, start + drift, x0, x0 + 1.5 * (targets - 0.5) + drift)
        assert (sides > 0).all()


@pytest.mark.parametrize("strength", [0.0, 0.01, 0.06, 1.0])
def test_early_rejection_keeps_every_crossing(strength):
    """Also of lines through nodes and edges of violently torn triangles; and it rejects most of what is not crossed."""
    rng = np.random.default_rng(3)
    triangles, walls, start, end = moving_box(rng, strength)
    x0, x1 = rng.uniform(-0.4, 1.4, (2, 1500, 3))
    when = rng.uniform(size=(500, 1))
    pair = triangles[rng.integers(len(triangles), size=500)][:, :2]
    share = rng.choice([0.0, 0.5, 1.0], size=(500, 1))
    one, other = ((1.0 - when) * start[node] + when * end[node] for node in pair.T)
    met = share * one + (1.0 - share) * other  # on an edge, or a node
    x1[:500] = x0[:500] + (met - x0[:500]) / when
    swept = np.empty((len(triangles), SWEPT_NUMBERS))
    sweep.serial(len(triangles), walls.nodes, walls.orientation, start, end, swept)
    may, does = np.zeros((2, len(x0), len(triangles)), np.bool_)
    _compare_all.serial(len(x0), walls.nodes, walls.orientation, start, end, swept, x0, x1, may, does)
    assert does.sum() > 1000
    assert not (does & ~may).any()
    if strength <= 0.01:  # what fabric does in a step
        assert may.sum() < 1.2 * does.sum()


@pytest.mark.parametrize("strength", [0.0, 0.01, 0.06, 0.3])
def test_what_stays_away_is_not_met_again(strength):
    """Also of violently torn triangles, whose pieces form corners in which a particle is reflected twice."""
    rng = np.random.default_rng(5)
    triangles, walls, start, end = moving_box(rng, strength)
    inside = rng.uniform(0.02, 0.98, (4000, 3))
    x0, x1 = inside, inside + rng.normal(0.0, 1.0, (4000, 3))
    swept = np.empty((len(triangles), SWEPT_NUMBERS))
    sweep.serial(len(triangles), walls.nodes, walls.orientation, start, end, swept)
    away, again = np.zeros((len(x0), len(triangles)), np.int64), np.zeros((len(x0), len(triangles)), np.bool_)
    _reflect_all.serial(len(x0), walls.nodes, walls.orientation, start, end, swept, x0, x1, away, again)
    assert np.count_nonzero(away) > 2000
    assert not (again & (away == 2)).any()
    if strength <= 0.01:  # what fabric does in a step
        assert np.count_nonzero(away == 2) > 0.8 * np.count_nonzero(away)
    else:
        assert again.any()


def test_normal_and_travel_are_those_of_the_piece():
    """n . y - travel * tau is the same at the four corners of a piece and where the line crosses it."""
    rng = np.random.default_rng(3)
    _, walls, start, end = moving_box(rng, 0.06)
    x0, x1 = rng.uniform(0.3, 0.7, (300, 3)), rng.uniform(-1.0, 2.0, (300, 3))
    _, met = cross(walls, start, end, x0, x1)
    seen = np.flatnonzero(met[:, 0] >= 0)
    assert set(met[seen, 1]) == {0.0, 1.0, 2.0}
    for p in seen:
        t, piece, when = int(met[p, 0]), int(met[p, 1]), met[p, 2]
        *normal, travel = piece_normal(walls.nodes, walls.orientation, t, piece, start, end)
        corners = [(start, end)[late][walls.nodes[t, k]] @ normal - travel * late for k, late in PIECES[piece]]
        line = (x0[p] + when * (x1[p] - x0[p])) @ normal - travel * when
        assert np.ptp([*corners, line]) < 1e-11
        assert np.linalg.norm(normal) - 1.0 < 1e-14
