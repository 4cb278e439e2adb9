"""The reduced-order model: from design parameters to the whole moving shape, with NumPy alone."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.base.markup import table_of
from billow.results.dataset_files import MeshParts, Parameter
from billow.results.tensor_file import write_tensors
from billow.rom.surrogate.basis import Basis
from billow.rom.surrogate.design_space import (
    Standing,
    check_design,
    check_times,
    design_rows,
    distinct,
    standing,
    time_row,
)
from billow.rom.surrogate.force_inputs import ForceInputs, further_inputs
from billow.rom.surrogate.intervals import FEWEST_RUNS, Intervals, scale
from billow.rom.surrogate.judgement import Judgement, require_won
from billow.rom.surrogate.locked_obstacles import LockedObstacle
from billow.rom.surrogate.regression import FREQUENCIES, InputScaling, Regression
from billow.rom.surrogate.start_shapes import StartShapes
from billow.rom.surrogate.surrogate_file import read_checked, surrogate_content, surrogate_fields

NO_SPREAD = InputError.declare(
    "E-ROM-011",
    "this surrogate has no spread",
    where="recipe {recipe!r}",
    why="spread is the disagreement of an ensemble, and there is one network per coefficient",
    remedy='train with recipe "shared"',
)
NO_INTERVALS = InputError.declare(
    "E-ROM-017",
    "this surrogate has no intervals",
    where="recipe {recipe!r}, {runs} training runs",
    why="it was trained without calibration, with contact forces, as `paper`, or on too few runs",
    remedy=f'train with recipe "shared" on at least {FEWEST_RUNS} runs: billow train FOLDER',
)

_DESIGNS_AT_ONCE = 16
"""Designs whose networks `predict_each` evaluates together: enough to fill the products, few enough for the cache."""


@dataclass(frozen=True, eq=False, repr=False)
class Surrogate:
    """A trained reduced-order model.

        surrogate = billow.train(dataset)
        surrogate.save("surrogate.safetensors")
        design = {"permeability": 0.03, ...}
        shape = surrogate.start(design) + surrogate.predict(design)     # [m], (times, nodes, 3)

    title: of the dataset; parameters: what a design consists of, with units and trained ranges
    times: [s], (times,) float64, the trained times
    reference: [m], (nodes, 3) float32, the start shape; triangles: (triangles, 3) int64
    bases: the reduced bases of x, y and z; regression: the networks
    training: how it was made: runs, seed, epochs, seconds, versions
    forces: how contact forces of the previous time become inputs; None if it needs none
    designs: (runs, parameters) float64, what it was trained on; intervals: how far answers may be off, or None
    judgement: how it did on runs it had not seen; None if nobody looked. If it lost there, it does not answer until
        `despite_verdict` is called: every method that answers raises InputError E-ROM-023.
    insisted: True after `despite_verdict`; not saved
    parts: of the mesh, for whoever looks at answers; None if they are not known
    starts: start shapes of designs that have their own, from which displacement counts then; None if all have
        `reference`
    obstacles: locked ones of the training runs, for whoever looks at answers
    """

    title: str
    parameters: tuple[Parameter, ...]
    times: np.ndarray
    reference: np.ndarray
    triangles: np.ndarray
    bases: tuple[Basis, Basis, Basis]
    regression: Regression
    training: dict
    forces: ForceInputs | None = None
    designs: np.ndarray | None = None
    intervals: Intervals | None = None
    judgement: Judgement | None = None
    insisted: bool = False
    parts: MeshParts | None = None
    starts: StartShapes | None = None
    obstacles: tuple[LockedObstacle, ...] = ()

    @classmethod
    def load(cls, path: str | Path) -> Surrogate:
        """Read a file written by `save`. Errors as `read_checked`."""
        return cls(**read_checked(path, surrogate_fields, "billow train FOLDER"))

    def save(self, path: str | Path) -> Path:
        """Write everything to one file without pickle (safetensors), atomically."""
        return write_tensors(path, *surrogate_content(self))

    def despite_verdict(self) -> Surrogate:
        """The same, which answers even if its judgement says that a simpler answer is better."""
        return replace(self, insisted=True)

    @property
    def recipe(self) -> str:
        """ "shared" or "paper"."""
        return self.regression.recipe

    @property
    def modes(self) -> int:
        """K, modes of each component."""
        return len(self.bases[0].modes)

    @property
    def inputs_by_own_time(self) -> InputScaling:
        """Scaling of designs and times without a clock."""
        start, end = float(self.times[0]), float(self.times[-1])
        return replace(self.regression.inputs, start=start, end=end, frequencies=FREQUENCIES)

    @property
    def nodes(self) -> int:
        return len(self.reference)

    @property
    def runs(self) -> tuple[str, ...]:
        """Names of the runs it was learned from."""
        return tuple(self.training["runs"])

    def __repr__(self) -> str:
        learned = f"{len(self.runs)} runs, {self.modes} modes, {self.nodes} nodes"
        return f"Surrogate({self.title!r}, recipe={self.recipe!r}, {learned})"

    def _repr_html_(self) -> str:
        rows = [(f"{p.label} ({p.name})", f"{p.low:g} to {p.high:g} {p.unit}") for p in self.parameters]
        said = "not judged on unseen runs" if self.judgement is None else str(self.judgement)
        return table_of(self.title or "Surrogate", [*rows, ("verdict", said), ("", repr(self))])

    @one_blas_thread()
    def predict(self, design, times=None, *, extrapolate: bool = False, previous_forces=None) -> np.ndarray:
        """Displacement from the start shape: [m], (times, nodes, 3) float32; (runs, times, nodes, 3) for many designs.

        design: {name: value} or (parameters,) for one, {name: (runs,)} or (runs, parameters) for many, in the
        parameters' own units and order
        times: [s], (times,), default the trained ones; between them the networks interpolate
        previous_forces: [N], (times, nodes, 3) or (runs, times, nodes, 3), contact force on each node one recorded
            interval before each time; only for a surrogate trained with `force_modes`

        The array is a view of (runs, 3, times, nodes) memory: one component of one snapshot is contiguous.
        Raises InputError E-ROM-001 (names, shape or values of the design), E-ROM-002 (a parameter outside its trained
        range), E-ROM-003 (a time outside), E-ROM-025 (no times), E-ROM-023 (the verdict), E-CPL-002 (forces missing,
        too many or of another shape), NumericalStop E-ROM-024 (no finite answer). `extrapolate=True` lifts E-ROM-002
        and E-ROM-003; such an answer has no support in the data.
        """
        rows, times, further, single = self._question(design, times, extrapolate, previous_forces)
        # Copied into the order of the product, which otherwise takes a third longer.
        coefficients = np.ascontiguousarray(self._coefficients(rows, times, further).transpose(0, 2, 1, 3))
        fields = np.empty((len(rows), 3, len(times), self.nodes), np.float32)
        np.matmul(coefficients, self._modes, out=fields)  # paper equation 1
        fields = fields.transpose(0, 2, 3, 1)
        return fields[0] if single else fields

    def predict_each(self, designs, times=None, *, extrapolate: bool = False) -> Iterator[np.ndarray]:
        """Predict many designs one after the other, each in the memory of the one before: [m], (times, nodes, 3).

        For sweeps that keep some numbers of each answer, not the answer: new memory for every one would cost as much
        as the answer. Copy what has to stay. Arguments and errors as `predict`; no force inputs.
        """
        rows, times, _, _ = self._question(designs, times, extrapolate, None)
        fields = np.empty((3, len(times), self.nodes), np.float32)
        for first in range(0, len(rows), _DESIGNS_AT_ONCE):
            with one_blas_thread():
                coefficients = self._coefficients(rows[first : first + _DESIGNS_AT_ONCE], times, None)
            for one in np.ascontiguousarray(coefficients.transpose(0, 2, 1, 3)):
                with one_blas_thread():
                    np.matmul(one, self._modes, out=fields)
                yield fields.transpose(1, 2, 0)

    @one_blas_thread()
    def start(self, design) -> np.ndarray:
        """Start shape of a design: [m], (nodes, 3) float32; (runs, nodes, 3) for many designs. InputError E-ROM-001."""
        rows, single = design_rows(design, self.parameters)
        if self.starts is None:
            return self.reference if single else np.broadcast_to(self.reference, (len(rows), *self.reference.shape))
        found = self.starts(rows, self.reference, self.parameters)
        return found[0] if single else found

    @one_blas_thread()
    def coefficients(self, design, times=None, *, extrapolate: bool = False, previous_forces=None) -> np.ndarray:
        """Basis coefficients: [m], (times, 3, modes) float32; (runs, times, 3, modes) for many designs. Arguments and
        errors as `predict`."""
        rows, times, further, single = self._question(design, times, extrapolate, previous_forces)
        coefficients = self._coefficients(rows, times, further)
        return coefficients[0] if single else coefficients

    @one_blas_thread()
    def spread(self, design, times=None, *, extrapolate: bool = False, previous_forces=None) -> np.ndarray:
        """How far the members of the ensemble disagree: [m], (times, 3); (runs, times, 3) for many designs.

        Standard deviation over members, as root mean square over nodes, like the RMSE of paper equation 5. It ranks
        designs by error; as an error bar it is too small, and it does not notice extrapolation.
        Arguments and errors as `predict`; InputError E-ROM-011 for the recipe `paper`, which has no ensemble.
        """
        if self.regression.members == 1:
            raise NO_SPREAD(recipe=self.recipe)
        rows, times, further, single = self._question(design, times, extrapolate, previous_forces)
        deviation = self.regression.by_member(rows, times, further).std(axis=0)
        deviation = deviation.reshape(*deviation.shape[:2], 3, self.modes)
        # The basis is orthonormal: a sum of squares over nodes is a sum of squares over modes.
        spread = np.sqrt(np.square(deviation).sum(axis=3) / self.nodes)
        return spread[0] if single else spread

    @one_blas_thread()
    def half_width(self, design, times=None, *, level: float = 0.9, extrapolate: bool = False) -> np.ndarray:
        """How far `predict` may be off: [m], (times, nodes, 3) float32; (runs, times, nodes, 3) for many designs.

        The solver's value lies within prediction +- half width for a part `level` (one of `intervals.LEVELS`) of all
        values of unseen designs from the trained ranges, component by component. It is a statement about many values
        together: at one moment of one design most values may lie outside. Other arguments and errors as `predict`;
        InputError E-ROM-017 if the surrogate was not calibrated, E-ROM-018 for another level.
        """
        if self.intervals is None:
            raise NO_INTERVALS(recipe=self.recipe, runs=len(self.runs))
        factor = self.intervals.factor(level).astype(np.float32)
        rows, times, _, single = self._question(design, times, extrapolate, None)
        lost = self.intervals.lost_by_time, self.intervals.lost_by_node
        widths = np.stack([scale(self, *lost, row, times) * factor for row in rows])
        return widths[0] if single else widths

    def standing(self, design) -> Standing | None:
        """Where one design stands among the trained ones; None if the file is of a Billow that did not store them, or
        all of them are the same. A design inside all ranges may still be far from everything learned. InputError
        E-ROM-001 if it does not fit."""
        rows, _ = design_rows(design, self.parameters)
        if self.designs is None or len(distinct(self.designs, self.parameters)) < 2:
            return None
        return standing(rows[0], self.designs, self.parameters)

    def stands_still(self, design) -> float | None:
        """[s], the trained time from which one design is farther in its motion than any run got (`Clock.reach`), so
        that its answer stands still; None if it never is. InputError E-ROM-001 if it does not fit."""
        rows, _ = design_rows(design, self.parameters)
        clock = self.regression.clock
        if clock is None:
            return None
        late = self.times[self.regression.common(rows[:1], self.times)[0] >= clock.latest]
        return float(late[0]) if len(late) else None

    @cached_property
    def _modes(self) -> np.ndarray:
        return np.stack([basis.modes for basis in self.bases])  # (3, modes, nodes)

    def _coefficients(self, rows, times, further):
        return self.regression(rows, times, further).reshape(len(rows), len(times), 3, self.modes)

    def _question(self, design, times, extrapolate, previous_forces):
        if not self.insisted:
            require_won(self.judgement, self)
        rows, single = design_rows(design, self.parameters)
        if not extrapolate:
            check_design(rows, self.parameters)
        if times is None:
            times = self.times
        else:
            times = time_row(times)
            if not extrapolate:
                check_times(times, self.times)
        further = further_inputs(previous_forces, self.forces, (len(rows), len(times), self.nodes, 3))
        return rows, times, further, single
