"""PX4's hover thrust estimator: a Kalman filter of one state on the vertical acceleration.

Model: hover thrust h is constant; acceleration upwards = g (thrust / h - 1). The measurement noise is learnt
from the residuals (Akhlaghi et al., "Adaptive adjustment of noise covariance in Kalman filter for dynamic
state estimation", 2017). A gate rejects outliers. If it rejects for long, the state's variance grows.
"""

from __future__ import annotations

from simulation_tools.px4.parameters import Px4Parameters

_GRAVITY = 9.80665
_NOISE_LEARNING_S = 2.0
_RESIDUAL_LOW_PASS_S = 1.0
_VALID_VARIANCE = 0.001
_VALID_AFTER_S = 2.0


class HoverThrustEstimator:
    """Estimates `hover_thrust`. Use it only while `valid`."""

    def __init__(self, parameters: Px4Parameters) -> None:
        self._parameters = parameters
        self.reset()

    def reset(self) -> None:
        """Go back to the parameters' hover thrust, not valid."""
        p = self._parameters
        self.hover_thrust = float(p["MPC_THR_HOVER"])
        self.variance = float(p["HTE_HT_ERR_INIT"]) ** 2
        self.valid = False
        self._noise_variance = 5.0
        self._residual = 0.0
        self._signed_test_ratio = 0.0
        self._good_for_s = 0.0

    def invalidate(self) -> None:
        """Stop, on the ground. The value stays, but is not valid any more."""
        self.valid = False
        self._good_for_s = 0.0

    def update(self, acceleration_up_m_s2: float, thrust: float, dt_s: float) -> None:
        """Take in the vertical acceleration (gravity taken out) and the vertical thrust, 0..1."""
        p = self._parameters
        process = p["HTE_HT_NOISE"] ** 2
        hover, variance = self.hover_thrust, self.variance + process * dt_s * dt_s
        slope = -_GRAVITY * thrust / hover**2
        innovation = acceleration_up_m_s2 - _predicted(thrust, hover)
        innovation_variance = slope * variance * slope + self._noise_variance
        test_ratio = innovation**2 / (p["HTE_ACC_GATE"] ** 2 * innovation_variance)
        residual = innovation
        if test_ratio < 1.0:
            gain = variance * slope / innovation_variance
            self.hover_thrust = hover = min(max(hover + gain * innovation, 0.1), 0.9)
            variance = min(max((1.0 - gain * slope) * variance, 1e-10), 1.0)
            residual = acceleration_up_m_s2 - _predicted(thrust, hover)
        elif abs(self._signed_test_ratio) > 0.2:
            variance += 1e3 * process * dt_s
        self.variance = variance

        share = dt_s / (_RESIDUAL_LOW_PASS_S + dt_s)
        self._residual += share * (residual - self._residual)
        signed = min(test_ratio, 1.0) if innovation >= 0.0 else -min(test_ratio, 1.0)
        self._signed_test_ratio += share * (signed - self._signed_test_ratio)
        share = dt_s / (_NOISE_LEARNING_S + dt_s)
        seen = (residual - self._residual) ** 2 + slope * variance * slope
        learnt = self._noise_variance + share * (seen - self._noise_variance)
        self._noise_variance = min(max(learnt, 1.0), 400.0)

        good = variance < _VALID_VARIANCE and (self.valid or test_ratio < 1.0)
        self._good_for_s = self._good_for_s + dt_s if good else 0.0
        self.valid = good and (self.valid or self._good_for_s >= _VALID_AFTER_S)


def _predicted(thrust: float, hover_thrust: float) -> float:
    return _GRAVITY * (thrust / hover_thrust - 1.0)
