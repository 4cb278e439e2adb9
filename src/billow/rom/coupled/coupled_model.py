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

from billow.base.blas_threads import one_blas_thread
from billow.base.errors import InputError
from billow.injury.criteria import assess
from billow.injury.filters import sample_interval
from billow.results.dataset_files import same_times
from billow.results.tensor_file import write_tensors
from billow.rom.coupled.calibration import Calibration
from billow.rom.coupled.calibration import calibrate as find_errors
from billow.rom.coupled.calibration_file import calibration_content, calibration_of
from billow.rom.coupled.coupled_answer import CoupledAnswer
from billow.rom.coupled.impactor import (
    EVERY,
    LEAST_DEVIATION,
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
from billow.rom.coupled.injury_metrics import FEWEST, METRICS, MOTION, Estimate, metric_values, not_usable
from billow.rom.learn.dataset import Dataset
from billow.rom.learn.progress import Progress, stages
from billow.rom.learn.train import Recipe, check_recipe, held_out, import_network, of_one_design, same_training, train
from billow.rom.surrogate import surrogate_file as stored
from billow.rom.surrogate.design_space import check_design, design_rows
from billow.rom.surrogate.judgement import Judgement, judgement_of, require_won
from billow.rom.surrogate.regression import NOT_FINITE, OutputScaling, Regression
from billow.rom.surrogate.surrogate import Surrogate

CANNOT_COUPLE = InputError.declare(
    "E-CPL-005",
    "a coupled model cannot be learned",
    cause="the surrogate was trained with force_modes, or histories of the runs have different times",
    remedy="train the surrogate without force_modes, on runs with the same run.histories_per_frame",
)
NOT_JUDGED = InputError.declare(
    "E-CPL-007",
    "nobody has measured how far this coupled model's answers may be off",
    where="{model}",
    cause=f"fewer than {FEWEST} training runs of different designs, or a file from before coupled models had intervals",
    remedy="learn it again from more runs, billow couple train FOLDER, or insist: --despite-verdict, in Python "
    "model.despite_verdict()",
)
NOT_COUPLED = InputError.declare(
    "E-CPL-006",
    "the file holds no coupled model",
    where="{path}",
    cause="the file is a surrogate of the bag alone",
    remedy="make one: billow couple train FOLDER",
)

FORMAT = 1
MOST_TIMES = 100_000
"""Of a motion: ten seconds at 10 kHz. One answer takes about 0.1 ms for each."""
FARTHEST_MOTION = 1e6
"""[m] and [m/s]: no body near a bag is farther or faster."""
STATE = 3 * len(REACHES) + 3
"""Numbers that the law sees besides design and time."""


@dataclass(frozen=True, eq=False, repr=False)
class Coupled:
    """A surrogate of the bag, a free body and the force between them.

        coupled = Coupled.train(dataset, surrogate)
        motion = coupled.deploy({"permeability": 0.03, ...})
        motion.velocity[-1]          # [m/s]

    times: [s], (steps + 1,) float64, evenly spaced from 0; gravity: [m/s^2], (3,)
    calibration: how far answers may be off; judgement: how the motion did on runs that were not learned from. Without
        either, or if the motion lost, the model does not answer until `despite_verdict` is called.
    insisted: True after `despite_verdict`; not saved
    """

    surrogate: Surrogate
    impactor: ImpactorOfDesign
    law: ContactLaw
    times: np.ndarray
    gravity: np.ndarray
    calibration: Calibration | None = None
    judgement: Judgement | None = None
    insisted: bool = False

    @classmethod
    def train(
        cls,
        dataset: Dataset,
        surrogate: Surrogate,
        seed: int = 0,
        progress: Progress | None = None,
        *,
        calibrate: bool = True,
    ) -> Coupled:
        """Learn the contact force of the runs that `surrogate` was learned from. Test runs are never read.

        calibrate: learn bag and force up to four more times, each time without a quarter of the runs, for intervals and
            judgement, as `Recipe`. Not done with fewer than `FEWEST` designs, or for the recipe `paper`

        Raises InputError E-CPL-003 and E-CPL-004 (no free obstacle, or one that the design does not determine),
        E-CPL-005 (the surrogate needs forces itself, or histories of runs differ in their times), E-ROM-026 (seed),
        E-INJ-003 (histories too coarse for injury metrics, if calibrated), ResourceError E-ROM-006 (no PyTorch),
        NumericalStop E-ROM-014 (training failed).
        """
        import_network()
        check_recipe(Recipe(seed=seed))
        runs = surrogate.runs
        impactor = ImpactorOfDesign.learn(dataset, runs)
        motions = [ImpactorMotion.of_run(dataset.result(run), impactor.name) for run in runs]
        _require_alike(surrogate, motions)
        gravity = np.array(dataset.result(runs[0]).case_toml["run"]["gravity"], float)
        designs = np.asarray(dataset.design(runs), float)
        groups = of_one_design(dataset, runs)
        folds = held_out(groups) if calibrate and surrogate.recipe == "shared" and len(groups) >= FEWEST else []
        progresses = stages(progress, 1 + 2 * len(folds))

        def learn(bag: Surrogate) -> Coupled:
            rows = [runs.index(run) for run in bag.runs]
            unfinished = cls(bag, impactor, None, motions[0].times, gravity)
            return unfinished._with_law(designs[rows], [motions[row] for row in rows], seed, next(progresses))

        def learn_without(fold):
            others = tuple(run for run in runs if run not in fold)
            recipe = Recipe(modes=surrogate.modes, calibrate=False, **same_training(surrogate))
            part = learn(train(dataset, recipe, runs=others, progress=next(progresses)))
            return partial(part.despite_verdict().deploy, extrapolate=True)

        whole = learn(surrogate)
        if not folds:
            return whole
        found = find_errors(runs, designs, surrogate.parameters, motions, folds, learn_without)
        return replace(whole, calibration=found[0], judgement=found[1])

    def _with_law(self, designs, motions: list[ImpactorMotion], seed: int, progress) -> Coupled:
        """The same with a law learned from runs. designs: (runs, parameters); motions: of the solver."""
        starts, state, force = self._starts, [], []
        for row, motion in zip(designs, motions, strict=True):
            body, bag = self.impactor(row), self._bag(row)
            moved = zip(bag, motion.centre[starts], motion.velocity[starts], strict=True)
            state.append([self._state(nodes, body, *place) for nodes, *place in moved])
            force.append(self._held(filtered_force(motion, body.mass, self.gravity)))
        at, inputs = self._middles, self.surrogate.inputs_by_own_time
        law = learn_contact_law(inputs, designs, at, np.array(state), np.array(force), seed, progress)
        return replace(self, law=law)

    def despite_verdict(self) -> Coupled:
        """The same, which answers even if nobody judged it, or a simpler answer is better."""
        return replace(self, insisted=True)

    @one_blas_thread()
    def answer(self, design, *, extrapolate: bool = False) -> CoupledAnswer:
        """Motion and injury metrics of one deployment, with their intervals, where the design stands, and the verdicts.
        Arguments and errors as `deploy`."""
        row, found = self._row(design, extrapolate), self.calibration
        motion = self.deploy(row, extrapolate=True)
        values = metric_values(assess(motion.times, motion.velocity))
        if found is None:
            injury = {n: Estimate(float(v), None, None, MOTION, False) for n, v in zip(METRICS, values, strict=True)}
        else:
            lost = not_usable(found.of_injury)
            injury = found.injury(row, values, self.surrogate.parameters, lost)
        return CoupledAnswer(
            name=self.impactor.name,
            motion=motion,
            half_widths=None if found is None else found.half_widths,
            injury=injury,
            standing=self.surrogate.standing(row),
            judgement=self.judgement,
            of_injury=None if found is None else found.of_injury,
        )

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
        told = {"format": FORMAT, "name": self.impactor.name, "judgement": self.judgement and self.judgement.record()}
        if self.calibration is not None:
            block |= calibration_content(self.calibration)
            told["of_injury"] = self.calibration.of_injury.record()
        tensors |= {f"coupled.{name}": array for name, array in block.items()}
        return write_tensors(path, tensors, record | {"coupled": told})

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
        if len(times) > MOST_TIMES or not same_times(np.diff(times), np.full(len(times) - 1, times[1] - times[0])):
            raise ValueError(f"the times of its motion are not even, or more than {MOST_TIMES:,}")
        stored.require_affordable(len(times) * surrogate.reference.size)
        affine = stored.take(tensors, "coupled.affine", np.float64, len(PROPERTIES), 1 + len(surrogate.parameters))
        mean, deviation = (stored.take(tensors, f"coupled.state_{n}", np.float64, STATE) for n in ("mean", "deviation"))
        if not (deviation >= LEAST_DEVIATION).all():
            raise ValueError("a state has no deviation")
        inputs = replace(surrogate.inputs_by_own_time, recipe="shared", further=STATE)
        weights, biases, width = stored.take_networks(tensors, "coupled.", None, inputs.width)
        if width != 3:
            raise ValueError(f"the force has {width} components")
        force = (stored.take(tensors, f"coupled.force_{name}", np.float32, 2, 3) for name in ("mean", "deviation"))
        outputs = OutputScaling(np.array([inputs.start, inputs.end]), *force)
        law = ContactLaw(Regression("shared", weights, biases, inputs, outputs), mean, deviation)
        gravity = stored.take(tensors, "coupled.gravity", np.float64, 3)
        calibration = calibration_of(tensors, block.get("of_injury"), len(times), len(surrogate.parameters))
        judgement = judgement_of(block.get("judgement"))
        return cls(surrogate, ImpactorOfDesign(block["name"], affine), law, times, gravity, calibration, judgement)

    def deploy(
        self, design, *, extrapolate: bool = False, pushed: np.ndarray | None = None, bag: np.ndarray | None = None
    ) -> ImpactorMotion:
        """Motion of the impactor in one deployment.

        design: {name: value} or (parameters,); pushed: [m], (3,), how far the body starts from where the design puts it
        bag: [m], (steps, nodes, 3), where the fabric is at `step_times`, default what the surrogate predicts
        Raises InputError E-ROM-001 and E-ROM-002, as `Surrogate.predict`, E-CPL-007 if nobody judged the model,
        E-ROM-023 if the mean motion of the training runs is better; `despite_verdict` lifts these two. E-CPL-008 if the
        design has no possible body, NumericalStop E-ROM-024 if the motion leaves all bounds.
        """
        self.require_judged()
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

    def require_judged(self) -> None:
        """InputError E-CPL-007 and E-ROM-023, as `deploy`, unless `despite_verdict` was called."""
        if self.insisted:
            return
        if self.judgement is None or self.calibration is None:
            raise NOT_JUDGED(model=repr(self), why="it holds no errors on runs it has not seen, and so no intervals")
        require_won(self.judgement, self)

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
            if not max(np.abs(centre[held]).max(), np.abs(velocity[held]).max()) < FARTHEST_MOTION:
                raise NOT_FINITE(where=f"the motion at {self.times[k]:.4g} s", why="the body is no longer near the bag")
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
        bag = self.surrogate.despite_verdict()  # what counts is the verdict on the motion
        return self.surrogate.reference + bag.predict(row, self.step_times, extrapolate=True)

    def _state(self, nodes, body: Impactor, centre, velocity):
        """What the law sees: area vectors [m^2] and velocity [m/s], (3 * reaches + 3,)."""
        return np.concatenate([area_vectors(nodes, self._area, body, centre).ravel(), velocity])


def load_if_coupled(path: str | Path) -> Coupled | None:
    """The coupled model of a file, None if it holds a surrogate of the bag alone. Errors as `Coupled.load`."""
    try:
        return Coupled.load(path)
    except InputError as error:
        if error.code != NOT_COUPLED.code:
            raise
        return None


def _require_alike(surrogate: Surrogate, motions: list[ImpactorMotion]) -> None:
    runs, first = surrogate.runs, motions[0]
    if surrogate.forces is not None:
        why = "it needs the contact forces of the previous time, which are not known in advance"
        raise CANNOT_COUPLE(where="surrogate", why=why)
    if surrogate.starts is not None:
        why, remedy = "its bags have sizes of their own, the law of contact knows one mesh", "vary no size of the bag"
        raise CANNOT_COUPLE(where="surrogate", why=why, remedy=remedy)
    for run, motion in zip(runs, motions, strict=True):
        if not same_times(motion.times, first.times):
            raise CANNOT_COUPLE(where=f"run {run}", why=f"its histories have other times than those of run {runs[0]}")
    sample_interval(first.times, first.velocity)
