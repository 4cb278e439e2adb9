"""What --set takes: assignments, and a file of values as the explorer saves it."""

import pytest

from billow.base.errors import InputError
from billow.cli.options import parse_settings


def test_a_design_of_the_explorer_and_assignments_after_it(tmp_path):
    path = tmp_path / "design.toml"
    path.write_text(
        '# Driver bag\n[design]\npermeability = 0.025  # -\ninflator_temperature = 650.0  # K\ngas = "argon"\n'
    )
    found = parse_settings([f"@{path}", "permeability=0.03"])
    assert found == {"permeability": 0.03, "inflator_temperature": 650.0, "gas": "argon"}


@pytest.mark.parametrize("text", ["", "[design]\n", "[design]\na = [1.0]\n", "not toml"])
def test_a_file_that_is_no_design_is_refused(tmp_path, text):
    path = tmp_path / "design.toml"
    path.write_text(text)
    with pytest.raises(InputError) as caught:
        parse_settings([f"@{path}"])
    assert caught.value.code == "E-CLI-001"
    with pytest.raises(InputError):
        parse_settings(["@nowhere.toml"])
