"""Cost of the corpuscular gas: its flight alone, its whole step beside that, how both grow, bytes per particle.

    python benchmarks/particles.py [--particles 50000 100000 250000 500000] [--element 0.0068]

Process time, medians, because shared machines stretch wall time. The bag is a full driver bag (0.56 m across, 0.32 m
deep) of 32,000 triangles, standing or breathing; particles are those of 650 K.
"""

from __future__ import annotations

import argparse
import time

import numba
import numpy as np

from billow.geometry.bag_shapes import round_bag
from billow.geometry.search_grid import SearchGrid
from billow.parts.gas.corpuscular import corpuscular
from billow.parts.gas.corpuscular.corpuscular import Corpuscular
from billow.parts.gas.corpuscular.flight import Flock, Motion, WallResponse, fly
from billow.parts.gas.corpuscular.impact_bank import Hits, ImpactBank
from billow.parts.gas.corpuscular.inside_points import Enclosure
from billow.parts.gas.corpuscular.walls import Walls
from billow.parts.gas.corpuscular.winding_number import audit
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.supply.ambient import Ambient
from billow.parts.gas.supply.species import AIR, SPECIES, thermo_table
from billow.parts.gas.supply.supply import Supply

RADIUS, HALF_DEPTH, SPEED, MASS = 0.28, 0.16, 431.0, 2e-7
SORT_EVERY = 4


def full_bag(element: float):
    """A flat bag of 0.70 m, and positions [m] of its nodes when it is full."""
    bag = round_bag(0.35, round(0.35 / element), 0.002)
    positions = bag.positions.copy()
    radius = np.hypot(positions[:, 0], positions[:, 1]) / 0.35
    positions[:, :2] *= RADIUS / 0.35
    positions[:, 2] = np.sign(positions[:, 2]) * HALF_DEPTH * np.sqrt(np.maximum(0.0, 1.0 - radius**2))
    return bag, positions


def full_flock(particles: int, rng: np.random.Generator) -> Flock:
    """Gas at rest that fills the bag up to 1 % of its depth."""
    place = np.empty((0, 3))
    while len(place) < particles:
        ball = rng.uniform(-1.0, 1.0, (particles, 3))
        place = np.concatenate([place, ball[(ball**2).sum(axis=1) < 0.98]])
    return Flock(
        place[:particles] * [RADIUS, RADIUS, HALF_DEPTH], rng.normal(0.0, SPEED, (particles, 3)),
        np.zeros(particles, np.int32), np.arange(particles), np.zeros(particles, np.int32),
        np.full(particles, -1, np.int32), np.zeros(particles, np.int32), np.zeros(particles, np.int32),
    )  # fmt: skip


def sorted_by_cell(flock: Flock, grid: SearchGrid) -> Flock:
    """The flock in the order of the cells."""
    order = np.argsort(grid.cells_of(flock.position), kind="stable")
    return Flock(*(values[order] for values in flock))


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
    bag, shape = full_bag(element)
    triangles = bag.surface.triangles
    n, t = particles, len(triangles)
    walls = Walls.build(triangles, bag.surface.chambers)
    flock, hits, bank = full_flock(n, np.random.default_rng(1)), Hits.empty(n), ImpactBank.empty(t)
    area, response = np.full(t, 1e-5), WallResponse(np.zeros(t), np.zeros(t, np.int32), np.empty(0))
    grid, start = SearchGrid.build(triangles, shape, shape), shape
    audit(flock, Enclosure(triangles, start, bag.surface.chambers))
    flights, whole, hit_count = [], [], 0
    for step in range(-2, steps):
        end = shape * [1.0, 1.0, 1.0 + breathing / HALF_DEPTH * dt * ((step + 2) % 20)]
        clock = [time.process_time()]
        if step % SORT_EVERY == 0:
            flock = sorted_by_cell(flock, grid)
        clock.append(time.process_time())
        grid = grid.follow(triangles, start, end)
        clock.append(time.process_time())
        motion = Motion(start, end, dt)
        tally = fly(flock, np.array([MASS]), walls, grid, motion, response, hits, bank, 1, step + 2)
        clock.append(time.process_time())
        bank.smooth(area, dt, 2e-4)
        clock.append(time.process_time())
        start = end
        if step >= 0:  # the first two compile
            flights.append(clock[3] - clock[2])
            whole.append(clock[4] - clock[0])
            hit_count += tally.hits
    audited = fastest(lambda: audit(flock, Enclosure(triangles, start, bag.surface.chambers)))
    rebuild = fastest(lambda: SearchGrid.build(triangles, start, start))
    flying_bytes = sum(v.nbytes for v in flock)
    hit_bytes = hits.numbers.nbytes + hits.triangle.nbytes
    scale = 1e9 / n
    return {
        "flight": f"{scale * np.median(flights):.0f} ns per particle (fastest {scale * min(flights):.0f})",
        "whole step": f"{scale * np.mean(whole):.0f} ns per particle: mean, with sorting, lists, smoothing",
        "hits": f"{hit_count / steps / n:.4f} per particle and step",
        "audit": f"{scale * audited:.0f} ns per particle, every 0.5 ms: {scale * audited * dt / 5e-4:.1f} ns per step",
        "lists": f"{1e3 * rebuild:.1f} ms to make, {(grid.first.nbytes + grid.listed.nbytes) / 1e6:.1f} MB",
        "memory": f"{flying_bytes / n:.0f} bytes per particle, and {hit_bytes / n:.0f} for hits",
    }


class FlightClock:
    """Stands in for the flight of the gas and adds up what it takes [s]: process time and wall time."""

    def __init__(self):
        self.process = self.wall = 0.0

    def __call__(self, *arguments):
        process, wall = time.process_time(), time.perf_counter()
        tally = fly(*arguments)
        self.process += time.process_time() - process
        self.wall += time.perf_counter() - wall
        return tally


def gas_step(particles: int, element: float, dt: float = 4e-6, steps: int = 20) -> tuple[float, float, float]:
    """Process time of a whole gas step and of its flight, and wall time of the former [s], medians over the gas steps
    of a standing full bag of air at 650 K; dt: of the structure."""
    bag, shape = full_bag(element)
    table = thermo_table([SPECIES[name] for name in AIR])
    fractions = np.array(list(AIR.values())) / table[:, 0]  # by mass
    air = Ambient(1.5e5, 650.0, fractions / fractions.sum())
    supply = Supply(table, tuple(AIR), (), air, bag.surface.chambers)
    gas = Corpuscular(supply, bag.surface, bag.reference, particles)
    now = Bag(bag.surface, shape, np.zeros_like(shape))
    state, push = gas.start(now), np.zeros((len(bag.surface.triangles), 3, 3))
    corpuscular.fly, rows, time_now = FlightClock(), [], 0.0
    while len(rows) < steps + 3:
        before, clock = state.gas_step, FlightClock()
        corpuscular.fly = clock
        process, wall = time.process_time(), time.perf_counter()
        gas.advance(state, now, time_now, dt, push)
        spent = time.process_time() - process, time.perf_counter() - wall
        time_now += dt
        if state.gas_step > before:
            rows.append((spent[0], clock.process, spent[1]))
    corpuscular.fly = fly
    return tuple(np.median(rows[3:], axis=0))  # the first ones compile, sort, and audit


def growth(counts: list[int], element: float) -> None:
    """How the cost of a gas step grows with particles and falls with threads."""
    threads = numba.config.NUMBA_NUM_THREADS
    numba.set_num_threads(1)
    spent = []
    for particles in counts:
        whole, flight, _ = gas_step(particles, element)
        spent.append(whole)
        print(
            f"{particles:8,} particles: {1e9 * whole / particles:.0f} ns per particle and gas step, "
            f"{whole / flight:.2f} of the flight alone"
        )
    if len(counts) > 1:
        print(f"grows with particles to the power {np.polyfit(np.log(counts), np.log(spent), 1)[0]:.3f}")
    one = gas_step(counts[-1], element)[2]
    numba.set_num_threads(threads)
    print(f"{threads} threads: {one / gas_step(counts[-1], element)[2]:.2f} times as fast as one, by wall time")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--particles", type=int, nargs="+", default=[50_000, 100_000, 250_000, 500_000])
    parser.add_argument("--element", type=float, default=0.0068, help="element size [m]")
    arguments = parser.parse_args()
    growth(arguments.particles, arguments.element)
    numba.set_num_threads(1)
    for dt, breathing in ((2e-6, 0.0), (5e-6, 0.0), (5e-6, 30.0)):
        print(f"flight of 250,000, step {1e6 * dt:.0f} us, front at {breathing:.0f} m/s")
        for what, value in measure(250_000, arguments.element, dt, breathing).items():
            print(f"  {what:12} {value}")


if __name__ == "__main__":
    main()
