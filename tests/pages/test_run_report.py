"""`billow report`: the verdict in a sentence at the top, and everything a run says of itself below."""

from __future__ import annotations

import shutil

import pytest
from typer.testing import CliRunner

from billow.base.quality import criterion
from billow.cli.main import app
from billow.injury.criteria import assess
from billow.pages.run_report import acceptance
from billow.pictures.highlights import highlights
from billow.results.run_file import read_run_file, write_run_file
from billow.run.simulate import simulate

HOSTILE = "</script><img src=x onerror=alert(1)>"


@pytest.fixture(scope="module")
def run(small_case, tmp_path_factory):
    """A run dense enough for injury metrics."""
    return simulate(small_case.vary({"run.histories_per_frame": 50}), tmp_path_factory.mktemp("report") / "run")


def record(*criteria, status="completed", reason=None):
    verdict = max((c.verdict for c in criteria), key=("PASS", "REVIEW", "FAIL").index, default="PASS")
    return {
        "status": status, "reason": reason, "quality": {"verdict": verdict, "criteria": [c.record() for c in criteria]},
    }  # fmt: skip


def test_the_sentence_says_what_to_try():
    good = criterion("mass error of the gas", 1e-15, 1e-12, 1e-9, "-", "a smaller step")
    bad = criterion("energy residual", 3.0, 1.0, 5.0, "%", "a smaller run.dt_scale")
    assert acceptance(record(good)) == "The run is complete, and passes all 1 criteria of quality."
    told = acceptance(record(good, bad))
    assert "asks for a review: energy residual is 3 %, try a smaller run.dt_scale." in told
    told = acceptance(record(criterion("x", float("nan"), 1.0, 2.0, "-", "y"), status="stopped", reason="E-SOL-001"))
    assert told.startswith("The run was stopped: E-SOL-001, and fails: x is not finite")
    assert "no verdict" in acceptance({"status": "completed", "reason": None})


def test_peaks_and_injury_metrics_are_those_of_the_run(run):
    told = dict(highlights(run))
    pressure = run.gas.pressure
    assert told["largest pressure"].startswith(f"{1e-3 * pressure.max():.4g} kPa at")
    injury = assess(run.histories.time, run.body("impactor").velocity)
    assert told["HIC15 of impactor"].startswith(f"{injury.hic15.value:.4g},")
    assert "largest impactor force" in told


def test_a_run_that_is_too_coarse_for_injury_metrics_says_so(small_case, tmp_path):
    coarse = simulate(small_case.vary({"run.end_time": 0.002}), tmp_path / "run")
    assert dict(highlights(coarse))["injury metrics of impactor"].startswith("none: ")


def test_the_page_opens_and_holds_what_the_run_says(open_page, run, tmp_path):
    told = read_run_file(run.folder)
    copy = shutil.copytree(run.folder, tmp_path / "copy")
    changed = {name: value for name, value in told.items() if name not in ("files", "record_sha256")}
    (copy / "run.json").unlink()
    write_run_file(copy, changed | {"title": HOSTILE, "assumptions": [HOSTILE]})
    done = CliRunner().invoke(app, ["report", str(copy), "--out", str(tmp_path / "page.html")])
    assert done.exception is None, done.exception
    page = open_page(tmp_path / "page.html")
    assert page.page.locator("h1").inner_text() == HOSTILE
    assert f"typical, not measured: {HOSTILE}" in page.page.locator("ul").inner_text()
    assert page.page.locator(".acceptance").inner_text() == acceptance(told)
    assert page(
        "[...document.querySelectorAll('img')].every((img) => img.src.startsWith('data:') && img.naturalWidth > 0)"
    )
    links = page("[...document.querySelectorAll('.contents a')].map((a) => a.getAttribute('href').slice(1))")
    assert page("(ids) => ids.every((id) => document.getElementById(id))", links)
    assert "injected" in page.page.locator("#boxes").text_content()
