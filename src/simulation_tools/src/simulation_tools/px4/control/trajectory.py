"""Jerk-limited motion along one axis, as PX4's VelocitySmoothing: the setpoints of the automatic modes.

From any velocity and acceleration to a wanted velocity in the least time: jerk for T1, constant acceleration
for T2, the opposite jerk for T3.
"""

from __future__ import annotations

import math


class SmoothAxis:
    """Position, velocity and acceleration of a point that follows a wanted velocity."""

    def __init__(self) -> None:
        self.position = self.velocity = self.acceleration = 0.0

    def start(self, position: float, velocity: float = 0.0, acceleration: float = 0.0) -> None:
        """Go on from here."""
        self.position, self.velocity, self.acceleration = position, velocity, acceleration

    def durations(
        self, wanted_velocity: float, acceleration_max: float, jerk_max: float
    ) -> tuple[float, float, float, float]:
        """Return the signed jerk and T1, T2, T3, seconds, of the fastest way to a velocity."""
        a, gap = self.acceleration, wanted_velocity - self.velocity
        # The final velocity if the acceleration is reduced at once.
        direction = math.copysign(1.0, gap - a * abs(a) / (2.0 * jerk_max))
        jerk = direction * jerk_max
        # Unlimited: rise to the peak from which falling to zero again ends at the wanted velocity.
        peak = direction * math.sqrt(max(0.5 * a * a + jerk * gap, 0.0))
        peak = min(max(peak, -acceleration_max), acceleration_max)
        t1, t3 = max((peak - a) / jerk, 0.0), abs(peak) / jerk_max
        if t1 == 0.0:
            peak, t3 = a, abs(a) / jerk_max  # above its limit already: fall from where it is
        gained = 0.5 * (a + peak) * t1 + 0.5 * peak * t3
        t2 = max((gap - gained) / peak, 0.0) if abs(peak) > 1e-9 else 0.0
        return jerk, t1, t2, t3

    def advance(self, wanted_velocity: float, acceleration_max: float, jerk_max: float, dt_s: float) -> None:
        """Move on by dt_s towards a wanted velocity."""
        jerk, t1, t2, t3 = self.durations(wanted_velocity, acceleration_max, jerk_max)
        left = dt_s
        for phase_jerk, duration in ((jerk, t1), (0.0, t2), (-jerk, t3)):
            t = min(left, duration)
            self._integrate(phase_jerk, t)
            left -= t
        if left > 0.0:
            self.velocity, self.acceleration = wanted_velocity, 0.0
            self.position += wanted_velocity * left

    def _integrate(self, jerk: float, t: float) -> None:
        self.position += t * (self.velocity + t * (0.5 * self.acceleration + t * jerk / 6.0))
        self.velocity += t * (self.acceleration + 0.5 * t * jerk)
        self.acceleration += jerk * t


def speed_that_stops_within(
    distance_m: float, acceleration_max: float, jerk_max: float, final_m_s: float = 0.0
) -> float:
    """Return the speed from which a point slows down to another within a distance.

    As in PX4, the time to build up the acceleration counts twice, for safety.
    """
    b = 4.0 * acceleration_max**2 / jerk_max
    c = 8.0 * acceleration_max * max(distance_m, 0.0) + 4.0 * final_m_s**2
    speed = 0.5 * (-b + math.sqrt(b * b + c))
    return max(speed, final_m_s) if final_m_s > 0.0 else speed
