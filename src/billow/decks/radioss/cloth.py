"""LAW19 and LAW58 as the `[fabric]` table, and what properties of shells say: thickness and warp."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np

from billow.decks.bag_mesh import BagMesh
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.radioss.columns import CARDS, TARGETS, card
from billow.decks.radioss.starter_model import StarterModel
from billow.decks.shared_tables import NO_AIRBAG, Options
from billow.decks.warp import put_warp

WEAK = 0.01
"""Share of the stiffness under compression up to which fabric bears none in a case."""


def put_cloth(context: Context, bag: BagMesh, place: str, options: Options, base: dict[str, Any]) -> None:
    model: StarterModel = context.model
    cloth = [number for number, table in bag.parts.items() if table["kind"] == "fabric"]
    found: dict[int, tuple[str, dict[str, Field], Context]] = {}
    for number in cloth:
        law = model.law_of(number)
        if law and f"MAT/{law[0]}" in CARDS:
            own = replace(context, units=model.deck.units_of(law[1]))
            found[number] = law[0], _fields(own, *law), own
    if not found:
        if "fabric" not in base:
            raise NO_AIRBAG(what="what the fabric is", place=place, why="no part of the bag has LAW19 or LAW58")
        return
    fabrics = _fabrics(context, bag, found)
    keys = {n: "fabric" if members is fabrics[0] else f"fabric.parts.{bag.parts[n]['name']}"
            for members in fabrics for n in members}  # fmt: skip
    done: set[str] = set()
    for number in (n for members in fabrics for n in members):
        (law, f, own), key = found[number], keys[number]
        if key in done:
            for one in f.values():
                if not context.report.settled(one):
                    context.report.mapped(one, key=key, note="as the fabric of the bag")
        else:
            (_law19 if law == "LAW19" else _law58)(own, f, key, options.measure)
        done.add(key)
    _thickness(context, bag, {n: keys.get(n, "fabric") for n in cloth}, place, base)
    fields = {}
    for number in cloth:
        p = model.properties.get(model.parts[number].section, {})
        if "Vx" in p and any(p[name].number for name in ("Vx", "Vy", "Vz")):
            fields[number] = {"A1": p["Vx"], "A2": p["Vy"], "A3": p["Vz"], "BETA": p.get("Phi", p["Vx"])}
    put_warp(context, bag, fields)
    for p in model.properties.values():
        context.report.take(p.values())


def _fabrics(
    context: Context, bag: BagMesh, found: dict[int, tuple[str, dict[str, Field], Context]]
) -> list[list[int]]:
    """Parts of the same fabric together, the fabric of most shells first."""
    groups: list[list[int]] = []
    for number, (law, f, own) in found.items():
        for members in groups:
            other, g, of_other = found[members[0]]
            same = law == other and own.units == of_other.units
            if same and all(f[name].number == g[name].number for name in f):
                members.append(number)
                break
        else:
            groups.append([number])
    groups.sort(key=lambda members: -int(np.isin(bag.start.part, members).sum()))
    if len(groups) > 1:
        names = "; ".join(", ".join(bag.parts[n]["name"] for n in members) for members in groups)
        context.report.remarks.append(f"{len(groups)} fabrics, of parts {names}: the first is [fabric]")
    return groups


def _fields(context: Context, law: str, block) -> dict[str, Field]:
    cards, key = context.model.cards(block), f"MAT/{law}"
    needed = ("density", "moduli", "shear")
    found: dict[str, Field] = {}
    for name in CARDS[key]:
        found |= card(context, cards, key, name, optional=name not in needed)
    return found


def _put(context: Context, key: str, one: Field, dimension: str, value: float | None = None) -> float:
    value = context.si(one, dimension) if value is None else value
    context.set(key, value, one)
    context.report.mapped(one, value, key)
    return value


def _law19(context: Context, f: dict[str, Field], table: str, measure: str) -> None:
    """Linear orthotropic: nu12 is the contraction along 2 under load along 1, as in a case."""
    report = context.report
    _modulus(f["E11"], f["E22"], f["G12"])
    _put(context, f"{table}.density", f["rho_i"], "density")
    context.set(f"{table}.law", "linear", f["E11"])
    warp = _put(context, f"{table}.young_warp", f["E11"], "pressure")
    weft = _put(context, f"{table}.young_weft", f["E22"], "pressure")
    how = "linear in Green strain, which is 2.5 % more than engineering strain where that is 5 %"
    for name, value in (("E11", warp), ("E22", weft)):
        report.approximated(f[name], how, value, _key(TARGETS[name], table))
    largest = 0.99 * min(0.49, (warp / weft) ** 0.5)
    if not 0.0 <= f["nu12"].number <= largest:
        report.approximated(f["nu12"], f"outside 0 to {largest:.4g}, which is used", largest, f"{table}.poisson")
        context.set(f"{table}.poisson", largest, f["nu12"])
    else:
        _put(context, f"{table}.poisson", f["nu12"], "-")
    _put(context, f"{table}.shear", f["G12"], "pressure")
    for name in ("G23", "G31"):
        report.ignored(f[name], "a membrane has no transverse shear")
    share = f["R_E"].number or 1.0
    context.set(f"{table}.compression", share > WEAK, f["R_E"])
    if share in (1.0,):
        report.mapped(f["R_E"], "true", f"{table}.compression")
    else:
        bears = "all of its stiffness" if share > WEAK else "no compression"
        report.approximated(
            f["R_E"], f"fabric of a case bears {bears}, not {share:g} of it", key=f"{table}.compression"
        )
    if f["Fscale_Por"].number:
        report.ignored(f["Fscale_Por"], "porosity of inner walls of another gas")
    _start(context, f)


def _law58(context: Context, f: dict[str, Field], table: str, measure: str) -> None:
    """Yarns that do not feel each other: curves of each direction, or straight lines of E1, E2 and G0."""
    report = context.report
    _modulus(f["E1"], f["E2"])
    _put(context, f"{table}.density", f["rho_i"], "density")
    context.set(f"{table}.law", "curves-shear", f["E1"])
    _put(context, f"{table}.young_warp", f["E1"], "pressure")
    _put(context, f"{table}.young_weft", f["E2"], "pressure")
    shear = context.si(f["G0"], "pressure") or 0.25 * sum(context.si(f[name], "pressure") for name in ("E1", "E2"))
    context.set(f"{table}.shear", shear, f["G0"])
    report.mapped(f["G0"], shear, f"{table}.shear", "" if f["G0"].number else "blank: a quarter of E1 + E2")
    context.set(f"{table}.compression", False, f["Flex"])
    context.set(f"{table}.curves.transverse", 0.0, "curves of one direction, at constant width")
    report.approximated(f["Flex"], "fabric bears no compression; the deck: that share of its stiffness")
    for name in ("S1", "S2", "N1", "N2"):
        report.approximated(f[name], "warp and weft do not feel each other's crimp")
    for name in ("B1", "B2"):
        if f[name].number:
            report.refused(f[name], "a modulus that falls with strain: give functions, fct_ID1 and fct_ID2")
    for name in ("GT", "AlphaT"):
        if f[name].number:
            report.refused(f[name], "shear that locks at an angle: give a function, fct_ID3")
    for name in ("Df", "Ds", "Gfrot"):
        if f[name].number:
            report.approximated(f[name], "Billow's own damping, 0.05 of critical in the highest mode")
    for name, loading, unloading, modulus in (
        ("warp", "1", "4", f["E1"]), ("weft", "2", "5", f["E2"]), ("shear", "3", "6", f["G0"]),
    ):  # fmt: skip
        for branch, k in (("loading", loading), ("unloading", unloading)):
            one, scale = f[f"fct_ID{k}"], f[f"Fscale{k}"].number or 1.0
            if one.whole:
                _curve(context, one, scale, name, branch, measure, table)
            elif branch == "loading":
                slope = shear if name == "shear" else context.si(modulus, "pressure")
                _line(context, slope, name, one, modulus, table)
    _start(context, f)


def _modulus(*moduli: Field) -> None:
    for one in moduli:
        if not one.number > 0.0:
            raise one.bad("fabric has a modulus")


def _start(context: Context, f: dict[str, Field]) -> None:
    if f["ZeroStress"].number:
        how = "strain of the start against the flat cut would be taken out; bag.birth_time brings it in slowly"
        context.report.refused(f["ZeroStress"], how)
    if f["sens_ID"].whole:
        context.report.refused(f["sens_ID"], "a sensor that brings the flat cut in: set bag.birth_time")


def _key(target: str, table: str) -> str:
    """A key of the general fabric as that of a table."""
    return table + target.removeprefix("fabric")


def _file(table: str, name: str, branch: str) -> str:
    part = "" if table == "fabric" else f"{table.rpartition('.')[2]}_"
    return f"curves/{part}{name}_{branch}.csv"


def _curve(context: Context, one: Field, scale: float, name: str, branch: str, measure: str, table: str) -> None:
    points, _, number = context.points(one, "-", "pressure")
    kept = points[points[:, 0] >= 0.0]
    if not len(kept) or kept[0, 0] > 0.0:
        kept = np.concatenate([[[0.0, 0.0]], kept])
    strain, stress, head = kept[:, 0], scale * kept[:, 1], "strain [-]"
    if name == "shear":
        head, note = "angle [deg]", "taken as the angle in degrees"
    elif measure == "engineering":
        strain, note = np.log1p(strain), "as nominal stress against engineering strain"
    elif measure == "green":
        stress = stress * np.sqrt(1.0 + 2.0 * strain)
        strain, note = 0.5 * np.log1p(2.0 * strain), "as second Piola-Kirchhoff stress against Green strain"
    else:
        note = "as true stress against true strain"
    file = _file(table, name, branch)
    rows = "".join(f"{x!r}, {y!r}\n" for x, y in zip(strain.tolist(), stress.tolist(), strict=True))
    context.curves[file] = f"{head}, stress [Pa]\n{rows}"
    context.set(f"{table}.curves.{name}.{branch}", file, one)
    how = f"function {number}: {note}; see --fabric-curves"
    context.report.approximated(one, how, file, _key(TARGETS[one.name], table))


def _line(context: Context, slope: float, name: str, one: Field, modulus: Field, table: str) -> None:
    """Without a function the modulus counts: a straight line, to 10 %."""
    end = math.degrees(0.1) if name == "shear" else 0.1
    head = "angle [deg]" if name == "shear" else "strain [-]"
    file = _file(table, name, "loading")
    context.curves[file] = f"{head}, stress [Pa]\n0, 0\n{end!r}, {0.1 * slope!r}\n"
    context.set(f"{table}.curves.{name}.loading", file, modulus)
    context.report.mapped(one, file, _key(TARGETS[one.name], table), f"blank: a straight line of {modulus.name}")


def _thickness(context: Context, bag: BagMesh, keys: dict[int, str], place: str, base: dict[str, Any]) -> None:
    """Of shells if they say it, else of their property; layers are counted from the thinnest part of a fabric on. keys:
    the table of each part of fabric."""
    model, thick = context.model, {}
    for number, key in keys.items():
        own = model.shells.thickness[bag.shell[(bag.shell >= 0) & (bag.start.part == number)]]
        section = model.thicknesses.get(model.parts[number].section)
        source = section[2] if section else f"part {number}"
        value = float(own.mean()) if len(own) and (own > 0.0).all() else section[0] if section else 0.0
        if value:
            thick[number] = value * context.units.length, source
            if section:
                context.report.mapped(section[2], thick[number][0], f"{key}.thickness")
    if not thick and "thickness" not in base.get("fabric", {}):
        raise NO_AIRBAG(what="how thick the fabric is", place=place, why="its parts have no /PROP that is read")
    for key in dict.fromkeys(keys.values()):
        mine = {number: pair for number, pair in thick.items() if keys[number] == key}
        if not mine:
            continue
        least, source = min(mine.values(), key=lambda pair: pair[0])
        context.set(f"{key}.thickness", least, source)
        for number, (value, _) in mine.items():
            if not math.isclose(value, least, rel_tol=1e-9):
                bag.parts[number]["layers"] = value / least
