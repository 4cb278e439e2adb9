"""Is every particle in its chamber? Counted anew, independent of flight, on the walls as they stand.

Who is not is put where its nearest fellow is: there is room for gas, which beside the nearest wall, in a fold, there
may not be.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from billow.parts.gas.corpuscular.depth import depths
from billow.parts.gas.corpuscular.flight import UNCOUNTED, Flock


def audit(
    flock: Flock, triangles: np.ndarray, positions: np.ndarray, behind: np.ndarray, ahead: np.ndarray
) -> np.ndarray:
    """Renew `flock.overlap`; indices (n,) int64 of particles that are not in the chamber they believe to be in.

    positions: [m], (nodes, 3), where the particles' step ended. triangles, behind, ahead: as `depths` takes them.
    """
    return _count(flock, np.arange(len(flock.chamber)), triangles, positions, behind, ahead)


def house_parked(
    flock: Flock, triangles: np.ndarray, positions: np.ndarray, behind: np.ndarray, ahead: np.ndarray
) -> None:
    """Count those anew that flight has put beside a wall; where fabric has come over that place, they go elsewhere."""
    bring_back(flock, _count(flock, np.flatnonzero(flock.overlap == UNCOUNTED), triangles, positions, behind, ahead))


def _count(flock, who, triangles, positions, behind, ahead):
    depth = depths(flock.position[who], flock.chamber[who], triangles, positions, behind, ahead)
    flock.overlap[who] = np.maximum(depth, 1) - 1
    return who[(depth < 1) & (flock.chamber[who] >= 0)]


def bring_back(flock: Flock, escaped: np.ndarray) -> None:
    """Put escaped particles where the nearest particle of their chamber is; velocity, hence energy, stays.

    Where a whole chamber has escaped, nobody moves.
    """
    inside = np.ones(len(flock.chamber), np.bool_)
    inside[escaped] = False
    for chamber in np.unique(flock.chamber[escaped]):
        lost = escaped[flock.chamber[escaped] == chamber]
        fellows = np.flatnonzero(inside & (flock.chamber == chamber))
        if len(fellows):
            nearest = fellows[cKDTree(flock.position[fellows]).query(flock.position[lost])[1]]
            flock.position[lost], flock.overlap[lost] = flock.position[nearest], flock.overlap[nearest]
