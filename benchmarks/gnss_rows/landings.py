"""Experiment 1 without GNSS, from the take-off to the landing at its goal: where it lands, and how.

The forest by `improved`, as the launch file flies it. At the goal the lidar sees few trunks.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Sequence

import numpy as np

from flights.flight.closed_loop import ClosedLoop
from flights.flight.judging.landing import TILT_MOST_RAD
from gridslam.odometry.warm_up import warm_up_odometry
from master_thesis.experiment_1.scenario_flight import scenario_parameters

NEAR_M = 0.5
"""A landing within this of the goal is one that was wanted."""


def fly(seed: int) -> dict:
    """Fly once. off_goal_m: horizontal, by the true pose at the end. tilt_deg: then, too."""
    warm_up_odometry()
    parameters = scenario_parameters("forest", "improved", seed)
    simulation = replace(parameters.simulation, sensors=("range_finder",), gnss=False)
    with ClosedLoop(replace(parameters, simulation=simulation, pose_source="odometry")) as loop:
        outcome = loop.run()
        end_xy = loop.log.truth.array("x_m", "y_m")[-1]
    assert parameters.goal_xyz_m is not None  # it is Experiment 1
    landing = outcome.landing
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "off_goal_m": math.dist(end_xy, parameters.goal_xyz_m[:2]),
        "tilt_deg": math.nan if landing is None else math.degrees(landing.tilt_rad),
    }


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, and median and worst of the distance from the goal.

    upright_near: of those that stand upright within `NEAR_M` of the goal.
    """
    off_m = [trial["off_goal_m"] for trial in trials]
    upright = [trial["tilt_deg"] <= math.degrees(TILT_MOST_RAD) for trial in trials]  # false for NaN
    return {
        "flights": len(trials),
        **{key: sum(trial[key] for trial in trials) for key in ("flown", "contact")},
        "upright_near": sum(stands and off <= NEAR_M for stands, off in zip(upright, off_m)),
        "off_goal_m": {"median": float(np.median(off_m)), "worst": max(off_m)},
    }
