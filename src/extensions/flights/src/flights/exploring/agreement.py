"""Without the truth: a map that does not agree with itself, or a height that was wrong, is no success."""

from __future__ import annotations

import math

import numpy as np

from exploration.next_view.outcome import HEIGHT_KNOWN_M, height_doubt
from gridslam.evaluation.volume.doubled_surfaces import disagreement

FIRST_HEIGHT_S = 1.0
"""Odometry may begin so long before the first range, which tells the first height."""
STANDING_S = 1.0
"""The UAV stands still so long before the take-off, and at the end."""
HOME_M = 1.0


def with_agreement(content: dict, share: float, home_off_m: float = math.nan) -> dict:
    """Return the content of result.json with what its map and its height are worth.

    It gets `doubled_share` and `home_height_off_m`. A flight that failed keeps its own failure.

    content: with `exploration`. share: of the map, see `doubled_share`; NaN: it has no surface. home_off_m:
    see there; NaN: not known.
    """
    explored = content["exploration"]
    explored = {**explored, "doubled_share": _told(share), "home_height_off_m": _told(home_off_m)}
    sigma_m = explored.get("height_uncertain_m")
    wrong = disagreement(share) or _home_doubt(home_off_m) or height_doubt(sigma_m or math.nan)
    judged = {**content, "exploration": explored}
    if wrong and content["success"]:
        judged |= {"success": False, "failure": wrong}
    return judged


def home_height_off_m(odometry: np.ndarray) -> float:
    """Return by how much the height is off where the UAV took off and has landed again, m.

    It stands there as high as at the start. Ground that rises by 45 degrees between both places, as odometry
    tells these, counts for nothing.

    odometry: (n, 4) time in s and x, y, z in m, from before the take-off until after the landing. NaN is
    returned if it tells too little, or ends farther than `HOME_M` from its begin.
    """
    if len(odometry) < 2 or odometry[-1, 0] - odometry[0, 0] < FIRST_HEIGHT_S + 2.0 * STANDING_S:
        return math.nan
    times_s = odometry[:, 0] - odometry[0, 0] - FIRST_HEIGHT_S
    first = np.median(odometry[(times_s >= 0.0) & (times_s <= STANDING_S)], axis=0)
    last = np.median(odometry[times_s >= times_s[-1] - STANDING_S], axis=0)
    apart_m = float(np.hypot(*(last - first)[1:3]))
    if not apart_m <= HOME_M:
        return math.nan
    return max(abs(float(last[3] - first[3])) - apart_m, 0.0)


def _told(figure: float) -> float | None:
    return None if math.isnan(figure) else figure


def _home_doubt(off_m: float) -> str:
    """Return what is wrong with a height that is off by so much where the UAV took off; empty: nothing."""
    if not off_m > HEIGHT_KNOWN_M:
        return ""
    return (
        f"The height was wrong: where the UAV took off, it stands {off_m:.1f} m higher or lower than at the "
        f"start (at most {HEIGHT_KNOWN_M} m). So the map is wrong, too: look at map.ot."
    )
