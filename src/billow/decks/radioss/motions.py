"""/IMPDISP, /IMPVEL and /IMPACC as motions of obstacles and nodes, and /INIVEL as motion at the start."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from billow.decks.cards import Field
from billow.decks.context import Context
from billow.decks.motions import Motion, Motions, integrated
from billow.decks.radioss.columns import card
from billow.decks.radioss.starter_file import kind_of, words
from billow.decks.velocities import Launch, Velocities

KINDS = {"IMPDISP": ("travel", "length"), "IMPVEL": ("speed", "velocity"), "IMPACC": ("speed", "acceleration")}
"""Keyword -> kind of motion in a case, and dimension of its function."""


def motions_of(context: Context) -> Motions:
    """All motions along an axis that can be read; the others are refused in the report."""
    model, found = context.model, Motions({}, [])
    for keyword in KINDS:
        for block in model.find(keyword):
            if not kind_of(block).isdecimal():
                model.used.discard(block.name)
                continue
            own, cards = replace(context, units=model.deck.units_of(block)), model.cards(block)
            f = card(own, cards, keyword, "motion")
            f |= card(own, cards, keyword, "scales", optional=True)
            motion = _motion(own, keyword, f)
            if motion is not None:
                found.nodes.append((model.group(f["grnd_ID"].whole, f["grnd_ID"]), motion))
    return found


def _motion(context: Context, keyword: str, f: dict[str, Field]) -> Motion | None:
    report, (kind, dimension) = context.report, KINDS[keyword]
    stop = context.si(f["Tstop"], "time")
    for name, is_there, why in (
        ("Dir", f["Dir"].text.upper() not in ("X", "Y", "Z"), "a rotation: what a case moves goes along a line"),
        ("skew_ID", f["skew_ID"].whole != 0, "a direction of a skew: give it along X, Y or Z"),
        ("frame_ID", f["frame_ID"].whole != 0, "a direction of a frame: give it along X, Y or Z"),
        ("sens_ID", f["sens_ID"].whole != 0, "a sensor: let the function begin later"),
        ("Tstart", f["Tstart"].number > 0.0, "free until then: let the function begin later"),
        ("Tstop", 0.0 < stop < context.end, "free from then on: a case moves it by its function"),
    ):
        if is_there:
            report.refused(f[name], why)
            return None
    curve = context.curve(f["fct_IDT"], "time", dimension, "a motion")
    points = np.column_stack([curve["time"], curve["value"]])
    points *= [f["Ascale_x"].number or 1.0, f["Fscale_y"].number or 1.0]
    report.mapped(f["Ascale_x"], f["Ascale_x"].number or 1.0, "nodes.motion")
    report.mapped(f["Fscale_y"], f["Fscale_y"].number or 1.0, "nodes.motion")
    axis = np.eye(3)["XYZ".index(f["Dir"].text.upper())]
    blank = replace(f["Tstop"], text="")
    named = {"TYPEID": f["grnd_ID"], "DOF": f["Dir"], "LCID": f["fct_IDT"], "DEATH": blank}
    if dimension == "acceleration":
        points, off = integrated(points)
        report.remarks.append(f"{f['fct_IDT'].place}: the integral of the function; speeds off by up to {off:.2g} m/s")
    return Motion(named, kind, axis, points)


def velocities_of(context: Context) -> Velocities:
    """All /INIVEL that can be read."""
    model, found = context.model, Velocities()
    for block in model.find("INIVEL"):
        kind = f"INIVEL/{kind_of(block)}"
        if kind not in ("INIVEL/TRA", "INIVEL/AXIS") or len(words(block)) < 3:
            model.used.discard(block.name)
            continue
        own, cards = replace(context, units=model.deck.units_of(block)), model.cards(block)
        f = card(own, cards, kind, "velocity") if kind == "INIVEL/TRA" else card(own, cards, kind, "axis")
        f |= card(own, cards, kind, "velocity") if kind == "INIVEL/AXIS" else {}
        f |= card(own, cards, kind, "start", optional=True)
        local = f.get("skew_ID") or f["frame_ID"]
        if local.whole:
            context.report.refused(local, "velocities of a skew or a frame: give them along the axes of the deck")
        elif f["Tstart"].number > 0.0 or f["sens_ID"].whole:
            context.report.refused(f["Tstart"], "velocities that come later: a case has those of the start")
        else:
            launch = _launch(own, f)
            found.launches += [launch] if launch else []
    return found


def _launch(context: Context, f: dict[str, Field]) -> Launch | None:
    one, zero, spin = f["grnd_ID"], np.zeros(3), np.zeros(3)
    names = ("Vx", "Vy", "Vz") if "Vx" in f else ("Vxt", "Vyt", "Vzt")
    says = [(f[name], "velocity") for name in names]
    if "Vr" in f:
        way = f["Dir"].text.upper()
        if way not in ("X", "Y", "Z"):
            context.report.refused(f["Dir"], "the axis of a rotation is X, Y or Z")
            return None
        spin["XYZ".index(way)] = context.si(f["Vr"], "frequency")
        says += [(f["Vr"], "spin"), (f["Dir"], "spin")]
    velocity = np.array([context.si(f[name], "velocity") for name in names])
    return Launch(context.model.group(one.whole, one), velocity, spin, zero, one, says)
