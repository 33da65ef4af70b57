"""The flight to one photograph: when the UAV is there and at rest, and when it does not get there."""

from __future__ import annotations

import math

import numpy as np

from inspection.flight.legs.passing import Passing
from inspection.flight.motion import Motion
from inspection.flight.parameters import InspectionParameters
from inspection.flight.photograph_queue import Task

SLOW = 3.0
"""A leg may take so many times as long as at full speed, and `LEG_S` more."""
LEG_S = 15.0
STRICTER = 0.5
"""For each failure of a photograph, the UAV moves so much less."""
LATE = 2.0
"""When patience is over, the UAV may move so many times as fast."""


class PhotographLeg:
    """Watches the UAV on its way to a photograph, and there.

    Args:
        task: the photograph. place_m: of the UAV there. stamp_s: now. way_m: length of its way.
        tilt_rad: that the gimbal has to turn. parameters: see there. failures: of this photograph before;
            the UAV rests more each time. overshoot_m: where the UAV aims if it takes the photograph in
            passing; None: it comes to rest.

    Attributes:
        is_shot: the shutter has opened. aim_m: where to aim on the last stretch, (x, y, z); None: at the
        place itself.
    """

    def __init__(
        self,
        task: Task,
        place_m: np.ndarray,
        stamp_s: float,
        way_m: float,
        tilt_rad: float,
        parameters: InspectionParameters,
        failures: int = 0,
        overshoot_m: np.ndarray | None = None,
    ) -> None:
        self.task, self.is_shot, self._place_m, self._p = task, False, place_m, parameters
        self.aim_m: np.ndarray | None = None
        self._passing, self._settle_s = None, parameters.settle
        if overshoot_m is not None:
            turned_rad = math.radians(parameters.turned)
            self._passing = Passing(place_m, overshoot_m, task.view.yaw_rad, parameters.near, turned_rad)
            self._settle_s = 0.0
        stricter = 1.0 + STRICTER * failures
        self._still_mm = parameters.still * parameters.most_blur_mm(task.number < 0) / stricter
        self._began_s, self._longest_m = stamp_s, way_m
        self._tilted_s = stamp_s + abs(math.degrees(tilt_rad)) / self._p.tilt_rate + self._p.settle
        self._arrived_s: float | None = None
        self._settled_s: float | None = None
        self._rests_s: float | None = None

    def go_on_from(self, before: PhotographLeg) -> None:
        """Go on with the patience of the leg before: this one is another way to the same photograph."""
        self._began_s, self._longest_m = before._began_s, max(self._longest_m, before._longest_m)

    @property
    def _until_s(self) -> float:
        """When it should be there."""
        return self._began_s + SLOW * self._longest_m / self._p.speed + LEG_S

    @property
    def has_arrived(self) -> bool:
        """Whether the UAV was once within `far` of the place."""
        return self._arrived_s is not None

    def follow(self, motion: Motion) -> str:
        """Take a pose. Return why the photograph cannot be taken now; empty: it can, or may still."""
        p, stamp_s, off_m = self._p, motion.time_s, math.dist(motion.place_m, self._place_m)
        if self._passing is not None:
            self.aim_m = self._passing.overshoot_m if self._passing.goes_on(motion) else None
        turn = abs(math.remainder(motion.yaw_rad - self.task.view.yaw_rad, 2.0 * math.pi))
        is_still = turn <= math.radians(p.turned) and self._rests(motion)
        if self._arrived_s is None and off_m <= p.far:
            self._arrived_s = stamp_s
        self._settled_s = _since(self._settled_s, is_still and off_m <= p.near, stamp_s)
        self._rests_s = _since(self._rests_s, is_still and off_m <= p.far, stamp_s)
        if self.is_shot:
            return ""
        if self._arrived_s is None and stamp_s > self._until_s:
            return f"the UAV did not get there: it was kept {off_m:.1f} m away"
        if self._arrived_s is not None and stamp_s > self._arrived_s + 2.0 * p.patience + LEG_S:
            return f"the UAV did not stay there: it was {off_m:.1f} m away"
        return ""

    def opens_shutter(self, motion: Motion) -> bool:
        """Return whether the shutter opens now, once."""
        p, stamp_s = self._p, motion.time_s
        if self.is_shot or self._arrived_s is None or stamp_s < self._tilted_s:
            return False
        is_settled = self._settled_s is not None and stamp_s >= self._settled_s + self._settle_s
        # CEPA may keep it off a little; then it comes to rest beside the place.
        rests = self._rests_s is not None and stamp_s >= self._rests_s + p.rest
        off_m = math.dist(motion.place_m, self._place_m)
        is_calm = self._rests_s is not None and stamp_s >= self._arrived_s + p.calm
        is_late = stamp_s > self._arrived_s + p.patience and off_m <= p.far and self._rests(motion, LATE)
        self.is_shot = is_settled or rests or is_calm or is_late
        return self.is_shot

    def _rests(self, motion: Motion, times: float = 1.0) -> bool:
        """Return whether the UAV moves and turns slower than allowed, so many times. Both blur: they add."""
        p = self._p
        shift_m, turn_rad = p.exposure * motion.speed, p.exposure * abs(motion.turn_rate)
        return p.blur_mm(shift_m, turn_rad, self.task.number < 0) <= times * self._still_mm


def _since(before_s: float | None, holds: bool, stamp_s: float) -> float | None:
    """Return since when something holds."""
    if not holds:
        return None
    return stamp_s if before_s is None else before_s
