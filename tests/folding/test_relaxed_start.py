"""A bag folded in two directions comes to rest: its yarns are as long as they were cut, and nothing has crossed."""

from __future__ import annotations

import numpy as np
import pytest

from billow.apps.folding.checks import fold_checks
from billow.base.errors import InputError
from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model, require_start_clear
from billow.case.schema import Case
from billow.solver.run import Schedule, run

LINES = {"kind": "leporello", "lines": [0.07, 0.12]}
RELAX = {"kind": "relax", "time": "2 ms"}


def case(*folds, gas=None, **settings):
    table = {"shape": "square", "side": 0.36, "mouth_radius": 0.02, "element_size": 0.02, **settings}
    return Case.from_dict({"bag": {**table, "folds": list(folds)}, "gas": gas or {}})


@pytest.fixture(scope="module")
def at_rest(tmp_path_factory):
    """Case and model, computed without anything kept."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("billow.case.relaxed_start.cache_folder", lambda: str(tmp_path_factory.mktemp("cache")))
        folded = case(LINES, {**LINES, "across": "y"}, RELAX)
        return folded, build_model(folded)


def test_all_checks_pass_that_fail_before(at_rest):
    folded, model = at_rest
    assert [check.name for check in fold_checks(folded, model) if not check.passed] == []
    tense = case(LINES, {**LINES, "across": "y"})
    before = [check.name for check in fold_checks(tense, build_model(tense)) if not check.passed]
    assert "strain of yarns, greatest" in before


def test_a_bag_folded_in_one_direction_stays_put(tmp_path, monkeypatch):
    """Without gas, for 5 ms: relax lets go what the map strained, and pumps nothing up. With gaps that grow it moves
    with 1.1e-3 J."""
    monkeypatch.setattr("billow.case.relaxed_start.cache_folder", lambda: str(tmp_path))
    model = build_model(case(LINES, RELAX, gas={"model": "none"}))
    mapped = build_shape(case(LINES).bag).positions
    assert np.ptp(model.start[:, 2]) < 1.2 * np.ptp(mapped[:, 2])
    assert run(model, Schedule(0.005, frames=1, histories_per_frame=1)).ledger["kinetic"] < 1e-4


def test_only_positions_change_and_plates_are_clear(at_rest):
    _, model = at_rest
    tense = build_model(case(LINES, {**LINES, "across": "y"}))
    np.testing.assert_array_equal(model.mass, tense.mass)
    np.testing.assert_array_equal(model.start[model.fixed], tense.start[model.fixed])
    moved = np.linalg.norm(model.start - tense.start, axis=1)
    assert 1e-4 < moved.max() < 0.02
    assert model.fabric.birth is None
    require_start_clear(model)


def test_kept_and_computed_starts_are_the_same_bits(at_rest, tmp_path, monkeypatch):
    folded, model = at_rest
    monkeypatch.setattr("billow.case.relaxed_start.cache_folder", lambda: str(tmp_path))
    computed = build_model(folded).start
    (kept,) = (tmp_path / "relaxed").iterdir()
    monkeypatch.setattr("billow.case.relaxed_start.run", None)  # nothing is computed again
    np.testing.assert_array_equal(build_model(folded).start, computed)
    np.testing.assert_array_equal(model.start, computed)
    assert kept.stat().st_size == computed.nbytes


@pytest.mark.parametrize(
    ("folds", "settings"), [([RELAX], {}), ([RELAX, LINES], {}), ([LINES, RELAX], {"birth_time": 0.004})]
)
def test_relax_is_the_last_table_and_the_only_ramp(folds, settings):
    with pytest.raises(InputError, match="relax"):
        case(*folds, **settings)


def test_the_map_is_that_without_relax():
    relaxed, plain = (build_shape(case(LINES, *more).bag) for more in ([RELAX], []))
    np.testing.assert_array_equal(relaxed.positions, plain.positions)


def test_a_study_varies_the_time():
    assert case(LINES, RELAX).vary({"bag.folds.2.time": 0.003}).bag.relax.time == 0.003
