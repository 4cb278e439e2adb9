"""Everything about the mesh gas that changes."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from billow.parts.gas.mesh.sheet import Sheet


@dataclass
class MeshState:
    """sheets: the gas of each room. joined: (rooms,) int64, of each the one that has taken it in, or itself. positions:
    of the surface [m], (nodes, 3). origin: of the lattice [m], (3,).
    Of the passages: is_open (passages,) bool; passed (passages, 2), mass [kg] gone from behind to ahead and back.

    Books, sums since the start: out and drawn (species,) [kg], to and from the surroundings; start_masses (species,)
    [kg]; energies [J]; jet_impulse [N s]. adopted, lost, donors: clusters taken in by others, without room, and redone
    as donor cells; inverted: largest volume that was inside out, of the volume then.
    """

    sheets: tuple[Sheet, ...]
    positions: np.ndarray
    origin: np.ndarray
    is_open: np.ndarray
    passed: np.ndarray
    out: np.ndarray
    drawn: np.ndarray
    volume: np.ndarray
    start_masses: np.ndarray
    joined: np.ndarray
    time: float = 0.0
    start_energy: float = 0.0
    enthalpy_in: float = 0.0
    enthalpy_out: float = 0.0
    work: float = 0.0
    ambient_work: float = 0.0
    heat_lost: float = 0.0
    jet_impulse: float = 0.0
    blocked_area: float = 0.0
    mass_error: float = 0.0
    energy_error: float = 0.0
    adopted: int = 0
    lost: int = 0
    donors: int = 0
    parts: int = 0
    inverted: float = 0.0

    # Made anew from the rest when needed: cells about the surface as it stands, and room for them.
    cuts = None
    windows = None
    longest = None
