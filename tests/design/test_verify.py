"""What the solver says of an optimum and of a scatter, with made-up runs in its place."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.design import verify
from billow.design.optimum import Goal, optimise
from billow.design.surfaces import ResponseSurfaces
from billow.design.verify import Round, scatter_runs
from trust.small_surfaces import small_surfaces, small_table, truth

POINT, SCATTER = {"vent": 35.0, "speed": 5.0, "gas": 0.0}, {"vent": 1.0, "speed": 0.2}


@pytest.fixture
def solver(monkeypatch):
    """A study whose added runs are 40 higher in hardness than what the surfaces learned from."""
    table, added = small_table(), []

    def with_run(values):
        added.append(tuple(values))
        return study, f"new{len(added) - 1}"

    def train(folder, responses):
        rows = truth(np.array(added)) + np.array([40.0, 0.0, 0.0, 0.0])
        known = len(table.runs) - table.unseen
        return ResponseSurfaces.learn(
            replace(table, designs=np.vstack([table.designs[:known], added]), unseen=0,
                    values=np.vstack([table.values[:known], rows]),
                    runs=(*table.runs[:known], *(f"new{k}" for k in range(len(added)) if k not in study.lost)))
            if not study.lost else replace(table, runs=table.runs)
        )  # fmt: skip

    study = SimpleNamespace(with_run=with_run, run=lambda **more: None, lost=())
    study.definition = SimpleNamespace(variables=[SimpleNamespace(stepped=float)] * 3)
    monkeypatch.setattr(verify, "Study", SimpleNamespace(open=lambda folder: study))
    monkeypatch.setattr(verify.ResponseSurfaces, "train", train)
    return study


def test_runs_of_the_scatter_show_by_how_much_a_surface_is_off_and_mend_it(solver):
    surfaces = small_surfaces()
    before = surfaces.predict("hard", POINT)
    shifts, again = scatter_runs(surfaces, POINT, SCATTER, "study", 12, seed=0)
    hard, pressure = shifts
    assert (hard.response, pressure.response) == ("hard", "pressure")
    assert hard.mean == pytest.approx(40.0, abs=2.0)
    assert abs(pressure.mean) < 0.2
    assert hard.error < 1.0
    assert again.predict("hard", POINT) == pytest.approx(before + 40.0, abs=5.0)
    assert len(again.runs) == len(surfaces.runs) + 12
    chances = [(model, model.exceed("hard", 225.0, POINT, SCATTER)) for model in (surfaces, again)]
    assert [chance.resolved for _, chance in chances] == [False, True]
    assert chances[1][1].near - chances[0][1].near in (11, 12)
    assert not again.exceed("hard", 225.0, POINT | {"gas": 1.0}, SCATTER).resolved


def test_without_sound_runs_nothing_is_said(solver):
    solver.lost = range(12)
    with pytest.raises(InputError) as caught:
        scatter_runs(small_surfaces(), POINT, SCATTER, "study", 12)
    assert caught.value.code == "E-DES-033"


def test_what_lies_outside_its_interval_is_named():
    optimum = optimise(small_surfaces(), Goal(minimise="hard"))
    computed = {name: value for name, (value, _, _) in optimum.responses.items()}
    assert Round(optimum, "0", computed).outside == []
    off = Round(optimum, "0", computed | {"pressure": computed["pressure"] + 100.0})
    assert off.outside == ["pressure"]
    assert off.holds  # the goal is inside, and pressure has no limit
    assert "outside their intervals, too: pressure" in verify._line(1, off, small_surfaces())
