"""Who may import whom. Redraw the picture in docs/architecture.md before bending a rule here."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[2] / "src" / "billow"

BASE = {"errors", "units", "compiled"}
MAY_IMPORT = {
    "errors": set(),
    "error_catalogue": {"errors"},
    "units": {"errors"},
    "compiled": set(),
    "geometry": BASE,
    "fabric": BASE | {"geometry"},
    "gas": BASE | {"geometry"},
    "contact": BASE | {"geometry"},
    "impactor": BASE | {"geometry"},
    "dynamics": BASE | {"geometry", "fabric", "gas", "contact", "impactor"},
    "case": BASE | {"geometry", "fabric", "gas", "contact", "impactor", "dynamics"},
    "results": {"errors", "units", "geometry"},
    "rom": {"errors", "units", "geometry", "results", "injury", "plot_style"},
    "study": {"errors", "units", "geometry", "results", "case", "simulate"},
    "checkpoint_file": {"errors", "dynamics", "results"},
    "history_columns": {"dynamics", "fabric", "gas", "impactor"},
    "interrupts": set(),
    "plot_style": set(),
    "recorder": {
        *("errors", "contact", "dynamics", "gas", "case", "results"),
        *("checkpoint_file", "history_columns", "interrupts"),
    },
    "simulate": {"errors", "dynamics", "case", "results", "checkpoint_file", "interrupts", "recorder"},
    "converge": {"errors", "case", "results", "simulate", "rom", "plot_style"},
    "tank": {"errors", "units", "compiled", "gas", "case", "results", "plot_style"},
    "coupon": BASE | {"geometry", "fabric", "gas", "dynamics", "case", "results"},
    "injury": {"errors", "compiled", "results"},
    "verification": BASE
    | {"geometry", "fabric", "gas", "contact", "impactor", "dynamics", "case", "simulate", "results"}
    | {"tank", "coupon", "injury"},
}


def imported(path: Path) -> set[str]:
    """Top-level parts of billow that a file imports."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            names = [f"{node.module}.{a.name}" for a in node.names] if node.module == "billow" else [node.module]
        elif isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        else:
            continue
        found |= {name.split(".")[1] for name in names if name.startswith("billow.")} - {"__version__"}
    return found


def test_arrows_point_downwards():
    wrong = []
    for path in sorted(PACKAGE.rglob("*.py")):
        part = path.relative_to(PACKAGE).parts[0].removesuffix(".py")
        if part in ("cli", "commands", "demo", "check", "prediction", "terminal", "__init__"):
            continue  # on top of everything
        allowed = MAY_IMPORT[part] | {part}
        wrong += [f"{path.relative_to(PACKAGE)} imports {name}" for name in sorted(imported(path) - allowed)]
    assert not wrong, "\n".join(wrong)


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
    assert users in ([], ["rom/network.py"])
