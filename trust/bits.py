"""The bits of a set of runs, held against those recorded: what a change of structure must leave as it is.

    python -m trust.bits record     # before the first edit: writes trust/bits.json
    python -m trust.bits            # after it: every quantity that is not the same bits is named, exit code 1

The digests are those of one machine: another processor may round otherwise, so this is a tool for whoever changes the
code and no test. Only public interfaces are used: results are read from disk.
"""

from __future__ import annotations

import hashlib
import json
import sys
import tempfile
from collections.abc import Callable, Iterator
from pathlib import Path

import h5py
import numpy as np

import billow
from billow.run.simulate import resume, simulate

RECORD = Path(__file__).parent / "bits.json"

BODY = {
    "shape": "super-ellipsoid", "name": "impactor", "radii": 0.175, "degree": 3.0, "clearance": 0.05, "slope": 5e5,
    "locked": False, "velocity": [0.0, 0.5, -2.0], "angle_about_x": 20.0,
}  # fmt: skip
DRIVER = {
    "bag": {"element_size": 0.05},
    "fabric": {"permeability": 0.0275},
    "obstacles": [{"shape": "plate"}, BODY],
    "run": {"end_time": 0.015, "frames": 3, "histories_per_frame": 4},
}
CHAMBERS = {
    "bag": {
        "shape": "rectangular", "length": 0.6, "width": 0.3, "chambers": 2, "mouth_radius": 0.04,
        "element_size": 0.035, "vents": {"diameter": 0.03, "panel": "front", "chambers": [2]},
    },
    "inflator": {"jets": {"count": 4}},
    "gas": {"heat_transfer": 50.0},
    "run": {"end_time": 0.010, "frames": 2, "histories_per_frame": 5, "gravity": [0.0, 0.0, -9.81]},
}  # fmt: skip
PARTICLES = {
    "bag": {"element_size": 0.05, "initial_gap": 0.02},
    "gas": {"model": "corpuscular", "particles": 4000, "switch_time": 0.006},
    "obstacles": [{"shape": "plate"}, BODY],
    "run": {
        "end_time": 0.009, "frames": 3, "histories_per_frame": 3, "particle_times": [0.004],
        "sensors": [{"name": "middle", "position": [0.0, 0.0, 0.02]}],
    },
}  # fmt: skip
LOCKED = DRIVER | {
    "obstacles": [{"shape": "plate"}, BODY | {"locked": True, "velocity": [0.0, 0.0, 0.0], "slope": 2e4}],
    "bag": {"element_size": 0.06, "straps": {"count": 4, "failure": 300.0}},
    "fabric": {"self_contact": True},
}
CASES = {
    "uniform pressure, jets, contact, free body": DRIVER,
    "several chambers, heat, gravity": CHAMBERS,
    "particles, then uniform": PARTICLES,
    "self-contact, straps that tear, locked body": LOCKED,
    "curves": DRIVER | {"fabric": {"law": "curves"}},
    "curves-shear": DRIVER | {"fabric": {"law": "curves-shear"}},
    "no gas": DRIVER | {"gas": {"model": "none"}},
}
"""Name -> what the case says."""

RESTARTED = ("uniform pressure, jets, contact, free body", "particles, then uniform")


def runs(folder: Path) -> Iterator[tuple[str, Callable[[], dict[str, np.ndarray]]]]:
    """Name -> what makes its arrays."""
    for name, told in CASES.items():
        yield name, lambda told=told, name=name: arrays_of(run(told, folder / name.replace(" ", "_")))
    for name in RESTARTED:
        yield f"{name}, restarted", lambda name=name: arrays_of(restarted(CASES[name], folder / f"again_{len(name)}"))
    yield "mesh bag with birth ramp", lambda: arrays_of(run(stretched_mesh(folder), folder / "mesh"))
    for law in ("linear", "curves", "curves-shear"):
        yield f"test bench, {law}", lambda law=law: bench(law)


def run(told: dict, folder: Path) -> Path:
    simulate(billow.Case.from_dict(told), folder)
    return folder


def restarted(told: dict, folder: Path) -> Path:
    """The same run, stopped half-way and resumed."""

    def stop_half_way(progress) -> None:
        if progress.time >= 0.5 * progress.end:
            (folder.with_name(folder.name + ".partial") / "STOP").touch()

    try:
        simulate(billow.Case.from_dict(told), folder, progress=stop_half_way)
    except KeyboardInterrupt:
        resume(folder)
    return folder


def stretched_mesh(folder: Path) -> dict:
    """A pillow of two discs that starts 5 % longer than its cut along x, with a birth time."""
    rings, around = 6, 24
    places = [(0.0, 0.0)]
    for ring in range(1, rings + 1):
        angle = 2.0 * np.pi * np.arange(around) / around
        places += list(zip(0.2 * ring / rings * np.cos(angle), 0.2 * ring / rings * np.sin(angle), strict=True))
    flat = np.array(places)
    half = [(0, 1 + k, 1 + (k + 1) % around) for k in range(around)]
    for ring in range(1, rings):
        inner, outer = 1 + (ring - 1) * around, 1 + ring * around
        for k in range(around):
            n = (k + 1) % around
            half += [(inner + k, outer + k, outer + n), (inner + k, outer + n, inner + n)]
    lower = {k: k + len(flat) if k <= (rings - 1) * around else k for k in range(len(flat))}
    triangles = half + [(lower[a], lower[c], lower[b]) for a, b, c in half]
    lift = 0.004 * (1.0 - (np.linalg.norm(flat, axis=1) / 0.2) ** 2)
    top = np.column_stack([flat, lift])
    both = np.concatenate([top, (top * [1.0, 1.0, -1.0])[: (rings - 1) * around + 1]])
    part = [1] * len(half) + [2] * len(half)
    for name, points in (("reference", both), ("start", both * [1.05, 1.0, 1.0])):
        lines = ["# vtk DataFile Version 3.0", name, "ASCII", "DATASET UNSTRUCTURED_GRID"]
        lines += [f"POINTS {len(points)} double", *(" ".join(map(repr, map(float, p))) for p in points)]
        lines += [f"CELLS {len(triangles)} {4 * len(triangles)}"]
        lines += [f"3 {a} {b} {c}" for a, b, c in triangles]
        lines += [f"CELL_TYPES {len(triangles)}", *["5"] * len(triangles), f"CELL_DATA {len(triangles)}"]
        lines += ["SCALARS part int 1", "LOOKUP_TABLE default", *map(str, part)]
        (folder / f"{name}.vtk").write_text("\n".join(lines) + "\n", encoding="utf-8")
    return {
        "bag": {
            "shape": "mesh", "start": str(folder / "start.vtk"), "reference": str(folder / "reference.vtk"),
            "birth_time": 0.001,
            "parts": [{"name": "front", "number": 1}, {"name": "rear", "number": 2, "seen_from": "inside"}],
        },
        "inflator": {"jets": {"count": 0}},
        "obstacles": [],
        "run": {"end_time": 0.004, "frames": 2, "histories_per_frame": 4},
    }  # fmt: skip


def arrays_of(folder: Path) -> dict[str, np.ndarray]:
    """Every column of histories.csv and every array of the frames."""
    header, *rows = (folder / "histories.csv").read_text(encoding="utf-8").splitlines()
    table = np.array([[float(cell) for cell in row.split(",")] for row in rows])
    found = {f"histories: {name}": table[:, k].copy() for k, name in enumerate(header.split(","))}
    for path in sorted(folder.glob("*.vtkhdf")):
        with h5py.File(path) as file:

            def keep(name, item, path=path):
                if isinstance(item, h5py.Dataset):
                    found[f"{path.name}: {name}"] = item[()]

            file.visititems(keep)
    return found


def bench(law: str) -> dict[str, np.ndarray]:
    """A picture frame on the test bench."""
    import dataclasses

    specimen, fabric, run_test = _bench_parts(law)
    measured = run_test(specimen, fabric, 0.4, duration=0.01)
    return {name: np.asarray(value) for name, value in dataclasses.asdict(measured).items() if name != "curves"}


def _bench_parts(law: str):
    from billow.apps.coupon.bench import run_test
    from billow.apps.coupon.specimen import PictureFrame
    from billow.case.fabric.build_fabric import build_fabric

    case = billow.Case.from_dict({"fabric": {"law": law}})
    return PictureFrame(0.1, 0.02), build_fabric(case.fabric), run_test


def digests(arrays: dict[str, np.ndarray]) -> dict[str, str]:
    """Name -> start of the SHA-256 of its bits."""
    return {
        name: hashlib.sha256(repr((a.shape, a.dtype.str)).encode() + _bytes(a)).hexdigest()[:16]
        for name, a in sorted(arrays.items())
    }


def _bytes(array: np.ndarray) -> bytes:
    if array.dtype.kind == "O":
        return repr(array.tolist()).encode()
    return (array + 0 if array.dtype.kind == "f" else array).tobytes()  # -0.0 counts as 0.0


def main() -> int:
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name, make in runs(Path(folder)):
            found[name] = digests(make())
            print(f"{name}: {len(found[name])} quantities", flush=True)
    if sys.argv[1:] == ["record"]:
        RECORD.write_text(json.dumps(found, indent=1) + "\n", encoding="utf-8")
        return 0
    before = json.loads(RECORD.read_text(encoding="utf-8"))
    lines = []
    for name in sorted(set(before) | set(found)):
        old, new = before.get(name, {}), found.get(name, {})
        lines += [f"{name}: {what} is gone" for what in sorted(set(old) - set(new))]
        lines += [f"{name}: {what} is new" for what in sorted(set(new) - set(old))]
        lines += [f"{name}: {what} differs" for what in sorted(set(old) & set(new)) if old[what] != new[what]]
    print("\n".join(lines) or "same bits")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
