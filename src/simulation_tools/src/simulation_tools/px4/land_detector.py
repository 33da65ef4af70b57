"""PX4's land detector for multirotors: ground contact, then maybe landed, then landed.

Ground contact: the setpoint asks to sink (until landed), thrust is low, nothing moves. Maybe landed: thrust
is minimal and nothing turns. Each stage must last for a third of LNDMC_TRIG_TIME. It ends at once.

A setpoint asks to sink if its downward velocity is at least 0.9 MPC_LAND_SPEED. With a smaller one, or with a
position below the ground, the vehicle counts as in the air for ever, as in PX4. Attitude and rates setpoints
have no speed, so for them low thrust is enough.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulation_tools.px4.parameters import Px4Parameters

_LAND_SPEED_SHARE = 0.9  # of MPC_LAND_SPEED: a velocity setpoint that asks to land
_JUST_LANDED_S = 2.0  # while the rotors spool down, the limits of motion are wider for this time
_JUST_LANDED_SLACK = 2.5
_MANUAL_THRUST_SLACK = 0.01


@dataclass
class _Stage:
    """A condition that must be true for some time before it counts."""

    state: bool = True
    held_s: float = 0.0

    def update(self, condition: bool, needed_s: float, dt_s: float) -> bool:
        self.held_s = self.held_s + dt_s if condition else 0.0
        self.state = condition and (self.state or self.held_s >= needed_s)
        return self.state


class LandDetector:
    """`ground_contact`, `maybe_landed` and `landed` say how sure it is that the vehicle stands."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Stand on the ground."""
        self._contact, self._maybe, self._landed = _Stage(), _Stage(), _Stage()
        self._maybe_for_s = _JUST_LANDED_S  # it has been on the ground for long
        self._in_descent = self._hover_thrust_known = False
        self.ground_contact = True
        """Whether the ground stops the vehicle from sinking."""
        self.maybe_landed = True
        """Whether it most likely stands on the ground."""
        self.landed = True
        """Whether it stands on the ground."""

    def update(
        self,
        armed: bool,
        estimate: np.ndarray,
        sinking_m_s: float | None,
        thrust: float,
        hover_thrust: float,
        hover_thrust_valid: bool,
        dt_s: float,
    ) -> None:
        """Take in one instant.

        estimate: record of ESTIMATE_DTYPE, shape (1,). sinking_m_s: the downward velocity setpoint; NaN: not
        set; None: the climb rate is not controlled. thrust, hover_thrust: 0..1.
        """
        if not armed:
            self.reset()
            return
        needed_s = self._parameters["LNDMC_TRIG_TIME"] / 3.0
        land_speed = _LAND_SPEED_SHARE * max(self._parameters["MPC_LAND_SPEED"], 0.1)
        if hover_thrust_valid or not self._in_descent:
            self._hover_thrust_known = hover_thrust_valid
        self._in_descent = sinking_m_s is not None and sinking_m_s >= land_speed
        just_landed = self.maybe_landed and self._maybe_for_s < _JUST_LANDED_S
        asked = self._in_descent or sinking_m_s is None or self.maybe_landed or self.landed
        contact = asked and self._has_low_thrust(thrust, hover_thrust)
        contact = contact and not self._moves(estimate["velocity"][0].tolist(), land_speed, just_landed)
        still = self._has_minimal_thrust(thrust, hover_thrust, sinking_m_s is not None)
        still = still and not self._turns(estimate["rates"][0].tolist(), just_landed)

        self.ground_contact = self._contact.update(contact, needed_s, dt_s)
        self.maybe_landed = self._maybe.update(still and self.ground_contact, needed_s, dt_s)
        self.landed = self._landed.update(self.maybe_landed, needed_s, dt_s)
        self._maybe_for_s = self._maybe_for_s + dt_s if self.maybe_landed else 0.0

    def _has_low_thrust(self, thrust: float, hover_thrust: float) -> bool:
        least = self._parameters["MPC_THR_MIN"]
        return thrust <= least + (hover_thrust - least) * (0.6 if self._hover_thrust_known else 0.3)

    def _has_minimal_thrust(self, thrust: float, hover_thrust: float, climb_rate_controlled: bool) -> bool:
        if not climb_rate_controlled:
            return thrust <= self._parameters["MPC_MANTHR_MIN"] + _MANUAL_THRUST_SLACK
        least = self._parameters["MPC_THR_MIN"]
        return thrust <= least + (hover_thrust - least) * 0.1

    def _moves(self, velocity: list[float], land_speed_m_s: float, just_landed: bool) -> bool:
        p = self._parameters
        climb_max = min(0.5 * land_speed_m_s, p["LNDMC_Z_VEL_MAX"])
        if just_landed:
            climb_max = _JUST_LANDED_SLACK * p["LNDMC_Z_VEL_MAX"]
        vx, vy, vz = velocity
        return abs(vz) > climb_max or math.hypot(vx, vy) > p["LNDMC_XY_VEL_MAX"]

    def _turns(self, rates: list[float], just_landed: bool) -> bool:
        slack = _JUST_LANDED_SLACK if just_landed else 1.0
        return math.hypot(rates[0], rates[1]) > slack * math.radians(self._parameters["LNDMC_ROT_MAX"])
