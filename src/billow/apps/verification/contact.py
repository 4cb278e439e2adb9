"""C1 to C4, R1: contact, the super-ellipsoid and a free rigid body (docs/theory.md, Verification cases)."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.integrate import quad

from billow.apps.verification.check import Measurement
from billow.apps.verification.scenes import Observer, disc, fabric_model, isotropic
from billow.case.obstacles.obstacles import SuperEllipsoid as ObstacleTable
from billow.geometry.bag_shapes import BagShape
from billow.geometry.shapes.half_space import HalfSpace
from billow.geometry.shapes.pose import of_plane, quaternion_about
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid, closest_point
from billow.geometry.surface import Surface
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState, kinetic_energy
from billow.parts.fabric.fabric import Fabric
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, start_state
from billow.solver.run import Schedule, run
from billow.solver.step import advance


def sphere_on_node() -> Iterator[Measurement]:
    """C1: a free sphere of 4.5 kg hits one fixed node of 1e-4 m^2 at 5 m/s, slope 2e6 N/m, undamped. A mass on a linear
    spring for half a period. The sphere is a headform (82.5 mm), 2 mm away at the start. Steps of 20 us, a usual step
    of a bag: a second-order method is right to (omega dt)^2/24 = 1e-5, a first-order one to 1 %."""
    mass, speed, slope, gap, radius = 4.5, 5.0, 2e6, 2e-3, 0.0825
    sphere = SuperEllipsoid(np.full(3, radius), 2.0)
    rigid, law = RigidBody(mass, sphere.inertia(mass), locked=False), SurfaceLaw(slope, friction=0.0, damping=0.0)
    falling = RigidState(np.array([0.0, 0.0, radius + gap]), velocity=np.array([0.0, 0.0, -speed]))
    model = _one_node(Body.of("ball", sphere, law, rigid, falling))
    state = start_state(model)
    dt, rows = 20e-6, [(gap, 0.0)]
    for _ in range(300):  # 6 ms; the sphere leaves at 5.1 ms
        advance(model, state, dt)
        motion = state.bodies.motion[0]
        rows.append((motion.centre[2] - radius, motion.force[2]))
    height, force = np.array(rows).T
    low, high = np.minimum(height[1:], height[:-1]), np.maximum(height[1:], height[:-1])
    inside = np.clip(-low / (high - low), 0.0, 1.0)  # share of each step, straight in between
    rebound = state.bodies.motion[0].velocity[2]
    yield Measurement("depth [m]", -height.min(), speed * np.sqrt(mass / slope), 5e-3)
    yield Measurement("force [N]", force.max(), speed * np.sqrt(mass * slope), 5e-3)
    yield Measurement("time of contact [s]", inside.sum() * dt, np.pi * np.sqrt(mass / slope), 5e-3)
    yield Measurement("restitution [-]", rebound / speed, 1.0, 5e-3)


def incline() -> Iterator[Measurement]:
    """C2: a patch of fabric on an inclined plate, friction mu = 0.3. Three angles: slope 1 % below mu, 1 % above it,
    and 35 degrees. 1e-4 m/s^2 counts as at rest: without friction it would be 2.8, and 1 % above it is 0.028. The patch
    starts at its resting depth, so that it does not bounce; the stick springs are loaded within the first 2 ms and
    damped. The acceleration is read from the speeds 5 ms and 20 ms after the start."""
    mu, gravity = 0.3, 9.81
    held = _downhill(np.arctan(0.99 * mu), mu, gravity)
    yield Measurement("acceleration at tan = 0.99 mu [m/s^2, absolute]", held, 0.0, 1e-4)
    for angle, name in ((np.arctan(1.01 * mu), "tan = 1.01 mu"), (np.radians(35.0), "35 degrees")):
        expected = gravity * (np.sin(angle) - mu * np.cos(angle))
        yield Measurement(f"acceleration at {name} [m/s^2]", _downhill(angle, mu, gravity), expected, 1e-2)


def super_ellipsoid_constants() -> Iterator[Measurement]:
    """C3: the section at height z is a Lame curve scaled by (1 - |z/c|^n)^(1/n). The inertia is read from an impactor
    as a case builds it, with three different radii."""
    radii, mass = np.array([0.10, 0.15, 0.22]), 4.5
    for n in (2.0, 3.0, 4.5):
        section = _unit_integral(lambda x, n=n: (1.0 - x**n) ** (1.0 / n))
        unit_volume = 8.0 * section * _unit_integral(lambda z, n=n: (1.0 - z**n) ** (2.0 / n))
        second_moment = 8.0 * section * _unit_integral(lambda z, n=n: z * z * (1.0 - z**n) ** (2.0 / n))
        (carried,), rigid, _ = ObstacleTable(shape="super-ellipsoid", radii=tuple(radii), degree=n, mass=mass).build()
        yield Measurement(f"volume/(a b c), n = {n} [-]", carried.shape.volume() / np.prod(radii), unit_volume, 1e-6)
        inertia = rigid.inertia
        for axis, (i, j) in enumerate(((1, 2), (2, 0), (0, 1))):
            expected = mass * (radii[i] ** 2 + radii[j] ** 2) * second_moment / unit_volume
            yield Measurement(f"inertia about {'xyz'[axis]}, n = {n} [kg m^2]", inertia[axis], expected, 1e-6)


def closest_points() -> Iterator[Measurement]:
    """C4: closest surface point and normal against brute force, degrees 2 to 4.5, points from 1.8 radii outside to a
    fifth of the radius inside, where "closest" has one answer. Brute force: the surface over a grid of directions in
    the point's octant (the closest point lies there by symmetry), and ever finer grids about the best direction. A
    minimum of a distance is found to the root of rounding, 1e-8."""
    radii, count = np.array([0.175, 0.15, 0.2]), 40
    random = np.random.default_rng(4)
    for n in (2.0, 2.5, 3.0, 3.5, 4.0, 4.5):
        worst = 0.0
        for measure in np.concatenate([random.uniform(1.0, 1.8, count // 2), random.uniform(0.8, 1.0, count // 2)]):
            point = measure * _on_surface(random.normal(size=(1, 3)), radii, n)[0]
            found = np.array(closest_point(*point, *radii, n))
            closest, normal = found[:3], found[3:]
            true = np.sign(point) * _closest_by_search(np.abs(point), radii, n)
            to_point = point - closest
            askew = to_point - to_point.dot(normal) * normal
            worst = max(worst, np.linalg.norm(closest - true), np.linalg.norm(askew))
        title = f"closest point and normal, n = {n}, worst of {count} / a [absolute]"
        yield Measurement(title, worst / radii.max(), 0.0, 1e-6)


def torque_free_top() -> Iterator[Measurement]:
    """R1: a body of three different inertias spins near its intermediate axis and tumbles over. Its angular momentum is
    measured from how it turns: R I R^T w, with the spin w from the attitudes two steps before and after (fourth-order
    difference). Spin times step is 2e-3, and the splitting's error of order (w dt)^2/12, 3e-7. In 10,000 steps, three
    turns, the intermediate axis tips over. How far follows from the two constants alone: where the momentum about the
    axis of largest (or smallest) inertia passes zero, sum L_i^2 = L^2 and sum L_i^2/I_i = 2 E give L_2."""
    radii, mass, rate = np.array([0.10, 0.15, 0.22]), 4.5, 20.0
    shape = SuperEllipsoid(radii, 3.0)
    inertia = shape.inertia(mass)
    momentum = inertia * rate * np.array([0.05, 1.0, 0.08])
    body = RigidBody(mass, inertia, locked=False)
    attitude = RigidState(np.array([0.0, 0.0, 10.0]), quaternion_about(np.array([0.6, 0.0, 0.8]), 0.7))
    attitude.angular_momentum = attitude.rotation @ momentum
    top = Body.of("top", shape, SurfaceLaw(1e6, 0.0, 0.0), body, attitude)
    model = fabric_model(disc(0.1, 0.05), isotropic(1e8, 0.3, 1000.0, 1e-3), bodies=(top,))
    state = start_state(model)
    dt, steps = 2e-3 / rate, 10_000
    quaternions, energies = np.empty((steps + 1, 4)), np.empty(steps + 1)
    for k in range(steps + 1):
        motion = state.bodies.motion[0]
        quaternions[k], energies[k] = motion.quaternion, kinetic_energy(body, motion)
        advance(model, state, dt)

    size = np.linalg.norm(momentum)
    error = np.linalg.norm(_angular_momentum(quaternions, inertia, dt) - attitude.angular_momentum, axis=1) / size
    yield Measurement("angular momentum, largest change / L [absolute]", error.max(), 0.0, 1e-6)
    change = np.abs(energies / energies[0] - 1.0).max()
    yield Measurement("energy, largest change / E [absolute]", change, 0.0, 1e-6)

    twice_energy = np.sum(momentum**2 / inertia)
    outer = inertia.min() if twice_energy * inertia[1] > size**2 else inertia.max()
    turned = np.sqrt((size**2 / outer - twice_energy) / (1.0 / outer - 1.0 / inertia[1])) / size
    axis = _turn(np.array([0.0, 1.0, 0.0]), quaternions[:, :1], quaternions[:, 1:])
    lowest = (axis @ attitude.angular_momentum).min() / size
    yield Measurement("cosine of the intermediate axis to L, tipped over [-]", lowest, -turned, 1e-6)


def _one_node(body: Body) -> Model:
    """A triangle of fixed nodes without fabric; the first, at the origin, has a contact area of 1e-4 m^2."""
    positions = np.array([[0.0, 0.0, 0.0], [-1.0, 0.0, -1.0], [-1.0, 1.0, -1.0]])
    surface, gravity = Surface.build(np.array([[0, 1, 2]]), np.zeros(1), ("support",), 3), np.zeros(3)
    gas, bodies = GasPart(NoGas(), surface, positions), Bodies((body,), np.array([1e-4, 0.0, 0.0]), gravity)
    parts = {"gas": gas, "fabric": Fabric(surface, ()), "straps": NO_STRAPS, "bodies": bodies}
    return Model(surface, positions, mass=np.zeros(3), fixed=np.ones(3, dtype=bool), gravity=gravity, **parts)


def _downhill(angle: float, friction: float, gravity: float) -> float:
    """Acceleration [m/s^2] down a plate tilted about y by angle [rad]."""
    normal, down = np.array([np.sin(angle), 0.0, np.cos(angle)]), np.array([np.cos(angle), 0.0, -np.sin(angle)])
    slope, areal = 1e4, 0.24
    fabric = isotropic(0.4e9, 0.3, 800.0, areal / 800.0, damping=0.05)
    flat = disc(0.05, 0.0125)
    shape = BagShape(flat.surface, flat.positions, flat.reference, np.zeros(flat.surface.node_count, dtype=bool))
    depth = areal * gravity * np.cos(angle) * 1e-4 / slope
    across = np.array([0.0, 1.0, 0.0])
    start = flat.positions @ np.array([down, across, normal]) - depth * normal
    pose, law = of_plane(0.0, normal), SurfaceLaw(slope, friction, damping=0.1)
    held = RigidBody(1.0, np.ones(3), locked=True)
    plate = Body.of("plate", HalfSpace(), law, held, RigidState(pose.centre, pose.quaternion))
    model = fabric_model(shape, fabric, start=start, bodies=(plate,), gravity=(0.0, 0.0, -gravity))
    watch = Observer(lambda state: (state.time, float(model.mass @ state.velocities @ down)))
    run(model, Schedule(0.020, 1, 4), watch)
    (early, early_momentum), (late, late_momentum) = watch.rows[1], watch.rows[-1]
    return (late_momentum - early_momentum) / (late - early) / model.mass.sum()


def _unit_integral(function) -> float:
    return quad(function, 0.0, 1.0, epsabs=1e-12, epsrel=1e-12, limit=400)[0]


def _on_surface(directions: np.ndarray, radii: np.ndarray, degree: float) -> np.ndarray:
    """Surface points (n, 3) [m] along directions (n, 3)."""
    return directions / np.sum(np.abs(directions / radii) ** degree, axis=1, keepdims=True) ** (1.0 / degree)


def _closest_by_search(point: np.ndarray, radii: np.ndarray, degree: float) -> np.ndarray:
    polar = azimuth = 0.25 * np.pi
    width, size = 0.25 * np.pi, 91
    while width > 1e-9:
        t, p = np.meshgrid(polar + width * np.linspace(-1.0, 1.0, size), azimuth + width * np.linspace(-1.0, 1.0, size))
        t, p = t.ravel(), p.ravel()
        directions = np.column_stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)])
        surface = _on_surface(directions, radii, degree)
        best = int(np.argmin(np.sum((surface - point) ** 2, axis=1)))
        polar, azimuth = t[best], p[best]
        width, size = 0.2 * width, 21
    return surface[best]


def _angular_momentum(q: np.ndarray, inertia: np.ndarray, dt: float) -> np.ndarray:
    """R I R^T w [kg m^2/s], (n - 4, 3), from unit quaternions (n, 4) every dt [s]; w = 2 dq/dt q^-1."""
    rate = (q[:-4] - 8.0 * q[1:-3] + 8.0 * q[3:-1] - q[4:]) / (12.0 * dt)
    w, v = q[2:-2, :1], q[2:-2, 1:]
    spin = 2.0 * (w * rate[:, 1:] - rate[:, :1] * v - np.cross(rate[:, 1:], v))
    # Into the body's axes and back.
    in_body = _turn(spin, w, -v) * inertia
    return _turn(in_body, w, v)


def _turn(x: np.ndarray, w: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Vectors x turned by quaternions (w, v)."""
    return x + 2.0 * np.cross(v, np.cross(v, x) + w * x)
