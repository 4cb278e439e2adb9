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
from billow.geometry.folding.folds import LONGEST, NO_ROOM, THROUGH_A_FOLD, Fold
from billow.geometry.folding.tuck import Tuck
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
    """mouth: (x, y) [m] of its centre, from which the folds count. half: from the flat bag's middle to a panel [m].
    steps: the stages after each of the user's folds. tuck: before them, if there is one; it is a step of its own."""

    mouth: tuple[float, float]
    half: float
    steps: tuple[tuple[Stage, ...], ...]
    tuck: Tuck | None = None

    @classmethod
    def of(
        cls, folds: tuple[Fold, ...], outline: np.ndarray, mouth: tuple[float, float], mouth_radius: float,
        size: float, half: float, tuck: Tuck | None = None,
    ) -> FoldPlan:  # fmt: skip
        """The plan of a tuck, if there is one, and folds in their order. outline: least and greatest (x, y) [m] of the
        flat bag, (2, 2); size: edge length of the mesh [m]; half: from the flat bag's middle to a panel [m].

        Raises InputError E-GEO-040 (through the mouth), E-GEO-041..044 (of a fold), E-GEO-045 (a direction again).
        """
        done: tuple[Stage, ...] = ()
        steps: dict[int, tuple[Stage, ...]] = {}  # by number of the fold: both sides are one
        thick, middle = half, 0.0
        if tuck is not None:
            _require_tuck_fits(tuck, mouth_radius + MARGIN * size, size)
            steps[tuck.number], thick = (), tuck.thick
        for across, group in itertools.groupby(folds, lambda fold: fold.across):
            own = list(group)
            if any(stage.across == across for stage in done):
                raise ACROSS_AGAIN(fold=own[0].number)
            is_tucked = tuck is not None and tuck.across == across
            low, high = tuck.outline if is_tucked else outline[:, across] - mouth[across]
            curve = FoldCurve.flat(low, high, thick, own[0].gap)
            for fold in own:
                curve = fold.applied(curve, size)
                _require_mouth_free(curve, fold, mouth_radius + MARGIN * size)
                if is_tucked:
                    _require_beside_tuck(curve, fold, tuck, size)
                steps[fold.number] = (*done, Stage(across, curve, middle))
            done = steps[own[-1].number]
            bottom, top = curve.height
            thick, middle = 0.5 * (top - bottom), middle + 0.5 * (top + bottom)
        if tuck is not None:
            tuck = replace(tuck, still=_still(tuck, done, size))
        return cls(mouth, half, tuple(steps.values()), tuck)

    @property
    def stages(self) -> tuple[Stage, ...]:
        """Of the bag folded to the end."""
        return self.steps[-1]

    def until(self, count: int) -> FoldPlan:
        """The plan that ends after so many of the user's folds, at least one."""
        return replace(self, steps=self.steps[:count])

    @property
    def keeps_lengths(self) -> bool:
        """Whether the map stretches no yarn: one direction, nothing rolled, nothing tucked."""
        spirals = (isinstance(p, Spiral) for stage in self.stages for p in stage.curve.pieces)
        return self.tuck is None and len(self.stages) == 1 and not any(spirals)

    @property
    def folded_last(self) -> int | None:
        """The axis across which a whole stack is folded, so that its layers bend in one crease; None if none is."""
        before = {stage.across for stage in self.stages[:-1]} | ({self.tuck.across} if self.tuck else set())
        return self.stages[-1].across if self.stages and before - {self.stages[-1].across} else None

    def rows(self, across: int, tucked: bool = True) -> tuple[Row, ...]:
        """Where the mesh needs rows of nodes along an axis, ascending: the middle of every crease, without those of the
        tuck if `tucked` is False."""
        turns = [turn for stage in self.stages if stage.across == across for turn in stage.curve.turns]
        rows = [(turn.middle, turn.radius) for turn in turns]
        if tucked and self.tuck and self.tuck.across == across:
            rows += [(line, self.tuck.half) for line in self.tuck.lines]
        shift = self.mouth[across]
        return tuple(sorted(Row(shift + place, BESIDE * 0.5 * np.pi * radius) for place, radius in rows))

    def pressed(self, shape: BagShape) -> np.ndarray:
        """Positions [m], (nodes, 3), of the bag laid flat: rear panel at z = 0, front panel above, sewn nodes between.
        shape: lying flat in x and y."""
        return np.column_stack([shape.positions[:, :2], self.half * (1.0 + panel_side(shape, shape.positions))])

    def folded(self, pressed: np.ndarray) -> np.ndarray:
        """Where points of the pressed bag [m], (n, 3), go."""
        points = pressed - self._origin(self.half)
        points = self.tuck.place(points) if self.tuck else points
        for stage in self.stages:
            s, height = points[:, stage.across], points[:, 2] - stage.middle
            x, z = stage.curve.place(s, height)
            points = _with(points, stage.across, x, z + stage.middle)
        return points + self._origin(self._thick)

    def unfolded(self, folded: np.ndarray) -> np.ndarray:
        """The inverse of `folded`, that knows only where the points are; nan where they are on no sheet."""
        points = folded - self._origin(self._thick)
        for stage in reversed(self.stages):
            s, height = stage.curve.unfold(points[:, stage.across], points[:, 2] - stage.middle)
            points = _with(points, stage.across, s, height + stage.middle)
        points = self.tuck.unfold(points) if self.tuck else points
        return points + self._origin(self.half)

    @property
    def _thick(self) -> float:
        """From the middle of the bag, pressed and tucked, to its outer panels [m]."""
        return self.tuck.thick if self.tuck else self.half

    def _origin(self, height: float) -> np.ndarray:
        """The bag's middle at the mouth [m], (3,), so high above the rear panel."""
        return np.array([*self.mouth, height])

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
        return (4 if self.tuck else 2) * int(np.prod([stage.curve.sheets for stage in self.stages]))


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


def _require_tuck_fits(tuck: Tuck, need: float, size: float) -> None:
    """The rim stays clear of the mouth [m], and between it and the crease lies more than the elements beside both."""
    for sign, depth, rim in zip((-1.0, 1.0), tuck.depths, tuck.inner, strict=True):
        if depth and sign * rim < need:
            why = (
                f"its rim would come to lie {max(0.0, sign * rim):.3g} m from the mouth's axis; the mouth and the "
                f"elements around it need {need:.3g} m"
            )
            raise NO_ROOM(fold=tuck.number, why=why, remedy="reduce bag.folds.depth")
        if depth and depth < LONGEST * size:
            why = f"it is {depth:.3g} m deep, and elements are {size:.3g} m long"
            raise NO_ROOM(fold=tuck.number, why=why, remedy="raise bag.folds.depth, or reduce bag.element_size")


def _require_beside_tuck(curve: FoldCurve, fold: Fold, tuck: Tuck, size: float) -> None:
    """No crease lies where four layers are: their elements beside it would have to be alike."""
    low, high = (rim - sign * LONGEST * size for sign, rim in zip((-1.0, 1.0), tuck.inner, strict=True))
    for piece in curve.pieces:
        bent = not isinstance(piece, Straight)
        if bent and ((tuck.depths[0] and piece.begin < low) or (tuck.depths[1] and piece.end > high)):
            why = "its line lies where the rim is tucked in, and the inner sleeve has no row of nodes there"
            raise THROUGH_A_FOLD(fold=fold.number, why=why, remedy="move the line inwards, or reduce the tuck's depth")


def _still(tuck: Tuck, stages: tuple[Stage, ...], size: float) -> tuple[float, float]:
    """Between which places [m] along the tuck's creases later folds bend it, elements beside them included."""
    turns = [turn for stage in stages if stage.across != tuck.across for turn in stage.curve.turns]
    if not turns:
        return (0.5 * sum(tuck.sides),) * 2
    return min(t.begin for t in turns) - LONGEST * size, max(t.end for t in turns) + LONGEST * size
