"""What Dynamic knew and foresaw at its last answer, for logs and pictures; computed when it is asked for."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from cepa.dynamic.kernels.response import roll
from cepa.dynamic.kernels.surroundings import Horizon
from cepa.dynamic.knowledge import Knowledge, Snapshot
from cepa.motion import Motion

HERE = np.zeros((1, 3))


class Considered(NamedTuple):
    """What the candidates were judged by. There is none if the reference was clear."""

    remembered: np.ndarray
    """(k, 2) or (k, 3) m: all remembered points."""
    is_hidden: np.ndarray
    """(k,) bool: which of them were not seen just now."""
    admissible: int
    """Number of candidates that could be flown."""
    braking_margin_m: float
    """How much more than it must keep the UAV would keep from everything if it braked at once."""


class Explanation(NamedTuple):
    """All that an answer is explained by."""

    knowledge: Knowledge
    snapshot: Snapshot
    command: np.ndarray
    """(3,) m/s: the answer, along the odometry's axes."""
    considered: Considered | None
    held_s: float
    """How long the UAV has got nowhere although it was asked to fly."""
    returns: int
    """How often it has come back to where it was, lately."""


@dataclass(frozen=True)
class Report:
    """The reasons of an answer in numbers; None: it was not looked at, because the reference was clear."""

    clearance_m: float
    """From the UAV's hull to the nearest thing in the scan; inf: nothing is seen."""
    held_s: float
    """How long the UAV has stayed within 0.5 m although it was asked to fly."""
    returns: int
    """How often it has come back to where it was in the last 120 s."""
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
    """What is known and foreseen, m and m/s in the scan's frame; without clouds as if that were level."""

    predicted_m: np.ndarray
    """(n, 3): the path if the answer is flown on."""
    braking_m: np.ndarray
    """(n, 3): the path if no further answer comes, down to standstill."""
    remembered_m: np.ndarray
    """(n, 3): points that earlier scans have shown, and that this one has not seen free."""
    hidden: np.ndarray
    """(n,) bool: which of them this scan cannot see."""
    movers: np.ndarray
    """(n, 5): position, velocity and radius of what moves, in the plane."""


def report_of(explanation: Explanation, body_radius: float) -> Report:
    """Return the reasons of the answer."""
    snapshot, considered = explanation.snapshot, explanation.considered
    nearest_m = np.sqrt((snapshot.near**2).sum(axis=1).min(initial=math.inf))
    clearance_m = float(nearest_m) - body_radius
    nowhere = explanation.held_s, explanation.returns
    if considered is None:
        return Report(clearance_m, *nowhere)
    counts = len(considered.remembered), len(snapshot.observed.movers)
    return Report(clearance_m, *nowhere, considered.admissible, considered.braking_margin_m, *counts)


def view_of(explanation: Explanation, response: np.ndarray, horizon: Horizon) -> View:
    """Return what is known and foreseen. response: see `observer.response_of`."""
    knowledge, snapshot, command, considered, *_ = explanation
    state, motion = snapshot.observed.state, snapshot.observed.motion
    predicted = np.empty((horizon.cost, 3))
    roll(state, command, response, horizon.cost, predicted)
    braking = np.empty((horizon.commit + horizon.brake, 3))
    braking = braking[: roll(state, command, response, horizon.commit, braking)]
    into_scan = _turned_back(motion, is_level=snapshot.space is None)
    remembered, hidden = considered[:2] if considered else knowledge.remembered(snapshot)
    remembered = np.pad(remembered, ((0, 0), (0, 3 - remembered.shape[1])))
    flat, observed = into_scan[:2, :2], snapshot.observed
    movers = np.concatenate((observed.movers, observed.columns[:, :6]))
    return View(
        np.concatenate((HERE, predicted @ into_scan)),
        np.concatenate((HERE, braking @ into_scan)),
        remembered @ into_scan,
        hidden.copy(),
        np.concatenate((movers[:, :2] @ flat, movers[:, 2:4] @ flat, movers[:, 4:5]), axis=1),
    )


def _turned_back(motion: Motion, is_level: bool) -> np.ndarray:
    """Return the matrix (3, 3) that takes rows along the odometry's axes into the scan's frame.

    is_level: as if the scan's frame were level; only its heading counts.
    """
    if not is_level:
        return motion.rotation()
    c, s = math.cos(motion.yaw_rad), math.sin(motion.yaw_rad)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
