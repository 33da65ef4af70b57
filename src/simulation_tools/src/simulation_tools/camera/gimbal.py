"""A camera on a gimbal that tilts: where it looks while the UAV moves, and how a picture blurs meanwhile.

As on the lidar's gimbal, there are two hinges, roll outside and pitch inside.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from flight_basics.checks import check_limits, limited
from simulation_tools.camera.errors import PhotographError
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.geometry import Pose, Vector3, quaternion_from_matrix
from simulation_tools.vehicle.gimbal import level_angles

ROLL_MAX_RAD = math.radians(45.0)


@dataclass(frozen=True)
class TiltParameters:
    """The gimbal.

    Raises:
        PhotographError: a value is out of range.
    """

    place_m: Vector3 = (0.1, 0.0, -0.05)
    """Of the camera in the UAV's frame, m."""
    tilt_min: float = limited(-90.0, -90.0, 90.0)
    """Least tilt of its axis against the horizon, deg."""
    tilt_max: float = limited(90.0, -90.0, 90.0)
    """Greatest tilt of its axis against the horizon, deg. 90 looks straight up."""
    rate: float = limited(60.0, 0.1, 3600.0)
    """Greatest rate of each hinge, deg/s."""

    def __post_init__(self) -> None:
        if len(self.place_m) != 3 or not all(abs(value) <= 10.0 for value in self.place_m):
            raise PhotographError(f"The camera's place {self.place_m} is not three numbers below 10 m.")
        check_limits(self, PhotographError, "The gimbal's {}")
        if self.tilt_min > self.tilt_max:
            raise PhotographError(
                f"The gimbal tilts from {self.tilt_min} to {self.tilt_max} deg; give the least first."
            )


class BodyState(NamedTuple):
    """The UAV at an instant. pose: in the world. velocity_m_s, rates_rad_s: in its own frame."""

    stamp_s: float
    pose: Pose
    velocity_m_s: Vector3
    rates_rad_s: Vector3


class CameraState(NamedTuple):
    """The camera at an instant. in_body: the optical frame (x right, y down, z ahead) in the UAV's frame.

    pose: of the optical frame in the world. velocity_m_s, rates_rad_s: in the optical frame.
    """

    stamp_s: float
    in_body: Pose
    pose: Pose
    velocity_m_s: np.ndarray
    rates_rad_s: np.ndarray


class TiltGimbal:
    """Keeps the camera's tilt against the horizon, and its right side level, while the UAV leans.

    It does not turn about the vertical: the camera looks where the UAV's front does. Within its rates and
    `ROLL_MAX_RAD` it is exact: its motors are much faster than the airframe.
    """

    def __init__(self, parameters: TiltParameters | None = None) -> None:
        self._p = parameters or TiltParameters()
        self.wanted_rad = 0.0
        self._angles_rad: tuple[float, float] | None = None
        self._stamp_s = math.nan

    def command(self, tilt_rad: float) -> None:
        """Tilt to here, or to the nearest end of its range.

        Raises:
            PhotographError: the tilt is not finite.
        """
        if not math.isfinite(tilt_rad):
            raise PhotographError("The tilt is not finite; the gimbal keeps the last one.")
        low, high = math.radians(self._p.tilt_min), math.radians(self._p.tilt_max)
        self.wanted_rad = min(max(tilt_rad, low), high)

    def follow(self, body: BodyState) -> CameraState:
        """Turn to the UAV's next state, and return the camera's. One that is older begins anew."""
        roll, pitch = level_angles(body.pose.orientation_xyzw)
        wanted = min(max(roll, -ROLL_MAX_RAD), ROLL_MAX_RAD), pitch - self.wanted_rad
        before, self._angles_rad = self._angles_rad, wanted
        step_s = body.stamp_s - self._stamp_s
        self._stamp_s = body.stamp_s
        if before is None or not step_s > 0.0:
            self._angles_rad = wanted if before is None else before
            return _camera(body, self._p.place_m, self._angles_rad, (0.0, 0.0))
        reach = math.radians(self._p.rate) * step_s
        turns = [min(max(to - now, -reach), reach) for to, now in zip(wanted, before)]
        self._angles_rad = before[0] + turns[0], before[1] + turns[1]
        return _camera(body, self._p.place_m, self._angles_rad, (turns[0] / step_s, turns[1] / step_s))


def _camera(
    body: BodyState, place_m: Vector3, angles_rad: tuple[float, float], hinges_rad_s: tuple[float, float]
) -> CameraState:
    """Return the camera by its hinges: angles about the UAV's x and then its y axis, and their rates."""
    (roll, pitch), (roll_rate, pitch_rate) = angles_rad, hinges_rad_s
    across = np.array((0.0, math.cos(roll), math.sin(roll)))
    ahead = math.cos(pitch) * np.array((1.0, 0.0, 0.0)) - math.sin(pitch) * np.cross((1.0, 0.0, 0.0), across)
    axes = np.column_stack((-across, np.cross(ahead, -across), ahead))
    in_body = Pose(place_m, quaternion_from_matrix(axes))
    rates = np.array(body.rates_rad_s)
    velocity = np.array(body.velocity_m_s) + np.cross(rates, place_m)
    turning = rates + roll_rate * np.array((1.0, 0.0, 0.0)) + pitch_rate * across
    return CameraState(body.stamp_s, in_body, body.pose @ in_body, velocity @ axes, turning @ axes)


def blur_px(camera: CameraState, optics: CameraOptics, depths_m: np.ndarray) -> tuple[float, np.ndarray]:
    """Return the longest blur, px, in the middle and the corners, and (2,) their mean, right and down.

    depths_m: (5,) along the optical axis, in the middle and the corners; inf where nothing is.

    The motion field of a pinhole: Longuet-Higgins and Prazdny, 1980.
    """
    x, y = (marks_px(optics) - optics.centre_px).T / optics.focal_px
    (vx, vy, vz), (wx, wy, wz) = camera.velocity_m_s, camera.rates_rad_s
    near = 1.0 / np.maximum(depths_m, 0.05)
    right = (x * vz - vx) * near + x * y * wx - (1.0 + x * x) * wy + y * wz
    down = (y * vz - vy) * near + (1.0 + y * y) * wx - x * y * wy - x * wz
    flow = np.column_stack((right, down)) * optics.focal_px * optics.exposure_s
    return float(np.linalg.norm(flow, axis=1).max()), flow.mean(axis=0)


def motion_of(camera: CameraState, exposure_s: float) -> tuple[float, float]:
    """Return how far the camera moves, m, and turns, rad, while the shutter is open.

    Over a surface at depth z the picture blurs by the first plus z times the second, at most, m. At the
    corners the turn counts up to a half more.
    """
    shift_m, turn_rad = np.linalg.norm((camera.velocity_m_s, camera.rates_rad_s), axis=1) * exposure_s
    return float(shift_m), float(turn_rad)


def marks_px(optics: CameraOptics) -> np.ndarray:
    """Return (5, 2) the middle and the corners of a picture, px."""
    right, down = optics.width - 1.0, optics.height - 1.0
    return np.array(
        (optics.centre_px, (0.0, 0.0), (right, 0.0), (0.0, down), (right, down)),
    )


def smeared(picture: np.ndarray, flow_px: np.ndarray) -> np.ndarray:
    """Return a picture (height, width, 3), uint8, averaged along a line. flow_px: (2,) right and down."""
    steps = math.ceil(float(np.abs(flow_px).max()))
    if steps < 1:
        return picture
    shares = np.linspace(-0.5, 0.5, min(steps, 200) + 1)
    shifts = np.round(shares[:, None] * flow_px).astype(int)
    if not shifts.any():  # most photographs: the UAV rests
        return picture
    total = np.zeros(picture.shape, np.uint16)
    for right, down in shifts:
        rows = np.clip(np.arange(picture.shape[0]) - down, 0, picture.shape[0] - 1)
        columns = np.clip(np.arange(picture.shape[1]) - right, 0, picture.shape[1] - 1)
        total += picture[rows][:, columns]
    return (total // len(shifts)).astype(np.uint8)
