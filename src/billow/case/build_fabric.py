"""From the `[fabric]` table to a fabric, and to the straps cut from it."""

from __future__ import annotations

import numpy as np

from billow.case import schema_fabric
from billow.fabric.linear_law import LinearFabric
from billow.fabric.straps import NO_STRAPS, Straps
from billow.geometry.bag_shapes import BagShape


def build_fabric(fabric: schema_fabric.Fabric) -> LinearFabric:
    return LinearFabric(
        density=fabric.density,
        thickness=fabric.thickness,
        young_warp=fabric.young_warp,
        young_weft=fabric.young_weft,
        poisson=fabric.poisson,
        shear=fabric.shear,
        compression=fabric.compression,
        damping=fabric.damping,
    )


def build_straps(shape: BagShape, fabric: LinearFabric) -> Straps:
    """Bars of the bag's own fabric, warp along the strap."""
    if not shape.straps:
        return NO_STRAPS
    counts = [len(line.bars) for line in shape.straps]
    width = np.repeat([line.width for line in shape.straps], counts)
    length = np.repeat([line.length for line in shape.straps], counts)
    section = fabric.thickness * width
    wave_speed = np.sqrt(fabric.young_warp / fabric.density)
    return Straps(
        bars=np.concatenate([line.bars for line in shape.straps]).astype(np.int64),
        length=length,
        stiffness=fabric.young_warp * section,
        viscosity=fabric.damping * fabric.density * wave_speed * length * section,
        mass=fabric.density * section * length,
        strap=np.repeat(np.arange(len(counts)), counts),
    )
