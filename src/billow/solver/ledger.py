"""Where the energy is and where it went (docs/theory.md, Energy balance): the only place where energies are written.

Every term of motion + stored + lost = start + received is computed on its own, so that a wrong sign anywhere shows up
in the residual.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property

from billow.base.quality import SMALLER_STEPS, Criterion, criterion
from billow.parts.bodies.bodies import BODY_KINETIC
from billow.parts.part import DRIVE_WORK, LOST, MOTION, RECEIVED, STORED, Account, Booking, Quantity


@dataclass
class Ledger:
    """energies: of each account now, or its sum since the start, [J]. start: total at time zero. residual: left minus
    right side of the balance. largest_gain, largest_loss: its extremes so far. largest_energy: largest of motion,
    stored energy and received work so far, the denominator of relative errors."""

    energies: dict[str, float]
    start: float | None = None
    residual: float = 0.0
    largest_gain: float = 0.0
    largest_loss: float = 0.0
    largest_energy: float = 0.0
    accounts: tuple[Account, ...] = field(default=(), metadata={"constant": True})

    @classmethod
    def of(cls, accounts: Sequence[Account]) -> Ledger:
        """Empty books with these accounts, each once, side by side."""
        sides = MOTION, STORED, LOST, RECEIVED
        ordered = tuple(a for side in sides for a in dict.fromkeys(accounts) if a.side == side)
        return cls({account.name: 0.0 for account in ordered}, accounts=ordered)

    def __getitem__(self, name: str) -> float:
        """Energy of an account [J]; zero for one that no part has."""
        return self.energies.get(name, 0.0)

    def side(self, side: str) -> float:
        """Energy of all accounts of a side [J]."""
        total = 0.0
        for account in self.accounts:
            if account.side == side:
                total += self.energies[account.name]
        return total

    def open(self) -> None:
        """Begin a step: accounts that say how much there is now begin anew."""
        self.energies.update(self._anew)

    @cached_property
    def _anew(self) -> dict[str, float]:
        return {account.name: 0.0 for account in self.accounts if account.renewed}

    @cached_property
    def _names(self) -> tuple[tuple[str, ...], ...]:
        """Of the accounts of each side."""
        sides = MOTION, STORED, LOST, RECEIVED
        return tuple(tuple(account.name for account in self.accounts if account.side == side) for side in sides)

    def book(self, bookings: Iterable[Booking]) -> None:
        for account, energy in bookings:
            self.energies[account.name] += energy

    def close(self) -> None:
        """Balance the books of a step."""
        motion, stored, lost, received, largest = 0.0, 0.0, 0.0, 0.0, self.largest_energy
        energies, (in_motion, in_store, in_heat, from_outside) = self.energies, self._names
        for name in in_motion:
            motion += energies[name]
        for name in in_store:
            stored += energies[name]
        for name in in_heat:
            lost += energies[name]
        for name in from_outside:
            received += energies[name]
            largest = max(largest, abs(energies[name]))
        if self.start is None:
            self.start = motion + stored
        residual, largest = motion + stored + lost - self.start - received, max(largest, motion, stored, self.start)
        self.residual, self.largest_energy = residual, largest
        self.largest_gain = max(self.largest_gain, residual)
        self.largest_loss = min(self.largest_loss, residual)

    @property
    def relative_error(self) -> float:
        """Largest absolute residual over the largest energy so far [-]."""
        if self.largest_energy == 0.0:
            return 0.0
        return max(self.largest_gain, -self.largest_loss) / self.largest_energy

    # --- what a run says of it -------------------------------------------------------------------------------------

    def quantities(self) -> Iterator[Quantity]:
        for account in self.accounts:
            yield Quantity("", account.name, "J", self.energies[account.name])
        yield Quantity("", "energy_residual", "J", self.residual)

    def books(self, injected: float, history) -> dict[str, float]:
        """Entries for run.json. injected: enthalpy that the gas has brought [J]; history: `results.history.History`."""
        largest = max(self.largest_energy, 1e-300)
        stored = sum(history.energy(account.name) for account in self.accounts if account.side == STORED)
        worst = max(self.largest_gain, -self.largest_loss)
        # What drives gave to fabric and gas: their work, less what set bodies moving.
        moving = history.energy(BODY_KINETIC.name)
        driven = history.energy(DRIVE_WORK.name) - (moving - moving[0]).clip(min=0.0)
        return {
            "energy_residual_joule": self.residual,
            "energy_residual_of_injected": worst / injected if injected else 0.0,
            "energy_residual_of_largest": self.relative_error,
            "energy_gain_of_largest": self.largest_gain / largest,
            "energy_loss_of_largest": -self.largest_loss / largest,
            "largest_internal_energy_joule": float(stored.max()),
            "penalty_scale_joule": max(float(stored.max()), float(driven.max())),
        }

    @staticmethod
    def verdicts(books: Mapping[str, float]) -> Iterator[Criterion]:
        residual, gain = books["energy_residual_of_largest"], books["energy_gain_of_largest"]
        yield criterion("energy residual, of the largest energy", 100.0 * residual, 1.0, 5.0, "%", SMALLER_STEPS)
        yield criterion("energy gain, of the largest energy", 100.0 * gain, 1.0, 2.0, "%", SMALLER_STEPS)
