"""The gas models that a case chooses among with `gas.model`; a new one is an entry of GAS_MODELS.

A builder imports its model itself, so that a run loads the kernels of its own gas and of no other.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from billow.base.errors import InputError
from billow.geometry.bag_shapes import BagShape
from billow.geometry.flat_cut import flat_area
from billow.parts.gas.gas_model import Bag, GasModel
from billow.parts.gas.no_gas import NoGas
from billow.parts.gas.supply.supply import Supply

NO_MOUTH = InputError.declare(
    "E-GAS-006",
    "inflator {inflator} has jets, and chamber {chamber} has no mouth",
    where="inflator {inflator}, jets",
    why="jets and local gas enter the bag through a mouth",
    remedy="name a chamber with a mouth in inflator.chamber; with uniform pressure, set inflator.jets.count = 0",
)
NOT_IN_MESH = InputError.declare(
    "E-GAS-007",
    "gas that flows from place to place cannot pass {orifice}",
    where="gas.orifices",
    why="an orifice without geometry has no place in the mesh",
    cause="a case that was written for uniform pressure",
    remedy='remove it, draw it into the mesh as an opening, or set gas.model = "uniform-pressure"',
)


def _uniform_pressure(case, shape: BagShape, supply: Supply) -> GasModel:
    from billow.parts.gas.uniform.uniform_pressure import UniformPressure

    return UniformPressure(supply)


def _require_geometry(supply: Supply) -> None:
    """Raises InputError E-GAS-006 if a source has no mouth, E-GAS-007 if a passage has no triangles."""
    for source in supply.sources:
        if source.jets is None:
            inflator = source.inflator
            raise NO_MOUTH(inflator=inflator.name, chamber=supply.chambers.names[inflator.chamber])
    for row in supply.passages.rows:
        if not len(row.triangles):
            raise NOT_IN_MESH(orifice=row.name)


def _corpuscular(case, shape: BagShape, supply: Supply) -> GasModel:
    """Raises as `_require_geometry`."""
    from billow.parts.gas.corpuscular.corpuscular import Corpuscular

    _require_geometry(supply)
    return Corpuscular(supply, shape.surface, shape.reference, case.gas.particles, case.gas.seed)


TILE = 3.0
"""Length of a strip of a roll, or of a tile of a bag that was folded elsewhere [cells]."""


def _mesh(case, shape: BagShape, supply: Supply) -> GasModel:
    """Raises as `_require_geometry`, and for a mesh as `MeshGas.start`."""
    from billow.case.bag.build_bag import build_shape, fold_plan
    from billow.case.bag.schema_mesh import MeshBag
    from billow.geometry.folding.strips import find_strips, find_tiles
    from billow.parts.gas.mesh.concerns import MANY, crowded
    from billow.parts.gas.mesh.mesh_gas import MeshGas

    _require_geometry(supply)
    area, plan, tile, strips = float(flat_area(shape.reference).sum()), fold_plan(case.bag), TILE * case.gas.cell, None
    gas = MeshGas(
        supply, shape.surface, area, case.gas.cell, case.gas.advection, case.gas.flow_limit, None,
        case.gas.film_friction,
    )  # fmt: skip
    if supply.chambers.count > 1:
        return gas
    if plan is not None:
        strips = find_strips(plan, build_shape(case.bag), tile)
    elif isinstance(case.bag, MeshBag):  # which may have been folded elsewhere
        bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
        strips = find_tiles(shape, tile) if crowded(gas.cut(gas.start(bag))) > MANY else None
    return replace(gas, strips=strips)


class Kind(NamedTuple):
    """build: the model from a case, the bag's shape, and its supply. is_local: whether the gas differs from place to
    place; layers of fabric are then kept apart by default, and `gas.switch_time` applies. has_supply: whether there is
    gas at all."""

    build: Callable[..., GasModel]
    is_local: bool = False
    has_supply: bool = True


GAS_MODELS = {
    "uniform-pressure": Kind(_uniform_pressure),
    "corpuscular": Kind(_corpuscular, is_local=True),
    "mesh": Kind(_mesh, is_local=True),
    "none": Kind(lambda case, shape, supply: NoGas(case.ambient.pressure, case.ambient.temperature), has_supply=False),
}
"""Name in a case -> how it is built."""
