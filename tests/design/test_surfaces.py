"""Surfaces of known functions, their intervals and verdicts, and what is asked of them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import binomtest, norm, qmc

from billow.base.errors import InputError, IntegrityError
from billow.design.gaussian_process import Axes, GaussianProcess
from billow.design.optimum import Goal, optimise
from billow.design.robust import read_values, robustness, scattered
from billow.design.sensitivity import correlations, indices, main_effects
from billow.design.surface import _quantile, learn
from billow.design.surfaces import ResponseSurfaces
from billow.results.tensor_file import read_tensors, write_tensors
from billow.study.responses import Limit
from billow.study.variables import StudyConstraint
from trust.small_surfaces import small_surfaces, small_table, truth


@pytest.fixture(scope="module")
def surfaces():
    return small_surfaces()


def test_values_are_near_the_function_and_inside_their_intervals(surfaces):
    found = surfaces.interval("hard", surfaces.unseen[:, :3])
    value = surfaces.unseen[:, 3]
    assert found[:, 0] == pytest.approx(value, rel=0.02)
    assert ((found[:, 1] < found[:, 0]) & (found[:, 0] < found[:, 2])).all()
    assert surfaces.verdict("hard").word == "usable"


def test_what_is_no_one_surface_is_refused(surfaces):
    assert "did not happen" in surfaces.verdict("contact").why
    assert "in all runs" in surfaces.verdict("constant").why
    for name in ("contact", "constant"):
        with pytest.raises(InputError) as caught:
            surfaces.predict(name, {"vent": 30.0, "speed": 4.0, "gas": 0})
        assert caught.value.code == "E-DES-010"


def test_a_response_that_is_noise_is_not_usable():
    random = np.random.default_rng(0)
    points = random.random((30, 2))
    surface = learn(Axes((0, 0)), points, random.standard_normal(30), [[k] for k in range(30)])
    assert surface.verdict.word == "not usable"


def test_levels_may_be_named(surfaces):
    by_name = surfaces.predict("hard", {"vent": 30.0, "speed": 4.0, "gas": "argon"})
    assert by_name == surfaces.predict("hard", {"vent": 30.0, "speed": 4.0, "gas": 1})
    assert by_name > surfaces.predict("hard", {"vent": 30.0, "speed": 4.0, "gas": "nitrogen"})


def test_a_file_gives_the_same_bits(surfaces, tmp_path):
    path = surfaces.save(tmp_path / "r.safetensors")
    again = ResponseSurfaces.load(path)
    design = {"vent": 30.0, "speed": 4.0, "gas": 0}
    assert np.array_equal(again.interval("hard", design), surfaces.interval("hard", design))
    assert again.verdict("contact").why == surfaces.verdict("contact").why
    assert small_surfaces().save(tmp_path / "s.safetensors").read_bytes() == path.read_bytes()


def test_intervals_hold_what_they_say():
    """Twenty studies of a function with noise: of the unseen values of all, 90 % intervals hold 86 to 95 %."""
    held = []
    for seed in range(20):
        random = np.random.default_rng(seed)
        points = random.random((60, 3))
        values = np.sin(3 * points[:, 0]) + points[:, 1] * points[:, 2] + 0.05 * random.standard_normal(60)
        surface = learn(Axes((0, 0, 0)), points[:48], values[:48], [[k] for k in range(48)], "identity")
        found = surface.interval(points[48:])
        held += ((found[:, 1] <= values[48:]) & (values[48:] <= found[:, 2])).tolist()
    assert 0.86 <= np.mean(held) <= 0.95


def test_intervals_do_not_shrink_where_a_process_is_sure_of_itself():
    """Ten studies of a smooth function of six parameters: each holds three of four unseen values, and intervals get
    wider beyond the runs."""
    for seed in range(10):
        random = np.random.default_rng(seed)
        points = random.random((248, 6))
        values = np.exp(-2.0 * points[:, 3]) * (1.0 + points[:, 0]) + np.sin(2.0 * points[:, 1] + points[:, 4])
        values += 0.01 * values.std() * random.standard_normal(248)
        surface = learn(Axes((0,) * 6), points[:48], values[:48], [[k] for k in range(48)], "identity")
        found = surface.interval(points[48:])
        assert ((found[:, 1] <= values[48:]) & (values[48:] <= found[:, 2])).mean() > 0.75
        width = np.ptp(surface.interval(np.array([np.full(6, 0.5), np.ones(6)]))[:, 1:], axis=1)
        assert width[1] > width[0]


def test_intervals_are_as_much_wider_as_surfaces_that_miss_a_fold_lie_apart():
    random = np.random.default_rng(0)
    points = random.random((32, 2))
    values = np.sin(3 * points[:, 0]) * (1.0 + points[:, 1]) + 0.02 * random.standard_normal(32)
    surface = learn(Axes((0, 0)), points, values, [[k] for k in range(32)], "identity")
    asked = random.random((50, 2))
    _, whole = surface.distribution(asked)
    _, alone = replace(surface, folds=surface.folds[:1]).distribution(asked)
    means = np.stack([process.predict(asked)[0] for process in surface.folds])
    assert whole**2 - alone**2 == pytest.approx(means.var(axis=0), abs=1e-12)
    assert np.ptp(surface.interval(asked)[:, 1:], axis=1) == pytest.approx(2 * 1.6448536 * whole)
    assert surface.value(asked) == pytest.approx(surface.interval(asked)[:, 0], abs=1e-12)


def test_a_further_value_lies_below_a_quantile_as_often_as_it_says():
    """The k-th of n values of a kind has k / (n + 1) of all further ones below it."""
    assert _quantile(np.arange(48.0, 0.0, -1.0), 0.9) == pytest.approx(0.9 * 49)
    assert _quantile(np.arange(1.0, 6.0), 0.95) == 5.0


def test_a_verdict_says_how_many_runs_lay_in_intervals_and_doubts_intervals_that_miss():
    random = np.random.default_rng(2)
    points = random.random((60, 2))
    values = np.sin(3 * points[:, 0]) + points[:, 1] + 0.02 * random.standard_normal(60)
    rows = [[k] for k in range(40)]
    for away, word in ((0.0, "usable"), (1.0, "indicative")):
        unseen = points[40:], np.append(values[40:59] + away, np.nan)
        verdict = learn(Axes((0, 0)), points[:40], values[:40], rows, "identity", unseen).verdict
        assert verdict.word == word
        assert verdict.asked == 59
        assert (verdict.held > 48) == (word == "usable")
        ends = binomtest(verdict.held, 59).proportion_ci(0.95)
        assert verdict.coverage == pytest.approx((ends.low, ends.high))
        assert f"90 % intervals held {verdict.held} of 59 runs" in str(verdict)
    assert "intervals miss more than they say" in str(verdict)


def test_a_file_of_another_version_is_refused_with_the_reason(surfaces, tmp_path):
    path = surfaces.save(tmp_path / "r.safetensors")
    tensors, record = read_tensors(path, ValueError)
    del record["sha256"]
    write_tensors(path, tensors, record | {"format": 2})
    with pytest.raises(IntegrityError) as caught:
        ResponseSurfaces.load(path)
    assert caught.value.code == "E-DES-012"
    assert "version 2" in str(caught.value)


def ishigami(unit):
    x = np.pi * (2.0 * unit - 1.0)
    return np.sin(x[:, 0]) + 7.0 * np.sin(x[:, 1]) ** 2 + 0.1 * x[:, 2] ** 4 * np.sin(x[:, 0])


ISHIGAMI = np.array([0.5576, 0.4424, 0.2437])
"""Total indices (Ishigami and Homma, 1990), for a = 7 and b = 0.1."""


def test_indices_of_the_ishigami_function_are_known():
    first, total = indices(ishigami, 3, 4096, seed=0)
    assert total[:, 0] == pytest.approx(ISHIGAMI, abs=0.02)
    assert first[:, 0] == pytest.approx([0.3139, 0.4424, 0.0], abs=0.02)
    assert ((total[:, 1] <= total[:, 0]) & (total[:, 0] <= total[:, 2])).all()


G = np.array([0.0, 1.0, 4.5, 9.0])


def g_function(unit):
    return np.prod((np.abs(4.0 * unit - 2.0) + G) / (1.0 + G), axis=1)


def g_totals():
    parts = 1.0 / (3.0 * (1.0 + G) ** 2)
    whole = np.prod(1.0 + parts) - 1.0
    return np.array([part * np.prod(1.0 + np.delete(parts, k)) / whole for k, part in enumerate(parts)])


def test_indices_of_the_g_function_are_known():
    found = indices(g_function, 4, 4096, seed=0)[1]
    assert found[:, 0] == pytest.approx(g_totals(), abs=0.02)


@pytest.mark.parametrize(("function", "expected"), [(ishigami, ISHIGAMI), (g_function, g_totals())])
def test_indices_on_a_process_of_200_points_are_near_those_of_the_function(function, expected):
    points = qmc.LatinHypercube(len(expected), rng=1).random(200)
    process = GaussianProcess.fit(Axes((0,) * len(expected)), points, function(points))
    found = indices(lambda unit: process.predict(unit)[0], len(expected), 4096, seed=0)[1]
    assert found[:, 0] == pytest.approx(expected, abs=0.05)


def test_sensitivity_finds_what_matters(surfaces):
    found = surfaces.sensitivity("hard", samples=256)
    assert found.names == ("vent", "speed", "gas")
    assert found.total[1, 0] > 0.8 > 0.1 > found.total[0, 0]
    again = surfaces.sensitivity("hard", samples=256)
    assert np.array_equal(found.total, again.total)
    places, effects = main_effects(surfaces, "pressure")
    assert effects[0, 0, 0] - effects[0, -1, 0] == pytest.approx(30.0, rel=0.05)
    assert sorted(set(places[2])) == [0.0, 1.0]
    assert correlations(surfaces)[1, 3] > 0.8


def test_the_optimum_is_the_best_design_that_surely_keeps_the_limits(surfaces):
    best = surfaces.optimise(minimise="hard", below={"pressure": 50.0}, fixed={"speed": 5.0})
    assert best.responses["pressure"][2] <= 50.0
    assert best.design["speed"] == pytest.approx(5.0)
    assert best.design["gas"] == 0.0
    grid = np.array([[vent, 5.0, 0.0] for vent in np.linspace(20, 50, 301)])
    free = truth(grid)[truth(grid)[:, 1] <= 50.0, 0].min()
    assert best.responses["hard"][0] == pytest.approx(free, rel=0.02)
    again = surfaces.optimise(minimise="hard", below={"pressure": 50.0}, fixed={"speed": 5.0})
    assert again.design == best.design


def test_limits_are_kept_by_the_ends_of_intervals_and_chances_have_ends_there():
    noisy = ResponseSurfaces.learn(small_table(noise=2.0))
    best = noisy.optimise(maximise="pressure", below={"pressure": 45.0})
    value, low, high = best.responses["pressure"]
    assert low < value - 2.0 < value + 2.0 < high <= 45.0
    assert high == pytest.approx(45.0, abs=0.1)
    lowest = noisy.optimise(minimise="pressure", above={"pressure": 45.0}).responses["pressure"]
    assert lowest[1] == pytest.approx(45.0, abs=0.1)
    chance = noisy.exceed("pressure", 47.0, {"vent": 35.0, "speed": 5.0, "gas": 0}, {"vent": 2.0})
    assert chance.low < chance.probability < chance.high
    assert chance.low < chance.with_error < chance.high
    for scatter, seen in (({"vent": 2.0}, False), ({"vent": 4.0, "speed": 0.6}, True)):
        around = {"vent": 35.0, "speed": 5.0, "gas": 0}
        chance = noisy.exceed("pressure", 47.0, around, scatter)
        assert chance.resolved == (chance.near >= 6) == seen
        points, _ = scattered(noisy, around, scatter, 100_000, 0)
        mean, deviation = noisy.surfaces[1].distribution(points)
        for side, end in ((-1.0, chance.low), (1.0, chance.high)):
            shifted = mean + side * 1.645 * deviation
            assert end == pytest.approx((shifted > noisy.surfaces[1].scaled(47.0)).mean(), abs=1e-3)


def test_an_optimum_stays_within_reach_and_on_its_steps(surfaces):
    best = surfaces.optimise(maximise="hard", steps={"vent": 4.0})
    unit = np.array([[(best.design["vent"] - 20) / 30, (best.design["speed"] - 3) / 4, best.design["gas"]]])
    assert surfaces.beyond(unit)[0] == 0.0
    assert (best.design["vent"] - 20.0) / 4.0 == pytest.approx(round((best.design["vent"] - 20.0) / 4.0))
    target = surfaces.optimise(target=("hard", 300.0))
    assert target.responses["hard"][0] == pytest.approx(300.0, rel=1e-3)


def test_a_fixed_value_is_not_moved_to_a_step(surfaces):
    assert surfaces.optimise(minimise="hard", fixed={"vent": 33.0}, steps={"vent": 7.0}).design["vent"] == 33.0


def test_an_optimum_keeps_to_the_steps_and_constraints_of_its_study(surfaces, tmp_path):
    """Otherwise the solver would be given another design than was predicted, or one that cannot be built."""
    free = surfaces.optimise(minimise="hard").design
    assert free["vent"] - 4.0 * free["speed"] > 15.0
    constraint = StudyConstraint(terms={"vent": 1.0, "speed": -4.0}, at_most=15.0)
    bound = replace(surfaces, steps={"vent": 4.0}, constraints=(constraint,))
    again = ResponseSurfaces.load(bound.save(tmp_path / "r.safetensors"))
    for made in (bound, again):
        best = made.optimise(minimise="hard").design
        assert best["vent"] - 4.0 * best["speed"] <= 15.0
        assert best["vent"] in (20.0, 24.0, 28.0, 32.0, 36.0, 40.0, 44.0, 48.0)
        for goal in ({"vent": 33.0}, {"vent": 48.0, "speed": 3.0}):  # between steps; none is allowed there
            with pytest.raises(InputError) as caught:
                made.optimise(minimise="hard", fixed=goal)
            assert caught.value.code == ("E-DES-030" if len(goal) == 1 else "E-DES-031")
            assert "steps" in caught.value.why or "constraints of the study" in caught.value.why


def test_an_optimum_keeps_away_from_designs_whose_runs_do_not_hold(surfaces):
    goal = Goal(minimise="hard")
    first = optimise(surfaces, goal).design
    place = np.array([[(first["vent"] - 20) / 30, (first["speed"] - 3) / 4, first["gas"]]])
    second = optimise(surfaces, goal, avoid=place).design
    away = np.array([(second["vent"] - 20) / 30, (second["speed"] - 3) / 4, second["gas"]]) - place[0]
    assert np.linalg.norm(away) >= 0.2 - 1e-9


@pytest.mark.parametrize(
    "goal",
    [
        {},
        {"minimise": "hard", "maximise": "pressure"},
        {"minimise": "hard", "fixed": {"speed": 9.0}},
        {"minimise": "hard", "fixed": {"spead": 4.0}},
        {"minimise": "hard", "steps": {"vent": 0.0}},
        {"minimise": "hard", "level": 0.33},
        {"minimise": "hard", "seed": -1},
        {"minimise": "hard", "below": {"pressure": float("nan")}},
        {"target": ("hard", float("inf"))},
        {"minimise": "hard", "steps": {"vent": float("inf")}},
        {"minimise": "hard", "fixed": {"gas": 0.4}},
    ],
)
def test_goals_that_make_no_sense_are_refused(surfaces, goal):
    with pytest.raises(InputError) as caught:
        surfaces.optimise(**goal)
    assert caught.value.code == "E-DES-030"


def test_the_chance_of_a_linear_response_is_known():
    random = np.random.default_rng(5)
    points = random.random((40, 2))
    table = small_table()
    designs = np.column_stack([20 + 30 * points[:, 0], 3 + 4 * points[:, 1], random.integers(0, 2, 40)])
    linear = replace(table, designs=designs, values=(2 * points[:, 0] + points[:, 1])[:, None], unseen=0,
                     runs=tuple(map(str, range(40))), responses=table.responses[:1], units=("-",))  # fmt: skip
    surfaces = ResponseSurfaces.learn(linear)
    around = {"vent": 35.0, "speed": 5.0, "gas": 0}
    chance = surfaces.exceed("hard", 1.8, around, {"vent": 3.0, "speed": 0.4})
    expected = norm.sf((1.8 - 1.5) / np.hypot(2 * 0.1, 0.1))
    assert chance.probability == pytest.approx(expected, abs=3 * np.sqrt(expected * (1 - expected) / 1e5))
    assert chance.with_error == pytest.approx(expected, abs=0.005)
    assert chance.low <= chance.with_error <= chance.high


def test_a_limit_on_both_sides_is_broken_on_either(surfaces):
    """The chance once was that of the upper side alone."""
    around, scatter = {"vent": 35.0, "speed": 5.0, "gas": 0}, {"speed": 0.3}
    hard = surfaces.responses[0]

    def chance(**limit):
        given = hard.model_copy(update={"limit": Limit(**limit)})
        return robustness(replace(surfaces, responses=(given, *surfaces.responses[1:])), around, scatter)["hard"]

    upper, lower, both = chance(below=230.0), chance(above=170.0), chance(below=230.0, above=170.0)
    assert min(upper.probability, lower.probability) > 0.05
    assert both.probability == pytest.approx(upper.probability + lower.probability, abs=1e-9)
    assert both.with_error == pytest.approx(upper.with_error + lower.with_error, abs=1e-9)
    assert both.low <= both.probability <= both.high
    assert (both.broken, upper.broken, lower.broken) == ("below 170 or above 230", "above 230", "below 170")
    assert (both.light, chance().light) == ("red", "grey")


def test_goals_designs_and_scatter_take_texts_with_units(surfaces, tmp_path):
    """Other units, names of levels, and numbers in the unit of the response say the same; units that do not fit are
    refused with the name."""
    (tmp_path / "goals.toml").write_text(
        'minimise = "hard"\n[below]\npressure = "1.2 bar"\n[fixed]\nvent = "3.5 cm"\ngas = "argon"\n'
        '[steps]\nspeed = "1 km/h"\n'
    )
    goal = Goal.load(tmp_path / "goals.toml", surfaces)
    assert goal.below == {"pressure": pytest.approx(120.0)}
    assert goal.fixed == {"vent": pytest.approx(35.0), "gas": 1.0}
    assert goal.steps == {"speed": pytest.approx(1 / 3.6)}
    for text, why in (
        ('pressure = "3 m"', "pressure = '3 m': unit 'm' does not fit here"),
        ("pressure = [1]", "number"),
        ('gas = "hot"', "gas = 'hot': its levels are nitrogen, argon"),
    ):
        (tmp_path / "goals.toml").write_text(f'minimise = "hard"\n[below]\n{text}\n')
        with pytest.raises(InputError, match="E-DES-030") as raised:
            Goal.load(tmp_path / "goals.toml", surfaces)
        assert why in raised.value.why
    (tmp_path / "s.toml").write_text('speed = "18 km/h"\nvent = "3.5 cm"\ngas = "nitrogen"\n')
    assert read_values(tmp_path / "s.toml", surfaces) == pytest.approx({"speed": 5.0, "vent": 35.0, "gas": 0.0})


def test_robustness_says_which_limits_are_in_danger(surfaces, tmp_path):
    (tmp_path / "s.toml").write_text("[scatter]\nspeed = 0.05\n")
    scatter = read_values(tmp_path / "s.toml", surfaces)
    slow, fast = ({"vent": 35.0, "speed": v, "gas": 0} for v in (4.0, 6.8))
    found = robustness(surfaces, slow, scatter)
    assert set(found) == {"hard", "pressure"}
    assert (found["hard"].light, robustness(surfaces, fast, scatter)["hard"].light) == ("green", "red")
    assert found["pressure"].light == "grey"
    assert (np.diff(found["hard"].percentiles) > 0).all()
