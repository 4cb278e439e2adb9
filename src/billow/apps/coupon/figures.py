"""Pictures of a bench test: stress against strain of every law and of the test data, and how the specimen looks."""

from __future__ import annotations

import io
from collections.abc import Mapping
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure

from billow.apps.coupon.bench import Measured
from billow.results.atomic import write_atomically

COLOURS = {"linear": "#b0722a", "curves": "#2a6fb0", "curves-shear": "#2a9050"}


def stress_strain(
    path: Path, title: str, measured: Mapping[str, Measured], data: Mapping[str, tuple[np.ndarray, np.ndarray]]
) -> None:
    """One panel a curve. measured: law -> test; data: curve -> (strain, stress [Pa])."""
    curves = next(iter(measured.values())).curves
    figure = Figure(figsize=(5.6 * len(curves), 4.2), layout="constrained")
    for k, (axes, curve) in enumerate(zip(np.atleast_1d(figure.subplots(1, len(curves))), curves, strict=True)):
        scale = 180.0 / np.pi if curve == "shear" else 100.0
        if curve in data:
            strain, stress = data[curve]
            axes.plot(scale * strain, 1e-6 * stress, "ko", markersize=3.5, label="test data")
        for law, test in measured.items():
            colour = COLOURS.get(law, "#666666")
            axes.plot(scale * test.strain[:, k], 1e-6 * test.stress[:, k], color=colour, linewidth=1.3, label=law)
        axes.set_xlabel("shear angle [deg]" if curve == "shear" else "true strain [%]")
        axes.set_ylabel("shear stress [MPa]" if curve == "shear" else "true stress [MPa]")
        axes.set_title(f"{title}: {curve}")
        axes.grid(alpha=0.3)
        axes.legend(frameon=False)
    _save(figure, path)


def _save(figure: Figure, path: Path) -> None:
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=130)
    write_atomically(path, buffer.getvalue())
