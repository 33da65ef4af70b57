"""PX4's land detector for multirotors: ground contact, then maybe landed, then landed.

Ground contact: sinking is asked for (until landed), thrust is low, nothing moves. Maybe landed: thrust is
minimal and nothing turns. Each stage must hold for a third of LNDMC_TRIG_TIME; leaving one is immediate.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from simulation_tools.px4.parameters import Px4Parameters

_SINKING_M_S = 0.3  # a velocity setpoint beyond this asks to sink


@dataclass
class _Stage:
    """A condition that must hold for a time before it counts."""

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

    @property
    def ground_contact(self) -> bool:
        """Something stops the vehicle from sinking."""
        return self._contact.state

    @property
    def maybe_landed(self) -> bool:
        """It stands, most likely."""
        return self._maybe.state

    @property
    def landed(self) -> bool:
        """It stands."""
        return self._landed.state

    def update(
        self,
        armed: bool,
        estimate: np.ndarray,
        velocity_setpoint_down_m_s: float,
        thrust: float,
        hover_thrust: float,
        hover_thrust_valid: bool,
        dt_s: float,
    ) -> None:
        """estimate: record of ESTIMATE_DTYPE, shape (1,). velocity setpoint: NaN when none; thrust 0..1."""
        if not armed:
            self.reset()
            return
        p = self._parameters
        needed_s = p["LNDMC_TRIG_TIME"] / 3.0
        vx, vy, vz = estimate["velocity"][0].tolist()
        wx, wy, _ = estimate["rates"][0].tolist()
        slack = 2.5 if self._maybe.state else 1.0
        least = p["MPC_THR_MIN"]

        low = least + (hover_thrust - least) * (0.6 if hover_thrust_valid else 0.3)
        contact = thrust <= low
        if not (self._maybe.state or self._landed.state):
            contact = contact and velocity_setpoint_down_m_s > _SINKING_M_S
        contact = contact and abs(vz) <= slack * p["LNDMC_Z_VEL_MAX"]
        contact = contact and math.hypot(vx, vy) <= p["LNDMC_XY_VEL_MAX"]

        minimal = thrust <= least + (hover_thrust - least) * 0.1
        still = math.hypot(wx, wy) <= math.radians(p["LNDMC_ROT_MAX"]) * slack
        self._contact.update(contact, needed_s, dt_s)
        self._maybe.update(minimal and still and self._contact.state, needed_s, dt_s)
        self._landed.update(self._maybe.state, needed_s, dt_s)
