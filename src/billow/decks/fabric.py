"""*MAT_FABRIC as the `[fabric]` and `[leakage]` tables.

PRBA is the minor ratio: poisson = PRBA EA / EB (symmetry of the compliance). What FORM 4 and 14 measure is not said in
a deck: `measure` names it, and curves are turned into true strain against true stress at constant width, where a
nominal stress is the true stress, and S of Green strain becomes S times the stretch (docs/theory.md, Curve laws).
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from billow.decks.block import Block
from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.draft import said

MEASURES = ("true", "engineering", "green")
LAWS = {0: "linear", 1: "linear", 2: "linear", 3: "linear", 12: "linear", 13: "linear"}
LAWS |= {4: "curves", 14: "curves-shear", -14: "curves-shear", 24: "curves-shear"}
OWN = ("RO", "EA", "EB", "PRBA", "PRAB", "GAB", "CSE", "EL", "PRL", "LRATIO", "DAMP", "FORM", "TCOAT")
CURVES = ("LCA", "LCB", "LCAB", "LCUA", "LCUB", "LCUAB")
"""Fields of *MAT_FABRIC that say what the fabric is: numbers, and ids of curves."""
LEAKS = {1: "wang-nefske", 2: "wang-nefske", 3: "graefe", 4: "graefe", 5: "porous-medium", 6: "porous-medium"}
LEAKS |= {7: "velocity-curve", 8: "velocity-curve"}


def fabric_cards(context: Context, block: Block) -> dict[str, Field]:
    """All fields of a *MAT_FABRIC by name."""
    cards = context.cards(block)
    found: dict[str, Field] = {}
    for card in ("elastic", "shear", "leakage"):
        found |= context.card(cards, card, optional=card == "leakage")
    form = found["FORM"].whole
    # A negative FVOPT brings a card of yarns in newer releases: cards beyond all that older ones have tell.
    older = 2 + (form in (4, 14, -14, 24)) + (form == -14)
    if found["FVOPT"].whole < 0 and cards.left > older:
        found |= context.card(cards, "yarns")
    for card in ("axes", "vector"):
        found |= context.card(cards, card, optional=True)
    if form in (4, 14, -14, 24):
        found |= context.card(cards, "curves")
    if form in (-14, 24):
        found |= context.card(cards, "more curves", optional=True)
    return found


def same_fabric(context: Context, f: dict[str, Field], g: dict[str, Field]) -> bool:
    """Whether two materials differ in nothing but number, leakage and axes, which a case has by part anyway."""
    if any(f[name].number != g[name].number for name in OWN if name in f and name in g):
        return False
    curves = [
        [context.model.curve(h[name]).points if h[name].whole else np.empty((0, 2)) for name in CURVES if name in h]
        for h in (f, g)
    ]
    return len(curves[0]) == len(curves[1]) and all(map(np.array_equal, *curves))


def added_leakage(context: Context, f: dict[str, Field]) -> dict[str, Field]:
    """The fields with those of *MAT_ADD_AIRBAG_POROSITY_LEAKAGE of the same material, which count instead."""
    for block in context.model.deck.all("MAT_ADD_AIRBAG_POROSITY_LEAKAGE"):
        number = context.cards(block).optional("leakage", "MID")["MID"]
        if number.whole == f["MID"].whole:
            own = context.card(context.cards(block), "leakage")
            context.report.mapped(own["MID"], own["MID"].text, "leakage")
            for name in ("FLC", "FAC", "ELA", "FVOPT", "X0", "X1"):
                if f[name].number:
                    context.report.ignored(f[name], f"*{block.name} counts instead")
            return f | own
    return f


def put_fabric(context: Context, f: dict[str, Field], measure: str, key: str = "fabric") -> None:
    """The `[fabric]` table, or that of a part, key."""
    report = context.report
    report.mapped(f["MID"], f["MID"].text, key)
    context.put(f"{key}.density", f["RO"], "density")
    form = f["FORM"].whole
    law = LAWS.get(form)
    if law is None:
        law = "linear"
        report.refused(f["FORM"], f"FORM {form} has no counterpart; the moduli are used, as with FORM 0")
    elif form in (0, 1, 3, 13):
        report.approximated(f["FORM"], "linear in Green strain; the forms differ at large strain and shear", law)
    else:
        report.mapped(f["FORM"], law)
    context.set(f"{key}.law", law, f["FORM"])
    for name, least in (("EA", 0.0), ("EB", -1e-300)):
        if not f[name].number > least:
            raise f[name].bad("fabric has a modulus")
    warp = context.put(f"{key}.young_warp", f["EA"], "pressure")
    weft = warp
    if f["EB"].number:
        weft = context.put(f"{key}.young_weft", f["EB"], "pressure")
    else:
        context.set(f"{key}.young_weft", warp, f["EA"])
        report.mapped(f["EB"], warp, f"{key}.young_weft", "blank: as EA")
    _poisson(context, f, warp, weft, key)
    if f["GAB"].number:
        context.put(f"{key}.shear", f["GAB"], "pressure")
    else:
        shear = warp / (2.0 * (1.0 + f["PRBA"].number))
        context.set(f"{key}.shear", shear, f["EA"])
        report.approximated(f["GAB"], "blank: that of an isotropic sheet", shear)
    no_compression = f["CSE"].number == 1.0
    context.set(f"{key}.compression", not no_compression and not f["LRATIO"].number, f["CSE"])
    report.mapped(f["CSE"], "false" if no_compression else "true")
    if f["DAMP"].number:
        value = min(f["DAMP"].number, 0.5)
        context.set(f"{key}.damping", value, f["DAMP"])
        report.approximated(f["DAMP"], "both are fractions of critical, of an element's highest mode in Billow", value)
    else:
        report.approximated(f["DAMP"], "blank or zero: Billow's own, 0.05 of critical in the highest mode", 0.05)
    _liner(context, f, law, key)
    _coating(context, f)
    if law != "linear":
        _curves(context, f, measure, key)
    for one in f.values():  # rows name keys of the general fabric
        row = report.rows.get((one.shown, one.place))
        if row and key != "fabric" and row.key.startswith("fabric.") and not row.key.startswith(key):
            report.rows[one.shown, one.place] = replace(row, key=key + row.key.removeprefix("fabric"))
    if f["RGBRTH"].number:
        birth_time(context, f["RGBRTH"])


def birth_time(context: Context, one: Field) -> None:
    """`bag.birth_time`: until then the start is the reference in a deck; in a case it moves to the flat cut."""
    value = context.si(one, "time")
    context.set("bag.birth_time", value, one)
    how = "until then a deck measures strain from the start; in a case the reference moves to the flat cut meanwhile"
    context.report.approximated(one, how, value, "bag.birth_time")


def _poisson(context: Context, f: dict[str, Field], warp: float, weft: float, key: str) -> None:
    """poisson: contraction along the weft under load along the warp, nu_ab = PRBA EA / EB = PRAB."""
    minor, major, report = f["PRBA"], f["PRAB"], context.report
    value = minor.number * warp / weft if minor.number else major.number
    if major.number and math.isclose(value, major.number, rel_tol=1e-6):
        value = major.number
    largest = 0.99 * min(0.49, (warp / weft) ** 0.5)
    if not 0.0 <= value <= largest:
        clipped = min(max(value, 0.0), largest)
        report.approximated(minor, f"{value:.4g} would be unstable: {clipped:.4g} is used", clipped)
        context.set(f"{key}.poisson", clipped, minor)
        return
    context.set(f"{key}.poisson", value, minor if minor.number else major)
    report.mapped(minor, value, note="PRBA EA / EB" if minor.number else "")
    if major.number:
        off = abs(major.number - value) > 0.02
        report.mapped(major, value, note=f"it differs from PRBA EA / EB, {value:.4g}, which is used" if off else "")


def _liner(context: Context, f: dict[str, Field], law: str, key: str) -> None:
    ratio, report = f["LRATIO"], context.report
    if not ratio.number or not f["EL"].number:
        return
    if law != "linear":
        for name in ("EL", "PRL", "LRATIO"):
            report.refused(f[name], "laws of curves have no liner; FORM 0 has, or leave it out")
        return
    context.put(f"{key}.liner.ratio", ratio, "-")
    context.put(f"{key}.liner.young", f["EL"], "pressure")
    context.put(f"{key}.liner.poisson", f["PRL"], "-")


def _coating(context: Context, f: dict[str, Field]) -> None:
    if "TCOAT" in f and f["TCOAT"].number:
        for name in ("TCOAT", "ECOAT", "SCOAT"):
            context.report.refused(f[name], "a coating that stiffens; a case has a liner for the linear law only")


def _curves(context: Context, f: dict[str, Field], measure: str, key: str) -> None:
    context.set(f"{key}.curves.transverse", 0.0, "curves of one direction, at constant width")
    for name, loading, unloading in (("warp", "LCA", "LCUA"), ("weft", "LCB", "LCUB"), ("shear", "LCAB", "LCUAB")):
        if not f[loading].whole:
            _line(context, f, loading, f"{key}.curves.{name}")
            continue
        _curve(context, f[loading], f"{key}.curves.{name}", "loading", measure)
        if f[unloading].whole:
            _curve(context, f[unloading], f"{key}.curves.{name}", "unloading", measure)
    for name in ("LCAA", "LCBB"):
        if name in f and f[name].whole:
            context.report.refused(f[name], "curves of coupled stress have no counterpart; they are left out")


def _file(key: str, branch: str) -> str:
    """CSV file of a curve; key: fabric.curves.warp, fabric.parts.front.curves.warp."""
    *_, name = key.split(".")
    part = key.split(".")[2] + "_" if ".parts." in key else ""
    return f"curves/{part}{name}_{branch}.csv"


def _line(context: Context, f: dict[str, Field], loading: str, key: str) -> None:
    """Without a curve the modulus counts: a straight line, to 10 %."""
    name = key.rpartition(".")[2]
    modulus = f[{"warp": "EA", "weft": "EB", "shear": "GAB"}[name]]
    slope = context.si(modulus, "pressure")
    if not slope > 0.0:
        raise modulus.bad(f"{loading} names no curve, so a modulus is needed")
    end = np.degrees(0.1) if name == "shear" else 0.1
    file = _file(key, "loading")
    head = "angle [deg]" if name == "shear" else "strain [-]"
    context.curves[file] = f"{head}, stress [Pa]\n0, 0\n{float(end)!r}, {0.1 * slope!r}\n"
    context.set(f"{key}.loading", file, modulus)
    context.report.mapped(f[loading], file, note=f"blank: a straight line of {modulus.name}")


def _curve(context: Context, one: Field, key: str, branch: str, measure: str) -> None:
    """Strain against stress into a CSV file, from zero on."""
    points, _, number = context.points(one, "-", "pressure")
    strain, stress = points[:, 0], points[:, 1]
    kept = strain >= 0.0
    note = "" if kept.all() else f"{(~kept).sum()} points of compression left out; "
    strain, stress = strain[kept], stress[kept]
    if not len(strain) or strain[0] > 0.0:
        strain, stress = np.append(0.0, strain), np.append(0.0, stress)
    head = "strain [-]"
    if key.endswith("shear"):
        strain, head = np.degrees(strain), "angle [deg]"
        note += "shear strain is taken as the angle in radians"
    elif measure == "engineering":
        strain = np.log1p(strain)
        note += "as nominal stress against engineering strain"
    elif measure == "green":
        stress = stress * np.sqrt(1.0 + 2.0 * strain)
        strain = 0.5 * np.log1p(2.0 * strain)
        note += "as second Piola-Kirchhoff stress against Green strain"
    else:
        note += "as true stress against true strain"
    file = _file(key, branch)
    rows = "".join(f"{x!r}, {y!r}\n" for x, y in zip(strain.tolist(), stress.tolist(), strict=True))
    context.curves[file] = f"{head}, stress [Pa]\n{rows}"
    context.set(f"{key}.{branch}", file, one)
    context.report.approximated(one, f"curve {number}: {note}; a deck does not say which, see --fabric-curves", file)


def leakage(context: Context, f: dict[str, Field], option: int) -> dict[str, object] | None:
    """The `[leakage]` table of a fabric, None if it does not leak. option: OPT of the airbag, which counts where FVOPT
    is blank."""
    report, fvopt = context.report, f["FVOPT"].whole or option
    law = LEAKS.get(abs(fvopt))
    if not any(f[name].number for name in (("FLC", "FAC", "X0", "X1") if fvopt < 0 else ("FLC", "FAC"))):
        return None
    if law is None:
        for name in ("FLC", "FAC"):
            report.ignored(f[name], "FVOPT and OPT are 0: the airbag's own cards say how the fabric leaks")
        return None
    report.mapped(f["FVOPT"], law)
    table: dict[str, object] = {"law": said(law, f["FVOPT"])}
    if fvopt > 0:
        table["time_factor"] = _factor(context, f["FLC"], "time", "-")
        unit = {"porous-medium": "per velocity", "velocity-curve": "velocity"}.get(law, "-")
        table["pressure_factor"] = _factor(context, f["FAC"], "pressure", unit)
    if fvopt % 2 == 0:
        table["blockage"] = said(True, f["FVOPT"])
        if f["ELA"].number < 0.0:
            report.refused(f["ELA"], "a curve of the effective area has no counterpart: through_blocked is 0")
        else:
            table["through_blocked"] = said(min(f["ELA"].number, 1.0), f["ELA"])
            report.mapped(f["ELA"], min(f["ELA"].number, 1.0))
    if fvopt > 0:
        table["area"] = said("deformed", f["FVOPT"])
        return table
    # A negative FVOPT takes the area of Anagonye and Wang, and FLC and FAC are X2 and X3.
    for name in ("L", "R", "C1", "C2", "C3"):
        if name in f and f[name].number:
            report.refused(f[name], "an area of gaps between yarns has no counterpart: that of X0 to X3 is used")
    if law not in ("wang-nefske", "graefe"):
        report.refused(f["FVOPT"], "the area of Anagonye and Wang leaves no field for the law's own factor")
    terms = [f[name].number for name in ("X0", "X1", "FLC", "FAC")]
    table |= {"area": said(terms, f["X0"]), "time_factor": said(1.0, f["FVOPT"])}
    table["pressure_factor"] = said(1.0, f["FVOPT"])
    for name, value in zip(("X0", "X1", "FLC", "FAC"), terms, strict=True):
        report.mapped(f[name], value, "leakage.area")
    if f["A0REF"].number == 1.0:
        report.mapped(f["A0REF"], "as cut", "leakage.area")
    else:
        report.approximated(f["A0REF"], "terms are on the area as cut, not on that at the start", key="leakage.area")
    return table


def _factor(context: Context, one: Field, axis: str, dimension: str):
    """A number, or a curve if it is negative."""
    if one.number < 0.0:
        curve = context.curve(one, axis, dimension, "leakage.pressure_factor", axis)
        context.report.mapped(one, f"curve {abs(one.whole)}")
        return said(curve, one)
    value = context.si(one, dimension)
    context.report.mapped(one, value)
    return said(value, one)
