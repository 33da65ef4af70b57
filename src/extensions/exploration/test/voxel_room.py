"""A true world of voxels, a level lidar in it that fills a map, and a UAV that is moved along its plans."""

import math

import numpy as np
from scipy import ndimage

from exploration.planning import FREE, OCCUPIED, UNKNOWN, PathPlanner, PlannerParameters
from flight_basics.errors import NoPathError
from flight_limits import parse_limits

SIDE_M = 0.2
TILE = 52
LIDAR_MAX_M = 12.0
PLANNER = PlannerParameters(radius=0.3, margin=0.1)


def room(size_m, walls=()):
    """A closed room (d, h, w) from the origin; walls: boxes (low, high), x, y, z in m, that are filled."""
    shape = [round(length / SIDE_M) for length in size_m[::-1]]
    filled = np.ones((TILE, TILE, TILE), bool)
    filled[1 : shape[0] - 1, 1 : shape[1] - 1, 1 : shape[2] - 1] = False
    for low, high in walls:
        a, b = (np.round(np.array(corner[::-1]) / SIDE_M).astype(int) for corner in (low, high))
        filled[a[0] : b[0], a[1] : b[1], a[2] : b[2]] = True
    return filled


def beams(elevation_rad=0.26, rings=16, around=120):
    elevation, azimuth = np.meshgrid(
        np.linspace(-elevation_rad, elevation_rad, rings), np.linspace(0.0, math.tau, around, endpoint=False)
    )
    level = np.cos(elevation)
    return np.stack((level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)), -1).reshape(-1, 3)


class Flight:
    """A UAV without dynamics: it is where its plan leads, and looks around on the way."""

    def __init__(self, filled, start_m, directions=None, sees_m=LIDAR_MAX_M, parameters=PLANNER):
        self.filled = filled
        self.kinds = np.full(filled.shape, UNKNOWN, np.uint8)
        self.place_m = np.array(start_m, float)
        self.directions = beams() if directions is None else directions
        self.planner, self.sees_m = PathPlanner(parameters), sees_m
        self.way_m = 0.0
        self.places_m = [self.place_m]
        x, y, z = (self.place_m / SIDE_M).astype(int)
        self.kinds[z - 2 : z + 3, y - 2 : y + 3, x - 2 : x + 3] = FREE  # where it stood
        self.look()

    def look(self):
        is_on = np.ones(len(self.directions), bool)
        for far_m in np.arange(0.0, self.sees_m, SIDE_M / 3):
            points = self.place_m + far_m * self.directions[is_on]
            x, y, z = (points / SIDE_M).astype(int).T
            hits = self.filled[z, y, x]
            self.kinds[z[hits], y[hits], x[hits]] = OCCUPIED
            seen = self.kinds[z[~hits], y[~hits], x[~hits]]
            self.kinds[z[~hits], y[~hits], x[~hits]] = np.where(seen == OCCUPIED, OCCUPIED, FREE)
            is_on[np.flatnonzero(is_on)[hits]] = False
            if not is_on.any():
                break
        self.planner.update_map(SIDE_M, TILE, np.zeros((1, 3), int), self.kinds.reshape(1, -1))

    def space(self):
        return self.planner.space(0.0, self.place_m)

    def fly_to(self, goal_m, step_m=0.4):
        plan = self.planner.plan(self.place_m, np.array(goal_m))
        for a, b in zip(plan.points_m, plan.points_m[1:]):
            for share in np.linspace(0.0, 1.0, max(2, math.ceil(math.dist(a, b) / step_m) + 1))[1:]:
                there = a + share * (b - a)
                self.way_m += math.dist(self.place_m, there)
                self.place_m = there
                self.places_m.append(there)
                self.look()

    def explore(self, explorer, views_max=200):
        """Fly until the explorer says that nothing is left; return that decision and the number of views."""
        for views in range(views_max):
            decision = explorer.decide(self.space(), self.place_m)
            if decision.goal_m is None:
                return decision, views
            try:
                self.fly_to(decision.goal_m)
            except NoPathError as error:
                raise AssertionError(f"the way that was promised is none: {error}") from None
        raise AssertionError(f"it does not end: {decision}")


def reachable(flight):
    """Where the UAV fits in the true world: a flood fill from its start, without the explorer's code."""
    fits = ndimage.distance_transform_edt(~flight.filled) * SIDE_M >= PLANNER.clearance_m + SIDE_M
    labels, _ = ndimage.label(fits, np.ones((3, 3, 3)))
    x, y, z = (flight.places_m[0] / SIDE_M).astype(int)
    return labels == labels[z, y, x]


def next_places(exploration, flight, step_m):
    """Yield where the UAV would be half a second later, until the exploration ends."""
    for stamp_s in np.arange(0.0, 900.0, 0.5):
        if exploration.follow(float(stamp_s), flight.place_m):
            exploration.look(float(stamp_s), flight.place_m)
        if exploration.explored.end is not None:
            return
        away_m = exploration.setpoint_m - flight.place_m
        yield flight.place_m + away_m * min(1.0, step_m / max(math.hypot(*away_m), 1e-9))


def open_box(side=32):
    """A planner that knows a free box of 6.4 m, and may not be at x > 4 m."""
    planner = PathPlanner(
        PlannerParameters(radius=0.3, margin=0.1),
        parse_limits({"keep_in": {"low": [-9] * 3, "high": [4, 9, 9]}}),
    )
    kinds = np.full((1, side**3), FREE, np.uint8)
    planner.update_map(0.2, side, np.zeros((1, 3), np.int64), kinds)
    return planner
