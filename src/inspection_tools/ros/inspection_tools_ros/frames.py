"""TF without waiting: what is not known now is asked for again with the next message."""

from __future__ import annotations

import math

import rospy

from inspection_tools.errors import InspectionToolsError
from inspection_tools.geometry import yaw_of
from inspection_tools_ros import conversions


class FrameError(InspectionToolsError):
    """TF does not know a transform."""


class Frames:
    """The newest transforms between frames; TF is listened to from the first question on."""

    def __init__(self):
        self._buffer = None

    def listen(self) -> None:
        """Begin to listen, so that the first question can be answered already."""
        import tf2_ros  # only where it is needed: it slows the start

        self._error = tf2_ros.TransformException
        self._buffer = tf2_ros.Buffer(debug=False)
        self._listener = tf2_ros.TransformListener(self._buffer)

    def look_up(self, target: str, source: str) -> tuple:
        """Return translation (x, y, z) and unit quaternion (x, y, z, w) that take ``source`` to ``target``.

        Raises:
            FrameError: TF does not know it (yet).
            PoseError: it is no rotation.
        """
        if self._buffer is None:
            self.listen()
        try:
            found = self._buffer.lookup_transform(target, source, rospy.Time(0))
        except self._error:
            raise FrameError(f'TF knows no transform between "{target}" and "{source}".') from None
        return conversions.transform_of(found.transform)

    def turn(self, vector_xy, target: str, source: str) -> tuple:
        """Return a levelled vector (x, y) of ``source`` as it reads in ``target``: turned by yaw only.

        Raises:
            FrameError, PoseError: as ``look_up``.
        """
        if source in ("", target):
            return tuple(vector_xy)
        yaw_rad = yaw_of(self.look_up(target, source)[1])
        x, y = vector_xy
        return (
            math.cos(yaw_rad) * x - math.sin(yaw_rad) * y,
            math.sin(yaw_rad) * x + math.cos(yaw_rad) * y,
        )
