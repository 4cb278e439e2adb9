"""The surrogate coupled to its own impactor: nothing about the deployment is known in advance (docs/coupled.md, The
coupled model).

The bag is a `Surrogate`, the force a `ContactLaw`. It is held for `EVERY` intervals of the histories, and the body's
centre then moves on a parabola, whose points at the histories' times are the answer.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property, partial
from pathlib import Path

import numpy as np

from billow.base.errors import InputError
from billow.injury.filters import sample_interval
from billow.results.dataset_files import same_times
from billow.results.tensor_file import write_tensors
from billow.rom.coupled.impactor import (
    EVERY,
    PROPERTIES,
    REACHES,
    ContactLaw,
    Impactor,
    ImpactorMotion,
    ImpactorOfDesign,
    area_vectors,
    filtered_force,
    learn_contact_law,
    node_area,
)
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Progress
from billow.rom.surrogate import surrogate_file as stored
from billow.rom.surrogate.design_space import check_design, design_rows
from billow.rom.surrogate.regression import OutputScaling, Regression
from billow.rom.surrogate.surrogate import Surrogate

CANNOT_COUPLE = InputError.declare(
    "E-CPL-005",
    "a coupled model cannot be learned",
    cause="the surrogate was trained with force_modes, or histories of the runs have different times",
    remedy="train the surrogate without force_modes, on runs with the same run.histories_per_frame",
)
NOT_COUPLED = InputError.declare(
    "E-CPL-006",
    "the file holds no coupled model",
    where="{path}",
    cause="the file is a surrogate of the bag alone",
    remedy="make one: billow couple train FOLDER",
)

FORMAT = 1
STATE = 3 * len(REACHES) + 3
"""Numbers that the law sees besides design and time."""


@dataclass(frozen=True, eq=False, repr=False)
class Coupled:
    """A surrogate of the bag, a free body and the force between them.

        coupled = Coupled.train(dataset, surrogate)
        motion = coupled.deploy({"permeability": 0.03, ...})
        motion.velocity[-1]          # [m/s]

    times: [s], (steps + 1,) float64, evenly spaced from 0; gravity: [m/s^2], (3,)
    """

    surrogate: Surrogate
    impactor: ImpactorOfDesign
    law: ContactLaw
    times: np.ndarray
    gravity: np.ndarray

    @classmethod
    def train(cls, dataset: Dataset, surrogate: Surrogate, seed: int = 0, progress: Progress | None = None) -> Coupled:
        """Learn the contact force of the runs that `surrogate` was learned from. Test runs are never read.

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
        """Write a surrogate file with one more block, without pickle, atomically: `Surrogate.load` reads the bag."""
        tensors, record = stored.surrogate_content(self.surrogate)
        law, outputs = self.law, self.law.regression.outputs
        block = {
            "times": self.times,
            "gravity": self.gravity,
            "affine": self.impactor.affine,
            "state_mean": law.mean,
            "state_deviation": law.deviation,
            "force_mean": outputs.mean,
            "force_deviation": outputs.deviation,
            **stored.network_content(law.regression),
        }
        tensors |= {f"coupled.{name}": array for name, array in block.items()}
        return write_tensors(path, tensors, record | {"coupled": {"format": FORMAT, "name": self.impactor.name}})

    @classmethod
    def load(cls, path: str | Path) -> Coupled:
        """Read a file written by `save`. Raises InputError E-CPL-006 if the file holds a surrogate alone or a block of
        another format, and the errors of `surrogate_file.read_checked`."""
        return stored.read_checked(path, partial(cls._read, path), "billow couple train FOLDER")

    @classmethod
    def _read(cls, path, tensors, record) -> Coupled:
        surrogate, block = Surrogate(**stored.surrogate_fields(tensors, record)), record.get("coupled")
        if not isinstance(block, dict) or block.get("format") != FORMAT:
            why = "it is a surrogate of the bag alone" if block is None else "its coupled part has another format"
            raise NOT_COUPLED(path=path, why=why)
        if not isinstance(block.get("name"), str):
            raise ValueError("the obstacle has no name")
        times = stored.times_of(tensors, "coupled.times")
        affine = stored.take(tensors, "coupled.affine", np.float64, len(PROPERTIES), 1 + len(surrogate.parameters))
        mean, deviation = (stored.take(tensors, f"coupled.state_{n}", np.float64, STATE) for n in ("mean", "deviation"))
        if not (deviation > 0.0).all():
            raise ValueError("a state has no deviation")
        inputs = replace(surrogate.regression.inputs, recipe="shared", further=STATE)
        weights, biases, width = stored.take_networks(tensors, "coupled.", None, inputs.width)
        if width != 3:
            raise ValueError(f"the force has {width} components")
        force = (stored.take(tensors, f"coupled.force_{name}", np.float32, 2, 3) for name in ("mean", "deviation"))
        outputs = OutputScaling(np.array([inputs.start, inputs.end]), *force)
        law = ContactLaw(Regression("shared", weights, biases, inputs, outputs), mean, deviation)
        gravity = stored.take(tensors, "coupled.gravity", np.float64, 3)
        return cls(surrogate, ImpactorOfDesign(block["name"], affine), law, times, gravity)

    def deploy(
        self, design, *, extrapolate: bool = False, pushed: np.ndarray | None = None, bag: np.ndarray | None = None
    ) -> ImpactorMotion:
        """Motion of the impactor in one deployment.

        design: {name: value} or (parameters,); pushed: [m], (3,), how far the body starts from where the design puts it
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
        """What `deploy` would answer with a perfect law: motion under a contact force that is known, held over the same
        steps. force: [N], (times - 1, 3), mean over each interval of `times`; errors as `deploy`."""
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
    if surrogate.forces is not None:
        why = "it needs the contact forces of the previous time, which are not known in advance"
        raise CANNOT_COUPLE(where="surrogate", why=why)
    for run, motion in zip(runs, motions, strict=True):
        if not same_times(motion.times, first.times):
            raise CANNOT_COUPLE(where=f"run {run}", why=f"its histories have other times than those of run {runs[0]}")
    sample_interval(first.times, first.velocity)
