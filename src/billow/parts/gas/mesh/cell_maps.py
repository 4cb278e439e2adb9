"""The cells of a surface before and after a step as one list, and what each of them is in either."""

from __future__ import annotations

import numpy as np
from numba import prange

from billow.base.compiled import kernel, scalar
from billow.geometry.lattice_clipping import cell_of


@scalar
def _look_up(outer, inner, out):
    for i in range(len(outer)):
        out[i] = inner[outer[i]] if outer[i] >= 0 else -1


def through(outer: np.ndarray, inner: np.ndarray) -> np.ndarray:
    """inner[outer], -1 where outer is."""
    out = np.empty(len(outer), np.int32)
    _look_up(outer, inner, out)
    return out


@kernel
def spread(n, at, held, temperature, sound, held_out, temperature_out, sound_out):
    """What n cells hold, by their numbers `at` among those that hold gas, or -1."""
    for i in prange(n):
        for k in range(held.shape[1]):
            held_out[i, k] = held[at[i], k] if at[i] >= 0 else 0.0
        temperature_out[i] = temperature[at[i]] if at[i] >= 0 else 0.0
        sound_out[i] = sound[at[i]] if at[i] >= 0 else 0.0


@kernel
def find_pace(n, held, sound, pace_out):
    """|u_d| + c [m/s] of n cells that hold this, with this speed of sound [m/s]: (n, 3)."""
    species = held.shape[1] - 4
    for i in prange(n):
        m = 0.0
        for s in range(species):
            m += held[i, s]
        for d in range(3):
            pace_out[i, d] = abs(held[i, species + d] / m) + sound[i] if m != 0.0 else 0.0


@kernel
def geometry(n, key, in_old, in_new, old_volume, new_volume, old_centroid, new_centroid, volume_out, centroid_out):
    """Volumes at both ends, (2, n), and centroids: the new one, of a dying cell the old one."""
    for i in prange(n):
        a, b = in_old[i], in_new[i]
        volume_out[0, i] = old_volume[a] if a >= 0 else 0.0
        volume_out[1, i] = new_volume[b] if b >= 0 else 0.0
        for d in range(3):
            if b >= 0 and (new_volume[b] != 0.0 or a < 0):
                centroid_out[i, d] = new_centroid[b, d]
            else:
                centroid_out[i, d] = old_centroid[a, d] if a >= 0 else cell_of(key[i])[d] + 0.5


@kernel
def blend(n, beside, in_old, in_new, old, new, whole, begin, end, volume_out, aperture_out):
    """Volumes at the start and the end of a part, and the mean apertures; faces that lead nowhere are closed."""
    for i in prange(n):
        a, b = in_old[i], in_new[i]
        first, last = whole[0, i], whole[1, i]
        volume_out[0, i] = first if begin == 0.0 else (1.0 - begin) * first + begin * last
        volume_out[1, i] = last if end == 1.0 else (1.0 - end) * first + end * last
        middle = 0.5 * (begin + end)
        for d in range(3):
            aperture_out[i, d] = 0.0
            if beside[i, 2 * d + 1] >= 0:
                was = old[a, d] if a >= 0 else 0.0
                will = new[b, d] if b >= 0 else 0.0
                aperture_out[i, d] = (1.0 - middle) * was + middle * will
