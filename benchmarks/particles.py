"""Cost of the corpuscular gas' flight: nanoseconds per particle and step, bytes per particle.

    python benchmarks/particles.py [--particles 250000] [--element 0.0068]

One thread. Process time, median and fastest step, because shared machines stretch wall time. The bag is a full driver
bag (0.56 m across, 0.32 m deep) of 32,000 triangles, standing or breathing; particles are those of 650 K.
"""

from __future__ import annotations

import argparse
import os
import time

os.environ.setdefault("NUMBA_NUM_THREADS", "1")

import numpy as np

from billow.gas.corpuscular.audit import find_escaped
from billow.gas.corpuscular.flight import Flock, fly
from billow.gas.corpuscular.impact_bank import Hits, ImpactBank
from billow.gas.corpuscular.walls import Walls
from billow.geometry.bag_shapes import round_bag
from billow.geometry.search_grid import SearchGrid

RADIUS, HALF_DEPTH, SPEED, MASS = 0.28, 0.16, 431.0, 2e-7
SORT_EVERY = 4


def full_bag(element: float):
    """Triangles and positions [m] of a full bag, made from a flat one of 0.70 m."""
    bag = round_bag(0.35, round(0.35 / element), 0.002)
    positions = bag.positions.copy()
    radius = np.hypot(positions[:, 0], positions[:, 1]) / 0.35
    positions[:, :2] *= RADIUS / 0.35
    positions[:, 2] = np.sign(positions[:, 2]) * HALF_DEPTH * np.sqrt(np.maximum(0.0, 1.0 - radius**2))
    return bag.surface.triangles, positions


def full_flock(particles: int, rng: np.random.Generator) -> Flock:
    """Gas at rest that fills the bag up to 1 % of its depth."""
    place = np.empty((0, 3))
    while len(place) < particles:
        ball = rng.uniform(-1.0, 1.0, (particles, 3))
        place = np.concatenate([place, ball[(ball**2).sum(axis=1) < 0.98]])
    return Flock(
        place[:particles] * [RADIUS, RADIUS, HALF_DEPTH], rng.normal(0.0, SPEED, (particles, 3)),
        np.zeros(particles, np.int32), np.arange(particles), np.zeros(particles, np.int32),
        np.full(particles, -1, np.int32),
    )  # fmt: skip


def sort(flock: Flock, grid: SearchGrid) -> None:
    """Gather every array of the flock in the order of cells."""
    order = grid.order(flock.position)
    for name, values in vars(flock).items():
        setattr(flock, name, values[order])


def fastest(call, repeats: int = 3) -> float:
    """Process time [s] of the fastest of a few calls."""
    times = []
    for _ in range(repeats):
        begun = time.process_time()
        call()
        times.append(time.process_time() - begun)
    return min(times)


def measure(particles: int, element: float, dt: float, breathing: float, steps: int = 24) -> dict[str, str]:
    """Cost of each part. breathing: speed [m/s] at which the front goes up and down."""
    triangles, shape = full_bag(element)
    n, t = particles, len(triangles)
    walls = Walls.build(triangles, np.zeros(t), np.full(t, -1))
    flock, hits, bank = full_flock(n, np.random.default_rng(1)), Hits.empty(n), ImpactBank.empty(t)
    area, tight = np.full(t, 1e-5), np.zeros(t)
    grid, start = SearchGrid.build(triangles, shape, shape), shape
    find_escaped(flock, walls, grid, start)
    flights, whole, hit_count = [], [], 0
    for step in range(-2, steps):
        end = shape * [1.0, 1.0, 1.0 + breathing / HALF_DEPTH * dt * ((step + 2) % 20)]
        clock = [time.process_time()]
        if step % SORT_EVERY == 0:
            sort(flock, grid)
        clock.append(time.process_time())
        grid = grid.follow(triangles, start, end)
        clock.append(time.process_time())
        tally = fly(flock, np.array([MASS]), walls, grid, start, end, dt, tight, 0.0, 1, step + 2, hits, bank)
        clock.append(time.process_time())
        bank.smooth(area, dt, 2e-4)
        clock.append(time.process_time())
        start = end
        if step >= 0:  # the first two compile
            flights.append(clock[3] - clock[2])
            whole.append(clock[4] - clock[0])
            hit_count += tally.hits
    audit = fastest(lambda: find_escaped(flock, walls, grid, start))
    rebuild = fastest(lambda: SearchGrid.build(triangles, start, start))
    flying_bytes = sum(v.nbytes for v in vars(flock).values())
    hit_bytes = hits.numbers.nbytes + hits.triangle.nbytes
    scale = 1e9 / n
    return {
        "flight": f"{scale * np.median(flights):.0f} ns per particle (fastest {scale * min(flights):.0f})",
        "whole step": f"{scale * np.mean(whole):.0f} ns per particle: mean, with sorting, lists, smoothing",
        "hits": f"{hit_count / steps / n:.4f} per particle and step",
        "audit": f"{scale * audit:.0f} ns per particle, every 0.1 ms: {scale * audit * dt / 1e-4:.1f} ns per step",
        "lists": f"{1e3 * rebuild:.1f} ms to make, {(grid.first.nbytes + grid.listed.nbytes) / 1e6:.1f} MB",
        "memory": f"{flying_bytes / n:.0f} bytes per particle, and {hit_bytes / n:.0f} for hits",
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=int, default=250_000)
    parser.add_argument("--element", type=float, default=0.0068, help="element size [m]")
    arguments = parser.parse_args()
    for dt, breathing in ((2e-6, 0.0), (5e-6, 0.0), (5e-6, 30.0)):
        print(f"step {1e6 * dt:.0f} us, front at {breathing:.0f} m/s")
        for what, value in measure(arguments.particles, arguments.element, dt, breathing).items():
            print(f"  {what:12} {value}")


if __name__ == "__main__":
    main()
