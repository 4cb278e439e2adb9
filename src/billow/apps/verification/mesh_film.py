"""M8: friction of the mesh gas in films (docs/theory.md, Verification cases)."""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Iterator

import numpy as np

from billow.apps.verification.check import Measurement
from billow.apps.verification.gas import GAMMA, GAS_CONSTANT
from billow.apps.verification.mesh_gas import ATMOSPHERE, SOUND, WARM, books, carry, force_on, mesh_in, moved, still
from billow.apps.verification.mesh_waves import along, set_gas
from billow.apps.verification.scenes import box
from billow.parts.gas.gas_model import Bag
from billow.parts.gas.mesh.mesh_gas import MeshGas

CELL, WIDE = 0.025, 0.11
VISCOSITY = 1.846e-5
"""Of air at 300 K [Pa s] (Kadoya, Matsunaga and Nagashima, J. Phys. Chem. Ref. Data 14 (1985) 947)."""
DENSITY = ATMOSPHERE / (GAS_CONSTANT * WARM)


def film(width: float, depth: float, height: float) -> tuple[MeshGas, Bag]:
    """The gas of a box [m] with friction."""
    shape = box(width, depth, height)
    bag = Bag(shape.surface, shape.positions, np.zeros_like(shape.positions))
    return dataclasses.replace(mesh_in(bag, CELL), film_friction=True), bag


def damped_wave(apart: float = 6e-4, amplitude: float = 1e-3) -> Iterator[Measurement]:
    """Sound along 1 m between plates, first mode: p'' + K p' + w^2 p = 0, K = 12 mu/(rho h^2), w = pi c/L. What walls
    and gas have of momentum is that of the start, none."""
    gas, bag = film(WIDE, apart, 1.0)
    state = gas.start(bag)

    def profile(z):
        wave = amplitude * np.cos(math.pi * z)
        return DENSITY * (1.0 + wave / GAMMA), 0.0 * z, ATMOSPHERE * (1.0 + wave)

    set_gas(gas, state, profile)
    omega, rate = math.pi * SOUND, 12.0 * VISCOSITY / (DENSITY * apart**2)
    slow = math.sqrt(omega**2 - 0.25 * rate**2)
    impulse, before, last = 0.0, 0.0, None
    for time in still(gas, state, math.pi / slow):
        now = state.sheets[0].force.sum(axis=(0, 1))[2]
        last = now if last is None else last
        impulse, before, last = impulse + 0.5 * (time - before) * (last + now), time, now
    z, volume, _, _, pressure = along(gas, state)
    mode = 2.0 * float(volume @ ((pressure / ATMOSPHERE - 1.0) * np.cos(math.pi * z))) / volume.sum() / amplitude
    exact = math.exp(-0.5 * rate * time) * (math.cos(slow * time) + 0.5 * rate / slow * math.sin(slow * time))
    yield Measurement("mode of sound between plates after half a period", mode, exact, 2e-2)
    most = amplitude * ATMOSPHERE / SOUND * volume.sum() * CELL**3
    whole = (impulse + float(state.sheets[0].held[:, 3].sum())) / most
    yield Measurement("momentum of gas and walls, of the wave's [absolute]", whole, 0.0, 1e-2)
    yield from books(state)


def sliding_plate(apart: float = 6e-4, speed: float = 5.0) -> Iterator[Measurement]:
    """A lid that slides at a speed over gas at half of it is held back by mu v/h (Couette)."""
    gas, bag = film(WIDE, WIDE, apart)
    state = gas.start(bag)
    carry(state, np.array([0.5 * speed, 0.0, 0.0]))

    def at(time):
        return bag.positions + np.outer(bag.positions[:, 2] / apart, [speed * time, 0.0, 0.0])

    for _ in moved(gas, state, at, 2e-5, longest=1e-5):
        pass
    yield Measurement("force on a lid that slides [N]", force_on(gas, state, "lid")[0],
                      -VISCOSITY * speed / apart * WIDE**2, 2e-2)  # fmt: skip
    yield from books(state)


def plates_in_a_wind(apart: float = 2.5e-3) -> Iterator[Measurement]:
    """Gas that flows between plates: on both of them 12 mu U/h, or by Blasius' law of channels."""
    for speed in (2.0, 100.0):
        gas, bag = film(WIDE, apart, 1.0)
        state = gas.start(bag)
        carry(state, np.array([0.0, 0.0, speed]))
        for _ in moved(gas, state, lambda _, places=bag.positions: places, 1e-5):
            pass
        ends = np.ptp(bag.positions[bag.surface.triangles][:, :, 2], axis=1) == 0.0
        reynolds = 2.0 * DENSITY * speed * apart / VISCOSITY
        shear = 6.0 * VISCOSITY * speed / apart
        if reynolds > 2300.0:
            shear = 0.5 * DENSITY * speed**2 * 0.0791 / reynolds**0.25
        found = state.sheets[0].force[~ends].sum(axis=(0, 1))[2]
        yield Measurement(f"drag of plates at Re = {reynolds:.0f} [N]", found, shear * 2.0 * (WIDE + apart), 3e-2)


def friction() -> Iterator[Measurement]:
    """M8."""
    yield from damped_wave()
    yield from sliding_plate()
    yield from plates_in_a_wind()
