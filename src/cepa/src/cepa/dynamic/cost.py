"""The cost of flying a velocity, in the terms of equation 6.5 of the thesis."""

from __future__ import annotations

import numpy as np

from cepa.parameters import CepaParameters

COMFORT, LOST, CHANGE = 1.2, 1.0, 0.2
"""Of k3, of the whole horizon, and of k1 = |v_uav| k4 + k5 relative to its value with k4 = 1 and k5 = 6."""
CAUGHT = 6.0
"""For the whole horizon lost to what moves. It counts more than any progress in MEETING_S."""
USUAL_K4, USUAL_K5 = 1.0, 6.0
HEIGHT, CLIMB_CHANGE = 0.3, 0.05
"""For a metre off the height, and for a change of the climb by 1 m/s."""
LEAVING_CHANGE = 0.02
"""For a change of the command by 1 m/s in an emergency."""
SLOWEST_SCALE_M_S = 1.0


class Cost:
    """Weighs progress against discomfort, against the loss by a contact, and against change."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self.progress, self.comfort, self.lost = parameters.k2, COMFORT * parameters.k3, LOST
        self.height, self.climb_change = HEIGHT, CLIMB_CHANGE
        self.leaving_change = LEAVING_CHANGE

    def of(
        self, commands: np.ndarray, results: np.ndarray, last: np.ndarray, speed: float, own_speed: float
    ) -> np.ndarray:
        """Return the cost (n,) of each command (n, 3), m/s; results (n, 5): what `judge` found.

        last: the last command (3,). speed, own_speed: of the reference and of the UAV, m/s.
        """
        progress, discomfort, lost, _, caught = results.T
        change = np.hypot(commands[:, 0] - last[0], commands[:, 1] - last[1])
        k1 = own_speed * self._p.k4 + self._p.k5
        steady = CHANGE * k1 / (own_speed * USUAL_K4 + USUAL_K5)
        along = (steady * change - self.progress * progress) / max(speed, SLOWEST_SCALE_M_S)
        return along + self.comfort * discomfort + self.lost * lost + CAUGHT * caught

    def of_height(
        self, commands: np.ndarray, results: np.ndarray, last: np.ndarray, height_m: float
    ) -> np.ndarray:
        """Return the further cost (n,) of each command, for the height ``height_m`` that it misses."""
        change = np.abs(commands[:, 2] - last[2])
        return self.height * np.abs(results[:, 3] - height_m) + self.climb_change * change

    def of_leaving(
        self, commands: np.ndarray, results: np.ndarray, last: np.ndarray, has_direction: bool
    ) -> np.ndarray:
        """Return the cost (n,) of each command in an emergency.

        Commands that progress in the direction to leave in are cheap. Without a direction, those are cheap
        that keep farthest away.
        """
        progress, discomfort, lost, _, caught = results.T
        change = np.linalg.norm(commands - last, axis=1)
        contact = self.lost * lost + CAUGHT * caught
        return (-progress if has_direction else discomfort) + contact + self.leaving_change * change
