"""Where a UAV is, and how it moves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Motion:
    """The UAV at an instant, in the map's frame. speed: m/s.

    time_s: of a clock that nobody sets (see `SteadyTime`). turn_rate: of the heading, rad/s. The gimbal takes
    out roll and pitch.
    """

    time_s: float
    place_m: np.ndarray
    yaw_rad: float
    speed: float = 0.0
    turn_rate: float = 0.0
