import io
import re

from fake_solver import Fails, simulate
from rich.console import Console

from billow.study.progress import clock, study_progress


def shown(study, terminal, runner):
    console = Console(file=io.StringIO(), force_terminal=terminal, width=100, highlight=False, color_system=None)
    with study_progress(console) as report:
        study.run(workers=1, progress=report, runner=runner)
    return console.file.getvalue()


def test_plain_lines_tell_done_total_elapsed_eta(study):
    lines = shown(study, False, Fails(study.runs["0001"][0], "error")).splitlines()
    assert lines[0] == "study started: 6 of 6 runs to make, by 1 worker"
    assert re.fullmatch(r"\[1/6\] run 0000 completed in \d+\.\d s; elapsed 0:0\d, ETA 0:0\d", lines[1])
    assert lines[2].startswith("[2/6] run 0001 failed: E-STU-016: the simulation ended with ZeroDivisionError; a bug")
    assert lines[-1].startswith("study finished: 5 runs completed; 1 failed in 0:0")
    assert len(lines) == 8


def test_a_terminal_gets_a_bar_and_lines_only_for_what_is_not_routine(study):
    text = shown(study, True, simulate)
    assert "6/6" in text
    assert "ETA 0:00" in text
    assert "run 0000 completed" not in text


def test_clock():
    assert [clock(s) for s in (0.4, 75.0, 3700.0)] == ["0:00", "1:15", "1:01:40"]
