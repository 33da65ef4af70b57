"""Orders the scans for the node and the replay of bags: finds strays, and clocks that went back."""

from __future__ import annotations

from typing import Callable, Sequence

from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan

from gridslam_ros.odometry_frames import BACK_NS, OdometryFrames


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
        self._forget()

    def _forget(self) -> None:
        self._newest_ns = self._before_ns = -1  # a simulation begins at 0
        self._tf_resets = self._frames.resets

    def add_transforms(self, transforms: Sequence[TransformStamped]) -> int | None:
        """Take in a message of /tf. Return the stamp (ns) of an odometry's edge in it."""
        stamp_ns = self._frames.add(transforms)
        if self._held is not None and self._tf_is_back_at(_stamp_ns(self._held)):
            self._go_back()
        return stamp_ns

    def add_scan(self, scan: LaserScan) -> None:
        """Take in a scan."""
        self._heard += 1
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
        self._forget()
        self._start_anew(seconds)
        self._let_in(scan)

    def _let_in(self, scan: LaserScan) -> None:
        stamp_ns = _stamp_ns(scan)
        if stamp_ns > self._newest_ns:
            self._before_ns, self._newest_ns = self._newest_ns, stamp_ns
            self._tf_resets = self._frames.resets
            self._receive(scan)
            return
        if stamp_ns < self._newest_ns:  # simulators in lockstep send the same scan again
            self._say("A scan is older than the one before it; it is left out.")
        self._leave_out(scan)


def _stamp_ns(scan: LaserScan) -> int:
    return scan.header.stamp.to_nsec()
