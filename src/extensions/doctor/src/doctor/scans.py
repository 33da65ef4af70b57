"""Checks laser scans: geometry that fits the beams, and ranges by REP-117."""

from __future__ import annotations

from collections import defaultdict
from typing import Iterator

import numpy as np

from doctor.diagnosis import ERROR, NOTE, WARNING, Diagnosis
from doctor.snapshot import Recording, Scan
from input_checks.far_value import EXACT, FarValue

REP_117 = "REP-117: -inf is too near, +inf is nothing there, NaN is not a measurement"
MOST_STEPS_BEHIND = 1.99
"""Steps of a scan from its last beam to angle_max, at most; see the nodes' conversions."""
MOSTLY = 0.5
"""A share of the beams that is not by chance."""


def check(recording: Recording) -> list[Diagnosis]:
    """Return all diagnoses about scans, each once per topic."""
    by_topic = defaultdict(list)
    for scan in recording.scans:
        by_topic[scan.topic].append(scan)
    found: list[Diagnosis] = []
    for scans in by_topic.values():
        broken = {diagnosis.what: diagnosis for scan in scans for diagnosis in geometry(scan)}
        found += broken.values() or [*values(scans), *blind(scans)]
    return found


def geometry(scan: Scan) -> Iterator[Diagnosis]:
    """Check angles, limits and the number of beams."""
    remedy = "Correct the driver's (or the SDF sensor's) settings"
    finite = np.isfinite([scan.angle_min, scan.angle_max, scan.angle_increment, scan.range_min])
    if not finite.all() or np.isnan(scan.range_max):  # the greatest range may be +inf
        yield Diagnosis(ERROR, scan.topic, "its angles or range limits are no numbers", remedy)
        return
    if scan.angle_increment == 0.0 or len(scan.ranges) == 0:
        yield Diagnosis(
            ERROR, scan.topic, f"has {len(scan.ranges)} beams {scan.angle_increment:g} rad apart", remedy
        )
        return
    steps = (scan.angle_max - scan.angle_min) / scan.angle_increment
    behind = steps - (len(scan.ranges) - 1)
    if not -0.5 <= behind <= 0.5:
        what = f"has {len(scan.ranges)} ranges, and its angles make {round(steps) + 1} beams"
        # Drivers often declare up to two more beams: one repeats the first of a full turn, or is cut off.
        is_usual = -1.5 <= behind < MOST_STEPS_BEHIND
        yield Diagnosis(WARNING if is_usual else ERROR, scan.topic, what, remedy)
    if not 0.0 <= scan.range_min < scan.range_max:
        what = f"its range_min of {scan.range_min:g} m and range_max of {scan.range_max:g} m leave nothing"
        yield Diagnosis(ERROR, scan.topic, what, remedy)


def values(scans: list[Scan]) -> Iterator[Diagnosis]:
    """Check for finite ranges outside the lidar's own limits."""
    topic, ranges = scans[0].topic, np.concatenate([scan.ranges for scan in scans])
    near = np.concatenate(
        [np.isfinite(scan.ranges) & (scan.ranges < scan.range_min - 1e-4) for scan in scans]
    )
    far = np.concatenate([np.isfinite(scan.ranges) & (scan.ranges > scan.range_max + 1e-4) for scan in scans])
    if near.any():
        zeros = np.count_nonzero(ranges[near] == 0.0)
        part = f"{zeros} of {np.count_nonzero(near)} are 0"
        what = f"{100.0 * near.mean():.1f} % of its ranges are finite and below range_min ({part})"
        yield Diagnosis(WARNING, topic, what, f"{REP_117}; correct the driver, or filter them")
    if far.any():
        what = f"{100.0 * far.mean():.1f} % of its ranges are finite and above range_max"
        yield Diagnosis(WARNING, topic, what, f"{REP_117}; correct the driver, or its range_max")
    lidar = FarValue()
    for scan in scans:
        lidar.learn(0.0, scan.ranges, (scan.range_min, scan.range_max))
    if (far_m := lidar.value_m) is not None:
        part = np.mean(np.abs(ranges - far_m) <= EXACT * far_m)
        limit = f"its range_max is {scans[0].range_max:g} m"
        what = f"{100.0 * part:.0f} % of its ranges are exactly {far_m:g} m, and none is more ({limit})"
        yield Diagnosis(NOTE, topic, what, f"Our nodes take that for nothing there. {REP_117}")


def blind(scans: list[Scan]) -> Iterator[Diagnosis]:
    """Check whether the lidar sees anything. Padded beams may be NaN."""
    ranges = [scan.ranges for scan in scans]
    empty = sum(bool(np.isnan(values).all()) for values in ranges)
    if empty:
        what = (
            f"{empty} of {len(scans)} scans are NaN in every beam: the lidar sees nothing, CEPA stands still"
        )
        yield Diagnosis(ERROR, scans[0].topic, what, "Look at the lidar's cover, cable and driver")
    with np.errstate(invalid="ignore"):
        stuck = sum(bool(np.isneginf(values).mean() > MOSTLY) for values in ranges)
    if stuck:
        what = f"{stuck} of {len(scans)} scans are -inf in most beams: something covers the lidar"
        yield Diagnosis(ERROR, scans[0].topic, what, "Look at what sits before it")
