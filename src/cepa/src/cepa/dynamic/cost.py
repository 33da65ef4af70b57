"""The cost of flying a velocity, in the terms of equation 6.5 of the thesis. Change the cost here.

The terms are measured along a path by `kernels.rollout.fly_on`. For a further term add a column there.
"""

from __future__ import annotations

import numpy as np

from cepa.dynamic.constants.choice import (
    COST_OF_BEING_HIT,
    COST_OF_CHANGE,
    COST_OF_CLIMB_CHANGE_S_M,
    COST_OF_DISCOMFORT,
    COST_OF_HEIGHT_1_M,
    COST_OF_LEAVING_CHANGE_S_M,
    COST_OF_LOSS,
    SLOWEST_SCALE_M_S,
    USUAL_K4,
    USUAL_K5,
)
from cepa.dynamic.kernels.rollout import HEIGHT
from cepa.parameters import CepaParameters


def limit_progress(
    progress_m: np.ndarray, asked_m: float, has_end: bool, is_faster: np.ndarray, is_admissible: np.ndarray
) -> None:
    """Limit the progress (n,), m, of commands while something moves; all arrays (n,).

    asked_m: what the UAV is asked to make in the same time. has_end: a cost-to-go tells where the way ends.
    is_faster: which commands are faster than usual, to evade what comes.

    - Without an end, each metre beyond ``asked_m`` counts as one that is missed. Else a UAV that may fly
      faster than it is asked to would fly past the place that it is led to.
    - No command loses more than ``asked_m``. Else a UAV that slowly comes back to its place would rather be
      hit there than fly away from it.
    - The faster ones progress no farther than the best of the others: they are not there to arrive sooner.
    """
    if not has_end:
        progress_m[:] = asked_m - np.abs(asked_m - progress_m)
    np.maximum(progress_m, -asked_m, out=progress_m)
    usual_m = progress_m[is_admissible & ~is_faster].max(initial=-np.inf)
    if np.isfinite(usual_m):
        progress_m[is_faster] = np.minimum(progress_m[is_faster], usual_m)


class Cost:
    """Weighs progress against discomfort, against the loss by a contact, and against change."""

    def __init__(self, parameters: CepaParameters):
        self._p = parameters
        self._of_progress, self._of_discomfort = parameters.k2, COST_OF_DISCOMFORT * parameters.k3

    def of(
        self,
        commands: np.ndarray,
        outcomes: np.ndarray,
        last: np.ndarray,
        reference_speed: float,
        own_speed: float,
    ) -> np.ndarray:
        """Return the cost (n,) of each command (n, 3), m/s; outcomes (n, 5): see `roll_out`.

        last: the last command (3,). reference_speed, own_speed: of the reference and of the UAV, m/s.
        """
        progress, discomfort, lost, _, hit = outcomes.T
        change = np.hypot(commands[:, 0] - last[0], commands[:, 1] - last[1])
        k1 = own_speed * self._p.k4 + self._p.k5  # the thesis's; the parameter k1 belongs to `Original`
        of_change = COST_OF_CHANGE * k1 / (own_speed * USUAL_K4 + USUAL_K5)
        flight = (of_change * change - self._of_progress * progress) / max(reference_speed, SLOWEST_SCALE_M_S)
        return flight + self._of_discomfort * discomfort + COST_OF_LOSS * lost + COST_OF_BEING_HIT * hit

    def of_height(
        self, commands: np.ndarray, outcomes: np.ndarray, last: np.ndarray, height_m: float, is_steep: bool
    ) -> np.ndarray:
        """Return the further cost (n,) of each command, for the height ``height_m`` that it misses.

        is_steep: the reference leads up or down, so height is progress.
        """
        change = np.abs(commands[:, 2] - last[2])
        of_height = self._of_progress / SLOWEST_SCALE_M_S if is_steep else COST_OF_HEIGHT_1_M
        return of_height * np.abs(outcomes[:, HEIGHT] - height_m) + COST_OF_CLIMB_CHANGE_S_M * change

    def of_leaving(
        self, commands: np.ndarray, outcomes: np.ndarray, last: np.ndarray, has_direction: bool
    ) -> np.ndarray:
        """Return the cost (n,) of each command in an emergency.

        Commands that progress in the direction to leave in are cheap. Without a direction, those are cheap
        that keep farthest away.
        """
        progress, discomfort, lost, _, hit = outcomes.T
        change = np.linalg.norm(commands - last, axis=1)
        contact = COST_OF_LOSS * lost + COST_OF_BEING_HIT * hit
        return (-progress if has_direction else discomfort) + contact + COST_OF_LEAVING_CHANGE_S_M * change
