"""Looks up base and lidar in the odometry's frame by TF. It never waits and needs no node."""

from __future__ import annotations

import math
import operator
from collections import deque
from typing import Callable, Sequence

import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped
from sensor_msgs.msg import LaserScan

from gridslam import SlamError
from gridslam_ros.frames.tf_tree import TfTree
from input_checks.transform_senders import TransformSenders
from node_tools.conversions import xyz, xyzw, yaw_of, yaw_of_xyzw

Pose = tuple[tuple[float, float, float], tuple[float, float, float, float]]
"""Translation (x, y, z) in m and unit quaternion (x, y, z, w)."""

CACHE_S = 120.0
BACK_NS = 1_000_000_000
"""If a stamp is older than the last by this much, the clock went back: a reset, or a bag played again."""
SWEEP_MAX_S = 2.0
"""A scan that claims to last longer counts as one of an instant."""
HELD_MAX = 100
"""Greatest number of held messages."""
UNIT_TOLERANCE = 4e-3
"""Error of a quaternion's norm; tf2 refuses a greater one."""
SAME_M, SAME_RAD = 1e-3, 1e-3
"""Two static transforms that differ by less are one that was rounded."""
AUTHORITY = "gridslam"


class FrameError(SlamError):
    """TF does not know a transform."""


class EarlyScanError(FrameError):
    """Odometry begins after the scan, as it may when nodes start one after the other."""


class OdometryFrames:
    """The received transforms between the odometry's, the base's and the lidar's frame.

    If an edge of odometry is more than BACK_NS older than the last, its message is held back. If a later one
    is old as well, the clock has gone back. If the next one is in order, the held one was a stray.

    Args:
        odom_frame: the odometry's frame.
        base_frame: the vehicle's.
        say: is called with a sentence about each transform that is left out.
    """

    def __init__(self, odom_frame: str, base_frame: str, say: Callable[[str], None]):
        self.odom_frame, self.base_frame = odom_frame.lstrip("/"), base_frame.lstrip("/")
        self._say = say
        self._buffer = tf2_py.BufferCore(rospy.Duration(CACHE_S))
        self._tree = TfTree(self.odom_frame)
        self._static: dict[str, dict[str, TransformStamped]] = {}
        """By child and parent."""
        self._is_reversed = False
        """Whether TF tells the odometry's frame below the base, and not the base below odometry."""
        self._senders: dict[str, TransformSenders] = {}
        """Of the edges from the odometry's frame to the base, by child."""
        self.resets = 0
        """Number of times that moving transforms were forgotten."""
        self._forget()

    def _forget(self) -> None:
        self._last_ns: dict[str, int] = {}
        self._held: deque = deque(maxlen=HELD_MAX)
        self._first_ns: int | None = None
        self.newest_ns: int | None = None
        """The newest stamp of odometry."""
        self.doubtful_ns: int | None = None
        """The stamp of the held odometry."""

    def add(
        self, transforms: Sequence[TransformStamped], static: bool = False, sender: str = ""
    ) -> int | None:
        """Take in a message of /tf or /tf_static. Return the stamp (ns) of an odometry's edge in it.

        sender: name of the node that has sent it; empty: it is not known.
        """
        above = (_names(edge)[0] for edge in transforms if _names(edge)[1] == self.odom_frame)
        self._is_reversed = self._is_reversed or self.base_frame in above
        # map -> odom is never odometry
        edges = [edge for edge in transforms if _names(edge)[1] != self.odom_frame and self._is_sound(edge)]
        if static:
            for edge in edges:
                parent, child = _names(edge)
                self._compare(edge, self._static.setdefault(child, {}).get(parent))
                self._static[child][parent] = edge
        edges = [edge for edge in edges if self._counts(edge)]
        if static:
            for edge in edges:
                self._buffer.set_transform_static(edge, AUTHORITY)
            return None
        odometry = [edge for edge in edges if _names(edge)[0] == self.odom_frame]
        for edge in odometry:
            self._watch_senders(edge, sender)
        if not any(self._is_far_back(edge) for edge in odometry or edges):
            return self._take_in(edges, odometry)
        self._held.append(edges)
        if odometry:
            before_ns, self.doubtful_ns = self.doubtful_ns, _stamp_ns(odometry[-1])
            if before_ns is not None and self.doubtful_ns > before_ns:
                stamp_ns = self.doubtful_ns
                self.go_back()
                return stamp_ns
        return None

    def _watch_senders(self, edge: TransformStamped, sender: str) -> None:
        """Say it if the poses of an edge that carries the base come from two sources."""
        parent, child = _names(edge)
        if child != self.base_frame and self._tree.parent_of(self.base_frame) != child:
            return
        senders = self._senders.setdefault(child, TransformSenders())
        pose = edge.transform
        senders.add(edge.header.stamp.to_sec(), xyz(pose.translation), yaw_of(pose.rotation), sender)
        if senders.found is not None:
            self._say(senders.found.sentence(parent, child))

    @property
    def in_doubt(self) -> str:
        """Why odometry is not to be trusted now, in a sentence; empty: it is."""
        edges = ((self.odom_frame, child, senders.found) for child, senders in self._senders.items())
        return next((found.sentence(*edge) for *edge, found in edges if found is not None), "")

    def _compare(self, edge: TransformStamped, before: TransformStamped | None) -> None:
        """Say it if a static transform has other values than before."""
        if before is None:
            return
        apart_m = math.dist(xyz(edge.transform.translation), xyz(before.transform.translation))
        one, other = xyzw(edge.transform.rotation), xyzw(before.transform.rotation)
        apart_rad = 2.0 * math.acos(min(1.0, abs(sum(map(operator.mul, one, other)))))
        if apart_m > SAME_M or apart_rad > SAME_RAD:
            self._say(
                f"{_arrow(edge)} is told as static with two values, {apart_m:.3f} m and "
                f"{math.degrees(apart_rad):.1f} degrees apart; the newer one counts from now on."
            )

    def _counts(self, edge: TransformStamped) -> bool:
        """Whether an edge is of the parent that counts for its child."""
        parent, child = _names(edge)
        if self._tree.parent_of(child) != parent:
            changed = self._tree.add(parent, child)
            if changed:
                self._change_parents(changed)
        counts = self._tree.parent_of(child)
        if counts != parent:
            self._say(
                f'"{child}" has two parents in TF, "{counts}" and "{parent}", but may have one; '
                f'the transform from "{parent}" is left out.'
            )
        return counts == parent

    def _change_parents(self, children: list[str]) -> None:
        """Forget what the frames' other parents told. tf2 cannot forget a static edge, so it begins anew."""
        self._buffer = tf2_py.BufferCore(rospy.Duration(CACHE_S))
        for child, by_parent in self._static.items():
            edge = by_parent.get(self._tree.parent_of(child) or "")
            if edge is not None:
                self._buffer.set_transform_static(edge, AUTHORITY)
        for child in children:
            self._last_ns.pop(child, None)

    def what_lacks(self, lidar_frame: str) -> str:
        """Return what lacks in TF between odometry, base and lidar, without a full stop; empty: nothing."""
        lacks = self._tree.what_lacks(self.base_frame, lidar_frame.lstrip("/"))
        if lacks and self._is_reversed:
            return (
                f'odometry lacks: TF has "{self.odom_frame}" below "{self.base_frame}", but needs '
                f'"{self.base_frame}" below "{self.odom_frame}"; send the inverse transform'
            )
        return lacks

    @property
    def has_odometry(self) -> bool:
        """Whether a transform from the odometry's frame has come since the clock went back last."""
        return self.newest_ns is not None

    def go_back(self) -> None:
        """Forget all moving transforms but the held ones, as after a clock that jumped back."""
        held = self._held
        self._buffer.clear()  # static ones stay known
        self.resets += 1
        self._forget()
        for edges in held:
            self._take_in(edges, [edge for edge in edges if _names(edge)[0] == self.odom_frame])

    def _take_in(self, edges: list, odometry: list) -> int | None:
        for edge in edges:
            self._insert(edge)
        if not odometry:
            return None
        if self._held:
            self._say(f"{_arrow(self._held[0][0])} was of another time; it is left out.")
            self._held.clear()
            self.doubtful_ns = None
        stamp_ns = _stamp_ns(odometry[-1])
        self._first_ns = stamp_ns if self._first_ns is None else self._first_ns
        self.newest_ns = stamp_ns if self.newest_ns is None else max(self.newest_ns, stamp_ns)
        return stamp_ns

    def _insert(self, edge: TransformStamped) -> None:
        child, stamp_ns = _names(edge)[1], _stamp_ns(edge)
        if stamp_ns > self._last_ns.get(child, -1):
            self._last_ns[child] = stamp_ns
            self._buffer.set_transform(edge, AUTHORITY)
        else:
            self._say(f"{_arrow(edge)} came again, or late: its stamp is not newer; it is left out.")

    def _is_far_back(self, edge: TransformStamped) -> bool:
        return _stamp_ns(edge) < self._last_ns.get(_names(edge)[1], -1) - BACK_NS

    def _is_sound(self, edge: TransformStamped) -> bool:
        parent, child = _names(edge)
        norm = math.hypot(*xyzw(edge.transform.rotation))
        is_sound = parent and child and parent != child and abs(norm - 1.0) < UNIT_TOLERANCE
        if is_sound and math.isfinite(sum(xyz(edge.transform.translation))):
            return True
        self._say(
            f"{_arrow(edge)} is not a transform: it must have finite numbers, a unit quaternion and two "
            "frames; it is left out."
        )
        return False

    def know(self, scan: LaserScan) -> bool:
        """Whether TF has reached the scan's last beam. Then a later look-up gives the same result."""
        lidar_frame, end = scan.header.frame_id.lstrip("/"), scan.header.stamp + sweep(scan)
        return all(self._has_reached(end, source) for source in (lidar_frame, self.base_frame))

    def _has_reached(self, stamp: rospy.Time, source: str) -> bool:
        try:
            newest = self._buffer.get_latest_common_time(self.odom_frame, source)
        except tf2_py.TransformException:
            return False
        if newest.is_zero():  # only static transforms, which hold at any time, or a simulation that begins
            return self._buffer.can_transform_core(self.odom_frame, source, stamp)[0]
        return newest >= stamp

    def look_up(self, scan: LaserScan) -> tuple[Pose, Pose]:
        """Return (base in odom, lidar in base) at the scan's stamp, each as (xyz, quaternion xyzw).

        Raises:
            FrameError: TF does not know them at that time.
            EarlyScanError: it knows odometry since later only.
        """
        stamp, lidar_frame = scan.header.stamp, scan.header.frame_id.lstrip("/")
        base_in_odom = self._pose(self.odom_frame, self.base_frame, stamp)
        return base_in_odom, self._pose(self.base_frame, lidar_frame, stamp)

    def last_base(self, scan: LaserScan) -> Pose | None:
        """Return the base in odom at the scan's last beam; None: it is not known, or all are of one stamp."""
        lasts = sweep(scan)
        if lasts.is_zero():
            return None
        try:
            return self._pose(self.odom_frame, self.base_frame, scan.header.stamp + lasts)
        except FrameError:  # at the end of a bag
            return None

    def newest_base(self) -> tuple[float, tuple[float, float, float]] | None:
        """Return the newest stamp (s) at which TF knows the base in odom, and x, y, yaw there; or None."""
        try:
            stamp = self._buffer.get_latest_common_time(self.odom_frame, self.base_frame)
            (x, y, _), rotation = self._pose(self.odom_frame, self.base_frame, stamp)
        except (tf2_py.TransformException, FrameError):
            return None
        return stamp.to_sec(), (x, y, yaw_of_xyzw(rotation))

    def _pose(self, target: str, source: str, stamp: rospy.Time) -> Pose:
        try:
            found = self._buffer.lookup_transform_core(target, source, stamp).transform
        except tf2_py.TransformException:
            is_early = self._first_ns is not None and stamp.to_nsec() < self._first_ns
            raise (EarlyScanError if is_early else FrameError)(
                f'TF knows no transform from "{source}" to "{target}" at {stamp.to_sec():.3f} s.'
            ) from None
        return xyz(found.translation), xyzw(found.rotation)


def sweep(scan: LaserScan) -> rospy.Duration:
    """Return how long a scan lasts from its first beam to its last, by its `time_increment`.

    It is 0 for what has none, or one that makes no sense.
    """
    lasts_s = getattr(scan, "time_increment", 0.0) * (len(getattr(scan, "ranges", ())) - 1)
    return rospy.Duration(lasts_s) if 0.0 < lasts_s <= SWEEP_MAX_S else rospy.Duration()


def _names(edge: TransformStamped) -> tuple[str, str]:
    return edge.header.frame_id.lstrip("/"), edge.child_frame_id.lstrip("/")


def _stamp_ns(edge: TransformStamped) -> int:
    return edge.header.stamp.to_nsec()


def _arrow(edge: TransformStamped) -> str:
    return 'TF "{}" -> "{}"'.format(*_names(edge))
