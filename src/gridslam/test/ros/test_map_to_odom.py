"""When map -> odom goes out, and with which stamp."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

map_to_odom = pytest.importorskip(
    "gridslam_ros.publishing.map_to_odom", reason="the workspace is not built, or not sourced"
)
FRAMES = ("map", "odom")
S = 1_000_000_000
HERE, THERE = (1.0, 2.0, 0.5, 0.2), (1.1, 2.0, 0.5, 0.2)


class Sent(list):
    """Stands for a publisher: keeps what goes out, as (stamp in s, x)."""

    def publish(self, message):
        for edge in message.transforms:
            self.append((edge.header.stamp.to_sec(), edge.transform.translation.x))
            self.edge = edge


def broadcaster(period_s=0.05, delay_s=0.1, pose=HERE):
    sent = Sent()
    out = map_to_odom.MapToOdom(sent, FRAMES, period_s, delay_s)
    out.restart(pose)
    return out, sent


def test_it_is_stamped_ahead():
    out, sent = broadcaster()
    out.keep_up(10 * S)
    assert sent == [(10.1, 1.0)]
    assert (sent.edge.header.frame_id, sent.edge.child_frame_id) == FRAMES
    assert sent.edge.transform.translation.z == 0.2
    assert sent.edge.transform.rotation.z == pytest.approx(math.sin(0.25))
    assert sent.edge.transform.rotation.w == pytest.approx(math.cos(0.25))


def test_nothing_goes_out_before_there_is_something_to_say():
    out, sent = broadcaster(pose=None)
    out.keep_up(10 * S)
    assert sent == []
    out.correct(HERE, 10 * S)
    assert sent == [(10.1, 1.0)]


def test_with_odometry_at_100_hz_it_goes_out_once_a_period():
    out, sent = broadcaster()
    for tick in range(100):
        out.keep_up(10 * S + tick * S // 100)
    assert [stamp for stamp, _ in sent] == pytest.approx([10.1 + 0.05 * index for index in range(20)])


def test_a_correction_goes_out_at_once_and_after_what_went_out_before():
    # Given a scan at 10.00 s that is dealt with when odometry is at 10.06 s already
    out, sent = broadcaster()
    for tick in range(7):
        out.keep_up(10 * S + tick * S // 100)
    out.correct(THERE, 10 * S)
    # Then the correction is the newest that TF knows
    assert [x for _, x in sent] == [1.0, 1.0, 1.1]
    assert sent[-1][0] > sent[-2][0]
    assert sent[-1][0] == pytest.approx(10.15, abs=1e-4)


def test_a_correction_is_a_jump_that_tf_does_not_smooth():
    out, sent = broadcaster()
    out.keep_up(10 * S)
    out.correct(THERE, 10 * S + S // 50)
    assert [x for _, x in sent] == [1.0, 1.0, 1.1]
    assert [stamp for stamp, _ in sent] == pytest.approx([10.1, 10.119999, 10.12], abs=1e-7)


def test_what_has_not_changed_is_no_correction():
    out, sent = broadcaster()
    for tick in range(5):
        out.correct(HERE, 10 * S + tick * S // 100)
    assert len(sent) == 1


def test_period_zero_publishes_none():
    out, sent = broadcaster(period_s=0.0)
    out.keep_up(10 * S)
    out.correct(THERE, 11 * S)
    assert sent == []


def test_after_a_restart_stamps_may_be_older():
    out, sent = broadcaster()
    out.keep_up(10 * S)
    out.restart(HERE)
    out.keep_up(2 * S)
    assert [stamp for stamp, _ in sent] == pytest.approx([10.1, 2.1])


@given(
    st.lists(st.tuples(st.booleans(), st.integers(0, 10 * S), st.sampled_from([HERE, THERE])), max_size=30)
)
def test_stamps_always_rise(calls):
    out, sent = broadcaster()
    for is_correction, stamp_ns, pose in calls:
        out.correct(pose, stamp_ns) if is_correction else out.keep_up(stamp_ns)
    stamps = [stamp for stamp, _ in sent]
    assert stamps == sorted(set(stamps))
