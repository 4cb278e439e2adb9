"""Flow through vents and porous fabric, fragment by fragment, by the laws that all gas models share.

Each fragment has its part of the passage's area and the pressures of the clusters on either side, so that a vent feels
the jet that blows at it. The surroundings are a cluster of their own, which never empties.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.lattice_clipping import NORMAL
from billow.parts.gas.mesh.openings import fragment_velocity
from billow.parts.gas.mesh.thermodynamics import RHO, C, P, T, U, Y
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gamma, mixture_gas_constant
from billow.parts.gas.supply.outflow import conductance
from billow.parts.gas.supply.passages import FABRIC, KIND, LAW, effective_area

LARGEST_SHARE = 0.25
"""Of a cluster's mass that may leave, or come, in a part of a step."""
LARGEST_RELIEF = 0.25
"""Of what makes the pressures on both sides of porous fabric equal, that may pass through one panel in a part of a
step. Gas of stiffness k between sheets of mass m swings with w^2 = k/m; with a relief r in each step dt, gas and sheets
by turns are stable while (w dt)^2 < 4 - 2 r, and a layer has two panels or, at a seam, three or four parts of them."""


class Side(NamedTuple):
    """The gas on one side of a passage. state: (clusters, Y + species); gained: (clusters, species + 4), what is given
    to each; mass: [kg], (clusters,), infinite for the surroundings; cluster: of each fragment, (fragments,) int32;
    coming: the gas that comes to it if it is a hole, as from `gas_before`; leaving: the gas that flows away from it, as
    from `gas_leaving`; patch: of each fragment, through which gas leaves at the speeds `through` [m/s]."""

    state: np.ndarray
    gained: np.ndarray
    mass: np.ndarray
    cluster: np.ndarray
    coming: np.ndarray
    leaving: float
    patch: np.ndarray
    through: np.ndarray


def surroundings(table: np.ndarray, ambient: Ambient, fragments: int) -> Side:
    """The still air outside a number of fragments."""
    fractions = ambient.mass_fractions
    gamma = mixture_gamma(table, fractions, ambient.temperature)
    rt = mixture_gas_constant(table, fractions) * ambient.temperature
    state = np.zeros((1, Y + len(table)))
    state[0, RHO], state[0, P], state[0, T] = ambient.pressure / rt, ambient.pressure, ambient.temperature
    state[0, C], state[0, Y:] = np.sqrt(gamma * rt), fractions
    gained, mass = np.zeros((1, len(table) + 4)), np.full(1, np.inf)
    cluster, patch = np.zeros(fragments, np.int32), np.zeros(fragments, np.int32)
    return Side(state, gained, mass, cluster, state[0, : P + 1], 0.0, patch, np.zeros(1))


@scalar
def gas_before(cluster, start, members, of, beside, aperture, state):
    """Mean state rho, u, v, w, p of the gas that comes to a hole, (5,), by area of open faces: that of the clusters
    beside those at the hole; if there are none, of what is at the hole.

    cluster: of each fragment of the hole. start, members, of: as in Clusters; beside, aperture: of the cells. Gas that
    turns into a hole within a cell or two loses total pressure that it would keep in finer cells: entropy of the
    scheme. A cell before the hole it still has it.
    """
    found, whole = np.zeros(P + 1), 0.0
    at_hole = np.zeros(len(state), np.bool_)
    for m in range(len(cluster)):
        at_hole[cluster[m]] = True
    for m in range(len(cluster)):
        c = cluster[m]
        for g in range(start[c], start[c + 1]):
            i = members[g]
            for face in range(6):
                j, d = beside[i, face], face // 2
                if j >= 0 and not at_hole[of[j]] and state[of[j], P] > 0.0:
                    a = max(aperture[i, d] if face % 2 else aperture[j, d], 0.0)
                    whole += a
                    for v in range(P + 1):
                        found[v] += a * state[of[j], v]
    if whole > 0.0:
        return found / whole
    for m in range(len(cluster)):
        found += state[cluster[m], : P + 1]
    return found / max(len(cluster), 1)


@scalar
def gas_leaving(cluster, start, members, of, beside, aperture, state):
    """Mass flow [kg/(m^2 s)], times area in faces of a cell, from the clusters at a hole to those beside them, by the
    velocities on both sides of each open face; arguments as of `gas_before`."""
    flow, at_hole, counted = 0.0, np.zeros(len(state), np.bool_), np.zeros(len(state), np.bool_)
    for m in range(len(cluster)):
        at_hole[cluster[m]] = True
    for m in range(len(cluster)):
        c = cluster[m]
        if counted[c]:
            continue
        counted[c] = True
        for g in range(start[c], start[c + 1]):
            i = members[g]
            for face in range(6):
                j, d = beside[i, face], face // 2
                if j >= 0 and not at_hole[of[j]] and state[of[j], P] > 0.0:
                    a = max(aperture[i, d], 0.0) if face % 2 else -max(aperture[j, d], 0.0)
                    flow += 0.5 * a * (state[c, RHO] * state[c, U + d] + state[of[j], RHO] * state[of[j], U + d])
    return flow


@scalar
def _most_taken(filled, coming, wanted, face, dt, weight):
    """Mass [kg] that the clusters at a hole can take in a share `weight` of a part of a step: what lifts their pressure
    to that of the gas that comes, and what flows on in dt [s], this share. filled: their Side. coming: as from
    `gas_before`. wanted: of each fragment [kg], zero where nothing flows. face: area of a cell's face [m^2].

    Through a hole over a layer much thinner than it is wide flows in a part of a step, at a few pascals, more than the
    layer holds. By the pressure at its start alone it would end far above the surroundings, and the bag would be
    pumped up by air at rest.
    """
    taken, counted = max(filled[5], 0.0) * face * dt, np.zeros(len(filled[2]), np.bool_)
    for m in range(len(wanted)):
        c = filled[3][m]
        if wanted[m] != 0.0 and not counted[c]:
            counted[c] = True
            gamma = filled[0][c, C] ** 2 * filled[0][c, RHO] / filled[0][c, P]
            volume = filled[2][c] / filled[0][c, RHO]
            taken += weight * max(coming[P] - filled[0][c, P], 0.0) * volume * coming[RHO] / (gamma * coming[P])
    return taken


@scalar
def _pressure_change(side, c, mass, rt):
    """Pressure [Pa] by which a mass [kg] of gas that flows with R T = rt [J/kg] changes cluster c of a Side."""
    if side[2][c] == np.inf:
        return 0.0
    return side[0][c, C] ** 2 * side[0][c, RHO] ** 2 / side[0][c, P] * rt * mass / side[2][c]


@scalar
def _stagnation(coming, gamma, inside, moves, m, rows, f, way):
    """Total pressure [Pa] and R T [J/kg] of the coming gas that flows towards fragment f, which moves as moves[m];
    static ones if it is not inside the bag. way: 1/|N|, or the opposite if the rows point to the gas."""
    along = 0.0
    for d in range(3):
        along += (coming[U + d] - moves[m, d]) * rows[f, NORMAL + d] * way
    rise = 1.0
    if inside and along > 0.0:
        rise += 0.5 * (gamma - 1.0) / gamma * along * along * coming[RHO] / coming[P]
    return coming[P] * rise ** (gamma / (gamma - 1.0)), coming[P] / coming[RHO] * rise


@scalar
def mean_lead(behind, ahead, rows, fragments):
    """Pressure behind less that ahead [Pa], mean over the area of a passage; behind, ahead: of each fragment."""
    lead, total = 0.0, 0.0
    for m in range(len(fragments)):
        f = fragments[m]
        a = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
        lead += a * (behind[m] - ahead[m])
        total += a
    return lead / total if total > 0.0 else 0.0


@scalar
def _throttled(behind, ahead, rows, fragments, flux):
    """Share of the lead of the coming gas that gets to a hole, by the mean over its area; flux: what the hole
    would pass of it per area [kg/(m^2 s)].

    Gas that comes without loss still has at the hole its pressure less that of its speed there, flux^2/(2 rho)
    (Bernoulli). Where the scheme makes entropy of that speed there is no less. So whatever is missing beyond it was
    lost on the way, by folds that throttle it.
    """
    at_hole, coming, total = 0.0, 0.0, 0.0
    for m in range(len(fragments)):
        f = fragments[m]
        size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
        p_behind, p_ahead = behind[0][behind[3][m], P], ahead[0][ahead[3][m], P]
        if p_behind > 0.0 and p_ahead > 0.0:
            at_hole += size * (p_behind - p_ahead)
            coming += size * (behind[4][P] - ahead[4][P])
            total += size
    forth = coming >= 0.0
    density = behind[4][RHO] if forth else ahead[4][RHO]
    lossless = abs(coming) - total * 0.5 * flux * flux / density
    arrives = at_hole if forth else -at_hole
    if arrives >= lossless:
        return 1.0
    return max(arrives, 0.0) / lossless if lossless > 0.0 else 0.0


@scalar
def flow_through(
    table, passages, k, present, behind, ahead, rows, fragments, triangle, triangles, velocity, face, open_share, sign,
    time, dt, weight, books_out,
):  # fmt: skip
    """Let gas through passage k of a PassageTable for a share `weight` of dt [s].

    present: its area now [m^2]. behind, ahead: Sides as plain tuples. rows, fragments, triangle, triangles, velocity:
    the fragments it consists of, their geometry and motion; face: area of a cell's face [m^2]; open_share: of each
    fragment, what contact leaves open. sign: 1.0 if the normals of the rows point from behind to ahead. books_out: (2,
    species + 1), what went from behind to ahead and back: masses [kg] and energy [J].
    """
    plan, n, species = passages.plan, len(fragments), len(table)
    porous, dt, largest = plan[k, KIND] == FABRIC, weight * dt, weight * LARGEST_SHARE
    total = 0.0
    for m in range(n):
        f = fragments[m]
        total += np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
    share, wanted, moves = 1.0, np.zeros(n), np.zeros((n, 3))
    relief_behind, relief_ahead = np.zeros(len(behind[2])), np.zeros(len(ahead[2]))
    from_behind, from_ahead = np.zeros(len(behind[2])), np.zeros(len(ahead[2]))
    for m in range(n):
        f, t = fragments[m], triangle[fragments[m]]
        moves[m, 0], moves[m, 1], moves[m, 2] = fragment_velocity(rows, f, triangles, t, velocity)
    for throttling in range(1 if porous else 2):
        whole, free = 0.0, 0.0
        for m in range(n):
            f, b, a = fragments[m], behind[3][m], ahead[3][m]
            p_behind, p_ahead, wanted[m] = behind[0][b, P], ahead[0][a, P], 0.0
            if not (p_behind > 0.0 and p_ahead > 0.0):
                continue
            size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
            if not porous:
                p_behind, p_ahead = behind[4][P], ahead[4][P]
            forth = p_behind >= p_ahead
            up, c, inside = (behind[0], b, behind[2][b] < np.inf) if forth else (ahead[0], a, ahead[2][a] < np.inf)
            gamma, rt = up[c, C] ** 2 * up[c, RHO] / up[c, P], up[c, P] / up[c, RHO]
            if not porous:
                low = min(p_behind, p_ahead)
                coming, way = (behind[4], sign / size) if forth else (ahead[4], -sign / size)
                high, rt = _stagnation(coming, gamma, inside, moves, m, rows, f, way)
                high = low + share * (high - low)
                p_behind, p_ahead = (high, low) if forth else (low, high)
            area = effective_area(passages, k, present, 0.0, time, p_behind, p_ahead) * size / total * open_share[m]
            high, low = max(p_behind, p_ahead), min(p_behind, p_ahead)
            flow = dt * area * conductance(plan[k, LAW], high, low, gamma, rt) * (high - low)
            wanted[m] = flow if forth else -flow
            if porous and flow > 0.0:
                relief_behind[b] += _pressure_change(behind, b, flow, rt) / (high - low)
                relief_ahead[a] += _pressure_change(ahead, a, flow, rt) / (high - low)
            whole += flow
            free += present * size / total * open_share[m]
        if not porous and throttling == 0:
            share = _throttled(behind, ahead, rows, fragments, whole / (dt * free)) if whole > 0.0 else 1.0
            if share == 1.0:
                break
    if not porous and whole > 0.0:
        forth = behind[4][P] >= ahead[4][P]
        coming, filled = (behind[4], ahead) if forth else (ahead[4], behind)
        if filled[2][filled[3][0]] < np.inf:
            most = _most_taken(filled, coming, wanted, face, dt, weight)
            for m in range(n):
                wanted[m] *= min(1.0, most / whole)
    for m in range(n):
        if porous:
            wanted[m] /= max(1.0, (relief_behind[behind[3][m]] + relief_ahead[ahead[3][m]]) / LARGEST_RELIEF)
        from_behind[behind[3][m]] += abs(wanted[m])
        from_ahead[ahead[3][m]] += abs(wanted[m])
    for m in range(n):
        if wanted[m] == 0.0:
            continue
        f, b, a = fragments[m], behind[3][m], ahead[3][m]
        most = min(
            1.0, largest * behind[2][b] / from_behind[b], largest * ahead[2][a] / from_ahead[a]
        )  # a side that is filled may not take more than it holds either, or its pressure would overshoot
        mass, forth = abs(wanted[m]) * most, wanted[m] > 0.0
        side, c = (behind, b) if forth else (ahead, a)
        up, still = side[0], side[2][c] == np.inf
        if not porous and not still:
            size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
            side[7][side[6][m]] = mass / (dt * face * size * up[c, RHO])
        energy = mixture_enthalpy(table, up[c, Y:], up[c, T])
        for d in range(3):
            u = moves[m, d] if still else up[c, U + d]  # air comes in at the speed of the fabric
            energy += 0.5 * u * u
            if porous and not still:
                energy -= 0.5 * (u - moves[m, d]) ** 2  # flow along the fabric stays behind as heat
            behind[1][b, species + d] -= wanted[m] * most * u
            ahead[1][a, species + d] += wanted[m] * most * u
        row = 0 if forth else 1
        for s in range(species):
            behind[1][b, s] -= wanted[m] * most * up[c, Y + s]
            ahead[1][a, s] += wanted[m] * most * up[c, Y + s]
            books_out[row, s] += mass * up[c, Y + s]
        behind[1][b, species + 3] -= wanted[m] * most * energy
        ahead[1][a, species + 3] += wanted[m] * most * energy
        books_out[row, species] += mass * energy


@scalar
def lose_heat(table, state, total, cluster, rows, fragments, ambient, conductance, dt, gained):
    """Heat [J] that clusters lose through fragments of the outer fabric in dt [s], taken from `gained`: m cv dT/dt =
    -h A (T - T_ambient), exact. ambient: temperature [K]. conductance: h A [W/K] of all these fragments together."""
    whole, species = 0.0, len(table)
    share = np.zeros(len(state))
    for m in range(len(fragments)):
        f = fragments[m]
        size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
        share[cluster[m]] += size
        whole += size
    lost = 0.0
    for c in range(len(state)):
        if share[c] > 0.0 and state[c, P] > 0.0:
            gamma = state[c, C] ** 2 * state[c, RHO] / state[c, P]
            mass, gas_constant = 0.0, 0.0
            for s in range(species):
                mass += total[c, s]
                gas_constant += total[c, s] * table[s, 0]
            capacity = gas_constant / (gamma - 1.0)
            heat = -capacity * (state[c, T] - ambient) * np.expm1(-dt * conductance * share[c] / whole / capacity)
            gained[c, species + 3] -= heat
            lost += heat
    return lost
