"""From a `Case` to a `Model`: the only place where what users wrote meets what kernels need."""

from __future__ import annotations

import numpy as np

from billow.case import schema
from billow.contact.rigid_contact import Plate, SuperEllipsoid, SurfaceLaw
from billow.dynamics.forces import push_apart
from billow.dynamics.model import Model, Obstacle, start_state
from billow.dynamics.run import Schedule
from billow.errors import InputError
from billow.fabric.fabric import LinearFabric
from billow.fabric.membrane import Membrane
from billow.fabric.straps import NO_STRAPS, Straps
from billow.gas.gas_model import GasModel
from billow.gas.inflator import Inflator, JetRing
from billow.gas.jets import Jets
from billow.gas.no_gas import NoGas
from billow.gas.species import AIR, find_species, mass_fractions, thermo_table
from billow.gas.uniform_pressure import Ambient, Porosity, UniformPressure, Vents
from billow.geometry import super_ellipsoid
from billow.geometry.bag_shapes import BagShape, driver_bag
from billow.geometry.surface import area_vectors, check_closed, nodal_share
from billow.impactor.rigid_body import RigidBody, RigidState, quaternion_about

MOST_TRIANGLES = 500_000


def build_model(case: schema.Case) -> Model:
    """The model of a case.

    Raises InputError: E-GEO-001..011 geometry, E-GAS-001 unknown species.
    """
    _require_modest(case.bag)
    _require_apart(case.bag.vents)
    shape = build_shape(case.bag)
    check_closed(shape.surface, shape.positions, "bag")
    fabric = build_fabric(case.fabric)
    cloth = fabric_triangles(shape)
    membrane = Membrane.build(fabric, cloth, shape.reference[cloth])
    straps = build_straps(shape, fabric)
    area = flat_area(shape.reference)
    mass = nodal_mass(shape, membrane, straps)
    return Model(
        surface=shape.surface,
        start=np.ascontiguousarray(shape.positions),
        membranes=(membrane,),
        straps=straps,
        gas=build_gas(case, shape, float(area[cloth].sum())),
        obstacles=tuple(build_obstacle(o) for o in case.obstacles),
        mass=mass,
        contact_area=nodal_share(shape.surface.triangles[cloth], area[cloth], shape.surface.node_count),
        fixed=shape.fixed,
        gravity=np.array(case.run.gravity),
    )


def _require_modest(bag: schema.Bag) -> None:
    panels = 0.5 * np.pi * bag.diameter**2
    triangles = panels / (0.25 * np.sqrt(3.0) * bag.element_size**2)
    if triangles > MOST_TRIANGLES:
        raise InputError(
            "E-GEO-011",
            f"the mesh would have about {triangles:.2g} triangles",
            where="bag.element_size, bag.diameter",
            why=f"at most {MOST_TRIANGLES} are allowed, to fit into memory; a length may be in another unit",
            remedy=f"raise bag.element_size to {bag.element_size * np.sqrt(triangles / MOST_TRIANGLES):.2g} m or more",
        )


def _require_apart(vents: schema.Vents) -> None:
    apart = 2.0 * vents.distance * np.sin(np.pi / vents.count) if vents.count > 1 else np.inf
    if apart <= vents.diameter:
        raise InputError(
            "E-GEO-010",
            "the vents overlap",
            where="bag.vents",
            why=f"{vents.count} vents of {vents.diameter:g} m have their centres {apart:.3g} m apart",
            remedy="reduce bag.vents.diameter or bag.vents.count, or raise bag.vents.distance",
        )


def build_schedule(run: schema.Run) -> Schedule:
    return Schedule(run.end_time, run.frames, run.histories_per_frame, run.dt_scale)


def build_shape(bag: schema.Bag) -> BagShape:
    return driver_bag(
        diameter=bag.diameter,
        element_size=bag.element_size,
        mouth_radius=bag.mouth_radius,
        vent_count=bag.vents.count,
        vent_diameter=bag.vents.diameter,
        vent_radius=bag.vents.distance,
        strap_count=bag.straps.count,
        strap_length=bag.straps.length,
        strap_width=bag.straps.width,
        strap_stitch_radius=bag.straps.stitch_radius,
        initial_gap=bag.initial_gap,
    )


def build_fabric(fabric: schema.Fabric) -> LinearFabric:
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


def fabric_triangles(shape: BagShape) -> np.ndarray:
    """Triangles (n,) int64 made of fabric: all but vents, which are holes, and the mouth, which is the inflator."""
    names = shape.surface.part_names
    cloth = np.array([not (name == "mouth" or name.startswith("vent")) for name in names])
    return np.flatnonzero(cloth[shape.surface.part])


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


def build_gas(case: schema.Case, shape: BagShape, porous_area: float) -> GasModel:
    """The gas model named in the case; inflator, vents, porosity and ambient are the same objects for all."""
    if case.gas.model == "none":
        return NoGas(case.ambient.pressure, case.ambient.temperature)
    names = tuple(dict.fromkeys([*case.inflator.gas, *AIR]))
    species = [find_species(name, f"inflator.gas.{name}") for name in names]

    def in_order(moles: dict[str, float]) -> np.ndarray:
        fractions = mass_fractions(moles)
        return np.array([fractions.get(name, 0.0) for name in names])

    temperature = case.inflator.temperature
    if isinstance(temperature, float):
        temperature_time, temperature_value = [0.0, 1.0], [temperature, temperature]
    else:
        temperature_time, temperature_value = temperature.time, temperature.value
    ring = JetRing(
        case.inflator.jets.count,
        case.inflator.jets.ring_radius,
        case.inflator.jets.hole_diameter,
        float(np.radians(case.inflator.jets.angle)),
    )
    inflator = Inflator(
        flow_time=np.array(case.inflator.mass_flow.time),
        mass_flow=np.array(case.inflator.mass_flow.value),
        temperature_time=np.array(temperature_time),
        temperature=np.array(temperature_value),
        mass_fractions=in_order(case.inflator.gas),
    )
    mouth = np.unique(shape.surface.triangles[shape.surface.triangles_of("mouth")]).astype(np.int64)
    return UniformPressure(
        table=thermo_table(species),
        species_names=names,
        inflator=inflator,
        ambient=Ambient(case.ambient.pressure, case.ambient.temperature, in_order(AIR)),
        vents=build_vents(case.bag.vents, shape),
        porosity=Porosity(case.fabric.permeability, porous_area),
        jets=Jets(ring, mouth, shape.mouth_axis) if ring.count else None,
    )


def build_vents(vents: schema.Vents, shape: BagShape) -> Vents:
    patches = [shape.surface.triangles_of(f"vent_{k + 1}") for k in range(vents.count)]
    return Vents(
        triangles=shape.surface.triangles[np.concatenate([*patches, np.empty(0, np.int64)]).astype(np.int64)],
        start=np.concatenate([[0], np.cumsum([len(p) for p in patches])]).astype(np.int64),
        discharge=np.full(vents.count, vents.discharge),
        opening=np.full(vents.count, vents.opening_pressure),
    )


def build_obstacle(obstacle: schema.Plate | schema.SuperEllipsoid) -> Obstacle:
    law = SurfaceLaw(obstacle.slope, obstacle.friction, obstacle.damping)
    if isinstance(obstacle, schema.Plate):
        body = RigidBody(1.0, np.ones(3), locked=True)
        start = RigidState(np.array([0.0, 0.0, obstacle.height]))
        return Obstacle(obstacle.name, Plate(np.array([0.0, 0.0, 1.0])), law, body, start)
    radii = np.array([obstacle.radii] * 3 if isinstance(obstacle.radii, float) else obstacle.radii)
    inertia = super_ellipsoid.principal_inertia(obstacle.mass, radii, obstacle.degree)
    start = RigidState(
        centre=np.array([*obstacle.offset, obstacle.clearance + radii[2]]),
        quaternion=quaternion_about(np.array([1.0, 0.0, 0.0]), np.radians(obstacle.angle_about_x)),
        velocity=np.array(obstacle.velocity) * (not obstacle.locked),
    )
    body = RigidBody(obstacle.mass, inertia, obstacle.locked)
    return Obstacle(obstacle.name, SuperEllipsoid(radii, obstacle.degree), law, body, start)


def require_start_clear(model: Model) -> None:
    """Raises InputError if an obstacle touches the bag at the start, E-GEO-020, or lies inside it, E-GEO-021."""
    state = start_state(model)
    push_apart(model, state, 0.0)
    for obstacle, deepest in zip(model.obstacles, state.contact.deepest.tolist(), strict=True):
        if deepest > 1e-6:
            raise InputError(
                "E-GEO-020",
                f"{obstacle.name} penetrates the bag at the start by {1e3 * deepest:.3g} mm",
                where=f"obstacles.{obstacle.name}",
                why="the penalty force would shoot the fabric away",
                remedy="raise its clearance, or lower the plate's height",
            )
        if isinstance(obstacle.shape, SuperEllipsoid) and _encloses(model, obstacle.start.centre):
            raise InputError(
                "E-GEO-021",
                f"{obstacle.name} lies inside the bag at the start",
                where=f"obstacles.{obstacle.name}",
                why="the gas does not know that it takes up room there",
                remedy="raise its clearance, or move it aside with offset",
            )


def _encloses(model: Model, point: np.ndarray) -> bool:
    """Whether the closed bag surrounds a point [m]: its triangles then fill the whole view, 4 pi (van Oosterom and
    Strackee, IEEE Trans. Biomed. Eng. 30 (1983) 125)."""
    corners = model.start[model.surface.triangles] - point
    a, b, c = (corners[:, k] for k in range(3))
    la, lb, lc = (np.linalg.norm(v, axis=1) for v in (a, b, c))
    ab, bc, ca = (np.einsum("ij,ij->i", u, v) for u, v in ((a, b), (b, c), (c, a)))
    box = np.einsum("ij,ij->i", a, np.cross(b, c))
    half_angle = np.arctan2(box, la * lb * lc + ab * lc + bc * la + ca * lb)
    return abs(half_angle.sum()) > np.pi
