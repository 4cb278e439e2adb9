"""What a cluster holds at the start of a part of a step, and at its end: the sum of everything that happened to it.

Each cluster gathers in a fixed order, so that threads change no digit.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import inlined, kernel, scalar
from billow.geometry.lattice_clipping import NORMAL
from billow.parts.gas.mesh.slopes import forget
from billow.parts.gas.mesh.thermodynamics import RHO, C, P, T, U, Y, primitive
from billow.parts.gas.mesh.walls import fragment_velocity, pressure_on

TEAM = 128
"""Clusters that share scratch."""


@kernel
def gather(
    n, start, members, before, after, table, volume, held, temperature, weight, centroid, room, total_out, state_out,
    place_out, bad_out,
):  # fmt: skip
    """Totals, state and centroid of n clusters at the start; bad_out: (n,) bool, those with gas but without a state.

    held: (cells, species + 4) and temperature [K] (cells,): of the cells; weight: volume of each at the end [cells],
    and centroid (cells, 3). room: of a cell [m^3]. A cluster without gas has the pressure zero.
    """
    species = len(table)
    for c in prange(n):
        for k in range(species + 4):
            total_out[c, k] = 0.0
        x, y, z, total, guess, most = 0.0, 0.0, 0.0, 0.0, 0.0, -1.0
        for m in range(start[c], start[c + 1]):
            i = members[m]
            mass = 0.0
            for k in range(species + 4):
                total_out[c, k] += held[i, k]
            for k in range(species):
                mass += held[i, k]
            if mass > most:
                most, guess = mass, temperature[i]
            w = max(weight[i], 0.0) if after[c] > 0.0 else 1.0
            x, y, z, total = x + w * centroid[i, 0], y + w * centroid[i, 1], z + w * centroid[i, 2], total + w
        place_out[c, 0], place_out[c, 1], place_out[c, 2] = x / total, y / total, z / total
        bad_out[c] = False
        if not primitive(table, total_out, c, species, before[c] * room, guess, state_out, c):
            bad_out[c] = most > 0.0 and before[c] > 0.0
            for k in range(Y + species):
                state_out[c, k] = 0.0


@inlined
def _meet(c, at, cut, triangles, velocity, is_link, state, half, slope, place, weight, pressure_out, sums):
    """Pressure [Pa] on the fragments of cell `at` of a cut, in cluster c; adds to `sums` what they push with beyond the
    cluster's own pressure (3), and how much of it each speed of the cluster adds (6, the upper half of a matrix), per
    area of a face and weight."""
    _, start, order, rows, triangle, through = cut
    stiffness = weight * state[c, RHO] * state[c, C]
    for g in range(start[at], start[at + 1]):
        f = order[g]
        t = triangle[f]
        pressure_out[f] = 0.0
        if not is_link[t]:
            ux, uy, uz = fragment_velocity(rows, f, triangles, t, velocity)
            p = pressure_on(state, half, slope, place, c, rows, f, ux, uy, uz, through[f])
            pressure_out[f] = p
            nx, ny, nz = rows[f, NORMAL], rows[f, NORMAL + 1], rows[f, NORMAL + 2]
            push, k = weight * (p - state[c, P]), stiffness / math.sqrt(nx * nx + ny * ny + nz * nz)
            sums[0], sums[1], sums[2] = sums[0] + push * nx, sums[1] + push * ny, sums[2] + push * nz
            sums[3], sums[4], sums[5] = sums[3] + k * nx * nx, sums[4] + k * nx * ny, sums[5] + k * nx * nz
            sums[6], sums[7], sums[8] = sums[6] + k * ny * ny, sums[7] + k * ny * nz, sums[8] + k * nz * nz


@scalar
def _give_way(sums, scale):
    """Change of the cluster's velocity [m/s] by its walls, and the share of it that their pressure knows of.

    scale: dt times area of a face over mass. Between close walls gas stops within less than a step. Walls that only
    know its velocity at the start would throw it back and forth, harder each time; so as much of the change is made
    known to them as it takes that they just stop it.
    """
    stiff = scale * (sums[3] + sums[6] + sums[8])
    known = 1.0 - 1.0 / stiff if stiff > 1.0 else 0.0
    k = known * scale
    a, b, c = 1.0 + k * sums[3], k * sums[4], k * sums[5]
    d, e, f = 1.0 + k * sums[6], k * sums[7], 1.0 + k * sums[8]
    x, y, z = -scale * sums[0], -scale * sums[1], -scale * sums[2]
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    whole = a * first + b * second + c * third
    return (
        (first * x + second * y + third * z) / whole,
        (second * x + (a * f - c * c) * y + (b * c - a * e) * z) / whole,
        (third * x + (b * c - a * e) * y + (a * d - b * b) * z) / whole,
        known,
    )


@inlined
def _push(c, at, cut, triangles, velocity, is_link, state, way, weight, new, species, work_out):
    """Push of the fragments of cell `at` of a cut on cluster c, into new; work_out: the pressure on each, and after it
    the work [J]. way: as returned by `_give_way`. weight: times dt and the area of a face."""
    _, start, order, rows, triangle, _ = cut
    back = way[3] * state[c, RHO] * state[c, C]
    for g in range(start[at], start[at + 1]):
        f = order[g]
        t = triangle[f]
        if not is_link[t]:
            p, nx, ny, nz = work_out[f], rows[f, NORMAL], rows[f, NORMAL + 1], rows[f, NORMAL + 2]
            if back > 0.0:
                p += back * (way[0] * nx + way[1] * ny + way[2] * nz) / math.sqrt(nx * nx + ny * ny + nz * nz)
            ux, uy, uz = fragment_velocity(rows, f, triangles, t, velocity)
            push, work = weight * (p - state[c, P]), weight * p * (nx * ux + ny * uy + nz * uz)
            new[c, species] -= push * nx
            new[c, species + 1] -= push * ny
            new[c, species + 2] -= push * nz
            new[c, species + 3] -= work
            work_out[f] = work


@kernel
def add_fluxes(
    n, start, members, beside, aperture, of, in_old, in_new, old_start, new_start, total, gained, state, flux, face, dt,
    next_out, walled_out,
):  # fmt: skip
    """Totals of n clusters after a part of dt [s], walls still missing, into next_out; walled_out: (n,) bool, where
    there are any. gained: (n, species + 4), from sources, passages and openings. face: area of a face [m^2]."""
    species = total.shape[1] - 4
    for c in prange(n):
        for k in range(species + 4):
            next_out[c, k] = total[c, k] + gained[c, k]
        walled_out[c] = False
        p = state[c, P]
        if not p > 0.0:
            continue
        for m in range(start[c], start[c + 1]):
            i = members[m]
            a, b = in_old[i], in_new[i]
            if (a >= 0 and old_start[a + 1] > old_start[a]) or (b >= 0 and new_start[b + 1] > new_start[b]):
                walled_out[c] = True
            for side in range(6):
                j, d = beside[i, side], side // 2
                own = side % 2 == 1
                if j < 0:
                    continue
                k = i if own else j
                if not aperture[k, d] > 0.0:
                    continue
                # The still walls: what closes the cell, at the pressure of the cluster.
                sign = dt * face if own else -dt * face
                next_out[c, species + d] += sign * p * aperture[k, d]
                if of[j] == c:
                    continue
                mass = flux[k, d, 0]
                upwind = np.int64(c) if (mass > 0.0) == own else np.int64(of[j])  # c is unsigned in threads
                for s in range(species):
                    next_out[c, s] -= sign * mass * state[upwind, Y + s]
                for v in range(3):
                    next_out[c, species + v] -= sign * flux[k, d, U + v]
                next_out[c, species + 3] -= sign * flux[k, d, 4]


@kernel
def add_walls(
    n, clusters, start, members, old, new, triangles, velocity, is_link, total, state, half, slope, place, face, dt,
    middle, next_out, old_work_out, new_work_out,
):  # fmt: skip
    """Add what walls do to n of the clusters. old, new: (number of each cell, start, order, rows, triangle, speed of
    what flows through) of the fragments of the surface before and after, which count as `middle`, a share of time,
    says."""
    species = total.shape[1] - 4
    for team in prange((n + TEAM - 1) // TEAM):
        sums = np.empty(9)
        for at in range(team * TEAM, min(n, (team + 1) * TEAM)):
            c, mass = clusters[at], 0.0
            for s in range(species):
                mass += total[c, s]
            for k in range(9):
                sums[k] = 0.0
            for m in range(start[c], start[c + 1]):
                a, b = old[0][members[m]], new[0][members[m]]
                if a >= 0:
                    _meet(
                        c, a, old, triangles, velocity, is_link, state, half, slope, place, 1.0 - middle, old_work_out,
                        sums,
                    )  # fmt: skip
                if b >= 0:
                    _meet(
                        c, b, new, triangles, velocity, is_link, state, half, slope, place, middle, new_work_out, sums
                    )
            way = _give_way(sums, dt * face / mass)
            late = dt * face * middle
            for m in range(start[c], start[c + 1]):
                a, b, early = old[0][members[m]], new[0][members[m]], dt * face - late
                if a >= 0:
                    _push(c, a, old, triangles, velocity, is_link, state, way, early, next_out, species, old_work_out)
                if b >= 0:
                    _push(c, b, new, triangles, velocity, is_link, state, way, late, next_out, species, new_work_out)


@kernel
def new_states(n, after, table, total, room, state, state_out, bad_out):
    """States of n clusters that hold these totals at the end; bad_out: (n,) bool, those that have none."""
    species = len(table)
    for c in prange(n):
        bad_out[c], some = False, False
        for s in range(species):
            some = some or total[c, s] != 0.0
        if some and after[c] > 0.0:
            bad_out[c] = not primitive(table, total, c, species, after[c] * room, state[c, T], state_out, c)
        if bad_out[c] or not (some and after[c] > 0.0):
            for k in range(Y + species):
                state_out[c, k] = 0.0


@kernel
def hand_back(n, of, start, after, weight, total, state, held_out, temperature_out, sound_out):
    """Share the totals of clusters among their n cells, by volume at the end; room for gas or not, nothing is lost."""
    species_and_more = total.shape[1]
    for i in prange(n):
        c = of[i]
        share = weight[i] / after[c] if after[c] > 0.0 else 1.0 / (start[c + 1] - start[c])
        for k in range(species_and_more):
            held_out[i, k] = share * total[c, k]
        temperature_out[i], sound_out[i] = state[c, T], state[c, 5]


@scalar
def forget_slopes(bad, state, slope, half):
    """Make clusters that have no state donor cells; returns how many are so already, and the first of these or -1."""
    already, first = 0, -1
    for c in range(len(bad)):
        if bad[c]:
            flat = True
            for d in range(3):
                for v in range(5):
                    flat = flat and slope[c, d, v] == 0.0
            if flat:
                already += 1
                first = c if first < 0 else first
            forget(state, c, slope, half)
    return already, first
