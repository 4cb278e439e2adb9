"""Gas from inflators: it enters the clusters beside the holes of a mouth, with its momentum."""

from __future__ import annotations

import math

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.lattice_clipping import NORMAL, PLACE
from billow.parts.gas.mesh.thermodynamics import P
from billow.parts.gas.supply.curve import interpolate
from billow.parts.gas.supply.mixture import mixture_enthalpy, mixture_gas_constant
from billow.parts.gas.supply.outflow import jet_speed
from billow.parts.gas.supply.supply import Source

REACH = 1.0
"""Radius [cells] of the patch of mouth that the gas of a hole enters through, at least."""


def blow(
    source: Source, table: np.ndarray, positions: np.ndarray, mouth_velocity: np.ndarray, origin: np.ndarray, h: float,
    rows: np.ndarray, fragments: np.ndarray, cluster: np.ndarray, state: np.ndarray, times: tuple[float, float],
    gained: np.ndarray,
) -> tuple[float, float]:  # fmt: skip
    """Give what a source delivers between two times [s] to clusters, into gained (clusters, species + 4).

    positions: of the nodes [m]. rows, fragments: of the mouth; cluster: of each of these fragments; state: of the
    clusters. Returns energy [J] and thrust times time [N s].

    In the frame of the mouth the gas brings its total enthalpy, of which its kinetic energy is a part. The jets of a
    cone of half-angle b, evenly filled, keep (1 + cos b)/2 of their thrust; the rest of their motion is turbulence.
    """
    inflator, jets = source.inflator, source.jets
    begin, end = times
    mass = inflator.delivered(end) - inflator.delivered(begin)
    if not mass > 0.0:
        return 0.0, 0.0
    middle, fractions = 0.5 * (begin + end), inflator.mass_fractions
    temperature = interpolate(inflator.temperature_time, inflator.temperature, middle)
    enthalpy = mixture_enthalpy(table, fractions, temperature)
    if source.diffuse or not jets.ring.count:
        centres, directions, reach, speed = np.zeros((1, 3)), np.zeros((1, 3)), math.inf, 0.0
    else:
        ring = jets.ring
        holes, frames, _ = jets.nozzles(positions, middle)
        centres, directions = (holes - origin) / h, 0.5 * (1.0 + math.cos(ring.cone)) * frames[:, 0]
        reach = max(0.5 * ring.hole_diameter / h, REACH)
        about = np.unique(cluster)
        pressure = max(float(state[about, P].mean()), 1e-6)
        density = pressure / (mixture_gas_constant(table, fractions) * temperature)
        area = 0.25 * math.pi * ring.hole_diameter**2 * ring.count
        speed = min(jet_speed(table, fractions, temperature), mass / (end - begin) / (density * area))
    energy = _give(
        centres, np.ascontiguousarray(directions), reach, rows, fragments, cluster, mass / len(centres), fractions,
        enthalpy, speed, mouth_velocity, gained,
    )  # fmt: skip
    return energy, mass * speed * float(np.linalg.norm(directions, axis=1).mean())


@scalar
def _give(
    centres, directions, reach, rows, fragments, cluster, mass, fractions, enthalpy, speed, frame, gained
):  # fmt: skip
    """mass: of each hole [kg]; frame: velocity of the mouth [m/s]. Returns the energy [J]."""
    species, n = len(fractions), len(fragments)
    weight, whole_energy = np.empty(n), 0.0
    for hole in range(len(centres)):
        limit, total = reach * reach, 0.0
        nearest = np.inf
        for m in range(n):
            f = fragments[m]
            distance = 0.0
            for d in range(3):
                distance += (rows[f, PLACE + d] - centres[hole, d]) ** 2
            nearest = min(nearest, distance)
        if nearest >= 0.9 * limit:  # a hole beside the mouth blows through the rim
            limit = nearest + limit
        for m in range(n):
            f = fragments[m]
            distance = 0.0
            for d in range(3):
                distance += (rows[f, PLACE + d] - centres[hole, d]) ** 2
            size = np.sqrt(rows[f, NORMAL] ** 2 + rows[f, NORMAL + 1] ** 2 + rows[f, NORMAL + 2] ** 2)
            weight[m] = size * max(1.0 - distance / limit, 0.0) if limit < np.inf else size
            total += weight[m]
        energy, pushes = enthalpy, np.empty(3)
        for d in range(3):
            u = speed * directions[hole, d]
            energy += u * frame[d] + 0.5 * frame[d] * frame[d]
            pushes[d] = u + frame[d]
        for m in range(n):
            if weight[m] > 0.0:
                c, share = cluster[m], mass * weight[m] / total
                for s in range(species):
                    gained[c, s] += share * fractions[s]
                for d in range(3):
                    gained[c, species + d] += share * pushes[d]
                gained[c, species + 3] += share * energy
        whole_energy += mass * energy
    return whole_energy
