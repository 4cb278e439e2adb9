"""`simulate(case, folder)`: the wiring of case, solver and result files."""

from __future__ import annotations

import contextlib
import os
import platform
import shutil
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numba
import numpy as np

import billow
from billow.case.build import build_model, build_schedule, require_start_clear
from billow.case.schema import Case
from billow.contact.rigid_contact import SuperEllipsoid
from billow.dynamics.model import Model, State
from billow.dynamics.run import run
from billow.errors import InputError, NumericalStop, ResourceError
from billow.gas.gas_model import GasTotals
from billow.impactor import rigid_body
from billow.results.atomic import publish_folder, write_atomically
from billow.results.histories import write_histories
from billow.results.result import Result
from billow.results.run_file import write_run_file
from billow.results.vtkhdf import FabricWriter

LOG_HEADER = (
    "    step    time[ms]   dt[us]  p_gauge[kPa]    T[K]     V[l]    m[g]"
    "   E_kin[J]   E_int[J] E_diss[J]   W_gas[J]  error[%]   ETA[s]"
)


@dataclass(frozen=True)
class Progress:
    """How far a run is: time and end [s], one line of the solver log."""

    time: float
    end: float
    line: str


def simulate(
    case: Case,
    folder: str | Path,
    *,
    progress: Callable[[Progress], None] | None = None,
    threads: int | None = None,
) -> Result:
    """Run a case and publish its results in `folder`, which must not exist yet.

    progress: called at each output frame. threads: of the compiled kernels, all by default; results do not depend on
    it. While it runs, everything lies in `folder`.partial; it takes its name when complete. A run that had to be
    stopped is published too, with status "stopped", before NumericalStop is raised. An interrupted run stays in
    `folder`.partial.

    Raises InputError (case, geometry, folder), NumericalStop, ResourceError E-RES-020 (disk).
    """
    folder = Path(folder)
    partial = _make_partial(folder)
    try:
        model = build_model(case)
        require_start_clear(model)
        write_atomically(partial / "case.toml", case.to_toml())
        with _threads(threads), _Recorder(case, model, partial, progress) as recorder:
            status, failure = "completed", None
            try:
                run(model, build_schedule(case.run), recorder)
            except NumericalStop as stop:
                status, failure = "stopped", stop
            except KeyboardInterrupt as interrupt:
                status, failure = "interrupted", interrupt
        recorder.finish(status, None if failure is None else str(failure) or "interrupted by the user")
        if status == "interrupted":
            raise failure
        publish_folder(partial, folder)
        if failure is not None:
            raise failure
    except OSError as error:
        raise ResourceError(
            "E-RES-020",
            "the results could not be written",
            where=str(partial),
            why=error.strerror or str(error),
            remedy="free space or choose another folder, then run again",
        ) from error
    except InputError:
        shutil.rmtree(partial, ignore_errors=True)
        raise
    return Result.open(folder)


def _make_partial(folder: Path) -> Path:
    if folder.exists() and (not folder.is_dir() or any(folder.iterdir())):
        raise InputError(
            "E-RES-009",
            "the result folder exists already",
            where=str(folder),
            why="a published result is never overwritten",
            remedy="choose another folder with --out, or delete this one",
        )
    partial = folder.with_name(folder.name + ".partial")
    shutil.rmtree(partial, ignore_errors=True)  # of an earlier, interrupted try
    partial.mkdir(parents=True)
    return partial


@contextlib.contextmanager
def _threads(count: int | None) -> Iterator[None]:
    before = numba.get_num_threads()
    numba.set_num_threads(min(count or before, numba.config.NUMBA_NUM_THREADS))
    try:
        yield
    finally:
        numba.set_num_threads(before)


class _Recorder:
    """Writes what a run tells: frames at once, histories and the record at the end, a line of log at each frame."""

    def __init__(self, case: Case, model: Model, folder: Path, progress: Callable[[Progress], None] | None):
        self.case, self.model, self.folder, self.progress = case, model, folder, progress
        surface = model.surface
        self.frames = FabricWriter(
            folder / "fabric.vtkhdf",
            model.start,
            surface.triangles.astype(np.int64),
            surface.part,
            list(surface.part_names),
        )
        self.rows: list[dict[str, float]] = []
        self.log: list[str] = []
        self.begun = time.perf_counter()
        self.state: State | None = None

    def __enter__(self) -> _Recorder:
        membrane = min(self.model.membranes, key=lambda m: m.altitude.min())
        element = int(membrane.elements[membrane.altitude.argmin()])
        part = self.model.surface.part_names[self.model.surface.part[element]]
        self._say(f"Billow {billow.__version__}: {self.case.title}")
        self._say(
            f"{self.model.surface.triangle_count} triangles, {self.model.surface.node_count} nodes, fabric "
            f"{self.model.mass.sum():.3f} kg; triangle {element} ({part}) limits the step"
        )
        self._say(LOG_HEADER)
        return self

    def __exit__(self, *_) -> None:
        self.frames.close()

    def history(self, model: Model, state: State, dt: float) -> None:
        self.state = state
        row = {"time [s]": state.time, "dt [s]": dt}
        row |= _gas_columns(model.gas.totals(state.gas))
        row |= _energy_columns(state)
        for obstacle, body in zip(model.obstacles, state.bodies, strict=True):
            row |= _body_columns(model, obstacle, body)
        for k in range(model.straps.strap_count):
            row[f"strap_{k + 1}_tension [N]"] = float(state.bar[model.straps.strap == k, 0].sum())
        self.rows.append(row)

    def frame(self, model: Model, state: State) -> None:
        touching = {True: np.zeros_like(state.positions), False: np.zeros_like(state.positions)}
        for obstacle, contact in zip(model.obstacles, state.contacts, strict=True):
            touching[isinstance(obstacle.shape, SuperEllipsoid)] += contact.force
        self.frames.append(
            state.time,
            state.positions,
            point_data={
                "displacement": state.positions - model.start,
                "velocity": state.velocities,
                "contact_force": touching[True],
                "plate_force": touching[False],
            },
            cell_data=model.gas.fields(state.gas),
        )
        self._say(self._line(state))

    def finish(self, status: str, reason: str | None) -> None:
        """Write histories, log and the run's record."""
        totals, ledger = self.model.gas.totals(self.state.gas), self.state.ledger
        residual = max(ledger.largest_gain, -ledger.largest_loss)
        injected = max(totals.enthalpy_in, 1e-300)
        books = {
            "gas_mass_error": totals.mass_error,
            "gas_energy_error": totals.energy_error,
            "energy_residual_joule": ledger.residual,
            "energy_residual_of_injected": residual / injected if totals.enthalpy_in else 0.0,
            "energy_residual_of_largest": ledger.relative_error,
            "injected_mass_kg": totals.injected,
            "injected_enthalpy_joule": totals.enthalpy_in,
            "jet_impulse_delivered": totals.jet_impulse_out / totals.jet_impulse_in if totals.jet_impulse_in else 1.0,
        }
        self._say(
            f"{status}: mass error {books['gas_mass_error']:.1e}, gas energy error {books['gas_energy_error']:.1e}, "
            f"whole energy residual {100 * books['energy_residual_of_injected']:.4f} % of injected "
            f"({100 * books['energy_residual_of_largest']:.2f} % of the largest energy)"
        )
        columns = {key: np.array([row[key] for row in self.rows]) for key in self.rows[0]}
        write_histories(self.folder / "histories.csv", columns)
        write_atomically(self.folder / "solver.log", "\n".join(self.log) + "\n")
        write_run_file(
            self.folder,
            {
                "status": status,
                "reason": reason,
                "title": self.case.title,
                "billow_version": billow.__version__,
                "case_digest": self.case.digest(),
                "wall_seconds": time.perf_counter() - self.begun,
                "steps": self.state.step,
                "threads": numba.get_num_threads(),
                "simulated_time": self.state.time,
                "ledger": books,
                "obstacles": [_describe(o) for o in self.model.obstacles],
                "environment": environment(),
            },
        )

    def _line(self, state: State) -> str:
        totals, ledger = self.model.gas.totals(state.gas), state.ledger
        spent = time.perf_counter() - self.begun
        to_go = spent * (self.case.run.end_time / state.time - 1.0) if state.time > 0.0 else float("nan")
        dt = self.rows[-1]["dt [s]"]
        return (
            f"{state.step:8d} {1e3 * state.time:11.3f} {1e6 * dt:8.3f}"
            f" {1e-3 * (totals.pressure - self.case.ambient.pressure):13.3f} {totals.temperature:7.1f}"
            f" {1e3 * totals.volume:8.3f} {1e3 * totals.mass:7.2f}"
            f" {ledger.kinetic + ledger.body_kinetic:10.2f} {ledger.internal:10.2f}"
            f" {ledger.damping + ledger.friction:9.2f} {ledger.gas_work:10.2f}"
            f" {100 * ledger.relative_error:9.3f} {to_go:8.1f}"
        )

    def _say(self, line: str) -> None:
        self.log.append(line)
        if self.progress is not None:
            now = self.state.time if self.state is not None else 0.0
            self.progress(Progress(now, self.case.run.end_time, line))


def _gas_columns(totals: GasTotals) -> dict[str, float]:
    return {
        "pressure [Pa]": totals.pressure,
        "temperature [K]": totals.temperature,
        "volume [m^3]": totals.volume,
        "gas_mass [kg]": totals.mass,
        "gas_energy [J]": totals.energy,
        "injected [kg]": totals.injected,
        "vented [kg]": totals.vented,
        "leaked [kg]": totals.leaked,
        "drawn_in [kg]": totals.drawn_in,
        "enthalpy_in [J]": totals.enthalpy_in,
        "enthalpy_out [J]": totals.enthalpy_out,
        "pressure_work [J]": totals.work,
        "jet_work [J]": totals.jet_work,
        "jet_impulse_in [N s]": totals.jet_impulse_in,
        "jet_impulse_out [N s]": totals.jet_impulse_out,
    }


def _energy_columns(state: State) -> dict[str, float]:
    ledger = state.ledger
    return {
        "kinetic [J]": ledger.kinetic,
        "body_kinetic [J]": ledger.body_kinetic,
        "strain [J]": ledger.strain,
        "strap [J]": ledger.strap,
        "contact [J]": ledger.contact,
        "damping [J]": ledger.damping,
        "friction [J]": ledger.friction,
        "gas_work [J]": ledger.gas_work,
        "gravity_work [J]": ledger.gravity_work,
        "energy_residual [J]": ledger.residual,
    }


def _body_columns(model: Model, obstacle, body: rigid_body.RigidState) -> dict[str, float]:
    columns = {f"{obstacle.name}_force_{axis} [N]": float(body.force[k]) for k, axis in enumerate("xyz")}
    if obstacle.body.locked:
        return columns
    acceleration = body.force / obstacle.body.mass + model.gravity
    spin = rigid_body.spin(obstacle.body, body)
    for k, axis in enumerate("xyz"):
        columns[f"{obstacle.name}_centre_{axis} [m]"] = float(body.centre[k])
        columns[f"{obstacle.name}_velocity_{axis} [m/s]"] = float(body.velocity[k])
        columns[f"{obstacle.name}_acceleration_{axis} [m/s^2]"] = float(acceleration[k])
        columns[f"{obstacle.name}_spin_{axis} [rad/s]"] = float(spin[k])
    for k, part in enumerate("wxyz"):
        columns[f"{obstacle.name}_quaternion_{part} [-]"] = float(body.quaternion[k])
    return columns


def _describe(obstacle) -> dict:
    """What a picture of an obstacle needs, at the start."""
    described = {"name": obstacle.name, "kind": "plate", "center": obstacle.start.centre.tolist()}
    if isinstance(obstacle.shape, SuperEllipsoid):
        described |= {
            "kind": "super-ellipsoid",
            "radii": obstacle.shape.radii.tolist(),
            "degree": obstacle.shape.degree,
            "rotation": obstacle.start.rotation.tolist(),
            "locked": obstacle.body.locked,
        }
    return described


def environment() -> dict[str, str | int]:
    """What a timing or a last bit may depend on."""
    return {
        "python": platform.python_version(),
        "numpy": np.__version__,
        "numba": numba.__version__,
        "machine": platform.machine(),
        "system": platform.system(),
        "processor": _processor(),
        "cores": os.cpu_count() or 1,
    }


def _processor() -> str:
    try:
        with open("/proc/cpuinfo", encoding="utf-8") as file:
            return next(line.split(":", 1)[1].strip() for line in file if line.startswith("model name"))
    except (OSError, StopIteration):
        return platform.processor() or "unknown"
