"""The impulses of particles on the fabric, held per corner until the fabric takes them, and the local pressure
(docs/theory.md, Smoothing of wall pressure)."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import prange

from billow.base.compiled import CHUNK, kernel, team

HITS_PER_CHUNK = 512
"""Hits that one chunk of CHUNK particles can hold before they are collected; at least one particle's MOST_HITS."""

HIT_NUMBERS = 7
"""Numbers of a hit: impulse on the wall x, y, z [N s]; weights of corners 0 and 1; incident 2 m u [N s]; mass [kg]."""


class Hits(NamedTuple):
    """Hits of one pass of the flight kernel, per chunk of particles, in the order of the particles.

    count: (chunks,) int64. triangle: (chunks, HITS_PER_CHUNK) int32, t if struck from behind, ~t if from ahead.
    numbers: (chunks, HITS_PER_CHUNK, HIT_NUMBERS).
    """

    count: np.ndarray
    triangle: np.ndarray
    numbers: np.ndarray

    @classmethod
    def empty(cls, particles: int) -> Hits:
        """Room for the hits of this many particles."""
        chunks = -(-particles // CHUNK)
        return cls(
            np.zeros(chunks, dtype=np.int64),
            np.empty((chunks, HITS_PER_CHUNK), dtype=np.int32),
            np.empty((chunks, HITS_PER_CHUNK, HIT_NUMBERS)),
        )


@dataclass
class ImpactBank:
    """Impulses not yet passed on to the fabric, and what strikes each side of each triangle.

    held: [N s], (triangles, 3, 3), impulse at each corner. struck: (triangles, 2, 2), since the last `smooth`: side (0
    behind, 1 ahead) by incident impulse 2 m u [N s] and mass [kg]. pressure: [Pa], (triangles, 2), absolute pressure of
    the gas on either side. mass_flux: [kg/m^2/s], (triangles, 2), incident.
    """

    held: np.ndarray
    struck: np.ndarray
    pressure: np.ndarray
    mass_flux: np.ndarray

    @classmethod
    def empty(cls, triangles: int) -> ImpactBank:
        """Nothing held, nothing struck."""
        return cls(
            np.zeros((triangles, 3, 3)), np.zeros((triangles, 2, 2)), np.zeros((triangles, 2)), np.zeros((triangles, 2))
        )

    def collect(self, hits: Hits) -> None:
        """Take all hits; each triangle adds its own, in the order of the particles."""
        n = int(hits.count.sum())
        _collect(n, team(n), hits.count, hits.triangle, hits.numbers, self.held, self.struck)
        hits.count[:] = 0

    def smooth(self, area: np.ndarray, dt: float, time_constant: float) -> None:
        """Add what struck in the last gas step dt [s] to the running means of pressure and mass flux.

        area: [m^2], (triangles,). time_constant: of the exponential mean [s].
        """
        _smooth(len(area), area, dt, -math.expm1(-dt / time_constant), self.struck, self.pressure, self.mass_flux)


@kernel
def _collect(n, parts, count, triangle, numbers, held, struck):
    """n: hits, which decide whether it runs in parallel; each part takes those of its own triangles."""
    chunks, triangles = len(count), len(held)
    for part in prange(parts):
        begin, end = part * triangles // parts, (part + 1) * triangles // parts
        for chunk in range(chunks):
            for h in range(count[chunk]):
                t, side = triangle[chunk, h], 0
                if t < 0:
                    t, side = ~t, 1
                if t < begin or t >= end:
                    continue
                for axis in range(3):
                    impulse = numbers[chunk, h, axis]
                    first, second = numbers[chunk, h, 3] * impulse, numbers[chunk, h, 4] * impulse
                    held[t, 0, axis] += first
                    held[t, 1, axis] += second
                    held[t, 2, axis] += impulse - first - second  # the rest, so that the three add up to the impulse
                struck[t, side, 0] += numbers[chunk, h, 5]
                struck[t, side, 1] += numbers[chunk, h, 6]


@kernel
def _smooth(n, area, dt, part, struck, pressure, mass_flux):
    for i in prange(n):
        for side in range(2):
            if area[i] > 0.0:
                pressure[i, side] += part * (struck[i, side, 0] / (area[i] * dt) - pressure[i, side])
                mass_flux[i, side] += part * (struck[i, side, 1] / (area[i] * dt) - mass_flux[i, side])
            struck[i, side, 0] = 0.0
            struck[i, side, 1] = 0.0
