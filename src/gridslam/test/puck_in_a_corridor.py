"""A lidar of 16 rings in a corridor whose floor rises, in closed form, and a UAV that flies up and back."""

import math

import numpy as np

HALF_WIDTH_M, HIGH_M = 2.0, 3.0
BEGIN_M, SLOPE_M, LEVEL_M = -3.0, 12.0, 6.0
"""The floor is level for so long, then rises over the second, then is level again. The ceiling runs along."""
SPEED_M_S, HOVER_M = 1.2, 1.5
CLIMB_S = 4.0
"""It takes off in this time."""


class Corridor:
    """slope_rad: of the middle 12 m. length_m: of all.

    back_s: when the UAV is at the far end, and turns back.
    """

    def __init__(self, slope_rad, length_m=24.0):
        rise_m = SLOPE_M * math.tan(slope_rad)
        self.bends_m = BEGIN_M + np.array([0.0, LEVEL_M, LEVEL_M + SLOPE_M, length_m])
        self.floor_m = np.array([0.0, 0.0, rise_m, rise_m])
        self.far_m = float(self.bends_m[-1]) - 3.0
        self.back_s = CLIMB_S + self.far_m / SPEED_M_S

    def floor_at(self, x_m):
        return np.interp(x_m, self.bends_m, self.floor_m)

    def ranges_m(self, origin, rays):
        """Distances (n,) from inside along unit vectors (n, 3) to walls, ends, floors and ceilings."""
        with np.errstate(divide="ignore", invalid="ignore"):
            sides = (np.sign(rays[:, 1]) * HALF_WIDTH_M - origin[1]) / rays[:, 1]
            ends = (np.where(rays[:, 0] > 0, self.bends_m[-1], self.bends_m[0]) - origin[0]) / rays[:, 0]
        found = np.fmin(np.where(sides > 0, sides, np.inf), np.where(ends > 0, ends, np.inf))
        for (left, right), (low, high) in zip(_pairs(self.bends_m), _pairs(self.floor_m)):
            slope = (high - low) / (right - left)
            for above_m in (0.0, HIGH_M):
                with np.errstate(divide="ignore", invalid="ignore"):
                    to_m = (low + above_m + slope * (origin[0] - left) - origin[2]) / (
                        rays[:, 2] - slope * rays[:, 0]
                    )
                    x_m = origin[0] + to_m * rays[:, 0]
                found = np.where((to_m > 0) & (x_m >= left) & (x_m <= right), np.fmin(found, to_m), found)
        return found

    def place_at(self, time_s):
        """At rest for a second, up, along the corridor to 3 m before its end and, if there is time, back."""
        up = _smooth((time_s - 1.0) / (CLIMB_S - 1.0))
        there_s = self.back_s - CLIMB_S
        x_m = self.far_m * (_smooth((time_s - CLIMB_S) / there_s) - _smooth((time_s - self.back_s) / there_s))
        around = np.linspace(-0.75, 0.75, 16)
        return np.array([x_m, 0.0, 0.1 + (HOVER_M - 0.1) * up + float(np.mean(self.floor_at(x_m + around)))])


def _pairs(values):
    return zip(values, values[1:])


def _smooth(share):
    """From 0 to 1 with a speed that begins and ends at 0."""
    share = min(max(share, 0.0), 1.0)
    return share - math.sin(2.0 * math.pi * share) / (2.0 * math.pi)
