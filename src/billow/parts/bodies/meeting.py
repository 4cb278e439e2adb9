"""Bodies against each other, over a step (docs/theory.md, Obstacles that meet): every pair of which one can move.
Nothing of this is asked where there is no such pair.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from billow.base.compiled import scalar
from billow.base.errors import NumericalStop
from billow.geometry.shapes.kinds import number_of
from billow.geometry.shapes.touching import farthest_in_space, touch
from billow.parts.bodies.body import Body, Carried
from billow.parts.bodies.drive import Guided
from billow.parts.bodies.penalty import A_REFERENCE
from billow.parts.bodies.rigid_body import RigidState, spin
from billow.parts.part import Moment

SWEEPS, SETTLED = 50, 1e-10
"""Most sweeps over pairs that push on the same body, and the relative change of force at which they end."""

DEEPEST = 0.5
"""Of the smallest radius of two bodies; where they overlap by more, their contact means nothing."""

MET_TOO_DEEP = NumericalStop.declare(
    "E-NUM-010",
    "{one} and {other} went {depth:.3g} mm into each other",
    where="obstacles {one} and {other}, {when}",
    why="they are too soft for the impact: beyond half the smaller radius their contact has no meaning",
    remedy="raise obstacles.{one}.slope and obstacles.{other}.slope",
)


@dataclass
class MeetingState:
    """force: of the other bodies on each, average over the last step [N], (bodies, 3); deepest: overlap of each pair
    [m], (pairs,)."""

    force: np.ndarray
    deepest: np.ndarray


class Touch(NamedTuple):
    """normal: unit vector from the first body to the second, (3,). overlap: along it [m]. place: where they touch, in
    space [m], (3,). scale: of the overlap that the springs see, which is a function of the scale t at which the bodies
    just touch, so that their force is its exact gradient."""

    normal: np.ndarray
    overlap: float
    place: np.ndarray
    scale: float


@dataclass(frozen=True)
class Pair:
    """Two shapes on different bodies; the second may be a plane without bounds, the first is not.

    bodies: their indices. shapes: with their places on them. span: mean radii of both together [m]. firmness: force
    over the square of the overlap [N/m^2]. friction [-]; damping: of critical [-].
    """

    bodies: tuple[int, int]
    shapes: tuple[Carried, Carried]
    span: float
    firmness: float
    friction: float
    damping: float

    @classmethod
    def of(cls, ends: Sequence[tuple[int, Body, Carried]]) -> Pair:
        """Springs all over the surfaces of two round bodies: slopes in series, curvatures added, friction and damping
        geometric means."""
        indices, bodies, shapes = zip(*ends, strict=True)
        first, second = bodies[0].law, bodies[1].law
        radii = [(0.75 / math.pi * carried.shape.volume()) ** (1.0 / 3.0) for carried in shapes]
        radius = 1.0 / sum(1.0 / r for r in radii)
        return cls(
            indices,
            shapes,
            span=sum(radii),
            firmness=math.pi * radius / A_REFERENCE / (1.0 / first.slope + 1.0 / second.slope),
            friction=math.sqrt(first.friction * second.friction),
            damping=math.sqrt(first.damping * second.damping),
        )

    @property
    def size(self) -> float:
        """Smallest radius of the two [m]."""
        return min(carried.shape.size for carried in self.shapes)

    @cached_property
    def _told(self) -> list[tuple[int, tuple[float, ...]]]:
        """Kind and numbers of both shapes."""
        return [(number_of(carried.shape), tuple(carried.shape.numbers.tolist())) for carried in self.shapes]

    def touching(self, motions: Sequence[RigidState]) -> Touch:
        """How they touch, or would."""
        centres, poses = [], []
        for body, carried in zip(self.bodies, self.shapes, strict=True):
            rotation = motions[body].rotation
            centres.append(motions[body].centre + rotation @ carried.centre)
            poses.append(rotation @ carried.rotation)
        apart = centres[1] - centres[0]
        (kind_a, numbers_a), (kind_b, numbers_b) = self._told
        if math.isinf(self.shapes[1].shape.bound):
            normal = -poses[1][:, 2]
            above = float(apart @ normal)
            point = np.array(farthest_in_space(kind_a, numbers_a, tuple(poses[0].ravel().tolist()), *normal.tolist()))
            return Touch(normal, float(point @ normal) - above, centres[0] + point, 1.0)
        pose_a, pose_b = (tuple(pose.ravel().tolist()) for pose in poses)
        found = touch(kind_a, numbers_a, pose_a, kind_b, numbers_b, pose_b, *apart.tolist())
        normal, span = np.array(found[:3]), found[3]
        return Touch(normal, span - float(normal @ apart), centres[0] + np.array(found[4:]), self.span / span)


@scalar
def _way(velocity, force, torque, angular_momentum, moves, per_mass, per_momentum, push, pull, dt):
    """A bound of the way of any point of a body [m] over a step of dt [s], but for meetings. per_mass: inverse mass
    [1/kg], and per_momentum: size over least inertia [1/(kg m)], both zero where forces do not change its motion;
    push: of its drive [N]; pull: speed that gravity gives [m/s]."""
    if not moves:
        return 0.0
    speed = _length(velocity) + pull + dt * per_mass * (_length(force) + abs(push))
    return dt * (speed + per_momentum * (_length(angular_momentum) + dt * _length(torque)))


@scalar
def _length(vector):
    return math.sqrt(vector[0] * vector[0] + vector[1] * vector[1] + vector[2] * vector[2])


@scalar
def _may_meet(
    a, va, fa, ta, la, push_a, b, vb, fb, tb, lb, push_b, is_plane, normal, sizes, bounds, gravity, dt
):  # fmt: skip
    """Whether two shapes may meet in a step of dt [s]: cheap, because it is asked in every one.

    Of each body centre [m], velocity [m/s], force [N], torque [N m], angular momentum [kg m^2/s] and push of its drive
    [N]; normal: outward, of the second shape, if it is a plane; sizes: radii of spheres about both centres that hold
    the shapes [m]; bounds: moves, per_mass and per_momentum of `_way`, (2, 3); gravity [m/s^2]."""
    pull = dt * _length(gravity)
    x, y, z = a[0] - b[0], a[1] - b[1], a[2] - b[2]
    if is_plane:
        gap = x * normal[0] + y * normal[1] + z * normal[2] - sizes[0]
    else:
        gap = math.sqrt(x * x + y * y + z * z) - (sizes[0] + sizes[1])
    first = _way(va, fa, ta, la, bounds[0, 0] > 0.0, bounds[0, 1], bounds[0, 2], push_a, pull, dt)
    second = _way(vb, fb, tb, lb, bounds[1, 0] > 0.0, bounds[1, 1], bounds[1, 2], push_b, pull, dt)
    return gap <= first + second


def _bound(body: Body) -> tuple[float, float, float]:
    """What bounds the way of a body, as in `_may_meet`."""
    if body.rigid.locked:
        return float(body.moves), 1.0 / body.drive.mass if isinstance(body.drive, Guided) else 0.0, 0.0
    size = max(math.hypot(*carried.centre.tolist()) + carried.shape.bound for carried in body.shapes)
    return 1.0, 1.0 / body.rigid.mass, size / float(body.rigid.inertia.min())


@dataclass(frozen=True)
class Meetings:
    """All pairs of bodies that can meet."""

    bodies: tuple[Body, ...]
    pairs: tuple[Pair, ...]

    @classmethod
    def of(cls, bodies: tuple[Body, ...]) -> Meetings:
        pairs = []
        for (a, one), (b, other) in itertools.combinations(enumerate(bodies), 2):
            if not (one.yields or other.yields):
                continue
            for first, second in itertools.product(one.shapes, other.shapes):
                if math.isinf(first.shape.bound) and math.isinf(second.shape.bound):
                    continue  # planes without end
                ends = [(a, one, first), (b, other, second)]
                pairs.append(Pair.of(ends[::-1] if math.isinf(first.shape.bound) else ends))
        return cls(bodies, tuple(pairs))

    @cached_property
    def members(self) -> frozenset[int]:
        """Indices of the bodies that can meet another."""
        return frozenset(body for pair in self.pairs for body in pair.bodies)

    def start(self) -> MeetingState:
        return MeetingState(np.zeros((len(self.bodies), 3)), np.zeros(len(self.pairs)))

    def overlaps(self, motions: Sequence[RigidState]) -> Iterator[tuple[Body, Body, float]]:
        """Bodies of each pair, and their overlap [m], negative if they are apart."""
        for pair in self.pairs:
            yield self.bodies[pair.bodies[0]], self.bodies[pair.bodies[1]], pair.touching(motions).overlap

    def guard(self, state: MeetingState, moment: Moment) -> None:
        """Raises NumericalStop E-NUM-010 if bodies went too deep into each other."""
        for pair, deepest in zip(self.pairs, state.deepest.tolist(), strict=True):
            if deepest > DEEPEST * pair.size:
                one, other = (self.bodies[body].name for body in pair.bodies)
                raise MET_TOO_DEEP(one=one, other=other, depth=1e3 * deepest, when=moment.when)

    # --- in a step -------------------------------------------------------------------------------------------------

    def push(
        self, motions: Sequence[RigidState], state: MeetingState, pushes: np.ndarray, gravity: np.ndarray, dt: float
    ) -> tuple[float, float]:
        """Add the forces [N] and torques [N m] of all pairs over a step of dt [s] to those in `motions`; returns what
        the springs hold at its end, and what friction and damping took [J]. pushes: of the drives of guided bodies
        [N], (bodies,)."""
        if any(state.deepest.tolist()):
            state.force[...], state.deepest[...] = 0.0, 0.0
        met = [
            (k, pair, pair.touching(motions))
            for k, (pair, limits) in enumerate(zip(self.pairs, self._limits, strict=True))
            if self._may_meet(pair, limits, motions, pushes, gravity, dt)
        ]
        if not met:
            return 0.0, 0.0
        responses = [
            Response.of(body, motion, push, gravity)
            for body, motion, push in zip(self.bodies, motions, pushes.tolist(), strict=True)
        ]
        forces, stored, lost = np.zeros((len(met), 3)), np.zeros(len(met)), np.zeros(len(met))
        for _ in range(SWEEPS if len(met) > 1 else 1):
            change = 0.0
            for m, (k, pair, touch_) in enumerate(met):
                _act(motions, pair, touch_.place, -forces[m])
                solved = self._solve(pair, touch_, motions, responses, dt)
                force, stored[m], lost[m], state.deepest[k] = solved
                _act(motions, pair, touch_.place, force)
                change += float(np.abs(force - forces[m]).sum())
                forces[m] = force
            if change <= SETTLED * float(np.abs(forces).sum()):
                break
        for force, (_, pair, _) in zip(forces, met, strict=True):
            state.force[pair.bodies[0]] += force
            state.force[pair.bodies[1]] -= force
        return float(stored.sum()), float(lost.sum())

    def _may_meet(
        self, pair: Pair, limits: tuple, motions: Sequence[RigidState], pushes: np.ndarray, gravity: np.ndarray,
        dt: float,
    ) -> bool:  # fmt: skip
        a, b = pair.bodies
        one, other = motions[a], motions[b]
        return _may_meet(
            one.centre, one.velocity, one.force, one.torque, one.angular_momentum, float(pushes[a]), other.centre,
            other.velocity, other.force, other.torque, other.angular_momentum, float(pushes[b]), *limits,
            gravity, dt,
        )  # fmt: skip

    @cached_property
    def _limits(self) -> list[tuple[bool, np.ndarray, np.ndarray, np.ndarray]]:
        """Of each pair is_plane, normal, sizes and bounds of `_may_meet`. Planes never turn."""
        found = []
        for pair in self.pairs:
            body, carried = self.bodies[pair.bodies[1]], pair.shapes[1]
            turn = body.start.rotation @ carried.rotation
            sizes = [math.hypot(*shape.centre.tolist()) + shape.shape.bound for shape in pair.shapes]
            bounds = np.array([_bound(self.bodies[k]) for k in pair.bodies])
            found.append((math.isinf(carried.shape.bound), turn[:, 2].copy(), np.array(sizes), bounds))
        return found

    def _solve(
        self, pair: Pair, found: Touch, motions: Sequence[RigidState], responses: Sequence[Response], dt: float
    ) -> tuple[np.ndarray, float, float, float]:
        """Force on the first body [N], (3,), energy stored at the end of the step and lost in it [J], and the overlap
        at its end [m], with all other forces as they are in `motions`."""
        # Velocity of the first body at the place less that of the second: now, and at the end without this force; and
        # what it gains per force [1/kg], (3, 3).
        normal, place, scale = found.normal, found.place, found.scale
        now, later, gain = np.zeros(3), np.zeros(3), np.zeros((3, 3))
        for body, sign in zip(pair.bodies, (1.0, -1.0), strict=True):
            motion, response = motions[body], responses[body]
            arm = place - motion.centre
            now += sign * (motion.velocity + np.cross(spin(self.bodies[body].rigid, motion), arm))
            if self.bodies[body].yields:
                turning = np.cross(response.per_inertia @ motion.torque, arm)
                later += sign * dt * (response.per_mass @ motion.force + response.other + turning)
                lever = np.cross(np.eye(3), arm)
                gain += response.per_mass + lever @ response.per_inertia @ lever.T
        later += now
        middle, weight, overlap = 0.5 * (now + later), scale**2 * float(normal @ gain @ normal), scale * found.overlap
        push, after = spring_force(overlap, scale * float(middle @ normal), pair.firmness, weight, pair.damping, dt)
        force = -scale * push * normal
        before, stored = (pair.firmness * max(0.0, depth) ** 3 / 3.0 for depth in (overlap, after))
        lost = push * (after - overlap) - (stored - before)
        # Friction: what would end the sliding within the step, cut back to the Coulomb limit.
        later += dt * gain @ force
        slide = later - (later @ normal) * normal
        speed = float(np.linalg.norm(slide))
        if speed > 0.0 and push > 0.0 and pair.friction > 0.0:
            along = slide / speed
            drag, ends = pair.friction * scale * push, dt * float(along @ gain @ along)
            drag = min(drag, speed / ends) if ends > 0.0 else drag
            force = force - drag * along
            lost += drag * dt * float((middle + 0.5 * dt * gain @ force) @ along)
        return force, stored, lost, max(0.0, after) / scale


def _act(motions: Sequence[RigidState], pair: Pair, place: np.ndarray, force: np.ndarray) -> None:
    """A force [N] on the first body of a pair at a place in space [m], and its reaction on the second."""
    for body, one in zip(pair.bodies, (force, -force), strict=True):
        motions[body].force = motions[body].force + one
        motions[body].torque = motions[body].torque + np.cross(place - motions[body].centre, one)


class Response(NamedTuple):
    """How a body answers to forces: inverse mass [1/kg] and inverse inertia [1/(kg m^2)] in space, (3, 3), zero where
    it does not yield; other: its acceleration by gravity and drive [m/s^2], (3,)."""

    per_mass: np.ndarray
    per_inertia: np.ndarray
    other: np.ndarray

    @classmethod
    def of(cls, body: Body, motion: RigidState, push: float, gravity: np.ndarray) -> Response:
        none = np.zeros((3, 3))
        if isinstance(body.drive, Guided):
            along, mass = body.drive.direction, body.drive.mass
            return cls(np.outer(along, along) / mass, none, (push / mass + along @ gravity) * along)
        if body.rigid.locked:
            return cls(none, none, none[0])
        rotation = motion.rotation
        return cls(np.eye(3) / body.rigid.mass, rotation / body.rigid.inertia @ rotation.T, gravity)


@scalar
def _mean_force(overlap, end, firmness):
    """Mean force [N] of springs of energy firmness d^3/3 on the way from an overlap d [m] to another, and its slope."""
    a, b = max(0.0, overlap), max(0.0, end)
    whole = firmness * (a * a + a * b + b * b) / 3.0
    way = end - overlap
    if way == 0.0:
        return whole, firmness * a
    inside = (b - a) / way
    steeper = firmness * (a + 2.0 * b) / 3.0 if end > 0.0 else 0.0
    return whole * inside, steeper * inside + whole * ((1.0 if end > 0.0 else 0.0) - inside) / way


@scalar
def spring_force(overlap, closing, firmness, weight, damping, dt):
    """Average normal force over a step [N], and the overlap at its end [m]: the discrete gradient of the springs'
    energy, as for fabric (`penalty`).

    overlap: at the start [m]; closing: speed [m/s] at the middle without this force; weight: inverse mass that it moves
    [1/kg]; damping: fraction of critical [-]; dt [s].
    """
    free, half = overlap + dt * closing, 0.5 * dt * dt * weight
    if max(overlap, free) <= 0.0:
        return 0.0, free
    end = free  # Newton from above: the mean force is convex, so that it comes down to the root
    for _ in range(60):
        force, slope = _mean_force(overlap, end, firmness)
        change = (end - free + half * force) / (1.0 + half * slope)
        end -= change
        if abs(change) <= 1e-15 * (abs(end) + abs(overlap)):
            break
    force, _ = _mean_force(overlap, end, firmness)
    if damping > 0.0 and weight > 0.0:
        stiffness = firmness * (max(0.0, overlap) + max(0.0, end))
        viscosity = 2.0 * damping * math.sqrt(stiffness / weight)
        force = max(0.0, force + viscosity * (end - overlap) / dt / (1.0 + half * viscosity / dt))
    return force, free - half * force
