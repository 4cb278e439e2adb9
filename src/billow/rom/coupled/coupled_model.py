"""The surrogate coupled to its own impactor: nothing about the deployment is known in advance.

The ROM paper predicts the bag with the contact forces of the run to be predicted, and names this coupling as future
work. Step by step:

    bag(t)  ->  fabric within reach of the body where it now is  ->  contact force  ->  the body moves  ->  t + dt

The bag is a `Surrogate`, the force a `ContactLaw`. It is held for dt, `EVERY` intervals of the histories, and the
body's centre then moves on a parabola, whose points at the histories' times are the answer.
The body's rotation stays that of the start: in the driver-bag study it turns by less than 3 degrees while the force is
large.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.injury.curve import sample_interval
from billow.results.dataset_files import same_times
from billow.results.tensor_file import write_tensors
from billow.rom.coupled.contact_force import EVERY, REACHES, ContactLaw, area_vectors, learn_contact_law, node_area
from billow.rom.coupled.coupled_file import coupled_content, read_coupled
from billow.rom.coupled.impactor import Impactor, ImpactorMotion, ImpactorOfDesign, filtered_force
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Progress
from billow.rom.surrogate.design_space import check_design, design_rows
from billow.rom.surrogate.surrogate import Surrogate

CANNOT_COUPLE = InputError.declare(
    "E-CPL-005",
    "a coupled model cannot be learned",
    cause="the surrogate was trained with force_modes, or histories of the runs have different times",
    remedy="train the surrogate without force_modes, on runs with the same run.histories_per_frame",
)


@dataclass(frozen=True, eq=False, repr=False)
class Coupled:
    """A surrogate of the bag, a free body and the force between them.

        coupled = Coupled.train(dataset, surrogate)
        motion = coupled.deploy({"permeability": 0.03, ...})
        motion.velocity[-1]          # [m/s]

    times: [s], (steps + 1,) float64, evenly spaced from 0
    gravity: [m/s^2], (3,)
    """

    surrogate: Surrogate
    impactor: ImpactorOfDesign
    law: ContactLaw
    times: np.ndarray
    gravity: np.ndarray

    @classmethod
    def train(cls, dataset: Dataset, surrogate: Surrogate, seed: int = 0, progress: Progress | None = None) -> Coupled:
        """Learn the contact force of the runs that `surrogate` was learned from. Test runs are never read.

        progress(epoch, epochs, loss) is called after each epoch.
        Raises InputError E-CPL-003 and E-CPL-004 (no free obstacle, or one that the design does not determine),
        E-CPL-005 (the surrogate needs forces itself, or histories of runs differ in their times), ResourceError
        E-ROM-006 (no PyTorch), NumericalStop E-ROM-014 (training failed).
        """
        runs = surrogate.runs
        impactor = ImpactorOfDesign.learn(dataset, runs)
        motions = [ImpactorMotion.of_run(dataset.result(run), impactor.name) for run in runs]
        times = motions[0].times
        _require_alike(surrogate, motions)
        gravity = np.array(dataset.result(runs[0]).case_toml["run"]["gravity"], float)
        design = np.asarray(dataset.design(runs), float)
        unfinished = cls(surrogate, impactor, None, times, gravity)
        starts = unfinished._starts
        state, force = [], []
        for row, motion in zip(design, motions, strict=True):
            body, bag = impactor(row), unfinished._bag(row)
            moved = zip(bag, motion.centre[starts], motion.velocity[starts], strict=True)
            state.append([unfinished._state(nodes, body, *place) for nodes, *place in moved])
            force.append(unfinished._held(filtered_force(motion, body.mass, gravity)))
        at, inputs = unfinished._middles, surrogate.regression.inputs
        law = learn_contact_law(inputs, design, at, np.array(state), np.array(force), seed, progress)
        return cls(surrogate, impactor, law, times, gravity)

    def __repr__(self) -> str:
        return f"Coupled({self.surrogate!r}, impactor={self.impactor.name!r}, {len(self.times) - 1} steps)"

    def save(self, path: str | Path) -> Path:
        """Write everything to one file without pickle, atomically. `Surrogate.load` reads the bag from it too."""
        return write_tensors(path, *coupled_content(self))

    @classmethod
    def load(cls, path: str | Path) -> Coupled:
        """Read a file written by `save`. Errors as `read_coupled`."""
        return cls(**read_coupled(path))

    def deploy(
        self, design, *, extrapolate: bool = False, pushed: np.ndarray | None = None, bag: np.ndarray | None = None
    ) -> ImpactorMotion:
        """Motion of the impactor in one deployment.

        design: {name: value} or (parameters,)
        pushed: [m], (3,), the body starts displaced by this much from where the design puts it
        bag: [m], (steps, nodes, 3), where the fabric is at `step_times`, default what the surrogate predicts
        Raises InputError E-ROM-001 and E-ROM-002, as `Surrogate.predict`.
        """
        row = self._row(design, extrapolate)
        body, middles = self.impactor(row), self._middles
        bag = self._bag(row) if bag is None else bag

        def force(step, centre, velocity):
            state = self._state(bag[step], body, centre, velocity)
            if not state[: 3 * len(REACHES)].any():  # fabric out of reach cannot push
                return np.zeros(3)
            return self.law(row, middles[step], state)

        return self._move(body, body.centre if pushed is None else body.centre + pushed, force)

    def replay(self, design, force: np.ndarray) -> ImpactorMotion:
        """Motion of the impactor under a contact force that is known: what `deploy` would answer with a perfect law.

        force: [N], (times - 1, 3), mean over each interval of `times`; it is held over the same steps as in `deploy`
        Arguments and errors otherwise as `deploy`.
        """
        body, held = self.impactor(self._row(design, extrapolate=False)), self._held(force)
        return self._move(body, body.centre, lambda step, centre, velocity: held[step])

    @property
    def step_times(self) -> np.ndarray:
        """Times from which a force is held, within the surrogate's trained ones: [s], (steps,)."""
        trained = self.surrogate.times
        return np.clip(self.times[self._starts], trained[0], trained[-1])

    def _row(self, design, extrapolate):
        rows, _ = design_rows(design, self.surrogate.parameters)
        if not extrapolate:
            check_design(rows, self.surrogate.parameters)
        return rows[0]

    def _move(self, body: Impactor, start, force_of) -> ImpactorMotion:
        """Motion from `start` [m], (3,), under force_of(step, centre, velocity) -> [N], (3,), held over each step."""
        centre, velocity = np.empty((2, len(self.times), 3))
        centre[0], velocity[0] = start, body.velocity
        for step, k in enumerate(self._starts):
            held = slice(k + 1, k + EVERY + 1)
            after = (self.times[held] - self.times[k])[:, None]
            acceleration = self.gravity + force_of(step, centre[k], velocity[k]) / body.mass
            centre[held] = centre[k] + after * (velocity[k] + 0.5 * after * acceleration)
            velocity[held] = velocity[k] + after * acceleration
        return ImpactorMotion(self.times, centre, velocity)

    @cached_property
    def _area(self):
        return node_area(self.surrogate.reference, self.surrogate.triangles)

    @property
    def _starts(self):
        """Index of each time from which a force is held."""
        return np.arange(0, len(self.times) - 1, EVERY)

    @property
    def _middles(self):
        """Middle of each step: [s], (steps,)."""
        return self.times[self._starts] + 0.5 * self._intervals * (self.times[1] - self.times[0])

    @property
    def _intervals(self):
        """Intervals of the histories in each step: (steps,)."""
        return np.diff([*self._starts, len(self.times) - 1])

    def _held(self, force):
        """Mean over each step: (times - 1, 3) -> (steps, 3)."""
        return np.add.reduceat(force, self._starts) / self._intervals[:, None]

    def _bag(self, row):
        """Nodes at `step_times`: [m], (steps, nodes, 3)."""
        return self.surrogate.reference + self.surrogate.predict(row, self.step_times, extrapolate=True)

    def _state(self, nodes, body: Impactor, centre, velocity):
        """What the law sees: area vectors [m^2] and velocity [m/s], (3 * reaches + 3,)."""
        return np.concatenate([area_vectors(nodes, self._area, body, centre).ravel(), velocity])


def _require_alike(surrogate: Surrogate, motions: list[ImpactorMotion]) -> None:
    runs, first = surrogate.runs, motions[0]
    other = [run for run, m in zip(runs, motions, strict=True) if not same_times(m.times, first.times)]
    if surrogate.forces is not None:
        where, why = "surrogate", "it needs the contact forces of the previous time, which are not known in advance"
    elif other:
        where, why = f"run {other[0]}", f"its histories have other times than those of run {runs[0]}"
    else:
        sample_interval(first.times, first.velocity)
        return
    raise CANNOT_COUPLE(where=where, why=why)
