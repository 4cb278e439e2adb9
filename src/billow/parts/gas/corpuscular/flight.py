"""Particles fly straight and bounce off moving walls; none gets lost (docs/theory.md, Flight).

The end of the path and the end of the walls' motion are the numbers with which the next step starts. Therefore `start`
of a step must be `end` of the last one, bit for bit.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel
from billow.geometry.search_grid import SearchGrid, clipped_cell
from billow.parts.gas.corpuscular.crossing import BOTH, INWARD, NEVER, OUTWARD, beside_wall, crossing, piece_normal
from billow.parts.gas.corpuscular.impact_bank import HITS_PER_CHUNK, Hits, ImpactBank
from billow.parts.gas.corpuscular.random_numbers import stream, uniform
from billow.parts.gas.corpuscular.walls import SWEPT_NUMBERS, Walls, may_cross, stays_away, sweep
from billow.parts.gas.corpuscular.whole_steps import (
    SET_BITS,
    from_the_end,
    pack_boxes,
    packed,
    step_of,
    steps_per_metre,
)

STANDOFF = 1e-9
"""Distance [m] from a wall at which a reflected particle starts again."""

MOST_HITS = 32
"""Hits per particle and step after which it is put beside a wall; a fold of angle a takes up to pi/a."""

UNCOUNTED = -(2**30)
"""Overlap of a particle that was put beside a wall: fabric may have moved over that place. No count reaches it; -1 is
one, of a particle that fabric has brought into the space of a chamber that openings join to its own."""

MOST_LOOKS = 100_000
"""Most pieces into which the search cuts a path; only meaningless velocities need so many."""

LEAST_REBOUND = 0.1
"""A particle bounces off the speed of its patch only if it then leaves the wall, as that really moves, with at least
this share of the speed it came with."""

_TIE = 1e-9
"""Fractions of a step closer than this count as simultaneous."""

_LATER = 1e-15
"""Fraction of a step by which the next layer of fabric to pass must come later than the last."""

PASSING = 0x5EED_0001
"""Names the random numbers that decide whether a particle passes a triangle."""


class Flock(NamedTuple):
    """The flying particles: arrays of equal length, changed in place by `fly`.

    position: [m], (particles, 3). velocity: [m/s], (particles, 3). species: (particles,) int32. identity: (particles,)
    int64, names the particle in random numbers. chamber: (particles,) int32, OUTSIDE once it has left. exit:
    (particles,) int32, the last opening it passed, -1 if none. overlap: (particles,) int32, layers of fabric through
    which it has come in from outside and not gone out again; UNCOUNTED after it was put beside a wall. group_overlap:
    the same of fabric around all chambers that openings join to its own.
    """

    position: np.ndarray
    velocity: np.ndarray
    species: np.ndarray
    identity: np.ndarray
    chamber: np.ndarray
    exit: np.ndarray
    overlap: np.ndarray
    group_overlap: np.ndarray


class Motion(NamedTuple):
    """A gas step of dt [s], in which the nodes move linearly from start to end [m], (nodes, 3)."""

    start: np.ndarray
    end: np.ndarray
    dt: float


class WallResponse(NamedTuple):
    """What a hit on each triangle does, (triangles,).

    pass_probability: 0 for tight fabric, 1 for an opening. passage: int32, the passage a triangle belongs to, if it can
    be passed. speed: of the wall along its normal, as its patch feels it [m/s]; particles bounce off this speed where
    that takes them away from the wall. If `speed` is empty they bounce off the wall as it really moves.
    """

    pass_probability: np.ndarray
    passage: np.ndarray
    speed: np.ndarray


@dataclass(frozen=True)
class FlightTally:
    """What happened in a step.

    energy_to_walls: [J], kinetic energy the particles lost in hits. hits: reflections and passages. passed: passages;
    through: mass that went through each passage from behind to ahead, less what came back [kg], (passages,). parked:
    particles that had MOST_HITS hits and were put beside a wall. bad: index of the first particle whose position is not
    finite, -1 if none.
    """

    energy_to_walls: float
    hits: int
    passed: int
    through: np.ndarray
    parked: int
    bad: int


class _Sums(NamedTuple):
    """By chunk of particles: the next one to fly; energy to the walls [J]; hits, passages, parked and the first bad
    particle, (chunks, 4); mass through each passage [kg], (chunks, passages)."""

    next_particle: np.ndarray
    energy: np.ndarray
    counts: np.ndarray
    through: np.ndarray


def fly(
    flock: Flock, particle_mass: np.ndarray, walls: Walls, grid: SearchGrid, motion: Motion, response: WallResponse,
    hits: Hits, bank: ImpactBank, seed: int, step: int, born: np.ndarray | None = None,
) -> FlightTally:  # fmt: skip
    """Fly all particles through a gas step; changes flock and bank.

    particle_mass: [kg] of one particle of each species, (species,). grid: must have followed this motion. hits: room
    for this many particles. seed, step: name the random numbers. born: fraction of the step at which each of the last
    particles starts from its position, (newborns,); the others, at the start of the step.
    """
    n = len(flock.position)
    chunks = -(-n // CHUNK)
    triangles = len(walls.nodes)
    swept, boxes = np.empty((triangles, SWEPT_NUMBERS)), np.empty((triangles, 2), np.uint64)
    sweep(triangles, walls.nodes, walls.orientation, motion.start, motion.end, swept)
    per_metre = steps_per_metre(grid)
    pack_boxes(triangles, walls.nodes, motion.start, motion.end, grid.origin, per_metre, boxes)
    sums = _Sums(
        np.arange(0, n, CHUNK, dtype=np.int64), np.zeros(chunks), np.zeros((chunks, 4), dtype=np.int64),
        np.zeros((chunks, 1 + max(0, int(response.passage.max(initial=0))))),
    )  # fmt: skip
    sums.counts[:, 3] = n
    born = np.empty(0) if born is None else born
    while True:
        _fly(
            n, flock, particle_mass, walls, swept, boxes, per_metre, grid, motion, response, seed + PASSING, step, born,
            hits, sums,
        )  # fmt: skip
        bank.collect(hits)
        if (sums.next_particle >= np.minimum(np.arange(1, chunks + 1) * CHUNK, n)).all():
            break
    total = sums.counts.sum(axis=0)
    bad = int(sums.counts[:, 3].min(initial=n))
    return FlightTally(
        float(sums.energy.sum()), int(total[0]), int(total[1]), sums.through.sum(axis=0), int(total[2]),
        bad if bad < n else -1,
    )  # fmt: skip


@kernel
def _fly(
    n, flock, particle_mass, walls, swept, boxes, per_metre, grid, motion, response, seed, step, born, hits, sums
):  # fmt: skip
    # numba silently loses what a prange writes to an array of a group, unless the array was taken from the group
    # before, by name, and not by unpacking a tuple of more than three.
    position, velocity = flock.position, flock.velocity
    overlap, group_overlap = flock.overlap, flock.group_overlap
    chamber, exit_out = flock.chamber, flock.exit
    species, identity = flock.species, flock.identity
    nodes, corner, orientation = walls.nodes, walls.corner, walls.orientation
    behind, ahead, group = walls.behind, walls.ahead, walls.group
    group_behind, group_ahead = walls.group_behind, walls.group_ahead
    start, end, dt = motion.start, motion.end, motion.dt
    pass_probability, passage, wall_speed = response.pass_probability, response.passage, response.speed
    first, listed = grid.first, grid.listed
    counts, clear = grid.counts, grid.clear
    hit_count, hit_triangle, hit_numbers = hits.count, hits.triangle, hits.numbers
    next_particle, energy_out = sums.next_particle, sums.energy
    tally_out, through_out = sums.counts, sums.through
    chunks = (n + CHUNK - 1) // CHUNK
    rate = 1.0 / dt
    ox, oy, oz, per_cell = grid.origin[0], grid.origin[1], grid.origin[2], 1.0 / grid.cell
    nx_cells, ny_cells, nz_cells = counts[0], counts[1], counts[2]
    looks_per_metre, cell, margin = 0.5 / grid.reach, grid.cell, grid.reach - grid.cell
    none, first_born = np.uint32(len(nodes)), n - len(born)
    for chunk in prange(chunks):
        recorded, energy = 0, 0.0
        p = next_particle[chunk]
        stop = min(n, (chunk + 1) * CHUNK)
        # A chunk whose room for hits runs low waits for them to be collected.
        while p < stop and recorded + MOST_HITS <= HITS_PER_CHUNK:
            home = chamber[p]
            if home < 0:
                p += 1
                continue
            px, py, pz = position[p, 0], position[p, 1], position[p, 2]
            vx, vy, vz = velocity[p, 0], velocity[p, 1], velocity[p, 2]
            x0, y0, z0, now, left = px, py, pz, 0.0, dt
            if p >= first_born:
                now = born[p - first_born]
                left = (1.0 - now) * dt
                x0, y0, z0 = px - vx * (now * dt), py - vy * (now * dt), pz - vz * (now * dt)
            x1, y1, z1 = px + vx * left, py + vy * left, pz + vz * left
            cell_x = clipped_cell(px, ox, per_cell, nx_cells)
            cell_y = clipped_cell(py, oy, per_cell, ny_cells)
            cell_z = clipped_cell(pz, oz, per_cell, nz_cells)
            free = clear[np.uint64((cell_x * ny_cells + cell_y) * nz_cells + cell_z)]
            room = free * cell + margin
            if free > 0 and abs(x1 - px) < room and abs(y1 - py) < room and abs(z1 - pz) < room:
                # No triangle is as near as it gets.
                position[p, 0], position[p, 1], position[p, 2] = x1, y1, z1
                p += 1
                continue
            struck, skip, passed, since, lap = 0, none, none, now - _TIE, overlap[p]
            crowd, group_lap = group[home], group_overlap[p]
            while True:
                # First crossing on the path from (px, py, pz) to (x1, y1, z1), searched in pieces that the lists of one
                # cell cover. Written out here: a call with this many arrays costs as much as the search.
                fraction, t, way, piece, wi, wj, wk = NEVER, none, 0, 0, 0.0, 0.0, 0.0
                way_x, way_y, way_z = x1 - px, y1 - py, z1 - pz
                extent = max(abs(way_x), abs(way_y), abs(way_z)) * looks_per_metre
                looks = int(extent) + 1 if extent < MOST_LOOKS else MOST_LOOKS
                part = 1.0 / looks
                dx, dy, dz = part * way_x, part * way_y, part * way_z
                half_x, half_y, half_z = 0.5 * abs(dx) + STANDOFF, 0.5 * abs(dy) + STANDOFF, 0.5 * abs(dz) + STANDOFF
                for look in range(looks):
                    mx, my, mz = px + (look + 0.5) * dx, py + (look + 0.5) * dy, pz + (look + 0.5) * dz
                    cell_x = clipped_cell(mx, ox, per_cell, nx_cells)
                    cell_y = clipped_cell(my, oy, per_cell, ny_cells)
                    cell_z = clipped_cell(mz, oz, per_cell, nz_cells)
                    place = np.uint64((cell_x * ny_cells + cell_y) * nz_cells + cell_z)
                    begin, finish = np.uint64(first[place]), np.uint64(first[place + np.uint64(1)])
                    if begin == finish:
                        continue
                    near = packed(
                        step_of(mx - half_x, ox, per_metre), step_of(my - half_y, oy, per_metre),
                        step_of(mz - half_z, oz, per_metre),
                    )  # fmt: skip
                    far = from_the_end(
                        step_of(mx + half_x, ox, per_metre), step_of(my + half_y, oy, per_metre),
                        step_of(mz + half_z, oz, per_metre),
                    )  # fmt: skip
                    for entry in range(begin, finish):
                        s = listed[entry]
                        if (boxes[s, 0] - near) & (boxes[s, 1] - far) & SET_BITS != SET_BITS:
                            continue
                        if s == skip:
                            continue
                        own = behind[s] == home or ahead[s] == home
                        if not own and (
                            group_behind[s] == group_ahead[s] or (group_behind[s] != crowd and group_ahead[s] != crowd)
                        ):
                            continue
                        if not may_cross(swept, s, x0, y0, z0, x1, y1, z1, STANDOFF):
                            continue
                        # An opening that turns in the step can be passed, and passed back, by a straight path.
                        after = now + _LATER if s == passed else since
                        when, which, cut, a, b, c = crossing(
                            nodes, orientation, s, start, end, x0, y0, z0, x1, y1, z1, BOTH, after
                        )
                        out = OUTWARD if (behind[s] == home if own else group_behind[s] == crowd) else INWARD
                        if when <= now and which != out:
                            # Rounding near the last reflection: it cannot have come from the other side.
                            when, which, cut, a, b, c = crossing(
                                nodes, orientation, s, start, end, x0, y0, z0, x1, y1, z1, out, since
                            )
                        # Ties go to the lower index, so that the order of the lists does not matter.
                        if when < fraction or (when == fraction and when < NEVER and s < t):
                            fraction, t, way, piece, wi, wj, wk = when, s, which, cut, a, b, c
                    # Crossings in later pieces are later, except for ties.
                    if fraction + _TIE < now + (1.0 - now) * (look + 1) * part:
                        break
                if fraction == NEVER:
                    break
                fraction = max(fraction, now)
                nx, ny, nz, travel = piece_normal(nodes, orientation, t, piece, start, end)
                approach = vx * nx + vy * ny + vz * nz - travel * rate
                outward = way == OUTWARD
                if outward != (approach > 0.0):
                    approach = -approach  # a rounding error of the wrong sign
                own = behind[t] == home or ahead[t] == home
                if behind[t] != ahead[t]:
                    outer = group_behind[t] != group_ahead[t]
                    comes_in = outward != (behind[t] == home if own else group_behind[t] == crowd)
                    if comes_in or (group_lap if outer else lap) > 0:
                        layer = 1 if comes_in else -1
                        lap += layer if own else 0
                        group_lap += layer if outer else 0
                        now, since, skip, passed = fraction, fraction + _LATER, none, none
                        px, py, pz = x0 + vx * (now * dt), y0 + vy * (now * dt), z0 + vz * (now * dt)
                        continue
                if struck == MOST_HITS:
                    x1, y1, z1 = beside_wall(t, wi, wj, wk, outward, walls, end, grid)
                    tally_out[chunk, 2] += 1
                    lap = group_lap = UNCOUNTED
                    break
                if len(wall_speed) > 0:
                    felt = vx * nx + vy * ny + vz * nz - wall_speed[t]
                    if felt * approach > 0.0 and (2.0 * felt - approach) / approach > LEAST_REBOUND:
                        approach = felt
                weight0 = wi if corner[t, 0] == 0 else (wj if corner[t, 1] == 0 else wk)
                weight1 = wi if corner[t, 0] == 1 else (wj if corner[t, 1] == 1 else wk)
                mass = particle_mass[species[p]]
                hit_triangle[chunk, recorded] = np.int32(t) if outward else ~np.int32(t)
                hit_numbers[chunk, recorded, 3], hit_numbers[chunk, recorded, 4] = weight0, weight1
                hit_numbers[chunk, recorded, 5] = 2.0 * mass * abs(approach)
                hit_numbers[chunk, recorded, 6] = mass
                jx, jy, jz = 0.0, 0.0, 0.0
                chance = pass_probability[t]
                passes = chance > 0.0 and (chance >= 1.0 or uniform(stream(seed, step, identity[p]), struck) < chance)
                struck += 1
                if not passes:
                    gap = STANDOFF * rate / abs(approach) if approach != 0.0 else 1.0
                    now = fraction - min(gap, 0.5 * (fraction - now))
                    px, py, pz = x0 + vx * (now * dt), y0 + vy * (now * dt), z0 + vz * (now * dt)
                    jx, jy, jz = 2.0 * approach * nx, 2.0 * approach * ny, 2.0 * approach * nz
                    energy += mass * (jx * (vx - 0.5 * jx) + jy * (vy - 0.5 * jy) + jz * (vz - 0.5 * jz))
                    vx -= jx
                    vy -= jy
                    vz -= jz
                hit_numbers[chunk, recorded, 0] = mass * jx
                hit_numbers[chunk, recorded, 1] = mass * jy
                hit_numbers[chunk, recorded, 2] = mass * jz
                recorded += 1
                tally_out[chunk, 0] += 1
                if passes:
                    tally_out[chunk, 1] += 1
                    exit_out[p] = np.int32(t)
                    through_out[chunk, passage[t]] += mass if outward else -mass
                    now, since, skip, passed = fraction, fraction - _TIE, none, t
                    home = ahead[t] if outward else behind[t]
                    px, py, pz = x0 + vx * (now * dt), y0 + vy * (now * dt), z0 + vz * (now * dt)
                    if home < 0:
                        x1, y1, z1 = px, py, pz
                        break
                    crowd, lap = group[home], 0
                    continue
                left = (1.0 - now) * dt
                leaves = vx * nx + vy * ny + vz * nz - travel * rate
                leaves = -leaves if outward else leaves
                speed = math.sqrt(vx * vx + vy * vy + vz * vz)
                since, passed = now - _TIE, none
                skip = t if stays_away(swept, t, leaves * dt, speed * dt) else none
                x0, y0, z0 = px - vx * (now * dt), py - vy * (now * dt), pz - vz * (now * dt)
                x1, y1, z1 = px + vx * left, py + vy * left, pz + vz * left
            position[p, 0], position[p, 1], position[p, 2] = x1, y1, z1
            overlap[p], group_overlap[p] = lap, group_lap
            if struck > 0:
                velocity[p, 0], velocity[p, 1], velocity[p, 2] = vx, vy, vz
                chamber[p] = home
            if not abs(x1 + y1 + z1) < np.inf:
                tally_out[chunk, 3] = min(tally_out[chunk, 3], p)
            p += 1
        next_particle[chunk] = p
        hit_count[chunk] = recorded
        energy_out[chunk] += energy
