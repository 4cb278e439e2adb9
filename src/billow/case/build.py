"""From a `Case` to a `Model`: the only place where what users wrote meets what kernels need."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from billow.base.errors import InputError
from billow.case import schema
from billow.case.bag.build_bag import build_shape, build_straps, fold_plan
from billow.case.bag.build_tear_seams import build_tear_seams
from billow.case.fabric.build_fabric import build_fabric
from billow.case.gas.build_gas import build_gas
from billow.case.gas.models import GAS_MODELS
from billow.case.nodes.build_nodes import driven_nodes, launched, require_possible_groups, start_velocity
from billow.case.obstacles.obstacles import build_body
from billow.case.relaxed_start import relaxed_start, tense_case
from billow.geometry.assembly import in_neighbourhoods
from billow.geometry.bag_shapes import BagShape
from billow.geometry.crossings import CrossingCount, edges_of
from billow.geometry.flat_cut import flat_area
from billow.geometry.reference_check import place
from billow.geometry.surface import check_closed, encloses, nodal_share
from billow.parts.bodies.bodies import TOUCHES, Bodies
from billow.parts.fabric.birth import Birth
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.mass_shares import share_mass
from billow.parts.fabric.membrane import FabricLaw, Membrane
from billow.parts.layers.layers import Layers
from billow.parts.self_contact import SelfContact
from billow.parts.straps import Straps
from billow.solver.model import Model
from billow.solver.run import Schedule

PENETRATES = InputError.declare(
    "E-GEO-020",
    "{body} penetrates the bag at the start by {depth:.3g} mm",
    where="obstacles.{body}",
    why="the penalty force would shoot the fabric away",
    cause="a clearance that is too small for the start shape, or a plate above z = 0",
    remedy="raise its clearance, or lower the height of the plate",
)
OVERLAP = InputError.declare(
    "E-GEO-022",
    "{one} and {other} overlap at the start by {depth:.3g} mm",
    where="obstacles.{one}, obstacles.{other}",
    why="at least one of them is free to move, and their contact would throw it away",
    cause="a clearance or an offset that is too small, or a plate at the height of another obstacle",
    remedy="move them apart, or lock both",
)
NO_SUCH_PART = InputError.declare(
    "E-FAB-150",
    "the bag has no fabric part {part!r}",
    where="fabric.parts.{part}",
    why="a fabric belongs to a part of the bag, and vents and the mouth are none of fabric",
    cause="a misspelt part, or a vent",
    remedy="use one of {known}",
)
INSIDE = InputError.declare(
    "E-GEO-021",
    "{body} lies inside the bag at the start",
    where="obstacles.{body}",
    why="the gas does not know that it takes up room there",
    cause="a small obstacle within a start shape that is high",
    remedy="raise its clearance, or move it aside with offset",
)
CROSSED = InputError.declare(
    "E-GEO-110",
    "layers of the bag pass through each other at the start, at {count} places",
    where="{places}; bag",
    why="contact keeps every layer on the side where it lies, and would hold those that have crossed for ever; which "
    "of them to move, and where to, only who folded the bag can tell",
    cause="a mesh folded by another tool without a check, a vent on a fold line, or folds without a row of nodes along "
    "them",
    remedy="move the start shape apart there, or run with fabric.self_contact = false to see it open all the same",
)
MOST_PLACES = 3
"""Where layers cross, in a message."""


def build_model(case: schema.Case) -> Model:
    """The model of a case.

    Raises InputError: E-GEO-001..012 geometry, E-GAS-001 unknown species, E-FAB-150 unknown part, E-CASE-213..216
    groups of nodes.
    """
    shape = found = build_shape(case.bag)
    if getattr(case.bag, "relax", None):
        tense = tense_case(case)
        is_exact = fold_plan(case.bag).keeps_lengths
        shape = replace(shape, positions=relaxed_start(build_model(tense), case.bag.relax, tense.digest(), is_exact))
    check_closed(shape.surface, shape.positions, "bag")
    law = build_fabric(case.fabric)
    membranes = build_membranes(case, shape, law)
    cloth = np.concatenate([membrane.elements for membrane in membranes])
    straps = build_straps(shape, law)
    area = flat_area(shape.reference)
    mass = nodal_mass(shape, membranes, straps)
    contact_area = nodal_share(shape.surface.triangles[cloth], area[cloth], shape.surface.node_count)
    gravity = np.array(case.run.gravity)
    birth, birth_time = None, getattr(case.bag, "birth_time", 0.0)
    if birth_time:
        birth = Birth.of(birth_time, membranes, shape.surface.triangles, shape.positions)
    apart = case.fabric.self_contact
    if apart == "auto":
        apart = "layers" if getattr(case.bag, "folds", ()) else GAS_MODELS[case.gas.model].is_local
    gas = GAS_MODELS[case.gas.model]
    has_jets = gas.is_local or (gas.has_supply and any(one.jets.count for one in case.inflators))
    require_possible_groups(case.nodes, found, has_jets, apart == "layers")
    driven, fixed = driven_nodes(case.nodes, found, shape.positions, mass), shape.fixed
    if driven is not None:
        fixed = fixed.copy()
        fixed[driven.nodes] = True  # for all kernels; what moves or yields is theirs
        contact_area[driven.nodes[driven.yielding > 0.0]] = 0.0
    velocity = start_velocity(case.nodes, found, shape.positions)
    if velocity is not None:
        velocity = launched(velocity, ~fixed & (mass > 0.0), driven)
    fastest = min(membrane.crossing_time for membrane in membranes)
    springs = SelfContact.build(shape.surface, shape.positions, mass, fastest) if apart is True else None
    model = Model(
        surface=shape.surface,
        start=np.ascontiguousarray(shape.positions),
        mass=mass,
        fixed=fixed,
        gravity=gravity,
        gas=build_gas(case, shape),
        fabric=Fabric(shape.surface, membranes, birth),
        straps=straps,
        bodies=Bodies(tuple(build_body(obstacle) for obstacle in case.obstacles), contact_area, gravity),
        self_contact=springs,
        driven=driven,
        tear_seams=build_tear_seams(shape, law),
        start_velocity=velocity,
    )
    return replace(model, layers=keep_apart(model, case.fabric.friction)) if apart == "layers" else model


def build_membranes(case: schema.Case, shape: BagShape, law: FabricLaw) -> tuple[Membrane, ...]:
    """A membrane for each fabric, the general one, law, first. Raises InputError E-FAB-150, and those of
    `build_fabric`."""
    surface, parts = shape.surface, case.fabric.parts
    known = [name for name, kind in zip(surface.part_names, surface.part_kinds, strict=True) if kind == "fabric"]
    for part in parts:
        if part not in known:
            raise NO_SUCH_PART(part=part, known=", ".join(known))
    cloth = surface.triangles_of_kind("fabric")  # vents are holes, and the mouth is the inflator
    cloth = cloth[in_neighbourhoods(shape.positions[surface.triangles[cloth]].mean(axis=1))]
    general = ~np.isin(surface.part[cloth], [surface.part_names.index(part) for part in parts])
    laws = [(law, cloth[general])] if general.any() else []
    for part, table in parts.items():
        own = cloth[surface.part[cloth] == surface.part_names.index(part)]
        laws.append((build_fabric(table, f"fabric.parts.{part}"), own))
    membranes = [
        Membrane.build(one, own, shape.reference[own], one.thickness * shape.layers[own], surface.chambers)
        for one, own in laws
    ]
    return share_mass(membranes, surface.triangles)


def keep_apart(model: Model, friction: float = 0.0) -> Layers:
    """Contact of the layers of a model's fabric; friction: coefficient between them."""
    fabric = model.fabric
    birth = fabric.birth.time if fabric.birth is not None else 0.0
    stable_dt = fabric.squared_rate(fabric.start(None)) ** -0.5
    triangles = model.surface.triangles[model.surface.solid]
    ends = model.start[edges_of(triangles)]
    edge = float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean())
    gap = min(membrane.fabric.thickness for membrane in fabric.membranes)
    return Layers(model.surface, model.mass, model.inverse_mass, edge, gap, stable_dt, birth, friction)


def build_schedule(run: schema.Run) -> Schedule:
    return Schedule(run.end_time, run.frames, run.histories_per_frame, run.dt_scale)


def nodal_mass(shape: BagShape, membranes: Sequence[Membrane], straps: Straps) -> np.ndarray:
    """Lumped mass [kg], (nodes,): a third of each element, half of each strap bar."""
    surface, elements = shape.surface, np.concatenate([membrane.elements for membrane in membranes])
    order = np.argsort(elements)  # which may be any; the sums shall not depend on it
    corners, masses = surface.triangles[elements[order]].astype(np.int64), [membrane.mass for membrane in membranes]
    mass = nodal_share(corners, np.concatenate(masses)[order], surface.node_count)
    return mass + np.bincount(straps.bars.ravel(), np.repeat(0.5 * straps.mass, 2), surface.node_count)


def require_start_clear(model: Model) -> None:
    """Raises InputError if an obstacle touches the bag at the start, E-GEO-020, lies inside it, E-GEO-021, or overlaps
    another of which one can move, E-GEO-022; or if layers that contact keeps apart have crossed, E-GEO-110."""
    if model.layers is not None:
        crossed = CrossingCount(model.surface).per_triangle(model.start)
        if crossed.any():
            worst = np.argsort(-crossed, kind="stable")[: min(MOST_PLACES, np.count_nonzero(crossed))]
            places = "; ".join(place(model.surface, model.start, int(triangle)) for triangle in worst)
            raise CROSSED(count=int(crossed.sum()), places=places)
    for one, other, depth in model.bodies.meetings.overlaps([body.start for body in model.bodies.bodies]):
        if depth > TOUCHES:
            raise OVERLAP(one=one.name, other=other.name, depth=1e3 * depth)
    for body, deepest in model.bodies.touching_at_start(model.start, model.inverse_mass):
        raise PENETRATES(body=body.name, depth=1e3 * deepest)
    for body in model.bodies.bodies:
        middles = [body.start.centre + body.start.rotation @ carried.centre for carried in body.shapes]
        if body.is_bounded and any(encloses(model.surface.triangles, model.start, middle) for middle in middles):
            raise INSIDE(body=body.name)
