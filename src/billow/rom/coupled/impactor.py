"""The free obstacle of a study: the body of a design, how it moved, and the contact force on it, recorded and learned.

A surrogate has parameters, not cases. How the parameters change the body (radii, degree, place, attitude, mass, speed)
is read from the cases of the training runs: each property must be an affine function of the design. The force is
learned from their histories: networks map design, time, area vectors of the fabric within reach of the body and its
velocity to the mean force over the next `EVERY` intervals (docs/theory.md, Contact force on a free obstacle).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from billow.base.errors import InputError
from billow.geometry.shapes.pose import above_bag, quaternion_about, rotation_matrix
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.injury.criteria import mean_acceleration
from billow.injury.filters import channel_filter
from billow.results.result import Result
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Progress
from billow.rom.learn.train import import_network
from billow.rom.surrogate.regression import InputScaling, OutputScaling, Regression

NO_FREE_OBSTACLE = InputError.declare(
    "E-CPL-003",
    "the study has no free obstacle",
    where="case of run {run}",
    why="a coupled model moves the obstacle, and this one is locked or a plate",
    remedy="set obstacles.impactor.locked to false in the case of the study",
)
NOT_AFFINE = InputError.declare(
    "E-CPL-004",
    "the obstacle is not an affine function of the design",
    where="{runs} training runs",
    cause="a property that is no affine function of the parameters, or fewer training runs than parameters",
    remedy="vary radii, degree, clearance, angle, mass or velocity each by a parameter of its own",
)

NO_BODY = InputError.declare(
    "E-CPL-008",
    "the design has no possible obstacle",
    where="design",
    why="its {name} would be {value:.4g}",
    cause="a design far outside the trained ranges, or a file by another program",
    remedy="ask inside the trained ranges",
)

PROPERTIES = (
    *("radius a [m]", "radius b [m]", "radius c [m]", "degree [-]"),
    *("centre x [m]", "centre y [m]", "centre z [m]", "angle about x [deg]"),
    *("mass [kg]", "velocity x [m/s]", "velocity y [m/s]", "velocity z [m/s]"),
)
LEAST_SIZE, MOST_SIZE = 1e-6, 1e6
"""[m], [kg]: of radii and mass, and the most of any property."""
MOST_DEGREE = 100.0
EXACT = 1e-6
"""Largest residual of a property over the largest value of it: case files hold ten digits."""

FORCE_CLASS = 180
"""Channel frequency class of the forces that are learned."""

REACHES = (5e-3, 20e-3)
"""[m]: about the error of a surrogate, and well beyond it."""

FARTHEST = 7.0
"""Reaches beyond which fabric does not count: its weight is below 1e-3."""

EVERY = 4
"""Intervals of the histories for which a force is held: 0.4 ms at 10 kHz, short against what CFC 180 lets through."""

EPOCHS = 20
LEAST_DEVIATION = 1e-9
"""[m^2] and [m/s]: of a state that never changes."""
STATE_NOISE = 0.05
"""Random disturbance of the state inputs while learning, over their deviation: a closed loop visits states that no run
went through, and must not drift further away because of them."""


@dataclass(frozen=True)
class Impactor:
    """A super-ellipsoid in a start position: radii [m], (3,); degree [-]; centre [m], (3,); rotation, body to space,
    (3, 3); mass [kg]; velocity [m/s], (3,)."""

    radii: np.ndarray
    degree: float
    centre: np.ndarray
    rotation: np.ndarray
    mass: float
    velocity: np.ndarray

    def distance_to(self, nodes: np.ndarray, centre: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Distance of nodes [m] (nodes, 3) from the surface about `centre` [m], negative inside: [m], (nodes,), to
        first order, and outward normals (nodes, 3)."""
        shape = SuperEllipsoid(self.radii, self.degree)
        distance, normal = shape.distance((nodes - centre) @ self.rotation)
        return distance, normal @ self.rotation.T


@dataclass(frozen=True, eq=False)
class ImpactorOfDesign:
    """name: of the obstacle; affine: (properties, 1 + parameters) float64, in the units of `PROPERTIES`."""

    name: str
    affine: np.ndarray

    @classmethod
    def learn(cls, dataset: Dataset, runs) -> ImpactorOfDesign:
        """From the cases of `runs`. Raises InputError E-CPL-003 without a free super-ellipsoid, E-CPL-004 if a property
        is no affine function of the design, or the runs are too few to tell."""
        bodies = [_free_body(dataset.result(run).case_toml, run) for run in runs]
        design = np.asarray(dataset.design(runs), float)
        rows = np.column_stack([np.ones(len(runs)), design])
        scale = np.abs(rows).max(axis=0)
        values = np.array([_properties(body) for body in bodies])
        affine, _, rank, _ = np.linalg.lstsq(rows / scale, values, rcond=None)
        wrong = np.abs(rows / scale @ affine - values).max(axis=0) > EXACT * np.maximum(np.abs(values).max(axis=0), 1.0)
        if rank < rows.shape[1] or len(runs) <= rows.shape[1] or wrong.any():
            why = f"they are too few for {rows.shape[1] - 1} parameters"
            fixed = [p.name for p, column in zip(dataset.parameters, design.T, strict=True) if np.ptp(column) == 0.0]
            if fixed:
                why = f"{', '.join(fixed)} has one value in all of them: nothing shows what it does to the obstacle"
            elif len(runs) > rows.shape[1] and rank < rows.shape[1]:
                why = "their designs are copies of few, or lie on a line: they do not tell the parameters apart"
            if wrong.any():
                why = f"{PROPERTIES[int(wrong.argmax())]} of {bodies[0]['name']} is not affine in the parameters"
            raise NOT_AFFINE(runs=len(runs), why=why)
        return cls(bodies[0]["name"], np.ascontiguousarray((affine / scale[:, None]).T))

    def __call__(self, design: np.ndarray) -> Impactor:
        """The body of one design: (parameters,), in their own units. InputError E-CPL-008 if there is none."""
        p = self.affine @ np.concatenate([[1.0], design])
        bounds = dict.fromkeys((0, 1, 2, 8), (LEAST_SIZE, MOST_SIZE)) | {3: (1.0, MOST_DEGREE)}
        for row, value in enumerate(p):
            least, most = bounds.get(row, (-MOST_SIZE, MOST_SIZE))
            if not least <= value <= most:
                raise NO_BODY(name=PROPERTIES[row], value=value)
        rotation = rotation_matrix(quaternion_about(np.array([1.0, 0.0, 0.0]), np.radians(p[7])))
        return Impactor(p[:3], float(p[3]), p[4:7], rotation, float(p[8]), p[9:])


def _free_body(case: dict, run: str) -> dict:
    for obstacle in case.get("obstacles", ()):
        if obstacle.get("shape") == "super-ellipsoid" and not obstacle.get("locked", True):
            return obstacle
    raise NO_FREE_OBSTACLE(run=run)


def _properties(body: dict) -> list[float]:
    radii = body["radii"] if isinstance(body["radii"], list) else [body["radii"]] * 3
    centre = above_bag(radii[2], body["clearance"], body["offset"], 0.0).centre
    return [*radii, body["degree"], *centre, body["angle_about_x"], body["mass"], *body["velocity"]]


@dataclass(frozen=True, eq=False)
class ImpactorMotion:
    """times: [s], (times,); centre: [m], (times, 3); velocity: [m/s], (times, 3)."""

    times: np.ndarray
    centre: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of_run(cls, result: Result, name: str) -> ImpactorMotion:
        """The free obstacle `name` of a finished run."""
        body = result.body(name)
        return cls(result.histories.time, body.centre, body.velocity)

    @property
    def displacement(self) -> np.ndarray:
        """From the start: [m], (times, 3)."""
        return self.centre - self.centre[0]

    def acceleration(self, channel_class: int | None = None) -> tuple[np.ndarray, np.ndarray]:
        """Middles of the intervals [s], (times - 1,), and mean accelerations over them [m/s^2], (times - 1, 3),
        filtered if a channel frequency class is given."""
        middles, acceleration = mean_acceleration(self.times, self.velocity)
        if channel_class is not None:
            acceleration = channel_filter(middles, acceleration, channel_class)
        return middles, acceleration


def filtered_force(motion: ImpactorMotion, mass: float, gravity: np.ndarray) -> np.ndarray:
    """Contact force on a body from how it moved, filtered to `FORCE_CLASS`: [N], (times - 1, 3). mass: [kg]; gravity:
    [m/s^2], (3,)."""
    return mass * (motion.acceleration(FORCE_CLASS)[1] - gravity)


def recorded_force(result: Result, name: str) -> np.ndarray:
    """Contact force on the free obstacle `name` as the solver recorded it, filtered to `FORCE_CLASS`: [N],
    (times - 1, 3), mean of the two ends of each interval of the histories."""
    force, times = result.body(name).force, result.histories.time
    return channel_filter(0.5 * (times[1:] + times[:-1]), 0.5 * (force[1:] + force[:-1]), FORCE_CLASS)


def area_vectors(nodes: np.ndarray, area: np.ndarray, body: Impactor, centre: np.ndarray) -> np.ndarray:
    """Area vectors of all `REACHES`: [m^2], (reaches, 3). nodes: [m], (nodes, 3); area: fabric of each node [m^2],
    (nodes,); centre: of the body now [m], (3,)."""
    # |y_k| <= a_k G along each axis: a node so far outside its box is out of reach before any power is taken.
    far = FARTHEST * max(REACHES)
    outside = np.abs((nodes - centre) @ body.rotation) - body.radii
    near = (outside < far).all(axis=1)
    nodes, area = nodes[near], area[near]
    distance, normal = body.distance_to(nodes, centre)
    weights = area * np.exp(-np.maximum(distance, 0.0) / np.array(REACHES)[:, None])
    return -weights @ normal


def node_area(reference: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Fabric of each node in the start shape: [m^2], (nodes,), a third of each of its triangles."""
    a, b, c = (reference[triangles[:, k]].astype(float) for k in range(3))
    third = np.linalg.norm(np.cross(b - a, c - a), axis=1) / 6.0
    return np.bincount(triangles.ravel(), np.repeat(third, 3), minlength=len(reference))


@dataclass(frozen=True, eq=False)
class ContactLaw:
    """regression: from design, time and scaled state to a force [N] with components x, y, z
    mean, deviation: of the state, (state,) float64, as `scaled` needs them
    """

    regression: Regression
    mean: np.ndarray
    deviation: np.ndarray

    def __call__(self, design: np.ndarray, time: float, state: np.ndarray) -> np.ndarray:
        """Mean force over a step around `time`: [N], (3,). design: (parameters,); state: (state,)."""
        further = ((state - self.mean) / self.deviation).astype(np.float32)[None, None]
        return self.regression(design[None], np.array([time]), further)[0, 0].astype(float)


def learn_contact_law(
    inputs: InputScaling, design, times, state, force, seed: int, progress: Progress | None = None
) -> ContactLaw:
    """Learn a law from runs. inputs: scaling of design and time; design: (runs, parameters); times: [s], (steps,), the
    middle of each step; state: (runs, steps, state); force: [N], (runs, steps, 3)."""
    mean = state.mean(axis=(0, 1))
    deviation = np.maximum(state.std(axis=(0, 1)), LEAST_DEVIATION)
    scaling = replace(inputs, recipe="shared", further=state.shape[-1])
    size = np.full((2, 3), force.std(axis=(0, 1)).max())
    outputs = OutputScaling(np.array([inputs.start, inputs.end]), np.zeros((2, 3), np.float32), size.astype(np.float32))
    noise = STATE_NOISE * np.random.default_rng(seed).standard_normal(state.shape)
    features = scaling(design, times, (state - mean) / deviation + noise)
    targets = (force / size[0]).reshape(-1, 3).astype(np.float32)
    weights, biases = import_network().train_shared(features, targets, epochs=EPOCHS, seed=seed, progress=progress)
    return ContactLaw(Regression("shared", weights, biases, scaling, outputs), mean, deviation)
