"""The arithmetic of the error-state Kalman filter: prediction, correction, and the way from its past to now.

J. Sola, "Quaternion kinematics for the error-state Kalman filter", arXiv:1711.02508 (2017), with the
attitude's error of chapter 7: a small rotation in the world's axes (NED), so q_true = exp(error) q. Gravity
is known. A kernel's `x` is the nominal state (16,), `p` the covariance of the error state (15, 15).
"""
