"""Range finders that look up and down, as the library's type."""

from __future__ import annotations

import math
from typing import Sequence

import numpy as np
from sensor_msgs.msg import Range

from cepa import MotionError, Ranging
from cepa.motion import rotation_matrix
from cepa_ros.clouds import out_of_body
from cepa_ros.frames import Mount

SOURCES = ("range_finder", "range_finder_up")
"""Their topics."""
STEEPEST_COSINE = math.cos(math.radians(30.0))


def ranging_of(message: Range, mount: Mount) -> Ranging:
    """Return a sensor_msgs/Range in the body's frame; it looks along the x axis of its own frame.

    Raises:
        MotionError: it makes no sense, or it looks neither up nor down.
    """
    direction = rotation_matrix(mount.orientation_xyzw)[:, 0]
    if abs(direction[2]) < STEEPEST_COSINE:
        raise MotionError(f'The range finder "{message.header.frame_id}" looks neither up nor down.')
    limits = message.range, message.min_range, message.max_range
    return Ranging(mount.position_m, _vector(direction), *limits)


def in_lidar_frame(rangings: Sequence[Ranging], mount: Mount) -> list[Ranging]:
    """Return ranges of the body's frame in that of a lidar with this mounting."""
    turn = rotation_matrix(mount.orientation_xyzw)
    return [
        Ranging(
            _vector(out_of_body(np.array(ranging.origin_m), mount)),
            _vector(np.array(ranging.direction) @ turn),
            ranging.range_m,
            ranging.range_min_m,
            ranging.range_max_m,
        )
        for ranging in rangings
    ]


def _vector(values: np.ndarray) -> tuple[float, float, float]:
    x, y, z = values.tolist()
    return x, y, z
