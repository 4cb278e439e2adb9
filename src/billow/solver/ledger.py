"""Where the energy is and where it went.

The balance closed every step is

    kinetic + strain + straps + contact springs + dissipated = start + work of gas, gravity and birth ramp,

with every term computed on its own: kinetic from velocities, strain from the fabric law, work from the gas' own books.
Its residual is a property of the whole solver; a wrong sign anywhere shows up in it.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass
class Ledger:
    """Energies [J] at the current time; dissipated ones and works are sums since the start.

    kinetic: fabric. body_kinetic: rigid bodies. strain: fabric. strap. contact: springs of the penalty contact.
    self_contact: springs between layers of fabric.
    damping: fabric, straps and mass damping together. hysteresis: fabric that unloads on another curve than it was
    loaded on. friction: contact damping and friction.
    birth_work: of a reference that moves from the start shape to the flat cut, and birth_slope, its last rate per
    fraction of the way.
    gas_work: net work of the gas on the fabric. gas_temperature: [K], and gas_volume: smallest of the chambers' volumes
    over those at the start [-], for the guards. gravity_work. start: total at
    time zero. residual: left minus right side of the balance. largest_gain, largest_loss: its extremes so far.
    largest_energy: largest of kinetic, internal and gas work so far, the denominator for relative errors.
    """

    kinetic: float = 0.0
    body_kinetic: float = 0.0
    strain: float = 0.0
    strap: float = 0.0
    contact: float = 0.0
    self_contact: float = 0.0
    damping: float = 0.0
    hysteresis: float = 0.0
    friction: float = 0.0
    birth_work: float = 0.0
    birth_slope: float = 0.0
    gas_work: float = 0.0
    gas_temperature: float = 0.0
    gas_volume: float = 1.0
    gravity_work: float = 0.0
    start: float | None = None
    residual: float = 0.0
    largest_gain: float = 0.0
    largest_loss: float = 0.0
    largest_energy: float = 0.0

    @property
    def internal(self) -> float:
        """Recoverable energy in fabric, straps and contact springs [J]."""
        return self.strain + self.strap + self.contact + self.self_contact

    def close(self) -> None:
        """Balance the books of a step."""
        stored = self.kinetic + self.body_kinetic + self.internal
        if self.start is None:
            self.start = stored
        dissipated = self.damping + self.hysteresis + self.friction
        self.residual = stored + dissipated - self.start - self.gas_work - self.gravity_work - self.birth_work
        self.largest_gain = max(self.largest_gain, self.residual)
        self.largest_loss = min(self.largest_loss, self.residual)
        self.largest_energy = max(
            self.largest_energy, self.kinetic + self.body_kinetic, self.internal, abs(self.gas_work), self.start
        )

    @property
    def relative_error(self) -> float:
        """Largest absolute residual over the largest energy so far [-]."""
        if self.largest_energy == 0.0:
            return 0.0
        return max(self.largest_gain, -self.largest_loss) / self.largest_energy
