"""What walls do to the gas in a part of a step, and the gas to the walls.

A wall pushes with the pressure of half a Riemann problem about the state half-way through the part. The force on the
fabric at the end of the step is that pressure and half of what a wall would feel of the change of the cluster's state
in the part, dp + rho c n.du. So what gas and fabric give each other over a time is the same but for what the first and
the last step change: the impulse is of second order in the step, and exact where the flow is steady.
"""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.triangle import double_area_vector
from billow.parts.gas.mesh.patches import AREA, AT, BEFORE, SIDE, SPEED
from billow.parts.gas.mesh.riemann import SLOW, wall_pressure
from billow.parts.gas.mesh.slopes import GAMMA
from billow.parts.gas.mesh.thermodynamics import LANES, RHO, C, P, T, U, put_state, temperatures

END, GIVEN, BOOKS = 0, 1, 2
"""Columns of what is booked for a patch, and their number."""
LARGEST_SHARE = 0.02
"""Of the thermal energy of a cluster that is taken for debts in one step, at most; the rest is owed until the next."""
LEAST, MOST = 0.5, 2.0
"""Bounds of the pressure that slopes extrapolate to a wall, relative to that of the cluster."""


@scalar
def _give_way(sums, scale, ux, uy, uz):
    """Change of the cluster's velocity [m/s] by its walls and by what comes through openings, and the share of it that
    the walls' pressure knows of.

    scale: dt times area of a face over mass; u: change by openings, passages and sources [m/s]. Between close walls gas
    stops within less than a step. Walls that only know its velocity at the start would throw it back and forth, harder
    each time; so as much of the change is made known to them as it takes that they just stop it.
    """
    stiff = scale * (sums[3] + sums[6] + sums[8])
    known = 1.0 - 1.0 / stiff if scale * sums[9] > 1.0 else 0.0
    k = known * scale
    a, b, c = 1.0 + k * sums[3], k * sums[4], k * sums[5]
    d, e, f = 1.0 + k * sums[6], k * sums[7], 1.0 + k * sums[8]
    x, y, z = ux - scale * sums[0], uy - scale * sums[1], uz - scale * sums[2]
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    whole = a * first + b * second + c * third
    return (
        (first * x + second * y + third * z) / whole,
        (second * x + (a * f - c * c) * y + (b * c - a * e) * z) / whole,
        (third * x + (b * c - a * e) * y + (a * d - b * b) * z) / whole,
        known,
    )


@kernel
def add_walls(
    n, start, members, after, walls, patches, rows, is_link, through, table, state, half, slope, place, total, gained,
    per_area, face, room, dt, held_out, temperature_out, sound_out, state_out, bad_out, booked_out,
):  # fmt: skip
    """Add what walls do to the n special clusters, and find their states.

    start, members, after: as in Clusters; walls, patches, rows: first patch of each cell, and
    of the patches triangle and rows; is_link: of the triangles; through: speed [m/s] at which gas leaves through each
    patch. total: what clusters held before; gained: what they get from sources, passages and openings. per_area: what
    is owed for triangles [J per face of a cell], to be paid now. face, room: area [m^2] and volume [m^3] of a cell.
    held_out, temperature_out, sound_out: as in `add_fluxes`. booked_out: (patches, BOOKS), pressure [Pa] at the end,
    and what the gas has given: work and debt [J].
    """
    species = len(table)
    for team in prange((n + LANES - 1) // LANES):
        sums, cells, guess, found = np.empty(10), np.empty(LANES, np.int64), np.empty(LANES), np.empty((4, LANES))
        begin, end = team * LANES, min(n, (team + 1) * LANES)
        for c in range(begin, end):
            cells[c - begin], guess[c - begin] = members[start[c]], state[c, T]
            first, own, mass, flow, debt = members[start[c]], state[c, P], 0.0, 0.0, 0.0
            for s in range(species):
                mass += total[c, s]
            if not own > 0.0:  # nothing was there to push
                continue
            sums[:] = 0.0
            rho_c = state[c, RHO] * state[c, C]
            rho, u, v, w, p = half[c, RHO], half[c, U], half[c, U + 1], half[c, U + 2], half[c, P]
            gamma, x, y, z = half[c, GAMMA], place[c, 0], place[c, 1], place[c, 2]
            sound = np.sqrt(gamma * p / rho)
            u_x, v_y, w_z = slope[c, 0, U], slope[c, 1, U + 1], slope[c, 2, U + 2]
            p_x, p_y, p_z = slope[c, 0, P], slope[c, 1, P], slope[c, 2, P]
            for m in range(start[c], start[c + 1]):
                for q in range(walls[members[m]], walls[members[m] + 1]):
                    debt += per_area[patches[q]] * rows[q, BEFORE]
                    booked_out[q, END] = 0.0
                    if is_link[patches[q]]:
                        continue
                    nx, ny, nz, area = rows[q, SIDE], rows[q, SIDE + 1], rows[q, SIDE + 2], rows[q, AREA]
                    dx, dy, dz = rows[q, AT] - x, rows[q, AT + 1] - y, rows[q, AT + 2] - z
                    du = (u + u_x * dx - rows[q, SPEED]) * nx + (v + v_y * dy - rows[q, SPEED + 1]) * ny
                    du += (w + w_z * dz - rows[q, SPEED + 2]) * nz
                    there = min(max(p + p_x * dx + p_y * dy + p_z * dz, LEAST * p), MOST * p)
                    du -= min(max(du, 0.0), through[q])
                    on = wall_pressure(rho, there, sound, gamma, du)
                    # How much less slower gas pushes: more than rho c where it meets the wall with a shock.
                    stiff = max(rho_c, (on - there) / du) if du > SLOW * sound else rho_c
                    booked_out[q, END], booked_out[q, GIVEN] = on, stiff
                    push, k = area * (on - own), stiff * area
                    sums[0], sums[1], sums[2] = sums[0] + push * nx, sums[1] + push * ny, sums[2] + push * nz
                    sums[3], sums[4], sums[5] = sums[3] + k * nx * nx, sums[4] + k * nx * ny, sums[5] + k * nx * nz
                    sums[6], sums[7], sums[8] = sums[6] + k * ny * ny, sums[7] + k * ny * nz, sums[8] + k * nz * nz
                    sums[9] += rho_c * area
            came = 0.0  # gas that comes or goes with the velocity of the cluster does not change it
            for s in range(species):
                came += gained[c, s]
            dvx, dvy, dvz, known = _give_way(
                sums, dt * face / mass, (gained[c, species] - came * state[c, U]) / mass,
                (gained[c, species + 1] - came * state[c, U + 1]) / mass,
                (gained[c, species + 2] - came * state[c, U + 2]) / mass,
            )  # fmt: skip
            px, py, pz, work = 0.0, 0.0, 0.0, 0.0
            share = 0.0
            if debt != 0.0:
                for d in range(3):
                    flow += total[c, species + d] ** 2
                limit = LARGEST_SHARE * (total[c, species + 3] - 0.5 * flow / mass)
                share = min(max(debt, -limit), limit) / debt
            for m in range(start[c], start[c + 1]):
                for q in range(walls[members[m]], walls[members[m] + 1]):
                    paid, back = share * per_area[patches[q]] * rows[q, BEFORE], known * booked_out[q, GIVEN]
                    booked_out[q, GIVEN] = paid
                    if is_link[patches[q]]:
                        continue
                    nx, ny, nz, area = rows[q, SIDE], rows[q, SIDE + 1], rows[q, SIDE + 2], rows[q, AREA]
                    on = booked_out[q, END] + back * (dvx * nx + dvy * ny + dvz * nz)
                    push = area * (on - own)
                    px, py, pz = px + push * nx, py + push * ny, pz + push * nz
                    moves = rows[q, SPEED] * nx + rows[q, SPEED + 1] * ny + rows[q, SPEED + 2] * nz
                    booked_out[q, END], booked_out[q, GIVEN] = on, paid + dt * face * area * on * moves
                    work += dt * face * area * on * moves
            held_out[first, species] -= dt * face * px
            held_out[first, species + 1] -= dt * face * py
            held_out[first, species + 2] -= dt * face * pz
            held_out[first, species + 3] -= work + share * debt
        temperatures(end - begin, table, held_out, cells, guess, found)
        for c in range(begin, end):
            k = c - begin
            first = cells[k]
            bad_out[c] = put_state(held_out, first, species, after[c] * room, found, k, state_out, c)
            temperature_out[first], sound_out[first] = state_out[c, T], state_out[c, C]
            own, now, rise = state[c, P], state_out[c, P], 0.5 * state[c, RHO] * state[c, C]
            dp = 0.5 * (now - own)
            dvx, dvy = rise * (state_out[c, U] - state[c, U]), rise * (state_out[c, U + 1] - state[c, U + 1])
            dvz = rise * (state_out[c, U + 2] - state[c, U + 2])
            for m in range(start[c], start[c + 1]):
                for q in range(walls[members[m]], walls[members[m] + 1]):
                    if not own > 0.0:
                        booked_out[q, END], booked_out[q, GIVEN] = now, 0.0
                    elif now > 0.0:
                        nx, ny, nz = rows[q, SIDE], rows[q, SIDE + 1], rows[q, SIDE + 2]
                        booked_out[q, END] = max(booked_out[q, END] + dp + dvx * nx + dvy * ny + dvz * nz, 0.0)


@kernel
def load(
    n, triangles, before, after, first, number, levers, of, booked, is_link, sign, outer, ambient, force, work_out,
    against_out,
):  # fmt: skip
    """Forces [N] of the gas on the corners of n triangles at the end of a step in place of those at its start, (n, 3,
    3), absolute; their work [J] over the step, and that of the ambient pressure [Pa] against them, (n,).

    before, after: positions of the nodes [m]. first, number, levers: as in `Fragments` after the step; of: the patch of
    each; booked: of the patches.
    """
    for t in prange(n):
        a, b, c = triangles[t, 0], triangles[t, 1], triangles[t, 2]
        ux, uy, uz = double_area_vector(before, a, b, c)
        vx, vy, vz = double_area_vector(after, a, b, c)
        on_a, on_b, on_c = 0.0, 0.0, 0.0
        for m in range(first[t], first[t + 1] if not is_link[t] else first[t]):
            half = 0.5 * booked[of[number[m]], END]
            on_a, on_b, on_c = on_a + half * levers[m, 0], on_b + half * levers[m, 1], on_c + half * levers[m, 2]
        pushes = (on_a, on_b, on_c)
        now = (sign[t] * vx, sign[t] * vy, sign[t] * vz)
        pull = ambient * sign[t] / 12.0 if outer[t] else 0.0
        mean = (pull * (ux + vx), pull * (uy + vy), pull * (uz + vz))
        work, against = 0.0, 0.0
        for k in range(3):
            node = triangles[t, k]
            for d in range(3):
                way, late = after[node, d] - before[node, d], pushes[k] * now[d]
                work += 0.5 * (force[t, k, d] + late) * way
                against += mean[d] * way
                force[t, k, d] = late
        work_out[t], against_out[t] = work, against
