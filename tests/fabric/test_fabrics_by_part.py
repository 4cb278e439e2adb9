"""Several fabrics in one bag: each part has its own mass, law, leak and history, and one fabric is as it was."""

from __future__ import annotations

import numpy as np
import pytest
from run_fingerprint import fingerprint

from billow.base.errors import InputError
from billow.case.assumptions import assumptions
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model, build_schedule
from billow.case.concerns import concerns_of
from billow.case.schema import Case
from billow.geometry.flat_cut import flat_area
from billow.run.simulate import simulate
from billow.solver.model import start_state
from billow.solver.run import Recorder, run

BAG = {"element_size": 0.06, "straps": {"count": 0}, "seam": {"layers": 1.0}, "vents": {"count": 0}}
CURVED = {"law": "curves-shear", "density": 900.0, "thickness": 0.4e-3}
STIFF = {"young_warp": 0.8e9, "young_weft": 0.6e9, "density": 700.0, "thickness": 0.25e-3, "compression": True}
RUN = {"end_time": 0.006, "frames": 2, "histories_per_frame": 4}


def case_of(parts: dict, **fabric) -> Case:
    return Case.from_dict({"bag": BAG, "fabric": {**fabric, "parts": parts}, "run": RUN})


def test_masses_are_those_of_the_parts():
    model = build_model(case_of({"rear": CURVED, "front": STIFF}))
    rear, front = model.fabric.membranes  # in the order of the case
    shape = build_shape(case_of({}).bag)
    flat = {name: flat_area(shape.reference)[shape.surface.triangles_of(name)].sum() for name in ("rear", "front")}
    expected = flat["rear"] * 900.0 * 0.4e-3 + flat["front"] * 700.0 * 0.25e-3
    assert model.mass.sum() == pytest.approx(expected, rel=1e-12)
    surface = model.surface
    for membrane, name in ((rear, "rear"), (front, "front")):
        assert np.array_equal(np.sort(membrane.elements), np.sort(surface.triangles_of(name)))


def test_the_stretched_bag_holds_the_energy_of_its_parts():
    """Linear fabric that carries compression: energy of a sphere's worth of small stretch is quadratic in the moduli,
    so that twice the moduli of one part add that part's energy once more."""
    soft = {"compression": True, "young_warp": 0.4e9, "young_weft": 0.3e9, "shear": 10e6}
    hard = {"compression": True, "young_warp": 0.8e9, "young_weft": 0.6e9, "shear": 20e6}
    energy = {}
    for name, parts in (("none", {}), ("front", {"front": hard}), ("both", {"front": hard, "rear": hard})):
        model = build_model(case_of(parts, **soft))
        stretched, still = 1.01 * model.start, np.zeros_like(model.start)
        energy[name] = sum(
            m.by_itself(model.surface.triangles, stretched, still, h)[1][:, 0].sum()
            for m, h in zip(model.fabric.membranes, start_state(model).fabric.history, strict=True)
        )
    assert energy["both"] == pytest.approx(2.0 * energy["none"], rel=1e-12)
    assert energy["none"] < energy["front"] < energy["both"]


def test_the_same_fabric_in_parts_moves_as_one():
    """Only the order of sums differs: after a few hundred steps by rounding alone."""
    whole, parted = (build_model(case_of(parts)) for parts in ({}, {"front": {}}))
    assert np.array_equal(whole.mass, parted.mass)
    schedule = build_schedule(case_of({}).run)
    first, second = run(whole, schedule, Recorder()), run(parted, schedule, Recorder())
    assert np.abs(first.positions - second.positions).max() < 1e-9
    assert second.ledger.relative_error == pytest.approx(first.ledger.relative_error, rel=1e-3)


@pytest.mark.parametrize("parts", [{"front": CURVED}, {"front": STIFF, "rear": CURVED}])
def test_energy_closes_with_several_laws(parts):
    case = case_of(parts)
    coarse, fine = (
        run(build_model(case), build_schedule(case.vary({"run.dt_scale": scale}).run), Recorder()).ledger
        for scale in (1.0, 0.5)
    )
    assert coarse.relative_error < 5e-3
    assert fine.relative_error < max(0.6 * coarse.relative_error, 1e-4)
    assert coarse["hysteresis"] > 0.0


def test_a_run_that_stopped_goes_on_with_the_history_of_each_fabric(in_two, tmp_path):
    case = case_of({"front": CURVED, "rear": {**CURVED, "density": 800.0}})
    straight = simulate(case, tmp_path / "straight", threads=1)
    assert fingerprint(in_two(case, tmp_path / "resumed").folder) == fingerprint(straight.folder)


def test_each_part_leaks_as_its_fabric_does():
    passages = build_model(case_of({"front": {"permeability": 0.3}}, permeability=0.1)).gas.supply.passages.rows
    assert {p.name: p.coefficient for p in passages} == {"front": 0.3, "rear": 0.1}


def test_a_study_varies_a_part_and_what_is_typical_is_named_by_part():
    case = case_of({"front": STIFF}).vary({"fabric.parts.front.thickness": "0.5 mm"})
    assert case.fabric.of("front").thickness == 0.5e-3
    assert case.fabric.of("rear") is case.fabric
    assert Case.from_dict(case.to_dict()) == case
    assert any(line.startswith("fabric.parts.front: poisson") for line in assumptions(case))


def test_concerns_name_the_part():
    case = case_of({"front": {"thickness": 4e-3}})
    (weight,) = [c for c in concerns_of(case, build_model(case)) if c.code == "W-FAB-002"]
    assert weight.where.endswith("part front")


def test_curves_of_parts_come_from_files(tmp_path):
    (tmp_path / "warp.csv").write_text("strain [-], stress [Pa]\n0, 0\n0.1, 2e7\n")
    (tmp_path / "case.toml").write_text(
        '[fabric.parts.front]\nlaw = "curves-shear"\nlibrary = "nylon66-470dtex"\n'
        '[fabric.parts.front.curves.warp]\nloading = "warp.csv"\n'
    )
    case = Case.load(tmp_path / "case.toml")
    assert case.fabric.parts["front"].curves.warp.loading.stress == (0.0, 2e7)


def test_curves_that_cannot_be_are_named_with_their_part():
    falling = {"loading": {"strain": [0.0, 0.1, 0.2], "stress": [0.0, 2e7, 1e7]}}
    parts = {"front": {"library": "nylon66-470dtex", "curves": {"warp": falling}}}
    with pytest.raises(InputError, match="E-FAB-004") as caught:
        build_model(case_of(parts))
    assert caught.value.where.startswith("fabric.parts.front.curves.warp")
