"""Boxes of 0.5 m under the way: the height over the floor, and the climb that is commanded while they pass.

The UAV flies the first leg of Experiment 4 by its odometry and lands. A box changes what the range finder
measures by 0.5 m within one reading. The commanded climb must not follow.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Sequence

import numpy as np

from flights.flight.closed_loop import ClosedLoop
from flights.flight.course import Phase
from flights.worlds.placements import Obstacle, varied
from flights.worlds.writer import Box
from gridslam.odometry.warm_up import warm_up_odometry
from master_thesis.experiments_3_4.without_gnss.flight import parameters_without_gnss

HEIGHT_M = 0.5
BOXES = tuple(
    Obstacle(f"low_box_{number}", Box(along_m, 3.0, HEIGHT_M), x_m, -7.0)
    for number, (along_m, x_m) in enumerate(((0.4, 2.5), (1.0, 4.5), (2.5, 7.5), (0.5, 9.6), (0.5, 10.6)))
)
WITHIN_S = 0.5
"""A change of the commanded climb within this time counts as a jump."""
AFTER_S = 2.0
"""The command is watched for this time after each box, too."""
METRICS = ("height_p95_m", "height_over_boxes_m", "step_m_s", "jump_m_s", "climb_m_s")


def fly(seed: int) -> dict:
    """Fly once; return the errors of the height in m, and of the commanded climb in m/s its greatest change.

    height_p95_m: over flat ground, 95 %. height_over_boxes_m: greatest over boxes. step_m_s: from one command
    to the next. jump_m_s: within `WITHIN_S`. climb_m_s: the greatest climb or descent that was commanded.
    """
    warm_up_odometry()
    boxes = varied(BOXES, np.random.default_rng(seed))
    parameters = parameters_without_gnss("hold", "ust", seed)
    with ClosedLoop(replace(parameters, mission=parameters.mission[:1])) as loop:
        for box in boxes:
            loop.simulation.world.spawn(box.model(), box.name, box.pose())
        outcome = loop.run()
        truth = loop.log.truth.array("t_s", "x_m", "y_m", "z_m")
        commands = loop.log.v_final.array("t_s", "vz_m_s")
        assert loop.own_odometry is not None  # there is no GNSS
        found = np.array([(e.stamp_s, e.position_xyz[2]) for e in loop.own_odometry.estimates])
    below = over(truth[:, 1:3], boxes)
    flying_s = (outcome.times_s[Phase.FLYING], outcome.times_s[Phase.HOVERING])
    height_off_m = np.abs(found[:, 1] - np.interp(found[:, 0], truth[:, 0], truth[:, 3]))
    box_below = np.interp(found[:, 0], truth[:, 0], below) > 0.0
    passing = commands[_is_near(commands[:, 0], truth[below, 0]) & _is_between(commands[:, 0], flying_s)]
    return {
        "flown": outcome.reached_goal and outcome.landed,
        "contact": outcome.collision,
        "boxes": int((np.diff(below.astype(int)) == 1).sum()),
        "height_p95_m": float(np.percentile(height_off_m[~box_below], 95)),
        "height_over_boxes_m": float(height_off_m[box_below].max()),
        "step_m_s": change_within(passing, 0.0),
        "jump_m_s": change_within(passing, WITHIN_S),
        "climb_m_s": float(np.abs(passing[:, 1]).max()),
    }


def summary(trials: Sequence[dict]) -> dict:
    """Return counts, and median and worst of each metric."""
    counts = {key: sum(trial[key] for trial in trials) for key in ("flown", "contact", "boxes")}
    values = {key: [trial[key] for trial in trials] for key in METRICS}
    spread = {key: {"median": float(np.median(all_)), "worst": max(all_)} for key, all_ in values.items()}
    return {"flights": len(trials), **counts, **spread}


def over(places_xy: np.ndarray, boxes: Sequence[Obstacle]) -> np.ndarray:
    """Return (n,) whether one of the boxes is below a place (n, 2)."""
    below = np.zeros(len(places_xy), dtype=bool)
    for box in boxes:
        assert isinstance(box.shape, Box)
        off = np.abs(places_xy - (box.x_m, box.y_m))
        below |= (off <= (box.shape.x_m / 2, box.shape.y_m / 2)).all(axis=1)
    return below


def change_within(rows: np.ndarray, seconds: float) -> float:
    """Return the greatest change of a value from one row to a later one; rows (n, 2): time in s and value.

    seconds: the later row is the next one, or at most this much later.
    """
    greatest = 0.0
    for i, (t_s, value) in enumerate(rows[:-1]):
        end = max(i + 2, np.searchsorted(rows[:, 0], t_s + seconds, side="right"))
        greatest = max(greatest, float(np.abs(rows[i + 1 : end, 1] - value).max()))
    return greatest


def _is_near(times_s: np.ndarray, box_s: np.ndarray) -> np.ndarray:
    """Return (n,) whether a box was below at most `AFTER_S` before a time."""
    newest = np.searchsorted(box_s, times_s, side="right") - 1
    return (newest >= 0) & (times_s - box_s[newest] <= AFTER_S)


def _is_between(times_s: np.ndarray, limits_s: tuple[float, float]) -> np.ndarray:
    return (limits_s[0] <= times_s) & (times_s <= limits_s[1])
