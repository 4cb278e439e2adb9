"""Whatever has columns has a name of its own: two that would share one are refused before a run."""

from __future__ import annotations

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.case.build import build_model
from billow.case.schema import Case
from billow.injury.criteria import assess_run
from billow.run.check import describe
from billow.run.names import owners
from billow.run.recorder import quantities
from billow.run.simulate import simulate
from billow.solver.run import Schedule, begin

COARSE = {"diameter": 0.6, "element_size": 0.06, "initial_gap": 0.02}
HEAD = {"shape": "super-ellipsoid", "name": "head", "clearance": 0.3, "locked": False}
ORIFICE = {"between": ["bag", "ambient"], "area": 1e-4}
PARTICLES = {"model": "corpuscular", "particles": 1000}


def sensor(name: str) -> dict:
    return {"sensors": [{"name": name, "position": [0.0, 0.0, 0.01]}], "end_time": 5e-5, "frames": 1}


def case(**tables) -> Case:
    return Case.from_dict({"bag": COARSE, "obstacles": [{"shape": "plate"}, HEAD]} | tables)


@pytest.mark.parametrize(
    ("tables", "said"),
    [
        ({"gas": {"orifices": [{"name": "vent_1", **ORIFICE}]}}, ["vent vent_1", "orifice vent_1"]),
        ({"gas": {"orifices": [{"name": "Vent_1", **ORIFICE}]}}, ["vent vent_1", "orifice Vent_1"]),
        ({"gas": PARTICLES, "run": sensor("head")}, ["free obstacle head", "sensor head"]),
        ({"gas": PARTICLES, "run": sensor("front")}, ["fabric part front", "sensor front"]),
        ({"obstacles": [HEAD | {"name": "strap_2"}]}, ["strap strap_2", "free obstacle strap_2"]),
        ({"obstacles": [HEAD, HEAD | {"name": "Head"}]}, ["obstacle head", "obstacle Head"]),
        ({"obstacles": [HEAD | {"name": "self"}], "fabric": {"self_contact": True}}, ["self_contact", "obstacle self"]),
        (
            {"gas": PARTICLES, "run": sensor("a"), "obstacles": [HEAD | {"name": "a_gas"}]},
            ["sensor a", "a_gas_velocity"],
        ),
    ],
)
def test_what_would_share_a_name_or_a_column_is_refused(tables, said, tmp_path):
    for use in (describe, lambda odd: simulate(odd, tmp_path / "run")):
        with pytest.raises(InputError) as caught:
            use(case(**tables))
        assert caught.value.code == "E-CASE-007"
        assert all(words in str(caught.value) for words in said), str(caught.value)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("model", ["uniform-pressure", "corpuscular", "none"])
def test_every_column_has_an_owner(model):
    """A column of a run belongs to what the names were checked for."""
    two = {
        "shape": "rectangular", "length": 0.5, "width": 0.3, "chambers": 2, "element_size": 0.05, "mouth_radius": 0.045,
        "vents": {"chambers": [2], "diameter": 0.03}, "initial_gap": 0.02,
        "straps": [{"front": [0.1, 0.0], "rear": [0.1, 0.0]}],
    }  # fmt: skip
    gas = {"model": model, "particles": 1000}
    if model == "uniform-pressure":
        gas["orifices"] = [{"name": "hole", "between": ["chamber_1", "ambient"], "area": 1e-4}]
    built = build_model(case(bag=two, gas=gas, fabric={"permeability": 0.03}))
    sensors = {"middle": (0.0, 0.0, 0.01)}
    known = {(one.name, quantity) for one in owners(built, sensors) for quantity in one.quantities}
    state = begin(built, Schedule(1e-4, 1, 1))
    written = {(quantity.of, quantity.name) for quantity in quantities(built, state, sensors)}
    assert written <= known
    assert {name for name, _ in written} == {name for name, _ in known}


def test_a_sensor_of_the_gas_is_no_body(tmp_path):
    """The velocity of a gas jet was taken for that of a head, and had a HIC15 of 82,286,141."""
    run = {"end_time": 1e-4, "frames": 1, "histories_per_frame": 2, "sensors": sensor("jet")["sensors"]}
    result = simulate(case(obstacles=[{"shape": "plate"}], gas=PARTICLES, run=run), tmp_path / "run")
    assert "jet_gas_velocity_x [m/s]" in result.histories
    assert result.free_obstacles == ()
    with pytest.raises(InputError, match="E-INJ-005"):
        assess_run(result)
    for name in ("jet", "jet_gas"):
        with pytest.raises(KeyError):
            result.body(name)
        with pytest.raises(KeyError):
            result.chamber(name)
    assert np.shape(result.body("plate").force) == (3, 3)
