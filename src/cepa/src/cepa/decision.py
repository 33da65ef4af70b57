"""What CEPA answers, and why."""

from __future__ import annotations

import enum
from typing import NamedTuple

Vector2 = tuple[float, float]


class Reason(enum.Enum):
    """The reason for an answer."""

    CUSHION_CLEAR = "cushion clear"
    """Nothing intrudes on the outer cushion along v_ref: v_out = v_ref (algorithm 2, lines 8-9)."""
    STEERED = "steered"
    """The least costly candidate (equation 6.6)."""
    BLOCKED = "blocked"
    """No direction is free: zero velocity. In an emergency: no open section."""
    BRAKING = "braking"
    """Dynamic only: no other velocity is admissible."""
    NO_WAY = "no way"
    """Dynamic only: all ways out of the window are closed; zero velocity."""
    MARGIN_LOST = "margin lost"
    """Dynamic only: an obstacle is nearer than the margin allows; the answer leads away from it."""
    NO_REFERENCE = "no reference"
    """|v_ref| is too small for equation 6.5 to be defined: zero velocity."""
    EMERGENCY_SUM = "emergency sum"
    """Something is within r_LB; the answer is the sum of the intrusions (thesis 6.1.2)."""
    EMERGENCY_OPEN_SECTION = "emergency open section"
    """As before, but the sum led into an obstacle or cancelled out: the middle of an open section (6.2.2)."""


class Decision(NamedTuple):
    """A velocity, and the reason for it.

    Velocities are in m/s in the frame of the scan (x forward, y left).
    """

    velocity_xy: Vector2
    emergency: bool
    cost: float
    """Equation 6.5 at the answer; inf when blocked, nan in an emergency, 0 without a reference."""
    directions_tested: int
    """Number of candidate velocities whose full cost (equation 6.5) was computed."""
    reason: Reason
    emergency_original_xy: Vector2 | None = None
    """In an emergency: what the original algorithm answers (the red arrow of figure 8.6)."""
    emergency_improved_xy: Vector2 | None = None
    """In an emergency met by ``Improved``: what it answers (the green arrow)."""
    climb_m_s: float | None = None
    """Vertical velocity to fly, m/s upwards; None: the reference's."""
    warnings: tuple[str, ...] = ()
    """Sentences about the sensors that the user should read; each comes once, with the first answer."""
