"""For each parameter a question whose answer it changes: what live tuning is tested with."""

from __future__ import annotations

import dataclasses
import math
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from cepa import ALGORITHMS, CepaParameters, LaserScan2D, LidarAttitude, Motion, levelled

BEAMS = 1440
INCREMENT_RAD = 2.0 * math.pi / BEAMS
RANGE_MIN_M, RANGE_MAX_M = 0.06, 10.0
UNSEEN_INTENSITY = -1.0
PERIOD_S = 0.1
BEARINGS = np.degrees(-math.pi + np.arange(BEAMS) * INCREMENT_RAD)


@dataclass(frozen=True)
class Case:
    """A parameter's other value, and the question; ``given``: what else is not at its default."""

    name: str
    value: Any
    ranges: np.ndarray
    v_ref: tuple[float, float] = (1.0, 0.0)
    own: tuple[float, float] = (0.0, 0.0)
    given: dict = field(default_factory=dict)
    unseen: np.ndarray = field(default_factory=lambda: np.zeros(BEAMS, bool))
    height_m: float = 2.0
    pitch_rad: float = 0.0
    before: np.ndarray | None = None
    """The ranges of a scan without unseen beams that is answered 0.1 s before; None: there is none."""

    def answer(self, **changes) -> tuple[float, float]:
        """Return the library's answer, with the ranges as single precision, as the message has them."""
        values = {"algorithm": "improved", **self.given, **changes}
        algorithm = ALGORITHMS[values.pop("algorithm")](CepaParameters(**values))
        geometry = np.float32(-math.pi), np.float32(INCREMENT_RAD), np.float32(RANGE_MIN_M), RANGE_MAX_M
        half = 0.5 * self.pitch_rad
        pose = (0.0, 0.0, self.height_m), (0.0, math.sin(half), 0.0, math.cos(half)), (*self.own, 0.0)
        if self.before is not None:
            scan = LaserScan2D(np.float32(self.before), *geometry)
            algorithm.steer(scan, self.v_ref, self.own, Motion.of_mounted(0.0, *pose))
            algorithm.on_next_scan(PERIOD_S, 0.0)
        scan = LaserScan2D(np.float32(self.ranges), *geometry, ~self.unseen)
        if algorithm.parameters.levelling:
            attitude = LidarAttitude.of_mounted(self.height_m, pose[1])
            scan = levelled(scan, attitude, algorithm.parameters, math.hypot(*self.own))
        return algorithm.steer(scan, self.v_ref, self.own, Motion.of_mounted(PERIOD_S, *pose)).velocity_xy


def around(*obstacles: tuple[float, float, float]) -> np.ndarray:
    """Return the ranges of a full turn with obstacles (bearing and width in degrees, distance in m)."""
    ranges = np.full(BEAMS, np.inf)
    for bearing, width, distance in obstacles:
        near = np.abs((BEARINGS - bearing + 180.0) % 360.0 - 180.0) <= 0.5 * width
        ranges[near] = np.minimum(ranges[near], distance)
    return ranges


def wall(distance: float, bearing: float = 0.0, half_width: float = 80.0) -> np.ndarray:
    """Return the ranges of a full turn with a wall across a bearing (degrees)."""
    offset = (BEARINGS - bearing + 180.0) % 360.0 - 180.0
    with np.errstate(divide="ignore"):
        ranges = distance / np.cos(np.radians(offset))
    return np.where(np.abs(offset) <= half_width, ranges, np.inf)


def floor(height_m: float, pitch_rad: float, ceiling_m: float = math.inf) -> np.ndarray:
    """Return the ranges of a lidar that leans forward: the floor ahead, and a ceiling behind."""
    climb = -math.sin(pitch_rad) * np.cos(np.radians(BEARINGS))
    with np.errstate(divide="ignore"):
        ranges = np.where(climb < 0.0, -height_m / climb, (ceiling_m - height_m) / np.abs(climb))
    return np.where(ranges < RANGE_MAX_M, ranges, np.inf)


def nearest(*scans: np.ndarray) -> np.ndarray:
    """Return the nearer of several scans in each beam."""
    return np.minimum.reduce(scans)


COLUMNS = around((25.0, 10.0, 2.6), (-28.0, 10.0, 2.5), (3.0, 4.0, 4.0))
THREE_COLUMNS = nearest(
    wall(0.42, 90.0), around((-125.0, 18.0, 0.48), (-90.0, 18.0, 0.48), (-55.0, 18.0, 0.48))
)
POST_AND_WALL = nearest(around((90.0, 6.0, 0.3)), wall(0.44, -90.0))
ONE_COLUMN = around((0.0, 10.0, 2.6))
COLUMN_IN_THE_WAY_OUT = around((90.0, 60.0, 0.42), (-80.0, 18.0, 0.6))
GAP = around((90.0, 20.0, 0.45), (-125.0, 6.0, 0.5), (-55.0, 6.0, 0.5))
DROPOUTS = np.where(np.abs(BEARINGS) < 0.4, np.nan, np.inf)
BRAKES = {"velocity_aware_emergency": True}
AHEAD = np.abs(BEARINGS) < 60.0
DYNAMIC = {"algorithm": "dynamic"}
LEVELS = {"levelling": True}
LOW = {"height_m": 1.2, "pitch_rad": math.radians(30.0)}
LOW_FLOOR = floor(**LOW)
FAST = {"v_ref": (2.0, 0.0), "own": (2.0, 0.0)}

CASES = (
    Case("algorithm", "original", THREE_COLUMNS),
    Case("r_lb", 0.8, around((30.0, 20.0, 0.7))),
    Case("r_ub", 2.5, COLUMNS, **FAST),
    Case("time_horizon", 0.3, ONE_COLUMN, **FAST),
    Case("k_filter", 0.3, POST_AND_WALL, given={"algorithm": "original"}),
    Case("k1", 0.5, COLUMNS, **FAST, given={"algorithm": "original"}),
    Case("k2", 40.0, wall(2.5, half_width=85.0), **FAST),
    Case("k3", 5.0, COLUMNS, **FAST),
    Case("k4", 20.0, ONE_COLUMN, **FAST),
    Case("k5", 0.2, COLUMNS, **FAST),
    Case("k_previous", 50.0, around((-4.0, 10.0, 2.6)), **FAST, before=around((4.0, 10.0, 2.6))),
    Case("speed_fractions", (0.6,), ONE_COLUMN, **FAST),
    Case("body_radius", 0.2, GAP),
    Case("emergency_lookahead", 3.0, nearest(wall(0.45), around((180.0, 20.0, 2.5)))),
    Case("emergency_gain", 2.0, wall(0.4)),
    Case("v_min", 0.2, wall(0.49)),
    Case("v_max", 0.85, wall(0.3)),
    Case("emergency_cancellation", 0.9, around((60.0, 20.0, 0.38), (-70.0, 20.0, 0.42))),
    Case("emergency_tie_angle", 3.0, COLUMN_IN_THE_WAY_OUT, own=(0.2, 0.0)),
    Case("reference_speed_min", 0.9, around(), v_ref=(0.5, 0.0)),
    Case("dropout_beams", 0, DROPOUTS, v_ref=(2.0, 0.0)),
    Case("unseen_is_free", True, around(), v_ref=(1.0, -1.0), unseen=BEARINGS < 0.0),
    Case("velocity_aware_emergency", True, around((0.0, 20.0, 1.3)), **FAST),
    Case("braking_deceleration", 1.0, around((0.0, 20.0, 2.0)), **FAST, given=BRAKES),
    Case("braking_latency", 1.0, around((0.0, 20.0, 2.0)), **FAST, given=BRAKES),
    Case("margin", 0.8, around((0.0, 20.0, 2.2)), **FAST, given=DYNAMIC),
    Case("commit_s", 0.4, around((0.0, 60.0, 2.2)), **FAST, given=DYNAMIC),
    Case("memory_s", 0.0, around(), **FAST, given=DYNAMIC, unseen=AHEAD, before=around()),
    Case("window_m", 0.0, around((10.0, 100.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_p", 0.6, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_i", 1.0, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_d", 2.0, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_lag", 0.5, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_acceleration_max", 1.0, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_delay", 0.4, around((0.0, 60.0, 1.6)), **FAST, given=DYNAMIC),
    Case("response_jerk_max", 2.0, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("planar_speed_max", 1.0, around((0.0, 20.0, 2.0)), **FAST, given=DYNAMIC),
    Case("response_error", 3.0, around((0.0, 60.0, 2.4)), **FAST, given=DYNAMIC),
    Case("levelling", True, LOW_FLOOR, v_ref=(2.0, 0.0), **LOW),
    Case("floor_height", -1.0, LOW_FLOOR, v_ref=(2.0, 0.0), **LOW, given=LEVELS),
    Case("ceiling_height", 2.0, floor(**LOW, ceiling_m=2.0), v_ref=(-2.0, 0.0), **LOW, given=LEVELS),
    Case("floor_margin", 0.0, 0.95 * LOW_FLOOR, v_ref=(2.0, 0.0), **LOW, given=LEVELS),
)


def names() -> set[str]:
    """Return the names of all parameters but those that test_clouds.py and test_self_filter.py try."""
    elsewhere = {"climb_max", "height_min", "height_max", "body_below", "body_above", "self_filter"}
    return {"algorithm", *(field.name for field in dataclasses.fields(CepaParameters))} - elsewhere
