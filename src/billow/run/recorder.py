"""The recorder of a run: journal, log, checkpoints while it runs; result files when it ends."""

from __future__ import annotations

import copy
import json
import math
import time
from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numba
import numpy as np

import billow
from billow.base.errors import Concern, NumericalStop
from billow.base.quality import Criterion, criterion, overall
from billow.parts.part import LOST, MOTION, STORED, Quantity
from billow.results import journal as journals
from billow.results.atomic import write_atomically
from billow.results.frame_files import Lines, write_frames
from billow.results.histories import History, columns, values, write_histories
from billow.results.journal import JOURNAL, Journal
from billow.results.machine import machine
from billow.results.run_file import write_run_file
from billow.run.checkpoint_file import BEGINNING, SLOTS, Start, write_checkpoint
from billow.run.crossing_guard import CrossingGuard
from billow.run.interrupts import Interrupts, RunInterrupted
from billow.run.spent import Stopwatch
from billow.run.status import Status
from billow.solver.model import Model, State
from billow.solver.run import Recorder, Schedule

CHECKPOINT_SECONDS = 30.0
"""Wall time [s] between two checkpoints."""

LOG = "solver.log"
LAST_GOOD = "last_good.safetensors"
"""State at the last frame before a run was stopped, beside its post-mortem."""

LAST_STEPS = 100
"""Steps whose energies go into a post-mortem."""

COLUMNS = {
    "step": 7, "time[ms]": 8, "dt[us]": 6, "p_g[kPa]": 8, "T[K]": 5, "V[l]": 6, "m[g]": 6, "Ekin[J]": 7, "Eint[J]": 7,
    "Edis[J]": 7, "Wgas[J]": 7, "err[%]": 6, "ETA[s]": 6,
}  # fmt: skip
"""Of the table in the log, which is not wider than 100 letters: titles and widths."""
LOG_HEADER = " ".join(f"{title:>{width}}" for title, width in COLUMNS.items())
MOST_DIGITS = 5


def fitted(value: float, width: int) -> str:
    """A number in `width` letters, with as many digits as fit."""
    for digits in range(MOST_DIGITS, 0, -1):
        text = f"{value:.{digits}g}"
        if len(text) <= width:
            break
    return f"{text:>{width}}"


@dataclass(frozen=True)
class Progress:
    """How far a run is: time and end [s], one line of the solver log, or none and a status, as status.json has it."""

    time: float
    end: float
    line: str
    status: dict | None = None


@dataclass(frozen=True)
class Told:
    """What a run's record says besides what was computed, and what is wanted of it.

    digest: SHA-256 of whatever the model was made from. concerns: what looked unintended. assumptions: what was taken
    from Billow where a measurement belongs. sensors: places [m] where the
    gas is read, by name. particle_times: [s], when particles are recorded. gas_frames: whether the gas is, in boxes.
    guard_crossings: whether crossings of fabric are counted at every frame.
    """

    title: str
    digest: str
    schedule: Schedule
    concerns: Sequence[Concern] = ()
    assumptions: Sequence[str] = ()
    ambient_pressure: float = 101325.0
    sensors: Mapping[str, Sequence[float]] = field(default_factory=dict)
    particle_times: Sequence[float] = ()
    gas_frames: bool = True
    guard_crossings: bool = False


class RunRecorder(Recorder):
    """Listens to one run and keeps its folder."""

    def __init__(
        self,
        told: Told,
        model: Model,
        folder: Path,
        interrupts: Interrupts,
        progress: Callable[[Progress], None] | None = None,
        start: Start = BEGINNING,
    ):
        """start: what the run begins with, or goes on from."""
        self.told, self.model, self.folder, self.progress = told, model, folder, progress
        self.interrupts = interrupts
        self.journal = Journal(folder / JOURNAL, start.journal_offset)
        self.log = open(folder / LOG, "a", encoding="utf-8")  # noqa: SIM115 - lives as long as the run
        self.stopwatch, self.saved = Stopwatch(start.spent), time.perf_counter()
        self.slot = 0
        self.guard = CrossingGuard(model, told.guard_crossings)
        self.state: State | None = None
        self.last_good: Start | None = None
        self.status: Status | None = None
        self.touched: set[str] | None = None
        self.last_steps: deque[tuple[float, ...]] = deque(maxlen=LAST_STEPS)

    # --- while the run goes on -------------------------------------------------------------------------------------

    def greet(self, state: State | None = None) -> None:
        """First lines of the log; `state`: where a resumed run continues."""
        surface, told = self.model.surface, self.told
        element = self.model.fabric.smallest_element
        part = surface.part_names[surface.part[element]]
        self.say(f"Billow {billow.__version__}: {told.title}")
        if state is not None:
            self.say(f"resumed at {1e3 * state.time:.4f} ms, step {state.step}")
        self.say(
            f"{surface.triangle_count} triangles, {surface.node_count} nodes, fabric {self.model.mass.sum():.3f} kg; "
            f"triangle {element} ({part}) and its neighbours limit the step"
        )
        for line in told.assumptions:
            self.say(f"typical, not measured: {line}")
        for concern in told.concerns:
            self.say(str(concern))
        if (told.sensors or told.particle_times) and self.model.gas.model.view() is None:
            self.say("sensors and particles are not written: this gas is the same everywhere")
        self.say(LOG_HEADER)
        what = {"title": told.title, "limited_by": f"triangle {element} ({part}) and neighbours"}
        self.status = Status(self.folder, what, told.schedule.end, self.journal)

    def say(self, line: str) -> None:
        """A line for the log and for whoever watches."""
        self.log.write(line + "\n")
        self.log.flush()
        self._show(line)

    def _show(self, line: str, status: dict | None = None) -> None:
        if self.progress is not None:
            now = self.state.time if self.state is not None else 0.0
            try:
                self.progress(Progress(now, self.told.schedule.end, line, status))
            except BrokenPipeError:  # nobody watches any more
                self.progress = None

    def history(self, model: Model, state: State) -> None:
        self.state = state
        found = list(quantities(model, state, self.told.sensors))
        if self.journal.offset == 0:
            self.journal.columns(list(columns(found)))
        self.journal.row(np.array(values(found)))
        self._tell_contacts(found)
        if self.status is not None and self.status.due:
            self._show("", self.status.tell(state.time, state.step, columns(found)))
        if self._particles_wanted(state) and (particles := model.gas.particles(state.gas)):
            self.journal.frame({"time": np.array([state.time])} | named("particle", particles))
        self.interrupts.look_for_stop_file()

    def _tell_contacts(self, found: Sequence[Quantity]) -> None:
        """Say which bodies the bag touches for the first time; those touched when a run begins or resumes are known."""
        pushed = {q.of for q in found if q.name == "force" and q.of and np.any(q.value)}
        if self.touched is None:
            self.touched = pushed
        for name in sorted(pushed - self.touched):
            self.say(f"contact: the bag touches {name} at {1e3 * self.state.time:.3f} ms")
        self.touched |= pushed

    def frame(self, model: Model, state: State) -> None:
        point = {
            "displacement": (state.positions - model.start).astype(np.float32),
            "velocity": state.velocities.astype(np.float32),
        }
        arrays = {"time": np.array([state.time]), "positions": state.positions} | named("point", point)
        for name, part in model.parts:
            frame = part.frame(state.of(name), state.moment)
            for kind in ("point", "cell", "bar"):
                arrays |= named(kind, getattr(frame, kind), np.float32)
        arrays |= named("cell", self.guard.frame(state), np.float32)
        if self.told.gas_frames:
            on_lattice, boxes = model.gas.boxes(state.gas)
            arrays |= named("lattice" if on_lattice else "cloud", boxes, np.float32)
        self.journal.frame(arrays)
        self.last_good = Start(copy.deepcopy(state), self.journal.offset, self.stopwatch.spent)
        self.say(self._line(state))

    def step(self, model: Model, state: State) -> None:
        self.state = state
        ledger = state.ledger
        self.last_steps.append((state.time, ledger["kinetic"], ledger["strain"], ledger["gas_work"], ledger.residual))
        if self.interrupts.stop:
            self.save(state)
            raise RunInterrupted("asked to stop")
        if self.interrupts.save or (state.step % 64 == 0 and time.perf_counter() - self.saved > CHECKPOINT_SECONDS):
            self.interrupts.save = False
            self.save(state)

    def save(self, state: State) -> None:
        """Write a checkpoint into the older of the two slots."""
        self.journal.sync()
        start = Start(state, self.journal.offset, self.stopwatch.spent)
        write_checkpoint(self.folder / SLOTS[self.slot], start, self.told.digest)
        self.slot = 1 - self.slot
        self.saved = time.perf_counter()

    # --- when it ends ----------------------------------------------------------------------------------------------

    def finish(self, status: str, reason: str | None) -> list[Criterion]:
        """Write result files from the journal, and the run's record with its verdict."""
        self.journal.sync()
        self.journal.close()
        if self.status is not None:
            self.status.end_it()
        history = journals.read_history(self.folder / JOURNAL)
        write_histories(self.folder / "histories.csv", history)
        obstacles = [shape for body in self.model.bodies.bodies for shape in body.describe()]
        straps = self.model.straps
        names = tuple(straps.name(k) for k in range(straps.strap_count))
        lines, journal = Lines(straps.bars, straps.strap, names), self.folder / JOURNAL
        write_frames(self.folder, journal, self.model.start, self.model.surface, lines, obstacles, history)
        books, criteria = judge(self.model, self.state, history, self.told.schedule.end, len(self.told.concerns))
        books |= self.guard.books(self.state, journals.frames(self.folder / JOURNAL))
        criteria += self.guard.verdicts(books)
        self.say(
            f"{status}: mass error {books['gas_mass_error']:.1e}, gas energy error {books['gas_energy_error']:.1e}, "
            f"whole energy residual {100 * books['energy_residual_of_injected']:.4f} % of injected "
            f"({100 * books['energy_residual_of_largest']:.2f} % of the largest energy)"
        )
        for name, part in self.model.parts:
            for remark in part.remarks(self.state.of(name)):
                self.say(remark)
        for remark in self.guard.remarks(books):
            self.say(remark)
        self.say(f"quality: {overall(criteria)}")
        for c in criteria:
            if c.verdict != "PASS":
                self.say(f"  {c.line}")
        self.log.close()
        needed_no_more = (JOURNAL, *SLOTS) if status == "completed" else ()
        write_run_file(
            self.folder,
            {
                "status": status,
                "reason": reason,
                "title": self.told.title,
                "billow_version": billow.__version__,
                "case_digest": self.told.digest,
                "wall_seconds": self.stopwatch.spent.wall,
                "processor_seconds": self.stopwatch.spent.processor,
                "steps": self.state.step,
                "threads": numba.get_num_threads(),
                "simulated_time": self.state.time,
                "ledger": books,
                "quality": {"verdict": overall(criteria), "criteria": [c.record() for c in criteria]},
                "assumptions": list(self.told.assumptions),
                "warnings": [asdict(concern) for concern in self.told.concerns],
                "obstacles": obstacles,
                "environment": environment(),
            },
            without=needed_no_more,
        )
        for name in needed_no_more:  # not before the results are whole
            (self.folder / name).unlink(missing_ok=True)
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
            write_checkpoint(self.folder / LAST_GOOD, self.last_good, self.told.digest)

    def _particles_wanted(self, state: State) -> bool:
        """Whether a wanted time lies between the last row of histories and this one; a resumed run answers the same."""
        schedule = self.told.schedule
        between = schedule.end / (schedule.frames * schedule.histories_per_frame)
        return state.interval in {math.ceil(time / between - 1e-6) for time in self.told.particle_times}

    def _line(self, state: State) -> str:
        totals, ledger = self.model.gas.totals(state.gas), state.ledger
        numbers = (
            1e6 * state.dt, 1e-3 * (totals.pressure - self.told.ambient_pressure), totals.temperature,
            1e3 * totals.volume, 1e3 * totals.mass, ledger.side(MOTION), ledger.side(STORED), ledger.side(LOST),
            ledger["gas_work"], 100 * ledger.relative_error,
        )  # fmt: skip
        cells = [f"{state.step:7d}", f"{1e3 * state.time:8.3f}"]
        *widths, last = list(COLUMNS.values())[len(cells) :]
        cells += (fitted(*cell) for cell in zip(numbers, widths, strict=True))
        spent, end = self.stopwatch.spent.wall, self.told.schedule.end
        to_go = fitted(spent * (end / state.time - 1.0), last) if state.time > 0.0 else f"{'-':>{last}}"
        return " ".join([*cells, to_go])


def quantities(model: Model, state: State, sensors: Mapping[str, Sequence[float]]) -> Iterator[Quantity]:
    """A row of the histories: what solver, ledger, sensors and parts say now."""
    moment = state.moment
    yield Quantity("", "time", "s", state.time)
    yield Quantity("", "dt", "s", state.dt)
    for name, part in model.parts:
        yield from part.quantities(state.of(name), moment)
    yield from state.ledger.quantities()
    yield from model.gas.readings(state.gas, sensors)


def judge(
    model: Model, state: State, history: History, end: float, concerns: int
) -> tuple[dict[str, float], list[Criterion]]:
    """Books of a run that has reached `state`, and the criteria by which it is judged.

    end: time asked for [s]; concerns: number of things that looked unintended.
    """
    moment, books = state.moment, {}
    for name, part in model.parts:
        books |= part.books(state.of(name), moment, history)
    books |= state.ledger.books(books["injected_enthalpy_joule"], history)
    criteria = list(state.ledger.verdicts(books))
    for _, part in model.parts:
        criteria += part.verdicts(books, history)
    criteria.append(criterion("plausibility warnings", concerns, 0, math.inf, "-", "what each warning says"))
    missing = 1e3 * max(0.0, end - state.time)
    on = "billow resume, if the run was interrupted; what its reason says, if it was stopped"
    criteria.append(criterion("time asked for and not simulated", missing, 1e-9, 1e-6, "ms", on))
    return books | {"plausibility_warnings": float(concerns)}, criteria


def named(kind: str, fields: Mapping[str, np.ndarray], dtype=None) -> dict[str, np.ndarray]:
    """Fields of one kind as the journal keeps them."""
    return {f"{kind}.{name}": array if dtype is None else array.astype(dtype) for name, array in fields.items()}


def environment() -> dict[str, str | int]:
    """What a timing or a last bit may depend on."""
    return {**machine(), "numpy": np.__version__, "numba": numba.__version__}
