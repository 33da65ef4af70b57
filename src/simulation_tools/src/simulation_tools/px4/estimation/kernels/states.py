"""Nominal and error state of the filter, and what is stored between the fusion horizon and the present."""

from __future__ import annotations

import numpy as np

# Nominal state: position m and velocity m/s (NED), attitude (FRD in NED, w x y z), biases of accelerometer
# m/s2 and gyroscope rad/s (FRD).
POSITION, VELOCITY, ATTITUDE, ACCELEROMETER_BIAS, GYROSCOPE_BIAS, NOMINAL_SIZE = 0, 3, 6, 10, 13, 16

# Error state: as above, with a rotation vector (rad, NED) in the place of the attitude. The first two have
# the same indices in both states.
ROTATION_ERROR, ACCELEROMETER_BIAS_ERROR, GYROSCOPE_BIAS_ERROR, ERROR_SIZE = 6, 9, 12, 15
LEAST_VARIANCE = 1e-12  # of any component of the error state

IMU_DTYPE = np.dtype(
    [
        ("time_us", np.int64),  # of the sample's end
        ("dt", np.float64),  # s
        ("rates", np.float64, (3,)),  # rad/s, FRD
        ("force", np.float64, (3,)),  # m/s2, FRD
        ("predicted", np.float64, (10,)),  # the estimate after this sample: position, velocity, attitude
    ]
)

CLOCK_DTYPE = np.dtype(
    [
        ("head", np.int64),  # where the next sample goes
        ("count", np.int64),  # samples between horizon and now
        ("horizon_us", np.int64),
        ("since_propagation", np.float64),  # s of nominal prediction without one of the covariance
        ("turn_correction", np.float64, (3,)),  # rad per sample, FRD
        ("velocity_integral", np.float64, (3,)),
        ("position_integral", np.float64, (3,)),
    ]
)
