"""Scenes and tools for tests of the whole solver: a free bag against a free body, fingerprints, silent recorders."""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np

from billow.geometry.bag_shapes import square_bag
from billow.geometry.shapes.pose import quaternion_about
from billow.geometry.shapes.super_ellipsoid import SuperEllipsoid
from billow.geometry.surface import nodal_share
from billow.parts.bodies.bodies import Bodies
from billow.parts.bodies.body import Body
from billow.parts.bodies.contact import SurfaceLaw
from billow.parts.bodies.rigid_body import RigidBody, RigidState
from billow.parts.fabric.fabric import Fabric
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.gas_part import GasPart
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model
from billow.solver.run import Recorder


def free_model(*, slope=2e4, friction=0.3, damping=0.1, gravity=(0.0, 0.0, 0.0), apart=0.0) -> Model:
    """An empty square bag at rest and a small spinning super-ellipsoid that flies into it; nothing is held.

    apart: extra distance between them [m].
    """
    shape = square_bag(0.3, 8, 0.04)
    fabric = LinearFabric(800.0, 3e-4, 4e8, 3e8, 0.2, 2e7, compression=False, damping=0.5 * damping)
    membrane = Membrane.build(fabric, np.arange(shape.surface.triangle_count), shape.reference)
    corners, nodes = shape.surface.triangles.astype(np.int64), shape.surface.node_count
    radii = np.array([0.06, 0.05, 0.04])
    start = RigidState(
        np.array([0.03, -0.02, 0.02 + 0.065 + apart]),
        quaternion_about(np.array([1.0, 0.0, 0.0]), 0.4),
        np.array([2.0, 1.0, -20.0]),
        np.array([2e-4, -3e-4, 1e-4]),
    )
    ellipsoid = SuperEllipsoid(radii, 3.0)
    rigid = RigidBody(0.05, ellipsoid.inertia(0.05), locked=False)
    body = Body.of("body", ellipsoid, SurfaceLaw(slope, friction, damping), rigid, start)
    positions, contact_area = np.ascontiguousarray(shape.positions), membrane.volume / fabric.thickness
    return Model(
        surface=shape.surface,
        start=positions,
        mass=nodal_share(corners, membrane.mass, nodes),
        fixed=np.zeros(nodes, dtype=bool),
        gravity=np.array(gravity),
        gas=GasPart(NoGas(), shape.surface, positions),
        fabric=Fabric(shape.surface, (membrane,)),
        straps=NO_STRAPS,
        bodies=Bodies((body,), nodal_share(corners, contact_area, nodes), np.array(gravity)),
    )


class EachStep(Recorder):
    """A recorder that calls `look(model, state)` after every step."""

    def __init__(self, look):
        self.step = look


def fingerprint(state) -> str:
    """SHA-256 over everything in a state: arrays, numbers, gas, bodies, contacts, ledger."""
    digest = hashlib.sha256()

    def take(value):
        if dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                if "constant" not in field.metadata:
                    digest.update(field.name.encode())
                    take(getattr(value, field.name))
        elif isinstance(value, dict):
            for name, item in value.items():
                digest.update(name.encode())
                take(item)
        elif isinstance(value, tuple | list):
            for item in value:
                take(item)
        elif value is None:
            digest.update(b"none")
        else:
            array = np.asarray(value)
            assert array.dtype.kind in "biuf", f"not covered: {value!r}"
            digest.update(array.tobytes())

    take(state)
    return digest.hexdigest()
