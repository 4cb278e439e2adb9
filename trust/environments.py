"""Environments that nobody meant: each must leave every answer as it is, and nothing behind.

    python -m trust.environments

A process of its own goes through a few commands of `billow` in each environment; what they write is held against what
they write in a plain one. Variables of one kind are set all at once.
"""

from __future__ import annotations

import hashlib
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

CASE = """title = "Größe ∅ µ"
[bag]
element_size = 0.06
[gas]
model = "corpuscular"
particles = 9000
[[obstacles]]
shape = "plate"
[run]
end_time = "1 ms"
frames = 1
"""
"""Letters beyond ASCII, and particles enough for parallel kernels."""

TANK = """title = "Tank"
[tank]
volume = "60 l"
[inflator]
gas = { N2 = 1.0 }
mass_flow = { time = [0, "2 ms", "20 ms"], value = [0, 2.0, 0] }
temperature = 600.0
"""

COMMANDS = (
    ("--help",),
    ("check", "case.toml"),
    ("run", "case.toml", "--out", "run", "--threads", "2"),
    ("tank", "forward", "tank.toml", "--out", "tank"),
    ("predict", "surrogate.safetensors", "--set", "permeability=0.03", "--set", "temperature=600", "--out", "p.vtkhdf"),
)


@dataclass(frozen=True)
class Surroundings:
    """variables: name -> value; None: not set. files: in the working folder, name -> content."""

    variables: dict[str, str | None]
    files: dict[str, bytes] = field(default_factory=dict)


def _all(prefix: str, names: str, value: str) -> dict[str, str]:
    return {f"{prefix}_{name}": value for name in names.split()}


HOSTILE = {
    "another compiler": Surroundings(
        {
            **_all("NUMBA", "DISABLE_JIT BOUNDSCHECK DEBUG_NRT SLP_VECTORIZE DEBUGINFO ENABLE_PROFILING", "1"),
            **_all("NUMBA", "OPT LOOP_VECTORIZE ENABLE_AVX DISABLE_INTEL_SVML LLVM_REFPRUNE_PASS", "0"),
            **_all("NUMBA", "CPU_NAME CPU_FEATURES THREADING_LAYER CACHE_LOCATOR_CLASSES CACHE_DIR", "none"),
            "LLVMLITE_ENABLE_IR_LAYER_TYPED_POINTERS": "1",
        },
        {".numba_config.yaml": b"opt: 0\ndisable_jit: 1\n"},
    ),
    "settings of a compiler that cannot be read": Surroundings({}, {".numba_config.yaml": b"- opt: [0\xff"}),
    "no threads": Surroundings(
        {
            **_all("OMP", "NUM_THREADS THREAD_LIMIT MAX_ACTIVE_LEVELS", "0"),
            **_all("OMP", "DYNAMIC NESTED SCHEDULE PLACES PROC_BIND STACKSIZE WAIT_POLICY", "none"),
            **{f"{name}_NUM_THREADS": "-1" for name in ("NUMBA", "OPENBLAS", "MKL", "GOTO")},
            "KMP_AFFINITY": "none,verbose",
        }
    ),
    "threads without end": Surroundings(
        {f"{name}_NUM_THREADS": "99999999" for name in ("NUMBA", "OMP", "OPENBLAS", "MKL", "GOTO")}
    ),
    "one thread of two": Surroundings({"OMP_THREAD_LIMIT": "1", "OMP_DYNAMIC": "true", "KMP_TEAMS_THREAD_LIMIT": "1"}),
    "other arithmetic": Surroundings(
        {
            **{"OPENBLAS_CORETYPE": "Nehalem", "OPENBLAS_VERBOSE": "2", "MKL_CBWR": "COMPATIBLE"},
            **{
                "NPY_DISABLE_CPU_FEATURES": "AVX2 none",
                "NPY_PROMOTION_STATE": "legacy",
                "ATEN_CPU_CAPABILITY": "default",
            },
            **{"SCIPY_ARRAY_API": "1", "NPY_RELAXED_STRIDES_DEBUG": "1"},
        }
    ),
    "other files": Surroundings(
        {
            **_all("HDF5", "DRIVER VOL_CONNECTOR DRIVER_CONFIG PLUGIN_PATH PLUGIN_PRELOAD USE_FILE_LOCKING", "none"),
            **{"HDF5_DEBUG": "all", "H5PY_DEFAULT_READONLY": "1"},
        }
    ),
    "other figures": Surroundings(
        {"MPLBACKEND": "none", "MATPLOTLIBRC": "/dev/null/rc", "MPLCONFIGDIR": "/dev/null/mpl"},
        {"matplotlibrc": b"backend: none\nsavefig.dpi: 7\nfont.size: 40\ntext.usetex: True\nunknown: 1\n"},
    ),
    "settings of figures that cannot be read": Surroundings({"MPLBACKEND": ""}, {"matplotlibrc": b"\xff\xfe\x00"}),
    "another Python": Surroundings(
        {
            **{"PYTHONWARNINGS": "error", "PYTHONHASHSEED": "1", "PYTHONINTMAXSTRDIGITS": "0", "PYTHON_CPU_COUNT": "1"},
            **{"PYTHONMALLOC": "debug", "PYTHONWARNDEFAULTENCODING": "1", "PYTHONASYNCIODEBUG": "1"},
        }
    ),
    "Python without assertions": Surroundings({"PYTHONOPTIMIZE": "2"}),
    "a terminal of ASCII": Surroundings(
        {**{"LC_ALL": "C", "LANG": "C", "PYTHONIOENCODING": "ascii"}, "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    ),
    "a language that is not installed": Surroundings({"LC_ALL": "xx_YY.KOI8-R", "LANG": "\udcff"}),
    "a terminal without columns": Surroundings({"COLUMNS": "0", "LINES": "0", "TERM": "dumb", "NO_COLOR": "1"}),
    "a terminal of one column": Surroundings({"COLUMNS": "1", "LINES": "1", "FORCE_COLOR": "1", "TERM": "none"}),
    "a terminal that is no number": Surroundings({"COLUMNS": "-x", "LINES": "", "UNICODE_VERSION": "x", "TERM": ""}),
    "other commands": Surroundings(
        {"_BILLOW_COMPLETE": "complete_bash", "TYPER_USE_RICH": "x", "_TYPER_STANDARD_TRACEBACK": "1"}
    ),
    "other learning": Surroundings(
        {**_all("TORCH", "LOGS SHOW_CPP_STACKTRACES", "x"), "PYTORCH_JIT": "x", "PYDANTIC_DISABLE_PLUGINS": "x"}
    ),
    "a home without a path": Surroundings({"HOME": "~", "XDG_CACHE_HOME": "cache", "XDG_CONFIG_HOME": None}),
    "no home": Surroundings({"HOME": "", "XDG_CONFIG_HOME": "", "XDG_CACHE_HOME": ""}),
    "a home that is no folder": Surroundings({"HOME": "/dev/null", "XDG_CONFIG_HOME": "/dev/null"}),
    "no folder for temporary files": Surroundings({"TMPDIR": "/dev/null", "TEMP": "", "TMP": "nowhere"}),
}


def misled(names: Iterator[str] | None = None) -> Iterator[tuple[str, str | None]]:
    """(environment, what it changed or None) for each."""
    with tempfile.TemporaryDirectory(prefix="billow-environments-") as folder:
        plain, problem = _answers(Path(folder, "plain"), Surroundings({}))
        if problem:
            raise RuntimeError(f"in a plain environment: {problem}")
        for number, name in enumerate(names or HOSTILE):
            found, problem = _answers(Path(folder, str(number)), HOSTILE[name])
            changed = sorted(key for key in plain.keys() | found.keys() if plain.get(key) != found.get(key))
            yield name, problem or (f"changed: {', '.join(changed)}" if changed else None)


def _answers(place: Path, surroundings: Surroundings) -> tuple[dict[str, str], str | None]:
    """What is written in an environment, name -> digest; and what was said that should not be, or None."""
    place.mkdir()
    for name, content in surroundings.files.items():
        (place / name).write_bytes(content)
    variables = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, map(os.path.abspath, sys.path)))}
    for name, value in surroundings.variables.items():
        variables.pop(name, None)
        if value is not None:
            variables[name] = value
    report = place.with_name(place.name + ".json")
    program = [sys.executable, "-c", "from trust.environments import commands; commands()", str(report)]
    done = subprocess.run(program, cwd=place, env=variables, capture_output=True, timeout=600, check=False)
    said = done.stderr.decode(errors="replace").strip()
    if done.returncode or said:
        return {}, f"exit {done.returncode}: {said[-1500:]}"
    return json.loads(report.read_text()), None


def commands() -> None:
    """Run in the environment: every command, then the digest of every file it left, and every exit code."""
    from billow.cli.main import main
    from trust.small_surrogate import small_surrogate

    found: dict[str, str] = {}
    present = set(Path().iterdir())
    Path("case.toml").write_text(CASE, encoding="utf-8")
    Path("tank.toml").write_text(TANK, encoding="utf-8")
    small_surrogate().save(Path("surrogate.safetensors"))
    for command in COMMANDS:
        sys.argv = ["billow", *command]
        try:
            main()
        except SystemExit as end:
            found[" ".join(command)] = str(end.code)
    from trust.bits import arrays_of

    for name, array in arrays_of(Path("run")).items():
        array = array.astype("S") if array.dtype.hasobject else array
        found[f"run: {name}"] = hashlib.sha256(array.tobytes()).hexdigest()
    for path in sorted(set(Path().iterdir()) - present):
        found[str(path)] = "there"
    for path in (*Path("tank").iterdir(), Path("run/histories.csv"), Path("p.vtkhdf")):
        found[str(path)] = hashlib.sha256(path.read_bytes()).hexdigest()
    Path(sys.orig_argv[-1]).write_text(json.dumps(found), encoding="ascii")


def main() -> int:
    failed = 0
    for name, problem in misled(sys.argv[1:] or None):
        failed += problem is not None
        print(f"{'MISS' if problem else 'ok':5} {name}{': ' + problem if problem else ''}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
