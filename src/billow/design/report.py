"""All of a design study on one page: verdicts, figures, optimum and robustness; design.html needs no other file."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.base.input_file import read_text
from billow.design import figures
from billow.design.optimum import Goal, Optimum, pareto
from billow.design.robust import Chance
from billow.design.sensitivity import correlations, main_effects, sensitivity
from billow.design.surfaces import ResponseSurfaces
from billow.design.verify import Round
from billow.results.atomic import write_atomically
from billow.rom.judge.report import render
from billow.rom.surrogate.design_space import to_unit

NO_OPTIMUM = InputError.declare(
    "E-DES-034",
    "the folder holds no optimum",
    where="{path}",
    cause="a misspelt path, or a folder of another command",
    remedy="make it: billow design optimise RESPONSES goals.toml --out OPT",
)
OPTIMUM_FILE = "optimum.json"


def optimum_record(rounds: list[Round], surfaces: ResponseSurfaces) -> dict:
    """Plain JSON of an optimum and its rounds in the solver; `rounds_of` reads it."""

    def plain(values):
        return [value if np.isfinite(value) else None for value in values]

    return {
        "goal": {key: dict(v) if isinstance(v, dict) else v for key, v in vars(rounds[0].optimum.goal).items()},
        "units": dict(zip(surfaces.names, surfaces.units, strict=True)),
        "holds": rounds[-1].holds if rounds[-1].run else None,
        "rounds": [
            {
                "design": one.optimum.design,
                "predicted": {name: list(ends) for name, ends in one.optimum.responses.items()},
                "generations": plain(one.optimum.generations),
                "run": one.run,
                "computed": dict(zip(one.computed, plain(one.computed.values()), strict=True)),
                "doubts": list(one.doubts),
            }
            for one in rounds
        ],
    }


def rounds_of(folder: str | Path) -> list[Round]:
    """Rounds of an optimum in a folder. InputError E-DES-034."""
    path = Path(folder) / OPTIMUM_FILE
    try:
        record = json.loads(read_text(path))
        target = record["goal"].get("target")
        goal = Goal(**record["goal"] | {"target": tuple(target) if target else None})

        def numbers(values):
            return [float("nan") if value is None else float(value) for value in values]

        return [
            Round(
                Optimum(goal, dict(one["design"]), {name: tuple(ends) for name, ends in one["predicted"].items()},
                        np.array(numbers(one["generations"]))),
                str(one["run"]),
                dict(zip(one["computed"], numbers(one["computed"].values()), strict=True)),
                tuple(one["doubts"]),
            )
            for one in record["rounds"]
        ]  # fmt: skip
    except (OSError, ValueError, KeyError, TypeError, AttributeError, RecursionError) as error:
        raise NO_OPTIMUM(path=path, why=error) from error


def write_report(
    surfaces: ResponseSurfaces, path: str | Path, rounds: list[Round] = (), chances: dict[str, Chance] | None = None
) -> Path:
    """Write design.html. rounds: of an optimum; chances: of `robustness`."""
    usable = [name for name in surfaces.names if surfaces.verdict(name).usable]
    found = [sensitivity(surfaces, name) for name in usable]
    shown = rounds[0].optimum.goal.response if rounds else (usable[0] if usable else None)
    pictures = {"quality": figures.draw(figures.predicted_against_computed, surfaces)}
    ranks = correlations(surfaces)
    pictures["correlation"] = figures.draw(figures.correlation_matrix, surfaces, ranks)
    if found:
        pictures |= _of_usable(surfaces, shown, found, rounds)
    if rounds:
        pictures["history"] = figures.draw(figures.optimum_history, surfaces, rounds)
    if chances:
        pictures["robustness"] = figures.draw(figures.robustness_histograms, list(chances.values()))
    page = render(
        __package__, pictures, surfaces=surfaces, shown=shown, usable=usable, rounds=rounds, chances=chances or {}
    )
    write_atomically(Path(path), page)
    return Path(path)


def _of_usable(surfaces: ResponseSurfaces, shown: str, found: list, rounds: list[Round]) -> dict[str, bytes]:
    """Figures of the response that matters most, and of all that depends on it."""
    own = next(one for one in found if one.response == shown)
    two = tuple(np.argsort(own.total[:, 0])[::-1][:2].tolist())
    middle = np.full(len(surfaces.parameters), 0.5)
    limits = []
    if rounds:
        goal = rounds[-1].optimum.goal
        middle = to_unit(np.array(list(rounds[-1].optimum.design.values())), surfaces.parameters)
        limits = [(name, limit, 1) for name, limit in goal.below.items()]
        limits += [(name, limit, -1) for name, limit in goal.above.items()]
    pictures = {
        "sobol": figures.draw(figures.sobol_bars, surfaces, found),
        "prognosis": figures.draw(figures.prognosis, surfaces, found),
        "effects": figures.draw(figures.main_effect_curves, surfaces, shown, *main_effects(surfaces, shown)),
        "anthill": figures.draw(figures.anthill, surfaces, shown, two[0]),
        "parallel": figures.draw(figures.parallel_coordinates, surfaces, shown),
    }
    if len(two) == 2:
        pictures["surface"] = figures.draw(figures.response_surface, surfaces, shown, two, middle, limits)
    other = next(
        (name for name in (limits[0][0] if limits else "", *(o.response for o in found)) if name not in ("", shown)),
        None,
    )
    if other is not None:
        try:
            _, front = pareto(surfaces, (shown, other))
        except InputError:  # without pymoo the runs alone are shown
            front = np.empty((0, 2))
        pictures["pareto"] = figures.draw(figures.pareto_front, surfaces, (shown, other), front)
    return pictures
