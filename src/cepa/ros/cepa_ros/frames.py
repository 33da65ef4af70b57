"""TF without waiting: what is not known now is asked for again with the next message."""

from __future__ import annotations

import math
from typing import NamedTuple

import rospy
import tf2_ros
from tf2_msgs.msg import TFMessage

from cepa import CepaError

LEVEL_COSINE = math.cos(math.radians(20.0))
"""A lidar whose axis leans more than this against the body's does not scan the plane in which CEPA steers."""


class FrameError(CepaError):
    """TF does not know a transform, or it makes no sense for CEPA."""


class PlaneTurn:
    """How a plane vector of one frame reads in another: a turn, mirrored for a lidar upside down."""

    def __init__(self, yaw_rad: float, flipped: bool = False):
        self._cos, self._sin = math.cos(yaw_rad), math.sin(yaw_rad)
        self._side = -1.0 if flipped else 1.0

    def apply(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the source frame to the target frame."""
        y *= self._side
        return self._cos * x - self._sin * y, self._sin * x + self._cos * y

    def undo(self, x: float, y: float) -> tuple[float, float]:
        """Take a vector of the target frame to the source frame."""
        return self._cos * x + self._sin * y, self._side * (self._cos * y - self._sin * x)


class Mount(NamedTuple):
    """How a lidar sits on the body: its turn of the plane, and its whole pose in the base frame."""

    turn: PlaneTurn
    position_m: tuple[float, float, float]
    orientation_xyzw: tuple[float, float, float, float]


class Frames:
    """Turns of the horizontal plane between frames; only /tf_static is listened to until /tf is needed."""

    def __init__(self, base_frame: str):
        self.base_frame = base_frame
        self._mounts: dict[str, Mount] = {}
        self._subscribers: list = []
        self.restart()

    def restart(self) -> None:
        """Forget moving transforms, as after a clock that jumped back; how lidars are mounted stays known."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        self._buffer = tf2_ros.Buffer(debug=False)
        self._moving = False
        self._subscribers = [rospy.Subscriber("/tf_static", TFMessage, self._on_static, queue_size=100)]

    def lidar_mount(self, frame: str) -> Mount:
        """Return how the lidar sits on the base frame; asked for once.

        Raises:
            FrameError: TF does not know it yet, or the lidar does not lie flat.
        """
        if frame not in self._mounts:
            mount = self._look_up(frame)
            x, y, _, _ = mount.orientation_xyzw
            lean_cosine = 1.0 - 2.0 * (x * x + y * y)
            if abs(lean_cosine) < LEVEL_COSINE:
                lean = math.degrees(math.acos(lean_cosine))
                raise FrameError(
                    f'The lidar "{frame}" leans by {lean:.0f} degrees; CEPA needs one that lies flat.'
                )
            self._mounts[frame] = mount
        return self._mounts[frame]

    def yaw_turn(self, frame: str) -> PlaneTurn:
        """Return how a levelled velocity of ``frame`` turns into the base frame, by its newest yaw.

        Raises:
            FrameError: TF does not know it (yet).
        """
        return self._look_up(frame).turn

    def _look_up(self, frame: str) -> Mount:
        frame = frame.lstrip("/")
        if frame in ("", self.base_frame):
            return Mount(PlaneTurn(0.0), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))
        try:
            found = self._buffer.lookup_transform(self.base_frame, frame, rospy.Time(0)).transform
        except tf2_ros.TransformException:
            self._listen_to_moving()
            raise FrameError(f'TF knows no transform from "{frame}" to "{self.base_frame}".') from None
        t, q = found.translation, found.rotation
        yaw = math.atan2(2.0 * (q.x * q.y + q.z * q.w), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
        turn = PlaneTurn(yaw, flipped=q.x * q.x + q.y * q.y > 0.5)
        return Mount(turn, (t.x, t.y, t.z), (q.x, q.y, q.z, q.w))

    def _listen_to_moving(self) -> None:
        if not self._moving:
            self._moving = True
            self._subscribers.append(rospy.Subscriber("/tf", TFMessage, self._on_moving, queue_size=100))

    def _on_static(self, message: TFMessage) -> None:
        for transform in message.transforms:
            self._buffer.set_transform_static(transform, "cepa")

    def _on_moving(self, message: TFMessage) -> None:
        for transform in message.transforms:
            self._buffer.set_transform(transform, "cepa")
