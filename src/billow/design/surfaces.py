"""The response surfaces of a study: made from its table, kept in one file, asked by name."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.close_names import did_you_mean
from billow.base.errors import InputError, IntegrityError
from billow.base.units import in_unit
from billow.design.gaussian_process import Axes, GaussianProcess
from billow.design.surface import LEVELS, Surface, Verdict, learn
from billow.design.table import ResponseTable, respond
from billow.results.dataset_files import Parameter, parameter_of
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.surrogate.design_space import (
    bounds,
    check_design,
    design_rows,
    distinct,
    has_range,
    neighbour_distances,
    to_unit,
)
from billow.study.responses import StudyResponse
from billow.study.variables import StudyConstraint

NO_SURFACE = InputError.declare(
    "E-DES-010",
    "there is no surface of {name!r}",
    where="response {name}",
    cause="a misspelt name; a response that does not exist in many runs; too few runs for what the parameters change",
    remedy="{remedy}",
)
NO_LEVEL = InputError.declare(
    "E-DES-011",
    "there are no intervals of level {level:g}",
    where="level",
    why="levels are {known}",
    remedy="ask for one of these",
)
DAMAGED = IntegrityError.declare(
    "E-DES-012",
    "the file of response surfaces cannot be used",
    where="{path}",
    cause="a copy that was cut short, a file of another kind, or of another version",
    remedy="make it again: billow design train STUDY --out responses.safetensors",
)
FILE_FORMAT = 4
"""4: with the steps and constraints of the study."""
UNREADABLE = InputError.declare(
    "E-DES-013",
    "the file of response surfaces cannot be read",
    where="{path}",
    cause="a misspelt path",
    remedy="make it: billow design train STUDY --out responses.safetensors",
)
NO_RANGE = InputError.declare(
    "E-DES-014",
    "{name} has no range to learn from",
    where="design.csv",
    why="all training runs have one value of it",
    remedy="vary it, or leave it out of the parameters",
)


@dataclass(frozen=True, eq=False)
class ResponseSurfaces:
    """Surfaces of all responses of a study.

        surfaces = ResponseSurfaces.train("STUDY")
        surfaces.interval("hic15", {"speed": -5.0, ...})         # value, low end, high end
        surfaces.verdict("hic15")

    parameters: axes; responses, units: of each surface; runs, designs: (runs, parameters) learned from; values: (runs,
    responses); unseen: (test runs, parameters + responses); digest: of the table it was made from; steps, constraints:
    of the study, which an optimum keeps to
    """

    title: str
    parameters: tuple[Parameter, ...]
    responses: tuple[StudyResponse, ...]
    units: tuple[str, ...]
    surfaces: tuple[Surface, ...]
    designs: np.ndarray
    values: np.ndarray
    unseen: np.ndarray
    digest: str
    runs: tuple[str, ...] = field(default=())
    steps: Mapping[str, float] = field(default_factory=dict)
    constraints: tuple[StudyConstraint, ...] = ()

    @classmethod
    def train(cls, study, responses: Sequence[StudyResponse] | None = None) -> ResponseSurfaces:
        """From the folder of a study or an imported dataset, or its open `Dataset` or `Study`. Errors as `respond`."""
        return cls.learn(respond(getattr(study, "folder", study), responses))

    @classmethod
    @one_blas_thread()
    def learn(cls, table: ResponseTable) -> ResponseSurfaces:
        """From a table of responses; test runs are kept aside. InputError E-DES-014: a parameter has one value."""
        train = len(table.runs) - table.unseen
        designs, values = table.designs[:train], table.values[:train]
        for parameter, column in zip(table.parameters, designs.T, strict=True):
            if not has_range(np.array([column.min()]), np.array([column.max()])).all() and np.ptp(column) == 0.0:
                raise NO_RANGE(name=parameter.name)
        axes = Axes(tuple(len(parameter.levels) for parameter in table.parameters))
        unit, groups = to_unit(designs, table.parameters), distinct(designs, table.parameters)
        others = to_unit(table.designs[train:], table.parameters)
        surfaces = tuple(
            learn(axes, unit, column[:train], groups, response.scale, (others, column[train:]))
            for response, column in zip(table.responses, table.values.T, strict=True)
        )
        unseen = np.column_stack([table.designs[train:], table.values[train:]])
        return cls(table.title, table.parameters, table.responses, table.units, surfaces, designs, values, unseen,
                   table.digest, table.runs[:train], table.steps, table.constraints)  # fmt: skip

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the responses."""
        return tuple(response.name for response in self.responses)

    def index(self, name: str) -> int:
        """Number of a response. InputError E-DES-010 if there is none of this name."""
        if name not in self.names:
            known = ", ".join(self.names)
            raise NO_SURFACE(
                name=name, why=f"responses are {known}", remedy=did_you_mean(name, self.names) or "use one"
            )
        return self.names.index(name)

    def number(self, name: str, value: float | str) -> float:
        """Value of a parameter or response in its unit: from a number in it, a text such as "0.4 bar", or the name of a
        factor's level. Raises ValueError for texts that do not fit; names that are not known are left to others."""
        units = dict(zip(self.names, self.units, strict=True))
        for parameter in self.parameters:
            units[parameter.name] = parameter.unit
            if parameter.name == name and parameter.levels and isinstance(value, str):
                if value not in parameter.levels:
                    raise ValueError(f"{name} = {value!r}: its levels are {', '.join(parameter.levels)}")
                return float(parameter.levels.index(value))
        try:
            return in_unit(value, units.get(name, "-"))
        except ValueError as error:
            raise ValueError(f"{name} = {value!r}: {error}") from None

    def verdict(self, name: str) -> Verdict:
        """How far a response can be trusted."""
        return self.surfaces[self.index(name)].verdict

    def response(self, name: str) -> StudyResponse:
        """What was asked for by a name."""
        return self.responses[self.index(name)]

    def unit(self, name: str) -> str:
        """Unit of a response."""
        return self.units[self.index(name)]

    def usable(self, name: str) -> Surface:
        """A surface that may be built upon. InputError E-DES-010 if the verdict is "not usable"."""
        surface = self.surfaces[self.index(name)]
        if not surface.verdict.usable:
            remedy = "add runs, narrow the ranges, or measure something smoother"
            raise NO_SURFACE(
                what=f"the surface of {name!r} is not usable", name=name, why=surface.verdict.why, remedy=remedy
            )
        return surface

    def interval(self, name: str, design, level: float = 0.9) -> np.ndarray:
        """Value of a response and both ends of its interval: (3,), or (designs, 3) for many designs.

        design: {name: value or (designs,)}, (parameters,) or (designs, parameters); names of levels for factors
        InputError E-DES-010 without a usable surface, -011 for another level; E-ROM-001, -002: the design.
        """
        if level not in LEVELS:
            raise NO_LEVEL(level=level, known=", ".join(map(str, LEVELS)))
        surface = self.usable(name)
        rows, single = design_rows(design, self.parameters)
        check_design(rows, self.parameters)
        found = surface.interval(to_unit(rows, self.parameters), level)
        return found[0] if single else found

    def predict(self, name: str, design) -> np.ndarray | float:
        """Value of a response; arguments and errors as `interval`."""
        return self.interval(name, design)[..., 0]

    @cached_property
    def _reach(self) -> tuple[np.ndarray, float]:
        firsts = self.designs[[group[0] for group in distinct(self.designs, self.parameters)]]
        known = to_unit(firsts, self.parameters)
        return known, float(neighbour_distances(known).max())

    def beyond(self, unit: np.ndarray) -> np.ndarray:
        """How far designs (designs, parameters) in [0, 1] lie beyond the reach of the runs, (designs,), 0 within: the
        distance to the nearest run over the largest between neighbouring runs, minus 1."""
        from scipy.spatial import cKDTree

        known, largest = self._reach
        nearest, _ = cKDTree(known).query(unit)
        return np.maximum(nearest / largest - 1.0, 0.0)

    def save(self, path: str | Path) -> Path:
        """Write a .safetensors file: arrays and a JSON record, no code."""
        tensors = {"designs": self.designs, "values": self.values, "unseen": self.unseen}
        told = []
        for k, surface in enumerate(self.surfaces):
            verdict = {key: None if value != value else value for key, value in asdict(surface.verdict).items()}
            told.append({"scale": surface.scale, "verdict": verdict, "common": surface.common})
            tensors |= {f"{k}.factors": surface.factors, f"{k}.held_out": surface.held_out}
            if surface.process is not None:
                process = surface.process
                every = [np.append(one.log_lengths, one.log_nugget) for one in (process, *surface.folds)]
                tensors |= {f"{k}.points": process.points, f"{k}.values": process.values,
                            f"{k}.logs": np.array(every), f"{k}.fold": surface.fold.astype(float)}  # fmt: skip
        record = {
            "format": FILE_FORMAT, "kind": "response surfaces", "title": self.title, "digest": self.digest,
            "runs": list(self.runs), "parameters": [asdict(p) for p in self.parameters], "units": list(self.units),
            "responses": [r.model_dump(mode="json") for r in self.responses], "surfaces": told,
            "steps": dict(self.steps), "constraints": [c.model_dump(mode="json") for c in self.constraints],
        }  # fmt: skip
        return write_tensors(path, tensors, record)

    @classmethod
    def load(cls, path: str | Path) -> ResponseSurfaces:
        """Read a file by `save`. InputError E-DES-013: there is none; IntegrityError E-DES-012: it cannot be used."""
        path = Path(path)
        try:
            tensors, record = read_tensors(path, lambda why: DAMAGED(path=path, why=why))
        except OSError as error:
            raise UNREADABLE(path=path, why=error) from error
        try:
            if record["kind"] != "response surfaces":
                raise ValueError("it is of another kind")
            if record["format"] != FILE_FORMAT:
                raise ValueError(f"it is of version {record['format']}, and this Billow reads {FILE_FORMAT}")
            parameters = tuple(map(parameter_of, record["parameters"]))
            axes = Axes(tuple(len(parameter.levels) for parameter in parameters))
            surfaces = tuple(_surface(axes, tensors, k, told) for k, told in enumerate(record["surfaces"]))
            responses = tuple(map(StudyResponse.model_validate, record["responses"]))
            constraints = tuple(map(StudyConstraint.model_validate, record["constraints"]))
            steps, names = dict(record["steps"]), {parameter.name for parameter in parameters}
            if not {*steps, *(name for c in constraints for name in c.terms)} <= names or not all(
                type(step) in (int, float) and 0.0 < step < float("inf") for step in steps.values()
            ):
                raise ValueError("its steps or constraints do not fit its parameters")
            width = len(parameters), len(responses)
            shapes = [tensors[name].shape[1:] for name in ("designs", "values", "unseen")]
            if shapes != [width[:1], width[1:], (sum(width),)] or not len(surfaces) == len(record["units"]) == width[1]:
                raise ValueError("its parts do not fit together")
            if not has_range(*bounds(parameters)).all():
                raise ValueError("a parameter has no range")
            return cls(str(record["title"]), parameters, responses, tuple(map(str, record["units"])), surfaces,
                       tensors["designs"], tensors["values"], tensors["unseen"], str(record["digest"]),
                       tuple(map(str, record["runs"])), steps, constraints)  # fmt: skip
        except (KeyError, TypeError, ValueError, IndexError, AttributeError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else str(error)
            raise DAMAGED(path=path, why=why) from error

    def optimise(self, **goal):
        """The best design; arguments of `Goal`."""
        from billow.design.optimum import Goal, optimise

        return optimise(self, Goal(**goal))

    def sensitivity(self, name: str, samples: int = 1024, seed: int = 0):
        """Sobol' indices of a response; see `billow.design.sensitivity.sensitivity`."""
        from billow.design.sensitivity import sensitivity

        return sensitivity(self, name, samples, seed)

    def exceed(self, name: str, limit: float, around: Mapping[str, float], scatter: Mapping[str, float], seed: int = 0):
        """Chance that a response exceeds a limit; see `billow.design.robust.Chance`."""
        from billow.design.robust import exceed

        return exceed(self, name, limit, around, scatter, seed)


def _surface(axes: Axes, tensors: dict[str, np.ndarray], k: int, told: dict) -> Surface:
    verdict = Verdict(**{key: float("nan") if value is None else value for key, value in told["verdict"].items()})
    if not (type(verdict.held) is type(verdict.asked) is int and 0 <= verdict.held <= verdict.asked):
        raise ValueError("its verdict cannot be read")
    process, fold, folds = None, np.empty(0, int), ()
    if f"{k}.points" in tensors:
        logs, points, values, fold = (tensors[f"{k}.{name}"] for name in ("logs", "points", "values", "fold"))
        if points.shape != (len(values), len(axes.levels)) or logs.shape[1:] != (len(axes.levels) + 1,):
            raise ValueError("its parts do not fit together")
        if fold.shape != values.shape or sorted(set(fold.tolist())) != list(range(len(logs) - 1)):
            raise ValueError("its folds do not fit its runs")
        if not all(np.isfinite(array).all() for array in (logs, points, values)):
            raise ValueError("a number is not finite")
        kept = [np.full(len(values), True), *(fold != number for number in range(len(logs) - 1))]
        if not all(rows.any() and np.ptp(values[rows]) > 0.0 for rows in kept):
            raise ValueError("its values are all the same")
        process, *folds = (
            GaussianProcess(axes, points[rows], values[rows], one[:-1], float(one[-1]))
            for rows, one in zip(kept, logs, strict=True)
        )
    elif verdict.usable:
        raise ValueError("a surface is missing")
    if told["scale"] not in ("identity", "log", "root") or tensors[f"{k}.factors"].shape != (len(LEVELS),):
        raise ValueError("its scale or its intervals cannot be read")
    common = float(told["common"])
    if not 0.0 <= common < float("inf"):
        raise ValueError("its intervals cannot be read")
    return Surface(process, told["scale"], tensors[f"{k}.factors"], verdict, tensors[f"{k}.held_out"], common,
                   fold.astype(int), tuple(folds))  # fmt: skip
