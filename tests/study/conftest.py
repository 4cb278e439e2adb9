import fake_solver
import pytest

from billow.study import study as study_module
from billow.study.study import Study


@pytest.fixture
def definition(tmp_path, monkeypatch):
    """A study.toml around the fake case."""
    monkeypatch.setattr(study_module, "_load_case", fake_solver.FakeCase.load)
    monkeypatch.setattr(study_module, "_outline", fake_solver.outline)
    monkeypatch.setattr(study_module, "_recorded", fake_solver.recorded)
    (tmp_path / "square.toml").write_text(fake_solver.CASE)
    path = tmp_path / "definition.toml"
    path.write_text(fake_solver.STUDY)
    return path


@pytest.fixture
def study(definition, tmp_path):
    return Study.create(definition, tmp_path / "study")
