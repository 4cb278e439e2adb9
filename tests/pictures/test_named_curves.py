"""Quantities by their names, resultants, filters that are those of the injury metrics, and tables of tests."""

import numpy as np
import pytest

from billow.base.errors import InputError
from billow.injury.criteria import GRAVITY, assess_run
from billow.injury.filters import channel_filter
from billow.pictures.curves import curve_of, quantities, require_quantities, usual_quantities
from billow.pictures.shown_units import check_units, factor_of, shown_unit
from billow.pictures.source import labels, open_source, read_curves
from billow.results.histories import History
from billow.results.result import Result

TIMES = np.arange(501) * 1e-4
WAVE = np.stack([np.sin(300.0 * TIMES), np.cos(500.0 * TIMES), 0.3 * np.sin(2000.0 * TIMES)], axis=1)


def moving(name="head"):
    columns = {"time [s]": TIMES, "pressure [Pa]": 1e5 + 100.0 * TIMES}
    columns |= {f"{name}_velocity_{axis} [m/s]": WAVE[:, k] for k, axis in enumerate("xyz")}
    columns |= {f"{name}_acceleration_{axis} [m/s^2]": 0.0 * TIMES for axis in "xyz"}
    return History(columns)


def test_names_are_columns_without_units_and_vectors_without_axes():
    known = quantities(moving())
    assert known["pressure"] == "Pa"
    assert known["head_velocity"] == known["head_velocity_z"] == "m/s"
    assert "time" not in known


def test_a_vector_means_its_resultant_and_an_axis_its_component():
    whole, part = curve_of(moving(), "head_velocity"), curve_of(moving(), "head_velocity_y")
    np.testing.assert_allclose(whole.values, np.linalg.norm(WAVE, axis=1))
    np.testing.assert_array_equal(part.values, WAVE[:, 1])
    assert whole.title == "head velocity, resultant"
    assert curve_of(moving(), "head_velocity_w") is None


@pytest.mark.parametrize("channel_class", [60, 180, 600, 1000])
def test_each_component_goes_through_the_filter_of_the_injury_metrics(channel_class):
    filtered = channel_filter(TIMES, WAVE, channel_class)
    found = curve_of(moving(), "head_velocity", channel_class)
    np.testing.assert_array_equal(found.values, np.linalg.norm(filtered, axis=1))
    assert found.title == f"head velocity, resultant, CFC {channel_class}"
    np.testing.assert_array_equal(curve_of(moving(), "head_velocity_z", channel_class).values, filtered[:, 2])


def test_the_peak_of_an_acceleration_is_that_of_billow_injury():
    class Run:
        free_obstacles, histories = ("head",), moving()

        def body(self, name):
            return self.histories.of(name)

    curve = curve_of(Run.histories, "head_acceleration", 1000)
    injury = assess_run(Run())["head"]
    assert curve.peak == (pytest.approx(injury.peak, rel=1e-12), pytest.approx(injury.peak_time))
    component = curve_of(Run.histories, "head_acceleration_x", 1000)
    assert np.abs(component.values).max() < injury.peak


def test_the_peak_of_a_run_is_that_of_billow_injury(pair):
    result = Result.open(pair[0])
    found = curve_of(result.histories, "impactor_acceleration", 1000)
    assert found.peak[0] == pytest.approx(assess_run(result)["impactor"].peak, rel=1e-12)


def test_a_column_of_an_acceleration_without_a_filter_is_as_recorded():
    np.testing.assert_array_equal(curve_of(moving(), "head_acceleration").values, 0.0)


def test_peaks_are_farthest_from_zero_whatever_their_sign_and_skip_what_is_no_number():
    history = History({"time [s]": np.arange(4.0), "force [N]": np.array([1.0, -5.0, np.nan, 2.0])})
    curve = curve_of(history, "force")
    assert curve.peak == (-5.0, 1.0)
    assert curve.end == 2.0
    nothing = curve_of(History({"time [s]": np.arange(2.0), "a [N]": np.full(2, np.nan)}), "a")
    assert np.isnan(nothing.peak).all()


def test_a_name_that_no_run_has_is_refused_with_close_ones():
    with pytest.raises(InputError, match="E-PIC-009") as refused:
        require_quantities(["presure"], [moving()], "runs/a")
    assert refused.value.remedy.startswith("did you mean pressure?")
    with pytest.raises(InputError, match="E-PIC-009"):
        require_quantities(["time"], [moving()], "runs/a")
    require_quantities(["head_velocity", "pressure"], [moving(), History({"time [s]": TIMES})], "runs")


def test_what_is_usual_follows_from_what_is_there(pair):
    free = usual_quantities([Result.open(pair[0]).histories])
    assert free == ["pressure", "volume", "impactor_acceleration", "impactor_velocity"]
    table = History({"time [s]": TIMES, "a [N]": TIMES, "b [N]": TIMES})
    assert usual_quantities([table]) == ["a", "b"]


# --- units ------------------------------------------------------------------------


def test_values_are_shown_in_units_that_read_well():
    assert shown_unit("Pa", 5e4) == "kPa"
    assert shown_unit("Pa", 5e6) == "MPa"
    assert shown_unit("Pa", 5e6, ["l", "bar"]) == "bar"
    assert shown_unit("m^3", 0.05) == "l"
    assert shown_unit("K", 300.0, ["bar"]) == "K"
    assert shown_unit("furlong", 1.0) == "furlong"
    assert factor_of("m/s^2", "g") == GRAVITY
    assert factor_of("furlong", "furlong") == 1.0


def test_a_unit_that_nobody_knows_is_refused():
    check_units(["kPa", "g", "ms"])
    with pytest.raises(InputError, match="E-PIC-003") as refused:
        check_units(["kpa"])
    assert "did you mean kPa" in refused.value.remedy


# --- tables of tests ------------------------------------------------------------------------


def test_a_table_of_a_test_is_read_in_its_units(tmp_path):
    path = tmp_path / "test.csv"
    path.write_text("Time [ms];head acceleration z [g];pressure [kPa];angle [deg]\n0;1,5;101,3;0\n0,1;-2;102;1\n")
    curves = read_curves(path)
    np.testing.assert_allclose(curves.time, [0.0, 1e-4])
    np.testing.assert_allclose(curves["head_acceleration_z [m/s^2]"], [1.5 * GRAVITY, -2.0 * GRAVITY])
    np.testing.assert_allclose(curves["pressure [Pa]"], [101300.0, 102000.0])
    np.testing.assert_allclose(curves["angle [deg]"], [0.0, 1.0])


@pytest.mark.parametrize(
    "text",
    [
        "",
        "pressure [kPa],time [ms]\n1,2\n",
        "time,pressure [kPa]\n1,2\n",
        "time [ms],pressure\n1,2\n",
        "time [ms],pressure [kPa]\n1,x\n",
        "time [ms],pressure [kPa]\n2,1\n1,1\n",
        "time [ms],pressure [kPa]\n1,1\n1,1\n",
        "time [m],pressure [kPa]\n1,1\n2,1\n",
        "\x00\x01",
    ],
)
def test_what_is_no_table_of_curves_is_refused(tmp_path, text):
    path = tmp_path / "test.csv"
    path.write_text(text)
    with pytest.raises(InputError, match="E-PIC-007"):
        read_curves(path)


def test_sources_are_told_apart_by_as_much_of_their_paths_as_that_needs(tmp_path):
    paths = [tmp_path / "a" / "run", tmp_path / "b" / "run", tmp_path / "a" / "run"]
    assert labels(paths) == ["a/run (1)", "b/run", "a/run (2)"]
    assert labels([tmp_path / "one", tmp_path / "two"]) == ["one", "two"]
    assert labels([tmp_path / "one"]) == ["one"]


def test_files_of_other_kinds_are_refused(tmp_path):
    path = tmp_path / "notes.txt"
    path.write_text("hello")
    with pytest.raises(InputError, match="E-PIC-006"):
        open_source(path, "plot")
    with pytest.raises(InputError, match="E-RES-001"):
        open_source(tmp_path / "none", "plot")
