"""The records of the position controller's setpoint and output, which other parts fill and read."""

from __future__ import annotations

import numpy as np

from simulation_tools.px4.setpoint import Setpoint

# The controller's setpoint; NaN: not set.
SETPOINT_DTYPE = np.dtype(
    [
        ("position", np.float64, (3,)),
        ("velocity", np.float64, (3,)),
        ("acceleration", np.float64, (3,)),
        ("yaw", np.float64),
        ("yaw_rate", np.float64),
    ]
)

# The controller's output, which is the input of the attitude controller.
ATTITUDE_SETPOINT_DTYPE = np.dtype(
    [
        ("attitude", np.float64, (4,)),  # FRD in NED, w x y z
        ("yaw_rate", np.float64),  # rad/s about the world's down axis, feed-forward
        ("thrust", np.float64),  # 0..1 along the body's -z
        ("velocity", np.float64, (3,)),  # the velocity setpoint after the position loop and limits
        ("acceleration", np.float64, (3,)),
        ("thrust_vector", np.float64, (3,)),  # NED, normalised thrust
        ("yaw", np.float64),
    ]
)


def fill(record: np.ndarray, setpoint: Setpoint) -> None:
    """Copy a setpoint into a record array of SETPOINT_DTYPE, shape (1,)."""
    record[0] = (setpoint.position, setpoint.velocity, setpoint.acceleration, setpoint.yaw, setpoint.yaw_rate)
