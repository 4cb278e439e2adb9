"""A study as a data set for others: a folder that says what it is, in formats that need no Billow to be read.

F/README.md             the card: what, how made, units, precision, verdicts, licence, a loader of ten lines
F/dataset.json          the same for programs
F/runs.csv              a row for each run: split, parameters, responses
F/train/RUN.zarr        mesh_pos (times, nodes, 3) [m], edges, triangles, and each parameter on every node;
F/test/RUN.zarr         the layout of the crash example of PhysicsNeMo (zarr_reader.py), one folder for each split
F/global_features.json  run -> parameters, as that example reads them
F/study/                the files of the study that say how it was made
F/SHA256SUMS            of every other file, for sha256sum -c
"""

from __future__ import annotations

import json
import math
import re
from dataclasses import asdict
from importlib import resources
from pathlib import Path

import jinja2
import numpy as np

from billow import __version__
from billow.base.errors import InputError
from billow.design.table import ResponseTable, respond
from billow.geometry.crossings import edges_of
from billow.results.atomic import new_folder, write_atomically
from billow.results.dataset import Dataset
from billow.results.dataset_files import DATASET_FILE, DESIGN_FILE
from billow.results.run_file import file_sha256
from billow.results.zarr_store import write_group
from billow.rom.learn.dataset import read_run

UNUSABLE = InputError.declare(
    "E-DES-170",
    "{name} = {value} cannot be used",
    where="billow dataset publish",
    cause="a precision in another unit, a licence that is a sentence, or a parameter with the name of an array",
    remedy="{remedy}",
)

FORMAT = 1
PRECISION = 5e-5
"""[m] No published coordinate is farther from that of the run."""
FINEST, COARSEST = 1e-6, 1e-2
"""[m] Of the precision: single precision does not hold more, and less shows no bag."""
LICENCE = "CC-BY-4.0"
MESH, EDGES, TRIANGLES = "mesh_pos", "edges", "mesh_connectivity_triangles"
SUMS = "SHA256SUMS"
_FROM_STUDY = ("study.toml", "case.toml", DESIGN_FILE, DATASET_FILE)


def publish(folder: str | Path, out: str | Path, precision: float = PRECISION, licence: str = LICENCE) -> Path:
    """Write the runs of a study or an imported dataset to a new folder, whole or not at all; returns its path.

    precision: [m]; licence: an SPDX identifier, such as CC-BY-4.0
    Runs that failed or are in doubt are left out, as in training, and named on the card. InputError E-DES-170: an
    argument or the name of a parameter; E-RES-009: the folder exists; E-ROM-009: a run is not finite; errors as
    `respond`.
    """
    if not FINEST <= precision <= COARSEST:
        why = f"it is between {FINEST:g} and {COARSEST:g} m"
        raise UNUSABLE(name="precision", value=f"{precision:g} m", why=why, remedy="give one that is, such as 5e-5")
    if not re.fullmatch(r"[A-Za-z0-9][A-Za-z0-9.+-]{1,60}", licence):
        why, remedy = "it is no identifier of SPDX", "write one of https://spdx.org/licenses, such as CC-BY-4.0"
        raise UNUSABLE(name="licence", value=repr(licence), why=why, remedy=remedy)
    dataset, table = Dataset.open(folder), respond(folder)
    for parameter in table.parameters:
        if parameter.name in (MESH, EDGES) or parameter.name.startswith("mesh_connectivity_"):
            why, remedy = "an array of the published runs has this name", "give the parameter another one"
            raise UNUSABLE(name="parameter", value=parameter.name, why=why, remedy=remedy)
    with new_folder(out) as place:
        record = _record(dataset, table, precision, licence)
        _write_runs(dataset, table, place, precision)
        write_atomically(place / "runs.csv", table.csv())
        features = dict(zip(table.runs, _designs(table), strict=True))
        for name, content in (("dataset.json", record), ("global_features.json", features)):
            write_atomically(place / name, json.dumps(content, indent=1, allow_nan=False) + "\n")
        write_atomically(place / "README.md", _card(record))
        (place / "study").mkdir()
        for name in _FROM_STUDY:
            if (dataset.folder / name).is_file():
                write_atomically(place / "study" / name, (dataset.folder / name).read_bytes())
        write_atomically(place / SUMS, _sums(place))
    return Path(out)


def rounded(values: np.ndarray, precision: float) -> np.ndarray:
    """The nearest multiples of the largest power of two that is at most twice the precision, as float32.

    float32 holds these without error as long as they are below 2^24 steps: what is stored is what was rounded, and the
    zeros at its end pack well.
    """
    step = 2.0 ** math.floor(math.log2(2.0 * precision))
    return (np.round(np.asarray(values, float) / step) * step).astype(np.float32)


def _write_runs(dataset: Dataset, table: ResponseTable, place: Path, precision: float) -> None:
    triangles = np.asarray(dataset.triangles, np.int32)
    edges, nodes = edges_of(triangles).astype(np.int32), len(dataset.reference)
    for split in ("train", "test"):
        (place / split).mkdir()
    for run, split, design in zip(table.runs, _splits(table), _designs(table), strict=True):
        start = dataset.starts([run])[0].astype(float)
        positions = np.concatenate([start[None], start + read_run(dataset, run)])
        arrays = {MESH: rounded(positions, precision), EDGES: edges, TRIANGLES: triangles}
        if not np.abs(arrays[MESH] - positions).max() <= precision:
            why = f"run {run} reaches {np.abs(positions).max():.3g} m, where single precision is coarser"
            raise UNUSABLE(name="precision", value=f"{precision:g} m", why=why, remedy="give a coarser one")
        arrays |= {name: np.full(nodes, value, np.float32) for name, value in design.items()}
        times = [0.0, *dataset.times.tolist()]
        write_group(place / split / f"{run}.zarr", arrays, {"run": run, "times_s": times, "parameters": design})


def _splits(table: ResponseTable) -> list[str]:
    return ["train"] * (len(table.runs) - table.unseen) + ["test"] * table.unseen


def _designs(table: ResponseTable) -> list[dict[str, float]]:
    names = [parameter.name for parameter in table.parameters]
    return [dict(zip(names, row.tolist(), strict=True)) for row in table.designs]


def _record(dataset: Dataset, table: ResponseTable, precision: float, licence: str) -> dict:
    first = dataset.result(table.runs[0]).record
    runs = {
        run: {"split": split, "verdict": dataset.verdict(run), "doubts": list(dataset.doubts(run)),
              "wall_seconds": float(dataset.result(run).wall_seconds)}
        for run, split in zip(table.runs, _splits(table), strict=True)
    }  # fmt: skip
    responses = [r.model_dump(mode="json", exclude_none=True) | {"unit": unit}
                 for r, unit in zip(table.responses, table.units, strict=True)]  # fmt: skip
    return {
        "format": FORMAT, "title": table.title, "licence": licence, "published_by": f"Billow {__version__}",
        "made_by": f"Billow {first['billow_version']}" if "billow_version" in first else "another solver",
        "seed": dataset.seed, "content_sha256": dataset.content_sha256(), "precision_m": precision,
        "reference_length_m": dataset.reference_length, "times_s": [0.0, *dataset.times.tolist()],
        "nodes": len(dataset.reference), "triangles": len(dataset.triangles),
        "parts": list(dataset.parts.names), "own_starts": dataset.own_starts,
        "parameters": [asdict(parameter) for parameter in table.parameters], "responses": responses,
        "runs": runs, "left_out": table.left_out,
    }  # fmt: skip


def _card(record: dict) -> str:
    counts: dict[str, int] = {}
    for run in record["runs"].values():
        word = run["verdict"] or "none given"
        counts[word] = counts.get(word, 0) + 1
    template = resources.files("billow.design").joinpath("card.md.j2").read_text(encoding="utf-8")
    made = jinja2.Environment(trim_blocks=True, lstrip_blocks=True, undefined=jinja2.StrictUndefined)
    splits = [run["split"] for run in record["runs"].values()]
    return made.from_string(template).render(**record, train=splits.count("train"), test=splits.count("test"),
                                             verdicts=counts)  # fmt: skip


def _sums(place: Path) -> str:
    files = sorted(path for path in place.rglob("*") if path.is_file() and path.name != "billow.lock")
    return "".join(f"{file_sha256(path)}  {path.relative_to(place).as_posix()}\n" for path in files)
