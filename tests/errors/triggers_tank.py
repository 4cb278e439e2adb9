"""What is wrong with a tank test or its trace."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from here import Here

from billow.apps.tank.evaluate import evaluate, measured, predict_case, warnings
from billow.apps.tank.tank_case import TankCase

SOUND = {
    "tank": {"volume": 0.06},
    "inflator": {
        "gas": {"N2": 1.0},
        "temperature": 600.0,
        "mass_flow": {"time": [0.0, 0.01, 0.04], "value": [0.0, 1.5, 0.0]},
    },
    "measurement": {"pressure": "absolute"},
}


def changed(**tables: dict) -> dict:
    """The sound case with keys of its tables changed; None removes a key."""
    data = {name: SOUND.get(name, {}) | tables.get(name, {}) for name in {*SOUND, *tables}}
    return {name: {k: v for k, v in table.items() if v is not None} for name, table in data.items()}


def case(**tables: dict) -> Callable[[Here], object]:
    return lambda here: TankCase.from_dict(changed(**tables))


def trace(change: Callable = lambda t, p: None, header: str = "time [s],pressure [Pa]", **tables: dict):
    """Evaluate a sound trace after a change to its times and pressures in place."""

    def trigger(here: Here):
        state = predict_case(TankCase.from_dict(SOUND))
        times, pressure = state.times[::5].copy(), state.pressure[::5].copy()
        change(times, pressure)
        rows = "".join(f"{t!r},{p!r}\n" for t, p in zip(times.tolist(), pressure.tolist(), strict=True))
        tank_case = TankCase.from_dict(changed(**tables))
        found = measured(tank_case, here.write("trace.csv", f"{header}\n{rows}"))
        return next(iter(warnings(tank_case, found, evaluate(tank_case, found))), None)

    return trigger


def falls(times, pressure):
    pressure[times > 0.05] *= 0.95


def no_rise(times, pressure):
    pressure[:] = 101325.0 + 100.0 * np.random.default_rng(0).standard_normal(len(times))


def rings(times, pressure):
    pressure += 1500.0 * np.sin(2.0 * np.pi * times / 0.004)


def repeats(times, pressure):
    times[7] = times[6]


def negative(times, pressure):
    pressure -= 101325.0 + 5000.0


UNTOLD = {"temperature": None}

TRIGGERS: dict[str, Callable[[Here], object]] = {
    "E-TANK-001": lambda here: TankCase.load(here.write("tank.toml", "volume =")),
    "E-TANK-002": case(tank={"volume": 60.0}),
    "E-TANK-003": case(inflator={"gas": {"xenon": 1.0}}),
    "E-TANK-004": case(inflator={"gas": {"N2": 0.5, "CO2": 0.4}}),
    "E-TANK-005": trace(header="time [s]"),
    "E-TANK-006": trace(header="time [s],pressure"),
    "E-TANK-007": trace(repeats),
    "E-TANK-008": trace(negative),
    "E-TANK-009": trace(measurement={"pressure": "gauge"}),
    "E-TANK-010": trace(falls),
    "E-TANK-011": trace(no_rise),
    "E-TANK-012": trace(inflator=UNTOLD),
    "E-TANK-013": trace(inflator=UNTOLD | {"total_mass": 0.002}),
    "W-TANK-001": trace(rings, tank={"wall_area": 0.9, "heat_transfer": 0.01}),
    "W-TANK-002": trace(inflator={"total_mass": 0.060}),
}
