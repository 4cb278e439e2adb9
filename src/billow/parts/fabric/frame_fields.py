"""What frames show of the fabric: stretch, strain along the yarns, and stress, whatever its law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from billow.geometry.surface import area_vectors
from billow.parts.fabric.membrane import Membrane

BITS = 11
"""Significant bits that are kept: what nobody can see would make frames a fifth larger."""
COLLAPSED = 1e-6
"""Area over that of the flat cut below which a triangle has no true stress."""


def fabric_fields(
    membranes: Sequence[Membrane],
    histories: Sequence[np.ndarray],
    triangles: np.ndarray,
    positions: np.ndarray,
    velocities: np.ndarray,
) -> dict[str, np.ndarray]:
    """Fields on all triangles, (triangles,) each, of membranes at positions [m] and velocities [m/s], (nodes, 3).

    stretch: largest principal stretch [-]. strain_warp, strain_weft: Green strain along the yarns [-]. stress: largest
    principal true stress [Pa] of the law, without damping, over the thickness of the flat cut. Triangles without fabric
    have stretch 1 and nothing else. All are rounded to `BITS`. histories: as of `FabricState`; they stay as they are.
    """
    count = len(triangles)
    fields = {"stretch": np.ones(count)}
    fields |= {name: np.zeros(count) for name in ("strain_warp", "strain_weft", "stress")}
    area = np.linalg.norm(area_vectors(triangles, positions), axis=1)
    for membrane, history in zip(membranes, histories, strict=True):
        where = membrane.elements
        along_warp, along_weft, _ = replace(membrane, reference_inverse=membrane.yarn_inverse).cauchy_green(
            triangles, positions
        )
        fields["strain_warp"][where] = 0.5 * (along_warp - 1.0)
        fields["strain_weft"][where] = 0.5 * (along_weft - 1.0)
        fields["stretch"][where] = membrane.stretch(triangles, positions)
        virial = _virial(membrane, history, triangles, positions, velocities)
        d11, d12, d21, d22 = membrane.reference_inverse
        thickness = membrane.volume * 2.0 * np.abs(d11 * d22 - d12 * d21)
        flat = membrane.volume / thickness
        sound = area[where] > COLLAPSED * flat
        over = np.where(sound, area[where], 1.0) * thickness
        fields["stress"][where] = np.where(sound, _largest(virial) / over, 0.0)
    return {name: rounded(values) for name, values in fields.items()}


def rounded(values: np.ndarray) -> np.ndarray:
    """Values with `BITS` significant bits, so that they can be packed well; off by at most 2^-BITS of themselves."""
    fraction, exponent = np.frexp(values)
    return np.ldexp(np.round(np.ldexp(fraction, BITS)), exponent - BITS)


def _largest(tensors: np.ndarray) -> np.ndarray:
    """Largest eigenvalue (n,) of symmetric tensors (n, 3, 3). One is zero, along the normal of the triangle; the others
    follow from their sum and the sum of their squares."""
    half = 0.5 * np.einsum("nii->n", tensors)
    squares = np.einsum("nij,nij->n", tensors, tensors)
    return np.maximum(half + np.sqrt(np.maximum(0.5 * squares - half**2, 0.0)), 0.0)


def _virial(membrane, history, triangles, positions, velocities) -> np.ndarray:
    """Volume times stress tensor of each element [J], (n, 3, 3): minus the sum of its corner forces times their places,
    which needs no other knowledge of the law."""
    elastic = replace(membrane, viscosity=np.zeros_like(membrane.viscosity))
    forces, _ = elastic.by_itself(triangles, positions, velocities, history)
    places = positions[triangles[membrane.elements]]
    tensor = -np.einsum("nki,nkj->nij", forces, places - places[:, :1])
    return 0.5 * (tensor + tensor.transpose(0, 2, 1))
