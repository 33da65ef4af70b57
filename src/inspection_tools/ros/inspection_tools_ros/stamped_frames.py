"""TF at the stamps of messages, without waiting: who asks too soon asks again when TF has grown."""

from __future__ import annotations

from typing import Callable

import rospy
import tf2_py
from tf2_msgs.msg import TFMessage

from flight_basics.geometry import Quaternion, Vector3, normalised
from node_tools.conversions import xyz, xyzw

CACHE_S = 5.0
AUTHORITY = "inspection_tools"


class StampedFrames:
    """The transforms of the last seconds.

    Args:
        grown: is called after each message of /tf or /tf_static.
    """

    def __init__(self, grown: Callable[[], None]) -> None:
        self._buffer = tf2_py.BufferCore(rospy.Duration(CACHE_S))
        self._grown = grown

    def listen(self) -> None:
        """Subscribe."""
        for topic, is_static in (("/tf_static", True), ("/tf", False)):
            rospy.Subscriber(topic, TFMessage, self._on_tf, is_static, queue_size=100, tcp_nodelay=True)

    def _on_tf(self, message: TFMessage, is_static: bool) -> None:
        for edge in message.transforms:
            try:
                take = self._buffer.set_transform_static if is_static else self._buffer.set_transform
                take(edge, AUTHORITY)
            except (ValueError, TypeError):
                continue
        self._grown()

    def forget(self) -> None:
        """Forget the moving transforms, as after a clock that jumped back."""
        self._buffer.clear()

    def look_up(self, target: str, source: str, stamp: rospy.Time) -> tuple[Vector3, Quaternion] | None:
        """Return translation (x, y, z) and unit quaternion that take `source` to `target`; None: not known.

        Raises:
            PoseError: it is not a rotation.
        """
        try:
            found = self._buffer.lookup_transform_core(target, source, stamp).transform
        except tf2_py.TransformException:
            return None
        return xyz(found.translation), normalised(xyzw(found.rotation))
