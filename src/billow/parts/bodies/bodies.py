"""The part of all bodies: how they move, what touches them, and what a run says of them."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from billow.base.errors import Concern, NumericalStop
from billow.base.plausible import is_usual, unusual
from billow.base.quality import Criterion, criterion
from billow.geometry.shapes.mesh import Mesh
from billow.parts.bodies import rigid_body
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import ContactState, Nodes, ShapeMotion, ShapeTable, kick_touch_drift
from billow.parts.bodies.drive import Drive, Guided, advance, begin
from billow.parts.bodies.meeting import Meetings, MeetingState
from billow.parts.bodies.penalty import A_REFERENCE
from billow.parts.bodies.rigid_body import RigidState
from billow.parts.bodies.rows import BodyRows
from billow.parts.part import (
    DRIVE_WORK,
    FRICTION,
    GRAVITY_WORK,
    MOTION,
    STORED,
    WORKING_PRESSURE,
    Account,
    Booking,
    Frame,
    Moment,
    Owner,
    Part,
    Quantity,
    Setting,
)

BODY_KINETIC = Account("body_kinetic", MOTION, renewed=True)
"""Kinetic energy of the bodies."""
CONTACT = Account("contact", STORED, renewed=True)
"""Energy in the springs between fabric and bodies, and between bodies."""

FREE = ("centre", "velocity", "acceleration", "spin", "quaternion")
"""Quantities of a body that is free to move."""
DRIVEN = ("centre", "velocity", "quaternion", "drive_work")
"""Quantities of a body that is moved; of a guided one its acceleration too."""

DEEPEST = 0.5
"""Of a body's smallest radius; fabric that goes deeper makes the contact meaningless."""

TOUCHES = 1e-6
"""Depth [m] from which on a body touches the bag at the start."""

SECONDS_PER_NODE = 18e-9
"""Rough cost of the contact of one node with one body in a step."""

TOO_DEEP = NumericalStop.declare(
    "E-NUM-006",
    "fabric went {depth:.3g} mm into {body}",
    where="obstacle {body}, {when}",
    why="the obstacle is too soft for the load: beyond half its smallest radius its surface has no meaning",
    remedy="raise obstacles.{body}.slope (N/m per cm^2 of fabric)",
)
OUT_OF_REACH = Concern.declare(
    "W-OBS-001",
    "{body} is {gap:.3g} m away from a bag of {across:.3g} m",
    where="obstacles.{body}.clearance",
    why="the bag will not reach it",
    cause="a clearance in another unit",
    remedy="reduce the clearance, or remove the obstacle",
)
ODD_DENSITY = Concern.declare(
    "W-OBS-002",
    "{body} has a mean density of {density:.3g} kg/m^3",
    where="obstacles.{body}.mass, obstacles.{body}.radii",
    why="heads and impactors lie between 50 and 8,000: mass or radii may be in another unit",
    remedy='write units, for example mass = "4500 g"',
)
SOFTER_THAN_BAG = Concern.declare(
    "W-OBS-003",
    f"{{body}} yields {{depth:.3g}} mm at {1e-3 * WORKING_PRESSURE:g} kPa",
    where="obstacles.{body}.slope",
    why="it is softer than the bag: the slope may be in N/mm",
    remedy='write units, for example slope = "100 N/mm"',
)


@dataclass
class BodiesState:
    """motion: of each body; contact: of all their shapes with fabric, body by body; meeting: of bodies with bodies;
    push: of the drive on each guided body, mean over the last step [N], and work: of the drive on each body so far [J],
    both (bodies,)."""

    motion: tuple[RigidState, ...]
    contact: ContactState
    meeting: MeetingState
    push: np.ndarray
    work: np.ndarray


@dataclass(frozen=True)
class Bodies(Part):
    """bodies: any number; area: fabric that each node stands for in contact [m^2], (nodes,); gravity: [m/s^2], (3,)."""

    bodies: tuple[Body, ...]
    area: np.ndarray
    gravity: np.ndarray

    @property
    def accounts(self) -> tuple[Account, ...]:
        driven = (DRIVE_WORK,) if any(body.drive is not None for body in self.bodies) else ()
        return (BODY_KINETIC, CONTACT, FRICTION, GRAVITY_WORK, *driven)

    @cached_property
    def owner(self) -> list[int]:
        """Index of the body of each shape."""
        return [k for k, body in enumerate(self.bodies) for _ in body.shapes]

    @cached_property
    def _first_shape(self) -> list[int]:
        """Of each body, index of its first shape."""
        return [self.owner.index(k) for k in range(len(self.bodies))]

    @cached_property
    def table(self) -> ShapeTable:
        """Shapes and laws, as kernels need them."""
        shapes = [carried.shape for body in self.bodies for carried in body.shapes]
        return ShapeTable.build(shapes, [self.bodies[k].law for k in self.owner])

    @cached_property
    def has_gravity(self) -> bool:
        return bool(self.gravity.any())

    @cached_property
    def _rows(self) -> ShapeMotion:
        """Where the shapes are: of locked bodies for ever, of the others as `_motion` left them."""
        rows = ShapeMotion.room(len(self.owner), len(self.area) if self._meshes else 0)
        self._fill(rows, [body.start for body in self.bodies], range(len(self.bodies)))
        return rows

    @cached_property
    def _meshes(self) -> list[tuple[int, Mesh, np.ndarray]]:
        """Of the shapes that are meshes: index, shape, and what is remembered of the nodes to save searching."""
        shapes = [carried.shape for body in self.bodies for carried in body.shapes]
        return [(o, s, s.nothing_seen(len(self.area))) for o, s in enumerate(shapes) if isinstance(s, Mesh)]

    @cached_property
    def _moving(self) -> list[int]:
        """Indices of the bodies that move."""
        return [k for k, body in enumerate(self.bodies) if body.moves]

    @cached_property
    def _driven(self) -> list[tuple[int, Drive, np.ndarray]]:
        """Of the bodies that are moved: index, what moves them, and centre at the start [m], (3,)."""
        return [(k, b.drive, b.start.centre) for k, b in enumerate(self.bodies) if b.drive is not None]

    @cached_property
    def _allowed(self) -> list[float]:
        """Of each shape, how deep fabric may go into it [m]."""
        return [DEEPEST * self.bodies[k].size for k in self.owner]

    @cached_property
    def meetings(self) -> Meetings:
        """The pairs of bodies that can meet."""
        return Meetings.of(self.bodies)

    def start(self, bag=None) -> BodiesState:
        """Bodies where they start; nothing touches."""
        motion = tuple(deepcopy(body.start) for body in self.bodies)
        contact, none = ContactState.none(len(self.owner), len(self.area)), np.zeros(len(self.bodies))
        return BodiesState(motion, contact, self.meetings.start(), none, none.copy())

    # --- in a step -------------------------------------------------------------------------------------------------

    def drive(self, state: BodiesState, time: float, dt: float) -> None:
        """What moves bodies begins a step of dt [s] at `time` [s]."""
        for k, how, start in self._driven:
            state.push[k] = begin(how, state.motion[k], start, time, dt)

    def kick_touch_drift(self, state: BodiesState, nodes: Nodes, dt: float) -> list[Booking]:
        """Half a kick of the nodes, their contact with the bodies over the drift, and the drift: half of each contact
        impulse on the nodes, all of it on the bodies."""
        reaction = kick_touch_drift(self.table, self._motion(state, nodes, dt), self.area, nodes, dt, state.contact)
        return self._receive(state, reaction)

    def rows(self, state: BodiesState, nodes: Nodes, dt: float) -> BodyRows:
        """Half a kick of the nodes and their contact with the bodies, to be solved together with other contacts; then
        `drift`."""
        return BodyRows(self.table, self._motion(state, nodes, dt), self.area, nodes, dt, state.contact)

    def drift(self, state: BodiesState, rows: BodyRows) -> list[Booking]:
        """The drift of the nodes: half of each contact impulse is on them, all of it on the bodies."""
        return self._receive(state, rows.drift())

    def _receive(self, state: BodiesState, reaction: np.ndarray) -> list[Booking]:
        """Forces [N] and torques [N m] on the bodies, (shapes, 6), and what the contact springs hold and took."""
        contact = state.contact
        if not self.bodies:
            return []
        if len(self.owner) > len(self.bodies):
            reaction = np.add.reduceat(reaction, self._first_shape)
        for motion, row in zip(state.motion, reaction, strict=True):
            motion.force, motion.torque = row[:3], row[3:]
        stored, lost = sum(contact.stored.tolist()), sum(contact.dissipated.tolist())
        return [(CONTACT, stored), (FRICTION, lost)]

    def meet(self, state: BodiesState, dt: float) -> list[Booking]:
        """Contact of bodies with each other over the coming step of dt [s], after that with fabric."""
        if not self.meetings.pairs:
            return []
        stored, lost = self.meetings.push(state.motion, state.meeting, state.push, self.gravity, dt)
        return [Booking(CONTACT, stored), Booking(FRICTION, lost)]

    def _motion(self, state: BodiesState, nodes: Nodes, dt: float) -> ShapeMotion:
        """Where the shapes are now, and the nodes that may come to a mesh in a step of dt [s]."""
        rows = self._rows
        self._fill(rows, state.motion, self._moving)
        if self._meshes:
            fastest = math.sqrt(3.0) * float(np.abs(nodes.velocities).max(initial=0.0))
            for o, mesh, seen in self._meshes:
                of_body = np.linalg.norm(rows.body[o, 3:6]) + np.linalg.norm(rows.body[o, 6:]) * (
                    mesh.bound + np.linalg.norm(rows.centre[o])
                )
                within = mesh.edge + 2.0 * dt * (fastest + float(of_body))
                mesh.look(nodes.positions, rows.body[o], rows.centre[o], rows.pose[o], within, seen, rows.met[o])
        return rows

    def _fill(self, rows: ShapeMotion, motions: Sequence[RigidState], which: Iterable[int]) -> None:
        for k in which:
            body, motion = self.bodies[k], motions[k]
            for o, carried in enumerate(body.shapes, self._first_shape[k]):
                rigid_body.carry(
                    body.rigid, motion, carried.centre, carried.rotation, rows.body[o], rows.centre[o], rows.pose[o]
                )  # fmt: skip

    def move(self, state: BodiesState, dt: float) -> list[Booking]:
        """Bodies over a step of dt [s] under the contact forces and gravity."""
        if not self._moving:
            return []
        bookings = []
        for k in self._moving:
            body, motion = self.bodies[k], state.motion[k]
            if body.drive is not None:
                work, by_gravity = advance(body.drive, motion, float(state.push[k]), self.gravity, dt)
                state.work[k] += work
                bookings += [Booking(DRIVE_WORK, work), Booking(GRAVITY_WORK, by_gravity)]
                continue
            by_gravity = rigid_body.advance(body.rigid, motion, self.gravity, dt)
            if self.has_gravity:
                bookings.append(Booking(GRAVITY_WORK, by_gravity))
        return bookings + self.kinetic_energy(state)

    def kinetic_energy(self, state: BodiesState) -> list[Booking]:
        """That of all bodies now."""
        total = 0.0
        for k in self._moving:
            body, motion = self.bodies[k], state.motion[k]
            if isinstance(body.drive, Guided):
                total += body.drive.kinetic_energy(motion)
            elif body.drive is None:
                total += rigid_body.kinetic_energy(body.rigid, motion)
        return [Booking(BODY_KINETIC, total)]

    # --- what a run says of them -----------------------------------------------------------------------------------

    def _deepest(self, state: BodiesState) -> list[float]:
        """Penetration of each body [m]."""
        depths = state.contact.deepest.tolist()
        return [max(d for k, d in zip(self.owner, depths, strict=True) if k == b) for b in range(len(self.bodies))]

    def owners(self) -> Iterator[Owner]:
        for k, body in enumerate(self.bodies):
            kind, more = ("free obstacle", FREE) if body.drive is None else ("moved obstacle", DRIVEN)
            if not body.moves:
                kind, more = "obstacle", ()
            elif isinstance(body.drive, Guided):
                kind, more = "guided obstacle", (*more, "acceleration")
            met = ("obstacle_force",) if k in self.meetings.members else ()
            yield Owner(kind, body.name, ("force", "contact", "penetration", *more, *met))

    def quantities(self, state: BodiesState, moment: Moment) -> Iterator[Quantity]:
        energies = np.bincount(self.owner, state.contact.stored, len(self.bodies)).tolist() if self.owner else []
        rows = zip(self.bodies, state.motion, energies, self._deepest(state), strict=True)
        for k, (body, motion, stored, deepest) in enumerate(rows):
            if k in self.meetings.members:
                yield Quantity(body.name, "force", "N", motion.force - state.meeting.force[k])
                yield Quantity(body.name, "obstacle_force", "N", state.meeting.force[k])
            else:
                yield Quantity(body.name, "force", "N", motion.force)
            if body.moves:
                yield Quantity(body.name, "centre", "m", motion.centre)
                yield Quantity(body.name, "velocity", "m/s", motion.velocity)
                if isinstance(body.drive, Guided):
                    felt = body.drive.acceleration(motion, float(state.push[k]), self.gravity)
                    yield Quantity(body.name, "acceleration", "m/s^2", felt)
                elif body.drive is None:
                    yield Quantity(body.name, "acceleration", "m/s^2", motion.force / body.rigid.mass + self.gravity)
                    yield Quantity(body.name, "spin", "rad/s", rigid_body.spin(body.rigid, motion))
                yield Quantity(body.name, "quaternion", "-", motion.quaternion)
                if body.drive is not None:
                    yield Quantity(body.name, "drive_work", "J", float(state.work[k]))
            yield Quantity(body.name, "contact", "J", stored)
            yield Quantity(body.name, "penetration", "m", deepest)

    def frame(self, state: BodiesState, moment: Moment) -> Frame:
        """Contact forces [N] on the nodes: of impactors, and of plates, which have no end."""
        of_impactors, of_plates = (np.zeros((len(self.area), 3)) for _ in range(2))
        for k, force in zip(self.owner, state.contact.force, strict=True):
            field = of_impactors if self.bodies[k].is_bounded else of_plates
            field += force
        return Frame(point={"contact_force": of_impactors, "plate_force": of_plates})

    def guard(self, state: BodiesState, moment: Moment) -> None:
        """Raises NumericalStop E-NUM-006 if fabric went too deep into a body."""
        for owner, deepest, allowed in zip(self.owner, state.contact.deepest.tolist(), self._allowed, strict=True):
            if deepest > allowed:
                raise TOO_DEEP(body=self.bodies[owner].name, depth=1e3 * deepest, when=moment.when)
        self.meetings.guard(state.meeting, moment)

    def books(self, state: BodiesState, moment: Moment, history) -> dict[str, float]:
        rigid = [history.of(body.name).contact for body in self.bodies if body.is_rigid]
        return {"rigid_contact_energy_joule": float(np.sum(rigid, axis=0).max()) if rigid else 0.0}

    def verdicts(self, books: Mapping[str, float], history) -> Iterator[Criterion]:
        share = books["rigid_contact_energy_joule"] / max(books["penalty_scale_joule"], 1e-300)
        stiffer = "a larger slope of plates and free obstacles"
        yield criterion("penalty energy of rigid contact, of peak internal", 100.0 * share, 5, 10, "%", stiffer)

    def seconds_per_step(self, state: BodiesState, dt: float, end: float) -> float:
        return SECONDS_PER_NODE * len(self.area) * len(self.owner)

    # --- before a run ----------------------------------------------------------------------------------------------

    def touching_at_start(self, positions: np.ndarray, inverse_mass: np.ndarray) -> Iterator[tuple[Body, float]]:
        """Bodies that reach into fabric at positions [m] (nodes, 3), and how deep [m]."""
        state, still = self.start(), np.zeros_like(positions)
        nodes = Nodes(inverse_mass, still, positions.copy(), still.copy(), np.empty_like(positions))
        self.kick_touch_drift(state, nodes, 0.0)
        for body, deepest in zip(self.bodies, self._deepest(state), strict=True):
            if deepest > TOUCHES:
                yield body, deepest

    def concerns(self, setting: Setting) -> Iterator[Concern]:
        across = setting.across
        for body in self.bodies:
            if not body.is_bounded:
                continue
            gap = float(body.distance(setting.start).min())
            if gap > 0.7 * across and body.drive is None:
                yield OUT_OF_REACH(body=body.name, gap=gap, across=across)
            density = body.rigid.mass / sum(carried.shape.volume() for carried in body.shapes)
            if not body.rigid.locked and not is_usual("density of a body", density):
                yield ODD_DENSITY(body=body.name, density=density)
            speed = 0.0 if body.rigid.locked else float(np.linalg.norm(body.start.velocity))
            where = f"obstacles.{body.name}.velocity"
            yield from unusual("speed of a body", speed, f"the speed of {body.name}", where, "write the unit")
            if body.law.slope < 200.0:
                yield SOFTER_THAN_BAG(body=body.name, depth=1e3 * WORKING_PRESSURE * A_REFERENCE / body.law.slope)
