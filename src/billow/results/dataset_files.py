"""design.csv, split.toml, dataset.toml: what turns a folder of runs into a dataset (docs/architecture.md, Study and
dataset)."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path

import numpy as np
import tomli_w

from billow.base.errors import InputError, IntegrityError, shown
from billow.base.table_file import read_table
from billow.base.toml_file import read_toml
from billow.results.atomic import write_atomically
from billow.results.csv_files import csv_text

NO_COMPLETED_RUN = InputError.declare(
    "E-RES-010",
    "the dataset has no completed run",
    where="{folder}",
    cause="the study has not been run, or all its runs failed",
    remedy="make its runs first: billow study STUDY.toml --out FOLDER",
)
DATASET_FILE_DAMAGED = IntegrityError.declare(
    "E-RES-011",
    "a file of the dataset cannot be read",
    where="{path}",
    cause="an edit by hand, or a copy that was cut short",
    remedy="restore the file, or make the study again in a new folder: billow study STUDY.toml --out FOLDER",
)

FORMAT = 1
RUN_NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9._-]{0,60}")
DATASET_FILE, DESIGN_FILE, SPLIT_FILE = "dataset.toml", "design.csv", "split.toml"


@dataclass(frozen=True)
class Parameter:
    """One axis of the design space; low and high are in `unit`. levels: names of the levels of a factor, whose values
    are the whole numbers from 0."""

    name: str
    label: str
    unit: str
    low: float
    high: float
    levels: tuple[str, ...] = field(default=(), repr=False)


@dataclass(frozen=True)
class MeshParts:
    """Which part each triangle belongs to: (triangles,) int64, index into names."""

    part: np.ndarray
    names: tuple[str, ...]


@dataclass(frozen=True)
class DatasetRecord:
    """What dataset.toml holds. reference_length: [m]; times: [s], (times,). own_starts: whether each run has a start
    shape of its own, on the same triangles."""

    title: str
    reference_length: float
    seed: int
    mesh_sha256: str
    times: tuple[float, ...]
    parameters: tuple[Parameter, ...]
    own_starts: bool = False

    @property
    def mesh(self) -> str:
        """Which mesh it is, for messages."""
        return "triangles" if self.own_starts else "start mesh"

    def has_mesh(self, reference: np.ndarray, triangles: np.ndarray) -> bool:
        """Whether a run's mesh is that of the dataset."""
        return fingerprint(reference, triangles, self.own_starts) == self.mesh_sha256


def fingerprint(reference: np.ndarray, triangles: np.ndarray, own_starts: bool) -> str:
    """`mesh_sha256`, without the start shape if each run has its own."""
    return mesh_sha256(reference[:0] if own_starts else reference, triangles)


def mesh_sha256(reference: np.ndarray, triangles: np.ndarray) -> str:
    """Fingerprint of a mesh. reference: [m], (nodes, 3); triangles: (triangles, 3) int.

    Positions count as float32, as they are stored: the last bits of a double may differ between machines.
    """
    digest = hashlib.sha256()
    for array in (np.asarray(reference, dtype="<f4"), np.asarray(triangles, dtype="<i8")):
        digest.update(f"{array.shape}".encode() + np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def same_times(one: np.ndarray, other: np.ndarray) -> bool:
    """True if two runs recorded the same times, rounding aside. one, other: [s], (times,)."""
    one, other = np.asarray(one), np.asarray(other)
    return one.shape == other.shape and np.allclose(one, other, rtol=1e-9, atol=1e-12)


def write_dataset_file(folder: str | Path, record: DatasetRecord) -> None:
    """Write `folder`/dataset.toml, atomically."""
    write_atomically(Path(folder, DATASET_FILE), tomli_w.dumps({"format": FORMAT, **asdict(record)}))


def read_dataset_file(folder: str | Path) -> DatasetRecord:
    """Content of `folder`/dataset.toml. InputError E-RES-010 if there is none, IntegrityError E-RES-011 if damaged."""
    path = Path(folder, DATASET_FILE)
    if not path.is_file():
        raise NO_COMPLETED_RUN(folder=folder, why=f"{DATASET_FILE}, written when the first run is in, is missing")
    try:
        content = read_toml(path)
        if content["format"] != FORMAT:
            raise ValueError(f"this version of Billow reads format {FORMAT}")
        return DatasetRecord(
            title=_text(content["title"]),
            reference_length=_length(content["reference_length"]),
            seed=int(_number(content["seed"])),
            mesh_sha256=_text(content["mesh_sha256"]),
            times=tuple(map(_number, _list(content["times"]))),
            parameters=tuple(map(parameter_of, _list(content["parameters"]))),
            own_starts=content.get("own_starts") is True,
        )
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise DATASET_FILE_DAMAGED(path=path, why=error) from error


def parameter_of(entry: Mapping[str, object]) -> Parameter:
    """A parameter as read from a file. KeyError, TypeError or ValueError if it is none."""
    texts = (_text(entry[key]) for key in ("name", "label", "unit"))
    levels = tuple(map(_text, _list(entry.get("levels") or [])))
    return Parameter(*texts, _number(entry["low"]), _number(entry["high"]), levels)


def _text(value: object) -> str:
    if not isinstance(value, str) or not value.isprintable():
        raise ValueError(f"{shown(value)} stands where a text in one line is expected")
    return value


def _list(value: object) -> list:
    if not isinstance(value, list):
        raise ValueError(f"{shown(value)} stands where a list is expected")
    return value


def _number(value: object) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float) or not abs(value) < 1e300:
        raise ValueError(f"{shown(value)} stands where a finite number is expected")
    return float(value)


def _length(value: object) -> float:
    if not _number(value) > 0.0:
        raise ValueError(f"reference_length = {shown(value)} is not above zero")
    return float(value)


def write_design(folder: str | Path, parameters: Sequence[Parameter], design: Mapping[str, Sequence[float]]) -> None:
    """Write `folder`/design.csv, atomically. design: run -> value of each parameter, in its unit."""
    rows = ([run, *map(float, values)] for run, values in design.items())
    write_atomically(Path(folder, DESIGN_FILE), csv_text([["run", *design_columns(parameters)], *rows]))


def read_design(folder: str | Path, parameters: Sequence[Parameter]) -> dict[str, tuple[float, ...]]:
    """Content of `folder`/design.csv: run -> value of each parameter.

    IntegrityError E-RES-011 if it cannot be read or its columns are not these parameters.
    """
    path = Path(folder, DESIGN_FILE)
    try:
        table, columns = read_table(path), design_columns(parameters)
        if table.names != ("run", *columns):
            raise ValueError(f"its columns are {', '.join(table.names)}; expected run, {', '.join(columns)}")
        runs = [cells[0] for _, cells in table.rows()]
        design = dict(zip(runs, map(tuple, table.numbers(columns)[0].tolist()), strict=True))
        if len(design) != len(runs):
            raise ValueError("a run stands in it twice")
        for run in design:
            if not RUN_NAME.fullmatch(run):
                raise ValueError(f"{run!r} cannot be the name of a run, because runs have folders of their name")
        return design
    except (OSError, ValueError) as error:
        raise DATASET_FILE_DAMAGED(path=path, why=error) from error


def design_columns(parameters: Sequence[Parameter]) -> list[str]:
    """Columns of the parameters in a table of designs."""
    return [f"{p.name} [{p.unit}]" for p in parameters]


def write_split(folder: str | Path, train: Sequence[str], test: Sequence[str]) -> None:
    """Write `folder`/split.toml, atomically. train, test: runs; the first n of train are a valid smaller dataset."""
    write_atomically(Path(folder, SPLIT_FILE), tomli_w.dumps({"train": list(train), "test": list(test)}))


def read_split(folder: str | Path) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """Content of `folder`/split.toml: (train, test). IntegrityError E-RES-011 if it cannot be read or they overlap."""
    path = Path(folder, SPLIT_FILE)
    try:
        content = read_toml(path)
        train, test = (tuple(map(_text, _list(content[part]))) for part in ("train", "test"))
        if set(train) & set(test):
            raise ValueError(f"runs used both to train and to test: {sorted(set(train) & set(test))}")
        return train, test
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise DATASET_FILE_DAMAGED(path=path, why=error) from error
