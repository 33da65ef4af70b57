"""Explores a place once without ROS, and judges the map by the world's own surfaces."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from exploration.next_view import Explored
from flights.exploring.flight import ExploringFlight
from flights.exploring.judge import Judged, judge_map
from flights.exploring.places import Place
from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Outcome, Phase
from gridslam.evaluation.volume.lidars import VIEWS
from gridslam.volume.voxel_map import VoxelMap

HOME_M = 1.0
JUDGED_M = 1.5
"""Over the start: there the UAV was on its first way up."""


@dataclass(frozen=True)
class JudgedFlight:
    """A flight, and what its map is worth.

    began_s: when the exploration began. path_m: (n, 3) of the UAV, true. is_home: it stands at its start.
    """

    explored: Explored
    outcome: Outcome
    began_s: float
    path_m: np.ndarray
    is_home: bool
    judged: Judged
    voxels: VoxelMap

    @property
    def home_s(self) -> float:
        """Time from the begin until it was home; NaN: it was not."""
        return self.outcome.times_s.get(Phase.HOVERING, math.nan) - self.began_s

    @property
    def known(self) -> np.ndarray:
        """Rows (n, 2): time from the begin, s, and the volume that was known, m3."""
        return np.array(self.explored.known_m3).reshape(-1, 2) - (self.began_s, 0.0)


def fly_and_judge(place: Place, world: Path, seed: int, time_s: float, longest_s: float) -> JudgedFlight:
    """Explore. world: the place's file. time_s: then the UAV flies home. longest_s: then it lands."""
    given = place.loop_parameters(world, seed, longest_s)
    with ClosedLoop(given) as loop:
        flight = ExploringFlight(loop, place.planner, place.explorer, place.volume, place.asked(time_s))
        explored = flight.run()
        outcome, path_m = loop.outcome, loop.log.truth.array("x_m", "y_m", "z_m")
    begin_z_m = place.start_m[2] + min(JUDGED_M, given.publisher.hover_height_m)
    rng, hover_m = np.random.default_rng(seed), np.array((*place.start_m[:2], begin_z_m))
    view = replace(VIEWS[place.uav.lidar], range_max_m=place.volume.max_range_m)
    judged = judge_map(flight.volume.shown, world, place.box_m, hover_m, place.clearance_m, view, rng)
    is_home = outcome.landed and math.dist(path_m[-1, :2], place.start_m[:2]) < HOME_M
    began_s = outcome.times_s[Phase.FLYING]
    return JudgedFlight(explored, outcome, began_s, path_m, is_home, judged, flight.volume.corrected.voxels)
