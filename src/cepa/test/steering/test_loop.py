"""The loop's decisions, with an algorithm that says what it was asked."""

from __future__ import annotations

import math

import numpy as np
import pytest

from cepa import CepaParameters, LaserScan2D, MountError, SteeringLoop
from cepa.decision import Decision, Reason
from cepa.motion import Ranging
from cepa.steering.clouds import CloudLimits, SensedPoints
from cepa.steering.mount import Mount
from cepa.steering.own_motion import OwnMotion, OwnState
from stamp_pairing.pairing import Paired, Stamped

SCAN = LaserScan2D(np.full(360, 5.0), -math.pi, math.radians(1.0), 0.1, 10.0)
LEVEL = Mount.of_pose((0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))
UPSIDE_DOWN = Mount.of_pose((0.0, 0.0, -0.1), (1.0, 0.0, 0.0, 0.0))
AHEAD, STANDS = (1.0, 0.0, 0.2), (0.0, 0.0, 0.0)
MS = 1_000_000


class Follows:
    """Answers the reference as it is, and keeps what it was asked."""

    wants_motion = wants_cloud = True
    commit_s = 0.1
    parameters = CepaParameters()

    def __init__(self):
        self.asked, self.resets, self.told = [], 0, []

    def take_ranges(self, rangings):
        pass

    def on_next_scan(self, gap_s, turn_rad):
        self.told.append((gap_s, turn_rad))

    def reset(self):
        self.resets += 1

    def steer(self, scan, v_ref_xy, v_uav_xy, motion, cloud):
        self.asked.append((scan, v_ref_xy, v_uav_xy, motion, cloud))
        return Decision(v_ref_xy, False, 0.0, 1, Reason.STEERED)


class Bench:
    """A loop, and what it said. Messages of one instant come in this order: odometry, reference, scan."""

    def __init__(self, mount=LEVEL, **named):
        self.algorithm, self.said, self.mount = Follows(), [], mount
        self.loop = SteeringLoop(self.algorithm, self._mount_of, self.said.append, **named)

    def _mount_of(self, frame):
        if self.mount is None:
            raise MountError(f'TF does not know "{frame}".')
        return self.mount

    def odometry(self, at_ms, x=0.0, speed=1.0, yaw_rad=0.0):
        level = (0.0, 0.0, math.sin(0.5 * yaw_rad), math.cos(0.5 * yaw_rad))
        return self.loop.on_odometry(at_ms * MS, OwnState((speed, 0.0, 0.0), (x, 0.0, 2.0), level))

    def instant(self, at_ms, v_ref=AHEAD, x=0.0, yaw_rad=0.0):
        """Return the command that answers the scan."""
        assert not self.odometry(at_ms, x, yaw_rad=yaw_rad)
        assert not self.loop.on_reference(at_ms * MS, v_ref)
        (command,) = self.loop.on_scan(at_ms * MS, SCAN, "laser")
        return command


def test_a_scan_is_answered_with_its_own_stamp_and_the_references_climb():
    command = Bench().instant(100)
    assert (command.stamp_ns, command.velocity_m_s) == (100 * MS, AHEAD)
    assert (command.scan_stamp_ns, command.frame) == (100 * MS, "laser")


def test_a_climb_that_the_algorithm_leaves_to_the_reference_ends_under_the_ceiling():
    bench = Bench(uses_range_finders=True)
    for source, up in (("range_finder", -1.0), ("range_finder_up", 1.0)):
        ranging = Ranging((0.0, 0.0, 0.0), (0.0, 0.0, up), bench.algorithm.parameters.r_lb, 0.05, 40.0)
        bench.loop.on_range(source, 100 * MS, ranging)
    assert bench.instant(100).velocity_m_s == (*AHEAD[:2], 0.0)


def test_a_scan_waits_for_what_has_its_stamp():
    bench = Bench()
    bench.instant(100)
    assert not bench.loop.on_scan(200 * MS, SCAN, "laser")
    assert not bench.odometry(200)
    (command,) = bench.loop.on_reference(200 * MS, STANDS)
    assert (command.stamp_ns, command.velocity_m_s) == (200 * MS, STANDS)


@pytest.mark.table(("mount", "side"), [(LEVEL, 1.0), (UPSIDE_DOWN, -1.0)])
def test_the_algorithm_knows_how_far_the_lidar_has_turned_since_the_last_scan_and_when_that_was(mount, side):
    bench = Bench(mount)
    bench.algorithm.wants_motion = False  # so that a lidar upside down is not turned over
    for at_ms, yaw_rad in ((100, 3.1), (125, -3.1), (175, 3.1)):
        bench.instant(at_ms, yaw_rad=yaw_rad)
    small_turn_rad = side * (2.0 * math.pi - 6.2)
    assert bench.algorithm.told == [
        (pytest.approx(0.025), pytest.approx(small_turn_rad)),
        (pytest.approx(0.05), pytest.approx(-small_turn_rad)),
    ]


def test_an_orientation_that_makes_no_sense_is_no_turn():
    bench = Bench()
    bench.algorithm.wants_motion = False
    for at_ms, orientation in ((100, (0.0, 0.0, 0.0, 1.0)), (125, (0.0, 0.0, math.nan, 0.0))):
        bench.loop.on_odometry(at_ms * MS, OwnState((1.0, 0.0, 0.0), (0.0, 0.0, 2.0), orientation))
        bench.loop.on_reference(at_ms * MS, AHEAD)
        bench.loop.on_scan(at_ms * MS, SCAN, "laser")
    assert bench.algorithm.told == [(pytest.approx(0.025), 0.0)]


@pytest.mark.table(("age_ms", "flown"), [(500, AHEAD), (501, STANDS)])
def test_a_reference_counts_for_half_a_second(age_ms, flown):
    bench = Bench()
    bench.loop.on_reference(1000 * MS, AHEAD)
    bench.odometry(1000 + age_ms)
    (command, *_) = [
        *bench.loop.on_scan((1000 + age_ms) * MS, SCAN, "laser"),
        *bench.loop.on_scan((1010 + age_ms) * MS, SCAN, "laser"),  # the first waits no longer
    ]
    assert command.velocity_m_s == flown


@pytest.mark.table(("at_ms", "words"), [(250, "0.75 s older"), (1750, "0.75 s newer")])
def test_odometry_of_another_time_is_told_as_older_or_newer(at_ms, words):
    said = []
    state = OwnState((1.0, 0.0, 0.0), (0.0, 0.0, 2.0), (0.0, 0.0, 0.0, 1.0))
    paired = Paired(Stamped(1000 * MS, None), {"odometry": Stamped(at_ms * MS, state)})
    assert OwnMotion(said.append).at(paired, LEVEL, 0.0) == (None, True)
    assert said[0].startswith(f"The odometry is {words} than the scan.")


def test_it_brakes_when_an_answer_is_too_old_and_stamps_never_go_back():
    bench = Bench()
    bench.instant(100)
    assert not bench.odometry(201)  # 0.1 s, and the tolerance of 1 ms
    (brake,) = bench.odometry(202)
    assert (brake.stamp_ns, brake.velocity_m_s, brake.answer) == (202 * MS, STANDS, None)
    assert "No scan was answered for 0.102 s" in bench.said[-1]
    bench.loop.on_reference(150 * MS, AHEAD)
    late = bench.loop.on_scan(150 * MS, SCAN, "laser")
    assert [command.stamp_ns for command in late] == [202 * MS]


def test_who_stands_need_not_brake():
    bench = Bench()
    bench.instant(100, v_ref=STANDS)
    assert not bench.odometry(900)


def test_a_replay_does_not_brake():
    bench = Bench(is_replay=True)
    bench.instant(100)
    assert not bench.odometry(900)


def test_until_the_mounting_is_known_the_uav_hovers():
    bench = Bench(mount=None)
    command = bench.instant(100)
    assert (command.velocity_m_s, command.answer) == (STANDS, None)
    assert "Hovering until the lidar's mounting is known" in bench.said[0]
    bench.mount = LEVEL
    assert bench.instant(200).velocity_m_s == AHEAD


def test_a_replay_waits_for_the_mounting():
    bench = Bench(mount=None, is_replay=True)
    bench.odometry(100)
    bench.loop.on_reference(100 * MS, AHEAD)
    assert not bench.loop.on_scan(100 * MS, SCAN, "laser")
    bench.mount = LEVEL
    (command,) = bench.odometry(200)
    assert (command.stamp_ns, command.velocity_m_s) == (100 * MS, AHEAD)


def test_what_is_remembered_is_forgotten_when_the_odometry_jumps():
    bench = Bench()
    for k in range(5):
        bench.instant(100 + 25 * k, x=0.025 * k)
    assert bench.algorithm.resets == 0
    bench.instant(225, x=2.0)
    assert bench.algorithm.resets == 1
    assert "The odometry jumped by 1.90 m" in bench.said[-1]


def test_after_a_clock_that_jumped_back_it_begins_anew():
    restarted = []
    bench = Bench(on_restart=lambda: restarted.append(True))
    bench.instant(5000)
    assert bench.instant(100).stamp_ns == 100 * MS
    assert restarted
    assert bench.algorithm.resets == 1
    assert "The clock jumped back by 4.900 s" in bench.said[0]


def test_a_lidar_upside_down_is_asked_as_seen_from_above():
    bench = Bench(mount=UPSIDE_DOWN)
    left = (0.3, 0.4, 0.0)
    command = bench.instant(100, v_ref=left)
    scan, v_ref_xy, *_ = bench.algorithm.asked[0]
    assert v_ref_xy == pytest.approx(left[:2])  # the plane is turned back, so left is left
    assert scan.angle_increment == -SCAN.angle_increment
    assert command.velocity_m_s == pytest.approx(left)


def test_a_cloud_of_another_frame_than_the_lidars_is_turned():
    limits = CloudLimits((-0.3, 0.3), (-math.pi, math.pi), (0.5, 100.0))
    bench = Bench(limits=limits)
    points = np.array([[1.0, 2.0, 3.0]])
    quarter = math.sqrt(0.5)
    turned = Mount.of_pose((1.0, 0.0, 0.1), (0.0, 0.0, quarter, quarter))
    for at_ms, mount in ((100, LEVEL), (200, turned)):
        bench.loop.on_cloud(at_ms * MS, SensedPoints(points, mount))
        bench.instant(at_ms)
    clouds = [asked[4].points_m for asked in bench.algorithm.asked]
    assert clouds[0] is points
    np.testing.assert_allclose(clouds[1], [[-1.0, 1.0, 3.0]], atol=1e-12)  # a quarter turn left, 1 m ahead


@pytest.mark.table(("late_ms", "is_told"), [(0, False), (15, False), (30, True)])
def test_clouds_whose_stamps_are_never_near_a_scans_are_told_of(late_ms, is_told):
    bench = Bench(limits=CloudLimits((-0.3, 0.3), (-math.pi, math.pi), (0.5, 100.0)))
    for number in range(16):
        at_ms = 100 * number
        bench.loop.on_cloud((at_ms - late_ms) * MS, SensedPoints(np.ones((20, 3)), LEVEL))
        bench.odometry(at_ms)
        bench.loop.on_reference(at_ms * MS, AHEAD)
        bench.loop.on_scan(at_ms * MS, SCAN, "laser")
    told = [sentence for sentence in bench.said if "none within 0.02 s of a scan" in sentence]
    assert bool(told) == is_told
    assert len(bench.algorithm.asked) > 12
    assert all((asked[4] is None) == is_told for asked in bench.algorithm.asked[1:])


class Listens(Follows):
    """Keeps what it was told of the UAV."""

    def __init__(self):
        super().__init__()
        self.is_ready = None

    def take_ready(self, is_ready):
        self.is_ready = is_ready

    def take_keep_out(self, keep_out):
        pass


def test_each_algorithm_knows_whether_the_uav_flies():
    """Without a word of it the UAV counts as ready."""
    first, second, third = Listens(), Listens(), Listens()
    loop = SteeringLoop(first, lambda frame: LEVEL, [].append)
    loop.take(second)
    loop.take_ready(False)
    loop.take(third)
    assert (first.is_ready, second.is_ready, third.is_ready) == (None, False, False)
    loop.take_ready(True)
    assert third.is_ready
    fourth = Listens()
    SteeringLoop(first, lambda frame: LEVEL, [].append).take(fourth)
    assert fourth.is_ready


def test_a_velocity_that_the_places_refute_does_not_reach_the_algorithm():
    """The twist is along the axes of the odometry's frame; the front is at a right angle to its x axis."""
    bench, turned = Bench(), (0.0, 0.0, math.sqrt(0.5), math.sqrt(0.5))
    for at_ms in range(100, 3100, 50):
        state = OwnState((2.0, 0.0, 0.0), (0.002 * at_ms, 0.0, 2.0), turned)
        bench.loop.on_odometry(at_ms * MS, state)
        bench.loop.on_reference(at_ms * MS, AHEAD)
        bench.loop.on_scan(at_ms * MS, SCAN, "laser")
    _, _, own_xy, motion, _ = bench.algorithm.asked[-1]
    assert own_xy == pytest.approx((0.0, -2.0))
    assert motion.velocity_m_s == pytest.approx((2.0, 0.0, 0.0))
    assert sum("velocity (twist)" in sentence for sentence in bench.said) == 1
