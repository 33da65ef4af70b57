"""Weights of particles, and resampling."""

from __future__ import annotations

import numpy as np


def normalised(log_weights: np.ndarray, gain: float) -> np.ndarray:
    """Return weights (particles,) that sum to one, proportional to exp(gain * log weight)."""
    weights = np.exp(gain * (log_weights - log_weights.max()))
    return weights / weights.sum()


def effective_number(weights: np.ndarray) -> float:
    """Return the effective number of particles N_eff = 1 / sum of squared weights (2007, equation 20)."""
    return float(1.0 / np.sum(weights**2))


def entropy(weights: np.ndarray) -> float:
    """Return the entropy of normalised weights."""
    positive = weights[weights > 0.0]
    return float(-np.sum(positive * np.log(positive)))


def systematic(weights: np.ndarray, uniform: float) -> np.ndarray:
    """Return the parent (particles,) of each new particle: a comb of equal teeth over the cumulated weights.

    A particle with weight w gets floor(n w) or ceil(n w) children, n w on average over ``uniform`` in [0, 1).
    """
    teeth = (uniform + np.arange(weights.size)) / weights.size
    cumulated = np.cumsum(weights)
    return np.minimum(np.searchsorted(cumulated / cumulated[-1], teeth, side="right"), weights.size - 1)
