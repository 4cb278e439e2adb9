"""A case of three numbers and a solver that takes a millisecond: what a study needs, without the physics.

Worker processes import this module, so everything in it is at module level.
"""

from __future__ import annotations

import hashlib
import os
import time
import tomllib
from pathlib import Path
from typing import ClassVar

import numpy as np
import tomli_w

from billow.base.errors import InputError, NumericalStop
from billow.results.atomic import publish_folder
from billow.results.dataset_files import mesh_sha256
from billow.results.histories import write_histories
from billow.results.run_file import write_run_file
from billow.results.vtkhdf import FabricWriter
from billow.run.check import Outline, Recorded

POINTS = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
TRIANGLES = np.array([[0, 1, 2], [0, 2, 3]])
TIMES = np.array([0.0, 0.01, 0.02])

STUDY = """
title = "Rising square"
case = "square.toml"
seed = 3
train = 4
test = 2
reference_length = 0.28

[[parameters]]
name = "lift"
label = "Lift"
unit = "m"
low = 1.0
high = 2.0
keys = ["square.lift"]

[[parameters]]
name = "slope"
label = "Contact slope"
unit = "N/m"
low = 1e3
high = 1e6
keys = ["plate.slope"]
scale = "log"
"""
CASE = "[square]\nlift = 1.0\nsize = 1.0\n[plate]\nslope = 1e4\n"


class FakeCase:
    def __init__(self, content):
        self.content = content

    @classmethod
    def load(cls, path):
        return cls(tomllib.loads(Path(path).read_text()))

    @classmethod
    def from_dict(cls, content):
        return cls(content)

    def vary(self, entries):
        content = {table: dict(keys) for table, keys in self.content.items()}
        for entry, value in entries.items():
            table, key = entry.split(".")
            if key not in content.get(table, {}):
                raise InputError("E-CASE-006", f"no {entry!r} to vary", where=entry, why="no such key", remedy="look")
            if not value < 1e7:
                raise InputError("E-CASE-005", f"{entry} = {value} too large", where=entry, why="limit", remedy="less")
            content[table][key] = value
        return FakeCase(content)

    files: ClassVar = {}

    def with_files(self, paths):
        return self

    def to_toml(self):
        return tomli_w.dumps(self.content)

    def digest(self):
        return hashlib.sha256(self.to_toml().encode()).hexdigest()


def outline(case):
    size = case.content["square"]["size"]
    return Outline(len(POINTS), len(TRIANGLES), mesh_sha256(size * POINTS, TRIANGLES), tuple(TIMES))


def recorded(case):
    return Recorded(("time [s]", "pressure [Pa]"), ("square",), {}, float(TIMES[1]))


def simulate(case, folder, *, progress=None, threads=None, status="completed", quality=None):
    assert threads == 1
    folder = Path(folder)
    partial = folder.with_name(folder.name + ".partial")
    partial.mkdir()
    (partial / "case.toml").write_text(case.to_toml())
    points = case.content["square"]["size"] * POINTS
    with FabricWriter(partial / "fabric.vtkhdf", points, TRIANGLES, [0, 0], ["square"]) as fabric:
        for t in TIMES:
            moved = np.tile([0.0, 0.0, case.content["square"]["lift"] * t], (4, 1))
            fabric.append(t, points + moved, {"displacement": moved, "contact_force": 0 * moved}, {"pressure": [t, t]})
    write_histories(partial / "histories.csv", {"time [s]": TIMES, "pressure [Pa]": TIMES})
    record = {"status": status, "reason": "too fast" if status == "stopped" else None, "case_digest": case.digest()}
    if quality:
        record["quality"] = quality
    write_run_file(partial, {**record, "wall_seconds": 0.001, "ledger": {}})
    publish_folder(partial, folder)


def _is(case, run_lift):
    return abs(case.content["square"]["lift"] - run_lift) < 1e-9


class Fails:
    """Simulates, except that the run with this lift ends in another way."""

    def __init__(self, lift, how):
        self.lift, self.how = lift, how

    def __call__(self, case, folder, *, threads):
        if not _is(case, self.lift):
            simulate(case, folder, threads=threads)
        elif self.how == "error":
            raise ZeroDivisionError("a bug")
        elif self.how == "full":
            raise OSError(28, "No space left on device")
        elif self.how == "interrupt":
            Path(f"{folder}.partial").mkdir()
            raise KeyboardInterrupt
        elif self.how == "stop":
            simulate(case, folder, threads=threads, status="stopped")
            raise NumericalStop("E-NUM-007", "not finite", where="element 1", why="inverted", remedy="smaller step")
        elif self.how == "stopped":
            simulate(case, folder, threads=threads, status="stopped")
        elif self.how == "interrupted":
            simulate(case, folder, threads=threads, status="interrupted")
        elif self.how == "die":
            time.sleep(0.1)
            os._exit(9)  # as a crash in compiled code, or a kill from outside
