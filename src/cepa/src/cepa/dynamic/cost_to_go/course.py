"""Where the reference leads: its direction, and its end if it has one in sight."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from cepa.dynamic.constants.choice import END_HORIZONS, LEVEL_CLIMB_M_S

NO_END = np.full(2, math.inf)


class Reference(NamedTuple):
    """The velocity that is asked for, along the odometry's axes."""

    velocity: np.ndarray
    """(3,) m/s"""
    speed: float
    """m/s, in the plane"""

    @property
    def direction(self) -> np.ndarray:
        """(2,) unit vector; zeros for a speed of zero."""
        return self.velocity[:2] / self.speed if self.speed else np.zeros(2)

    @property
    def is_steep(self) -> bool:
        """Whether it leads up or down rather than ahead."""
        return abs(self.velocity[2]) > max(self.speed, LEVEL_CLIMB_M_S)


class Course(NamedTuple):
    """Where a reference leads."""

    direction: np.ndarray
    """(2,) unit vector; zeros for a reference of zero."""
    end: np.ndarray = NO_END
    """(2,) m: from the UAV; inf: it is not in sight."""
    slowing: float = math.inf
    """1/s: the reference's speed for each metre to the end."""


def reference_of(velocity: np.ndarray) -> Reference:
    """Return the reference of a velocity (3,), m/s."""
    x, y, _ = velocity.tolist()
    return Reference(velocity, math.hypot(x, y))


def course_of(reference: Reference, gain_1_s: float, horizon_s: float) -> Course:
    """Return where the reference leads.

    gain_1_s: how much slower it is for each metre of way, see `Destination`. horizon_s: the cost's.
    """
    if reference.speed == 0.0 or gain_1_s * END_HORIZONS * horizon_s <= 1.0:
        return Course(reference.direction)
    return Course(reference.direction, reference.velocity[:2] / gain_1_s, gain_1_s)
