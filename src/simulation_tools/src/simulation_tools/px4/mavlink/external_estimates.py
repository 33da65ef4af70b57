"""Estimates and ranges that other computers send, read as PX4 of July 2021 reads them.

PX4 passes on what the messages hold, nonsense included; its estimator decides. The reset counters have no
effect. PX4 takes the frames LOCAL_NED and LOCAL_FRD for the same. It does not know VISION_SPEED_ESTIMATE.
"""

from __future__ import annotations

import math
from typing import Callable, Iterable, Sequence

from pymavlink.dialects.v20 import common

from simulation_tools.geometry import Vector3, quaternion_from_rpy
from simulation_tools.px4.estimation.samples import UNKNOWN, ExternalVision, RangeSample
from simulation_tools.px4.mavlink.clock_sync import ClockSync
from simulation_tools.px4.px4 import Px4

_X, _Y, _Z, _YAW = 0, 6, 11, 20  # of an upper triangle of 6 x 6
_LOCAL_FRAMES = (common.MAV_FRAME_LOCAL_NED, common.MAV_FRAME_LOCAL_FRD)
_VISIONS = (
    common.MAV_ESTIMATOR_TYPE_UNKNOWN,
    common.MAV_ESTIMATOR_TYPE_VISION,
    common.MAV_ESTIMATOR_TYPE_VIO,
)
_DOWN = common.MAV_SENSOR_ROTATION_PITCH_270
AHEAD_S, BEHIND_S = 0.1, 0.5
"""A stamp that is farther ahead of the present, or behind it, is a mistake of the sender."""


class ExternalEstimates:
    """Gives these messages to the estimator. Tells each kind of trouble to `warn` (kind, sentence)."""

    def __init__(self, px4: Px4, warn: Callable[[str, str], None]) -> None:
        self._px4 = px4
        self._warn = warn
        self.handlers: dict[str, Callable[[common.MAVLink_message, int], None]] = {
            "VISION_POSITION_ESTIMATE": self._on_pose,
            "VISION_SPEED_ESTIMATE": self._on_speed,
            "ODOMETRY": self._on_odometry,
            "DISTANCE_SENSOR": self._on_range,
        }

    def handle(self, m: common.MAVLink_message, clock: ClockSync, now_us: int) -> int:
        """Take in a message of one of the `handlers`, received now from a client of this clock.

        Return its stamp in PX4's time, us.
        """
        name = m.get_type()
        stamp_us = 1000 * m.time_boot_ms if name == "DISTANCE_SENSOR" else getattr(m, "usec", None)
        time_us = clock.own_time_us(m.time_usec if stamp_us is None else stamp_us, now_us)
        late_s = 1e-6 * (now_us - time_us)
        if late_s < -AHEAD_S:
            self._warn(f"{name} ahead", f"MAVLink: {name} is stamped {-late_s:.3g} s ahead of PX4's clock")
        elif late_s > BEHIND_S:
            self._warn(f"{name} late", f"MAVLink: {name} is {late_s:.3g} s old; PX4 fuses nothing so old")
        self.handlers[name](m, time_us)
        return time_us

    def _offer(self, name: str, sample: ExternalVision) -> None:
        if sample.position_m is not None and not _all_finite(sample.position_m):
            self._warn(
                f"{name} NaN", f"MAVLink: {name} has a position with NaN; PX4 does not filter that out"
            )
        if sample.attitude is None:
            self._warn(f"{name} attitude", f"MAVLink: {name} has no valid attitude; PX4 takes no yaw from it")
        self._px4.offer_external_vision(sample)

    def _on_pose(self, m: common.MAVLink_message, time_us: int) -> None:
        attitude = None
        if _all_finite((m.roll, m.pitch, m.yaw)):
            x, y, z, w = quaternion_from_rpy(m.roll, m.pitch, m.yaw)
            attitude = (w, x, y, z)
        sample = ExternalVision(
            time_us,
            position_m=(m.x, m.y, m.z),
            attitude=attitude,
            position_variance_m2=_variances(m.covariance),
            yaw_variance_rad2=m.covariance[_YAW],
        )
        self._offer("VISION_POSITION_ESTIMATE", sample)

    def _on_speed(self, m: common.MAVLink_message, time_us: int) -> None:
        self._warn("speed", "MAVLink: PX4 does not know VISION_SPEED_ESTIMATE; send ODOMETRY with a velocity")

    def _on_odometry(self, m: common.MAVLink_message, time_us: int) -> None:
        if m.frame_id not in _LOCAL_FRAMES:
            self._warn("frame", f"MAVLink: ODOMETRY in the frame {m.frame_id}; PX4 takes only 1 and 20")
            return
        if m.estimator_type not in _VISIONS:
            self._warn(
                "source", f"MAVLink: ODOMETRY of the estimator type {m.estimator_type}, which PX4 ignores"
            )
            return
        length = math.sqrt(sum(component * component for component in m.q))
        w, x, y, z = (component / length if length else math.nan for component in m.q)
        has_velocity = m.child_frame_id == common.MAV_FRAME_BODY_FRD
        if not has_velocity:
            self._warn("child", f"MAVLink: ODOMETRY of the body frame {m.child_frame_id}; PX4 takes only 12")
        sample = ExternalVision(
            time_us,
            position_m=(m.x, m.y, m.z),
            velocity_m_s=(m.vx, m.vy, m.vz) if has_velocity and _all_finite((m.vx, m.vy, m.vz)) else None,
            attitude=(w, x, y, z) if _all_finite((w, x, y, z)) else None,
            position_variance_m2=_variances(m.pose_covariance),
            velocity_variance_m2_s2=_variances(m.velocity_covariance),
            yaw_variance_rad2=m.pose_covariance[_YAW],
            velocity_in_body=True,
        )
        self._offer("ODOMETRY", sample)

    def _on_range(self, m: common.MAVLink_message, time_us: int) -> None:
        if m.orientation != _DOWN:
            return
        # MAVLink: 0 unknown, 1 invalid, 100 perfect
        quality = -1 if m.signal_quality == 0 else 100 * (m.signal_quality - 1) // 99
        sample = RangeSample(
            time_us, 0.01 * m.current_distance, 0.01 * m.min_distance, 0.01 * m.max_distance, quality
        )
        self._px4.offer_range(sample)


def _all_finite(values: Iterable[float]) -> bool:
    return all(map(math.isfinite, values))


def _variances(triangle: Sequence[float]) -> Vector3:
    """The variances along three axes. If one is not a number, PX4 uses its parameter for all of them."""
    variances = (triangle[_X], triangle[_Y], triangle[_Z])
    return variances if _all_finite(variances) else UNKNOWN
