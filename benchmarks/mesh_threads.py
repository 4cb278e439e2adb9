"""Wall and processor time of a step of the mesh gas with one thread and with two, in turn.

    python benchmarks/mesh_threads.py [--cell 0.008] [--rounds 9]

A sphere of 0.28 m that shrinks, of 20,480 triangles, with four species; at 8 mm 180,000 cells. The ratio of wall times
is that of the whole gas, cutting included. It says something only on a quiet machine: the load is printed beside it.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Iterator

import numba
import numpy as np

from billow.apps.verification.gas import supply
from billow.apps.verification.mesh_gas import SOUND, moved
from billow.apps.verification.scenes import sphere
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.mesh_gas import MeshGas
from billow.parts.gas.mesh.setup import VAN_LEER
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.species import SPECIES

NAMES = ("N2", "O2", "H2O", "CO2")
AIR = Ambient(101325.0, 300.0, np.array([0.7, 0.2, 0.05, 0.05]))
RADIUS, SPEED, SUBDIVISIONS = 0.28, 0.01 * SOUND, 5
TRIES = 3
"""Steps in a row with as many threads."""


def shrinking(cell: float) -> Iterator[float]:
    """Steps of the gas in cells of this size [m]; yields the time after each."""
    shape = sphere(RADIUS, SUBDIVISIONS)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    gas = MeshGas(supply([SPECIES[n] for n in NAMES], AIR, (), bag.surface.chambers), bag.surface, 1.0, cell, VAN_LEER)
    state = gas.start(bag)
    cells, fragments = len(state.sheets[0].key), len(gas.cut(state)[0].fragments.triangle)
    print(f"{cells:,} cells, {fragments:,} fragments", flush=True)
    return moved(gas, state, lambda t: shape.positions * (1.0 - SPEED * t / RADIUS), 1.0)


def timed(steps: Iterator[float], threads: int) -> tuple[float, float]:
    """Least wall and processor time [s] of a step with so many threads."""
    numba.set_num_threads(threads)
    found = []
    for _ in range(TRIES):
        begun, spent = time.perf_counter(), time.process_time()
        next(steps)
        found.append((time.perf_counter() - begun, time.process_time() - spent))
    return min(found)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cell", type=float, default=0.008)
    parser.add_argument("--rounds", type=int, default=9)
    arguments = parser.parse_args()
    steps = shrinking(arguments.cell)
    for threads in (1, 2):  # compiles
        timed(steps, threads)
    rounds = np.array([[timed(steps, 1), timed(steps, 2)] for _ in range(arguments.rounds)])
    (wall, spent), (wall_2, spent_2) = 1e3 * np.median(rounds, axis=0)
    print(f"one thread {wall:.0f} ms ({spent:.0f} ms of processor time), two {wall_2:.0f} ms ({spent_2:.0f} ms)")
    print(f"two threads are {np.median(rounds[:, 0, 0] / rounds[:, 1, 0]):.2f} times as fast as one")
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} processors")


if __name__ == "__main__":
    main()
