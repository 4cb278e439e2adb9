"""Mistakes put into a copy of the package, each of which a test must catch.

    python -m trust.mutants            # all, some seconds each
    python -m trust.mutants lead gain  # those whose name has one of these words

A mutant that no test catches is a promise that nothing keeps. Where a mutant's text is gone because the code has
changed, the entry is to be changed with it: tests/project/test_trust.py says so.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "billow"


@dataclass(frozen=True)
class Mutant:
    """In `file` of the package the text `right` becomes `wrong`; `test` (a file or a test of it) fails by it."""

    name: str
    file: str
    right: str
    wrong: str
    test: str

    def apply(self, package: Path) -> None:
        """Change a copy of the package. ValueError if the text is not there exactly once."""
        path = package / self.file
        text = path.read_text(encoding="utf-8") if path.is_file() else ""
        if text.count(self.right) != 1:
            raise ValueError(f"mutant '{self.name}': {self.right!r} is {text.count(self.right)} times in {self.file}")
        path.write_text(text.replace(self.right, self.wrong), encoding="utf-8")


PROMISES = "tests/results/test_run_promises.py::"
COLUMNS = "tests/results/test_history_columns.py::"
CACHE = "tests/base/test_kernel_cache.py::"

MUTANTS = (
    Mutant(
        "no element is ever inverted",
        "parts/fabric/fabric.py",
        "return int(count)",
        "return 0",
        PROMISES + "test_fabric_that_ends_turned_over_and_taut_fails_the_run",
    ),
    Mutant(
        "inverted elements are not reported",
        "parts/fabric/fabric.py",
        '"inverted_elements": float(self.inverted_elements(moment.positions))',
        '"inverted_elements": 0.0',
        PROMISES + "test_fabric_that_ends_turned_over_and_taut_fails_the_run",
    ),
    Mutant(
        "sign of the energy gain in the ledger",
        "solver/ledger.py",
        "max(self.largest_gain, residual)",
        "max(self.largest_gain, -residual)",
        PROMISES + "test_a_run_that_gains_energy_is_stopped_and_fails",
    ),
    Mutant(
        "sign of the energy gain in run.json",
        "solver/ledger.py",
        '"energy_gain_of_largest": self.largest_gain',
        '"energy_gain_of_largest": -self.largest_gain',
        PROMISES + "test_a_run_that_gains_energy_is_stopped_and_fails",
    ),
    Mutant(
        "sign of the energy gain in the guard",
        "solver/guards.py",
        "if ledger.residual > largest_gain",
        "if -ledger.residual > largest_gain",
        PROMISES + "test_a_run_that_gains_energy_is_stopped_and_fails",
    ),
    Mutant(
        "obstacles of run.json at the origin",
        "parts/bodies/body.py",
        '"center": centre.tolist()',
        '"center": [0.0, 0.0, 0.0]',
        PROMISES + "test_pictures_show_obstacles_where_the_case_puts_them",
    ),
    Mutant(
        "sign of the work that moves obstacles",
        "parts/bodies/drive.py",
        "return -float(motion.force @ way), 0.0",
        "return float(motion.force @ way), 0.0",
        "tests/contact/test_moved_obstacles.py::test_speed_is_integrated_to_travel_exactly",
    ),
    Mutant(
        "what torn seams held is forgotten",
        "parts/tear_seams.py",
        "lost += energy",
        "lost += 0.0 * energy",
        "tests/dynamics/test_tear_seams.py::test_a_strip_pulled_at_a_constant_speed_tears_at_strength_times_width",
    ),
    Mutant(
        "jets push on covers",
        "case/gas/build_gas.py",
        "if chambers.count == 1 and (chambers.behind == chamber).all():",
        "if chambers.count == 1:",
        "tests/dynamics/test_tear_seams.py::test_jets_and_gas_leave_a_cover_alone",
    ),
    Mutant(
        "moving obstacles of pictures at the origin",
        "results/obstacles.py",
        '"center": centre.tolist()',
        '"center": [0.0, 0.0, 0.0]',
        PROMISES + "test_pictures_show_obstacles_where_the_case_puts_them",
    ),
    Mutant(
        "of two surfaces the farther is drawn",
        "pictures/raster.py",
        "if depth > depth_out[row, column] + SAME:",
        "if depth_out[row, column] == -np.inf or depth < depth_out[row, column]:",
        "tests/pictures/test_raster.py::test_the_nearest_surface_wins_everywhere",
    ),
    Mutant(
        "the cut face of a solid is not filled",
        "pictures/raster.py",
        "depth[row, column] += forward * (wa",
        "depth[row, column] += 0.0 * (wa",
        "tests/pictures/test_raster.py::test_the_cut_face_of_a_solid_is_flat_and_as_large_as_its_section",
    ),
    Mutant(
        "pictures stand on their head",
        "pictures/camera.py",
        "0.5 * self.height - y",
        "0.5 * self.height + y",
        "tests/pictures/test_camera.py::test_lengths_across_the_view_are_the_scale_times_the_length",
    ),
    Mutant(
        "a plot filters the recorded acceleration",
        "pictures/curves.py",
        'if of_whole.endswith(f"_{ACCELERATION}") and',
        "if False and",
        "tests/pictures/test_named_curves.py::test_the_peak_of_a_run_is_that_of_billow_injury",
    ),
    Mutant(
        "a comparison rates the test against the model",
        "apps/compare/differences.py",
        'for curve in (one, other))), ""',
        'for curve in (other, one))), ""',
        "tests/pictures/test_compare_sides.py::test_the_second_is_the_reference_of_the_rating",
    ),
    Mutant(
        "a column of the energies dropped",
        "solver/ledger.py",
        'self.accounts:\n            yield Quantity("", account.name',
        'self.accounts[1:]:\n            yield Quantity("", account.name',
        COLUMNS + "test_a_run_with_bodies_and_straps",
    ),
    Mutant(
        "a column of a chamber dropped",
        "parts/gas/gas_part.py",
        'OF_CHAMBERS = ("pressure", "temperature", ',
        'OF_CHAMBERS = ("pressure", ',
        COLUMNS + "test_a_run_with_chambers",
    ),
    Mutant(
        "no guard below 1 J",
        "solver/guards.py",
        "floor = LARGE_ENERGY if state.step <= FIRST_STEPS else SMALLEST_ENERGY",
        "floor = LARGE_ENERGY",
        "tests/dynamics/test_guards.py",
    ),
    Mutant(
        "fabric step beyond the bound of its elements",
        "parts/fabric/fabric.py",
        "STEP_FACTOR = 0.9",
        "STEP_FACTOR = 1.05",
        "tests/fabric/test_stable_step.py",
    ),
    Mutant(
        "straps without a step limit",
        "solver/step_size.py",
        " + model.rate_of_straps",
        "",
        "tests/fabric/test_stable_step.py",
    ),
    Mutant(
        "undamped fabric with the step of damped fabric",
        "parts/fabric/membrane.py",
        "if not self.fabric.compression:",
        "if False:",
        "tests/fabric/test_stable_step.py",
    ),
    Mutant(
        "particles answer walls at their own steps only",
        "parts/gas/corpuscular/corpuscular.py",
        "return lead[self.chambers.behind] - lead[self.chambers.ahead]",
        "return 0.0 * lead[self.chambers.behind]",
        "tests/gas/corpuscular/test_between_gas_steps.py",
    ),
    Mutant(
        "kernels blind to a module imported by name",
        "base/compiled.py",
        "words = set(_WORD.findall(text))",
        "words = set()",
        CACHE + "test_kernels_are_compiled_again_after_an_edit_they_depend_on_and_only_then",
    ),
    Mutant(
        "kernels compiled without waiting for each other",
        "base/compiled.py",
        "fcntl.LOCK_EX",
        "fcntl.LOCK_SH",
        CACHE + "test_processes_that_need_the_same_kernels_compile_each_once",
    ),
    Mutant(
        "walls of strips with normals into them",
        "geometry/folding/parting.py",
        "[(a, c, b) for a, b, c in _between(forth, back, at)]",
        "[(a, b, c) for a, b, c in _between(forth, back, at)]",
        "tests/folding/test_strips.py::test_there_is_a_strip_between_neighbouring_lines",
    ),
    Mutant(
        "vents that take what they like",
        "parts/gas/mesh/passages.py",
        "min(1.0, most / whole)",
        "1.0",
        "tests/gas/mesh/test_bag_at_rest.py",
    ),
    Mutant(
        "impulses of the last step not swept",
        "parts/layers/parting.py",
        "if m or self.rubbed is not None:",
        "if m < 0:",
        "tests/contact/test_tight_layers.py",
    ),
    Mutant(
        "triangles of nodes on new paths not searched",
        "parts/layers/new_paths.py",
        "((ON, UNDER), nodes)",
        "((ON,), nodes)",
        "tests/contact/test_layers.py",
    ),
    Mutant(
        "edges of nodes on new paths found twice",
        "parts/layers/search.py",
        "skipped = skipped | strayed[edges[u, 0]] | strayed[edges[u, 1]]",
        "skipped = skipped | False",
        "tests/contact/test_layers.py",
    ),
    Mutant(
        "pairs of nodes on new paths kept beside new ones",
        "parts/layers/new_paths.py",
        "dropped = strayed[a] | strayed[b] | strayed[c] | strayed[d]",
        "dropped = strayed[a] & strayed[b]",
        "tests/contact/test_layers.py",
    ),
    Mutant(
        "processor time of the last sitting alone",
        "run/spent.py",
        "time.process_time() - before.processor",
        "time.process_time()",
        "tests/run/test_spent.py",
    ),
)


def caught(mutant: Mutant) -> bool:
    """Whether its test fails with the mutant; RuntimeError if the test does not run at all."""
    with tempfile.TemporaryDirectory(prefix="billow-mutant-") as folder:
        copy = Path(folder) / "billow"
        shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
        mutant.apply(copy)
        command = [sys.executable, "-m", "pytest", "-q", "-x", "-p", "no:cacheprovider", mutant.test]
        paths = os.pathsep.join([folder, *filter(None, [os.environ.get("PYTHONPATH")])])
        done = subprocess.run(
            command, cwd=ROOT, env={**os.environ, "PYTHONPATH": paths}, capture_output=True, text=True, check=False
        )
    if done.returncode not in (0, 1):
        raise RuntimeError(f"mutant '{mutant.name}': {mutant.test} does not run\n{done.stdout}{done.stderr}")
    return done.returncode == 1


def main() -> int:
    words = sys.argv[1:]
    survived = 0
    for mutant in MUTANTS:
        if words and not any(word in mutant.name for word in words):
            continue
        found = caught(mutant)
        survived += not found
        verdict = "caught" if found else "SURVIVED"
        print(f"{verdict:9} {mutant.name:48} {mutant.file:38} {mutant.test}", flush=True)
    return 1 if survived else 0


if __name__ == "__main__":
    sys.exit(main())
