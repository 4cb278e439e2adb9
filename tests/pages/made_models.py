"""Surrogates and coupled models that nobody trained: random networks over a bag by formula. They answer at once, and
what the page makes of them must be what Python makes of them."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from billow.results.dataset_files import Parameter
from billow.rom.coupled.calibration import Calibration
from billow.rom.coupled.coupled_model import STATE, Coupled
from billow.rom.coupled.impactor import ContactLaw, ImpactorOfDesign
from billow.rom.coupled.injury_metrics import METRICS, InjuryModel, LogLinear
from billow.rom.coupled.motion_errors import CURVES
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.clock import Clock
from billow.rom.surrogate.intervals import LEVELS, Intervals
from billow.rom.surrogate.judgement import UNSEEN, Comparison, Judgement
from billow.rom.surrogate.polynomial import count as terms_of
from billow.rom.surrogate.regression import BY_CLOCK, InputScaling, OutputScaling, Regression
from billow.rom.surrogate.surrogate import Surrogate

PARAMETERS = (
    Parameter("permeability", "Airbag permeability", "-", 0.02, 0.035),
    Parameter("temperature", "Inflator temperature", "K", 500.0, 800.0),
    Parameter("radius", "Impactor radius", "m", 0.1, 0.2),
)
WON = Judgement(UNSEEN, 4, (Comparison("nodes are off by [mm]", "mean trajectory", 1.0, 2.0, True),))


def made_surrogate(
    nodes: int = 400, *, modes: int = 12, recipe: str = "shared", width: int = 96, title: str = "A bag", seed: int = 1,
    parameters=PARAMETERS, clock: bool = False,
) -> Surrogate:  # fmt: skip
    """A closed bag of about `nodes` nodes that swells to 0.2 m, with random networks. clock: of random rates,
    by which some designs get as far as it reaches"""
    random = np.random.default_rng(seed)
    reference, triangles = globe(nodes)
    nodes, times = len(reference), np.linspace(0.0, 0.05, 26)
    low, high = (np.array([getattr(p, side) for p in parameters]) for side in ("low", "high"))
    shapes = np.linalg.qr(random.normal(size=(nodes, modes)))[0].T
    bases = tuple(Basis(shapes.astype(np.float32), np.linspace(2.0, 0.1, modes), 10.0) for _ in range(3))
    inputs, scaled, by = InputScaling(low, high, 0.0, 0.05, recipe), times, None
    if clock:
        by = Clock(random.normal(0.0, 0.2, (terms_of(len(parameters), True), 8)), 0.05, 0.045)
        inputs, scaled = replace(inputs, end=by.end, frequencies=BY_CLOCK), np.linspace(0.0, by.reach, 61)
    count = 3 * modes
    networks, last = (3, count) if recipe == "shared" else (count, 1)
    sizes = [inputs.width, width, width, last]
    weights, biases = random_layers(random, networks, sizes)
    grows = np.linspace(0.0, 1.0, len(scaled))[:, None] * random.normal(0.0, 0.3, count)
    outputs = OutputScaling(scaled, grows.astype(np.float32), np.full((len(scaled), count), 0.1, np.float32))
    intervals = None
    if recipe == "shared":
        lost = random.random((3, len(times))) * 1e-6, random.random((3, nodes)) * 1e-6
        intervals = Intervals(np.array(LEVELS), np.outer([0.7, 1.3, 1.7, 2.0], [1.0, 1.1, 1.2]), *lost)
    designs = low + random.random((9, len(parameters))) * (high - low)
    return Surrogate(
        title=title, parameters=tuple(parameters), times=times, reference=reference, triangles=triangles, bases=bases,
        regression=Regression(recipe, weights, biases, inputs, outputs, by),
        training={"runs": [f"{k:04d}" for k in range(9)], "mesh_sha256": "0"}, designs=designs, intervals=intervals,
        judgement=WON,
    )  # fmt: skip


def made_coupled(**changes) -> Coupled:
    """The same with a sphere of 5 kg that falls onto it, and a random force within reach."""
    surrogate, random = made_surrogate(**changes), np.random.default_rng(7)
    affine = np.zeros((12, 1 + len(PARAMETERS)))
    affine[:3, 3] = 1.0  # radii are the third parameter
    affine[3, 0], affine[6, 0], affine[7, 0], affine[8, 0], affine[11, 0] = 3.0, 0.42, 20.0, 5.0, -4.0
    inputs = InputScaling(surrogate.regression.inputs.low, surrogate.regression.inputs.high, 0.0, 0.05, "shared", STATE)
    weights, biases = random_layers(random, 2, [inputs.width, 24, 3])
    outputs = OutputScaling(np.array([0.0, 0.05]), np.zeros((2, 3), np.float32), np.full((2, 3), 900.0, np.float32))
    law = ContactLaw(Regression("shared", weights, biases, inputs, outputs), np.zeros(STATE), np.full(STATE, 0.05))
    times, metrics = np.linspace(0.0, 0.05, 501), len(METRICS)
    rows = 1 + len(PARAMETERS)
    half = {name: np.full((len(times), 3), 0.5 + k) for k, name in enumerate(CURVES)}
    fit = LogLinear(random.normal(0.0, 0.3, (rows, metrics)) + 1.0, 0.1 * np.eye(rows))
    injury = InjuryModel(fit, np.full(metrics, 1e-6), np.array([True, False, True, False, True]), np.full(metrics, 0.2))
    lost = Judgement(UNSEEN, 4, (Comparison("HIC36 is off by [%]", "mean of the training runs", 9.0, 5.0, True),))
    calibration = Calibration(half, injury, lost)
    gravity = np.array([0.0, 0.0, -9.81])
    return Coupled(surrogate, ImpactorOfDesign("head", affine), law, times, gravity, calibration, WON)


def random_layers(random, networks: int, sizes: list[int]):
    weights = tuple(
        random.normal(0.0, 1.2 / np.sqrt(a), (networks, a, b)).astype(np.float32) for a, b in pairwise(sizes)
    )
    biases = tuple(random.normal(0.0, 0.2, (networks, 1, b)).astype(np.float32) for b in sizes[1:])
    return weights, biases


def globe(nodes: int) -> tuple[np.ndarray, np.ndarray]:
    """A closed, flattened globe: [m], (nodes, 3) float32 and (triangles, 3) int64, outwards."""
    rings = max(3, round(np.sqrt(nodes / 2)))
    around = max(3, nodes // rings)
    up = np.pi * ((np.arange(rings) + 0.5) / rings - 0.5)[:, None]
    turn = 2.0 * np.pi * np.arange(around) / around
    ring = np.stack(
        np.broadcast_arrays(0.3 * np.cos(up) * np.cos(turn), 0.3 * np.cos(up) * np.sin(turn), 0.2 + 0.15 * np.sin(up)),
        -1,
    )
    points = np.concatenate([ring.reshape(-1, 3), [[0.0, 0.0, 0.05], [0.0, 0.0, 0.35]]]).astype(np.float32)
    i, j = np.meshgrid(np.arange(rings - 1), np.arange(around), indexing="ij")
    a, b = (i * around + j).ravel(), (i * around + (j + 1) % around).ravel()
    j, south, north = np.arange(around), len(points) - 2, len(points) - 1
    top = (rings - 1) * around
    caps = [
        np.stack([0 * j + south, (j + 1) % around, j], 1),
        np.stack([0 * j + north, top + j, top + (j + 1) % around], 1),
    ]
    quads = [np.stack([a, b, a + around], 1), np.stack([b, b + around, a + around], 1)]
    return points, np.concatenate([*quads, *caps])
