"""Who may import whom. Redraw the picture in docs/architecture.md before bending a rule here."""

import ast
import graphlib
from functools import cache
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "billow"

PARTS = {
    *("parts.fabric", "parts.straps", "parts.self_contact", "parts.layers", "parts.bodies", "parts.gas"),
    "parts.driven_nodes",
    "parts.tear_seams",
}
"""Siblings: none imports another; they meet in solver/step.py."""

MODEL = {"base", "geometry", "solver", "parts"} | PARTS
MAY_IMPORT = {
    "base": set(),
    "geometry": {"base"},
    **{part: {"base", "geometry"} for part in PARTS},
    "parts": {"base", "geometry"},
    "solver": MODEL,
    "case": MODEL,
    "results": {"base", "geometry"},
    "injury": {"base", "results"},
    "pictures": {"base", "geometry", "results", "injury"},
    "run": MODEL | {"case", "results"},
    "study": {"base", "geometry", "results", "injury", "case", "run", "decks"},
    "rom": {"base", "geometry", "results", "injury", "pictures"},
    "pages": {"base", "geometry", "results", "injury", "pictures", "rom"},
    "design": {"base", "geometry", "results", "injury", "study", "rom"},
    "reproductions": {"base", "results", "injury", "pictures", "rom"},
    "decks": MODEL | {"case", "results"},
    "apps": MODEL | {"case", "results", "injury", "run", "pictures", "rom"},
}
"""Room -> rooms it may import besides itself; `cli` is on top of everything."""


@cache
def imported(path: Path) -> frozenset[str]:
    """Modules of billow that a file imports, without the package's name."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{a.name}" for a in node.names]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        found |= {name.removeprefix("billow.") for name in names if name.startswith("billow.")} - {"__version__"}
    return frozenset(found)


def room(module: str) -> str:
    """The room of a module: its first folder, in `parts` the part."""
    first, *rest = module.split(".")
    return f"{first}.{rest[0]}" if first == "parts" and rest and f"{first}.{rest[0]}" in PARTS else first


def test_no_file_imports_itself_through_others():
    files = {".".join(path.relative_to(PACKAGE).with_suffix("").parts): path for path in PACKAGE.rglob("*.py")}
    graph = {
        name: {module for found in imported(path) for module in (found, found.rpartition(".")[0]) if module in files}
        for name, path in files.items()
    }
    tuple(graphlib.TopologicalSorter(graph).static_order())  # CycleError names the circle


def test_arrows_point_downwards():
    wrong = []
    for path in sorted(PACKAGE.rglob("*.py")):
        mine = room(".".join(path.relative_to(PACKAGE).with_suffix("").parts))
        if mine in ("cli", "__init__", "__main__"):
            continue  # on top of everything
        allowed = MAY_IMPORT.get(mine, set()) | {mine, "parts"}
        rooms = {room(name) for name in imported(path)}
        wrong += [f"{path.relative_to(PACKAGE)} imports {name}" for name in sorted(rooms - allowed)]
    assert not wrong, "\n".join(wrong)


def test_nothing_imports_the_reproductions_but_commands():
    users = [p for p in PACKAGE.rglob("*.py") if any(n.startswith("reproductions") for n in imported(p))]
    assert {p.relative_to(PACKAGE).parts[0] for p in users} <= {"cli", "reproductions"}


def test_torch_only_where_networks_are_trained():
    users = [
        str(path.relative_to(PACKAGE))
        for path in PACKAGE.rglob("*.py")
        if any(
            (isinstance(node, ast.Import) and any(a.name.split(".")[0] == "torch" for a in node.names))
            or (isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "torch")
            for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        )
    ]
    assert users in ([], ["rom/learn/network.py"])
