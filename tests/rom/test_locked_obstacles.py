"""A surrogate knows the locked obstacles of its runs, whatever the design makes of them."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from billow.base.errors import IntegrityError
from billow.rom.surrogate.locked_obstacles import LockedObstacle, locked_obstacles, numbers_of
from billow.rom.surrogate.surrogate import Surrogate

sys.path.insert(0, str(Path(__file__).parents[2]))  # trust/ stands beside the package, not in it

from trust.small_surrogate import small_surrogate

DESIGNS = np.random.default_rng(1).uniform([0.02, 500.0, 0.1, 2.0], [0.03, 800.0, 0.25, 4.5], (20, 4))


def head(design, **others):
    """An ellipsoid just above the bag, whose radius and degree are parameters."""
    described = {
        "kind": "super-ellipsoid", "radii": [design[2]] * 3, "degree": design[3], "name": "head", "locked": True,
        "center": [0.0, 0.0, 0.05 + design[2]], "rotation": np.eye(3).tolist(),
    }  # fmt: skip
    return described | others


PLATE = {
    "kind": "half-space", "name": "plate", "locked": True, "center": [0.0, 0.0, 0.0], "rotation": np.eye(3).tolist(),
}  # fmt: skip


def test_numbers_that_are_affine_in_the_design_are_found():
    found = locked_obstacles([[PLATE, head(design)] for design in DESIGNS[:12]], DESIGNS[:12])
    assert [one.name for one in found] == ["plate", "head"]
    assert [one.varies for one in found] == [False, True]
    for design in DESIGNS[12:]:
        there = found[1].at(design)
        assert numbers_of(there) == pytest.approx(numbers_of(head(design)), abs=1e-9)
        assert list(there) == list(head(design))
    assert found[1].rows("degree") == pytest.approx(np.array([[0.0, 0.0, 0.0, 0.0, 1.0]]), abs=1e-9)


@pytest.mark.parametrize(
    "told",
    [
        lambda design, k: head(design, locked=False),
        lambda design, k: head(design, degree=design[3] ** 2),
        lambda design, k: head(design, name="head" if k else "chest"),
        lambda design, k: head(design, radii=[0.1] * 3) | ({} if k else {"kind": "box", "half": [0.1] * 3}),
    ],
    ids=["free", "not affine", "another", "of another kind"],
)
def test_others_are_left_out(told):
    assert locked_obstacles([[told(design, k)] for k, design in enumerate(DESIGNS)], DESIGNS) == ()


def test_too_few_runs_do_not_tell_which_parameter_does_it():
    assert locked_obstacles([[head(design)] for design in DESIGNS[:5]], DESIGNS[:5]) == ()
    assert len(locked_obstacles([[PLATE]], DESIGNS[:1])) == 1


def with_head():
    made = small_surrogate()
    affine = np.column_stack([numbers_of(head(DESIGNS[0])), np.zeros((16, len(made.parameters)))])
    return replace(made, obstacles=(LockedObstacle(head(DESIGNS[0]), affine),))


def test_the_file_keeps_them(tmp_path):
    made = with_head()
    read = Surrogate.load(made.save(tmp_path / "s.safetensors"))
    assert read.obstacles[0].like == made.obstacles[0].like
    assert (read.obstacles[0].affine == made.obstacles[0].affine).all()
    assert Surrogate.load(small_surrogate().save(tmp_path / "none.safetensors")).obstacles == ()


@pytest.mark.parametrize(
    "spoilt",
    [
        {"kind": 3.0},
        {"name": "a\nb"},
        {"rotation": [1.0, 0.0, 0.0]},
        {"radii": "big"},
    ],
)
def test_a_damaged_one_is_refused(tmp_path, spoilt):
    made = with_head()
    wrong = LockedObstacle(made.obstacles[0].like | spoilt, made.obstacles[0].affine)
    with pytest.raises(IntegrityError, match="E-ROM-004"):
        Surrogate.load(replace(made, obstacles=(wrong,)).save(tmp_path / "s.safetensors"))
