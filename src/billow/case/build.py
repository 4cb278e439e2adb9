"""From a `Case` to a `Model`: the only place where what users wrote meets what kernels need."""

from __future__ import annotations

import numpy as np

from billow.case import schema
from billow.case.bag.bags import Bag
from billow.case.bag.build_bag import build_shape
from billow.case.bag.build_straps import build_straps
from billow.case.bag.schema_mesh_bag import MeshBag
from billow.case.fabric.build_fabric import build_fabric
from billow.case.gas.build_gas import build_gas
from billow.case.gas.models import GAS_MODELS
from billow.case.obstacles.obstacles import build_body
from billow.geometry.bag_shapes import BagShape
from billow.geometry.flat_cut import flat_area
from billow.geometry.surface import check_closed, nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.fabric.birth import Birth
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.self_contact import SelfContact
from billow.parts.straps import Straps
from billow.solver.model import Model
from billow.solver.run import Schedule


def build_model(case: schema.Case) -> Model:
    """The model of a case.

    Raises InputError: E-GEO-001..012 geometry, E-GAS-001 unknown species.
    """
    shape = build_shape(case.bag)
    check_closed(shape.surface, shape.positions, "bag")
    law = build_fabric(case.fabric)
    cloth = fabric_triangles(shape)
    membrane = Membrane.build(law, cloth, shape.reference[cloth], law.thickness * shape.layers[cloth])
    straps = build_straps(shape, law)
    area = flat_area(shape.reference)
    mass = nodal_mass(shape, membrane, straps)
    contact_area = nodal_share(shape.surface.triangles[cloth], area[cloth], shape.surface.node_count)
    gravity = np.array(case.run.gravity)
    return Model(
        surface=shape.surface,
        start=np.ascontiguousarray(shape.positions),
        mass=mass,
        fixed=shape.fixed,
        gravity=gravity,
        gas=build_gas(case, shape),
        fabric=Fabric(shape.surface, (membrane,), build_birth(case.bag, membrane, shape)),
        straps=straps,
        bodies=Bodies(tuple(build_body(obstacle) for obstacle in case.obstacles), contact_area, gravity),
        self_contact=build_self_contact(case, membrane, shape, mass),
    )


def build_birth(bag: Bag, membrane: Membrane, shape: BagShape) -> Birth | None:
    """The ramp from the start shape to the flat cut, if the case wants one."""
    if not isinstance(bag, MeshBag) or not bag.birth_time:
        return None
    return Birth.of(bag.birth_time, (membrane,), shape.surface.triangles, shape.positions)


def build_self_contact(case: schema.Case, membrane: Membrane, shape: BagShape, mass: np.ndarray) -> SelfContact | None:
    """Contact of fabric with fabric, if the case wants it: as it says, else where a local gas needs it."""
    wanted = case.fabric.self_contact
    if wanted == "auto":
        wanted = GAS_MODELS[case.gas.model].is_local
    return SelfContact.build(shape.surface, shape.positions, mass, membrane.stable_dt()) if wanted else None


def build_schedule(run: schema.Run) -> Schedule:
    return Schedule(run.end_time, run.frames, run.histories_per_frame, run.dt_scale)


def fabric_triangles(shape: BagShape) -> np.ndarray:
    """Triangles (n,) int64 made of fabric: all but vents, which are holes, and the mouth, which is the inflator."""
    return shape.surface.triangles_of_kind("fabric")


def nodal_mass(shape: BagShape, membrane: Membrane, straps: Straps) -> np.ndarray:
    """Lumped mass [kg], (nodes,): a third of each element, half of each strap bar."""
    surface = shape.surface
    mass = nodal_share(surface.triangles[membrane.elements].astype(np.int64), membrane.mass, surface.node_count)
    return mass + np.bincount(straps.bars.ravel(), np.repeat(0.5 * straps.mass, 2), surface.node_count)
