"""What is fed to Billow: each function makes a number of inputs of one kind and attempts to use them."""

from __future__ import annotations

import contextlib
import functools
import json
import os
import shutil
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from random import Random
from typing import Any

import hypothesis
import numpy as np
import tomli_w
from hypothesis import HealthCheck, Phase
from hypothesis import strategies as st

from billow.case.build import build_model
from billow.case.schema import Case
from billow.cli import demo
from billow.cli.options import parse_settings
from billow.results.dataset import Dataset
from billow.results.journal import Journal
from billow.results.result import Result
from billow.results.run_file import write_run_file
from billow.results.tensor_file import read_tensors, write_tensors
from billow.rom.surrogate.surrogate import Surrogate
from billow.run.check import describe
from billow.run.checkpoint_file import newest_checkpoint
from billow.run.simulate import simulate
from billow.study.study import Study
from trust.generated_cases import EXAMPLE, SETTINGS, case_dictionaries, curves
from trust.injections import interrupted
from trust.mutations import damaged_file, mutate_bytes, mutate_dictionary, mutate_text
from trust.small_surrogate import small_surrogate

Attempt = Callable[[Callable[[], object], object], bool]

SMALL_MESH = 5000
"""Triangles up to which an accepted case is built too; finer ones take their time by right."""


class Bench:
    """Sound files of every kind, to be damaged: made once."""

    def __init__(self, place: Path):
        self.place = place
        self.whole = json.loads(json.dumps(Case.from_dict(EXAMPLE).to_dict()))
        self.case_texts = [demo.CASE, tomli_w.dumps(self.whole)]
        (place / "case.toml").write_text(tomli_w.dumps({**self.whole, "run": {"end_time": 1e-4, "frames": 2}}))
        self.study_text = demo.STUDY.format(train=3, test=1)
        (place / "study.toml").write_text(self.study_text)
        self.study = Study.create(place / "study.toml", place / "study")
        self.study.run(workers=1)
        self.run = self.study.store.runs / "0000"
        self.case = Case.load(self.run / "case.toml")
        self.model = build_model(self.case)
        stopped = place / "stopped"
        stopped.mkdir()
        self.interrupted = interrupted(stopped, self.case)
        self.surrogate = small_surrogate().save(place / "surrogate.safetensors")

    @contextlib.contextmanager
    def damaged(self, path: Path, data: bytes) -> Iterator[None]:
        """`path` holds `data` for a while."""
        sound = path.read_bytes()
        path.write_bytes(data)
        try:
            yield
        finally:
            path.write_bytes(sound)


# --- cases ----------------------------------------------------------------------------------------------------------


def generated_cases(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    _draw(case_dictionaries(), lambda data: attempt(lambda: _use_case(data, random, bench), data), count, random)


def generated_curves(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    flow = curves().map(lambda curve: {"inflator": {"mass_flow": curve}})
    heat = curves("K", 200.0, 3000.0).map(lambda curve: {"inflator": {"temperature": curve}})
    _draw(st.one_of(flow, heat), lambda data: attempt(lambda: Case.from_dict(data), data), count, random)


def mutated_cases(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    for _ in range(count):
        data = mutate_dictionary(random.choice([EXAMPLE, bench.whole]), random)
        attempt(lambda data=data: Case.from_dict(data), data)


def mutated_case_files(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    path = bench.place / "mutated.toml"
    for _ in range(count):
        data = _mutated(random.choice(bench.case_texts), random)
        path.write_bytes(data)
        attempt(lambda: Case.load(path), data)


def assignments(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    keys = [".".join(map(str, path)).replace("obstacles.1", "obstacles.impactor") for path in SETTINGS]
    for _ in range(count):
        text = f"{random.choice(keys)}={random.choice(['1', '0.3 mm', '-1', 'nan', '1e400', '', 'plate', '[1]'])}"
        if random.random() < 0.5:
            text = mutate_text(text, random)
        attempt(lambda text=text: bench.case.vary(parse_settings([text])), text)


def _use_case(data: Any, random: Random, bench: Bench) -> None:
    """What becomes of a case: it is read, written and read again; some are built, a few are run."""
    case = Case.from_dict(data)
    again = Case.from_dict(tomllib.loads(case.to_toml()))
    if again != case or again.digest() != case.digest():
        raise AssertionError("a case changes on its way through a file")
    if 7.0 * (case.bag.diameter / case.bag.element_size) ** 2 > SMALL_MESH or random.random() < 0.7:
        return
    describe(case)
    if random.random() < 0.03:
        shutil.rmtree(bench.place / "run", ignore_errors=True)
        simulate(case.vary({"run.end_time": 1e-4, "run.frames": 1}), bench.place / "run", threads=1)


def _draw(strategy: st.SearchStrategy, use: Callable[[Any], object], count: int, random: Random) -> None:
    @hypothesis.seed(random.getrandbits(32))
    @hypothesis.settings(
        max_examples=count,
        database=None,
        deadline=None,
        phases=[Phase.generate],
        suppress_health_check=list(HealthCheck),
    )
    @hypothesis.given(strategy)
    def draw(data):
        use(data)

    draw()


def _mutated(text: str, random: Random) -> bytes:
    """Damaged as text or as bytes."""
    if random.random() < 0.5:
        return mutate_bytes(text.encode(), random)
    return mutate_text(text, random).encode("utf-8", "surrogatepass")


# --- studies and datasets -------------------------------------------------------------------------------------------


def study_files(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    path, folder = bench.place / "mutated_study.toml", bench.place / "mutated_study"
    content = tomllib.loads(bench.study_text)
    for number in range(count):
        data = _mutated(bench.study_text, random)
        if number % 2:
            with contextlib.suppress(TypeError, ValueError, RecursionError):  # what TOML cannot say
                data = tomli_w.dumps(mutate_dictionary(content, random)).encode()
        path.write_bytes(data)
        if attempt(lambda: Study.create(path, folder), data):
            shutil.rmtree(folder)


def study_folders(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    def use():
        study = Study.open(bench.study.folder)
        for run in study.runs:
            study.case(run)

    for _ in range(count):
        path = bench.study.folder / random.choice(["study.toml", "design.csv", "split.toml", "case.toml"])
        data = _mutated(path.read_text(), random)
        with bench.damaged(path, data):
            attempt(use, (path.name, data))


def datasets(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    def use():
        dataset = Dataset.open(bench.study.folder)
        runs = dataset.train + dataset.test
        dataset.design(runs), dataset.computing_seconds(runs), dataset.snapshots("displacement", runs)

    for _ in range(count):
        path = bench.study.folder / random.choice(["dataset.toml", "design.csv", "split.toml"])
        data = _mutated(path.read_text(), random)
        with bench.damaged(path, data):
            attempt(use, (path.name, data))


# --- runs and surrogates --------------------------------------------------------------------------------------------


def damaged_runs(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    for _ in range(count):
        path = bench.run / random.choice(sorted(os.listdir(bench.run)))
        data = damaged_file(path.name, path.read_bytes(), random)
        with bench.damaged(path, data):
            _must_be_refused(attempt, lambda: Result.open(bench.run), (path.name, data))


def forged_runs(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Contents changed, and checksums written anew to match: nothing to notice but what is said."""
    record = bench.run / "run.json"
    made = 0
    while made < count:
        path = bench.run / random.choice(["run.json", "histories.csv", "case.toml", "fabric.vtkhdf"])
        data = mutate_bytes(path.read_bytes(), random)
        with bench.damaged(record, record.read_bytes()), bench.damaged(path, data):
            said = {"status": "completed", "reason": None, "case_digest": "0", "wall_seconds": 1.0, "ledger": {}}
            if path == record:
                with contextlib.suppress(TypeError, ValueError):  # what JSON cannot say
                    said = mutate_dictionary({**said, "extra": {"a": [1]}}, random)
            try:
                write_run_file(bench.run, said)
            except (TypeError, ValueError):
                continue
            attempt(lambda: _read_all(Result.open(bench.run)), (path.name, said, data))
            made += 1


def _read_all(result: Result) -> None:
    result.fabric.points(-1)
    for name, kind in vars(Result).items():
        if isinstance(kind, (property, functools.cached_property)):
            getattr(result, name)


def damaged_checkpoints(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    def use():
        offset = newest_checkpoint(bench.interrupted, bench.model, bench.case.digest()).journal_offset
        journal = bench.place / "journal_copy.bin"
        shutil.copy(bench.interrupted / "journal.bin", journal)
        Journal(journal, offset).close()

    offset = newest_checkpoint(bench.interrupted, bench.model, bench.case.digest()).journal_offset
    for _ in range(count):
        path = bench.interrupted / random.choice(["checkpoint_a.safetensors", "journal.bin"])
        sound = path.read_bytes()
        data = mutate_bytes(sound, random)
        with bench.damaged(path, data):
            if path.name == "journal.bin" and data[:offset] == sound[:offset]:
                attempt(use, (path.name, data))  # what lies behind the checkpoint is dropped anyway
            else:
                _must_be_refused(attempt, use, (path.name, data))


def damaged_surrogates(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    for _ in range(count):
        data = mutate_bytes(bench.surrogate.read_bytes(), random)
        with bench.damaged(bench.surrogate, data):
            _must_be_refused(attempt, lambda: Surrogate.load(bench.surrogate), data)


def forged_surrogates(attempt: Attempt, count: int, random: Random, bench: Bench) -> None:
    """Arrays or record changed, and the checksum written anew to match."""
    path = bench.place / "forged.safetensors"
    tensors, record = read_tensors(bench.surrogate, ValueError)
    del record["sha256"]

    def use():
        surrogate = Surrogate.load(path)
        repr(surrogate)
        surrogate.predict([0.5 * (p.low + p.high) for p in surrogate.parameters])

    made = 0
    while made < count:
        forged, said = dict(tensors), record
        if random.random() < 0.5:
            said = mutate_dictionary(record, random)
        else:
            name = random.choice(sorted(forged))
            forged[name] = _forged_array(forged[name], random)
        try:
            write_tensors(path, forged, said)
        except (TypeError, ValueError):  # what JSON cannot say
            continue
        attempt(use, said)
        made += 1


def _forged_array(array: np.ndarray, random: Random) -> np.ndarray:
    flat = array.reshape(-1)
    with np.errstate(invalid="ignore"):
        absent = np.where(np.arange(flat.size) == 0, np.nan, flat).reshape(array.shape).astype(array.dtype)
    return random.choice(
        [
            absent,
            np.full_like(array, 3e38) if array.dtype.kind == "f" else np.full_like(array, 2**30 - 1),
            array[..., :0],
            array[:-1],
            array.astype(np.float16),
            flat,
            np.full_like(array, 2**30),
            -array,
            np.concatenate([array, array]),
        ]
    )


def _must_be_refused(attempt: Attempt, use: Callable[[], object], shown: object) -> None:
    def accept_nothing():
        use()
        raise AssertionError("damaged and accepted")

    attempt(accept_nothing, shown)
