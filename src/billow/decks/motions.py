"""*BOUNDARY_PRESCRIBED_MOTION, moving walls and guided rigid parts as the `motion` of an obstacle.

A case moves an obstacle along a line. Motions along several axes are one line where they share a curve; a motion by a
curve of zeros holds the part along its axis. Speed and travel are piecewise linear in both; an acceleration becomes a
curve of speed, which is exact where the acceleration is constant between its points.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from billow.decks.cards import Cards, Field
from billow.decks.context import Context
from billow.decks.draft import said

KINDS = {0: ("speed", "velocity"), 1: ("speed", "acceleration"), 2: ("travel", "length")}
"""VAD -> kind of motion in a case, and dimension of the curve."""
SHARE = 1e-4
"""Of the largest speed, by which the speed between points of a curve may be off its integral."""
MOST_POINTS = 1000


@dataclass
class Motion:
    """One card. f: its fields, under the names that cards of LS-DYNA have. kind: of KINDS. axis: unit vector, (3,).
    points: (n, 2), SI, scaled; of speed or travel. is_alone: whether nothing moves across the axis."""

    f: dict[str, Field]
    kind: str
    axis: np.ndarray
    points: np.ndarray
    is_alone: bool = False

    @property
    def is_nothing(self) -> bool:
        return not self.points[:, 1].any()


@dataclass
class Motions:
    """Of rigid parts and of nodes, by number of the part or the node; held: directions in which parts are held by a
    curve of zeros."""

    parts: dict[int, list[Motion]]
    nodes: list[tuple[np.ndarray, Motion]]

    def of_part(self, part: int, ids: np.ndarray) -> list[Motion]:
        """Motions of a rigid part with nodes ids, those of its nodes too: a rigid part has no others."""
        of_nodes = [motion for nodes, motion in self.nodes if np.isin(nodes, ids).any()]
        return self.parts.pop(part, []) + of_nodes

    def rest(self, context: Context) -> None:
        """Say what no obstacle took."""
        for motions in self.parts.values():
            for motion in motions:
                context.report.refused(motion.f["TYPEID"], "a motion of no rigid part that is an obstacle")
        for _, motion in self.nodes:
            if not context.report.settled(motion.f["TYPEID"]):
                context.report.ignored(motion.f["TYPEID"], "none of its nodes belongs to the bag or to an obstacle")


def motions_of(context: Context) -> Motions:
    """All *BOUNDARY_PRESCRIBED_MOTION that can be read; the others are refused in the report."""
    found = Motions({}, [])
    for block in context.model.all("BOUNDARY_PRESCRIBED_MOTION"):
        cards, has_id = Cards(context.model.deck.parameters, block), "_ID" in block.name
        while cards.left:
            if has_id:
                cards.text()
                if not cards.left:
                    break
            f = context.card(cards, "motion")
            if abs(f["DOF"].whole) in (9, 10, 11) or f["VAD"].whole == 4:
                context.card(cards, "offset", optional=True)
            motion = _motion(context, f, "LOCAL" in block.name, "obstacles" if "RIGID" in block.name else "nodes")
            if motion is None:
                continue
            one = f["TYPEID"]
            if "RIGID" in block.name:
                found.parts.setdefault(one.whole, []).append(motion)
            else:
                is_set = "SET" in block.name
                ids = context.model.set_of("NODE", one.whole, one.shown, one.place) if is_set else [one.whole]
                found.nodes.append((np.asarray(ids), motion))
    return found


def _motion(context: Context, f: dict[str, Field], is_local: bool, of: str) -> Motion | None:
    """of: the table of a case that a motion belongs to, as far as its keyword says."""
    report, kind, dof = context.report, KINDS.get(f["VAD"].whole), f["DOF"].whole
    if kind is None:
        report.refused(f["VAD"], "a motion relative to another body, or against displacement: give it against time")
        return None
    if dof in (5, 6, 7) or abs(dof) == 8:
        if not context.points(f["LCID"], "time", "-")[0][:, 1].any():
            report.mapped(f["DOF"], "does not turn", f"{of}.motion")
            report.mapped(f["TYPEID"], f["TYPEID"].whole, f"{of}.motion")
        else:
            report.refused(f["DOF"], "a rotation that is prescribed: obstacles of a case move along a line")
        return None
    if is_local:
        report.refused(f["DOF"], "an axis of the body's own: give it by DOF = 4 and a vector")
        return None
    if dof in (1, 2, 3):
        axis = np.eye(3)[dof - 1]
    elif abs(dof) == 4:
        axis = context.vector(f["VID"].whole)
        if not np.linalg.norm(axis) > 0.0:
            raise f["VID"].bad("no *DEFINE_VECTOR of that number has a length")
        axis = axis / np.linalg.norm(axis)
        report.mapped(f["VID"], str(axis.round(6).tolist()), f"{of}.motion.direction")
    else:
        report.refused(f["DOF"], "a motion of this kind has no counterpart: 1, 2, 3 and 4 are directions of a line")
        return None
    curve = context.curve(f["LCID"], "time", kind[1], "a prescribed motion")
    points = np.column_stack([curve["time"], curve["value"]]) * [1.0, f["SF"].number or 1.0]
    report.mapped(f["SF"], f["SF"].number or 1.0, f"{of}.motion")
    begin = context.si(f["BIRTH"], "time")
    if begin > 0.0:
        points[:, 0] += begin
        report.approximated(f["BIRTH"], "the part rests until then, and its curve begins then", begin)
        if kind[0] == "speed" and points[0, 1]:
            points = np.concatenate([[[0.0, 0.0], [points[0, 0] - min(1e-6, 0.5 * begin), 0.0]], points])
    if f["VAD"].whole == 1:
        points, off = integrated(points)
        note = "its integral, exact" if not off else f"its integral, speeds off by up to {off:.2g} m/s"
        (report.approximated if off else report.mapped)(f["VAD"], note, f"{of}.motion.speed")
    else:
        report.mapped(f["VAD"], kind[0], f"{of}.motion.{kind[0]}")
    return Motion(f, kind[0], axis, points, dof == -4)


def integrated(points: np.ndarray) -> tuple[np.ndarray, float]:
    """Speed [m/s] from a piecewise linear acceleration, points of (time, m/s^2), at rest at its first point; and by how
    much the speed between the points returned is off at most [m/s], 0 if it is exact."""
    time, value = points.T
    spans = np.diff(time)
    speeds = np.append(0.0, np.cumsum(0.5 * (value[1:] + value[:-1]) * spans))
    # Between two points the speed is a parabola, a chord of which is off by |slope| h^2/8.
    bends = np.abs(np.diff(value)) * spans / 8.0
    allowed = SHARE * max(float(np.abs(speeds).max()), 1e-300)
    pieces = np.minimum(np.ceil(np.sqrt(bends / allowed)), MOST_POINTS).astype(int).clip(1)
    found = [(time[0], 0.0)]
    for k, count in enumerate(pieces.tolist()):
        for share in np.arange(1, count + 1) / count:
            t = share * spans[k]
            v = speeds[k] + value[k] * t + 0.5 * (value[k + 1] - value[k]) * share * t
            found.append((time[k] + t, v))
    return np.array(found), float((bends / pieces**2).max(initial=0.0))


def motion_table(context: Context, motions: list[Motion], end: float, rigid: dict[str, Any] | None) -> dict | None:
    """The `motion` of an obstacle from the motions of its part, None if it is held; end: of the run [s]. rigid: as
    `obstacles` reads *MAT_RIGID."""
    report = context.report
    held, moving = set(rigid["held"] if rigid else ""), [m for m in motions if not m.is_nothing]
    for motion in motions:
        one = motion.f
        held |= {"xyz"[int(np.argmax(np.abs(motion.axis)))]} if np.abs(motion.axis).max() > 0.999999 else set()
        held |= set("xyz") if motion.is_alone else set()
        report.mapped(one["TYPEID"], one["TYPEID"].whole, "obstacles.motion")
        require_no_death(context, one, end)
    if not moving:
        return None
    first = moving[0]
    line = np.zeros(3)
    for motion in moving:
        share = _share(first, motion)
        if share is None:
            why = "another curve than along the first axis: a case moves along a line"
            report.refused(motion.f["LCID"], f"{why}; the part moves by {first.f['LCID'].text} alone")
            continue
        line += share * motion.axis
        report.mapped(motion.f["LCID"], f"{len(motion.points)} points", f"obstacles.motion.{motion.kind}")
        turns = rigid is None or rigid["turns"]
        if not motion.is_alone and (held != set("xyz") or turns):
            free = "".join(sorted(set("xyz") - held)) or "no axis"
            why = f"along this line only; in the deck it is free along {free}" + (", and turns" if turns else "")
            report.approximated(motion.f["DOF"], why, str(motion.axis.round(6).tolist()), "obstacles.motion.direction")
        else:
            report.mapped(motion.f["DOF"], str(motion.axis.round(6).tolist()), "obstacles.motion.direction")
    return course_table(context, first, line, end, "obstacles")


def course_table(context: Context, motion: Motion, line: np.ndarray, end: float, of: str) -> dict | None:
    """The `motion` of a table of a case along a line, whose length is a factor on the curve; None if it is refused."""
    report, size = context.report, float(np.linalg.norm(line))
    time, value = motion.points[:, 0], motion.points[:, 1] * size
    if motion.kind == "travel" and value[0]:
        report.refused(motion.f["LCID"], f"it begins {value[0]:g} m away from the place of its mesh: place it there")
        return None
    if motion.kind == "speed" and value[-1] and time[-1] < end:
        why = f"its last speed, {value[-1]:.4g} m/s, is kept after its end at {time[-1]:g} s"
        report.approximated(motion.f["LCID"], why, f"{len(time)} points", f"{of}.motion.speed")
    return {
        "kind": motion.kind, "direction": said((line / size).tolist(), motion.f["DOF"]),
        motion.kind: said({"time": time.tolist(), "value": value.tolist()}, motion.f["LCID"]),
    }  # fmt: skip


def require_no_death(context: Context, f: dict[str, Field], end: float) -> None:
    """Refuse in the report a motion that ends before the run."""
    death = context.si(f["DEATH"], "time")
    if 0.0 < death < end:
        why = f"after {death:g} s it would be free; a case moves it on by its curve"
        context.report.refused(f["DEATH"], why)


def _share(first: Motion, other: Motion) -> float | None:
    """How many times the first's curve another's is, None if it is another curve."""
    if first.kind != other.kind or not np.array_equal(first.points[:, 0], other.points[:, 0]):
        return None
    a, b = first.points[:, 1], other.points[:, 1]
    k = int(np.abs(a).argmax())
    share = float(b[k] / a[k])
    return share if np.allclose(b, share * a, rtol=1e-12, atol=1e-12 * float(np.abs(b).max())) else None


def guide(rigid: dict[str, Any]) -> np.ndarray | None:
    """Axis (3,) along which a rigid part is free to move if it is held in all other ways, else None."""
    free = set("xyz") - set(rigid["held"])
    if rigid["turns"] or len(free) != 1:
        return None
    return np.eye(3)["xyz".index(free.pop())]


def loads_of(context: Context, part: int, axis: np.ndarray) -> dict | None:
    """The force [N] against time on a guided part along its axis, of *LOAD_RIGID_BODY; None if there is none."""
    found, report = None, context.report
    for block in context.model.all("LOAD_RIGID_BODY"):
        cards = context.cards(block)
        while cards.left:
            f = context.card(cards, "load")
            if f["PID"].whole != part:
                continue
            along = float(axis[f["DOF"].whole - 1]) if f["DOF"].whole in (1, 2, 3) else 0.0
            if not along or found is not None:
                report.refused(f["DOF"], "a force across the rail, a torque, or a second force: one along the rail")
                continue
            curve = context.curve(f["LCID"], "time", "force", "a force")
            scale = along * (f["SF"].number or 1.0)
            for name in ("PID", "DOF", "LCID", "SF"):
                report.mapped(f[name], f[name].text, "obstacles.motion.force")
            found = said({"time": curve["time"], "value": [scale * v for v in curve["value"]]}, f["LCID"])
    return found


def wall_motion(context: Context, f: dict[str, Field]) -> dict | None:
    """The `motion` of a geometric rigid wall by its card of motion; None if it stands still."""
    report, is_travel = context.report, f["OPT"].whole == 1
    kind = "travel" if is_travel else "speed"
    direction = np.array([f[n].number for n in ("VX", "VY", "VZ")])
    if not f["LCID"].whole or not direction.any():
        return None
    curve = context.curve(f["LCID"], "time", "length" if is_travel else "velocity", "the motion of a wall")
    size = math.hypot(*direction)
    for name in ("LCID", "OPT", "VX", "VY", "VZ"):
        report.mapped(f[name], f[name].text, f"obstacles.motion.{'direction' if name[0] == 'V' else kind}")
    if is_travel and curve["value"][0]:
        report.refused(f["LCID"], "it begins away from the place of the wall: place the wall there")
        return None
    return {
        "kind": kind, "direction": said((direction / size).tolist(), f["VX"]),
        kind: said({"time": curve["time"], "value": curve["value"]}, f["LCID"]),
    }  # fmt: skip
