"""Orders the scans for the node and the replay of bags: finds strays, and clocks that went back."""

from __future__ import annotations

from typing import Callable, Sequence

import numpy as np
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan

from gridslam_ros.frames.odometry_frames import BACK_NS, OdometryFrames

QUICK_SCANS, QUICK_RESTARTS = 10, 3
"""A clock goes back now and then. If it does so this often after fewer scans, stamps are out of order."""
OUT_OF_ORDER = (
    "The stamps of the scans are out of order: they go back by more than a second again and again, after a "
    "few scans each."
)
SILENT_NS, PAUSE_NS, PAUSE_TIMES = 10_000_000_000, 60_000_000_000, 3
"""Odometry that comes for so long without any scan is told. After the first scan the second limit counts, and
so many times the longest pause so far. Some robots scan only now and then.
"""


class Intake:
    """Accepts scans by their stamps, and starts anew only if the clock really went back.

    A scan that is more than BACK_NS older than the newest is either a stray or the first one after a reset.
    Strays come from a driver's default message or a second publisher. This scan is held back at first. If TF
    has gone back too, or a later scan is old as well, there was a reset. If the next scan is in order, the
    held one was a stray.

    Args:
        frames: the transforms; `add_transforms` passes them on.
        throttle: accept one of this many scans.
        say: is called with a sentence about scans that are left out.
        receive: is called with each accepted scan. Their stamps ascend until ``start_anew``, except
            after a scan that was far ahead of the others.
        leave_out: is called with each refused scan.
        start_anew: is called with the seconds that the clock has gone back by.
    """

    def __init__(
        self,
        frames: OdometryFrames,
        throttle: int,
        say: Callable[[str], None],
        receive: Callable,
        leave_out: Callable,
        start_anew: Callable[[float], None],
    ):
        self._frames, self._throttle = frames, throttle
        self._say, self._receive, self._leave_out, self._start_anew = say, receive, leave_out, start_anew
        self._heard = 0
        self._held = None
        self.of_one_stamp = 0
        """Number of scans left out because the one before, with other ranges, has their stamp."""
        self._since_restart = self._quick_restarts = 0
        self._longest_pause_ns = 0
        self._forget()

    def _forget(self) -> None:
        self._newest_ns = self._before_ns = -1  # a simulation begins at 0
        self._newest_ranges: Sequence[float] | np.ndarray = ()
        self._quiet_from_ns: int | None = None
        self._has_told_silence = False
        self._tf_resets = self._frames.resets

    def add_transforms(self, transforms: Sequence[TransformStamped], sender: str = "") -> int | None:
        """Take in a message of /tf, from a node. Return the stamp (ns) of an odometry's edge in it."""
        stamp_ns = self._frames.add(transforms, sender=sender)
        if self._held is not None and self._tf_is_back_at(_stamp_ns(self._held)):
            self._go_back()
        if stamp_ns is not None:
            self._watch_silence(stamp_ns)
        return stamp_ns

    @property
    def is_out_of_order(self) -> bool:
        """Whether the clock has gone back so often that the stamps cannot be in order."""
        return self._quick_restarts >= QUICK_RESTARTS

    def _note_pause(self, now_ns: int | None) -> None:
        """Note that a scan has come, when odometry was at this stamp."""
        if self._heard > 1 and self._quiet_from_ns is not None and now_ns is not None:
            self._longest_pause_ns = max(self._longest_pause_ns, now_ns - self._quiet_from_ns)
        self._quiet_from_ns, self._has_told_silence = now_ns, False

    def _watch_silence(self, stamp_ns: int) -> None:
        if self._quiet_from_ns is None or stamp_ns < self._quiet_from_ns:
            self._quiet_from_ns = stamp_ns
            return
        pause_ns = stamp_ns - self._quiet_from_ns
        limit_ns = max(PAUSE_NS, PAUSE_TIMES * self._longest_pause_ns) if self._heard else SILENT_NS
        if pause_ns > limit_ns and not self._has_told_silence:
            self._has_told_silence = True
            self._say(
                f"Odometry has come for {pause_ns * 1e-9:.0f} s without a scan; "
                "check the lidar and the scans' topic."
            )

    def add_scan(self, scan: LaserScan) -> None:
        """Take in a scan."""
        self._heard += 1
        self._note_pause(self._frames.newest_ns)
        if self._heard % self._throttle:
            self._leave_out(scan)
            return
        if self._newest_was_ahead(_stamp_ns(scan)):
            self._say("A scan's stamp was far ahead of the others' and of TF; it does not count.")
            self._newest_ns = self._before_ns
        if _stamp_ns(scan) < self._newest_ns - BACK_NS:
            self._doubt(scan)
        else:
            self.drop_held()
            self._let_in(scan)

    def drop_held(self) -> None:
        """Leave out the held scan. Call it when no more scans will come, as at the end of a bag."""
        if self._held is not None:
            stray, self._held = self._held, None
            seconds = (self._newest_ns - _stamp_ns(stray)) * 1e-9
            self._say(f"A scan is {seconds:.3f} s older than the one before it; it is left out.")
            self._leave_out(stray)

    def _doubt(self, scan: LaserScan) -> None:
        if self._held is None:
            self._held = scan
            if self._tf_is_back_at(_stamp_ns(scan)):
                self._go_back()
        elif _stamp_ns(scan) > _stamp_ns(self._held):
            self._go_back()
            self._let_in(scan)
        else:
            self._leave_out(scan)  # the same stray again

    def _tf_is_back_at(self, stamp_ns: int) -> bool:
        """Whether TF has gone back to about this stamp since the newest scan. A late TF does not count."""
        frames = self._frames
        is_back = frames.doubtful_ns is not None or frames.resets != self._tf_resets
        return is_back and self._tf_is_at(stamp_ns)

    def _tf_is_at(self, stamp_ns: int) -> bool:
        """Whether TF's newest stamp, held or not, is about this stamp."""
        tf_ns = self._frames.newest_ns if self._frames.doubtful_ns is None else self._frames.doubtful_ns
        return tf_ns is not None and abs(tf_ns - stamp_ns) <= BACK_NS

    def _newest_was_ahead(self, stamp_ns: int) -> bool:
        """Whether the newest scan was the stray, and not this one: TF has never reached its stamp."""
        tf_ns = self._frames.newest_ns
        return (
            0 <= self._before_ns < stamp_ns < self._newest_ns - BACK_NS
            and self._frames.resets == self._tf_resets
            and tf_ns is not None
            and tf_ns < self._newest_ns - BACK_NS
        )

    def _go_back(self) -> None:
        scan, self._held = self._held, None
        seconds = (self._newest_ns - _stamp_ns(scan)) * 1e-9
        if not self._tf_is_at(_stamp_ns(scan)) or self._frames.doubtful_ns is not None:
            self._frames.go_back()
        is_quick = self._since_restart < QUICK_SCANS
        self._quick_restarts = self._quick_restarts + 1 if is_quick else 0
        self._since_restart = 0
        if self.is_out_of_order:
            self._say(f"{OUT_OF_ORDER} Each time mapping begins anew; let one clock stamp all scans.")
        self._forget()
        self._start_anew(seconds)
        self._let_in(scan)

    def _let_in(self, scan: LaserScan) -> None:
        stamp_ns = _stamp_ns(scan)
        if stamp_ns > self._newest_ns:
            self._before_ns, self._newest_ns = self._newest_ns, stamp_ns
            self._newest_ranges = scan.ranges
            self._since_restart += 1
            self._tf_resets = self._frames.resets
            self._receive(scan)
            return
        if stamp_ns < self._newest_ns:  # simulators in lockstep send the same scan again
            self._say("A scan is older than the one before it; it is left out.")
        elif not np.array_equal(scan.ranges, self._newest_ranges, equal_nan=True):
            self.of_one_stamp += 1
            self._say(
                f"Scans with other ranges have one stamp, {stamp_ns * 1e-9:.3f} s; only the first counts. "
                "The driver must stamp each scan."
            )
        self._leave_out(scan)


def _stamp_ns(scan: LaserScan) -> int:
    return scan.header.stamp.to_nsec()
