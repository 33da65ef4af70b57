"""What an accelerometer feels of an impact that stops a rigid body within one step."""

from __future__ import annotations

import numpy as np


class ImpactLimiter:
    """Spreads what exceeds a limit over the next samples.

    A rigid body stops within one step, at 18 g from 0.7 m/s. Real legs and mounts bend, so they take longer.
    What exceeds the limit is added to the next samples. So their sum still equals the change of velocity.
    """

    def __init__(self, limit_m_s2: float) -> None:
        """limit_m_s2: no sample exceeds it on any axis."""
        self._limit_m_s2 = limit_m_s2
        self.restart()

    def restart(self) -> None:
        """Forget earlier impacts."""
        self._rest = np.zeros(3)

    def felt(self, force_m_s2: np.ndarray) -> np.ndarray:
        """Return the part (3,) of a specific force that the accelerometer measures now."""
        wanted = force_m_s2 + self._rest
        felt = np.clip(wanted, -self._limit_m_s2, self._limit_m_s2)
        self._rest = wanted - felt
        return felt
