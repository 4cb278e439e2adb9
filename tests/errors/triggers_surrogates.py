"""What is wrong with a surrogate, or with what it is to learn from."""

from __future__ import annotations

import builtins
import dataclasses
import sys
from collections.abc import Callable
from types import SimpleNamespace

import numpy as np
from here import Here

from billow.reproductions.rom_paper.jets import compare_jets
from billow.results.dataset_files import Parameter
from billow.rom.judge.evaluate import evaluate
from billow.rom.learn import pod
from billow.rom.learn.dataset import collect
from billow.rom.learn.suggest import suggest
from billow.rom.learn.train import Recipe, train
from billow.rom.surrogate import onnx_export
from billow.rom.surrogate.intervals import Intervals
from billow.rom.surrogate.judgement import UNSEEN, Comparison, Judgement
from billow.rom.surrogate.onnx_export import export_onnx
from billow.rom.surrogate.surrogate import Surrogate
from trust.small_surrogate import small_surrogate

ANSWERABLE = {"permeability": 0.03, "temperature": 600.0}


def ask(design=ANSWERABLE, **options) -> Callable[[Here], object]:
    return lambda here: Surrogate.load(here.bench.surrogate).predict(design, **options)


ONE = (Parameter("a", "A", "-", 0.0, 1.0),)
GASES = (Parameter("gas", "Gas", "-", 0.0, 2.0, ("nitrogen", "helium", "argon")),)


def dataset(parameters=ONE, shape: float = 0.0, train=("0000",)) -> SimpleNamespace:
    """What a surrogate learns from, in memory."""
    return SimpleNamespace(
        title="Made up", parameters=parameters, times=np.array([0.1, 0.2]), reference=np.zeros((4, 3), np.float32),
        triangles=np.array([[0, 1, 2]]), train=train, test=(), trusted=train,
        design=lambda runs: np.zeros((len(runs), len(parameters))),
        snapshots=lambda field, runs: np.full((len(runs), 2, 4, 3), shape, np.float32),
    )  # fmt: skip


def without(here: Here, package: str) -> None:
    def missing(name, *arguments, **options):
        if name == package:
            raise ModuleNotFoundError(f"No module named '{package}'")
        return imported(name, *arguments, **options)

    imported = builtins.__import__
    here.patch.setattr(builtins, "__import__", missing)


def without_torch(here: Here):
    without(here, "torch")
    here.patch.delitem(sys.modules, "billow.rom.learn.network", raising=False)
    here.patch.delattr("billow.rom.learn.network", raising=False)
    train(dataset())


def one_network_each(here: Here):
    made = small_surrogate()
    single = dataclasses.replace(made.regression, recipe="paper")
    dataclasses.replace(made, regression=single).spread(ANSWERABLE)


def bad_factors(here: Here):
    here.patch.setattr(pod, "_orthonormal", lambda matrix: np.linalg.qr(matrix.astype(float))[0] * 1.1)
    pod.pod(np.random.default_rng(1).normal(size=(6, 5)).astype(np.float32), 2)


def diverging(here: Here):
    from billow.rom.learn import network

    network.train_shared(np.ones((8, 3), np.float32), np.full((8, 2), np.nan, np.float32), epochs=1)


def no_test_runs(here: Here):
    made = small_surrogate()
    own = dataset(made.parameters, train=("0000", "0001"))
    own.times, own.reference, own.triangles = made.times, made.reference, made.triangles
    evaluate(own, made)


def without_onnx(here: Here):
    here.patch.setitem(sys.modules, "onnx", None)
    export_onnx(small_surrogate(), here.place / "s.onnx")


def other_level(here: Here):
    known = Intervals(np.array([0.9]), np.ones((1, 3)), np.zeros((3, 3)), np.zeros((3, 4)))
    dataclasses.replace(small_surrogate(), intervals=known).half_width(ANSWERABLE, level=0.3)


def answering_otherwise(here: Here):
    here.patch.setattr(onnx_export, "onnx_bytes", lambda surrogate: b"")
    here.patch.setattr(onnx_export, "largest_difference", lambda *arguments: 1.0)
    export_onnx(small_surrogate(), here.place / "s.onnx")


def with_forces(here: Here):
    onnx_graph_of = dataclasses.replace(small_surrogate(), forces=object())
    here.patch.setattr(onnx_export, "import_onnx", lambda: None)
    export_onnx(onnx_graph_of, here.place / "s.onnx")


def that_lost(here: Here):
    comparison = Comparison("nodes are off by [mm]", "mean trajectory", 9.0, 7.0, ignores_design=True)
    dataclasses.replace(small_surrogate(), judgement=Judgement(UNSEEN, 5, (comparison,))).predict(ANSWERABLE)


def overflowing(here: Here):
    made = small_surrogate().regression
    loud = dataclasses.replace(made, weights=tuple(np.full_like(w, 1e30) for w in made.weights))
    dataclasses.replace(small_surrogate(), regression=loud).predict(ANSWERABLE)


TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-ROM-001": ask({"permeability": 0.03}),
    "E-ROM-002": ask({"permeability": 0.3, "temperature": 600.0}),
    "E-ROM-003": ask(times=[1.0]),
    "E-ROM-004": lambda here: Surrogate.load(here.write("s.safetensors", here.bench.surrogate.read_bytes()[:-9])),
    "E-ROM-005": lambda here: Surrogate.load(here.place / "none"),
    "E-ROM-006": without_torch,
    "E-ROM-007": lambda here: collect(dataset(), ()),
    "E-ROM-008": lambda here: train(dataset(), Recipe("secret")),
    "E-ROM-009": lambda here: collect(dataset(shape=np.nan), ("0000",)),
    "E-ROM-010": lambda here: train(dataset((Parameter("a", "A", "-", 1.0, 1.0),))),
    "E-ROM-011": one_network_each,
    "E-ROM-012": lambda here: evaluate(dataset(), small_surrogate()),
    "E-ROM-013": bad_factors,
    "E-ROM-014": diverging,
    "E-ROM-015": no_test_runs,
    "E-ROM-016": without_onnx,
    "E-ROM-017": lambda here: small_surrogate().half_width(ANSWERABLE),
    "E-ROM-018": other_level,
    "E-ROM-019": with_forces,
    "E-ROM-020": answering_otherwise,
    "E-ROM-021": lambda here: suggest(small_surrogate(), 0, []),
    "E-ROM-023": that_lost,
    "E-ROM-024": overflowing,
    "E-ROM-025": ask(times=[]),
    "E-ROM-026": lambda here: train(dataset(), Recipe(epochs=0)),
    "E-ROM-250": lambda here: train(dataset(GASES), Recipe(clock=True)),
    "E-ROM-022": lambda here: compare_jets(dataset(), dataset(), ("one", "other"), "jet_direction"),
}
