"""TF look-ups that never wait. If a transform is unknown, the next message asks again.

A look-up with a time-out waits for ROS time. It blocks for ever while the clock stands still, as in lockstep.
"""

from __future__ import annotations

from collections import deque
from typing import Callable, NamedTuple

import rospy
from geometry_msgs.msg import Transform as TransformMessage
from geometry_msgs.msg import TransformStamped
from tf2_msgs.msg import TFMessage

from node_tools.conversions import xyz, xyzw

AUTHORITY = "node_tools"
KEPT = 100
"""Of each moving edge."""


class FrameError(Exception):
    """TF does not know a transform."""


class Transform(NamedTuple):
    """Transforms coordinates from one frame to another: rotation, then translation."""

    translation_m: tuple[float, float, float]
    rotation_xyzw: tuple[float, float, float, float]


IDENTITY = Transform((0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 1.0))


class NewestTransforms:
    """The newest transforms between frames.

    Args:
        listen_to_moving: subscribe to /tf at once. Otherwise it subscribes to /tf when a look-up fails. So a
            node that needs only static frames does not receive a hundred messages a second.
        heard: is called with each edge that comes: its parent, its child, and whether it is static.
    """

    def __init__(
        self, listen_to_moving: bool = False, heard: Callable[[str, str, bool], None] = lambda *_: None
    ) -> None:
        self._heard = heard
        self._listens_from_the_start = listen_to_moving
        self._subscribers: list[rospy.Subscriber] = []
        self.restart()

    def restart(self) -> None:
        """Forget all transforms, as after a clock that jumped back. Static ones come again at once."""
        for subscriber in self._subscribers:
            subscriber.unregister()
        import tf2_ros  # slow to import, and not every node needs it

        self._buffer = tf2_ros.Buffer(debug=False)
        self._unknown = tf2_ros.TransformException
        self._moving = False
        self._sent: dict[tuple[str, str], deque[TransformStamped]] = {}
        self._subscribers = [rospy.Subscriber("/tf_static", TFMessage, self._on_static, queue_size=100)]
        if self._listens_from_the_start:
            self._listen_to_moving()

    def look_up(self, target: str, source: str) -> Transform:
        """Return the newest transform that takes `source` to `target`.

        Raises:
            FrameError: TF does not know it (yet).
        """
        target, source = target.lstrip("/"), source.lstrip("/")
        if source == target:
            return IDENTITY
        try:
            found = self._buffer.lookup_transform(target, source, rospy.Time(0)).transform
        except self._unknown:
            self._listen_to_moving()
            raise FrameError(f'TF knows no transform from "{source}" to "{target}".') from None
        return _transform_of(found)

    def look_up_at(self, target: str, source: str, stamp: rospy.Time) -> Transform:
        """Return the last transform from `target` to `source` that was sent with a stamp up to this one.

        A later one does not count, whether it has come or not. So in lockstep the answer does not depend on
        the order of messages. If TF has several edges between both frames, the newest transform counts.

        Raises:
            FrameError: TF does not know it (yet).
        """
        sent = tuple(self._sent.get((target.lstrip("/"), source.lstrip("/")), ()))  # others go on adding
        if not sent:
            return self.look_up(target, source)
        known = next((edge.transform for edge in reversed(sent) if edge.header.stamp <= stamp), None)
        if known is None:
            raise FrameError(f'TF knows no transform from "{source}" to "{target}" for {stamp.to_sec():g} s.')
        return _transform_of(known)

    def _listen_to_moving(self) -> None:
        if not self._moving:
            self._moving = True
            self._subscribers.append(rospy.Subscriber("/tf", TFMessage, self._on_moving, queue_size=100))

    def _on_static(self, message: TFMessage) -> None:
        for transform in message.transforms:
            self._buffer.set_transform_static(transform, AUTHORITY)
            self._heard(transform.header.frame_id, transform.child_frame_id, True)

    def _on_moving(self, message: TFMessage) -> None:
        for transform in message.transforms:
            self._buffer.set_transform(transform, AUTHORITY)
            edge = transform.header.frame_id.lstrip("/"), transform.child_frame_id.lstrip("/")
            self._heard(*edge, False)
            self._sent.setdefault(edge, deque(maxlen=KEPT)).append(transform)


def _transform_of(message: TransformMessage) -> Transform:
    return Transform(xyz(message.translation), xyzw(message.rotation))
