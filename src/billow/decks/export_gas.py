"""The gas of a case as *AIRBAG_HYBRID or *AIRBAG_PARTICLE."""

from __future__ import annotations

import math

import numpy as np

from billow.base.errors import InputError
from billow.case.gas.build_gas import GasNames, build_supply, ring_radius, start_of_rim
from billow.case.schema import Case
from billow.decks.deck_text import DeckText
from billow.decks.export_chambers import INNER, OUTER, openings, put_chambers
from billow.geometry.bag_shapes import BagShape
from billow.parts.gas.supply.inflator import Inflator
from billow.parts.gas.supply.species import COLDEST, MOLAR_GAS_CONSTANT, Species

NOT_EXPORTED = InputError.declare(
    "E-DCK-020",
    "{thing} cannot be exported",
    where="{key}",
    cause="a model that cards of LS-DYNA do not have",
    remedy="change {key}, or take it out before exporting",
)

HOTTEST_FIT = 1500.0
"""Temperature [K] up to which a quadratic is fitted to the heat capacity of a gas of the library."""
UNIT_CODES = {"kg-mm-ms": 0, "kg-m-s": 1, "t-mm-s": 2}


def put_gas(deck: DeckText, case: Case, shape: BagShape, vents: dict[str, int], notes: list[str]) -> None:
    """The airbag on part set 1. vents: number of each part that is one. Raises InputError E-DCK-020."""
    if case.gas.model == "none":
        raise NOT_EXPORTED(thing="a bag without gas", key="gas.model", why="an airbag keyword needs a gas")
    names, supply = GasNames.of(case), build_supply(case, shape)
    species = dict(zip(names.names, names.species, strict=True))
    flows = [
        (name, source.inflator, float(share), case.inflators[k])
        for k, source in enumerate(supply.sources)
        for name, share in zip(names.names, source.inflator.mass_fractions, strict=True)
        if share > 0.0
    ]
    initial = names.mass_fractions(case.gas.initial.gas, case.gas.initial.fractions)
    if case.gas.model == "corpuscular":
        _particle(deck, case, shape, species, flows, initial, vents, notes)
    else:
        _hybrids(deck, case, shape, species, flows, initial, vents, notes)


def _molar(deck: DeckText, gas: Species, notes: list[str]) -> tuple[float, float, float, float]:
    """Molar mass and terms A, B, C in the units of the deck; fitted for gases with more terms."""
    if gas.low == gas.high and gas.low[3:] == (0.0, 0.0):
        terms = [float(f"{term * MOLAR_GAS_CONSTANT:.15g}") for term in gas.low[:3]]  # as somebody wrote them
    else:
        t = np.linspace(COLDEST, HOTTEST_FIT, 131)
        cp = np.where(t < gas.middle, np.polyval(gas.low[::-1], t), np.polyval(gas.high[::-1], t))
        fit = np.polyfit(t, cp, 2)
        off = float(np.abs(np.polyval(fit, t) / cp - 1.0).max())
        terms = (MOLAR_GAS_CONSTANT * fit[::-1]).tolist()
        notes.append(f"{gas.name}: cp as A + B T + C T^2, within {100 * off:.2g} % up to {HOTTEST_FIT:g} K")
    a, b, c = (deck.of(term, "molar heat") for term in terms)
    return deck.of(gas.molar_mass, "molar mass"), a, b, c


def _curves(deck: DeckText, name: str, inflator: Inflator, share: float) -> tuple[int, int]:
    flow = deck.curve(inflator.flow_time, share * inflator.mass_flow, "time", "mass flow", f"{name} mass flow")
    warm = deck.curve(inflator.temperature_time, inflator.temperature, "time", "-", f"{name} temperature")
    return flow, warm


def _discharge(deck: DeckText, value, name: str) -> tuple[float, int]:
    """A number and no curve, or a curve against time."""
    if isinstance(value, float):
        return value, 0
    return 0.0, deck.curve(value.time, value.value, "time", "-", f"{name} discharge")


def _hybrids(deck: DeckText, case: Case, shape: BagShape, species, flows, initial, vents, notes: list[str]) -> None:
    """An airbag for each chamber, and what joins them."""
    surface, chambers = shape.surface, shape.surface.chambers
    if chambers.count == 1:
        _hybrid(deck, case, species, flows, initial, vents, list(case.gas.orifices), notes)
        return
    for number, name in enumerate(chambers.names):
        mine = {
            vent: part for vent, part in vents.items() if (chambers.behind[surface.triangles_of(vent)] == number).all()
        }
        out = [o for o in case.gas.orifices if set(o.between) == {name, "ambient"}]
        own = [flow for flow in flows if flow[1].chamber == number]
        _hybrid(deck, case, species, own, initial, mine, out, notes if number == 0 else [], number + 1)
    index = {name: k for k, name in enumerate(chambers.names, 1)}
    for orifice in case.gas.orifices:
        if "ambient" not in orifice.between:
            value, curve = _discharge(deck, orifice.discharge, orifice.name)
            _interaction(deck, *(index[end] for end in orifice.between), deck.of(orifice.area, "area"),
                         -float(curve) if curve else value, 0)  # fmt: skip
    for part, ends in openings(shape).items():
        _interaction(deck, *ends, 0.0, case.gas.opening_discharge, part)


def _interaction(deck: DeckText, first: int, second: int, area: float, share: float, part: int) -> None:
    deck.keyword("AIRBAG_INTERACTION")
    deck.card(first, second, area, share, part, 0, 0)


def _hybrid(
    deck: DeckText, case: Case, species, flows, initial, vents, orifices, notes: list[str], number: int = 0
) -> None:  # fmt: skip
    """number: of one of several airbags, whose part set is the next."""
    exits: list[tuple[float, int, float]] = []
    opens = 0.0
    if vents:
        flow = case.bag.vents
        value, curve = _discharge(deck, flow.discharge, "vents")
        exits.append((value, curve, -float(min(vents.values()))))
        opens = flow.opening_pressure
        if not isinstance(flow.area_factor, float) or flow.area_factor != 1.0:
            raise NOT_EXPORTED(
                thing="a factor on the area of vents", key="bag.vents.area_factor", why="A23 is that of the part"
            )
        for key in ("blockage", "burst_time"):
            if getattr(flow, key):
                notes.append(f"bag.vents.{key} has no field in *AIRBAG_HYBRID: left out")
    for orifice in orifices:
        value, curve = _discharge(deck, orifice.discharge, orifice.name)
        exits.append((value, curve, deck.of(orifice.area, "area")))
    if len(exits) > 2:
        raise NOT_EXPORTED(
            thing="a bag with more than two exits", key="gas.orifices", why="*AIRBAG_HYBRID has A23 and AP23"
        )
    exits += [(0.0, 0, 0.0)] * (2 - len(exits))
    curves = [_curves(deck, name, inflator, share) for name, inflator, share, _ in flows]
    if any(table.jets.count for *_, table in flows):
        notes.append("inflator.jets: uniform pressure of *AIRBAG_HYBRID has no jets: left out")
    gases = [_molar(deck, species[name], notes) for name, *_ in flows]
    rest = [(name, share) for name, share in zip(species, initial, strict=True) if share > 0.0]
    state = case.gas.initial
    if state.temperature != "ambient" or state.pressure != "ambient":
        notes.append("gas.initial: the bag begins at the ambient state in *AIRBAG_HYBRID")
    deck.keyword("AIRBAG_HYBRID_ID" if number else "AIRBAG_HYBRID")
    if number:
        deck.card(number)
    deck.card(number + 1, 1, 0, 1.0, 1.0, 0.0, 0.0, 0.0)
    ambient = case.ambient
    deck.card(
        ambient.temperature, deck.of(ambient.pressure, "pressure"), 0.0, deck.of(MOLAR_GAS_CONSTANT, "molar heat"), 1.0,
        deck.of(case.gas.heat_transfer, "heat transfer"),
    )  # fmt: skip
    (c23, lcc23, a23), (cp23, lccp23, ap23) = exits
    deck.card(c23, lcc23, a23, 0, cp23, lccp23, ap23, 0)
    own = [(name, share) for name, share in rest if name not in [flow[0] for flow in flows]]
    shared = dict(rest)
    deck.card(0, deck.of(opens, "pressure"), len(flows) + len(own), 0, 0, 0)
    used: set[str] = set()
    for (name, *_), (flow_id, warm_id), (mass, a, b, c) in zip(flows, curves, gases, strict=True):
        share = 0.0 if name in used else float(shared.get(name, 0.0))
        used.add(name)
        deck.card(flow_id, warm_id, None, mass, share, a, b, c)
        deck.card(0.0)
    for name, share in own:
        deck.card(0, 0, None, _molar(deck, species[name], notes)[0], float(share), *_molar(deck, species[name], [])[1:])
        deck.card(0.0)


def _particle(deck: DeckText, case: Case, shape: BagShape, species, flows, initial, vents, notes: list[str]) -> None:
    _require_mouths(case, shape, flows)
    if case.gas.orifices:
        raise NOT_EXPORTED(thing="an orifice", key="gas.orifices", why="*AIRBAG_PARTICLE has vents of parts only")
    curves = [_curves(deck, name, inflator, share) for name, inflator, share, _ in flows]
    numbers = {table.name: k for k, table in enumerate(case.inflators, 1)}
    chambers, inner = put_chambers(deck, shape), openings(shape)
    holes = []
    for table in case.inflators:
        if table.jets.count:
            chamber = next(flow[1].chamber for flow in flows if flow[3] is table) + 1 if chambers else 0
            holes += [(*row, 0, 0, chamber) for row in _ring(deck, table, shape, numbers[table.name])]
            if table.jets.spin:
                notes.append("inflator.jets.spin has no field in *AIRBAG_PARTICLE: left out")
    vent_rows = []
    if vents:
        flow = case.bag.vents
        value, curve = _discharge(deck, flow.discharge, "vents")
        vent_rows = [(n, 0, value, curve, 0, 0, deck.of(flow.opening_pressure, "pressure")) for n in vents.values()]
    vent_rows += [(n, 0, case.gas.opening_discharge, 0, 0, 2, 0.0) for n in inner]
    air = Species.polynomial("mixture", *_mixed(species, initial))
    state, ambient = case.gas.initial, case.ambient
    warm = ambient.temperature if state.temperature == "ambient" else state.temperature
    pressure = ambient.pressure if state.pressure == "ambient" else state.pressure
    notes.append("the air at the start as one gas: A + B T + C T^2 of the mixture")
    deck.keyword("AIRBAG_PARTICLE")
    blocked = case.leakage.blockage or (bool(vents) and case.bag.vents.blockage)
    within = (shape.surface.chambers.ahead >= 0).any()
    deck.card(OUTER if chambers else 1, 1, *((INNER, 1) if within else (0, 0)), 1 if blocked else 0, 0, 0.0, 0)
    code = UNIT_CODES.get(deck.units.name, 3)
    tsw = deck.of(case.gas.switch_time, "time") if case.gas.switch_time else 1e10
    deck.card(
        case.gas.particles, code, 1, ambient.temperature, deck.of(ambient.pressure, "pressure"), len(vent_rows),
        deck.of(case.run.end_time, "time"), tsw,
    )  # fmt: skip
    if code == 3:
        units = deck.units
        deck.card(None, units.mass, None, units.time, None, units.length)
    deck.card(2, len(flows), len(holes), 0, 0, 0, chambers, 0.0)
    for row in vent_rows:
        deck.card(*row)
    deck.card(deck.of(pressure, "pressure"), warm, *_molar(deck, air, []), 0, 0)
    for (name, _, _, table), (flow_id, warm_id) in zip(flows, curves, strict=True):
        deck.card(flow_id, warm_id, *_molar(deck, species[name], notes), numbers[table.name])
    for row in holes:
        deck.card(*row)


def _require_mouths(case: Case, shape: BagShape, flows) -> None:
    """Raises InputError E-DCK-020 for inflators of several chambers that no orifice can tell apart."""
    surface, chambers = shape.surface, shape.surface.chambers
    if chambers.count == 1:
        return
    mouths = set(chambers.behind[surface.triangles_of_kind("mouth")].tolist())
    if len(mouths) > 1:
        why = "rings of jets are written around one mouth"
        raise NOT_EXPORTED(thing="particles and mouths in several chambers", key="bag.parts", why=why)
    for _, inflator, _, table in flows:
        if not table.jets.count and inflator.chamber not in (mouths or {0}):
            why = "a gas of *AIRBAG_PARTICLE without orifices has no chamber; it would blow into that of the mouth"
            raise NOT_EXPORTED(
                thing="an inflator without jets away from the mouth", key=f"inflator, {table.name}, chamber", why=why
            )


def _mixed(species, shares) -> tuple[float, float, float, float]:
    """Molar mass [kg/mol] and molar terms a, b, c of a mixture by mass, cp fitted."""
    gases = [(gas, share) for gas, share in zip(species.values(), shares, strict=True) if share > 0.0]
    moles = np.array([share / gas.molar_mass for gas, share in gases])
    mole = moles / moles.sum()
    if len(gases) == 1 and gases[0][0].low == gases[0][0].high:
        return gases[0][0].molar_mass, *(MOLAR_GAS_CONSTANT * term for term in gases[0][0].low[:3])
    t = np.linspace(COLDEST, HOTTEST_FIT, 131)
    cp = sum(
        m * np.where(t < gas.middle, np.polyval(gas.low[::-1], t), np.polyval(gas.high[::-1], t))
        for m, (gas, _) in zip(mole, gases, strict=True)
    )
    terms = np.polyfit(t, cp, 2)[::-1] * MOLAR_GAS_CONSTANT
    return float(1.0 / moles.sum()), *map(float, terms)


def _ring(deck: DeckText, table, shape: BagShape, number: int) -> list[tuple]:
    """Nodes and vectors of a ring of jets in the mouth, and a card for each hole."""
    jets, axis = table.jets, shape.mouth_axis
    side = shape.azimuths_from
    if side is None:
        mouth = shape.surface.triangles[shape.surface.triangles_of_kind("mouth")]
        side = start_of_rim(mouth, shape.positions, axis)
    side = side - (side @ axis) * axis
    u = side / np.linalg.norm(side)
    v = np.cross(axis, u)
    around = math.radians(jets.azimuth) + 2.0 * np.pi * np.arange(jets.count) / jets.count
    out = np.cos(around)[:, None] * u + np.sin(around)[:, None] * v
    radius = ring_radius(jets, shape.surface.triangles_of_kind("mouth"), shape)
    first = deck.node_block(shape.mouth_centre + radius * out)
    tilt = math.radians(jets.angle)
    deck.keyword("DEFINE_VECTOR")
    for k, arm in enumerate(out, 1):
        deck.card(first + k, 0.0, 0.0, 0.0, *(float(x) for x in np.sin(tilt) * arm + np.cos(tilt) * axis))
    area = 0.25 * math.pi * jets.hole_diameter**2
    return [(first + k, deck.of(area, "area"), first + k, jets.cone, number) for k in range(1, jets.count + 1)]
