"""The verification cases by id, and how they are run.

Each case is a generator of `Measurement`s that runs the solver's own code and compares with a closed form or a
published number. To add a case, write the generator and enter it here.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator

from billow.apps.verification import (
    contact,
    coupon,
    fabric,
    gas,
    injury,
    mesh_film,
    mesh_gas,
    mesh_vents,
    mesh_waves,
    particles,
    tank,
    whole,
)
from billow.apps.verification.check import Check, Measurement
from billow.base.errors import BillowError, InputError

CASES: dict[str, Callable[[], Iterator[Measurement]]] = {
    "T1": gas.rigid_tank, "T2": gas.filling_at_constant_pressure, "T3": gas.choked_blow_down,
    "T4": gas.critical_flow, "T5": gas.isentropic_compression, "T6": gas.mixture_properties,
    "T1p": particles.rigid_tank, "T2p": particles.filling_at_constant_pressure, "T3p": particles.choked_blow_down,
    "T5p": particles.isentropic_compression,
    "T15": particles.maxwell, "T16": particles.flux, "T17": particles.relaxation,
    "T18": particles.mixture, "T19": particles.wall_noise, "T20": particles.leak_audit,
    "T1m": mesh_gas.rigid_tank, "T3m": mesh_gas.choked_blow_down, "T5m": mesh_gas.isentropic_compression,
    "T7": mesh_waves.shock_tube, "T9": mesh_waves.cold_gas_on_a_wall, "T10": mesh_waves.reflected_shock,
    "T11": mesh_waves.piston, "T12": mesh_gas.at_rest, "T13": whole.mesh_balance, "T14": mesh_gas.layers_in_a_cell,
    "M1": mesh_gas.breathing_sphere, "M2": mesh_gas.jet_on_a_plate, "M3": mesh_gas.turned_bag,
    "M4": mesh_waves.sound, "M5": mesh_waves.order,
    "M6": mesh_vents.vent_of_a_few_cells, "M7": mesh_waves.vortex,
    "M8": mesh_film.friction,
    "U1": gas.two_rooms, "U2": gas.chain, "U3": gas.stiff_chain, "U4": gas.blown_through,
    "U5": gas.cooling, "U5p": particles.cooling,
    "V1": tank.filling, "V2": tank.cooling, "V3": tank.inverse, "V4": tank.band,
    "S1": fabric.patch, "S3": fabric.vibrating_membrane, "S4": fabric.pressurised_shells,
    "S6": fabric.mylar_balloon, "S7": fabric.teabag, "S9": coupon.picture_frame, "S10": coupon.biaxial_cycle,
    "C1": contact.sphere_on_node, "C2": contact.incline, "C3": contact.super_ellipsoid_constants,
    "C4": contact.closest_points, "R1": contact.torque_free_top,
    "P3": whole.energy_balance, "I1": injury.half_sine_hic, "I3": injury.channel_classes,
}  # fmt: skip


UNKNOWN_CASE = InputError.declare(
    "E-CLI-030",
    "there is no verification case {ids}",
    where="the list of cases",
    why="no closed form is known under that id",
    remedy="choose from {known}",
)


def run_cases(ids: Iterable[str] | None = None, progress: Callable[[Check], None] | None = None) -> list[Check]:
    """Run the cases of these ids, all by default, in the order of `CASES`.

    progress: called with each check as soon as it is known. A case that the solver stops or refuses gives one failed
    check, so that the others are still run. The sum of `Check.seconds` is the total time.

    Raises InputError E-CLI-030 for an id that does not exist.
    """
    chosen = set(CASES if ids is None else ids)
    unknown = sorted(chosen - set(CASES))
    if unknown:
        raise UNKNOWN_CASE(ids=", ".join(unknown), known=", ".join(CASES))
    checks = []
    for name in (name for name in CASES if name in chosen):
        for check in _run(name, CASES[name]):
            checks.append(check)
            if progress is not None:
                progress(check)
    return checks


def _run(name: str, case: Callable[[], Iterator[Measurement]]) -> Iterator[Check]:
    begun = time.perf_counter()
    try:
        for m in case():
            numbers = (float(m.measured), float(m.expected), float(m.tolerance))
            yield Check(m.title, *numbers, name, time.perf_counter() - begun)
            begun = time.perf_counter()
    except BillowError as error:
        nan = float("nan")
        yield Check(f"stopped: {error.what}", nan, nan, 0.0, name, time.perf_counter() - begun)
