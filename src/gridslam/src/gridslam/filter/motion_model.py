"""gmapping's odometry motion model: the uncertainty of the true motion, given odometry.

gmapping draws new noise at every scan. So a lidar with four times the rate halves the uncertainty of the same
path. Here the deviations of all steps add up, so a path is as uncertain as one step.

Odometry may tell its own covariance, which grows with the way (REP-105). Then its growth counts instead. A
covariance that tells nothing (`is_told`) counts as none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

import numpy as np

from gridslam import se2
from gridslam.parameters import SlamParameters

SIDEWAYS = 0.3
"""gmapping's share of srr with which a translation to one side makes the other uncertain."""
DEVIATION_MIN = (1e-4, 1e-4, 1e-5)
"""m, m, rad: no motion is known better than this."""
TOLD_MIN = np.array((5e-3, 5e-3, 1e-3))
"""m, m, rad: odometry's noise at both ends of a motion, which the growth of its covariance leaves out."""
UNKNOWN_VARIANCE = 1e6
"""m2, rad2: with this variance and above, odometry says that it does not know its pose."""


def is_told(covariance: np.ndarray | None) -> bool:
    """Return whether a pose's covariance says anything: it is (3, 3), finite, not negative, and not huge."""
    if covariance is None or np.shape(covariance) != (3, 3):
        return False
    is_sane = (np.diag(covariance) >= 0.0).all() and (np.abs(covariance) < UNKNOWN_VARIANCE).all()
    return bool(is_sane)  # NaN fails both


@dataclass(frozen=True, eq=False)
class MotionState:
    """A `Motion` to save. The fields are its attributes.

    Raises:
        ValueError: they are not finite numbers, or a covariance is none.
    """

    start: np.ndarray
    now: np.ndarray
    deviations: np.ndarray
    stamp_s: float
    distance_m: float
    turned_rad: float
    tried: np.ndarray
    due: bool
    told: np.ndarray
    start_covariance: np.ndarray | None
    covariance: np.ndarray | None

    def __post_init__(self) -> None:
        rows = (self.start, self.now, self.deviations, self.tried, self.told)
        numbers = (self.stamp_s, self.distance_m, self.turned_rad)
        if any(row.shape != (3,) for row in rows) or not np.isfinite([*np.concatenate(rows), *numbers]).all():
            raise ValueError("the motion is not made of finite numbers")
        if not all(each is None or is_told(each) for each in (self.start_covariance, self.covariance)):
            raise ValueError("the motion's covariances are none")


class Motion:
    """The odometry since the last processed scan, and its uncertainty.

    covariance: (3, 3) of the base in odom, m2, m rad and rad2; None: odometry tells none.
    """

    def __init__(self, base_in_odom: np.ndarray, stamp_s: float, covariance: np.ndarray | None = None):
        self.start = np.array(base_in_odom, float)
        self.now = self.start
        self.stamp_s = stamp_s
        self.covariance = self.start_covariance = covariance if is_told(covariance) else None
        self.told = np.zeros(3)
        """Standard deviations that the covariances have told since the start."""
        self.distance_m = 0.0
        self.turned_rad = 0.0
        self.deviations = np.zeros(3)
        """Standard deviations of x, y in m and yaw in rad, in the base frame: the sum over all steps."""
        self.tried = np.array((0.0, 0.0, stamp_s))
        """Travel in m, turning in rad and stamp in s at which a scan was last processed, or refused."""
        self.due = False
        """Whether the next scan is to be processed, whatever the motion."""

    def add(
        self, base_in_odom: np.ndarray, parameters: SlamParameters, covariance: np.ndarray | None = None
    ) -> None:
        """Take the next odometry pose, and its covariance if odometry tells one."""
        step = np.abs(se2.between(self.now, base_in_odom))
        self.distance_m += math.hypot(step[0], step[1])
        self.turned_rad += step[2]
        self.now, self.covariance = np.array(base_in_odom, float), covariance if is_told(covariance) else None
        if self.covariance is None or self.start_covariance is None:
            self.deviations += _deviations(step[0], step[1], step[2], parameters)
            return
        grown = growth(self.start, self.start_covariance, self.now, self.covariance)
        told = np.sqrt(np.maximum(np.diag(grown), 0.0)) + TOLD_MIN
        self.deviations += told - self.told
        self.told = told

    @property
    def step(self) -> np.ndarray:
        """(3,) the present pose in the frame of the start."""
        return se2.between(self.start, self.now)

    @property
    def deviation(self) -> np.ndarray:
        """(3,) standard deviation of the step, never quite 0."""
        return np.maximum(self.deviations, DEVIATION_MIN)

    @property
    def is_as_told(self) -> bool:
        """Whether odometry's covariances alone say how uncertain the step is."""
        return self.covariance is not None and bool((self.deviations <= self.told + 1e-9).all())

    def is_enough(self, parameters: SlamParameters, stamp_s: float, enough_m: float = math.inf) -> bool:
        """Whether a scan at this time is worth processing. ``enough_m``: a way that is enough, too."""
        travelled_m, turned_rad, tried_s = self.tried.tolist()
        return (
            self.due
            or self.distance_m - travelled_m >= min(parameters.linearUpdate, enough_m)
            or self.turned_rad - turned_rad >= parameters.angularUpdate
            or (parameters.temporalUpdate >= 0.0 and stamp_s - tried_s > parameters.temporalUpdate)
        )

    def state(self) -> MotionState:
        """Return all that is known of the motion."""
        return MotionState(*(getattr(self, field.name) for field in fields(MotionState)))

    @classmethod
    def from_state(cls, state: MotionState) -> Motion:
        """Return the motion of a state."""
        motion = cls(state.start, state.stamp_s)
        for field in fields(MotionState):
            setattr(motion, field.name, getattr(state, field.name))
        return motion

    def refuse(self, stamp_s: float) -> None:
        """Note that the scan at this time was refused: the next one comes after as much motion again."""
        self.tried, self.due = np.array((self.distance_m, self.turned_rad, stamp_s)), False


@dataclass(frozen=True, eq=False)
class Prediction:
    """The particles' poses by odometry alone, in the map frame."""

    predicted: np.ndarray
    """(particles, 3) by odometry without noise."""
    drawn: np.ndarray
    """(particles, 3) drawn from the motion model, the best one without noise."""
    information: np.ndarray
    """(particles, 3, 3) inverse covariance of the motion model around ``predicted``, in 1/m2 and 1/rad2."""

    def log_density(self, poses: np.ndarray) -> np.ndarray:
        """Return the log-density (particles,) of poses (particles, 3) by odometry; 0 at ``predicted``."""
        errors = poses - self.predicted
        errors[:, 2] = se2.wrap(errors[:, 2])
        return -0.5 * np.einsum("pi,pij,pj->p", errors, self.information, errors)


def predict(poses: np.ndarray, motion: Motion, best: int, rng: np.random.Generator) -> Prediction:
    """Move particles (particles, 3) as odometry did, with and without noise.

    best: this particle has no noise. So where scans tell no place, the best guess stays what odometry says.
    """
    step, deviation = motion.step, motion.deviation
    noise = deviation * rng.standard_normal(poses.shape)
    noise[best] = 0.0
    return Prediction(
        se2.compose(poses, step), se2.compose(poses, step + noise), _information(poses, deviation)
    )


def growth(
    start: np.ndarray, start_covariance: np.ndarray, now: np.ndarray, covariance: np.ndarray
) -> np.ndarray:
    """Return the covariance (3, 3) of a motion, in the base frame at its start.

    Both poses (3,) and their covariances (3, 3) are in odom. The error at the start is taken off, with what
    its heading does to the place (Smith, Self and Cheeseman 1990, backwards).
    """
    dx, dy = now[:2] - start[:2]
    carried = np.array(((1.0, 0.0, -dy), (0.0, 1.0, dx), (0.0, 0.0, 1.0)))
    cos, sin = math.cos(start[2]), math.sin(start[2])
    turn = np.array(((cos, sin, 0.0), (-sin, cos, 0.0), (0.0, 0.0, 1.0)))
    return turn @ (covariance - carried @ start_covariance @ carried.T) @ turn.T


def _deviations(x: float, y: float, yaw: float, parameters: SlamParameters) -> np.ndarray:
    """Return gmapping's deviations (3,) of a small step's x, y and yaw from its sizes."""
    return np.array(
        (
            parameters.srr * (x + SIDEWAYS * y) + parameters.str * yaw,
            parameters.srr * (y + SIDEWAYS * x) + parameters.str * yaw,
            parameters.stt * yaw + parameters.srt * math.hypot(x, y),
        )
    )


def _information(poses: np.ndarray, deviation: np.ndarray) -> np.ndarray:
    """Return a motion's information (particles, 3, 3) in the map frame, for particles that start at poses."""
    cos, sin = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    turn = np.zeros((len(poses), 3, 3))
    turn[:, 0, 0], turn[:, 0, 1], turn[:, 1, 0], turn[:, 1, 1] = cos, -sin, sin, cos
    turn[:, 2, 2] = 1.0
    return (turn / deviation**2) @ turn.transpose(0, 2, 1)
