"""The way from messages to velocities: one class for the node and for flights without ROS."""

from __future__ import annotations

from collections import deque
from typing import Callable, NamedTuple

from cepa.algorithm import Algorithm
from cepa.errors import MountError
from cepa.keep_out import KeepOut
from cepa.motion import Ranging, Vector3
from cepa.scan import LaserScan2D
from cepa.steering.answering import RANGE_FINDERS, STANDSTILL, Answer, Answering
from cepa.steering.clouds import CloudLimits, SensedPoints
from cepa.steering.inertial_check import LAG_NS, InertialCheck
from cepa.steering.inertial_path import InertialReading
from cepa.steering.mount import MountOf
from cepa.steering.own_motion import OwnState
from cepa.steering.scan_watch import ScanWatch
from input_checks.velocity import VelocityCheck
from stamp_pairing.pairing import Paired, StampPairing

SCANS_IN_ORDER = 100
"""If more scans of a recording wait, a message is not in it, or is not played."""


class FramedScan(NamedTuple):
    """A scan, and the frame of the lidar that took it."""

    scan: LaserScan2D
    frame: str


class Command(NamedTuple):
    """A velocity to fly."""

    stamp_ns: int
    """Of the scan that it answers, or of the odometry at which the UAV brakes. It never goes back."""
    velocity_m_s: Vector3
    """Along the axes of the levelled body."""
    answer: Answer | None = None
    """How it came about; None: the UAV is to stand, because nothing could be asked."""
    scan_stamp_ns: int = 0
    frame: str = ""
    """Of the scan that the answer belongs to."""


class SteeringLoop:
    """Answers each scan with one velocity of the scan's stamp, and brakes when scans stay away.

    Tell it each message when it comes. Every call returns the commands that are due, oldest first. A scan
    waits for the reference, the odometry and the cloud of its own stamp (see `StampPairing`). A reference or
    a velocity of the UAV that is more than 0.5 s from its scan counts as zero. When the stamps of scans go
    back, everything is forgotten. All stamps are whole nanoseconds of one clock.

    Args:
        algorithm: what decides.
        mount_of: see `MountOf`. While it raises MountError, scans are answered with standstill.
        warn: takes a sentence each time that something is wrong. Let it drop repetitions.
        limits: of the sensor that gives clouds; None: there is none. Clouds count while the algorithm uses
            them.
        uses_range_finders: whether range finders look up and down.
        uses_imu: whether there is an IMU. While it confirms the odometry, what moves alike is no drift.
        is_replay: for a recording. Every scan is answered with the messages that belong to it, however late
            they come, and nothing brakes. In flight the newest scan counts, and none waits for the next one.
        on_restart: called when the clock went back.
    """

    def __init__(
        self,
        algorithm: Algorithm,
        mount_of: MountOf,
        warn: Callable[[str], None],
        limits: CloudLimits | None = None,
        uses_range_finders: bool = False,
        is_replay: bool = False,
        on_restart: Callable[[], None] = lambda: None,
        uses_imu: bool = False,
    ) -> None:
        self._mount_of, self._warn, self._is_replay = mount_of, warn, is_replay
        self._on_restart = on_restart
        self._pairing = _pairing(limits, uses_range_finders, is_replay)
        self._check = InertialCheck(warn) if uses_imu else None
        self._velocity_check = VelocityCheck(warn)
        self._pairing.wait_for("cloud", algorithm.wants_cloud)
        self._answering = Answering(algorithm, warn, limits, self._check)
        self._scan_watch = ScanWatch(warn)
        self._waiting: deque[Paired] = deque()  # in a replay, for the lidar's mounting
        self._newest_scan_ns: int | None = None
        self._braked_ns = 0

    @property
    def algorithm(self) -> Algorithm:
        """The algorithm that decides now."""
        return self._answering.algorithm

    def take(self, algorithm: Algorithm) -> None:
        """Steer by another algorithm, or by one with other parameters; it keeps what is remembered."""
        if self._check is not None and algorithm.wants_motion and not self.algorithm.wants_motion:
            self._check.restart()  # what came meanwhile was not compared
        self._pairing.wait_for("cloud", algorithm.wants_cloud)
        self._answering.take(algorithm)

    def take_keep_out(self, keep_out: KeepOut) -> None:
        """Keep out of these boxes from now on, whatever algorithm steers."""
        self._answering.take_keep_out(keep_out)

    def take_ready(self, is_ready: bool) -> None:
        """Take in whether the UAV flies what is answered. While it does not, it is not held up."""
        self._answering.take_ready(is_ready)

    def on_reference(self, stamp_ns: int, velocity_m_s: Vector3) -> list[Command]:
        """Take in the wanted velocity, along the axes of the levelled body."""
        return self._answer(self._pairing.offer("reference", stamp_ns, velocity_m_s))

    def on_odometry(self, stamp_ns: int, state: OwnState) -> list[Command]:
        """Take in the UAV's own motion. It is also the clock by which a UAV without scans brakes."""
        state = state.checked(stamp_ns, self._velocity_check)
        if self._check is not None:
            self._check.on_odometry(stamp_ns, state)
        commands = self._answer(self._pairing.offer("odometry", stamp_ns, state))
        if not self._is_replay and self._scan_watch.must_brake(stamp_ns, self.algorithm.commit_s):
            self._braked_ns = stamp_ns
            commands.append(Command(stamp_ns, STANDSTILL))
        return commands

    def on_cloud(self, stamp_ns: int, points: SensedPoints | None) -> list[Command]:
        """Take in a cloud; None: one came that cannot be used, so no scan shall wait for it."""
        return self._answer(self._pairing.offer("cloud", stamp_ns, points))

    def on_range(self, source: str, stamp_ns: int, ranging: Ranging | None) -> list[Command]:
        """Take in a range of the body's frame; None: one came that cannot be used.

        source: of `RANGE_FINDERS`.
        """
        return self._answer(self._pairing.offer(source, stamp_ns, ranging))

    def on_imu(self, stamp_ns: int, reading: InertialReading) -> list[Command]:
        """Take in a reading of the IMU, in the body's axes."""
        if self._check is None:
            return []
        self._check.on_reading(stamp_ns, reading)
        return self._answer([]) if self._is_replay else []

    def on_scan(self, stamp_ns: int, scan: LaserScan2D, frame: str) -> list[Command]:
        """Take in a scan. frame: that of its lidar."""
        self._watch_clock(stamp_ns)
        return self._answer(self._pairing.lead(stamp_ns, FramedScan(scan, frame)))

    def _watch_clock(self, scan_ns: int) -> None:
        last_ns, self._newest_scan_ns = self._newest_scan_ns, scan_ns
        if last_ns is None or scan_ns >= last_ns:
            return
        self._warn(f"The clock jumped back by {1e-9 * (last_ns - scan_ns):.3f} s; starting anew.")
        self._on_restart()
        for part in (self._pairing, self._answering, self._scan_watch, self._velocity_check):
            part.restart()
        if self._check is not None:
            self._check.restart()
        self._braked_ns = 0

    def _answer(self, ready: list[Paired]) -> list[Command]:
        """Return the answers to all scans that are ready and whose lidar's mounting is known."""
        commands: list[Command] = []
        if not (ready or self._is_replay):
            return commands  # in flight no scan waits
        self._waiting.extend(ready)
        while self._waiting:
            if self._lacks_imu(self._waiting[0].leader.stamp_ns):
                break
            framed: FramedScan = self._waiting[0].leader.value
            try:
                mount = self._mount_of(framed.frame)
            except MountError as error:
                if self._is_replay:
                    self._warn(f"{error} The recording's scans wait for it.")
                    return commands
                self._warn(f"{error} Hovering until the lidar's mounting is known.")
                commands.append(Command(self._waiting.popleft().leader.stamp_ns, STANDSTILL))
                continue
            paired = self._waiting.popleft()
            commands.append(self._command(paired, self._answering.answer(paired, framed.scan, mount)))
        self._complain_of_held()
        return commands

    def _lacks_imu(self, scan_ns: int) -> bool:
        """Whether a scan of a recording waits for the IMU, as long as its readings come."""
        if not self._is_replay or self._check is None or len(self._waiting) > SCANS_IN_ORDER:
            return False
        return self._check.newest_ns is not None and self._check.newest_ns < scan_ns - LAG_NS

    def _command(self, paired: Paired, answer: Answer) -> Command:
        scan_ns = paired.leader.stamp_ns
        self._scan_watch.on_answer(scan_ns, moves=any(answer.velocity_m_s))
        stamp_ns = max(scan_ns, self._braked_ns)
        return Command(stamp_ns, answer.velocity_m_s, answer, scan_ns, paired.leader.value.frame)

    def _complain_of_held(self) -> None:
        if self._is_replay and self._pairing.held > SCANS_IN_ORDER:
            lacking = " and ".join(self._pairing.due)
            self._warn(f"{self._pairing.held} scans of the recording wait for their {lacking}.")


def _pairing(limits: CloudLimits | None, uses_range_finders: bool, is_replay: bool) -> StampPairing:
    """Return the pairing of scans with what such a UAV tells. A lidar's own cloud has its scans' rate."""
    ranges = RANGE_FINDERS if uses_range_finders else ()
    in_space = (("cloud",) if limits else ()) + ranges
    own_rate = ranges if limits and limits.looks_all_around else in_space
    sources = ("reference", "odometry", *in_space)
    return StampPairing(sources, ("odometry", *in_space), own_rate, patient=is_replay)
