"""The checks with a hand on the UAV: a board is held before the lidar, or the UAV is turned, or carried."""

from __future__ import annotations

import math
from typing import NamedTuple, Sequence

import numpy as np

from doctor.preflight.verdict import Verdict
from input_checks.velocity import VelocityCheck

LEAST_SPEED_M_S = 0.05
LEAST_ANSWERS = 5
"""To a board within CEPA's inner cushion; one alone may be noise."""
LEAST_OF_A_SIDE = 2
WRONG_SHARE = 0.2
"""Of the answers to a board on one side; CEPA's command may point anywhere between two things near by."""
LEAST_TURN_RAD = math.radians(45.0)
DIRECTIONS = 720
"""Of a turn, in which two scans are compared."""
APART_RAD = 0.1
SIDES = ("ahead", "to the left", "behind", "to the right")


class Answer(NamedTuple):
    """The nearest thing of a scan and CEPA's command, in the body's axes: x ahead, y left."""

    bearing_rad: float
    range_m: float
    command_xy_m_s: tuple[float, float]


class View(NamedTuple):
    """A scan, in the body's axes, and the heading of odometry at the same time (rad)."""

    bearings_rad: np.ndarray
    ranges_m: np.ndarray
    heading_rad: float


def board(answers: Sequence[Answer], near_m: float) -> Verdict:
    """Check that CEPA gives way to what is nearer than its inner cushion, on each side for itself.

    A lidar that is mirrored answers well to a board ahead and behind. So no side outvotes another.
    """
    near = [one for one in answers if -math.inf < one.range_m < near_m and math.isfinite(one.bearing_rad)]
    if len(near) < LEAST_ANSWERS:
        what = f"nothing came nearer than {near_m:g} m to the lidar"
        return Verdict("board", what, "Hold a board nearer to the lidar, from one side after another")
    by_side = {side: [one for one in near if side_of(one.bearing_rad) == side] for side in SIDES}
    shown = {side: found for side, found in by_side.items() if len(found) >= LEAST_OF_A_SIDE}
    for side, found in shown.items():
        wrong = [one for one in found if _towards(one) > 0.0]
        if len(wrong) >= LEAST_OF_A_SIDE and len(wrong) > WRONG_SHARE * len(found):
            what = f"CEPA commands {_towards(wrong[0]):.1f} m/s towards the board {side}"
            remedy = "Do not fly. Look at the lidar's pose in the SDF: a wrong sign, or upside down"
            return Verdict("board", what, remedy)
    for side, found in shown.items():
        if 2 * sum(map(_moves, found)) < len(found):
            what = f"CEPA did not move away from a board {found[0].range_m:.2f} m {side}"
            return Verdict("board", what, "Look at `rostopic echo /cepa/stats`, and at r_lb")
    return Verdict("board", f"CEPA gives way to a board {', '.join(shown)}")


def side_of(bearing_rad: float) -> str:
    """Return the side of the UAV on which a bearing lies."""
    return SIDES[round(bearing_rad / (math.pi / 2)) % 4]


def turn(first: View, last: View) -> Verdict:
    """Check that odometry turns as far as the scan does, and the same way."""
    told = _wrapped(last.heading_rad - first.heading_rad)
    if abs(told) < LEAST_TURN_RAD:
        what = f"odometry's heading changed by {math.degrees(told):.0f} degrees only"
        return Verdict(
            "turn", what, "Turn the UAV by hand, by a right angle and more slowly; or odometry stands still"
        )
    seen = _turn_between(first, last)
    if seen is None:
        what = "both scans show too little to compare them"
        return Verdict("turn", what, "Turn the UAV where walls are near, and not in a round or empty place")
    if abs(_wrapped(seen - told)) > APART_RAD:
        what = f"odometry turned by {math.degrees(told):.0f} degrees, the view by {math.degrees(seen):.0f}"
        remedy = "Do not fly. If the signs differ, the lidar is mirrored in the SDF; else odometry is wrong"
        return Verdict("turn", what, remedy)
    return Verdict(
        "turn", f"odometry and the lidar's view turned by the same {math.degrees(told):.0f} degrees"
    )


class Odometry(NamedTuple):
    """Odometry as `VelocityCheck` takes it: m/s, m, and a unit quaternion."""

    stamp_ns: int
    told_m_s: tuple[float, float, float]
    place_m: tuple[float, float, float]
    orientation_xyzw: tuple[float, float, float, float]
    is_of_odometry: bool
    """Whether child_frame_id is header.frame_id."""


def carry(odometry: Sequence[Odometry]) -> Verdict:
    """Check that odometry's velocity fits its places, along the axes that child_frame_id names."""
    said: list[str] = []
    check = VelocityCheck(said.append)
    for one in odometry:
        check.velocity(*one)
    if said:
        return Verdict("carry", said[0].rstrip("."), "Do not fly before it fits")
    if not check.is_confirmed:
        what = "odometry's velocity fits its places, but the way does not tell along which axes"
        remedy = "Carry the UAV at 1 m/s or faster, ahead and sideways, with its front at a right angle to "
        return Verdict("carry", what, f"{remedy}the x axis of odom, for some seconds each")
    return Verdict("carry", "odometry's velocity fits its places, along the axes of child_frame_id")


def _moves(answer: Answer) -> bool:
    return LEAST_SPEED_M_S < math.hypot(*answer.command_xy_m_s) < math.inf


def _towards(answer: Answer) -> float:
    """Return the speed towards the nearest thing, m/s; 0 for a command that is none or too slow to count."""
    if not _moves(answer):
        return 0.0
    x, y = answer.command_xy_m_s
    return x * math.cos(answer.bearing_rad) + y * math.sin(answer.bearing_rad)


def _turn_between(first: View, last: View) -> float | None:
    """Return the UAV's turn by which both scans fit best, rad; None if none fits better than the others."""
    before, now = _profile(first), _profile(last)
    misfits = np.full(DIRECTIONS, np.inf)
    for shift in range(DIRECTIONS):
        apart = np.abs(np.roll(now, shift) - before)
        known = np.isfinite(apart)
        if known.sum() > DIRECTIONS / 8:
            misfits[shift] = np.minimum(apart[known], 1.0).mean()
    best = int(np.argmin(misfits))
    if not np.isfinite(misfits[best]) or misfits[best] >= 0.5 * np.median(misfits[np.isfinite(misfits)]):
        return None
    return _wrapped(best * 2.0 * math.pi / DIRECTIONS)


def _profile(view: View) -> np.ndarray:
    """Return the nearest range in each direction, m; NaN where nothing is known."""
    finite = np.isfinite(view.ranges_m)
    cells = np.round(view.bearings_rad[finite] / (2.0 * math.pi) * DIRECTIONS).astype(int) % DIRECTIONS
    profile = np.full(DIRECTIONS, np.inf)
    np.minimum.at(profile, cells, view.ranges_m[finite])
    return np.where(np.isfinite(profile), profile, np.nan)


def _wrapped(angle_rad: float) -> float:
    return math.remainder(angle_rad, 2.0 * math.pi)
