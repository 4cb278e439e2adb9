"""Where a trigger works: a folder of its own and copies of sound files."""

from __future__ import annotations

import dataclasses
import shutil
from pathlib import Path

from billow.case.schema import Case
from billow.study.study import Study
from trust.faults import SOUND, changed
from trust.fuzz_inputs import Bench


@dataclasses.dataclass
class Here:
    """Where a trigger works."""

    place: Path
    bench: Bench
    patch: object

    def study(self) -> Study:
        """A copy of the sound study."""
        return Study.open(shutil.copytree(self.bench.study.folder, self.place / "study"))

    def run(self) -> Path:
        """A copy of a sound run."""
        return shutil.copytree(self.bench.run, self.place / "run")

    def interrupted(self) -> Path:
        """A copy of an interrupted run, to be resumed as `place`/run."""
        return shutil.copytree(self.bench.interrupted, self.place / "run.partial")

    def write(self, name: str, text: str | bytes) -> Path:
        path = self.place / name
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    def study_file(self, old: str = "", new: str = "", **case) -> Path:
        """A study file with a text replaced, beside a case."""
        self.write("case.toml", Case.from_dict(changed(SOUND, dotted(case))).to_toml())
        assert old in self.bench.study_text
        return self.write("definition.toml", self.bench.study_text.replace(old, new, 1))


@dataclasses.dataclass
class Told:
    """A message that reached the user in another way than as an exception."""

    code: str
    what: str
    where: str
    why: str
    remedy: str


def dotted(changes: dict) -> dict:
    return {key.replace("__", "."): value for key, value in changes.items()}
