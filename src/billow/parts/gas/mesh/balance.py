"""What a cluster holds at the start of a part of a step, and what flows into it and out of it.

Each cluster gathers in a fixed order, so that threads change no digit. A single cell without walls is its own cluster:
what it holds is never copied. The others, called special, are the first ones. What a cluster holds at the end is
written to its first cell, and shared in the end.
"""

from __future__ import annotations

import math

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar, spliced
from billow.parts.gas.mesh.slopes import VALUES, forget
from billow.parts.gas.mesh.thermodynamics import (
    CAPACITY,
    FOUND,
    GAS,
    LANES,
    MASS,
    RHO,
    C,
    G,
    P,
    T,
    U,
    Y,
    contents,
    put_state,
    temperatures,
)

LARGEST_SHARE = 0.02
"""Of the thermal energy of a cluster, at most, that motion of its cells against each other holds."""


@kernel
def gather(
    n, special, start, members, before, after, table, held, temperature, sound, weight, centroid, room, total_out,
    state_out, place_out, bad_out,
):  # fmt: skip
    """Totals of the special clusters, and state and centroid of all n at the start; bad_out: (n,) bool, those with gas
    but without a state.

    held: (cells, species + 4), temperature [K] and speed of sound [m/s], (cells,): of
    the cells; weight: volume of each at the end [cells], and centroid (cells, 3). room: of a cell [m^3]. A cluster
    without gas has the pressure zero.
    """
    species = len(table)
    for team in prange((n + LANES - 1) // LANES):
        rows, guess, found = np.empty(LANES, np.int64), np.empty(LANES), np.empty((4, LANES))
        wanted = np.int64(0)  # for a plain 0 numba would compile what takes it twice
        for c in range(team * LANES, min(n, (team + 1) * LANES)):
            first, alone = members[start[c]], start[c + 1] - start[c] == 1
            if alone and (c >= special or temperature[first] > 0.0):
                for d in range(3):
                    place_out[c, d] = centroid[first, d]
                if c < special:
                    for k in range(species + 4):
                        total_out[c, k] = held[first, k]
                mass, gas_constant, thermal = contents(table, held, first, species)
                bad_out[c] = False
                if mass > 0.0 and thermal > 0.0 and before[c] > 0.0 and temperature[first] > 0.0:
                    heat, share, density = gas_constant * temperature[first], 1.0 / mass, 1.0 / (before[c] * room)
                    state_out[c, RHO], state_out[c, P] = mass * density, heat * density
                    for d in range(3):
                        state_out[c, U + d] = share * held[first, species + d]
                    state_out[c, C], state_out[c, T] = sound[first], temperature[first]
                    state_out[c, G] = 1.0 + heat / thermal
                    for k in range(species):
                        state_out[c, Y + k] = share * held[first, k]
                else:
                    bad_out[c] = mass != 0.0 and before[c] > 0.0
                    for k in range(Y + species):
                        state_out[c, k] = 0.0
                continue
            for k in range(species + 4):
                total_out[c, k] = 0.0
            x, y, z, total, most = 0.0, 0.0, 0.0, 0.0, -1.0
            for m in range(start[c], start[c + 1]):
                i = members[m]
                mass = 0.0
                for k in range(species + 4):
                    total_out[c, k] += held[i, k]
                for k in range(species):
                    mass += held[i, k]
                if mass > most:
                    most, guess[wanted] = mass, temperature[i]
                w = max(weight[i], 0.0) if after[c] > 0.0 else 1.0
                x, y, z, total = x + w * centroid[i, 0], y + w * centroid[i, 1], z + w * centroid[i, 2], total + w
            place_out[c, 0], place_out[c, 1], place_out[c, 2] = x / total, y / total, z / total
            rows[wanted] = c
            wanted += 1
        temperatures(wanted, table, total_out, rows, guess, found)
        for k in range(wanted):
            c = rows[k]
            bad_out[c] = put_state(total_out, c, species, before[c] * room, found, k, state_out, c)


@kernel
def add_fluxes(
    n, special, start, members, beside, aperture, of, after, table, held, total, gained, state, flux, face, dt,
    held_out, temperature_out, sound_out, bad_out,
):  # fmt: skip
    """What n clusters hold after a part of dt [s], into held_out of their first cells, and the temperature and speed of
    sound there; of the special ones walls are still missing, and these two. gained: (special, species + 4), what these
    get from sources, passages and openings. face: area [m^2] of a cell. bad_out: (n,) bool, those that have gas and no
    state."""
    species = len(table)
    for team in prange((n + LANES - 1) // LANES):
        rows, whose = np.empty(LANES, np.int64), np.empty(LANES, np.int64)
        guess, found, wanted = np.empty(LANES), np.empty((4, LANES)), np.int64(0)
        for c in range(team * LANES, min(n, (team + 1) * LANES)):
            first, bad_out[c] = members[start[c]], False
            if c >= special and min(beside[first, 0], beside[first, 2], beside[first, 4]) >= 0:
                # No walls: faces on both sides of an axis are open by the same share, and the push of still walls
                # cancels. Those that are not open have fluxes of zero.
                own, i0, i1, i2 = np.int64(c), beside[first, 0], beside[first, 2], beside[first, 4]
                m0, m1, m2 = flux[i0, 0, 0], flux[i1, 1, 0], flux[i2, 2, 0]
                m3, m4, m5 = flux[first, 0, 0], flux[first, 1, 0], flux[first, 2, 0]
                c0, c1, c2 = own if m0 < 0.0 else of[i0], own if m1 < 0.0 else of[i1], own if m2 < 0.0 else of[i2]
                c3 = own if not m3 < 0.0 else of[beside[first, 1]]
                c4 = own if not m4 < 0.0 else of[beside[first, 3]]
                c5 = own if not m5 < 0.0 else of[beside[first, 5]]
                for s in range(species):
                    k = Y + s
                    low = m0 * state[c0, k] + m1 * state[c1, k] + m2 * state[c2, k]
                    high = m3 * state[c3, k] + m4 * state[c4, k] + m5 * state[c5, k]
                    held_out[first, s] = held[first, s] - dt * face * (high - low)
                for v in range(1, VALUES):
                    low = flux[i0, 0, v] + flux[i1, 1, v] + flux[i2, 2, v]
                    high = flux[first, 0, v] + flux[first, 1, v] + flux[first, 2, v]
                    held_out[first, species + v - 1] = held[first, species + v - 1] - dt * face * (high - low)
            else:
                p = state[c, P]
                x, y, z, energy = 0.0, 0.0, 0.0, 0.0  # what flows out
                for k in range(species + 4):
                    held_out[first, k] = total[c, k] + gained[c, k] if c < special else held[first, k]
                for m in range(start[c], start[c + 1] if p > 0.0 else start[c]):
                    i = members[m]
                    for side in range(6):
                        j, d = beside[i, side], side // 2
                        own = side % 2 == 1
                        if j < 0:
                            continue
                        k = i if own else j
                        if not aperture[k, d] > 0.0:
                            continue
                        # The still walls: what closes the cell, at the pressure of the cluster.
                        sign = 1.0 if own else -1.0
                        push = sign * p * aperture[k, d]
                        x, y, z = (
                            x - (push if d == 0 else 0.0),
                            y - (push if d == 1 else 0.0),
                            z - (push if d == 2 else 0.0),
                        )
                        if of[j] == c:
                            continue
                        mass = sign * dt * face * flux[k, d, 0]
                        upwind = np.int64(c) if mass > 0.0 else np.int64(of[j])  # c is unsigned in threads
                        for s in range(species):
                            held_out[first, s] -= mass * state[upwind, Y + s]
                        x, y, z = x + sign * flux[k, d, U], y + sign * flux[k, d, U + 1], z + sign * flux[k, d, U + 2]
                        energy += sign * flux[k, d, 4]
                held_out[first, species] -= dt * face * x
                held_out[first, species + 1] -= dt * face * y
                held_out[first, species + 2] -= dt * face * z
                held_out[first, species + 3] -= dt * face * energy
            if c >= special:
                temperature_out[first], sound_out[first] = 0.0, 0.0
                if after[c] > 0.0:
                    rows[wanted], guess[wanted], whose[wanted] = first, state[c, T], c
                    wanted += 1
        temperatures(wanted, table, held_out, rows, guess, found)
        for k in range(wanted):
            t, cp, gas_constant, mass = found[FOUND, k], found[CAPACITY, k], found[GAS, k], found[MASS, k]
            if t > 0.0:
                temperature_out[rows[k]] = t
                sound_out[rows[k]] = math.sqrt(cp / (cp - gas_constant) * gas_constant * t / mass)
            else:
                bad_out[whose[k]] = mass != 0.0


@spliced
def _differ(c, place, slope, a, b, new_volume, old_centroid, new_centroid, faster_out):
    """How much faster [m/s] gas is along each axis at the centroid of a cell than that of its cluster c, by the slopes.
    a, b: number of the cell before and after the step, or -1; centroids as in `geometry`."""
    is_new = b >= 0 and (new_volume[b] != 0.0 or a < 0)
    for d in range(3):
        faster_out[d] = 0.0
    for k in range(3 if is_new or a >= 0 else 0):
        off = (new_centroid[b, k] if is_new else old_centroid[a, k]) - place[c, k]
        for d in range(3):
            faster_out[d] += slope[c, k, U + d] * off


@kernel
def share_out(
    n, start, members, in_old, in_new, new_volume, old_centroid, new_centroid, place, slope, after, weight, table, held,
    temperature, sound,
):  # fmt: skip
    """Share what the first cells of n clusters hold among their cells, by volume at the end; momentum by the slopes of
    the velocity too. Room for gas or not, nothing is lost.

    A cell that has grown leaves its cluster with the velocity at its own place. With that of the cluster, the scheme
    would be of first order where walls move from cell to cell: each of these cells would send out a wave. The energy of
    what cells differ in is taken from their heat, LARGEST_SHARE of it at most; slopes are followed less far than
    that. in_old, in_new: as in `blend`; place, slope: of the clusters; after, weight: volumes [cells] of clusters and
    cells at the end.
    """
    species = len(table)
    for team in prange((n + LANES - 1) // LANES):
        whose, rows, guess = np.empty(LANES, np.int64), np.empty(LANES, np.int64), np.empty(LANES)
        found, faster, wanted = np.empty((4, LANES)), np.empty(3), np.int64(0)
        for c in range(team * LANES, min(n, (team + 1) * LANES)):
            begin, end = start[c], start[c + 1]
            if end - begin == 1:
                continue
            first = members[begin]
            mass, _, thermal = contents(table, held, first, species)
            follows = thermal > 0.0 and after[c] > 0.0
            for m in range(begin, end):
                follows = follows and weight[members[m]] >= 0.0
            apart, largest = 0.0, first
            for m in range(begin, end if follows else begin):
                i = members[m]
                largest = i if weight[i] > weight[largest] else largest
                _differ(c, place, slope, in_old[i], in_new[i], new_volume, old_centroid, new_centroid, faster)
                scale = 0.5 * mass * weight[i] / after[c]
                apart += scale * (faster[0] * faster[0] + faster[1] * faster[1] + faster[2] * faster[2])
            far = math.sqrt(min(1.0, LARGEST_SHARE * thermal / apart)) if apart > 0.0 else 0.0
            heat = thermal - far * far * apart
            for m in range(end - 1, begin - 1, -1):  # the first one last
                i = members[m]
                share = weight[i] / after[c] if after[c] > 0.0 else 1.0 / (end - begin)
                if far > 0.0:
                    _differ(c, place, slope, in_old[i], in_new[i], new_volume, old_centroid, new_centroid, faster)
                for k in range(species + 4):
                    held[i, k] = share * held[first, k]
                if far > 0.0:
                    flow = 0.0
                    for d in range(3):
                        held[i, species + d] += far * share * mass * faster[d]
                        flow += held[i, species + d] ** 2
                    held[i, species + 3] = share * heat + (0.5 * flow / (share * mass) if share > 0.0 else 0.0)
                temperature[i], sound[i] = temperature[first], sound[first]
            if far > 0.0:
                whose[wanted], rows[wanted], guess[wanted] = c, largest, temperature[first]
                wanted += 1
        # All cells of a cluster have one temperature still, that of the largest one, which holds gas.
        temperatures(wanted, table, held, rows, guess, found)
        for k in range(wanted):
            t, cp, gas_constant, mass = found[FOUND, k], found[CAPACITY, k], found[GAS, k], found[MASS, k]
            for m in range(start[whose[k]], start[whose[k] + 1]):
                temperature[members[m]] = t
                sound[members[m]] = math.sqrt(cp / (cp - gas_constant) * gas_constant * t / mass)


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
