"""I1 and I3: injury metrics against closed forms."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from scipy.optimize import brentq

from billow.apps.verification.check import Measurement
from billow.injury.criteria import GRAVITY, head_injury
from billow.injury.filters import channel_filter


def half_sine_hic() -> Iterator[Measurement]:
    """I1: HIC of a half sine of height A [g] and length T [s]. A window of width u T about the middle has the mean (2
    A/pi u) sin(pi u/2). Its HIC is T A^2.5 u [(2/pi u) sin(pi u/2)]^2.5, largest where tan(x) = (5/3) x with x = pi
    u/2: u = 0.670, HIC = 0.41465 A^2.5 T."""
    height, length, samples = 80.0, 12e-3, 601
    times = np.linspace(0.0, length, samples)
    found = head_injury(times, GRAVITY * height * np.sin(np.pi * times / length), 0.036)
    x = brentq(lambda x: np.tan(x) - 5.0 / 3.0 * x, 0.5, 1.5)
    u = 2.0 * x / np.pi
    exact = height**2.5 * length * u * (np.sin(x) / x) ** 2.5
    yield Measurement("HIC of a half sine [-]", found.value, exact, 1e-3)
    yield Measurement("its window / T [-]", (found.end - found.start) / length, u, 5e-3)


def channel_classes() -> Iterator[Measurement]:
    """I3: CFC 180 and CFC 1000 lose 3 dB at 1.667 times their class (SAE J211-1), sampled at 100 times the class."""
    for channel_class in (180, 1000):
        times = np.arange(20_001) / (100.0 * channel_class)
        middle = slice(5000, 15_000)

        def loss(frequency, times=times, channel_class=channel_class, middle=middle):
            angle = 2.0 * np.pi * frequency * times
            out = channel_filter(times, np.sin(angle), channel_class)[middle]
            waves = np.stack([np.sin(angle[middle]), np.cos(angle[middle])], axis=1)
            return 20.0 * np.log10(np.linalg.norm(np.linalg.lstsq(waves, out, rcond=None)[0])) + 3.0

        corner = brentq(loss, channel_class, 3.0 * channel_class, xtol=1e-3 * channel_class)
        yield Measurement(f"-3 dB of CFC {channel_class} [Hz]", corner, 5.0 / 3.0 * channel_class, 0.02)
