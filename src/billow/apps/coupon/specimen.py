"""Specimens of the fabric test bench: a flat mesh, which nodes the clamps hold, and where they take them.

Warp lies along x, weft along y. `amount` is what the machine prescribes: the strain of the clamps, or the shear angle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.geometry.surface import Surface


@dataclass(frozen=True)
class Sheet:
    """Flat rectangle of fabric: surface, flat: node coordinates [m], (nodes, 2), length and width [m]."""

    surface: Surface
    flat: np.ndarray
    length: float
    width: float

    @property
    def on_edge(self) -> np.ndarray:
        """(nodes,) bool."""
        x, y = np.abs(self.flat[:, 0]), np.abs(self.flat[:, 1])
        return (x > 0.5 * self.length * (1.0 - 1e-9)) | (y > 0.5 * self.width * (1.0 - 1e-9))

    def pull(self, force: np.ndarray, axis: int) -> float:
        """Force [N] of the clamps on the two edges across an axis, averaged. force: [N], (nodes, 3), of the fabric."""
        along, length = self.flat[:, axis], (self.length, self.width)[axis]
        far, near = along > 0.5 * length * (1.0 - 1e-9), along < -0.5 * length * (1.0 - 1e-9)
        return float(0.5 * (force[near, axis].sum() - force[far, axis].sum()))


def sheet(length: float, width: float, element_size: float) -> Sheet:
    """Rectangle [m] about the origin of quads split along alternating diagonals, so that none is preferred."""
    nx, ny = (max(2, 2 * round(0.5 * side / element_size)) for side in (length, width))
    x, y = np.meshgrid(np.linspace(-0.5, 0.5, nx + 1) * length, np.linspace(-0.5, 0.5, ny + 1) * width, indexing="ij")
    i, j = (g.ravel() for g in np.meshgrid(np.arange(nx), np.arange(ny), indexing="ij"))
    a = i * (ny + 1) + j
    b, c, d = a + ny + 1, a + ny + 2, a + 1
    even = ((i + j) % 2 == 0)[:, None]
    first = np.where(even, np.column_stack([a, b, c]), np.column_stack([a, b, d]))
    second = np.where(even, np.column_stack([a, c, d]), np.column_stack([b, c, d]))
    triangles = np.concatenate([first, second])
    flat = np.column_stack([x.ravel(), y.ravel()])
    surface = Surface.build(triangles, np.zeros(len(triangles)), ("fabric",), len(flat))
    return Sheet(surface, flat, length, width)


class Specimen:
    """A test. curves: what it measures; clamped: (nodes,) bool; axis: along which the machine pulls; mounted: stretch
    of the sheet in the clamps before the test [-]."""

    curves: tuple[str, ...]
    sheet: Sheet
    clamped: np.ndarray
    axis = 0
    mounted = 1.0

    def places(self, amount: float) -> np.ndarray:
        """Where the clamped nodes are, [m], (clamped, 2)."""
        raise NotImplementedError

    def measure(self, amount: float, positions: np.ndarray, force: np.ndarray) -> tuple[list[float], list[float]]:
        """Strain [-] (shear angle [rad]) and force per current width [N/m] of each curve.

        positions: [m], (nodes, 3); force: [N], (nodes, 3), of the fabric on its nodes.
        """
        raise NotImplementedError

    def machine_force(self, amount: float, force: np.ndarray) -> float:
        """Force of the machine along its travel [N]."""
        return self.sheet.pull(force, self.axis)


class Biaxial(Specimen):
    """Square held by clamps along all four edges that stretch it equally along warp and weft."""

    curves = ("warp", "weft")

    def __init__(self, side: float, element_size: float):
        self.sheet = sheet(side, side, element_size)
        self.clamped = self.sheet.on_edge

    def places(self, amount: float) -> np.ndarray:
        return np.exp(amount) * self.sheet.flat[self.clamped]

    def measure(self, amount: float, positions: np.ndarray, force: np.ndarray) -> tuple[list[float], list[float]]:
        stretch = np.exp(amount)
        pulls = [self.sheet.pull(force, axis) / (stretch * self.sheet.width) for axis in (0, 1)]
        return [amount, amount], pulls


class Strip(Specimen):
    """Strip with clamped ends and free sides, pulled along warp or weft; strain is measured in its middle half.

    For weft the specimen is turned: it lies along y.
    """

    def __init__(self, length: float, width: float, element_size: float, direction: str = "warp"):
        self.axis = ("warp", "weft").index(direction)
        self.curves = (direction,)
        self.sheet = sheet(*((length, width) if self.axis == 0 else (width, length)), element_size)
        along = self.sheet.flat[:, self.axis]
        self.clamped = np.abs(along) > 0.5 * length * (1.0 - 1e-9)
        self.gauge = [np.abs(along - side * 0.25 * length) < 0.6 * element_size for side in (-1.0, 1.0)]
        self.waist = np.abs(along) < 0.6 * element_size

    def places(self, amount: float) -> np.ndarray:
        stretch = np.ones(2)
        stretch[self.axis] = np.exp(amount)
        return stretch * self.sheet.flat[self.clamped]

    def measure(self, amount: float, positions: np.ndarray, force: np.ndarray) -> tuple[list[float], list[float]]:
        low, high = (positions[g, self.axis].mean() for g in self.gauge)
        flat_low, flat_high = (self.sheet.flat[g, self.axis].mean() for g in self.gauge)
        across = positions[self.waist, 1 - self.axis]
        pull = self.sheet.pull(force, self.axis) / (across.max() - across.min())
        return [float(np.log((high - low) / (flat_high - flat_low)))], [pull]


class PictureFrame(Specimen):
    """Square in a frame of four hinged bars, pulled along its diagonal: pure shear by the angle `amount` [rad].

    The force along the diagonal d = 2 L cos(pi/4 - amount/2) is F = T L / sin(pi/4 - amount/2), with T the shear force
    per length that works on the angle (docs/theory.md, Verification cases, S9: energy balance of the frame).

    Yarns are mounted slightly taut, as on a real bench. Slack ones cost nothing to shorten, so that the sheet would
    rather do that here and there than shear evenly (2 % less force at 40 degrees).
    """

    curves = ("shear",)
    mounted = 1.0005

    def __init__(self, side: float, element_size: float):
        self.sheet = sheet(side, side, element_size)
        self.clamped = self.sheet.on_edge

    def places(self, amount: float) -> np.ndarray:
        c, s = np.cos(0.5 * amount), np.sin(0.5 * amount)
        return self.mounted * self.sheet.flat[self.clamped] @ np.array([[c, s], [s, c]])

    def measure(self, amount: float, positions: np.ndarray, force: np.ndarray) -> tuple[list[float], list[float]]:
        lever = np.sin(0.25 * np.pi - 0.5 * amount)
        return [amount], [self.machine_force(amount, force) * lever * self.mounted / self.sheet.length]

    def machine_force(self, amount: float, force: np.ndarray) -> float:
        c, s = 0.5 * np.cos(0.5 * amount), 0.5 * np.sin(0.5 * amount)
        turning = self.sheet.flat[self.clamped] @ np.array([[-s, c], [c, -s]])  # per rate of the angle, and per stretch
        power = -np.sum(force[self.clamped, :2] * turning)
        return float(power / (self.sheet.length * np.sin(0.25 * np.pi - 0.5 * amount)))
