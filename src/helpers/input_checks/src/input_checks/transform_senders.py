"""Finds that the poses of one transform come from two sources, such as a wheel driver and a filter.

Both send the same edge of TF, each its own track. Then a pose between two messages is neither: whoever reads
TF jumps between the tracks. Few nodes notice it, because each jump may be small.

One track is smooth over a second, so a cubic in time fits it, and what is left is noise. Two tracks that come
in turns leave two groups, with a gap between them that is many times the spread within each. Noise of any
size has no such gap. A single jump, as of an odometry that begins anew, changes from one group to the other
once only.
"""

from __future__ import annotations

import math
from bisect import insort
from dataclasses import dataclass

import numpy as np

APART_M, APART_RAD = 0.1, 0.1
"""Tracks that are nearer to each other do no harm: it is two cells of a usual map."""
WINDOW, WINDOW_MIN, WINDOW_S = 100, 20, 3.0
"""So many of the newest poses count at most, so many are needed, and they are not older."""
STRIDE = 2
"""A window is judged when one pose in so many of it is new, so that a few odd poses do not count twice."""
MEMBERS_MIN, CHANGES_MIN = 4, 6
"""Each track has so many poses of a window, and they change so often from one track to the other."""
GAP_SHARE = 6.0
"""The tracks are so many times farther apart than poses are from their own track. A split through the middle
of Gaussian noise reaches 2.7 (its halves are 1.6 deviations apart, each with a spread of 0.6)."""
CONFIRMED = 3
"""So many windows in a row must say so."""
BACK_S = 1.0
"""After a pose that is so much older than the newest one, all begins anew: the clock went back."""
ROUNDS = 6
"""Of assigning poses to tracks; few change after the second."""


@dataclass(frozen=True)
class TwoTracks:
    """Two tracks of one transform.

    Attributes:
        stamp_s: of the newest pose when they were found. apart_m, apart_rad: mean distance, and turn, between
        them. senders: the names of both nodes; empty: one node sends both, or the names are not known.
    """

    stamp_s: float
    apart_m: float
    apart_rad: float
    senders: tuple[str, ...] = ()

    def sentence(self, parent: str, child: str) -> str:
        """Return what is wrong, and what to do."""
        by = f" ({' and '.join(self.senders)})" if self.senders else ""
        return (
            f'Two sources send TF "{parent}" -> "{child}" in turns{by}, {self.apart_m:.2f} m and '
            f"{math.degrees(self.apart_rad):.0f} degrees apart: a pose between them is neither. Stop one of "
            "them, or let it send another frame."
        )


class TransformSenders:
    """Judges the stream of one transform's poses.

    Attributes:
        found: the tracks, as long as the newest poses are of two; None: they are of one.
    """

    def __init__(self) -> None:
        self._begin()

    def _begin(self) -> None:
        self.found: TwoTracks | None = None
        self._poses: list[tuple[float, tuple[float, ...], str]] = []
        """By stamp: (stamp, (x, y, z, cos yaw, sin yaw), sender)."""
        self._new = self._in_a_row = 0

    def add(
        self, stamp_s: float, place_m: tuple[float, float, float], yaw_rad: float, sender: str = ""
    ) -> None:
        """Take in a pose. A pose that comes again with its stamp, as from a relay, tells nothing.

        sender: name of the node; empty: it is not known.
        """
        if self._poses and stamp_s < self._poses[-1][0] - BACK_S:
            self._begin()
        pose = (*place_m, math.cos(yaw_rad), math.sin(yaw_rad))
        if any(stamp == stamp_s and other == pose for stamp, other, _ in self._poses[-4:]):
            return
        insort(self._poses, (stamp_s, pose, sender))
        oldest_s = self._poses[-1][0] - WINDOW_S
        while len(self._poses) > WINDOW or self._poses[0][0] < oldest_s:
            del self._poses[0]
        self._new += 1
        if len(self._poses) >= WINDOW_MIN and self._new * STRIDE >= len(self._poses):
            self._new = 0
            self._judge()

    def _judge(self) -> None:
        stamps_s = np.array([stamp for stamp, _, _ in self._poses])
        units = np.array([APART_M, APART_M, APART_M, APART_RAD, APART_RAD])
        poses = np.array([pose for _, pose, _ in self._poses]) / units
        senders = [sender for _, _, sender in self._poses]
        names = sorted(set(senders))
        if len(names) == 2:
            is_second = np.array([sender == names[1] for sender in senders])
            apart = _apart(stamps_s, poses, is_second, gap_share=1.0)
        else:
            is_second, names = _split(stamps_s, poses), []
            apart = _apart(stamps_s, poses, is_second, GAP_SHARE)
        self._in_a_row = 0 if apart is None else self._in_a_row + 1
        if apart is None:
            self.found = None
        elif self._in_a_row >= CONFIRMED:
            apart_m = APART_M * float(np.linalg.norm(apart[:3]))
            apart_rad = APART_RAD * float(np.linalg.norm(apart[3:]))
            self.found = TwoTracks(float(stamps_s[-1]), apart_m, apart_rad, tuple(names))


def _columns(stamps_s: np.ndarray, is_second: np.ndarray | None) -> np.ndarray:
    """Return the design matrix: a cubic in time, and a second track's offset that changes evenly."""
    middle_s, half_s = 0.5 * (stamps_s[0] + stamps_s[-1]), 0.5 * max(stamps_s[-1] - stamps_s[0], 1e-9)
    times = (stamps_s - middle_s) / half_s
    columns = [np.ones_like(times), times, times**2, times**3]
    if is_second is not None:
        columns += [is_second * 1.0, is_second * times]
    return np.stack(columns, axis=1)


def _split(stamps_s: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Return which poses (n, 5) belong to the second of two tracks, if there are two.

    The first guess parts what one cubic leaves, along its main direction, at the greatest gap.
    """
    columns = _columns(stamps_s, None)
    left = poses - columns @ np.linalg.lstsq(columns, poses, rcond=None)[0]
    along = left @ np.linalg.svd(left, full_matrices=False)[2][0]
    order = np.sort(along)
    gaps = np.diff(order)[MEMBERS_MIN - 1 : len(order) - MEMBERS_MIN]
    is_second = along > order[MEMBERS_MIN - 1 + int(np.argmax(gaps))]
    for _ in range(ROUNDS):
        offsets = [np.zeros(len(poses), bool), np.ones(len(poses), bool)]
        fitted = np.linalg.lstsq(_columns(stamps_s, is_second), poses, rcond=None)[0]
        errors = [np.linalg.norm(poses - _columns(stamps_s, each) @ fitted, axis=1) for each in offsets]
        before, is_second = is_second, errors[1] < errors[0]
        if (before == is_second).all():
            break
    return is_second


def _apart(
    stamps_s: np.ndarray, poses: np.ndarray, is_second: np.ndarray, gap_share: float
) -> np.ndarray | None:
    """Return how far (5,) two tracks of poses (n, 5) are apart, in units; None: they are one track.

    gap_share: they must be so many times farther apart than poses are from their own track.
    """
    members = int(is_second.sum())
    changes = int(np.count_nonzero(np.diff(is_second)))
    if min(members, len(poses) - members) < MEMBERS_MIN or changes < CHANGES_MIN:
        return None
    columns = _columns(stamps_s, is_second)
    fitted = np.linalg.lstsq(columns, poses, rcond=None)[0]
    left = poses - columns @ fitted
    spread = math.sqrt(float((left**2).sum()) / (len(poses) - columns.shape[1]))
    offsets = fitted[4] + columns[:, 1:2] * fitted[5]
    apart = np.sqrt((offsets**2).mean(axis=0))
    gap = float(np.linalg.norm(apart))
    return apart if gap >= 1.0 and gap >= gap_share * spread else None
