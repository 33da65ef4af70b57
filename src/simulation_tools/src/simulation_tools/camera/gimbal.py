"""A camera on a gimbal that tilts: where it looks while the UAV moves, and how a picture blurs meanwhile."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from simulation_tools.camera.errors import PhotographError
from simulation_tools.camera.optics import CameraOptics
from simulation_tools.geometry import Pose, Vector3, quaternion_from_matrix, rotate_inverse


@dataclass(frozen=True)
class TiltParameters:
    """The gimbal.

    place_m: of the camera in the UAV's frame. tilt_min, tilt_max: of its axis against the horizon, deg; 90
    looks straight up. rate: greatest, deg/s.

    Raises:
        PhotographError: a value is out of range.
    """

    place_m: Vector3 = (0.1, 0.0, -0.05)
    tilt_min: float = -90.0
    tilt_max: float = 90.0
    rate: float = 60.0

    def __post_init__(self) -> None:
        if len(self.place_m) != 3 or not all(abs(value) <= 10.0 for value in self.place_m):
            raise PhotographError(f"The camera's place {self.place_m} is not three numbers below 10 m.")
        if not -90.0 <= self.tilt_min <= self.tilt_max <= 90.0:
            raise PhotographError(
                f"The gimbal tilts from {self.tilt_min} to {self.tilt_max} deg; give -90 to 90, least first."
            )
        if not 0.1 <= self.rate <= 3600.0:
            raise PhotographError(f"The gimbal's rate is {self.rate} deg/s; give 0.1 to 3600.")


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
    """Keeps the camera's tilt against the horizon while the UAV pitches. It does not take out the roll.

    Within its rate it is exact: its motor is much faster than the airframe.
    """

    def __init__(self, parameters: TiltParameters | None = None) -> None:
        self._p = parameters or TiltParameters()
        self.wanted_rad = 0.0
        self._angle_rad: float | None = None
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
        ahead, up = _nose(body.pose)
        wanted = self.wanted_rad - math.atan2(ahead, up)
        step_s = body.stamp_s - self._stamp_s
        rate = 0.0
        if self._angle_rad is None or not step_s > 0.0:
            self._angle_rad = wanted if self._angle_rad is None else self._angle_rad
        else:
            reach = math.radians(self._p.rate) * step_s
            turn = min(max(wanted - self._angle_rad, -reach), reach)
            self._angle_rad += turn
            rate = turn / step_s
        self._stamp_s = body.stamp_s
        return _camera(body, self._p.place_m, self._angle_rad, rate)


def _nose(pose: Pose) -> tuple[float, float]:
    """Return how much of the UAV's x axis, and of its z axis, points up."""
    x, _, z = rotate_inverse(pose.orientation_xyzw, (0.0, 0.0, 1.0))
    return x, z


def _camera(body: BodyState, place_m: Vector3, angle_rad: float, rate_rad_s: float) -> CameraState:
    sine, cosine = math.sin(angle_rad), math.cos(angle_rad)
    axes = np.array(((0.0, -1.0, 0.0), (sine, 0.0, -cosine), (cosine, 0.0, sine))).T
    in_body = Pose(place_m, quaternion_from_matrix(axes))
    rates = np.array(body.rates_rad_s)
    velocity = np.array(body.velocity_m_s) + np.cross(rates, place_m)
    turning = rates - np.array((0.0, rate_rad_s, 0.0))
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
