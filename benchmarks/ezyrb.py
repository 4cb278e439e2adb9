"""One deployment by Billow and by EZyRB, learned from the same snapshots: `python benchmarks/ezyrb.py --study STUDY`.

EZyRB (https://github.com/mathLab/EZyRB, MIT) is the open library for POD with interpolation. It is installed into a
virtual environment of its own, which borrows NumPy and PyTorch from this one. Both get the snapshots of the study's
training runs, repeated to 10,000 nodes; one EZyRB model for each component, with 12 modes and the ROM paper's network
(25, 45, 15), trained for a moment only: its answers take equally long however good they are. Measured with one thread
each, and with as many as the libraries take by themselves. They answer in turn, each in its own process, and again;
medians count. Each process also measures what copying a deployment costs, so that a slow phase of the machine shows.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import sysconfig
import tempfile
import time
import venv
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np

from billow.results.dataset import Dataset
from billow.rom.learn.train import Recipe, train

VERSION = "1.3.3"
NODES, MODES, REPEATS, ROUNDS = 10_000, 12, 30, 3
THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")

PEER = """
import json, sys, time
import numpy as np
import torch
from ezyrb import ANN, POD, Database, ReducedOrderModel

data = np.load(sys.argv[1])
repeats, modes = int(sys.argv[2]), int(sys.argv[3])
models, seconds = [], {}
begun = time.process_time()
for component in data["snapshots"]:
    network = ANN([25, 45, 15], torch.nn.Tanh(), [5], frequency_print=1000)
    pod = POD("randomized_svd", rank=modes)
    models.append(ReducedOrderModel(Database(data["points"], component), pod, network).fit())
seconds["fit"] = time.process_time() - begun
asked = data["asked"]

def deployment():
    return [model.predict(asked) for model in models]

answer = np.stack([np.asarray(part.snapshots_matrix if hasattr(part, "snapshots_matrix") else part, np.float32)
                   for part in deployment()])
assert answer.shape == (3, len(asked), data["snapshots"].shape[2]), answer.shape
target = np.empty_like(answer)
for name, call in (("deployment", deployment), ("copy", lambda: np.copyto(target, answer))):
    taken = []
    for _ in range(repeats):
        begun = time.perf_counter()
        call()
        taken.append(time.perf_counter() - begun)
    seconds[name] = float(np.median(taken))
print(json.dumps(seconds))
"""


def install(place: Path) -> Path:
    """A virtual environment with EZyRB; returns its Python."""
    venv.create(place, with_pip=True)
    python = place / "bin" / "python"
    packages = subprocess.run(
        [python, "-c", "import sysconfig; print(sysconfig.get_path('purelib'))"],
        check=True,
        capture_output=True,
        text=True,
    ).stdout.strip()
    Path(packages, "borrowed.pth").write_text(sysconfig.get_path("purelib") + "\n")
    subprocess.run([python, "-m", "pip", "install", "--quiet", f"ezyrb=={VERSION}"], check=True)
    return python


def peer_seconds(python: Path, dataset: Dataset, design: np.ndarray) -> dict[str, float]:
    """What EZyRB takes: fit [CPU s], deployment and copy [s]."""
    shapes = dataset.snapshots("displacement", dataset.train)
    repeat = -(-NODES // shapes.shape[2])
    wide = np.tile(shapes.transpose(3, 0, 1, 2).reshape(3, -1, shapes.shape[2]), (1, 1, repeat))[:, :, :NODES]
    low, high = (np.array([getattr(p, side) for p in dataset.parameters]) for side in ("low", "high"))

    def with_times(designs):
        unit, time_unit = (designs - low) / (high - low), dataset.times / dataset.times[-1]
        rows = np.repeat(unit, len(time_unit), axis=0)
        return np.column_stack([rows, np.tile(time_unit, len(unit))])

    with tempfile.TemporaryDirectory() as place:
        data = Path(place, "data.npz")
        points = with_times(dataset.design(dataset.train))
        np.savez(data, snapshots=wide, points=points, asked=with_times(design[None]))
        command = [python, "-c", PEER, str(data), str(REPEATS), str(MODES)]
        done = subprocess.run(command, cwd=place, check=True, capture_output=True, text=True)
    return json.loads(done.stdout.strip().splitlines()[-1])


class Widened:
    """A dataset whose nodes are repeated up to `NODES`."""

    def __init__(self, dataset: Dataset):
        self._dataset, self._repeat = dataset, -(-NODES // len(dataset.reference))
        self.reference = np.tile(dataset.reference, (self._repeat, 1))[:NODES]

    def __getattr__(self, name):
        return getattr(self._dataset, name)

    def snapshots(self, field: str, runs) -> np.ndarray:
        return np.tile(self._dataset.snapshots(field, runs), (1, 1, self._repeat, 1))[:, :, :NODES]


def own_seconds(dataset: Dataset, design: np.ndarray) -> dict[str, float]:
    """What Billow takes: fit [CPU s], deployment and copy [s]."""
    begun = time.process_time()
    surrogate = train(Widened(dataset), Recipe(modes=MODES, epochs=5, calibrate=False))
    seconds = {"fit": time.process_time() - begun}
    answer = np.ascontiguousarray(surrogate.predict(design))
    target = np.empty_like(answer)
    for name, call in (
        ("deployment", lambda: surrogate.predict(design)),
        ("copy", lambda: np.copyto(target, answer)),
    ):
        taken = []
        for _ in range(REPEATS):
            begun = time.perf_counter()
            call()
            taken.append(time.perf_counter() - begun)
        seconds[name] = float(np.median(taken))
    return seconds


def medians(rounds: list[dict[str, float]]) -> dict[str, float]:
    return {name: float(np.median([seconds[name] for seconds in rounds])) for name in rounds[0]}


def compare(python: Path, study: Path) -> None:
    """Print a row for each of the two, and the ratio."""
    dataset = Dataset.open(study)
    design = dataset.design(dataset.test[:1])[0]
    peer, own = [], []
    for _ in range(ROUNDS):
        peer.append(peer_seconds(python, dataset, design))
        with ProcessPoolExecutor(1, get_context("spawn")) as another:  # which reads the number of threads anew
            own.append(another.submit(own_seconds, dataset, design).result())
    threads = os.environ.get(THREADS[0], "default")
    for name, seconds in ((f"EZyRB {VERSION}", medians(peer)), ("Billow", medians(own))):
        times = f"{1e3 * seconds['deployment']:.2f} ms | {seconds['deployment'] / seconds['copy']:.1f}"
        print(f"| {name} | {threads} | {times} |", flush=True)
    ratios = [a["deployment"] / b["deployment"] for a, b in zip(peer, own, strict=True)]
    print(f"| ratio (aim: 8) | {threads} | {', '.join(f'{ratio:.1f}' for ratio in ratios)} | |", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--study", type=Path, default=Path("demo/study"), help="a finished study (default: the demo's)")
    parser.add_argument("--environment", type=Path, help="keep EZyRB's virtual environment here (default: a new one)")
    asked = parser.parse_args()
    with tempfile.TemporaryDirectory() as place:
        environment = asked.environment or Path(place, "environment")
        python = environment / "bin" / "python" if (environment / "bin" / "python").exists() else install(environment)
        print("| one deployment, 10,000 nodes, three components | threads | time | x copying its output |")
        print("|---|---|---|---|")
        os.environ.update(dict.fromkeys(THREADS, "1"))
        compare(python, asked.study)
        for variable in THREADS:
            del os.environ[variable]
        compare(python, asked.study)


if __name__ == "__main__":
    sys.exit(main())
