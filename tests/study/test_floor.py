"""The floor of a study: runs made again with a change, and what they differ by."""

import fake_solver
import numpy as np
import pytest

from billow.base.errors import InputError, IntegrityError
from billow.case.schema import Case
from billow.results.dataset import Dataset
from billow.study import floor
from billow.study.floor import measure_floor


@pytest.fixture
def made(study):
    study.run(workers=1, runner=fake_solver.simulate)
    return study


def measured(study, **more):
    return measure_floor(study.folder, 2, {"square.lift": 1.5}, threads=1, runner=fake_solver.simulate, **more)


def test_it_is_the_difference_over_the_root_of_two(made):
    found = measured(made)
    lifts = np.array([made.runs[run][0] for run in found.runs])
    expected = np.abs(1.5 - lifts)[:, None] * fake_solver.TIMES[1:] / np.sqrt(2.0)
    assert found.runs == Dataset.open(made.folder).test
    assert found.rmse[:, :, 2] == pytest.approx(expected, rel=1e-6)
    assert not found.rmse[:, :, :2].any()
    assert found.distance == pytest.approx(np.sqrt(np.square(expected).mean(axis=1)).mean(), rel=1e-6)
    kept = Dataset.open(made.folder).floor
    assert np.array_equal(kept.rmse, found.rmse)
    assert kept.changes == {"square.lift": "1.5"}
    table = (made.folder / "floor.csv").read_text().splitlines()
    assert float(table[1].split(",")[3]) == pytest.approx(expected[:, 0].mean(), rel=1e-6)


def test_runs_that_are_there_are_not_made_again(made):
    first = measured(made)
    again = measure_floor(made.folder, 2, {"square.lift": 1.5}, runner=lambda *arguments, **more: 1 / 0)
    assert np.array_equal(first.rmse, again.rmse)


def test_a_change_that_changes_nothing_is_refused(made):
    run = Dataset.open(made.folder).test[0]
    with pytest.raises(InputError) as caught:
        measure_floor(made.folder, 1, {"square.lift": made.runs[run][0]}, threads=1, runner=fake_solver.simulate)
    assert caught.value.code == "E-STU-170"


@pytest.mark.parametrize(("size", "refused"), [(1.0 + 1e-8, False), (1.001, True)])
def test_a_change_of_the_start_shape_is_measured_if_it_is_next_to_none(made, size, refused):
    if refused:
        with pytest.raises(InputError, match="another mesh") as caught:
            measure_floor(made.folder, 1, {"square.size": size}, threads=1, runner=fake_solver.simulate)
        assert caught.value.code == "E-STU-170"
    else:
        found = measure_floor(made.folder, 1, {"square.size": size}, threads=1, runner=fake_solver.simulate)
        assert found.rmse.max() < 1e-7


def test_a_floor_of_other_times_is_refused(made):
    found = measured(made)
    assert Dataset.open(made.folder).floor is not None
    floor.Floor(found.changes, found.runs, found.times * 2.0, found.rmse).write(made.folder)
    with pytest.raises(IntegrityError) as caught:
        _ = Dataset.open(made.folder).floor
    assert caught.value.code == "E-RES-170"


def test_usual_changes_are_a_shorter_step_and_of_particles_another_seed():
    case = Case.from_dict({})
    assert floor._usual(case) == {"run.dt_scale": 0.99}
    particles = case.vary({"gas": {"model": "corpuscular", "seed": 3}})
    assert floor._usual(particles) == {"run.dt_scale": 0.99, "gas.seed": 4}
