"""Braking as hard as the UAV can, when something stands before it of which nobody knew."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.choice import DEEPER_M, HARD_BRAKING
from cepa.identification.response import ResponseModel


def is_too_late(clearance_m: np.ndarray, hull_m: float) -> bool:
    """Return whether a UAV that is told to stand comes too near to what stands, and nearer than it is.

    It then loses its speed with a time constant of 1 / `response_p`, and flies on by what it flies in that
    time. clearance_m (n,): of what stands, after each step. hull_m: of the body with its margin.
    """
    return float(clearance_m.min()) < min(hull_m, float(clearance_m[0]) - DEEPER_M)


def hardest_braking(velocity_m_s: np.ndarray, model: ResponseModel) -> np.ndarray:
    """Return the level command (3,), m/s, that brakes a level velocity (2,) hardest.

    A command against the velocity brakes harder than none: by p times the difference, until the greatest
    acceleration. At the end p is HARD_BRAKING + 1 times the usual one, and the UAV hardly flies back.
    """
    speed = math.hypot(*velocity_m_s)
    most = model.acceleration_max_m_s2 / (model.p * max(speed, 1e-9)) - 1.0
    x, y = (-min(HARD_BRAKING, max(0.0, most)) * velocity_m_s).tolist()
    return np.array((x, y, 0.0))
