"""What is allowed of a fabric but probably not meant."""

from __future__ import annotations

import math
from collections.abc import Iterator

from billow.base.errors import Concern
from billow.parts.fabric.membrane import Membrane
from billow.parts.part import Setting

ODD_SPEED = Concern.declare(
    "W-FAB-001",
    "sound travels at {speed:.3g} m/s along the warp",
    where="fabric.young_warp or fabric.curves.warp, fabric.density",
    why="woven fabric has 400 to 1,500 m/s: a modulus, a stress or the density is probably in another unit",
    remedy='write units, for example young_warp = "0.4 GPa"',
)
ODD_WEIGHT = Concern.declare(
    "W-FAB-002",
    "the fabric weighs {weight:.3g} g/m^2",
    where="fabric.density, fabric.thickness",
    why="airbag fabric weighs 150 to 400 g/m^2",
    cause="density or thickness in another unit",
    remedy='write units, for example thickness = "0.3 mm"',
)


def fabric_concerns(membrane: Membrane, setting: Setting) -> Iterator[Concern]:
    """Concerns of every fabric, then those of its own law."""
    fabric = membrane.fabric
    speed = math.sqrt(fabric.warp_modulus / fabric.density)
    if not 100.0 <= speed <= 4000.0:
        yield ODD_SPEED(speed=speed)
    areal = fabric.density * fabric.thickness
    if not 0.05 <= areal <= 2.0:
        yield ODD_WEIGHT(weight=1e3 * areal)
    yield from fabric.concerns(float(membrane.altitude.min()), setting)
