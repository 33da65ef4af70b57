"""Range finders that look up and down, as the library's type."""

from __future__ import annotations

import math

from sensor_msgs.msg import Range

from cepa import MotionError, Ranging
from cepa.motion import rotation_matrix
from cepa.steering.mount import Mount

STEEPEST_COSINE = math.cos(math.radians(30.0))


def ranging_of(message: Range, mount: Mount) -> Ranging:
    """Return a sensor_msgs/Range in the body's frame; it looks along the x axis of its own frame.

    Raises:
        MotionError: it makes no sense, or it looks neither up nor down.
    """
    x, y, z = rotation_matrix(mount.orientation_xyzw)[:, 0].tolist()
    if abs(z) < STEEPEST_COSINE:
        raise MotionError(f'The range finder "{message.header.frame_id}" looks neither up nor down.')
    return Ranging(mount.position_m, (x, y, z), message.range, message.min_range, message.max_range)
