"""`billow plot` and `billow render` on runs: formats, errors, what is drawn, and hostile names."""

import io
import shutil
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image
from typer.testing import CliRunner

from billow.cli.main import app
from billow.pictures.deployment import HOLE, Deployment, colouring_of
from billow.pictures.fields import Field, read_field
from billow.pictures.film import gif
from billow.pictures.shot import Shot
from billow.results.result import Result
from billow.results.run_file import write_run_file

BEGINS = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF", "gif": b"GIF89a"}


def billow(*words, code=0):
    done = CliRunner().invoke(app, [str(word) for word in words])
    if code == 0:
        assert done.exception is None, done.exception
        return done.output
    assert done.exception.code == code, done.exception
    return done.exception


# --- plot ------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_name_says_the_format(pair, tmp_path, kind):
    out = tmp_path / "new" / f"curves.{kind.upper()}"
    billow("plot", *pair, "--out", out)
    assert out.read_bytes().startswith(BEGINS[kind])
    billow("plot", pair[0], "--out", out)  # its own picture may be replaced


@pytest.mark.parametrize("kind", ["png", "svg", "pdf"])
def test_the_same_numbers_give_the_same_bytes(pair, tmp_path, kind):
    for name in ("one", "two"):
        billow("plot", *pair, "-q", "pressure", "--out", tmp_path / f"{name}.{kind}")
    assert (tmp_path / f"one.{kind}").read_bytes() == (tmp_path / f"two.{kind}").read_bytes()


def test_a_picture_that_is_not_ours_is_not_replaced(pair, tmp_path):
    out = tmp_path / "mine.png"
    Image.new("RGB", (50, 50)).save(out)
    before = out.read_bytes()
    for command in ("plot", "render"):
        billow(command, pair[0], "--out", out, code="E-RES-024")
    assert out.read_bytes() == before


@pytest.mark.parametrize("command", ["plot", "render"])
@pytest.mark.parametrize("name", ["curves", "curves.jpg", "curves.csv", ".png", "png"])
def test_other_endings_are_refused_before_anything_is_read(tmp_path, command, name):
    assert ".png" in billow(command, tmp_path / "none", "--out", tmp_path / name, code="E-PIC-008").why
    assert not list(tmp_path.iterdir())


def test_runs_that_lack_a_quantity_are_named_and_the_others_drawn(pair, tmp_path):
    table = tmp_path / "test.csv"
    table.write_text("time [ms],head acceleration z [g]\n" + "".join(f"{0.1 * k},{k}\n" for k in range(200)))
    said = billow("plot", pair[0], table, "-q", "pressure", "-q", "head_acceleration_z", "--out", tmp_path / "a.svg")
    assert "pressure is not in test.csv" in said
    assert f"head_acceleration_z is not in {pair[0].name}" in said


def test_a_quantity_that_nobody_has_is_refused(pair, tmp_path):
    error = billow("plot", *pair, "-q", "impactor_velocty", "--out", tmp_path / "a.png", code="E-PIC-009")
    assert "impactor_velocity" in error.remedy
    billow("plot", pair[0], "--cfc", 300, "--out", tmp_path / "a.png", code="E-INJ-002")
    billow("plot", pair[0], "--unit", "kpa", "--out", tmp_path / "a.png", code="E-PIC-003")
    billow("plot", pair[0] / "fabric.vtkhdf", "--out", tmp_path / "a.png", code="E-PIC-006")
    billow("plot", tmp_path / "none", "--out", tmp_path / "a.png", code="E-RES-001")
    assert not list(tmp_path.iterdir())


def test_texts_in_a_drawing_are_those_of_the_curves(pair, tmp_path):
    out = tmp_path / "a.svg"
    billow("plot", *pair, "-q", "impactor_velocity", "-q", "pressure", "--cfc", 180, "--unit", "bar", "--out", out)
    text = out.read_text()
    for part in ("impactor velocity, resultant, CFC 180", "[m/s]", "[bar]", "time [ms]", *(p.name for p in pair)):
        assert f"<!-- {part} -->" in text, part


@pytest.mark.parametrize(
    "name", ["$x_{", "_hidden", "a" * 200, "<b>&amp;", "tab\tand\nline", "ünïcode 日本", "--", "%s{0}"]
)
def test_hostile_names_of_runs_and_titles_are_drawn_as_they_are(pair, tmp_path, name):
    copies = [shutil.copytree(pair[0], tmp_path / k / name) for k in "ab"]
    billow("plot", *copies, "-q", "pressure", "--out", tmp_path / "a.png", f"--title={name}")
    billow("render", copies[0], "--size", "200x160", "--out", tmp_path / "b.svg", f"--title={name}")


# --- render ------------------------------------------------------------------------


@pytest.mark.parametrize("kind", ["png", "svg", "pdf", "gif"])
def test_pictures_and_films_are_written_in_the_format_of_their_name(pair, tmp_path, kind):
    out = tmp_path / f"bag.{kind}"
    for _ in range(2):
        billow("render", pair[0], "--out", out, "--size", "240x200", "--field", "pressure")
    assert out.read_bytes().startswith(BEGINS[kind])


def test_a_picture_has_the_size_that_was_asked_for(pair, tmp_path):
    billow("render", pair[0], "--out", tmp_path / "a.png", "--size", "333x222")
    assert Image.open(tmp_path / "a.png").size == (333, 222)


def test_a_film_shows_every_frame_and_repeats(pair, tmp_path):
    billow("render", pair[0], "--out", tmp_path / "a.gif", "--size", "200x160")
    film = Image.open(tmp_path / "a.gif")
    assert film.n_frames == len(Result.open(pair[0]).times) == 4
    assert film.info["loop"] == 0
    billow("render", pair[0], "--out", tmp_path / "b.gif", "--size", "200x160", "--times", "4 ms,11 ms")
    assert Image.open(tmp_path / "b.gif").n_frames == 2


@pytest.mark.parametrize(
    ("words", "code"),
    [
        (["--field", "presure"], "E-PIC-002"),
        (["--section", "y"], "E-PIC-001"),
        (["--unit", "x"], "E-PIC-003"),
        (["--view", "back"], "E-CLI-007"),
        (["--size", "9x9"], "E-CLI-007"),
        (["--size", "999999x999"], "E-CLI-007"),
        (["--size", "²x²"], "E-CLI-007"),
        (["--times", "soon"], "E-CLI-007"),
        (["--times", ""], "E-CLI-007"),
        (["--field", "pressure", "--range", "1"], "E-CLI-007"),
        (["--field", "pressure", "--range", "5,1"], "E-CLI-007"),
        (["--field", "pressure", "--range", "0,1 K"], "E-CLI-007"),
    ],
)
def test_what_cannot_be_drawn_is_refused_with_a_code(pair, tmp_path, words, code):
    billow("render", pair[0], "--out", tmp_path / "a.png", *words, code=code)
    assert not list(tmp_path.iterdir())


def test_a_table_of_curves_has_no_bag(tmp_path):
    table = tmp_path / "test.csv"
    table.write_text("time [ms],force [N]\n0,1\n1,2\n")
    billow("render", table, "--out", tmp_path / "a.png", code="E-PIC-006")


def test_without_ffmpeg_there_is_no_mp4(pair, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    billow("render", pair[0], "--out", tmp_path / "a.mp4", "--size", "200x160", code="E-PIC-004")


@pytest.mark.parametrize("ends", [0, 1])
def test_films_go_to_ffmpeg_as_they_are_and_its_failure_is_told(pair, tmp_path, monkeypatch, ends):
    """A stand-in notes what it is given."""
    program = tmp_path / "ffmpeg"
    program.write_text(
        f"#!{sys.executable}\nimport sys\ndata = sys.stdin.buffer.read()\n"
        f"open(sys.argv[-1], 'wb').write(b'Billow' + repr((sys.argv, len(data))).encode())\n"
        f"print('no encoder', file=sys.stderr)\nsys.exit({ends})\n"
    )
    program.chmod(0o755)
    monkeypatch.setenv("PATH", str(tmp_path))
    out = tmp_path / "a.mp4"
    if ends:
        assert "no encoder" in billow("render", pair[0], "--out", out, "--size", "201x161", code="E-PIC-005").why
        assert not out.exists()
        return
    billow("render", pair[0], "--out", out, "--size", "201x161", "--speed", "10")
    said = out.read_text()
    assert "202x162" in said  # H.264 needs even numbers
    assert "'10'" in said
    assert said.endswith(f"{202 * 162 * 3 * 4})")


def test_a_palette_keeps_the_colours_of_all_pictures():
    pictures = [np.full((40, 40, 3), colour, np.uint8) for colour in ([200, 0, 0], [0, 200, 0], [0, 0, 200])]
    film = Image.open(io.BytesIO(gif(pictures, 10.0)))
    for k, picture in enumerate(pictures):
        film.seek(k)
        np.testing.assert_array_equal(np.asarray(film.convert("RGB")), picture)


# --- what is shown ------------------------------------------------------------------------


def test_the_camera_stands_still_and_colours_keep_their_meaning(pair):
    result = Result.open(pair[0])
    colouring = colouring_of(read_field(result.fabric, "displacement"))
    deployment = Deployment(result.fabric, result, colouring)
    early, late = (Shot.at([deployment], times) for times in ([0.0, 0.015], [0.015, 0.0]))
    np.testing.assert_array_equal(early.camera(100, 80).centre, late.camera(100, 80).centre)
    assert early.camera(100, 80).scale == late.camera(100, 80).scale
    largest = np.linalg.norm(result.displacement, axis=2).max()
    assert (colouring.low, colouring.high) == (0.0, pytest.approx(largest))
    np.testing.assert_array_equal(np.unique(colouring.colours(0), axis=0), colouring.colours(0)[:1])


def test_frames_are_those_nearest_to_the_times_each_once(pair):
    result = Result.open(pair[0])
    shot = Shot.at([Deployment(result.fabric, result)], [0.0, 0.0051, 0.0049, 9.0])
    assert shot.frames == [[0], [1], [3]]
    np.testing.assert_allclose(shot.times, [0.0, 0.005, 0.015])


def test_vents_and_mouths_are_dark_and_obstacles_are_there(pair):
    result = Result.open(pair[0])
    deployment = Deployment(result.fabric, result)
    towards = np.array([0.5, -0.5, 0.7])
    bag, *others = deployment.bodies(-1, towards)
    holes = [name.startswith(("vent", "mouth")) for name in result.fabric.part_names]
    is_hole = np.array(holes)[result.fabric.part]
    assert is_hole.any()
    np.testing.assert_array_equal((bag.colours == HOLE).all(axis=(1, 2)), is_hole)
    assert len(others) == 3  # straps, plate and impactor
    assert len(deployment.bodies(-1, -towards)) == 3  # from below, the plate would hide the bag
    bars = result.straps.points(-1)
    for straps in (others[0], deployment.bodies(-1, -towards)[1]):
        np.testing.assert_allclose(straps.points.mean(axis=0), bars.mean(axis=0), atol=1e-6)
    impactor = others[2]
    centre = result.body("impactor").centre[-1]
    np.testing.assert_allclose(0.5 * (impactor.points.min(axis=0) + impactor.points.max(axis=0)), centre, atol=1e-3)


def test_a_deployment_without_a_run_is_drawn_alone(pair, tmp_path):
    shutil.copy(pair[0] / "fabric.vtkhdf", tmp_path / "predicted.vtkhdf")
    billow("render", tmp_path / "predicted.vtkhdf", "--out", tmp_path / "a.png", "--size", "200x160")


def test_a_run_with_a_hostile_title_is_drawn(pair, tmp_path):
    folder = shutil.copytree(pair[0], tmp_path / "run")
    record = Result.open(folder).record
    kept = {key: value for key, value in record.items() if key not in ("files", "record_sha256")}
    write_run_file(folder, kept | {"title": "$\\frac{ \x1b[31m</script>" * 20})
    billow("render", folder, "--out", tmp_path / "a.png", "--size", "200x160")
    billow("plot", folder, "--out", tmp_path / "b.png")


@pytest.mark.parametrize("command", ["check", "run"])
def test_commands_that_do_not_draw_do_not_load_matplotlib(command):
    loaded = f"import sys; sys.argv = ['billow', '{command}', '--help']; import billow.cli.main as m\n"
    loaded += "try: m.main()\nexcept SystemExit: print('matplotlib' in sys.modules, 'PIL' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "False False"


def test_a_few_folded_triangles_do_not_take_all_colours():
    even = np.linspace(2.0, 5.0, 4000, dtype=np.float32).reshape(2, 2000)
    assert Field("stress", "Pa", False, even).usual_limits == (2.0, 5.0)
    spoiled = even.copy()
    spoiled[1, 3] = 90.0
    spoiled[0, 4] = np.nan
    low, high = Field("stress", "Pa", False, spoiled).usual_limits
    assert low == 2.0
    assert 4.9 < high <= 5.0
    nothing = Field("stress", "Pa", False, np.full((1, 3), np.nan, np.float32))
    assert nothing.usual_limits == (0.0, 0.0)
