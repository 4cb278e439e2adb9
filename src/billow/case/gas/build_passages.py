"""From `[bag.vents]`, `[leakage]` and `[gas.orifices]` to the passages that gas leaves by; the same for all gases."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

import numpy as np

from billow.base.errors import InputError
from billow.case import schema
from billow.case.bag.schema_bag import VentFlow
from billow.case.gas.schema_gas import Orifice, PartLeakage
from billow.geometry.bag_shapes import BagShape
from billow.geometry.chambers import OUTSIDE
from billow.geometry.flat_cut import flat_area
from billow.parts.gas.supply.curve import Curve
from billow.parts.gas.supply.outflow import GRAEFE, ORIFICE, PERMEABILITY, POROUS_MEDIUM, VELOCITY
from billow.parts.gas.supply.passages import (
    ABSOLUTE,
    DIFFERENCE,
    FABRIC,
    FLAT_AREA,
    OPENING,
    PRESENT_AREA,
    VENT,
    Passage,
    Passages,
)

NO_SUCH_CHAMBER = InputError.declare(
    "E-GAS-002",
    "the bag has no chamber {name!r}",
    why="its chambers are: {chambers}",
    cause="a misspelt name, or a bag with fewer chambers",
    remedy="use one of these names, or give the bag more chambers",
)
NO_SUCH_FABRIC = InputError.declare(
    "E-GAS-003",
    "the bag has no fabric part {part!r}",
    where="leakage.parts.{part}",
    why="only fabric leaks; vents, mouths and openings are holes",
    cause="a misspelt part, or a vent",
    remedy="use one of {known}",
)
ONE_CHAMBER_TWICE = InputError.declare(
    "E-GAS-005",
    "the opening {part!r} joins chamber {chamber} with itself",
    where="bag, part {part}",
    why="gas can only flow between two chambers",
    cause="the chambers on its two sides were given the same name",
    remedy="give its two sides different chambers, or leave the opening out",
)

LAWS = {
    "permeability": PERMEABILITY,
    "wang-nefske": ORIFICE,
    "graefe": GRAEFE,
    "porous-medium": POROUS_MEDIUM,
    "velocity-curve": VELOCITY,
}
AREAS = {"reference": FLAT_AREA, "deformed": PRESENT_AREA}
SURROUNDINGS = "ambient"


def build_passages(case: schema.Case, shape: BagShape) -> Passages:
    """All passages of a case, in the order of the bag's parts, orifices last.

    Raises InputError E-GAS-002 (no such chamber), E-GAS-003 (no such part of fabric), E-GAS-005 (an opening that joins
    a chamber with itself).
    """
    surface = shape.surface
    fabric = [name for name, kind in zip(surface.part_names, surface.part_kinds, strict=True) if kind == "fabric"]
    for part in case.leakage.parts:
        if part not in fabric:
            raise NO_SUCH_FABRIC(part=part, known=", ".join(fabric))
    return Passages((*_parts(case, shape), *(_orifice(o, shape) for o in case.gas.orifices)))


def chamber_of(name: str, shape: BagShape, where: str) -> int:
    """Index of a chamber by name. Raises InputError E-GAS-002."""
    names = shape.surface.chambers.names
    if name not in names:
        raise NO_SUCH_CHAMBER(where=where, name=name, chambers=", ".join(names))
    return names.index(name)


def _parts(case: schema.Case, shape: BagShape) -> Iterator[Passage]:
    """One passage for every vent, opening and piece of fabric between the same two chambers."""
    surface, chambers = shape.surface, shape.surface.chambers
    flat = flat_area(shape.reference)
    for part, kind in zip(surface.part_names, surface.part_kinds, strict=True):
        if kind == "mouth":
            continue
        triangles = surface.triangles_of(part)
        sides = np.column_stack([chambers.behind[triangles], chambers.ahead[triangles]])
        for behind, ahead in np.unique(sides, axis=0).tolist():
            inside = (sides == (behind, ahead)).all(axis=1)
            members, ends = triangles[inside], (chambers.names[end] for end in (behind, ahead) if end != OUTSIDE)
            name = part if inside.all() else "_".join((part, *ends))
            area = float(flat[members].sum())
            if behind == ahead == OUTSIDE and kind == "fabric":
                continue  # a cover
            if kind == "fabric":
                leaks = shape.leak[members]
                law = case.leakage.parts.get(part, case.leakage)
                permeability = case.fabric.of(part).permeability
                leaky, area = members[leaks > 0.0], float(leaks @ flat[members])
                yield _leakage(law, permeability, name, behind, ahead, leaky, area)
            elif kind == "vent":
                yield _vent(case.bag.vents, name, behind, ahead, members, area)
            elif behind == ahead:
                raise ONE_CHAMBER_TWICE(part=part, chamber=chambers.names[behind])
            else:
                yield Passage(
                    name, OPENING, ORIFICE, behind, ahead, members, area,
                    coefficient=case.gas.opening_discharge, area_terms=PRESENT_AREA,
                )  # fmt: skip


def _vent(vents: VentFlow, name: str, behind: int, ahead: int, triangles: np.ndarray, area: float) -> Passage:
    return Passage(
        name, VENT, ORIFICE, behind, ahead, triangles, area,
        **_factors(vents.discharge, vents.area_factor),
        pressure_read=DIFFERENCE,
        area_terms=PRESENT_AREA,
        through_blocked=vents.through_blocked if vents.blockage else 1.0,
        opens_at=np.inf if vents.burst_time and not vents.opening_pressure else vents.opening_pressure,
        bursts_at=vents.burst_time or np.inf,
    )  # fmt: skip


def _leakage(
    leakage: PartLeakage, permeability: float, name: str, behind: int, ahead: int, triangles: np.ndarray, area: float
) -> Passage:
    of_fabric = (permeability,) if leakage.law == "permeability" else ()
    return Passage(
        name, FABRIC, LAWS[leakage.law], behind, ahead, triangles, area,
        **_factors(leakage.time_factor, leakage.pressure_factor, *of_fabric),
        pressure_read=ABSOLUTE,
        area_terms=AREAS[leakage.area] if isinstance(leakage.area, str) else leakage.area,
        through_blocked=leakage.through_blocked if leakage.blockage else 1.0,
    )  # fmt: skip


def _orifice(orifice: Orifice, shape: BagShape) -> Passage:
    ends = [
        OUTSIDE if end == SURROUNDINGS else chamber_of(end, shape, f"gas.orifices, orifice {orifice.name}")
        for end in orifice.between
    ]
    return Passage(
        orifice.name, VENT if OUTSIDE in ends else OPENING, ORIFICE, *sorted(ends, key=lambda end: end == OUTSIDE),
        area=orifice.area, **_factors(orifice.discharge),
    )  # fmt: skip


def _factors(*factors: Any) -> dict[str, Any]:
    """Numbers, curves against time, and at most one against pressure, as a passage keeps them."""
    curves = {
        axis: tuple(Curve(np.array(getattr(f, axis)), np.array(f.value)) for f in factors if hasattr(f, axis))
        for axis in ("time", "pressure", "gauge_pressure")
    }
    return {
        "coefficient": math.prod((f for f in factors if isinstance(f, float)), start=1.0),
        "over_time": curves["time"],
        "over_pressure": next(iter(curves["pressure"] + curves["gauge_pressure"]), None),
    }
