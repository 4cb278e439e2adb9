"""Pages made from code say what the code says."""

import importlib.util
from pathlib import Path

import pytest

DOCS = Path(__file__).parents[2] / "docs"


@pytest.mark.parametrize("generator", sorted(path.name for path in DOCS.glob("make_*.py")))
def test_a_generated_page_is_up_to_date(generator):
    spec = importlib.util.spec_from_file_location(generator.removesuffix(".py"), DOCS / generator)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    assert module.TARGET.read_text(encoding="utf-8") == module.render(), "run `make docs`"
