"""How the UAV's motion shows in its own axes: to the air, to the flight controller, to its sensors."""

from __future__ import annotations

from typing import NamedTuple

from kernel_cache.compiler import njit
from simulation_tools.compiled_geometry import rotate_inverse
from simulation_tools.geometry import ORIGIN, Quaternion, Vector3
from simulation_tools.world.kinematics import BodyState


class OwnMotion(NamedTuple):
    """Velocities, and the specific force that an accelerometer feels; FLU, in the world's frame of rest."""

    velocity_m_s: Vector3 = ORIGIN
    turning_rad_s: Vector3 = ORIGIN
    specific_force_m_s2: Vector3 = ORIGIN


def own_motion(velocity_before_m_s: Vector3, now: BodyState, dt_s: float, gravity_m_s2: Vector3) -> OwnMotion:
    """Return the motion now. The specific force is the mean over the last step, dt_s.

    velocity_before_m_s: at the beginning of that step, world axes. gravity_m_s2: world axes.
    """
    pose, velocity, spin = now
    return OwnMotion(
        *_own_motion(pose.orientation_xyzw, velocity_before_m_s, velocity, spin, dt_s, gravity_m_s2)
    )


@njit(cache=True)
def _own_motion(
    q: Quaternion, before: Vector3, now: Vector3, spin: Vector3, dt: float, gravity: Vector3
) -> tuple[Vector3, Vector3, Vector3]:
    (x0, y0, z0), (x1, y1, z1), (gx, gy, gz) = before, now, gravity
    felt = ((x1 - x0) / dt - gx, (y1 - y0) / dt - gy, (z1 - z0) / dt - gz)  # as `imu.specific_force`
    return rotate_inverse(q, now), rotate_inverse(q, spin), rotate_inverse(q, felt)
