"""Scenes and tools for tests of the whole solver: a free bag against a free body, fingerprints, silent recorders."""

from __future__ import annotations

import dataclasses
import hashlib

import numpy as np

from billow.geometry.bag_shapes import square_bag
from billow.geometry.shapes.super_ellipsoid import principal_inertia
from billow.geometry.surface import nodal_share
from billow.parts.bodies.rigid_body import RigidBody, RigidState, quaternion_about
from billow.parts.bodies.rigid_contact import SuperEllipsoid, SurfaceLaw
from billow.parts.fabric.linear_law import LinearFabric
from billow.parts.fabric.membrane import Membrane
from billow.parts.gas.no_gas import NoGas
from billow.parts.straps import NO_STRAPS
from billow.solver.model import Model, Obstacle


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
    body = RigidBody(0.05, principal_inertia(0.05, radii, 3.0), locked=False)
    return Model(
        surface=shape.surface,
        start=np.ascontiguousarray(shape.positions),
        membranes=(membrane,),
        straps=NO_STRAPS,
        gas=NoGas(),
        obstacles=(Obstacle("body", SuperEllipsoid(radii, 3.0), SurfaceLaw(slope, friction, damping), body, start),),
        mass=nodal_share(corners, membrane.mass, nodes),
        contact_area=nodal_share(corners, membrane.volume / fabric.thickness, nodes),
        fixed=np.zeros(nodes, dtype=bool),
        gravity=np.array(gravity),
    )


class Silent:
    """A recorder that writes nothing; `steps` is called after every step."""

    def __init__(self, steps=lambda model, state: None):
        self.step = steps

    def history(self, model, state) -> None:
        pass

    def frame(self, model, state) -> None:
        pass


def fingerprint(state) -> str:
    """SHA-256 over everything in a state: arrays, numbers, gas, bodies, contacts, ledger."""
    digest = hashlib.sha256()

    def take(value):
        if dataclasses.is_dataclass(value):
            for field in dataclasses.fields(value):
                digest.update(field.name.encode())
                take(getattr(value, field.name))
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
