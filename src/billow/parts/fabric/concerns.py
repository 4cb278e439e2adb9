"""What is allowed of a fabric but probably not meant."""

from __future__ import annotations

from collections.abc import Iterator

from billow.base.errors import Concern
from billow.parts.fabric.membrane import Membrane
from billow.parts.part import Setting


def fabric_concerns(membrane: Membrane, setting: Setting) -> Iterator[Concern]:
    """Questions to every law, then those of the law itself."""
    fabric = membrane.fabric
    speed = fabric.wave_speed
    if not 100.0 <= speed <= 4000.0:
        yield Concern(
            "W-FAB-001",
            f"sound travels at {speed:.3g} m/s in this fabric",
            "fabric.young_warp, fabric.young_weft or fabric.curves, fabric.density",
            "woven fabric has 400 to 1,500 m/s: a modulus, a stress or the density is probably in another unit",
            'write units, for example young_warp = "0.4 GPa"',
        )
    areal = fabric.density * fabric.thickness
    if not 0.05 <= areal <= 2.0:
        yield Concern(
            "W-FAB-002",
            f"the fabric weighs {1e3 * areal:.3g} g/m^2",
            "fabric.density, fabric.thickness",
            "airbag fabric weighs 150 to 400 g/m^2",
            'write units, for example thickness = "0.3 mm"',
        )
    yield from fabric.concerns(float(membrane.altitude.min()), setting)
