"""Makes the estimator that is asked for."""

from __future__ import annotations

import numpy as np

from simulation_tools.autopilot import Px4Error
from simulation_tools.px4.estimation.ekf_estimator import EkfEstimator
from simulation_tools.px4.estimation.interface import Estimator
from simulation_tools.px4.estimation.sensors import SensorErrors
from simulation_tools.px4.estimation.steady_estimator import EstimatorNoise, SteadyEstimator
from simulation_tools.px4.parameters import Px4Parameters

STEADY, EKF2 = ESTIMATORS = ("steady", "ekf2")


def make_estimator(
    kind: str, noise: EstimatorNoise | None, rng: np.random.Generator, parameters: Px4Parameters
) -> Estimator:
    """Return an estimator of one of the ESTIMATORS; raises Px4Error."""
    if kind == EKF2:
        return EkfEstimator(SensorErrors(), rng, parameters)
    if kind == STEADY:
        return SteadyEstimator(noise or EstimatorNoise(), rng, parameters)
    raise Px4Error(f'The estimator must be one of {", ".join(ESTIMATORS)}, not "{kind}".')
