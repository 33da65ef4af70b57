"""The setpoints of an OFFBOARD client."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, Sequence

from simulation_tools.geometry import Quaternion, Vector3, rotate
from simulation_tools.ned_frames import enu_to_ned, flu_to_frd, yaw_to_ned

NAN = math.nan
UNSET: Vector3 = (NAN, NAN, NAN)


class Setpoint(NamedTuple):
    """A local setpoint in NED, or, with `body`, its velocity and acceleration in the body's FRD.

    NaN stands for "not asked for". Body velocities are levelled: turned by yaw only, with the heading at
    receipt. yaw: clockwise from north; yaw_rate: about down. time_boot_ms: the client's stamp, passed
    on unchanged.
    """

    position: Vector3 = UNSET
    velocity: Vector3 = UNSET
    acceleration: Vector3 = UNSET
    yaw: float = NAN
    yaw_rate: float = NAN
    body: bool = False
    time_boot_ms: int = 0

    @classmethod
    def hold(
        cls, position_enu_m: Sequence[float], yaw_enu_rad: float = NAN, time_boot_ms: int = 0
    ) -> Setpoint:
        """Fly to and hold a position given in ENU."""
        return cls(
            position=enu_to_ned(position_enu_m), yaw=yaw_to_ned(yaw_enu_rad), time_boot_ms=time_boot_ms
        )

    @classmethod
    def fly(
        cls, velocity_flu_m_s: Sequence[float], yaw_rate_flu_rad_s: float, time_boot_ms: int = 0
    ) -> Setpoint:
        """Fly at a levelled body velocity (forward, left, up), turning counter-clockwise at a rate."""
        return cls(
            velocity=flu_to_frd(velocity_flu_m_s),
            yaw_rate=-yaw_rate_flu_rad_s,
            body=True,
            time_boot_ms=time_boot_ms,
        )

    def in_local_frame(self, yaw_rad: float, attitude_wxyz: Sequence[float]) -> Setpoint:
        """Turn a body setpoint to NED: velocity by yaw, acceleration by the whole attitude, as PX4 does."""
        c, s = math.cos(yaw_rad), math.sin(yaw_rad)
        vx, vy, vz = self.velocity
        w, x, y, z = attitude_wxyz
        return Setpoint(
            UNSET,
            (c * vx - s * vy, s * vx + c * vy, vz),
            rotate((x, y, z, w), self.acceleration),
            self.yaw,
            self.yaw_rate,
            body=False,
            time_boot_ms=self.time_boot_ms,
        )

    @property
    def asks_something(self) -> bool:
        """Whether any of position, velocity and acceleration is set. Yaw alone is not a setpoint."""
        values = (*self.position, *self.velocity, *self.acceleration)
        return any(map(math.isfinite, values)) and not any(map(math.isinf, values))


@dataclass(frozen=True)
class AttitudeSetpoint:
    """An attitude (FRD in NED, w x y z) or, where it is None, body rates (rad/s FRD), and thrust 0..1."""

    attitude: Quaternion | None
    rates: Vector3 = UNSET
    thrust: float = 0.0
    time_boot_ms: int = 0

    @property
    def asks_something(self) -> bool:
        """Whether it is complete: a finite thrust, and an attitude or rates."""
        orientation = self.rates if self.attitude is None else self.attitude
        return math.isfinite(self.thrust) and all(math.isfinite(value) for value in orientation)
