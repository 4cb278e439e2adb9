"""Cost of making and asking a reduced-order model at the paper's size and beyond: `python benchmarks/rom.py`.

Snapshots are synthetic, made block by block from sixty smooth shapes whose weights depend on the design and fall off as
a bag's do, with noise on top: what they look like does not matter for time and memory. One thread, CPU seconds (the
machine may be shared); what making the snapshots costs is measured and taken off.

paper   20,000 snapshots of 10,000 nodes, three components (400 runs of 50 times): bases and networks; inference
large   200,000 snapshots (4,000 runs), never in memory together: bases and coefficients, with the memory they took
"""

from __future__ import annotations

import argparse
import os
import resource
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

from billow.results.dataset_files import Parameter
from billow.rom.learn.dataset import snapshot_bytes
from billow.rom.learn.reduction import DEFAULT_MEMORY, reduce_runs
from billow.rom.learn.train import Recipe, train

NODES, TIMES, SHAPES = 10_082, 50, 60


class Synthetic:
    """What the reduced-order model asks of a dataset."""

    title, reference_length, test = "Synthetic", 0.28, ()

    def __init__(self, runs: int):
        random = np.random.default_rng(1)
        self.parameters = tuple(Parameter(f"p{k}", f"Parameter {k}", "-", 0.0, 1.0) for k in range(6))
        self.times = np.linspace(1e-3, 0.05, TIMES)
        self.train = self.trusted = tuple(f"{n:04d}" for n in range(runs))
        self.reference = random.random((NODES, 3), dtype=np.float32)
        self.triangles = np.array([[0, 1, 2]])
        self._designs = random.random((runs, 6))
        self._shapes = random.standard_normal((3, SHAPES, NODES), dtype=np.float32)
        self._waves = random.standard_normal((SHAPES, 7)) * np.array([1.0] * 6 + [6.0])
        self._size = (0.1 * np.arange(1, SHAPES + 1) ** -1.2).astype(np.float32)
        self._noise = (1e-4 * random.standard_normal((2 * TIMES, NODES, 3))).astype(np.float32)
        self.seconds = 0.0

    def design(self, runs) -> np.ndarray:
        return self._designs[[int(run) for run in runs]]

    def snapshots(self, field: str, runs) -> np.ndarray:
        begun = time.process_time()
        answer = np.empty((len(runs), TIMES, NODES, 3), np.float32)
        unit = self.times / self.times[-1]
        for place, (run, design) in enumerate(zip(runs, self.design(runs), strict=True)):
            asked = np.column_stack([np.tile(design, (TIMES, 1)), unit])
            weights = (np.sin(asked @ self._waves.T) * unit[:, None]).astype(np.float32) * self._size
            for component in range(3):
                answer[place, ..., component] = weights @ self._shapes[component]
            first = int(run) % TIMES
            answer[place] += self._noise[first : first + TIMES]
        self.seconds += time.process_time() - begun
        return answer


def peak_bytes() -> int:
    """Largest resident size of this process so far."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def row(what: str, value: str) -> None:
    print(f"| {what} | {value} |", flush=True)


def paper() -> None:
    """Bases and networks of 400 runs, and answers of the result."""
    dataset = Synthetic(400)
    begun = time.process_time()
    surrogate = train(dataset, Recipe(calibrate=False))
    spent = time.process_time() - begun - dataset.seconds
    size = f"20,000 snapshots of {NODES:,} nodes, three components, 12 modes"
    row(f"bases and networks, {size} (aim: 60 CPU s)", f"{spent:.1f} CPU s, {surrogate.training['epochs']} epochs")
    row("of it networks", f"{surrogate.training['network_seconds']:.1f} s")
    designs = dataset.design(dataset.train[:1])
    answer = np.ascontiguousarray(surrogate.predict(designs[0]))
    target = np.empty_like(answer)
    predict, copy = medians(lambda: surrogate.predict(designs[0]), lambda: np.copyto(target, answer))
    ratio = f"{1e3 * predict:.2f} ms, {predict / copy:.1f} x copying its output"
    row("one deployment (aim: at most 4 x copying its output)", ratio)
    many = np.random.default_rng(2).random((1_000, 6))
    begun = time.process_time()
    top = max(float(shape[-1, :, 2].max()) for shape in surrogate.predict_each(many))
    row("1,000 deployments, one after the other (aim: 2 CPU s)", f"{time.process_time() - begun:.2f} CPU s")
    assert np.isfinite(top)


def medians(*calls, repeats: int = 200) -> list[float]:
    """Median time [s] of each, taken in turn so that a slow phase of the machine hits all alike."""
    taken = np.empty((repeats, len(calls)))
    for times in taken:
        for k, call in enumerate(calls):
            begun = time.perf_counter()
            call()
            times[k] = time.perf_counter() - begun
    return np.median(taken, axis=0).tolist()


def large(runs: int) -> None:
    """Bases and coefficients of runs that are read block by block."""
    dataset = Synthetic(runs)
    before, begun, wall = peak_bytes(), time.process_time(), time.perf_counter()
    reduction = reduce_runs(dataset, dataset.train, 12, 0)
    spent, wall = time.process_time() - begun - dataset.seconds, time.perf_counter() - wall
    size = snapshot_bytes(dataset, dataset.train)
    row(f"{runs * TIMES:,} snapshots of {NODES:,} nodes", f"{size / 2**30:.1f} GiB, limit {DEFAULT_MEMORY / 2**30:.0f}")
    row("bases and coefficients", f"{spent:.0f} CPU s (making the snapshots twice took {dataset.seconds:.0f} more)")
    row("wall", f"{wall:.0f} s")
    row("peak memory", f"{peak_bytes() / 2**30:.2f} GiB, {before / 2**30:.2f} of it before")
    outside = [np.sqrt(1.0 - basis.energy_fraction[-1]) for basis in reduction.bases]
    row("outside the bases", ", ".join(f"{part:.4f}" for part in outside))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("what", choices=("paper", "large", "all"), nargs="?", default="all")
    parser.add_argument("--runs", type=int, default=4_000, help="runs of `large`")
    asked = parser.parse_args()
    print("| what | measured |\n|---|---|")
    if asked.what in ("large", "all"):  # first: its peak is that of the whole process
        large(asked.runs)
    if asked.what in ("paper", "all"):
        paper()


if __name__ == "__main__":
    main()
