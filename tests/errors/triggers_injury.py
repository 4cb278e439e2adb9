"""What is wrong with curves whose injury metrics are asked for."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np

from billow.injury.criteria import assess_run
from billow.injury.filters import channel_filter
from billow.injury.rating import rate

TIMES = np.arange(501) * 1e-4
WAVE = np.sin(300.0 * TIMES)

TRIGGERS = {
    "E-INJ-001": lambda here: channel_filter(TIMES, WAVE[:-1], 60),
    "E-INJ-002": lambda here: channel_filter(TIMES, WAVE, 300),
    "E-INJ-003": lambda here: channel_filter(2.0 * TIMES, WAVE, 1000),
    "E-INJ-004": lambda here: rate(TIMES, WAVE, np.ones(501)),
    "E-INJ-005": lambda here: assess_run(SimpleNamespace(free_obstacles=(), folder=here.place)),
}
