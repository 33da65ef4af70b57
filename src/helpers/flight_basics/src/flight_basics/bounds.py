"""Bounds that several nodes share."""

FARTHEST_M = 1e6
"""A pose or a setpoint beyond this is refused as a mistake."""

MAX_TIME_STEP_S = 0.1
"""A longer gap between poses counts as this long, so that the velocity never jumps after a gap."""
