"""How the UAV follows a commanded velocity: a linear loop with limits, and how far it strays from it.

Per horizontal axis, with e = commanded velocity - v:

    q = p e + I - d a,  dI = i e dt,  da = (q - a) dt / lag,  dv = a dt

That is PX4's velocity loop (P, I and D on a measured acceleration) behind an attitude with a delay, a lag and
a limited rate. The defaults have no I and no D, because they predict better so: PX4's integral makes up for
the drag of the air, which this model does not have either (doc/how_it_works.md has the measurements).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from cepa.errors import ParameterError
from flight_basics.checks import check_limits, limited


@dataclass(frozen=True)
class ResponseModel:
    """The velocity loop of a UAV in the plane. Raises ParameterError for a model that makes no sense."""

    p: float = limited(1.5, above=0.0)
    """Acceleration for an error of 1 m/s, 1/s."""
    i: float = limited(0.0, 0.0)
    """Its growth per second, 1/s2."""
    d: float = limited(0.0, 0.0)
    """Damping by the own acceleration. Only p / (1 + d), i / (1 + d) and lag / (1 + d) matter."""
    lag_s: float = limited(0.056, above=0.0)
    """Time constant from the wanted to the flown acceleration: the attitude."""
    delay_s: float = limited(0.048, 0.0)
    """From a command until the acceleration begins to change."""
    acceleration_max_m_s2: float = limited(6.0, above=0.0)
    """The greatest acceleration that is counted on; the UAV must have it."""
    jerk_max_m_s3: float = limited(36.0, above=0.0)
    """The fastest change of the acceleration: the attitude's rate is limited."""
    error_m_s2: float = limited(0.4, 0.0)
    """Bound of the disturbing acceleration (gusts, and what this model leaves out) that it must withstand."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError, "response_{}")
        if not (1.0 + self.d) * self.p > self.i * self.lag_s:
            raise ParameterError(
                f"The response model is unstable: (1 + d) p must be greater than i lag, but "
                f"{(1.0 + self.d) * self.p:.3g} <= {self.i * self.lag_s:.3g}; lower response_i or the lag."
            )

    def dynamics(self) -> tuple[np.ndarray, np.ndarray]:
        """Return A (4, 4) and B (4,) of dx/dt = A x + B u; x = (position, v, a, I)."""
        a = np.array(
            [
                [0.0, 1.0, 0.0, 0.0],
                [0.0, 0.0, 1.0, 0.0],
                [0.0, -self.p / self.lag_s, -(1.0 + self.d) / self.lag_s, 1.0 / self.lag_s],
                [0.0, -self.i, 0.0, 0.0],
            ]
        )
        return a, np.array([0.0, 0.0, self.p / self.lag_s, self.i])

    def transition(self, step_s: float) -> tuple[np.ndarray, np.ndarray]:
        """Return F (4, 4) and G (4,) of x(t + step) = F x(t) + G u for a command u that stays."""
        return _transition(self, step_s)

    def tube_m(self, step_s: float, steps: int) -> np.ndarray:
        """Return how far the UAV can stray from its predicted path, m, after 0, 1, ... ``steps`` steps.

        It is the error's bound times the integral of abs(h), with h the position after a unit impulse of
        acceleration. No disturbance within the bound leads farther, whatever it does in time.
        """
        fine = 20
        f, _ = self.transition(step_s / fine)
        state = np.array([0.0, 1.0, 0.0, 0.0])  # an impulse of acceleration is a step of velocity
        responses = np.empty(steps * fine + 1)
        for k in range(responses.size):
            responses[k] = abs(state[0])
            state = f @ state
        area = np.concatenate(([0.0], np.cumsum(0.5 * (responses[1:] + responses[:-1])) * step_s / fine))
        return self.error_m_s2 * area[::fine]


@lru_cache(maxsize=64)
def _transition(model: ResponseModel, step_s: float) -> tuple[np.ndarray, np.ndarray]:
    from scipy.linalg import expm  # slow to import, and only the algorithm `dynamic` needs it

    a, b = model.dynamics()
    whole = expm(np.block([[a, b[:, None]], [np.zeros((1, 5))]]) * step_s)
    return whole[:4, :4].copy(), whole[:4, 4].copy()
