"""What may lie below a UAV whose range finder reads another height than expected.

A reading of the range finder is the UAV's height less the floor's. Each hypothesis is a Kalman filter with an
opinion on the floor: the one of before, one that was seen before, a new one, or a reading that tells nothing.
A few hypotheses live on, and the readings that follow decide between them. So a step of the floor that is
hardly greater than the noise, and comes in two readings, is no climb.

Reference: Blom and Bar-Shalom 1988 for filters side by side, each with its own idea of what has changed.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

HEIGHT, CLIMB, BIAS, FLOOR, MAP = range(5)
"""Of a state: m, m/s, m/s2, m over the floor of the start, and m by which the clouds' map tells too much."""
CLIMB_FIRST = 0.5
SAME_LEVEL_M = 0.05
"""A floor nearer than this to one that was seen before is that one."""
NEW = -1
"""Level of a floor that is not confirmed yet."""
SLOPING = -2
"""Level of a floor that is not level."""
STEP_CHANCE, LOST_CHANCE, SHOCK_CHANCE = 0.02, 0.02, 0.005
"""Chances that between two readings the floor has a step, that a reading tells nothing, and that a shock has
spoiled the prediction, as at a touchdown."""
JUMP_SHARE = 0.25
"""After a shock the readings go on as before: they jump by less than this share of what they are off by."""
SHOCK_BELOW_M = 0.5
"""Only so near to what is below there are shocks. Higher up, readings that change from one to the next are an
edge that passes through the range finder's cone."""
STEP_SIGMA_M = 1.0
"""Of a new floor's height."""
LOST_DENSITY = 0.1
"""1/m: a reading that tells nothing may be any within some 10 m."""
ALIVE, LEAST_LOG_CHANCE = 6, -12.0
SAME_M = 0.01
"""Two hypotheses that differ by less are one."""


@dataclass(frozen=True)
class Level:
    """A floor that was seen: its height over that of the start in m, and the variance of it."""

    height_m: float
    variance_m2: float


@dataclass(frozen=True)
class Hypothesis:
    """A filter with an opinion on the floor.

    state: (5,), see `HEIGHT`. covariance: (5, 5). log_chance: of it, up to a constant. level: index of the
    floor below among the levels, or `NEW`. readings: how many in a row agree with that floor. has_counted:
    whether it counted the newest one.
    """

    state: np.ndarray
    covariance: np.ndarray
    log_chance: float = 0.0
    level: int = 0
    readings: int = 0
    has_counted: bool = True

    def measured(self, model: np.ndarray, value: float, variance_m2: float) -> Hypothesis:
        """Return it after a measurement of ``model`` (5,) times the state, and its chance with that."""
        spread = self.covariance @ model
        total = float(model @ spread) + variance_m2
        innovation = value - float(model @ self.state)
        gain = spread / total
        return replace(
            self,
            state=self.state + gain * innovation,
            covariance=self.covariance - np.outer(gain, spread),
            log_chance=self.log_chance - 0.5 * (innovation**2 / total + math.log(2.0 * math.pi * total)),
        )

    def over(self, level: int, height_m: float, variance_m2: float, chance: float) -> Hypothesis:
        """Return it over another floor, whose height has nothing to do with the one below so far."""
        state, covariance = self.state.copy(), self.covariance.copy()
        state[FLOOR] = height_m
        covariance[FLOOR, :] = covariance[:, FLOOR] = 0.0
        covariance[FLOOR, FLOOR] = variance_m2
        log_chance = self.log_chance + math.log(chance)
        return replace(
            self, state=state, covariance=covariance, log_chance=log_chance, level=level, readings=0
        )

    def after_height(
        self,
        model: np.ndarray,
        height_m: float,
        variance_m2: float,
        levels: Sequence[Level],
        step_m: float,
        may_shift: bool,
    ) -> list[Hypothesis]:
        """Return what a height that clouds tell may mean; model as of `measured`.

        If it is off by more than a step, the map of the clouds may be off, as where a cloud meets surfaces
        that were entered at another height. If it has come to be off little by little, the floor may have
        sunk or risen so slowly that it passed for a climb, as at an edge in the range finder's cone. Then
        height and floor are off alike.

        may_shift: whether it has come to be off little by little.
        """
        off_m = height_m - float(model @ self.state)
        meanings = [self.measured(model, height_m, variance_m2)]
        if abs(off_m) > step_m and may_shift:
            floor_m, level = float(self.state[FLOOR]) + off_m, NEW
            for index, seen in enumerate(levels):
                if abs(seen.height_m - floor_m) < SAME_LEVEL_M:
                    off_m, level = off_m + seen.height_m - floor_m, index
                    break
            meanings.append(self.shifted(off_m, level, variance_m2, STEP_CHANCE / (1 + len(levels))))
            meanings[-1] = meanings[-1].measured(model, height_m, variance_m2)
        return meanings

    def with_other_map(self, off_m: float) -> Hypothesis:
        """Return it with a map of the clouds that may be off by this much, whatever it was off by before."""
        covariance = self.covariance.copy()
        covariance[MAP, MAP] += off_m**2
        return replace(self, covariance=covariance)

    def over_slope(self, range_m: float, variance_m2: float) -> Hypothesis:
        """Return it over a sloping floor, which lies so far below it. That tells nothing of its height."""
        state, covariance = self.state.copy(), self.covariance.copy()
        state[FLOOR] = state[HEIGHT] - range_m
        covariance[FLOOR, :] = covariance[HEIGHT, :]
        covariance[:, FLOOR] = covariance[:, HEIGHT]
        covariance[FLOOR, FLOOR] = covariance[HEIGHT, HEIGHT] + variance_m2
        return replace(self, state=state, covariance=covariance, level=SLOPING, readings=0, has_counted=True)

    def shifted(self, off_m: float, level: int, variance_m2: float, chance: float) -> Hypothesis:
        """Return it with height and floor moved alike, so that the readings fit as before."""
        state, covariance = self.state.copy(), self.covariance.copy()
        state[[HEIGHT, FLOOR]] += off_m
        covariance[np.ix_((HEIGHT, FLOOR), (HEIGHT, FLOOR))] += variance_m2
        log_chance = self.log_chance + math.log(chance)
        return replace(
            self, state=state, covariance=covariance, log_chance=log_chance, level=level, readings=0
        )

    def explanations(
        self,
        range_m: float,
        jump_m: float,
        delay_s: float,
        variance_m2: float,
        levels: Sequence[Level],
        step_m: float,
    ) -> list[Hypothesis]:
        """Return what a reading may mean.

        Args:
            range_m: height over what is below, ``delay_s`` before the state's time.
            jump_m: from the reading before to this one.
            delay_s: see above.
            variance_m2: of the reading.
            levels: floors that were seen.
            step_m: a smaller step is none.
        """
        model = np.array((1.0, -delay_s, 0.0, -1.0, 0.0))
        off_m = range_m - float(model @ self.state)
        chances = STEP_CHANCE / (1 + len(levels))
        floors = [self]
        if abs(off_m) > step_m:
            floors += [
                self.over(NEW, float(self.state[FLOOR]) - off_m, STEP_SIGMA_M**2, chances),
                *(
                    self.over(index, level.height_m, level.variance_m2, chances)
                    for index, level in enumerate(levels)
                    if index != self.level and abs(level.height_m - self.state[FLOOR]) > step_m
                ),
            ]
            if range_m < SHOCK_BELOW_M and abs(jump_m) < JUMP_SHARE * abs(off_m):
                floors.append(self._doubted(off_m))
        return [self._lost(), *(each.measured(model, range_m, variance_m2)._counting() for each in floors)]

    def _counting(self) -> Hypothesis:
        return replace(self, readings=self.readings + 1, has_counted=True)

    def _lost(self) -> Hypothesis:
        """Return it without the newest reading."""
        log_chance = self.log_chance + math.log(LOST_CHANCE * LOST_DENSITY)
        return replace(self, log_chance=log_chance, has_counted=False)

    def _doubted(self, error_m: float) -> Hypothesis:
        """Return it with height and climb uncertain, because the height is off by this much."""
        covariance = self.covariance.copy()
        covariance[HEIGHT, HEIGHT] += error_m**2
        covariance[CLIMB, CLIMB] += CLIMB_FIRST**2
        return replace(self, covariance=covariance, log_chance=self.log_chance + math.log(SHOCK_CHANCE))


def likeliest(candidates: Sequence[Hypothesis]) -> list[Hypothesis]:
    """Return the few that live on, the likeliest first, with chances of which the greatest is 1."""
    ranked = sorted(candidates, key=lambda each: -each.log_chance)
    best = ranked[0].log_chance
    kept: list[Hypothesis] = []
    for each in ranked:
        if each.log_chance < best + LEAST_LOG_CHANCE or len(kept) == ALIVE:
            break
        if not any(_is_same(each, other) for other in kept):
            kept.append(replace(each, log_chance=each.log_chance - best))
    return kept


def _is_same(one: Hypothesis, other: Hypothesis) -> bool:
    apart = np.abs(one.state - other.state)
    return bool(one.level == other.level and apart[HEIGHT] < SAME_M and apart[FLOOR] < SAME_M)
