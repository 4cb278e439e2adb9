"""What code cites is there: pages of docs/, and headings of these pages."""

import re
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CITATION = re.compile(r"docs/([a-z_]+\.md)(?:, ([A-Z].{0,80}))?")
"""A page, and after a comma the heading meant: "docs/theory.md, Membrane step"."""


def texts(*folders: str) -> list[tuple[Path, str]]:
    """Files of the folders, each as one line: a citation may be broken anywhere."""
    paths = sorted(path for folder in folders for path in (ROOT / folder).rglob("*.py") if path != Path(__file__))
    return [(path, " ".join(path.read_text(encoding="utf-8").replace("\n#", "\n").split())) for path in paths]


def missing(citation: re.Match) -> str | None:
    """What the citation names and docs/ lacks."""
    page, cited = ROOT / "docs" / citation[1], citation[2]
    if not page.is_file():
        return f"docs/{citation[1]}"
    headings = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return None if cited is None or any(cited.startswith(heading) for heading in headings) else citation[0]


def test_pages_and_headings_that_the_code_cites_exist():
    cited = [(path, citation) for path, text in texts("src") for citation in CITATION.finditer(text)]
    assert len([c for _, c in cited if c[2]]) > 5
    wrong = [f"{path.relative_to(ROOT)}: {missing(citation)}" for path, citation in cited if missing(citation)]
    assert not wrong, "\n".join(wrong)


@pytest.mark.parametrize("text", ["docs/nowhere.md", "docs/theory.md, Phlogiston"])
def test_a_citation_of_what_is_not_there_is_found(text):
    assert missing(CITATION.search(text)) == text


def test_nothing_cites_notes_that_are_not_in_the_repository():
    users = [
        path.relative_to(ROOT) for path, text in texts("src", "tests", "trust", "benchmarks") if "physics notes" in text
    ]
    assert users == []
