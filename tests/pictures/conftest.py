"""Two runs that differ in the permeability of their fabric."""

import pytest

from billow.run.simulate import simulate


@pytest.fixture(scope="session")
def pair(small_case, tmp_path_factory):
    """Folders of two runs of the small case: plate and a free impactor."""
    place = tmp_path_factory.mktemp("pair")
    often = small_case.vary({"run.histories_per_frame": 100})  # 20 kHz
    simulate(often, place / "tight")
    simulate(often.vary({"fabric.permeability": 0.2}), place / "leaky")
    return place / "tight", place / "leaky"
