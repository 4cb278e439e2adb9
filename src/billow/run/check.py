"""What can be said of a case before it runs."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from billow.case.assumptions import HEADING, assumptions
from billow.case.bag.build_bag import build_shape, fold_plan
from billow.case.build import build_model, build_schedule, require_start_clear
from billow.case.concerns import concerns_of, start_panels
from billow.case.gas.models import GAS_MODELS
from billow.case.schema import Case
from billow.geometry.crossings import CrossingCount
from billow.results.dataset_files import fingerprint
from billow.results.histories import columns
from billow.run.names import owners, require_distinct
from billow.run.recorder import quantities
from billow.solver.checkpoint import flatten
from billow.solver.model import Model, start_state
from billow.solver.step_size import stable_dt

SECONDS_PER_STEP = 220e-6  # rough cost that does not depend on the mesh, on one core of a 2020s processor
MEGABYTES = 250.0  # of the program itself


class Outline(NamedTuple):
    """What all runs of a study have in common. nodes, triangles: how many; mesh: fingerprint of the start shape; times:
    of the frames [s]. topology: fingerprint of the triangles alone."""

    nodes: int
    triangles: int
    mesh: str
    times: tuple[float, ...]
    topology: str = ""


class Recorded(NamedTuple):
    """What a run will hold. columns: of its histories, such as "volume [m^3]"; parts: of the fabric; obstacles: name ->
    whether it moves; interval: between two rows of the histories [s]."""

    columns: tuple[str, ...]
    parts: tuple[str, ...]
    obstacles: dict[str, bool]
    interval: float


def recorded(case: Case) -> Recorded:
    """Build the model of a case and say what its run will hold. InputError as `describe`."""
    model, schedule = build_model(case), build_schedule(case.run)
    sensors = {sensor.name: sensor.position for sensor in case.run.sensors}
    interval = schedule.end / (schedule.frames * schedule.histories_per_frame)
    return Recorded(
        tuple(columns(quantities(model, start_state(model), sensors))),
        model.surface.part_names,
        {body.name: body.moves for body in model.bodies.bodies},
        interval,
    )


def outline(case: Case) -> Outline:
    """Build the model of a case and say what its run has in common with others. InputError as `describe`."""
    model = build_model(case)
    require_start_clear(model)
    schedule, surface = build_schedule(case.run), model.surface
    times = tuple(schedule.end * frame / schedule.frames for frame in range(schedule.frames + 1))
    mesh, topology = (fingerprint(model.start, surface.triangles, own_starts) for own_starts in (False, True))
    return Outline(surface.node_count, surface.triangle_count, mesh, times, topology)


def describe(case: Case) -> str:
    """A short text: size, masses, time step, expected run time, memory and disk, and what looks unintended.

    Raises InputError for everything that would stop the run before its first step: a bag that is not closed, seams that
    do not match, normals that point inwards, fabric inside an obstacle, values that cannot be.
    """
    model = build_model(case)
    require_distinct(owners(model, (sensor.name for sensor in case.run.sensors)))
    require_start_clear(model)
    schedule = build_schedule(case.run)
    state = start_state(model)
    dt = schedule.dt_scale * stable_dt(model, state)
    steps = math.ceil(schedule.end / dt)
    surface, chambers = model.surface, model.surface.chambers
    arrays = [array.nbytes for array in flatten(state)[0].values()]
    disk = schedule.frames * (surface.node_count * 4 * 15 + surface.triangle_count * 4)
    # A state, its copy at the last frame, and constants and work arrays of that size.
    memory = MEGABYTES + (3.0 * sum(arrays) + surface.triangle_count * 8 * 40) / 1e6
    # What every part says of itself, and what is there anyway.
    seconds = SECONDS_PER_STEP + sum(
        part.seconds_per_step(state.of(name), dt, schedule.end) for name, part in model.parts
    )
    lines = [
        f"{case.title}: ready to run",
        f"  mesh      {surface.triangle_count} triangles, {surface.node_count} nodes",
        f"  parts     {', '.join(surface.part_names)}",
        *(
            f"  panel     {p.name}: {p.flat_area:.4f} m^2 as cut{', seen from inside' if p.from_inside else ''}; edges "
            f"start at {100 * p.shortest:.1f} to {100 * p.longest:.1f} % of their cut length"
            for p in start_panels(model)
        ),
        *(
            f"  chamber   {name}: {1e3 * volume:.3f} l at the start"
            for name, volume in zip(chambers.names, chambers.volumes(surface.triangles, model.start), strict=True)
            if chambers.count > 1
        ),
        f"  fabric    {model.mass.sum():.4f} kg; start volume {1e3 * surface.volume(model.start):.3f} l, closed",
        *_snapped(case),
        *_sewn(case),
        *_folded(case, model),
        f"  crossings {CrossingCount(surface).total(model.start):.0f} of fabric through fabric",
        f"  step      {1e6 * dt:.4g} us, about {steps} steps",
        f"  run time  about {max(1.0, steps * seconds):.0f} s on one core",
        f"  needs     about {memory:.0f} MB of memory and up to {2 * disk / 1e6:.0f} MB of disk; each worker of a "
        "study needs as much memory",
    ]
    if model.gas.supply is not None:
        mass = sum(inflator.cumulative[-1] for inflator in model.gas.supply.inflators)
        gases = dict.fromkeys(name for inflator in case.inflators for name in inflator.gas)
        switches = GAS_MODELS[case.gas.model].is_local and case.gas.switch_time
        switch = f" until {1e3 * case.gas.switch_time:g} ms, then uniform-pressure" if switches else ""
        lines.append(f"  gas       {1e3 * mass:.1f} g of {' + '.join(gases)}, {case.gas.model}{switch}")
    taken = assumptions(case)
    if taken:
        lines += [f"  {HEADING}:", *(f"    {line}" for line in taken)]
    return "\n".join([*lines, *map(str, concerns_of(case, model))])


def _snapped(case: Case) -> Iterator[str]:
    """How far the ends of straps are from where they were asked for."""
    moved = [1e3 * strap.moved for strap in build_shape(case.bag).straps]
    if any(moved):
        yield f"  straps    ends {', '.join(f'{way:.2g}' for way in moved)} mm from where they were asked for"


def _sewn(case: Case) -> Iterator[str]:
    """How much of each tear seam found nodes to tie."""
    for line in build_shape(case.bag).tear_lines:
        yield f"  seam      {line.name}: {len(line.ties)} ties over {1e3 * line.length.sum():.0f} mm"


def _folded(case: Case, model: Model) -> Iterator[str]:
    plan = fold_plan(case.bag)
    if plan is None:
        return
    size = " x ".join(f"{1e3 * extent:.4g}" for extent in np.ptp(model.start, axis=0))
    longest = max(panel.longest for panel in start_panels(model)) - 1.0
    yield f"  folded    {plan.layers} layers, {size} mm; edges stretched by {100 * longest:.2g} % at most"
