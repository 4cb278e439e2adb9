"""The best design that the runs support: differential evolution on the response surfaces.

Limits are on the ends of intervals, not on values: an optimiser goes where a surface errs in its favour. No design lies
farther from the runs than they lie from each other. An optimum is a proposal until the solver has run it
(`billow.design.verify`).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.base.toml_file import read_toml
from billow.rom.surrogate.design_space import bounds, from_unit, to_unit

GOAL = InputError.declare(
    "E-DES-030",
    "the goal cannot be used",
    where="{where}",
    cause="a misspelt name, or a limit in another unit",
    remedy="write for example minimise = 'hic15' and [below] peak_pressure = 40.0; docs/design.md",
)
NO_DESIGN = InputError.declare(
    "E-DES-031",
    "no design fulfils the limits",
    where="the ranges of the study, within reach of its runs",
    why="{why}",
    cause="limits that contradict each other, or intervals too wide to be sure",
    remedy="loosen a limit, lower the level, or add runs so that intervals get narrower",
)
NO_PYMOO = InputError.declare(
    "E-DES-032",
    "several goals need pymoo",
    where="pareto",
    why="it is not installed ({reason})",
    remedy='pip install "billow[design]", or minimise one response with limits on the others',
)
POPULATION, GENERATIONS, STARTS = 15, 300, 3
"""Of differential evolution; the population is this times the number of parameters. One start may end in a valley that
is not the deepest (docs/design.md, Measured)."""
STRATEGY = "rand1bin"
"""Steps from a random member. From the best one, as is usual, a population gathers in the first good valley."""
TOLERANCE = 1e-6
FRONT, FRONT_GENERATIONS, FEWEST_GENERATIONS = 64, 12, 60
"""Designs of a front, generations for each parameter that is free, and the fewest."""
SAME_STEP = 1e-6
"""Part of a step by which a fixed value may be off."""
AWAY = 0.2
"""Distance, with every range scaled to 1, that an optimum keeps from designs whose runs do not hold."""


@dataclass(frozen=True)
class Goal:
    """What is wanted. One of minimise, maximise and target, a name or for target (name, value); below, above:
    response -> limit in its unit; fixed: parameter -> value; steps: parameter -> step, counted from its low end,
    instead of that of the study; level: of the intervals whose ends keep to the limits; seed."""

    minimise: str | None = None
    maximise: str | None = None
    target: tuple[str, float] | None = None
    below: Mapping[str, float] = field(default_factory=dict)
    above: Mapping[str, float] = field(default_factory=dict)
    fixed: Mapping[str, float] = field(default_factory=dict)
    steps: Mapping[str, float] = field(default_factory=dict)
    level: float = 0.9
    seed: int = 0

    @classmethod
    def load(cls, path: str | Path, surfaces) -> Goal:
        """From goals.toml: keys as the fields, and texts with units, or names of levels, as the surfaces know them.
        InputError E-DES-030."""
        try:
            return cls(**_checked(read_toml(Path(path)), surfaces))
        except (OSError, ValueError, TypeError) as error:
            raise GOAL(where=path, why=error) from error

    @property
    def response(self) -> str:
        """Name of what is minimised, maximised or brought to a target."""
        return self.minimise or self.maximise or self.target[0]


def _checked(content: dict, surfaces) -> dict:
    tables = dict.fromkeys(("below", "above", "fixed", "steps", "target"), dict)
    kinds = {"minimise": str, "maximise": str, "level": float, "seed": int, **tables}
    for key, value in content.items():
        if key not in kinds or not isinstance(value, kinds[key]):
            raise ValueError(f"{key} = {value!r}; known are {', '.join(kinds)}")
        if kinds[key] is dict:
            content = content | {key: {name: surfaces.number(name, each) for name, each in value.items()}}
    if "target" in content:
        if len(content["target"]) != 1:
            raise ValueError("target names one response and its value")
        content = content | {"target": next(iter(content["target"].items()))}
    return content


@dataclass(frozen=True, eq=False)
class Optimum:
    """design: parameter -> value; responses: name -> (value, low, high), of every usable surface; generations: best
    objective so far of each generation of all starts, in the response's unit, NaN while no design kept to the limits"""

    goal: Goal
    design: dict[str, float]
    responses: dict[str, tuple[float, float, float]]
    generations: np.ndarray


@one_blas_thread()
def optimise(surfaces, goal: Goal, avoid: np.ndarray | None = None) -> Optimum:
    """The design that a goal asks for (Storn and Price, Journal of Global Optimization 11 (1997) 341-359).

    avoid: (designs, parameters) in [0, 1] at which runs do not hold; no answer lies near them (`AWAY`)
    The same surfaces and goal: the same bits. InputError E-DES-010: a response without usable surface; -030: the goal;
    -031: no design fulfils it.
    """
    from scipy.optimize import differential_evolution

    space, random = _Space(surfaces, goal, avoid), np.random.default_rng(goal.seed)
    best: list[float] = []

    def objective(unit: np.ndarray) -> np.ndarray:  # (free parameters, designs)
        return space.cost(space.designs(unit.T))

    def record(intermediate_result) -> None:
        best.append(min([float(intermediate_result.fun), *best[-1:]]))

    ends = [differential_evolution(
        objective, [(0.0, 1.0)] * space.count, strategy=STRATEGY, vectorized=True, updating="deferred", polish=False,
        popsize=POPULATION, maxiter=GENERATIONS, tol=TOLERANCE, rng=random, callback=record,
    ) for _ in range(STARTS)]  # fmt: skip
    found = min(ends, key=lambda end: end.fun)
    unit = space.designs(found.x[None])
    broken = space.broken(unit)
    if broken:
        raise NO_DESIGN(why="nearest is a design that misses " + "; ".join(broken))
    design = from_unit(unit, surfaces.parameters)[0]
    answers = {
        name: tuple(surfaces.surfaces[k].interval(unit, goal.level)[0].tolist())
        for k, name in enumerate(surfaces.names)
        if surfaces.surfaces[k].verdict.usable
    }
    history = np.array([space.in_unit(cost) for cost in best])
    names = [parameter.name for parameter in surfaces.parameters]
    return Optimum(goal, dict(zip(names, design.tolist(), strict=True)), answers, history)


class _Space:
    """The free axes of a goal, and what a design costs."""

    def __init__(self, surfaces, goal: Goal, avoid: np.ndarray | None = None):
        from billow.design.surface import LEVELS

        self.surfaces, self.goal = surfaces, goal
        self.avoid = np.empty((0, len(surfaces.parameters))) if avoid is None else avoid
        names = [parameter.name for parameter in surfaces.parameters]
        wanted = [one for one in (goal.minimise, goal.maximise, goal.target) if one]
        if len(wanted) != 1:
            raise GOAL(where="goal", why=f"it names {len(wanted)} of minimise, maximise and target; one is needed")
        unknown = [name for name in (*goal.fixed, *goal.steps) if name not in names]
        if unknown:
            raise GOAL(where="goal", why=f"there is no parameter {unknown[0]!r}; known are {', '.join(names)}")
        if goal.level not in LEVELS:
            raise GOAL(where="goal", why=f"there are no intervals of level {goal.level:g}")
        for name, step in goal.steps.items():
            if not step > 0.0:
                raise GOAL(where="goal", why=f"the step of {name} is not above zero")
        for place, number in _numbers(goal):
            if not np.isfinite(number):
                raise GOAL(where="goal", why=f"{place} = {number} is no number")
        if goal.seed < 0:
            raise GOAL(where="goal", why=f"seed = {goal.seed} is below zero")
        self.steps = {**surfaces.steps, **goal.steps}
        self.surface = surfaces.usable(goal.response)
        self.spread = float(np.nanstd(surfaces.values[:, surfaces.index(goal.response)]))
        self.limits = [(name, float(limit), side) for side, limits in ((1.0, goal.below), (-1.0, goal.above))
                       for name, limit in limits.items()]  # fmt: skip
        self.bounding = [surfaces.usable(name) for name, _, _ in self.limits]
        self.free = [k for k, name in enumerate(names) if name not in goal.fixed]
        self.base = np.full(len(names), 0.5)
        for name, value in goal.fixed.items():
            k = names.index(name)
            p = surfaces.parameters[k]
            if not p.low <= value <= p.high:
                raise GOAL(
                    where="goal", why=f"fixed {name} = {value:g} is not between {p.low:g} and {p.high:g} {p.unit}"
                )
            if p.levels and value != round(value):
                raise GOAL(where="goal", why=f"fixed {name} = {value:g} is the number of no level")
            steps = (value - p.low) / surfaces.steps.get(name, np.inf)
            if abs(steps - round(steps)) > SAME_STEP:
                why = f"fixed {name} = {value:g} is not {p.low:g} and whole steps of {surfaces.steps[name]:g}"
                raise GOAL(where="goal", why=why)
            self.base[k] = (value - p.low) / (p.high - p.low)

    @property
    def count(self) -> int:
        """Free parameters, at least one."""
        if not self.free:
            raise GOAL(where="goal", why="every parameter is fixed")
        return len(self.free)

    def designs(self, free: np.ndarray) -> np.ndarray:
        """Whole designs in [0, 1] from their free axes, on steps and levels: (designs, parameters)."""
        unit = np.tile(self.base, (len(free), 1))
        unit[:, self.free] = free
        for k, parameter in enumerate(self.surfaces.parameters):
            if count := len(parameter.levels):
                unit[:, k] = np.round(unit[:, k] * (count - 1)) / (count - 1)
            elif k in self.free and (step := self.steps.get(parameter.name)) is not None:
                step = step / (parameter.high - parameter.low)
                unit[:, k] = np.minimum(np.round(unit[:, k] / step), np.floor(1.0 / step + 1e-9)) * step
        return unit

    def in_unit(self, cost: float) -> float:
        """An objective as the response's value, the distance from it for a target; NaN where limits were broken."""
        if cost >= _BROKEN:
            return float("nan")
        return cost * self.spread * (-1.0 if self.goal.maximise else 1.0)

    def cost(self, unit: np.ndarray) -> np.ndarray:
        """(designs,): the objective over the runs' deviation, or, where a limit is broken, how far."""
        value = self.surface.value(unit)
        if self.goal.target is not None:
            value = np.abs(value - self.goal.target[1])
        broken = self.missed(unit)
        sign = -1.0 if self.goal.maximise else 1.0
        return np.where(broken > 0.0, _BROKEN + broken, sign * value / self.spread)

    def missed(self, unit: np.ndarray) -> np.ndarray:
        """(designs,): how far they are from keeping to everything; 0 if they do."""
        near = np.zeros(len(unit))
        for point in self.avoid:
            near = np.maximum(near, AWAY - np.linalg.norm(unit - point, axis=1))
        limits = sum(self._excess(k, unit) for k in range(len(self.limits)))
        return near + self.surfaces.beyond(unit) + self._forbidden(unit) + limits

    def _forbidden(self, unit: np.ndarray) -> np.ndarray:
        """How far designs are from fulfilling the constraints of the study, over the range of each sum; 0 if they
        do."""
        low, high = bounds(self.surfaces.parameters)
        names = [parameter.name for parameter in self.surfaces.parameters]
        wide = dict(zip(names, high - low, strict=True))
        designs, missed = from_unit(unit, self.surfaces.parameters), np.zeros(len(unit))
        for constraint in self.surfaces.constraints:
            spread = sum(abs(factor) * wide[name] for name, factor in constraint.terms.items())
            missed += constraint.missed(designs, names) / max(spread, np.finfo(float).tiny)
        return missed

    def _excess(self, k: int, unit: np.ndarray) -> np.ndarray:
        """How far the end of an interval lies beyond a limit, over the runs' deviation; 0 within."""
        name, limit, side = self.limits[k]
        end = self.bounding[k].interval(unit, self.goal.level)[:, 2 if side > 0 else 1]
        spread = float(np.nanstd(self.surfaces.values[:, self.surfaces.index(name)]))
        return np.maximum(side * (end - limit) / spread, 0.0)

    def broken(self, unit: np.ndarray) -> list[str]:
        """What one design misses, in words."""
        told = []
        if self.surfaces.beyond(unit)[0] > 0.0:
            told.append("the reach of the runs")
        if self._forbidden(unit)[0] > 0.0:
            told.append("the constraints of the study")
        if len(self.avoid) and np.linalg.norm(unit - self.avoid, axis=1).min() < AWAY:
            told.append("a distance from designs whose runs do not hold")
        for k, (name, limit, side) in enumerate(self.limits):
            if self._excess(k, unit)[0] > 0.0:
                end = self.bounding[k].interval(unit, self.goal.level)[0, 2 if side > 0 else 1]
                word = "below" if side > 0 else "above"
                told.append(f"{name} {word} {limit:g} {self.surfaces.unit(name)} (its interval reaches {end:.4g})")
        return told


def _numbers(goal: Goal) -> Iterator[tuple[str, float]]:
    """Every number of a goal, and where it stands."""
    tables = {"below": goal.below, "above": goal.above, "fixed": goal.fixed, "steps": goal.steps}
    tables["target"] = dict([goal.target]) if goal.target else {}
    for table, entries in tables.items():
        for name, number in entries.items():
            yield f"{table} {name}", number


_BROKEN = 1e6
"""Cost of a design that keeps to no limit: above that of any other."""


def pareto(surfaces, minimise: tuple[str, ...], seed: int = 0, level: float = 0.9, below=None, above=None):
    """Designs of which none is better in all responses to be minimised, by NSGA-II (Deb et al., IEEE Transactions on
    Evolutionary Computation 6 (2002) 182-197): (designs, parameters) and (designs, responses).

    Needs pymoo: InputError E-DES-032 without it. Other errors as `optimise`.
    """
    try:
        from pymoo.algorithms.moo.nsga2 import NSGA2
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize
    except ImportError as error:
        raise NO_PYMOO(reason=error) from error
    space = _Space(surfaces, Goal(minimise=minimise[0], below=below or {}, above=above or {}, level=level))
    chosen = [surfaces.usable(name) for name in minimise]

    class Trade(Problem):
        def __init__(self):
            super().__init__(n_var=space.count, n_obj=len(chosen), n_ieq_constr=1, xl=0.0, xu=1.0)

        def _evaluate(self, x, out, *args, **kwargs):
            unit = space.designs(x)
            out["F"] = np.stack([surface.value(unit) for surface in chosen], axis=1)
            out["G"] = space.missed(unit)[:, None]

    with one_blas_thread():
        generations = max(FRONT_GENERATIONS * space.count, FEWEST_GENERATIONS)
        found = minimize(Trade(), NSGA2(pop_size=FRONT), ("n_gen", generations), seed=seed, verbose=False)
    if found.X is None:
        raise NO_DESIGN(why="no design keeps to the limits")
    unit, goals = space.designs(np.atleast_2d(found.X)), np.atleast_2d(found.F)  # of one design they are vectors
    order = np.argsort(goals[:, 0])
    return from_unit(unit, surfaces.parameters)[order], goals[order]


def unit_design(surfaces, design: Mapping[str, float]) -> np.ndarray:
    """A design as (1, parameters) in [0, 1]."""
    from billow.rom.surrogate.design_space import check_design, design_rows

    rows, _ = design_rows(design, surfaces.parameters)
    check_design(rows, surfaces.parameters)
    return to_unit(rows, surfaces.parameters)
