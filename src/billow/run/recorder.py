"""The recorder of a run: journal, log, checkpoints while it runs; result files when it ends."""

from __future__ import annotations

import copy
import json
import math
import time
from collections import deque
from collections.abc import Callable
from dataclasses import asdict, dataclass
from pathlib import Path

import numba
import numpy as np

import billow
from billow.base.errors import NumericalStop
from billow.case.plausibility import warnings
from billow.case.schema import Case
from billow.parts.bodies.rigid_contact import SuperEllipsoid
from billow.parts.gas.gas_model import LocalGas
from billow.results import journal as journals
from billow.results.atomic import write_atomically
from billow.results.frame_files import write_frames
from billow.results.histories import write_histories
from billow.results.journal import Journal
from billow.results.machine import machine
from billow.results.quality import Criterion, judge, overall
from billow.results.run_file import write_run_file
from billow.run.checkpoint_file import SLOTS, write_checkpoint
from billow.run.history_columns import history_row
from billow.run.interrupts import Interrupts, RunInterrupted
from billow.solver.inspection import inverted_elements
from billow.solver.model import Model, Obstacle, State

CHECKPOINT_SECONDS = 30.0
"""Wall time [s] between two checkpoints."""

JOURNAL = "journal.bin"
LAST_GOOD = "last_good.safetensors"
"""State at the last frame before a run was stopped, beside its post-mortem."""

LAST_STEPS = 100
"""Steps whose energies go into a post-mortem."""

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


class RunRecorder:
    """Listens to one run and keeps its folder."""

    def __init__(
        self,
        case: Case,
        model: Model,
        folder: Path,
        interrupts: Interrupts,
        progress: Callable[[Progress], None] | None,
        journal_offset: int = 0,
    ):
        self.case, self.model, self.folder, self.progress = case, model, folder, progress
        self.interrupts = interrupts
        self.warnings = warnings(case, model)
        self.digest = case.digest()
        self.journal = Journal(folder / JOURNAL, journal_offset)
        self.log = open(folder / "solver.log", "a", encoding="utf-8")  # noqa: SIM115 - lives as long as the run
        self.begun = self.saved = time.perf_counter()
        self.slot = 0
        self.state: State | None = None
        self.last_good: tuple[State, int] | None = None
        self.last_steps: deque[tuple[float, ...]] = deque(maxlen=LAST_STEPS)

    # --- while the run goes on -------------------------------------------------------------------------------------

    def greet(self, state: State | None = None) -> None:
        """First lines of the log; `state`: where a resumed run goes on."""
        membrane = min(self.model.membranes, key=lambda m: m.altitude.min())
        element = int(membrane.elements[membrane.altitude.argmin()])
        part = self.model.surface.part_names[self.model.surface.part[element]]
        self.say(f"Billow {billow.__version__}: {self.case.title}")
        if state is not None:
            self.say(f"resumed at {1e3 * state.time:.4f} ms, step {state.step}")
        self.say(
            f"{self.model.surface.triangle_count} triangles, {self.model.surface.node_count} nodes, fabric "
            f"{self.model.mass.sum():.3f} kg; triangle {element} ({part}) limits the step"
        )
        for warning in self.warnings:
            self.say(str(warning))
        if (self.case.run.sensors or self.case.run.particle_times) and not isinstance(self.model.gas, LocalGas):
            self.say(f"sensors and particles are not written: gas.model = {self.case.gas.model} has no places")
        self.say(LOG_HEADER)

    def say(self, line: str) -> None:
        """A line for the log and for whoever watches."""
        self.log.write(line + "\n")
        self.log.flush()
        if self.progress is not None:
            now = self.state.time if self.state is not None else 0.0
            self.progress(Progress(now, self.case.run.end_time, line))

    def history(self, model: Model, state: State) -> None:
        self.state = state
        row = history_row(model, state, {s.name: s.position for s in self.case.run.sensors})
        if self.journal.offset == 0:
            self.journal.columns(list(row))
        self.journal.row(np.array(list(row.values())))
        if isinstance(model.gas, LocalGas) and self._particles_wanted(state):
            particles = {f"particle.{name}": array for name, array in model.gas.points(state.gas).items()}
            self.journal.frame({"time": np.array([state.time])} | particles)
        self.interrupts.look_for_stop_file()

    def frame(self, model: Model, state: State) -> None:
        touching = {True: np.zeros_like(state.positions), False: np.zeros_like(state.positions)}
        for obstacle, force in zip(model.obstacles, state.contact.force, strict=True):
            touching[isinstance(obstacle.shape, SuperEllipsoid)] += force
        arrays = {
            "time": np.array([state.time]),
            "positions": state.positions,
            "point.displacement": (state.positions - model.start).astype(np.float32),
            "point.velocity": state.velocities.astype(np.float32),
            "point.contact_force": touching[True].astype(np.float32),
            "point.plate_force": touching[False].astype(np.float32),
        }
        arrays |= {f"cell.{name}": field.astype(np.float32) for name, field in model.gas.fields(state.gas).items()}
        if self.case.run.gas_frames and isinstance(model.gas, LocalGas):
            arrays |= {f"cloud.{name}": array.astype(np.float32) for name, array in model.gas.cells(state.gas).items()}
        self.journal.frame(arrays)
        self.last_good = copy.deepcopy(state), self.journal.offset
        self.say(self._line(state))

    def step(self, model: Model, state: State) -> None:
        self.state = state
        ledger = state.ledger
        self.last_steps.append((state.time, ledger.kinetic, ledger.strain, ledger.gas_work, ledger.residual))
        if self.interrupts.stop:
            self.save(state)
            raise RunInterrupted("asked to stop")
        if self.interrupts.save or (state.step % 64 == 0 and time.perf_counter() - self.saved > CHECKPOINT_SECONDS):
            self.interrupts.save = False
            self.save(state)

    def save(self, state: State) -> None:
        """Write a checkpoint into the older of the two slots."""
        self.journal.sync()
        write_checkpoint(self.folder / SLOTS[self.slot], state, self.digest, self.journal.offset)
        self.slot = 1 - self.slot
        self.saved = time.perf_counter()

    # --- when it ends ----------------------------------------------------------------------------------------------

    def finish(self, status: str, reason: str | None) -> list[Criterion]:
        """Write result files from the journal, and the run's record with its verdict."""
        self.journal.sync()
        self.journal.close()
        write_frames(self.folder, self.folder / JOURNAL, self.model.start, self.model.surface)
        histories = journals.read_histories(self.folder / JOURNAL)
        write_histories(self.folder / "histories.csv", histories)
        books = self._books(histories)
        rigid = {o.name: not isinstance(o.shape, SuperEllipsoid) or not o.body.locked for o in self.model.obstacles}
        criteria = judge(histories, books, rigid, self.case.run.end_time)
        self.say(
            f"{status}: mass error {books['gas_mass_error']:.1e}, gas energy error {books['gas_energy_error']:.1e}, "
            f"whole energy residual {100 * books['energy_residual_of_injected']:.4f} % of injected "
            f"({100 * books['energy_residual_of_largest']:.2f} % of the largest energy)"
        )
        if isinstance(self.model.gas, LocalGas):
            self.say(f"particles found outside and put back: {books['leaked_particles']:.0f}")
        self.say(f"quality: {overall(criteria)}")
        for c in criteria:
            if c.verdict != "PASS":
                self.say(f"  {c.verdict}: {c.name} = {c.measured:.4g} {c.unit} (passes up to {c.passes:g})")
        self.log.close()
        if status == "completed":
            for name in (JOURNAL, *SLOTS):
                (self.folder / name).unlink(missing_ok=True)
        write_run_file(
            self.folder,
            {
                "status": status,
                "reason": reason,
                "title": self.case.title,
                "billow_version": billow.__version__,
                "case_digest": self.digest,
                "wall_seconds": time.perf_counter() - self.begun,
                "steps": self.state.step,
                "threads": numba.get_num_threads(),
                "simulated_time": self.state.time,
                "ledger": books,
                "quality": {"verdict": overall(criteria), "criteria": [c.record() for c in criteria]},
                "warnings": [asdict(warning) for warning in self.warnings],
                "obstacles": [_describe(o) for o in self.model.obstacles],
                "environment": environment(),
            },
        )
        return criteria

    def post_mortem(self, stop: NumericalStop) -> None:
        """What was known when a run was stopped: cause, energies of the last steps, the surroundings of bad nodes."""
        triangles = self.model.surface.triangles
        around = np.unique(triangles[np.isin(triangles, stop.nodes).any(axis=1)]) if stop.nodes else []
        record = {
            "code": stop.code,
            "what": stop.what,
            "where": stop.where,
            "why": stop.why,
            "try": stop.remedy,
            "nodes": list(stop.nodes),
            "surroundings": [
                {
                    "node": int(node),
                    "start": self.model.start[node].tolist(),
                    "position": [repr(float(v)) for v in self.state.positions[node]],
                    "velocity": [repr(float(v)) for v in self.state.velocities[node]],
                }
                for node in around
            ],
            "last_steps": {
                "columns": ["time [s]", "kinetic [J]", "strain [J]", "gas_work [J]", "energy_residual [J]"],
                "rows": [[repr(float(v)) for v in row] for row in self.last_steps],
            },
        }
        write_atomically(self.folder / "postmortem.json", json.dumps(record, indent=1) + "\n")
        if self.last_good is not None:
            self.journal.sync()
            write_checkpoint(self.folder / LAST_GOOD, self.last_good[0], self.digest, self.last_good[1])

    def _particles_wanted(self, state: State) -> bool:
        """Whether a wanted time lies between the last row of histories and this one; a resumed run answers the same."""
        run = self.case.run
        between = run.end_time / (run.frames * run.histories_per_frame)
        return state.interval in {math.ceil(time / between - 1e-6) for time in run.particle_times}

    def _books(self, histories: dict[str, np.ndarray]) -> dict[str, float]:
        totals, ledger = self.model.gas.totals(self.state.gas), self.state.ledger
        residual = max(ledger.largest_gain, -ledger.largest_loss)
        largest = max(ledger.largest_energy, 1e-300)
        return {
            "gas_mass_error": totals.mass_error,
            "gas_energy_error": totals.energy_error,
            "energy_residual_joule": ledger.residual,
            "energy_residual_of_injected": residual / totals.enthalpy_in if totals.enthalpy_in else 0.0,
            "energy_residual_of_largest": ledger.relative_error,
            "energy_gain_of_largest": ledger.largest_gain / largest,
            "energy_loss_of_largest": -ledger.largest_loss / largest,
            "injected_mass_kg": totals.injected,
            "injected_enthalpy_joule": totals.enthalpy_in,
            "jet_impulse_delivered": totals.jet_impulse_out / totals.jet_impulse_in if totals.jet_impulse_in else 1.0,
            "shooting_nodes": float(histories["shooting_nodes [-]"].max()),
            "inverted_elements": float(inverted_elements(self.model, self.state)),
            "leaked_particles": float(totals.escaped),
            "leaked_particles_share": totals.escaped / self.case.gas.particles,
            "plausibility_warnings": float(len(self.warnings)),
        }

    def _line(self, state: State) -> str:
        totals, ledger = self.model.gas.totals(state.gas), state.ledger
        spent = time.perf_counter() - self.begun
        to_go = spent * (self.case.run.end_time / state.time - 1.0) if state.time > 0.0 else float("nan")
        return (
            f"{state.step:8d} {1e3 * state.time:11.3f} {1e6 * state.dt:8.3f}"
            f" {1e-3 * (totals.pressure - self.case.ambient.pressure):13.3f} {totals.temperature:7.1f}"
            f" {1e3 * totals.volume:8.3f} {1e3 * totals.mass:7.2f}"
            f" {ledger.kinetic + ledger.body_kinetic:10.2f} {ledger.internal:10.2f}"
            f" {ledger.damping + ledger.friction:9.2f} {ledger.gas_work:10.2f}"
            f" {100 * ledger.relative_error:9.3f} {to_go:8.1f}"
        )


def _describe(obstacle: Obstacle) -> dict:
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
    return {**machine(), "numpy": np.__version__, "numba": numba.__version__}
