"""`billow export-deck`: a case as a deck of LS-DYNA, to be computed elsewhere; what a deck cannot say is listed.

The mesh is that of the model, triangles; the flat cut is *AIRBAG_SHELL_REFERENCE_GEOMETRY with nodes of its own in the
plane z = 0, warp along x. Imported again, mesh and flat cut have the same bits.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

from billow.case.bag.build_bag import build_shape
from billow.case.fabric.schema_fabric import Cloth
from billow.case.schema import Case
from billow.decks.deck_text import DeckText
from billow.decks.export_bodies import put_bodies
from billow.decks.export_chambers import part_sets
from billow.decks.export_gas import NOT_EXPORTED, put_gas
from billow.decks.export_nodes import put_nodes
from billow.decks.export_straps import put_straps
from billow.decks.units import SYSTEMS
from billow.geometry.bag_shapes import BagShape

LEAK_CODES = {"wang-nefske": 1, "graefe": 3, "porous-medium": 5, "velocity-curve": 7}
FACTOR_UNITS = {"porous-medium": "per velocity", "velocity-curve": "velocity"}
NOT_IN_A_DECK = {
    "tear_seams": "seams that tear are not written; without them the bag would open otherwise",
    "covers": "what holds the bag back at first is not written; without it the bag would open otherwise",
}


def export_deck(case: Case, path: str | Path, units: str = "kg-mm-ms") -> list[str]:
    """Write the deck of a case; what was left out or approximated, line by line.

    Raises InputError of the case, and E-DCK-020 for what a deck cannot be without. FileExistsError if path exists.
    """
    text, notes = deck_of(case, units)
    with open(path, "x", encoding="ascii", errors="replace") as file:
        file.write(text)
    return notes


def deck_of(case: Case, units: str) -> tuple[str, list[str]]:
    """The text of the deck, and the notes."""
    for key, why in NOT_IN_A_DECK.items():
        if getattr(case.bag, key, ()):
            raise NOT_EXPORTED(thing=f"a bag with {key}", key=f"bag.{key}", why=why)
    if getattr(case.bag, "relax", None):
        raise NOT_EXPORTED(
            thing="a bag that comes to rest first", key="bag.folds, relax", why="a deck would begin before that"
        )
    shape = build_shape(case.bag)
    whole, (shape, called) = shape, by_chamber(shape)
    deck, notes = DeckText(SYSTEMS[units], case.title), []
    deck.comment(f"units {units}; written by Billow")
    _run(deck, case)
    vents = _mesh(deck, case, shape, called, notes)
    _materials(deck, case, shape, called, notes)
    put_gas(deck, case, shape, vents, notes)
    put_nodes(deck, case, whole)
    part = put_bodies(deck, case, shape, notes)
    if case.fabric.self_contact:
        deck.keyword("CONTACT_AIRBAG_SINGLE_SURFACE")
        deck.card(1, 0, 2, 0, 0, 0, 0, 0)
        deck.card(case.fabric.friction, 0.0)
        deck.card(0.0)
    put_straps(deck, case, shape, part, notes)
    return str(deck), notes


def _run(deck: DeckText, case: Case) -> None:
    run = case.run
    end = deck.of(run.end_time, "time")
    deck.keyword("CONTROL_TERMINATION")
    deck.card(end, 0, 0.0, 0.0, 0.0)
    deck.keyword("DATABASE_BINARY_D3PLOT")
    deck.card(end / run.frames)
    deck.keyword("DATABASE_ABSTAT")
    deck.card(end / run.frames / run.histories_per_frame)
    for axis, value in zip("XYZ", run.gravity, strict=True):
        if value:
            curve = deck.curve([0.0, 1.0], [-value, -value], "time", "acceleration", f"gravity along {axis}")
            deck.keyword(f"LOAD_BODY_{axis}")
            deck.card(curve, 1.0)


def by_chamber(shape: BagShape) -> tuple[BagShape, dict[str, str]]:
    """The bag with parts of one chamber each, and what each of them is part of in the case."""
    surface, chambers = shape.surface, shape.surface.chambers
    if chambers.count == 1:
        return shape, {name: name for name in surface.part_names}
    sides, part = np.unique(
        np.column_stack([surface.part, chambers.behind, chambers.ahead]), axis=0, return_inverse=True
    )
    names, kinds, called = [], [], {}
    for own, behind, _ in sides.tolist():
        alone = (sides[:, 0] == own).sum() == 1
        names.append(surface.part_names[own] if alone else f"{surface.part_names[own]}_{chambers.names[behind]}")
        kinds.append(surface.part_kinds[own])
        called[names[-1]] = surface.part_names[own]
    split = replace(surface, part=part.reshape(-1).astype(np.int32), part_names=tuple(names), part_kinds=tuple(kinds))
    return replace(shape, surface=split), called


def _mesh(deck: DeckText, case: Case, shape: BagShape, called: dict[str, str], notes: list[str]) -> dict[str, int]:
    """Nodes, shells, flat cut and parts; number of each part that is a vent. Part set 1 is the whole bag; the
    next ones are its chambers, or what `part_sets` says."""
    surface = shape.surface
    held = shape.fixed
    deck.node_block(shape.positions, held)
    flat = np.concatenate([shape.reference.reshape(-1, 2), np.zeros((3 * surface.triangle_count, 1))], axis=1)
    # Corners of one part that lie on each other are one node of the flat cut.
    key = np.column_stack([np.repeat(surface.part, 3), flat])
    _, first, node = np.unique(key, axis=0, return_index=True, return_inverse=True)
    begin = deck.node_block(flat[first])
    part = surface.part.astype(np.int64) + 1
    vents = [k for k, kind in enumerate(surface.part_kinds, 1) if kind == "vent"]
    chambers = surface.chambers
    for chamber in range(chambers.count):
        mine = [k for k in vents if (chambers.behind[part == k] == chamber).any()]
        if len(mine) > 1 and case.gas.model != "corpuscular":
            part[np.isin(part, mine)] = mine[0]  # A23 names one part
            notes.append(f"the {len(mine)} vents become one part: A23 of *AIRBAG_HYBRID names one")
    cells, own = surface.triangles.astype(np.int64) + 1, node.reshape(-1, 3) + begin + 1
    if case.gas.model == "corpuscular" and chambers.count == 1:  # *AIRBAG_PARTICLE wants normals into the bag
        cells, own = cells[:, [0, 2, 1]], own[:, [0, 2, 1]]
    fabric = np.isin(np.arange(len(cells)), surface.triangles_of_kind("fabric"))
    hole = ~fabric & (np.ptp(shape.reference, axis=1).min(axis=1) > 0.0)
    varied = {
        name
        for name, kind in zip(surface.part_names, surface.part_kinds, strict=True)
        if kind == "fabric" and np.ptp(shape.layers[surface.triangles_of(name)]) > 1e-9
    }
    own_thickness = np.isin(np.array(surface.part_names)[surface.part], list(varied))
    for keyword, nodes, which in (
        ("ELEMENT_SHELL", cells, ~own_thickness),
        ("ELEMENT_SHELL_THICKNESS", cells, own_thickness),
        ("AIRBAG_SHELL_REFERENCE_GEOMETRY", own, fabric | hole),
    ):
        if not which.any():
            continue
        deck.keyword(keyword)
        for k in np.flatnonzero(which):
            a, b, c = nodes[k].tolist()
            deck.card(int(k) + 1, int(part[k]), a, b, c, c)
            if keyword.endswith("THICKNESS"):
                deck.card(*[deck.of(case.fabric.thickness * float(shape.layers[k]), "length")] * 4, 0.0)
    for number, name in enumerate(surface.part_names, 1):
        if number not in part:
            continue
        deck.keyword("PART")
        deck.text(name)
        deck.card(number, number, number, 0, 0, 0, 0, 0)
        deck.keyword("SECTION_SHELL")
        deck.card(number, 9, 1.0, 3, 1.0, 0, 0, 1)
        mine = shape.layers[surface.triangles_of(name)]
        if name in varied:
            notes.append(f"part {name}: a thickness of its own for each shell; a case that is imported has their mean")
        thickness = case.fabric.of(called[name]).thickness * float(mine.mean())
        deck.card(*[deck.of(thickness, "length")] * 4)
    sets = {1: np.unique(part)}
    if chambers.count > 1 and case.gas.model == "corpuscular":
        sets |= part_sets(chambers, part)
    elif chambers.count > 1:
        sets |= {c + 2: np.unique(chambers.boundary(c, part)) for c in range(chambers.count)}
    for number, numbers in sets.items():
        deck.keyword("SET_PART_LIST")
        deck.card(number, 0.0, 0.0, 0.0, 0.0)
        for k in range(0, len(numbers), 8):
            deck.card(*numbers[k : k + 8].tolist())
    found = {surface.part_names[k - 1]: k for k in vents if k in part}
    return found


def _materials(deck: DeckText, case: Case, shape: BagShape, called: dict[str, str], notes: list[str]) -> None:
    surface = shape.surface
    for number, (name, kind) in enumerate(zip(surface.part_names, surface.part_kinds, strict=True), 1):
        fabric = case.fabric.of(called[name])
        if kind == "mouth":
            deck.keyword("MAT_RIGID")
            deck.card(number, deck.of(_density(fabric), "density"), deck.of(fabric.young_warp, "pressure"), 0.3)
            deck.card(1.0, 7, 7)
            deck.card(0.0)
        elif kind in ("vent", "opening"):
            deck.keyword("MAT_NULL")
            deck.card(number, deck.of(_density(fabric), "density"))
        else:
            leaky = bool((shape.leak[surface.triangles_of(name)] > 0.0).all())
            _cloth(deck, case, number, fabric, _leakage(deck, case, called[name], leaky, notes), notes)


def _density(fabric: Cloth) -> float:
    """With the coating [kg/m^3]."""
    return fabric.density + fabric.coating.density * fabric.coating.thickness / fabric.thickness


def _cloth(
    deck: DeckText, case: Case, number: int, fabric: Cloth, leakage: tuple[tuple[float, float, int], float],
    notes: list[str],
) -> None:  # fmt: skip
    """*MAT_FABRIC of a part, and its curves before it."""
    if fabric.coating.thickness:
        notes.append(f"fabric of part {number}: the mass of its coating is in RO")
    linear = fabric.law == "linear"
    curves = [0] * 6 if linear else _fabric_curves(deck, fabric, notes)
    form = {"linear": 0, "curves": 4, "curves-shear": 14}[fabric.law]
    (flc, fac, fvopt), blocked = leakage
    deck.keyword("MAT_FABRIC")
    young = deck.of(fabric.young_warp, "pressure"), deck.of(fabric.young_weft, "pressure")
    minor = fabric.poisson * fabric.young_weft / fabric.young_warp
    deck.card(number, deck.of(_density(fabric), "density"), *young, None, minor, fabric.poisson, None)
    liner = fabric.liner
    own = (deck.of(liner.young, "pressure"), liner.poisson, liner.ratio) if liner.ratio else (0.0, 0.0, 0.0)
    shear, compression = deck.of(fabric.shear, "pressure"), 0.0 if fabric.compression else 1.0
    deck.card(shear, None, None, compression, *own, fabric.damping)
    deck.card(2.0, flc, fac, blocked, 0.0, form, fvopt, 0.0)
    birth = deck.of(getattr(case.bag, "birth_time", 0.0), "time")
    deck.card(None, birth, 0, 1.0, 0.0, 0.0, 0.0, 1.0)
    deck.card(0.0, 0.0, 0.0, None, None, None, 0.0, 1)
    if not linear:
        deck.card(*curves, 0.0)


def _fabric_curves(deck: DeckText, fabric: Cloth, notes: list[str]) -> list[int]:
    """Ids of LCA LCB LCAB LCUA LCUB LCUAB: true strain, and true stress at constant width."""
    curves = fabric.curves
    if curves.yarn_angle != 90.0:
        raise NOT_EXPORTED(thing="yarns that are not at right angles", key="fabric.curves.yarn_angle", why="no field")
    if curves.transverse:
        notes.append(f"fabric curves: from transverse {curves.transverse:g} to constant width, exact at their points")
    ids = []
    for branch in ("loading", "unloading"):
        for name in ("warp", "weft"):
            one = getattr(getattr(curves, name), branch)
            strain, stress = np.array(one.strain), np.array(one.stress)
            stress = stress * np.exp(curves.transverse * strain)  # the same second Piola-Kirchhoff stress
            ids.append(deck.curve(strain, stress, "-", "pressure", f"{name} {branch}") if len(strain) else 0)
        one = getattr(curves.shear, branch)
        angle = np.radians(np.array(one.angle))
        ids.append(deck.curve(angle, one.stress, "-", "pressure", f"shear {branch}") if len(angle) else 0)
    return ids


def _leakage(
    deck: DeckText, case: Case, part: str, leaky: bool, notes: list[str]
) -> tuple[tuple[float, float, int], float]:
    """FLC, FAC, FVOPT, and ELA."""
    law = case.leakage.parts.get(part, case.leakage)
    if not leaky:
        return (0.0, 0.0, 0), 0.0
    if law.law == "permeability":
        permeability = case.fabric.of(part).permeability
        if not permeability:
            return (0.0, 0.0, 0), 0.0
        outside = case.ambient.pressure
        over = np.concatenate([[0.0], np.geomspace(50.0, 300e3, 60)])
        speed = permeability * np.sqrt(over / 500.0)
        curve = deck.curve(outside + over, speed, "pressure", "velocity", f"{part} leak speed")
        notes.append(
            f"part {part}: permeability as a curve of leak speed (FVOPT 7), exact at 61 pressures; its stretched area"
        )
        return (1.0, -float(curve), 7), 0.0
    fvopt = LEAK_CODES[law.law] + (1 if law.blockage else 0)
    if law.area != "deformed":
        notes.append(f"part {part}: the stretched area leaks; leakage.area has no fields beside FLC and FAC")

    def factor(value, axis: str, dimension: str) -> float:
        if isinstance(value, float):
            return deck.of(value, dimension)
        return -float(deck.curve(getattr(value, axis), value.value, axis, dimension, f"{part} leakage"))

    flc = factor(law.time_factor, "time", "-")
    fac = factor(law.pressure_factor, "pressure", FACTOR_UNITS.get(law.law, "-"))
    return (flc, fac, fvopt), law.through_blocked if law.blockage else 0.0
