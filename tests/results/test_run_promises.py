"""What run.json says of a finished run: inverted fabric and energy from nowhere fail it, and obstacles are where the
case puts them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from billow.base.errors import NumericalStop
from billow.case.schema import Case
from billow.geometry.bag_shapes import square_bag
from billow.results.obstacles import obstacles_at
from billow.results.result import Result
from billow.results.vtkhdf import FabricWriter
from billow.run.simulate import simulate


def verdicts(result: Result) -> dict[str, str]:
    """Verdict of each criterion by its name."""
    return {line["name"]: line["verdict"] for line in result.record["quality"]["criteria"]}


def pillow(path: Path, past: float, size: float = 1.0) -> str:
    """A mesh file of a square bag, scaled by its size [-]; a node of its front with four triangles is moved towards the
    middle of an opposite edge, that many times the way [-]."""
    shape = square_bag(0.4, 4, 0.04)
    triangles, points = shape.surface.triangles.astype(np.int64), shape.positions.copy()
    around = np.bincount(triangles.ravel())
    node = int(np.flatnonzero((points[:, 2] > 0.0) & (around == 4))[0])
    corners = triangles[(triangles == node).any(axis=1)][0]
    points[node] += past * (points[corners[corners != node]].mean(axis=0) - points[node])
    points *= size
    with FabricWriter(path, points, triangles, shape.surface.part, ["front", "rear"]) as file:
        file.append(0.0, points)
    return str(path)


@pytest.mark.parametrize(
    ("past", "inverted", "verdict"), [(0.0, 0, "PASS"), (0.5, 0, "PASS"), (1.3, 0, "PASS"), (2.2, 1, "FAIL")]
)
def test_fabric_that_ends_turned_over_and_taut_fails_the_run(tmp_path, past, inverted, verdict):
    """Beyond the edge a triangle faces against its neighbours, which still face outward: short of its own height there,
    as one in a wrinkle, or stretched."""
    case = Case.from_dict(
        {
            "bag": {
                "shape": "mesh", "start": pillow(tmp_path / "start.vtkhdf", past),
                "reference": pillow(tmp_path / "reference.vtkhdf", 0.0, 0.99),
                "birth_time": 0.01, "parts": [{"name": "front"}, {"name": "rear"}],
            },
            "gas": {"model": "none"},
            "obstacles": [],
            "run": {"end_time": 2e-5, "frames": 1, "histories_per_frame": 1},
        }
    )  # fmt: skip
    result = simulate(case, tmp_path / "run")
    assert result.ledger["inverted_elements"] == inverted
    assert verdicts(result)["inverted elements at the end"] == verdict


def test_a_run_that_gains_energy_is_stopped_and_fails(tmp_path):
    """Six times the stable step, which no case may ask for: fabric that is hit blows up."""
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.06},
            "gas": {"model": "none"},
            "obstacles": [
                {
                    "shape": "super-ellipsoid", "name": "impactor", "radii": 0.1, "locked": False, "clearance": 0.03,
                    "velocity": [0.0, 0.0, -20.0],
                }
            ],
            "run": {"end_time": 0.01, "frames": 1, "histories_per_frame": 50},
        }
    )  # fmt: skip
    unstable = case.model_copy(update={"run": case.run.model_copy(update={"dt_scale": 6.0})})
    with pytest.raises(NumericalStop, match="E-NUM-003"):
        simulate(unstable, tmp_path / "run")
    result = Result.open(tmp_path / "run")
    assert result.status == "stopped"
    assert result.ledger["energy_gain_of_largest"] > 0.2
    assert result.ledger["energy_loss_of_largest"] < result.ledger["energy_gain_of_largest"]
    assert verdicts(result)["energy gain, of the largest energy"] == "FAIL"
    assert result.record["quality"]["verdict"] == "FAIL"


def test_pictures_show_obstacles_where_the_case_puts_them(tmp_path):
    """Locked and free: before the run by run.json, during it by the histories as well."""
    table = {
        "shape": "super-ellipsoid", "radii": 0.1, "clearance": 0.03, "offset": [0.02, -0.01], "angle_about_x": 20.0,
    }  # fmt: skip
    place, above = [0.02, -0.01, 0.13], [0.02, -0.01, 0.4]  # the clearance is that of its lowest point
    case = Case.from_dict(
        {
            "bag": {"element_size": 0.06, "diameter": 0.4},
            "gas": {"model": "none"},
            "obstacles": [
                {"shape": "plate", "height": -0.005},
                table | {"name": "locked", "locked": True},
                table | {"name": "free", "locked": False, "clearance": 0.3, "velocity": [1.0, 0.0, 2.0]},
            ],
            "run": {"end_time": 1e-3, "frames": 1, "histories_per_frame": 1},
        }
    )
    result = simulate(case, tmp_path / "run")
    plate, locked, free = result.record["obstacles"]
    assert (plate["name"], plate["kind"], plate["center"][2]) == ("plate", "plate", -0.005)
    for told, centre in ((locked, place), (free, above)):
        assert (told["kind"], told["radii"]) == ("super-ellipsoid", [0.1, 0.1, 0.1])
        assert told["center"] == pytest.approx(centre, abs=1e-12)
        assert np.array(told["rotation"])[2, 1] == pytest.approx(np.sin(np.radians(20.0)), rel=1e-12)
    start, end = ({o["name"]: np.array(o["center"]) for o in obstacles_at(result, t)} for t in (0.0, 1e-3))
    assert start["locked"] == pytest.approx(place, abs=1e-12)
    assert start["free"] == pytest.approx(above, abs=1e-12)
    assert end["locked"] == pytest.approx(place, abs=1e-12)
    assert end["free"] - above == pytest.approx([1e-3, 0.0, 2e-3], abs=1e-9)
