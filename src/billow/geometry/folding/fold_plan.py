"""How a bag of two panels is folded: the lines that its meshes need rows of nodes on, and the map to the folded
start."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np

from billow.base.errors import InputError
from billow.geometry.bag_shapes import BagShape
from billow.geometry.flat_cut import signed_areas
from billow.geometry.folding.curve import FoldCurve, Spiral, Straight
from billow.geometry.folding.folds import Fold
from billow.geometry.rectangle_mesh import MARGIN, Row
from billow.geometry.surface import Surface

THROUGH_THE_MOUTH = InputError.declare(
    "E-GEO-040",
    "fold {fold} goes through the mouth",
    where="bag.folds, fold {fold}",
    why="its crease begins {there:.3g} m from the mouth's axis; the mouth and the elements around it need {need:.3g} m",
    cause="a line too close to the retainer ring, or a middle of the bag where the mouth is",
    remedy="move the line outwards, or reduce bag.mouth_radius or bag.element_size",
)
ACROSS_AGAIN = InputError.declare(
    "E-GEO-045",
    "fold {fold} comes back to a direction that was folded before",
    where="bag.folds, fold {fold}",
    why="its stack lies across the fold lines of that direction already, and no row of nodes would meet its line",
    cause="folds across x, then y, then x again",
    remedy="write all folds across one axis after each other",
)

BESIDE = 1.05
"""Width of an element beside a crease, at least, in lengths of half its turn: the next row lies on the straight."""


@dataclass(frozen=True)
class Stage:
    """Folds across one axis, one after the other: the axis (0 is x, 1 is y), the line of the stack, and the height [m]
    of the stack's middle above the bag's."""

    across: int
    curve: FoldCurve
    middle: float


@dataclass(frozen=True)
class FoldPlan:
    """mouth: (x, y) [m] of its centre, from which the folds count. half: from the bag's middle to a panel [m]. steps:
    the stages after each of the user's folds."""

    mouth: tuple[float, float]
    half: float
    steps: tuple[tuple[Stage, ...], ...]

    @classmethod
    def of(
        cls, folds: tuple[Fold, ...], outline: np.ndarray, mouth: tuple[float, float], mouth_radius: float, size: float
    ) -> FoldPlan:
        """The plan of folds in their order. outline: least and greatest (x, y) [m] of the flat bag, (2, 2); size: edge
        length of the mesh [m].

        Raises InputError E-GEO-040 (through the mouth), E-GEO-041..044 (of a fold), E-GEO-045 (a direction again).
        """
        half = 0.25 * min(fold.gap for fold in folds)
        done: tuple[Stage, ...] = ()
        steps: dict[int, tuple[Stage, ...]] = {}  # by number of the fold: both sides are one
        thick, middle = half, 0.0
        for across, group in itertools.groupby(folds, lambda fold: fold.across):
            own = list(group)
            if any(stage.across == across for stage in done):
                raise ACROSS_AGAIN(fold=own[0].number)
            low, high = outline[:, across] - mouth[across]
            curve = FoldCurve.flat(low, high, thick, own[0].gap)
            for fold in own:
                curve = fold.applied(curve, size)
                _require_mouth_free(curve, fold, mouth_radius + MARGIN * size)
                steps[fold.number] = (*done, Stage(across, curve, middle))
            done = steps[own[-1].number]
            bottom, top = curve.height
            thick, middle = 0.5 * (top - bottom), middle + 0.5 * (top + bottom)
        return cls(mouth, half, tuple(steps.values()))

    @property
    def stages(self) -> tuple[Stage, ...]:
        """Of the bag folded to the end."""
        return self.steps[-1]

    def until(self, count: int) -> FoldPlan:
        """The plan that ends after so many of the user's folds, at least one."""
        return replace(self, steps=self.steps[:count])

    @property
    def keeps_lengths(self) -> bool:
        """Whether the map stretches no yarn: one direction, nothing rolled."""
        return len(self.stages) == 1 and not any(isinstance(p, Spiral) for p in self.stages[0].curve.pieces)

    def rows(self, across: int) -> tuple[Row, ...]:
        """Where the mesh needs rows of nodes along an axis, ascending: the middle of every crease."""
        turns = [turn for stage in self.stages if stage.across == across for turn in stage.curve.turns]
        shift = self.mouth[across]
        return tuple(sorted(Row(shift + t.middle, BESIDE * 0.5 * np.pi * t.radius) for t in turns))

    def pressed(self, shape: BagShape) -> np.ndarray:
        """Positions [m], (nodes, 3), of the bag laid flat: rear panel at z = 0, front panel above, sewn nodes between.
        shape: lying flat in x and y."""
        return np.column_stack([shape.positions[:, :2], self.half * (1.0 + panel_side(shape, shape.positions))])

    def folded(self, pressed: np.ndarray) -> np.ndarray:
        """Where points of the pressed bag [m], (n, 3), go."""
        points = pressed - self._origin
        for stage in self.stages:
            s, height = points[:, stage.across], points[:, 2] - stage.middle
            x, z = stage.curve.place(s, height)
            points = _with(points, stage.across, x, z + stage.middle)
        return points + self._origin

    def unfolded(self, folded: np.ndarray) -> np.ndarray:
        """The inverse of `folded`, that knows only where the points are; nan where they are on no sheet."""
        points = folded - self._origin
        for stage in reversed(self.stages):
            s, height = stage.curve.unfold(points[:, stage.across], points[:, 2] - stage.middle)
            points = _with(points, stage.across, s, height + stage.middle)
        return points + self._origin

    @property
    def _origin(self) -> np.ndarray:
        """The bag's middle at the mouth [m], (3,)."""
        return np.array([*self.mouth, self.half])

    def applied(self, shape: BagShape) -> BagShape:
        """The shape at its folded start; all but its positions is that of the flat bag."""
        return replace(shape, positions=self.folded(self.pressed(shape)))

    def vents_on(self, surface: Surface, flat: np.ndarray, axis: int, place: float) -> dict[str, tuple[float, float]]:
        """Vents that a fold line at `place` [m] along an axis goes through, and from where to where on it [m]. flat:
        where the nodes lie on the flat bag [m], (nodes, 3)."""
        found = {}
        for name, kind in zip(surface.part_names, surface.part_kinds, strict=True):
            if kind == "vent":
                rim = flat[surface.triangles[surface.triangles_of(name)].ravel()]
                if rim[:, axis].min() < place < rim[:, axis].max():
                    found[name] = (float(rim[:, 1 - axis].min()), float(rim[:, 1 - axis].max()))
        return found

    @property
    def layers(self) -> int:
        """Layers of fabric over each other, at most."""
        return 2 * int(np.prod([stage.curve.sheets for stage in self.stages]))


def _with(points: np.ndarray, axis: int, along: np.ndarray, z: np.ndarray) -> np.ndarray:
    moved = points.copy()
    moved[:, axis], moved[:, 2] = along, z
    return moved


def panel_side(shape: BagShape, flat: np.ndarray) -> np.ndarray:
    """1 for nodes of the front panel, -1 for those of the rear one, 0 for those that are sewn, (nodes,). flat: where
    the nodes lie on the flat bag [m], (nodes, 3)."""
    surface = shape.surface
    facing = np.sign(signed_areas(flat[surface.triangles][:, :, :2]))
    facing[surface.triangles_of_kind("opening")] = 0.0
    front, rear = np.zeros((2, surface.node_count), dtype=bool)
    front[surface.triangles[facing > 0.0]] = True
    rear[surface.triangles[facing < 0.0]] = True
    return front.astype(float) - rear


def _require_mouth_free(curve: FoldCurve, fold: Fold, need: float) -> None:
    low, high = curve.pieces[0].begin, curve.pieces[-1].end
    base = next(piece for piece in curve.pieces if piece.begin <= 0.0 <= piece.end)
    reach = min(
        np.inf if base.begin == low else -base.begin,
        np.inf if base.end == high else base.end,
    )  # fmt: skip
    if not isinstance(base, Straight) or base.direction < 0 or base.z != 0.0 or reach < need:
        raise THROUGH_THE_MOUTH(fold=fold.number, there=max(0.0, reach), need=need)
