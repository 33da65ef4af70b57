"""Judges a landing: whether the UAV stands upright, at rest, softly, and near where it was told to land.

Everything is measured with the true pose. A flight controller disarms after a crash, too, so that it is
disarmed says nothing.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

TILT_MOST_RAD = math.radians(15.0)
"""A UAV that stands on all its legs is as tilted as the ground, which is steeper than that nowhere it should
land. One that lies on a rotor is tilted by 30 degrees and more.
"""
SINK_MOST_M_S = 1.5
"""Twice PX4's MPC_LAND_SPEED (0.7 m/s), three times ArduPilot's LAND_SPEED (0.5 m/s): room for gusts and for
an estimated height that drifts. The legs of a UAV of this size are built for a fall of some 0.1 m.
"""
SIDEWAYS_MOST_M_S = 0.8
"""Half the speed at which the Iris tips over when the ground stops its legs: 1.6 m/s, by the angular momentum
about the legs. Gusts of a wind of 10 m/s gave 0.47 m/s, flights without GNSS in 6 m/s 0.41 m/s.
"""
OFF_MOST_M = 1.5
"""From the place at the order to land. Landings that began at rest ended 0.2 m off in calm air, and up to
0.7 m off in wind without GNSS.
"""
BRAKING_S = 1.0
"""A UAV that is told to land while it flies has so many seconds of this speed more, to brake."""
REST_MOST_M_S = 0.1
REST_S = 0.5
"""Before the end, during which it moves no faster than this on average."""
BEFORE_TOUCH_S = 0.1
"""Before the first touch: the ground changes the speed within one step."""
STEP_S = 0.05
"""Speeds are means over this time."""
SAME_HEIGHT_M = 0.05
"""Without a contact that was told, the UAV touches down when it is as near as this to its last height."""


@dataclass(frozen=True)
class Landing:
    """How a UAV landed, by its true pose. NaN: it is not known.

    landing_error_m: horizontal, from the place at the order to land. off_most_m: the greatest that is fine.
    sink_m_s, sideways_m_s: greatest speeds from the touch-down on. tilt_rad, speed_m_s: at the end.
    """

    landing_error_m: float
    off_most_m: float
    sink_m_s: float
    sideways_m_s: float
    tilt_rad: float
    speed_m_s: float

    @property
    def faults(self) -> tuple[str, ...]:
        """What was wrong with it, in words with figures; empty: nothing."""
        if math.isnan(self.landing_error_m):
            return ("nobody told the UAV's true pose",)
        tilt_deg, tilt_most_deg = math.degrees(self.tilt_rad), math.degrees(TILT_MOST_RAD)
        rows = (
            (self.sideways_m_s, SIDEWAYS_MOST_M_S, "it touched the ground at {:.1f} m/s sideways"),
            (self.sink_m_s, SINK_MOST_M_S, "it touched the ground at {:.1f} m/s downwards"),
            (tilt_deg, tilt_most_deg, "it is tilted by {:.0f} degrees"),
            (self.speed_m_s, REST_MOST_M_S, "it still moved at {:.1f} m/s when the motors stopped"),
            (self.landing_error_m, self.off_most_m, "it is {:.1f} m from where it was told to land"),
        )
        return tuple(
            f"{words.format(value)} (at most {most:.3g})" for value, most, words in rows if not value <= most
        )

    @property
    def is_good(self) -> bool:
        """Whether the UAV stands upright, at rest, softly, and near where it was told to land."""
        return not self.faults

    @property
    def failure(self) -> str | None:
        """The sentence about a bad landing; None: it was good."""
        return f"The landing failed: {', '.join(self.faults)}." if self.faults else None

    def figures(self) -> dict[str, float]:
        """Return its figures, for result.json."""
        return {
            "sink_m_s": self.sink_m_s,
            "sideways_m_s": self.sideways_m_s,
            "tilt_deg": math.degrees(self.tilt_rad),
            "speed_m_s": self.speed_m_s,
        }


UNKNOWN = Landing(math.nan, OFF_MOST_M, math.nan, math.nan, math.nan, math.nan)
"""Of a UAV whose true poses nobody told."""


def landing_of(truth: np.ndarray, ordered_s: float, ended_s: float, touched_s: float = math.inf) -> Landing:
    """Return how a UAV landed.

    Args:
        truth: (n, 8) of time, position and quaternion xyzw in `world`, in the order of time.
        ordered_s: when it was told to land where it was.
        ended_s: when its motors stopped.
        touched_s: when it first touched the ground after the order; infinity: nobody told it.
    """
    rows = truth[(truth[:, 0] <= ended_s + 1e-6) & np.isfinite(truth).all(axis=1)]
    order = int(np.searchsorted(rows[:, 0], ordered_s + 1e-6)) - 1
    if order < 0 or len(rows) < order + 2:
        return UNKNOWN
    speeds = _speeds(rows)
    braking_m = BRAKING_S * float(np.hypot(*speeds[order, :2]))
    landing, speeds = rows[order:], speeds[order:]
    near = np.abs(landing[:, 3] - landing[-1, 3]) <= SAME_HEIGHT_M
    touched_s = min(touched_s, float(landing[np.argmax(near), 0]))
    down = speeds[landing[:, 0] >= touched_s - BEFORE_TOUCH_S - 1e-6]
    rest = rows[rows[:, 0] >= rows[-1, 0] - REST_S - 1e-6]
    x, y, z, w = landing[-1, 4:8].tolist()
    return Landing(
        landing_error_m=math.dist(landing[0, 1:3], landing[-1, 1:3]),
        off_most_m=OFF_MOST_M + braking_m,
        sink_m_s=max(float(-down[:, 2].min()), 0.0),
        sideways_m_s=float(np.hypot(*down[:, :2].T).max()),
        tilt_rad=math.acos(
            min(max(1.0 - 2.0 * (x * x + y * y) / (x * x + y * y + z * z + w * w), -1.0), 1.0)
        ),
        speed_m_s=math.dist(rest[0, 1:4], rest[-1, 1:4]) / max(float(rest[-1, 0] - rest[0, 0]), STEP_S),
    )


def _speeds(rows: np.ndarray) -> np.ndarray:
    """Return velocities (n, 3), m/s, at rows (n, 4 or more) of time and position: means over `STEP_S`."""
    times_s = rows[:, 0]
    before = np.maximum(
        np.minimum(np.searchsorted(times_s, times_s - STEP_S - 1e-6), np.arange(len(rows)) - 1), 0
    )
    lasted_s = np.maximum(times_s - times_s[before], 1e-6)
    return (rows[:, 1:4] - rows[before, 1:4]) / lasted_s[:, None]
