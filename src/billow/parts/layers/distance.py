"""Which pairs can matter in a step, and how far apart they are.

Most pairs of a list cannot touch in the step at hand. Along its last normal, the nodes of one side lie farther from
those of the other than a bound that costs four scalar products; a pair whose bound, less what its largest relative
speed can take away, leaves more than the gap, sleeps through the step. The bound is safe with any normal. So does a
pair of which the boxes around the paths of both sides stay apart.
"""

from __future__ import annotations

import math

from numba import prange

from billow.base.compiled import CHUNK, inlined, kernel, scalar
from billow.geometry.closest_points import of_segments, on_triangle
from billow.parts.layers.pairs import EDGES

PASSED = -0.5
"""Cosine of the angle by which a normal turns in a step, at which a pair counts as having changed sides."""


@inlined
def apart(k, key, nodes, normal, positions):
    """A lower bound of the distance of pair k along its last normal [m]."""
    nx, ny, nz = normal[k, 0], normal[k, 1], normal[k, 2]
    a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
    at_a = nx * positions[a, 0] + ny * positions[a, 1] + nz * positions[a, 2]
    at_b = nx * positions[b, 0] + ny * positions[b, 1] + nz * positions[b, 2]
    at_c = nx * positions[c, 0] + ny * positions[c, 1] + nz * positions[c, 2]
    at_d = nx * positions[d, 0] + ny * positions[d, 1] + nz * positions[d, 2]
    return at_a - max(at_b, at_c, at_d) if key[k] < EDGES else min(at_a, at_b) - max(at_c, at_d)


@inlined
def fastest(k, key, nodes, velocities):
    """Largest relative speed of nodes on the two sides of pair k [m/s]."""
    a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
    ac = (
        (velocities[a, 0] - velocities[c, 0]) ** 2 + (velocities[a, 1] - velocities[c, 1]) ** 2
        + (velocities[a, 2] - velocities[c, 2]) ** 2
    )  # fmt: skip
    ad = (
        (velocities[a, 0] - velocities[d, 0]) ** 2 + (velocities[a, 1] - velocities[d, 1]) ** 2
        + (velocities[a, 2] - velocities[d, 2]) ** 2
    )  # fmt: skip
    square = max(ac, ad)
    if key[k] < EDGES:
        ab = (
            (velocities[a, 0] - velocities[b, 0]) ** 2 + (velocities[a, 1] - velocities[b, 1]) ** 2
            + (velocities[a, 2] - velocities[b, 2]) ** 2
        )  # fmt: skip
        square = max(square, ab)
    else:
        bc = (
            (velocities[b, 0] - velocities[c, 0]) ** 2 + (velocities[b, 1] - velocities[c, 1]) ** 2
            + (velocities[b, 2] - velocities[c, 2]) ** 2
        )  # fmt: skip
        bd = (
            (velocities[b, 0] - velocities[d, 0]) ** 2 + (velocities[b, 1] - velocities[d, 1]) ** 2
            + (velocities[b, 2] - velocities[d, 2]) ** 2
        )  # fmt: skip
        square = max(square, bc, bd)
    return math.sqrt(square)


@inlined
def paths_meet(k, key, nodes, positions, velocities, ahead, near):
    """Whether boxes around the paths of the two sides of pair k, straight over `ahead` [s], come within `near` [m]."""
    a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
    together = True
    for axis in range(3):
        at_a, at_b, at_c, at_d = positions[a, axis], positions[b, axis], positions[c, axis], positions[d, axis]
        to_a, to_b = at_a + ahead * velocities[a, axis], at_b + ahead * velocities[b, axis]
        to_c, to_d = at_c + ahead * velocities[c, axis], at_d + ahead * velocities[d, axis]
        low, high = min(at_a, to_a), max(at_a, to_a)
        other_low, other_high = min(at_c, to_c, at_d, to_d), max(at_c, to_c, at_d, to_d)
        low_b, high_b = min(at_b, to_b), max(at_b, to_b)
        if key[k] < EDGES:
            other_low, other_high = min(other_low, low_b), max(other_high, high_b)
        else:
            low, high = min(low, low_b), max(high, high_b)
        together = together and low <= other_high + near and other_low <= high + near
    return together


@scalar
def closest(is_edges, ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz):
    """Weights of the four nodes of a pair, and the way from its second side to its first [m]."""
    if is_edges:
        s, t, rx, ry, rz = of_segments(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)
        return 1.0 - s, s, t - 1.0, -t, rx, ry, rz
    s, t, rx, ry, rz = on_triangle(ax, ay, az, bx, by, bz, cx, cy, cz, dx, dy, dz)
    return 1.0, s + t - 1.0, -s, -t, rx, ry, rz


@kernel
def wake(n, key, nodes, normal, positions, velocities, reach, ahead, full_gap, gap_out, impulse_out, awake_out,
         count_out):  # fmt: skip
    """Indices of the pairs that can matter, by chunks, each from its own place on. reach: distance [m] at which a pair
    does; ahead: time [s] for which its fastest nodes count. What sleeps is farther apart than the full gap, so that it
    has that gap and no impulse."""
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        count = chunk * CHUNK
        for k in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            left = apart(k, key, nodes, normal, positions)
            if left > reach and (
                left - ahead * fastest(k, key, nodes, velocities) > reach
                or not paths_meet(k, key, nodes, positions, velocities, ahead, reach)
            ):
                gap_out[k], impulse_out[k] = full_gap, 0.0
                continue
            awake_out[count] = k
            count += 1
        count_out[chunk] = count - chunk * CHUNK


@kernel
def wake_struck(n, key, nodes, normal, positions, velocities, struck, is_awake, reach, ahead, awake_out, count_out):
    """Likewise, pairs that sleep although one of their nodes was struck: nodes whose velocity an impulse changed by
    more than sleepers are ready for. struck: (nodes,) bool; is_awake: (pairs,) bool."""
    for chunk in prange((n + CHUNK - 1) // CHUNK):
        count = chunk * CHUNK
        for k in range(chunk * CHUNK, min(n, (chunk + 1) * CHUNK)):
            if is_awake[k] or not (
                struck[nodes[k, 0]] or struck[nodes[k, 1]] or struck[nodes[k, 2]] or struck[nodes[k, 3]]
            ):
                continue
            left = apart(k, key, nodes, normal, positions)
            if left - ahead * fastest(k, key, nodes, velocities) <= reach and paths_meet(
                k, key, nodes, positions, velocities, ahead, reach
            ):
                awake_out[count] = k
                count += 1
        count_out[chunk] = count - chunk * CHUNK


@kernel
def gather(n, found, counts, indices_out):
    """Indices that chunks found, one chunk after the other."""
    into = 0
    for chunk in range(n):
        for i in range(chunk * CHUNK, chunk * CHUNK + counts[chunk]):
            indices_out[into] = found[i]
            into += 1


@kernel
def measure(n, awake, key, nodes, positions, moment, normal_out, weight_out, distance_out, measured_out):
    """Weights, normal and distance of the pairs awake [m], where they are not known at this moment yet."""
    for i in prange(n):
        k = awake[i]
        if measured_out[k] == moment:
            continue
        a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
        wa, wb, wc, wd, rx, ry, rz = closest(
            key[k] >= EDGES,
            positions[a, 0], positions[a, 1], positions[a, 2], positions[b, 0], positions[b, 1], positions[b, 2],
            positions[c, 0], positions[c, 1], positions[c, 2], positions[d, 0], positions[d, 1], positions[d, 2],
        )  # fmt: skip
        size = math.sqrt(rx * rx + ry * ry + rz * rz)
        weight_out[k, 0], weight_out[k, 1], weight_out[k, 2], weight_out[k, 3] = wa, wb, wc, wd
        distance_out[k] = size
        measured_out[k] = moment
        if size > 0.0:  # what lies in one place keeps the normal it had
            normal_out[k, 0], normal_out[k, 1], normal_out[k, 2] = rx / size, ry / size, rz / size


@inlined
def speed_along(k, nodes, weight, normal, velocities):
    """Speed [m/s] at which the closest points of pair k part."""
    total = 0.0
    for i in range(4):
        j = nodes[k, i]
        along = normal[k, 0] * velocities[j, 0] + normal[k, 1] * velocities[j, 1] + normal[k, 2] * velocities[j, 2]
        total += weight[k, i] * along
    return total


@inlined
def nearest_after(k, key, nodes, normal, positions, velocities, dt):
    """True distance of pair k after a step of dt [s] [m], negative if its sides have changed places."""
    a, b, c, d = nodes[k, 0], nodes[k, 1], nodes[k, 2], nodes[k, 3]
    _, _, _, _, rx, ry, rz = closest(
        key[k] >= EDGES,
        positions[a, 0] + dt * velocities[a, 0], positions[a, 1] + dt * velocities[a, 1],
        positions[a, 2] + dt * velocities[a, 2],
        positions[b, 0] + dt * velocities[b, 0], positions[b, 1] + dt * velocities[b, 1],
        positions[b, 2] + dt * velocities[b, 2],
        positions[c, 0] + dt * velocities[c, 0], positions[c, 1] + dt * velocities[c, 1],
        positions[c, 2] + dt * velocities[c, 2],
        positions[d, 0] + dt * velocities[d, 0], positions[d, 1] + dt * velocities[d, 1],
        positions[d, 2] + dt * velocities[d, 2],
    )  # fmt: skip
    size = math.sqrt(rx * rx + ry * ry + rz * rz)
    along = rx * normal[k, 0] + ry * normal[k, 1] + rz * normal[k, 2]
    return -size if along < PASSED * size else size
