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
from billow.case.obstacles.build_obstacle import build_obstacle
from billow.geometry.bag_shapes import BagShape
from billow.geometry.surface import area_vectors, check_closed, nodal_share
from billow.parts.fabric.birth import Birth
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
    fabric = build_fabric(case.fabric)
    cloth = fabric_triangles(shape)
    membrane = Membrane.build(fabric, cloth, shape.reference[cloth], fabric.thickness * shape.layers[cloth])
    straps = build_straps(shape, fabric)
    area = flat_area(shape.reference)
    mass = nodal_mass(shape, membrane, straps)
    return Model(
        surface=shape.surface,
        start=np.ascontiguousarray(shape.positions),
        membranes=(membrane,),
        straps=straps,
        gas=build_gas(case, shape),
        obstacles=tuple(build_obstacle(o) for o in case.obstacles),
        mass=mass,
        contact_area=nodal_share(shape.surface.triangles[cloth], area[cloth], shape.surface.node_count),
        fixed=shape.fixed,
        gravity=np.array(case.run.gravity),
        birth=build_birth(case.bag, membrane, shape),
        self_contact=build_self_contact(case, membrane, shape, mass),
    )


def build_birth(bag: Bag, membrane: Membrane, shape: BagShape) -> Birth | None:
    """The ramp from the start shape to the flat cut, if the case wants one."""
    if not isinstance(bag, MeshBag) or not bag.birth_time:
        return None
    return Birth.of(bag.birth_time, (membrane,), shape.surface.triangles, shape.positions)


def build_self_contact(case: schema.Case, membrane: Membrane, shape: BagShape, mass: np.ndarray) -> SelfContact | None:
    """Contact of fabric with fabric, if the case wants it: as it says, else where particles need it."""
    wanted = case.fabric.self_contact
    if wanted == "auto":
        wanted = case.gas.model == "corpuscular"
    return SelfContact.build(shape.surface, shape.positions, mass, membrane.stable_dt()) if wanted else None


def build_schedule(run: schema.Run) -> Schedule:
    return Schedule(run.end_time, run.frames, run.histories_per_frame, run.dt_scale)


def fabric_triangles(shape: BagShape) -> np.ndarray:
    """Triangles (n,) int64 made of fabric: all but vents, which are holes, and the mouth, which is the inflator."""
    return shape.surface.triangles_of_kind("fabric")


def flat_area(reference: np.ndarray) -> np.ndarray:
    """Flat area [m^2], (triangles,), of reference corners [m], (triangles, 3, 2)."""
    flat = np.concatenate([reference, np.zeros((*reference.shape[:2], 1))], axis=2).reshape(-1, 3)
    corners = np.arange(len(flat)).reshape(-1, 3)
    return np.linalg.norm(area_vectors(corners, flat), axis=1)


def nodal_mass(shape: BagShape, membrane: Membrane, straps: Straps) -> np.ndarray:
    """Lumped mass [kg], (nodes,): a third of each element, half of each strap bar."""
    surface = shape.surface
    mass = nodal_share(surface.triangles[membrane.elements].astype(np.int64), membrane.mass, surface.node_count)
    return mass + np.bincount(straps.bars.ravel(), np.repeat(0.5 * straps.mass, 2), surface.node_count)
