"""Elements share the mass of their nodes so that the step is long, and no mode of the mesh is faster than it says."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest
from cloth import FABRICS, FLAT, KEEP, TRIANGLES, YARN
from curves import fabric as curve_fabric
from hypothesis import given
from hypothesis import strategies as st

from billow.case.bag.build_bag import build_shape
from billow.case.build import build_model
from billow.case.schema import Case
from billow.parts.fabric.mass_shares import share_mass
from billow.parts.fabric.membrane import Membrane
from billow.parts.part import GRAVITY_WORK, Booking
from billow.solver.run import Schedule, begin, run


def fastest(membranes) -> float:
    return max(float(membrane.squared_rate.max()) for membrane in membranes)


def mass_at_nodes(membranes, triangles, nodes: int, shared: bool) -> np.ndarray:
    """Of the elements' thirds, or of their shares [kg], (nodes,)."""
    mass = np.zeros(nodes)
    for membrane in membranes:
        light = membrane.lightness if shared else np.ones_like(membrane.lightness)
        np.add.at(mass, triangles[membrane.elements].astype(int), membrane.mass[:, None] / (3.0 * light))
    return mass


def highest_squared_frequency(membranes, triangles, mass) -> float:
    """Of the whole mesh in its plane, from its stiffness at rest and lumped masses [1/s^2]."""
    stiffness = np.zeros((2 * len(mass), 2 * len(mass)))
    for membrane in membranes:
        c11, c22, c12, c66 = membrane.fabric.stiffness + membrane.fabric.liner.stiffness
        moduli = np.array([[c11, c12, 0.0], [c12, c22, 0.0], [0.0, 0.0, c66]])
        for e, (d11, d12, d21, d22) in enumerate(membrane.reference_inverse.T):
            strain = np.zeros((3, 6))
            for corner, (x, y) in enumerate([(-d11 - d21, -d12 - d22), (d11, d12), (d21, d22)]):
                strain[:, 2 * corner : 2 * corner + 2] = [[x, 0.0], [0.0, y], [y, x]]
            at = np.ravel([[2 * node, 2 * node + 1] for node in triangles[membrane.elements[e]].astype(int)])
            stiffness[np.ix_(at, at)] += membrane.volume[e] * strain.T @ moduli @ strain
    root = np.repeat(mass, 2) ** -0.5
    return float(np.linalg.eigvalsh(root[:, None] * stiffness * root)[-1])


@given(seed=st.integers(0, 10_000))
def test_no_mode_of_a_mesh_is_faster_than_its_fastest_element(seed):
    """Patches of odd triangles and of two fabrics, one twice as thick, held against dense eigenvalues."""
    rng = np.random.default_rng(seed)
    flat = FLAT + rng.uniform(-0.002, 0.002, FLAT.shape)
    undamped = [dataclasses.replace(FABRICS[KEEP], damping=0.0), dataclasses.replace(FABRICS[YARN], damping=0.01)]
    parts = [np.array([0, 1, 2]), np.array([3])]
    membranes = [
        Membrane.build(fabric, own, flat[TRIANGLES[own]], thickness)
        for fabric, own, thickness in zip(undamped, parts, (3e-4, 6e-4), strict=True)
    ]
    mass = mass_at_nodes(membranes, TRIANGLES, 5, shared=False)
    shared = share_mass(membranes, TRIANGLES)
    assert mass_at_nodes(shared, TRIANGLES, 5, shared=True) == pytest.approx(mass, rel=1e-12)
    assert fastest(shared) <= fastest(membranes)
    assert fastest(shared) >= (1.0 - 1e-12) * highest_squared_frequency(membranes, TRIANGLES, mass) / 4.0


@pytest.mark.parametrize(("law", "gain"), [(FABRICS[YARN], 1.2), (curve_fabric(), 1.05)], ids=["linear", "curves"])
def test_the_step_of_an_uneven_mesh_is_longer(law, gain):
    """On a driver bag, against equal thirds. Curve laws gain less: their bound takes the lightest corner for all."""
    shape = build_shape(Case.from_dict({"bag": {"element_size": 0.04}}).bag)
    cloth = shape.surface.triangles_of_kind("fabric")
    thirds = Membrane.build(law, cloth, shape.reference[cloth])
    assert np.sqrt(fastest([thirds]) / fastest(share_mass([thirds], shape.surface.triangles))) > gain


def test_a_bag_that_is_shaken_at_its_full_step_stays_bounded():
    """Without damping, by compression too, nodes fly apart at random: a step beyond what is stable for any mode of the
    mesh lets that mode grow without end."""
    bag = {"element_size": 0.05}
    case = Case.from_dict({"bag": bag, "fabric": {"compression": True, "damping": 0.0}, "gas": {"model": "none"}})
    model = build_model(case)
    schedule = Schedule(0.03, 1, 1)
    state = begin(model, schedule)
    rng = np.random.default_rng(1)
    state.velocities[model.inverse_mass > 0.0] = rng.normal(size=(np.count_nonzero(model.inverse_mass), 3))
    start = 0.5 * float(model.mass @ np.sum(state.velocities**2, axis=1))
    state.ledger.book([Booking(GRAVITY_WORK, start)])  # the energy of the start, as if gravity had given it
    ledger = run(model, schedule, state=state).ledger
    assert ledger["kinetic"] + ledger["strain"] < 1.1 * start
