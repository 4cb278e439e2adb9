"""The rooms of the reduced-order model import downwards only: an answer needs less than learning, learning less than
judging."""

import subprocess
import sys

import pytest
from test_layering import PACKAGE, imported

MAY_IMPORT = {
    "surrogate": set(),
    "learn": {"surrogate"},
    "judge": {"surrogate", "learn"},
    "coupled": {"surrogate", "learn", "judge"},
}
"""Room of `rom` -> rooms of `rom` it may import besides itself."""

HEAVY = ("torch", "scipy", "matplotlib", "numba", "h5py", "jinja2")


@pytest.mark.parametrize("room", sorted(MAY_IMPORT))
def test_arrows_between_rooms_point_downwards(room):
    wrong = []
    for path in sorted((PACKAGE / "rom" / room).rglob("*.py")):
        rooms = {name.split(".")[1] for name in imported(path) if name.startswith("rom.")}
        wrong += [f"{path.relative_to(PACKAGE)} imports rom.{other}" for other in rooms - MAY_IMPORT[room] - {room}]
    assert not wrong, "\n".join(sorted(wrong))


def test_every_room_has_its_rule():
    rooms = {path.name for path in (PACKAGE / "rom").iterdir() if any(path.glob("*.py"))}
    assert rooms == set(MAY_IMPORT)
    assert [path.name for path in (PACKAGE / "rom").glob("*.py")] == ["__init__.py"]


def test_the_reproduction_is_imported_by_its_command_alone():
    users = {path for path in PACKAGE.rglob("*.py") if any(n.startswith("reproductions.") for n in imported(path))}
    outside = {str(path.relative_to(PACKAGE)) for path in users if "reproductions" not in path.parts}
    assert outside == {"cli/paper.py"}


def test_a_surrogate_answers_with_numpy_alone():
    loaded = f"import sys; import billow.rom.surrogate.surrogate; print(sorted(set({HEAVY}) & set(sys.modules)))"
    process = subprocess.run([sys.executable, "-c", loaded], capture_output=True, text=True, check=True)
    assert process.stdout.strip() == "[]"
