"""Billow in Python and notebooks: short help, results that draw themselves, the command as a module."""

from __future__ import annotations

import io
import pydoc
import subprocess
import sys
from importlib import resources

import numpy as np
import pytest
from PIL import Image

import billow
from billow.base.markup import table_of
from billow.case.schema import Case
from trust.small_surrogate import small_surrogate


def test_help_is_short_and_names_are_found():
    text = pydoc.plain(pydoc.render_doc(billow))
    assert len(text.splitlines()) < 80
    assert {"Case", "Run", "simulate", "train"} <= set(dir(billow))
    assert billow.Run is billow.Result


def test_types_are_told():
    assert resources.files("billow").joinpath("py.typed").is_file()


def test_the_command_is_a_module():
    done = subprocess.run([sys.executable, "-m", "billow", "--version"], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == billow.__version__


def test_a_run_is_loaded_drawn_and_shown(small_run):
    result = billow.Run.load(small_run.folder)
    figure = result.plot("pressure", "impactor_force")
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["pressure", "impactor force, resultant"]
    buffer = io.BytesIO()
    figure.savefig(buffer)
    assert np.ptp(np.array(Image.open(buffer))) > 100
    with pytest.raises(billow.BillowError, match="E-PIC-009"):
        result.plot("presure")
    html = result._repr_html_()
    assert "largest pressure" in html
    assert 'src="data:image/png;base64,' in html


def test_histories_as_a_table_of_pandas(small_run):
    table = small_run.to_pandas()
    assert (table.index == small_run.histories.time).all()
    assert (table["pressure [Pa]"] == small_run.gas.pressure).all()


def test_frames_as_a_dataset_of_xarray(small_run):
    frames = small_run.to_xarray()
    last = frames.sel(time=small_run.times[-1])
    assert (last.position.values == small_run.fabric.points(-1)).all()
    assert (frames.displacement.sel(axis="z").values == small_run.displacement[..., 2]).all()
    assert frames.gauge_pressure.attrs["units"] == "Pa"
    assert (frames.triangles.values == small_run.triangles).all()
    front = frames.stress.where(frames.part == small_run.fabric.part_names[0], drop=True)
    assert front.shape[1] == (small_run.fabric.part == 0).sum()


def test_cases_and_surrogates_show_themselves_as_text():
    html = Case.from_dict({"title": "<b>", "bag": {"element_size": 0.05}})._repr_html_()
    assert "&lt;b&gt;" in html
    assert "element_size = 0.05" in html
    assert "every default" in Case()._repr_html_()
    assert "Surrogate(" in small_surrogate()._repr_html_()
    assert table_of("<i>", [("<", ">")]).count("<i>") == 0
