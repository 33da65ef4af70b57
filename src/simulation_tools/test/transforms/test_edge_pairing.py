"""The pairing of odometry and ground truth."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from simulation_tools.geometry import Pose
from simulation_tools.transforms.edge_pairing import ABSENT_AFTER_NS, EdgePairer, FrameNames

TICK_NS = 10_000_000
IN_ODOM = Pose.from_xyz_rpy(1.0, 2.0, 3.0, 0.1, -0.2, 0.3)
IN_WORLD = Pose.from_xyz_rpy(1.5, 1.0, 3.0, 0.1, -0.2, 0.5)


def names(edges):
    return {(edge.parent, edge.child) for edge in edges}


BOTH = {("odom", "base_frame"), ("base_frame", "world")}


@pytest.fixture
def pairer():
    """A pairer that has heard both sources."""
    pairer = EdgePairer()
    pairer.on_odometry(0, IN_ODOM)
    pairer.on_ground_truth(0, IN_WORLD)
    return pairer


def test_edges_are_the_odometry_and_the_inverse_of_the_ground_truth(pairer):
    edges = {edge.child: edge for edge in run_pair(pairer, TICK_NS)}
    assert edges["base_frame"].pose == IN_ODOM
    round_trip = IN_WORLD @ edges["world"].pose
    assert round_trip.position_m == pytest.approx((0.0, 0.0, 0.0), abs=1e-12)
    assert abs(round_trip.orientation_xyzw[3]) == pytest.approx(1.0)


def run_pair(pairer, stamp_ns):
    assert pairer.on_odometry(stamp_ns, IN_ODOM) == []
    return pairer.on_ground_truth(stamp_ns, IN_WORLD)


@pytest.mark.parametrize("odometry_first", [True, False])
def test_both_edges_leave_together_with_one_stamp_in_either_order(pairer, odometry_first):
    calls = [lambda: pairer.on_odometry(TICK_NS, IN_ODOM), lambda: pairer.on_ground_truth(TICK_NS, IN_WORLD)]
    first, second = calls if odometry_first else calls[::-1]
    assert first() == []
    edges = second()
    assert names(edges) == BOTH
    assert {edge.stamp_ns for edge in edges} == {TICK_NS}


def test_a_repeated_stamp_is_published_once(pairer):
    run_pair(pairer, TICK_NS)
    assert pairer.on_odometry(TICK_NS, IN_ODOM) == []
    assert pairer.on_ground_truth(TICK_NS, IN_WORLD) == []
    assert pairer.jumps_back == 0


@pytest.mark.table(
    ("source", "edge"),
    [("on_odometry", ("odom", "base_frame")), ("on_ground_truth", ("base_frame", "world"))],
)
def test_a_source_alone_is_published_at_once(source, edge):
    pairer = EdgePairer()
    for tick in range(3):
        edges = getattr(pairer, source)(tick * TICK_NS, IN_ODOM)
        assert names(edges) == {edge}
        assert edges[0].stamp_ns == tick * TICK_NS


def test_when_odometry_stops_the_world_edge_goes_on(pairer):
    stamps = [tick * TICK_NS for tick in range(1, 200)]
    published = [edge for stamp in stamps for edge in pairer.on_ground_truth(stamp, IN_WORLD)]
    assert names(published) == {("base_frame", "world")}
    # While odometry may still come, an edge leaves one tick late; none is lost.
    assert [edge.stamp_ns for edge in published] == stamps
    late = ABSENT_AFTER_NS // TICK_NS
    assert pairer.on_ground_truth(stamps[-1] + TICK_NS, IN_WORLD)[0].stamp_ns == stamps[-1] + TICK_NS
    assert late < len(stamps)


def test_a_clock_that_jumps_back_starts_anew(pairer):
    run_pair(pairer, 20 * TICK_NS)
    pairer.on_odometry(0, IN_ODOM)
    assert pairer.jumps_back == 1
    pairer.on_ground_truth(0, IN_WORLD)
    assert names(run_pair(pairer, TICK_NS)) == BOTH


@given(
    st.lists(st.tuples(st.booleans(), st.integers(0, 3)), max_size=60),
)
def test_stamps_never_repeat_and_never_fall_while_the_clock_rises(messages):
    """Whatever is lost or late, tf2 gets rising stamps: each edge at most once per stamp."""
    pairer = EdgePairer()
    now = {True: 0, False: 0}
    published: dict = {}
    for is_odometry, ticks in messages:
        now[is_odometry] += ticks * TICK_NS
        take = pairer.on_odometry if is_odometry else pairer.on_ground_truth
        for edge in take(now[is_odometry], IN_ODOM):
            assert edge.stamp_ns > published.get(edge.child, -1)
            published[edge.child] = edge.stamp_ns
    assert pairer.jumps_back == 0


def test_frame_names_are_parameters():
    pairer = EdgePairer(FrameNames(odom="a/odom", base="a/base", world="a/world"))
    assert names(pairer.on_odometry(0, IN_ODOM)) == {("a/odom", "a/base")}
    assert names(pairer.on_ground_truth(TICK_NS * 100, IN_WORLD)) == {("a/base", "a/world")}
