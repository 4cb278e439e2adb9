"""`billow tank`: predict and evaluate closed-tank tests of inflators."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(
    name="tank",
    no_args_is_help=True,
    rich_markup_mode="rich",
    help="""Tank tests: an inflator fires into a closed rigid tank, and the pressure is measured.

A first round:

\b
  billow tank forward examples/tank/tank_test.toml --out predicted
  billow tank inverse examples/tank/tank_measured.csv \\
      --case examples/tank/tank_test.toml --out found

The second finds mass flow and band; found/inflator.toml can be pasted into a case. docs/tank.md: equations and keys.
""",
)

CaseFile = Annotated[Path, typer.Argument(help="Tank case (TOML): tables [tank] and [inflator]; docs/tank.md.")]
Out = Annotated[Path, typer.Option(help="Result folder; must not exist yet.")]


@app.command()
def forward(case_file: CaseFile, out: Out) -> None:
    """Predict pressure and temperature of a tank test from mass flow and temperature of the inflator.

    Writes trace.csv, summary.toml and tank.png. Without loss to the wall the result is exact thermodynamics.
    """
    from billow.apps.tank.evaluate import predict_case
    from billow.apps.tank.folder import write_prediction
    from billow.apps.tank.tank_case import TankCase
    from billow.results.atomic import new_place

    new_place(out)
    case = TankCase.load(case_file)
    state = predict_case(case)
    write_prediction(case, state, out)
    print(
        f"{state.mass[-1]:.5g} kg delivered; peak {state.pressure.max() / 1e3:.5g} kPa absolute; "
        f"at the end {state.pressure[-1] / 1e3:.5g} kPa, {state.temperature[-1]:.5g} K\n{out}: written"
    )


@app.command()
def inverse(
    trace_file: Annotated[
        Path, typer.Argument(help="Trace (CSV) with a header such as: time \\[ms],pressure \\[kPa]; docs/tank.md.")
    ],
    case_file: Annotated[
        Path, typer.Option("--case", help="Tank case (TOML): the tank, the gas, and what is known of its temperature.")
    ],
    out: Out,
) -> None:
    """Find the mass flow of an inflator, with a 95 % band, from the pressure measured in a tank.

    The temperature of the inflow is that of \\[inflator]; without one, it is found from the weighed total_mass; without
    that, from a column 'gas temperature \\[K]' of the trace. \\[measurement] says whether the pressure is absolute.

    Writes flow.csv, fit.csv, inflator.toml (to paste into a case), summary.toml and tank.png.
    """
    from billow.apps.tank.evaluate import evaluate, measured, warnings
    from billow.apps.tank.folder import write_evaluation
    from billow.apps.tank.tank_case import TankCase
    from billow.results.atomic import new_place

    new_place(out)
    case = TankCase.load(case_file)
    trace = measured(case, trace_file)
    found = evaluate(case, trace)
    write_evaluation(case, trace, found, out)
    for warning in warnings(case, trace, found):
        print(warning, file=sys.stderr)
    print(
        f"mass {1e3 * found.mass:.4g} g +- {1e3 * found.mass_half_width:.2g} g (95 %), "
        f"peak {found.flow.max():.4g} kg/s, pressure noise {found.noise:.0f} Pa, "
        f"time resolution {1e3 * found.resolution:.2g} ms\n{out}: written"
    )
