"""What Dynamic knew and foresaw at its last answer, for logs and pictures; computed when it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cepa.dynamic.lookout import Lookout, Sight
from cepa.kernels.rollout import Horizon, Response, Surroundings, roll
from cepa.motion import Motion

HERE = np.zeros((1, 2))


class Moment(NamedTuple):
    """What was known when a scan came. Arrays are along the odometry's axes, with the lidar at the origin."""

    motion: Motion
    standing: np.ndarray
    """(n, 2) m: the ends of the beams that hit what stands still."""
    seen: np.ndarray
    """(SIGHT_BINS,) m: how far each direction is seen."""
    state: np.ndarray
    """(3, 4): see kernels/rollout.py."""


class Judgement(NamedTuple):
    """How the candidates were judged. There is none if nothing was near the reference's path."""

    sight: Sight
    around: Surroundings
    admissible: int
    """Number of candidates that could be flown."""
    braking_margin_m: float
    """How much more than it must keep the UAV would keep from everything if it braked at once."""


@dataclass(frozen=True)
class Report:
    """The reasons of an answer in numbers; None: it was not looked at, because the reference was clear."""

    clearance_m: float
    """From the UAV's hull to the nearest thing in the scan; inf: nothing is seen."""
    admissible: int | None = None
    """Number of candidates that could be flown."""
    braking_margin_m: float | None = None
    """How much more than it must keep the UAV would keep from everything if it braked at once."""
    remembered: int | None = None
    """Number of remembered points."""
    movers: int | None = None
    """Number of things that move."""


@dataclass(frozen=True, eq=False)
class View:
    """What is known and foreseen, m and m/s in the plane of the scan's frame (levelled)."""

    predicted_m: np.ndarray
    """(n, 2): the path if the answer is flown on."""
    braking_m: np.ndarray
    """(n, 2): the path if no further answer comes, down to standstill."""
    remembered_m: np.ndarray
    """(n, 2): points that earlier scans have shown, and that this one has not seen free."""
    hidden: np.ndarray
    """(n,) bool: which of them this scan cannot see."""
    movers: np.ndarray
    """(n, 5): position, velocity and radius of what moves."""


def report_of(moment: Moment, judgement: Judgement | None, body_radius: float) -> Report:
    """Return the reasons of the answer."""
    nearest_m = np.sqrt((moment.standing**2).sum(axis=1).min(initial=math.inf))
    clearance_m = float(nearest_m) - body_radius
    if judgement is None:
        return Report(clearance_m)
    counts = len(judgement.sight.remembered), len(judgement.around.movers)
    return Report(clearance_m, judgement.admissible, judgement.braking_margin_m, *counts)


def view_of(
    moment: Moment,
    judgement: Judgement | None,
    command: np.ndarray,
    response: Response,
    horizon: Horizon,
    lookout: Lookout,
) -> View:
    """Return what is known and foreseen; ``command`` (3,), m/s, was the answer."""
    predicted = np.empty((horizon.cost, 3))
    roll(moment.state, command, response, horizon.cost, predicted)
    braking = np.empty((horizon.commit + horizon.brake, 3))
    braking = braking[: roll(moment.state, command, response, horizon.commit, braking)]
    scan = moment.standing, moment.seen, moment.motion
    sight = judgement.sight if judgement else lookout.look(*scan, forgets=False)
    movers = judgement.around.movers if judgement else np.empty((0, 6))
    c, s = math.cos(moment.motion.yaw_rad), math.sin(moment.motion.yaw_rad)
    into_scan = np.array([[c, -s], [s, c]])  # rows turn by -yaw
    return View(
        np.concatenate((HERE, predicted[:, :2] @ into_scan)),
        np.concatenate((HERE, braking[:, :2] @ into_scan)),
        sight.remembered @ into_scan,
        sight.is_hidden.copy(),
        np.concatenate((movers[:, :2] @ into_scan, movers[:, 2:4] @ into_scan, movers[:, 4:5]), axis=1),
    )
