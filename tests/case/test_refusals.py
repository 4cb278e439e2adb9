"""Whatever is wrong with a case is told in one message: file, key, value, what was expected, what to try."""

from __future__ import annotations

import copy
import random
import string
from contextlib import suppress

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from billow.base.errors import InputError
from billow.case.schema import Case

# What is written, the code, the key it must name, the value it must show, and words of the expectation or the remedy.
REFUSED = [
    # unknown keys
    ("[bag]\ndiametre = 0.7", "E-CASE-003", "bag.diametre", "", "did you mean 'diameter'"),
    ("[fabrik]\nthickness = 3e-4", "E-CASE-003", "fabrik", "", "did you mean 'fabric'"),
    ('[[obstacles]]\nshape = "plate"\nslop = 1e5', "E-CASE-003", "obstacles.0.slop", "", "did you mean 'slope'"),
    ("[bag.vents]\nxyzzy = 1", "E-CASE-003", "bag.vents.xyzzy", "", "count, diameter"),
    ("float = 1", "E-CASE-003", "float", "", "did you mean"),
    ("[run]\nplate = 1", "E-CASE-003", "run.plate", "", "end_time"),
    # missing keys
    ("[inflator]\nmass_flow = {}", "E-CASE-004", "inflator.mass_flow.time", "time and value are missing", "add time"),
    ("run.gravity = [0, 0]", "E-CASE-004", "run.gravity.2", "entry 3 is missing in run.gravity", "at least 3 entries"),
    ("[inflator.mass_flow]\ntime = [0.0, 0.05]", "E-CASE-004", "inflator.mass_flow.value", "", "add value"),
    (
        '[[gas.orifices]]\nname = "a"', "E-CASE-004", "gas.orifices.0", "between and area are missing",
        "add between and area",
    ),
    ("[[run.sensors]]", "E-CASE-004", "run.sensors.0", "name and position are missing", "add name and position"),
    ("[bag.vents]\narea_factor = {pressure = [0, 1e4], value = [1, 2]}", "E-CASE-003", "area_factor.pressure", "",
     "'gauge_pressure'"),
    ("[bag.vents]\narea_factor = {q = [0, 1e4], value = [1, 2]}", "E-CASE-003", "area_factor.q", "",
     "gauge_pressure, time, value"),
    ('[fabric]\nself_contact = "often"', "E-CASE-005", "fabric.self_contact", "often", ""),
    # values out of range, with the unit that was probably meant
    ("[fabric]\nthickness = -3e-4", "E-CASE-005", "fabric.thickness", "-0.0003", "range 1e-05 to 0.005 m"),
    ("[fabric]\nthickness = 0.3", "E-CASE-005", "fabric.thickness", "0.3", 'write "0.3 mm"'),
    ("[fabric]\nthickness = 0", "E-CASE-005", "fabric.thickness", "0", "range"),
    ("[ambient]\ntemperature = 22.0", "E-CASE-005", "ambient.temperature", "22", "range 200 to 400 K"),
    ("[ambient]\npressure = 101.3", "E-CASE-005", "ambient.pressure", "101.3", 'write "101.3 kPa"'),
    ("[fabric]\nyoung_warp = 0.4", "E-CASE-005", "fabric.young_warp", "0.4", 'write "0.4 MPa"'),
    ("[run]\nend_time = 50", "E-CASE-005", "run.end_time", "50", 'write "50 ms"'),
    ("[run]\ndt_scale = 1.5", "E-CASE-005", "run.dt_scale", "1.5", "range 0.01 to 1"),
    ('[[obstacles]]\nshape = "plate"\n' * 1001, "E-CASE-005", "case", "", "1001 tables obstacles; at most 1000"),
    ("[run]\nframes = 0", "E-CASE-005", "run.frames", "0", "1 to 10000"),
    ("[bag.vents]\ncount = -1", "E-CASE-005", "bag.vents.count", "-1", "0 to 12"),
    ("[bag]\ndiameter = nan", "E-CASE-005", "bag.diameter", "nan", ""),
    ("[bag]\ndiameter = inf", "E-CASE-005", "bag.diameter", "inf", ""),
    (f"[bag]\ndiameter = 1{400 * '0'}", "E-CASE-005", "bag.diameter", "", "too large"),
    # wrong units and types
    ('[fabric]\nthickness = "0.3 kg"', "E-CASE-005", "fabric.thickness", "0.3 kg", "one of m, mm, cm, in"),
    ('[fabric]\nthickness = "thin"', "E-CASE-005", "fabric.thickness", "thin", '"1.5 m"'),
    ('[inflator]\ntemperature = "650 C"', "E-CASE-005", "inflator.temperature", "650 C", "one of K"),
    ("[fabric]\nthickness = true", "E-CASE-005", "fabric.thickness", "true", "a number in m"),
    ("[fabric]\nthickness = [3e-4]", "E-CASE-005", "fabric.thickness", "list", "a number in m"),
    ("[fabric]\nthickness = 2026-11-22", "E-CASE-005", "fabric.thickness", "date", "a number in m"),
    ("bag = 3", "E-CASE-005", "bag", "3", "a table is expected"),
    ("run.frames = true", "E-CASE-005", "run.frames", "true", "not true or false"),
    ("bag.shape = \"mesh\"\nbag.fixed_nodes = [true]", "E-CASE-005", "bag.fixed_nodes", "true", "not true or false"),
    ('[gas]\nmodel = "ale"', "E-CASE-005", "gas.model", "ale", "uniform-pressure"),
    ('[[obstacles]]\nshape = "cube"', "E-CASE-005", "obstacles.0", "", "'plate' or shape = 'super-ellipsoid'"),
    ('title = "two\\nlines"', "E-CASE-005", "title", "two", "one line"),
    ("[run]\nframes = 10000\nhistories_per_frame = 1000", "E-CASE-005", "run", "", "at most 100000"),
    ('[[obstacles]]\nshape = "super-ellipsoid"\ndegree = 1.5', "E-CASE-005", "obstacles.0.degree", "1.5", "range 2"),
    # curves
    ("[inflator]\nmass_flow = {time = [], value = []}", "E-CASE-005", "mass_flow", "", "at least two points"),
    ("[inflator]\nmass_flow = {time = [0.0], value = [1.0]}", "E-CASE-005", "mass_flow", "", "at least two points"),
    ("[inflator]\nmass_flow = {time = [0, 0.02, 0.01], value = [0, 2, 0]}", "E-CASE-005", "mass_flow", "", "increase"),
    ("[inflator]\nmass_flow = {time = [0, 0.01, 0.01], value = [0, 2, 0]}", "E-CASE-005", "mass_flow", "", "increase"),
    ("[inflator]\nmass_flow = {time = [0, 0.01], value = [0, 2, 0]}", "E-CASE-005", "mass_flow", "", "equally many"),
    ("[inflator]\nmass_flow = {time = [0, 0.01], value = [0, -2]}", "E-CASE-005", "mass_flow.value.1", "-2", "range 0"),
    ("[inflator]\nmass_flow = {time = [-0.01, 0.01], value = [0, 2]}", "E-CASE-005", "mass_flow.time.0", "", "range 0"),
    ("[inflator]\nmass_flow = {time = [0, 0.01], value = [0, 0]}", "E-CASE-005", "inflator", "", 'gas.model = "none"'),
    # quantities that contradict each other
    ("[inflator.gas]\nN2 = 0.5\nAr = 0.4", "E-CASE-005", "inflator.gas", "", "sum to 0.9"),
    ("[fabric]\npoisson = 0.45\nyoung_warp = 1e8\nyoung_weft = 1e9", "E-CASE-005", "fabric", "", "below the root"),
    (2 * '[[obstacles]]\nshape = "plate"\n', "E-CASE-005", "obstacles", "", "two obstacles are called plate"),
    ('[[obstacles]]\nshape = "plate"\nname = "floor [m]"', "E-CASE-005", "obstacles.0.name", "floor [m]", "letters"),
    ('[[obstacles]]\nshape = "plate"\nname = ""', "E-CASE-005", "obstacles.0.name", "''", "letters"),
    # not a case at all
    ("bag = {\n\n", "E-CASE-002", "", "", "line 1"),
    ("title = 'a'\ntitle = 'b'\n\n", "E-CASE-002", "", "", "line 2"),
    (f"x = {5000 * '9'}", "E-CASE-002", "", "", ""),
    (f"x = {2000 * '['}{2000 * ']'}", "E-CASE-002", "", "", "nested"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "code", "key", "value", "words"), REFUSED, ids=[r[0][:60] for r in REFUSED])
def test_refused_with_file_key_value_and_remedy(tmp_path, text, code, key, value, words):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        Case.load(path)
    error = caught.value
    assert error.code == code
    assert error.exit_code == 2
    assert str(path) in error.where
    assert key in error.where
    assert value in error.what
    assert words in error.why + error.remedy
    assert len(str(error)) < 1500
    assert error.__cause__ is None  # one message, no second traceback
    assert error.__suppress_context__


@pytest.mark.parametrize("name", ["none.toml", "folder", "file.toml/below.toml", "nul\0byte.toml"])
def test_a_file_that_cannot_be_read(tmp_path, name):
    (tmp_path / "folder").mkdir()
    (tmp_path / "file.toml").write_text("")
    with pytest.raises(InputError, match="E-CASE-001") as caught:
        Case.load(f"{tmp_path}/{name}")
    assert str(tmp_path) in caught.value.where


@pytest.mark.parametrize(
    ("contents", "code"),
    [
        (b'title = "\x81"', "E-CASE-002"),
        (b"\x89HDF\r\n\x1a\n", "E-CASE-002"),
        (b"# " + b"x" * 1_000_001, "E-CASE-001"),
    ],
)
def test_a_file_that_is_no_case(tmp_path, contents, code):
    (tmp_path / "data.toml").write_bytes(contents)
    with pytest.raises(InputError, match=code):
        Case.load(tmp_path / "data.toml")


@pytest.mark.parametrize("data", [None, 3, [1], "text", {1: 2}, {"bag": {1: 2}}, {"obstacles": [3]}, {"obstacles": {}}])
def test_other_things_than_a_case(data):
    with pytest.raises(InputError, match="E-CASE-00"):
        Case.from_dict(data)


# --- nothing but InputError ------------------------------------------------------------------------------------------


def every_key(data, path=()):
    """All key paths of nested dictionaries and lists."""
    items = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list | tuple) else ()
    for key, value in items:
        yield (*path, key)
        yield from every_key(value, (*path, key))


def plain(data):
    """Lists instead of tuples, so that everything can be changed."""
    if isinstance(data, dict):
        return {key: plain(value) for key, value in data.items()}
    return [plain(value) for value in data] if isinstance(data, list | tuple) else data


WHOLE = plain(
    Case.from_dict(
        {
            "obstacles": [{"shape": "plate"}, {"shape": "super-ellipsoid", "radii": [0.1, 0.2, 0.3]}],
            "inflator": {"temperature": {"time": [0, 0.05], "value": [700.0, 600.0]}},
        }
    ).to_dict()
)
PATHS = list(every_key(WHOLE))

words = st.sampled_from(
    [
        "float",
        "plate",
        "super-ellipsoid",
        "function",
        "a[0]",
        "shape",
        "time",
        "value",
        "0",
        "",
        "0.3 mm",
        "1e400 m",
        "[key]",
    ]
)
scalars = st.one_of(
    st.none(),
    st.booleans(),
    st.integers(),
    st.floats(),
    st.text(max_size=8),
    words,
    st.sampled_from([10**400, -(10**400)]),
)
nested = st.recursive(
    scalars,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=4) | words, inner, max_size=3),
    max_leaves=8,
)


@settings(max_examples=300)
@given(path=st.sampled_from(PATHS), what=nested, extra=st.booleans(), name=st.text(max_size=6) | words)
def test_a_case_with_anything_anywhere_is_accepted_or_refused(path, what, extra, name):
    data = copy.deepcopy(WHOLE)
    place = data
    for key in path[:-1]:
        place = place[key]
    if extra and isinstance(place, dict):
        place[name] = what
    else:
        place[path[-1]] = what
    with suppress(InputError):
        case = Case.from_dict(data)
        assert Case.from_dict(case.to_dict()) == case


@settings(max_examples=300)
@given(seed=st.integers(0, 2**32), edits=st.integers(1, 6))
def test_mutated_text_is_accepted_or_refused(seed, edits, tmp_path_factory):
    """A valid case with letters struck out, doubled, exchanged, or lines moved about."""
    draw = random.Random(seed)
    text = Case.from_dict(WHOLE).to_toml()
    for _ in range(edits):
        at = draw.randrange(len(text))
        kind = draw.randrange(4)
        if kind == 0:
            text = text[:at] + text[at + draw.randint(1, 12) :]
        elif kind == 1:
            text = text[:at] + draw.choice(string.printable) + text[at:]
        elif kind == 2:
            text = text[:at] + text[at : at + 30] + text[at:]
        else:
            lines = text.splitlines(keepends=True)
            lines.insert(draw.randrange(len(lines)), lines.pop(draw.randrange(len(lines))))
            text = "".join(lines)
    path = tmp_path_factory.getbasetemp() / "mutated.toml"
    path.write_text(text, encoding="utf-8")
    with suppress(InputError):
        case = Case.load(path)
        assert Case.from_dict(case.to_dict()) == case


@settings(max_examples=100)
@given(contents=st.binary(max_size=60))
def test_any_bytes_are_accepted_or_refused(contents, tmp_path_factory):
    path = tmp_path_factory.getbasetemp() / "bytes.toml"
    path.write_bytes(contents)
    with suppress(InputError):
        Case.load(path)
