"""A gas, a shape and a fabric law are added by the files that docs/architecture.md names, and by no others.

A copy of the package gets three toys: new files, and an entry in each existing file that the page lists. Then a bag of
the toy fabric, filled with the toy gas, meets the toy obstacle.
"""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import billow

PACKAGE = Path(billow.__file__).parent
PAGE = Path(__file__).parents[2] / "docs" / "architecture.md"

GAS = '''"""A toy: gauge pressure that grows to 20 kPa within a millisecond."""

from dataclasses import dataclass

import numpy as np

from billow.parts.gas.gas_model import GasModel, GasTotals


@dataclass
class PumpState:
    start: float
    volume: float
    triangles: int
    gauge: float = 0.0
    work: float = 0.0


@dataclass(frozen=True)
class Pump(GasModel):
    ambient: float = 101325.0

    def start(self, bag):
        volume = bag.surface.volume(bag.positions)
        return PumpState(volume, volume, bag.surface.triangle_count)

    def advance(self, gas, bag, time, dt, loads):
        before, old = gas.volume, gas.gauge
        gas.volume, gas.gauge = bag.surface.volume(bag.positions), 2e4 * min(1.0, (time + dt) / 1e-3)
        gas.work += (self.ambient + 0.5 * (old + gas.gauge)) * (gas.volume - before)
        loads.gauge[0] = gas.gauge

    def totals(self, gas):
        grown = self.ambient * (gas.volume - gas.start)
        return GasTotals(
            self.ambient + gas.gauge, 295.0, gas.volume, np.zeros(0), 0.0, work=gas.work, ambient_work=grown
        )

    def fields(self, gas):
        return {"gauge": np.full(gas.triangles, gas.gauge)}
'''

SHAPE = '''"""A toy: a ball."""

import math
from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from billow.base.compiled import scalar
from billow.geometry.shapes.shape import NUMBERS


@dataclass(frozen=True)
class Ball:
    radius: float
    kind: ClassVar[str] = "ball"

    @property
    def numbers(self):
        return np.array([self.radius, *[0.0] * (NUMBERS - 1)])

    @property
    def bound(self):
        return self.radius

    size = bound

    def volume(self):
        return 4.0 / 3.0 * math.pi * self.radius**3

    def inertia(self, mass):
        return np.full(3, 0.4 * mass * self.radius**2)

    def distance(self, points):
        far = np.linalg.norm(points, axis=1)
        return far - self.radius, points / np.maximum(far, 1e-12)[:, None]

    def level(self, points):
        return np.sum(points**2, axis=-1) - self.radius**2

    def describe(self):
        return {"kind": self.kind, "radius": self.radius}

    @classmethod
    def from_description(cls, described):
        return cls(described["radius"])


@scalar
def near_ball(numbers, pose, rx, ry, rz, tx, ty, tz):
    far = math.sqrt(rx * rx + ry * ry + rz * rz)
    near = far < numbers[0] + math.sqrt(tx * tx + ty * ty + tz * tz) and far > 0.0
    over = max(far, 1e-12)
    return near, numbers[0] - far, rx / over, ry / over, rz / over


@scalar
def farthest_of_ball(numbers, dx, dy, dz):
    scale = numbers[0] / math.sqrt(dx * dx + dy * dy + dz * dz)
    return scale * dx, scale * dy, scale * dz
'''

TABLE = '''class Ball(ObstacleTable):
    """A free ball above the bag."""

    shape: Literal["ball"]
    """ball"""
    name: Name = "ball"
    """Name in results."""
    radius: quantity("m", 5e-3, 5.0) = 0.1
    """Radius."""

    def build(self):
        shape = BallShape(self.radius)
        start = RigidState(np.array([0.0, 0.0, self.radius + 0.02]), velocity=np.array([0.0, 0.0, -5.0]))
        return (Carried(shape),), RigidBody(1.0, shape.inertia(1.0), locked=False), start


'''

LAW = '''"""A toy: isotropic fabric, S = young E, in NumPy."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from billow.base.compiled import CHUNK
from billow.parts.fabric.membrane import ENERGY, HYSTERESIS, POWER, SQUARED_RATE, STRETCH, VOLUMES


@dataclass(frozen=True)
class Rubber:
    density: float
    thickness: float
    damping: float
    young: float = 4e8
    compression: ClassVar[bool] = True
    history_width: ClassVar[int] = 0

    @property
    def wave_speed(self):
        return float(np.sqrt(self.young / self.density))

    @property
    def warp_modulus(self):
        return self.young

    def along_yarns(self, reference_inverse):
        return reference_inverse

    def concerns(self, altitude, setting):
        return iter(())

    def squared_rate(self, membrane):
        return (1.5 * self.wave_speed / membrane.altitude) ** 2 * membrane.lightness.max(axis=1)

    def add_forces(self, membrane, corners, positions, velocities, history, loads, partial):
        node, d = corners.node, membrane.reference_inverse.T.reshape(-1, 2, 2)

        def gradient(field):
            x = field[node]
            return np.stack([x[:, 1] - x[:, 0], x[:, 2] - x[:, 0]], axis=2) @ d

        f, rate = gradient(positions), gradient(velocities)
        strain = 0.5 * (np.swapaxes(f, 1, 2) @ f - np.eye(2))
        speed = 0.5 * (np.swapaxes(rate, 1, 2) @ f + np.swapaxes(f, 1, 2) @ rate)
        viscous = membrane.viscosity[:, None, None] * speed
        pull = membrane.volume[:, None, None] * (f @ (self.young * strain + viscous)) @ np.swapaxes(d, 1, 2)
        a, b, c = np.swapaxes(positions[node], 0, 1)
        third = np.cross(b - a, c - a) / 6.0
        volume = np.sum((a - positions[0]) * third, axis=1)
        loads[corners.first[0] : corners.first[-1]] = 0.0
        for k, force in enumerate((pull.sum(axis=2), -pull[:, :, 0], -pull[:, :, 1])):
            np.add.at(loads, corners.entry[:, k], np.hstack([force, third]))
        energy = 0.5 * self.young * membrane.volume * np.sum(strain**2, axis=(1, 2))
        power = membrane.volume * np.sum(viscous * speed, axis=(1, 2))
        stretch = 1.0 + 2.0 * np.abs(strain).sum(axis=2).max(axis=1)
        starts = np.arange(0, len(energy), CHUNK)
        partial[:, ENERGY], partial[:, POWER] = np.add.reduceat(energy, starts), np.add.reduceat(power, starts)
        partial[:, STRETCH], partial[:, HYSTERESIS] = np.maximum.reduceat(stretch, starts), 0.0
        partial[:, SQUARED_RATE] = np.maximum.reduceat(membrane.squared_rate * stretch, starts)
        partial[:, VOLUMES:] = 0.0
        np.add.at(partial[0], VOLUMES + 1 + membrane.behind, volume)
        np.add.at(partial[0], VOLUMES + 1 + membrane.ahead, -volume)
'''

NEW = {
    "parts/gas/pump.py": GAS,
    "geometry/shapes/ball.py": SHAPE,
    "parts/fabric/rubber.py": LAW,
}


def imports(module: str, name: str, before: str) -> tuple[str, str]:
    """An import before the first one of another module."""
    return f"from {before}", f"from {module} import {name}\nfrom {before}"


ENTRIES = {
    "case/gas/models.py": [
        imports("billow.parts.gas.pump", "Pump", "billow.parts.gas.no_gas"),
        ("GAS_MODELS = {", 'GAS_MODELS = {\n    "pump": Kind(lambda case, shape, supply: Pump(), has_supply=False),'),
    ],
    "geometry/shapes/kinds.py": [
        imports("billow.geometry.shapes.ball", "Ball, farthest_of_ball, near_ball", "billow.geometry.shapes.box"),
        ("SuperEllipsoid, Box, Mesh, Cylinder)", "SuperEllipsoid, Box, Mesh, Cylinder, Ball)"),
        (
            "    return near_cylinder(",
            "    if number == 5:\n        return near_ball(numbers, pose, rx, ry, rz, tx, ty, tz)\n"
            "    return near_cylinder(",
        ),
        (
            "    return farthest_of_super_ellipsoid(",
            "    if number == 5:\n        return farthest_of_ball(numbers, dx, dy, dz)\n"
            "    return farthest_of_super_ellipsoid(",
        ),
    ],
    "case/obstacles/obstacles.py": [
        imports("billow.geometry.shapes.ball", "Ball as BallShape", "billow.geometry.shapes.half_space"),
        ("OBSTACLES: dict", TABLE + "OBSTACLES: dict"),
        ('    "plate": Plate,', '    "ball": Ball,\n    "plate": Plate,'),
    ],
    "case/fabric/schema_fabric.py": [("LAWS = {", 'LAWS = {"rubber": "moduli", ')],
    "case/fabric/build_fabric.py": [
        imports("billow.parts.fabric.rubber", "Rubber", "billow.parts.fabric.linear_law"),
        (
            "BUILDERS = {",
            "BUILDERS = {\n"
            '    "rubber": lambda fabric, common: Rubber(common["density"], common["thickness"], common["damping"]),',
        ),
    ],
}
"""Existing file -> (line it has, line with the entry before or in it)."""

CASE = {
    "bag": {"element_size": 0.05, "straps": {"count": 0}},
    "gas": {"model": "pump"},
    "fabric": {"law": "rubber"},
    "obstacles": [{"shape": "plate"}, {"shape": "ball", "radius": 0.08}],
    "run": {"end_time": 0.006, "frames": 2, "histories_per_frame": 4},
}
PROGRAM = """
import json, sys, billow
from billow.run.check import describe
case = billow.Case.from_dict(json.loads(sys.argv[1]))
describe(case)
result = billow.simulate(case, sys.argv[2])
ball = result.body("ball")
print(json.dumps({
    "verdicts": {line["name"]: line["verdict"] for line in result.record["quality"]["criteria"]},
    "speed": [float(ball.velocity[0, 2]), float(ball.velocity[-1, 2])],
    "pressure": float(result.gas.pressure[-1]), "strain": float(result.gas.strain[-1]),
    "kinds": [shape["kind"] for shape in result.record["obstacles"]], "from": billow.__file__,
}))
"""


def listed(row: str) -> set[str]:
    """Existing files of the package that the table of the page lists for a row."""
    line = next(line for line in PAGE.read_text(encoding="utf-8").splitlines() if line.startswith(f"| {row} |"))
    existing = line.split("|")[3]
    return {name for name in re.findall(r"`([\w/]+\.py)`", existing) if (PACKAGE / name).is_file()}


def test_a_toy_gas_a_toy_shape_and_a_toy_law_run_together(tmp_path):
    package = tmp_path / "billow"
    shutil.copytree(PACKAGE, package, ignore=shutil.ignore_patterns("__pycache__"))
    for name, text in NEW.items():
        (package / name).write_text(text, encoding="utf-8")
    for name, entries in ENTRIES.items():
        text = (package / name).read_text(encoding="utf-8")
        for line, entry in entries:
            assert line in text, f"{name}: {line}"
            text = text.replace(line, entry, 1)
        (package / name).write_text(text, encoding="utf-8")
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, json.dumps(CASE), str(tmp_path / "run")],
        env={**os.environ, "PYTHONPATH": str(tmp_path)}, capture_output=True, text=True, timeout=300,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["from"].startswith(str(tmp_path))
    assert found["kinds"] == ["plate", "ball"]
    assert found["pressure"] == pytest.approx(101325.0 + 2e4)
    assert found["strain"] > 1.0  # the fabric bears the pressure
    assert found["speed"][0] == -5.0
    assert found["speed"][1] > -4.5  # the bag has met the ball
    wrong = [name for name, verdict in found["verdicts"].items() if verdict == "FAIL"]
    assert wrong == []


def test_the_page_lists_the_files_that_get_an_entry():
    """At most three existing files for a gas, two for a shape and for a law."""
    gas, shape, law = listed("a gas"), listed("a shape"), listed("a fabric law")
    assert set(ENTRIES) <= gas | shape | law
    assert (len(gas), len(shape), len(law)) <= (3, 2, 2)
    assert shape == {"geometry/shapes/kinds.py", "case/obstacles/obstacles.py"}
