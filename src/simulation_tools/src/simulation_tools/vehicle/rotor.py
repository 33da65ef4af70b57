"""One rotor: its thrust, its reaction torque, and how it follows a command."""

from __future__ import annotations

import math
from dataclasses import MISSING, dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.errors import SimulationToolsError
from simulation_tools.geometry import Vector3


class AirframeError(SimulationToolsError):
    """The model's rotors are missing or described wrongly."""


@dataclass(frozen=True)
class Rotor:
    """One rotor. Its state x is the speed (rad/s) of a propeller, or the lagged command of a linear rotor.

    position_m: from the centre of mass, FLU. direction: +1 turns counter-clockwise seen from above. The
    target of x is idle + (top - idle) u. Thrust is quadratic x^2 + linear x; the reaction torque is thrust
    times moment_m, against the direction of turning. rotor_drag, rolling_moment: per x and m/s of air across.
    """

    joint: str
    position_m: Vector3
    direction: float
    idle: float
    top: float
    time_constant_up_s: float = limited(MISSING, above=0.0)
    time_constant_down_s: float = limited(MISSING, above=0.0)
    thrust_quadratic: float = limited(MISSING, 0.0)
    thrust_linear: float = limited(MISSING, 0.0)
    moment_m: float = limited(MISSING, 0.0)
    rotor_drag: float = limited(0.0, 0.0)
    rolling_moment: float = 0.0

    def __post_init__(self) -> None:
        check_limits(self, AirframeError, f"rotor {self.joint}: {{}}")
        if not 0.0 < self.top - self.idle < math.inf:
            raise AirframeError(
                f"rotor {self.joint}: its top speed {self.top} must be greater than idle, {self.idle}."
            )
        if not self.thrust_quadratic + self.thrust_linear:
            raise AirframeError(f"rotor {self.joint}: its thrust is 0 at any speed.")

    def command_for_thrust(self, thrust_n: float) -> float:
        """Return the steady command in 0..1 that gives a thrust (closed form; clipped)."""
        if self.thrust_quadratic:
            a, b = self.thrust_quadratic, self.thrust_linear
            x = (math.sqrt(b * b + 4.0 * a * thrust_n) - b) / (2.0 * a)
        else:
            x = thrust_n / self.thrust_linear
        return min(1.0, max(0.0, (x - self.idle) / (self.top - self.idle)))
