"""Straps: from what a case says of their cloth to bars between nodes, and on to bars of fabric."""

from __future__ import annotations

import numpy as np

from billow.case.bag.schema_bag import StrapCloth
from billow.geometry.bag_shapes import BagShape, StrapLine
from billow.parts.fabric.membrane import FabricLaw
from billow.parts.straps import NO_STRAPS, Straps


def strap_line(cloth: StrapCloth, bars: np.ndarray, positions: np.ndarray) -> StrapLine:
    """A strap of bars (n, 2) between nodes, which share its width; positions: start shape, [m], (nodes, 3)."""
    apart = np.linalg.norm(positions[bars[:, 1]] - positions[bars[:, 0]], axis=1)
    length = apart if cloth.length == "start" else np.full(len(bars), cloth.length)
    return StrapLine(
        bars=bars,
        width=cloth.width / len(bars),
        length=length + cloth.slack,
        stiffness=cloth.stiffness or None,
        failure=cloth.failure or np.inf,
    )


def build_straps(shape: BagShape, fabric: FabricLaw) -> Straps:
    """Bars of the bag's own fabric, warp along the strap, unless a strap has a stiffness of its own.

    The bars of a strap share its stiffness and its failure tension evenly.
    """
    if not shape.straps:
        return NO_STRAPS
    counts = [len(line.bars) for line in shape.straps]
    width = np.repeat([line.width for line in shape.straps], counts)
    length = np.concatenate([line.length for line in shape.straps])
    section = fabric.thickness * width
    own = np.repeat(
        [np.nan if line.stiffness is None else line.stiffness / len(line.bars) for line in shape.straps], counts
    )
    stiffness = np.where(np.isnan(own), fabric.warp_modulus * section, own)
    mass = fabric.density * section * length
    return Straps(
        bars=np.concatenate([line.bars for line in shape.straps]).astype(np.int64),
        length=length,
        stiffness=stiffness,
        # Of a bar's mass and stiffness: xi rho c l A = xi sqrt(EA m l), as in a membrane.
        viscosity=fabric.damping * np.sqrt(stiffness * mass * length),
        mass=mass,
        strap=np.repeat(np.arange(len(counts)), counts),
        failure=np.repeat([line.failure / len(line.bars) for line in shape.straps], counts),
    )
