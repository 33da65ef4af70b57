"""Which of what moves the UAV may meet."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.response import BRAKE_S, LONGEST_COMMIT_S, MEETING_S, PATH_STEP_S

FORESEEN_S = max(MEETING_S, LONGEST_COMMIT_S + BRAKE_S)
TIMES_S = PATH_STEP_S * np.arange(1, math.ceil(FORESEEN_S / PATH_STEP_S) + 1)


def threats(movers: np.ndarray, speed: float, near_m: float) -> np.ndarray:
    """Return those of ``movers`` (k, 6) that may come within ``near_m`` of a UAV, see `Surroundings`.

    speed: the greatest that the UAV may have, m/s, in any direction. No path that is foreseen comes so near
    to what is left out. So that changes neither what is admissible nor, over the same horizon, what it costs.
    """
    if not len(movers):
        return movers
    x, y, vx, vy, radius_m, growth = (column[:, None] for column in movers.T)
    apart_m = np.hypot(x + vx * TIMES_S, y + vy * TIMES_S) - radius_m - (growth + speed) * TIMES_S
    return movers[apart_m.min(axis=1) <= near_m]
