"""Vision, odometry and ranges as PX4 of July 2021 reads them; what PX4 does not understand gives a sentence.

Expected values: what PX4's receiver hands to its estimator, see px4_reference.md and PX4's documentation.
"""

from __future__ import annotations

import math

import pytest
from pymavlink.dialects.v20 import common as mavlink

from simulation_tools.px4.mavlink.clock_sync import ClockSync

NAN = math.nan
HALF_ROOT = math.sqrt(0.5)
NO_COVARIANCE = [NAN] * 21
POSE_COVARIANCE = [float(i) for i in range(21)]  # variances: 0, 6, 11 of the position, 20 of the yaw


@pytest.fixture
def receiver(setup, monkeypatch):
    """A client, and the samples that reach the estimator."""
    client, samples = setup.client(), []
    monkeypatch.setattr(setup.flight.px4, "offer_external_vision", samples.append)
    setup.run(0.1)
    return setup, client, samples


def pose(us=90_000, xyz=(1.0, 2.0, -3.0), rpy=(0.0, 0.0, math.pi / 2), covariance=NO_COVARIANCE):
    return mavlink.MAVLink_vision_position_estimate_message(us, *xyz, *rpy, covariance)


def odometry(us=90_000, frame=1, child=12, q=(1.0, 0.0, 0.0, 0.0), v=(0.1, 0.2, 0.3), kind=2):
    return mavlink.MAVLink_odometry_message(
        us, frame, child, 1, 2, -3, q, *v, 0, 0, 0, POSE_COVARIANCE, POSE_COVARIANCE, 0, kind
    )


def send(setup, client, *messages):
    for message in messages:
        client.send(message)
    setup.run(0.008)


def test_a_pose_has_no_velocity_and_unknown_covariances_stay_unknown(receiver):
    setup, client, samples = receiver
    send(
        setup, client, pose(), pose(covariance=POSE_COVARIANCE), pose(covariance=[NAN, *POSE_COVARIANCE[1:]])
    )
    plain, known, partly = samples
    assert (plain.time_us, plain.position_m, plain.velocity_m_s) == (90_000, (1.0, 2.0, -3.0), None)
    assert plain.attitude == pytest.approx((HALF_ROOT, 0.0, 0.0, HALF_ROOT))
    assert all(map(math.isnan, plain.position_variance_m2))
    assert math.isnan(plain.yaw_variance_rad2)
    assert (known.position_variance_m2, known.yaw_variance_rad2) == ((0.0, 6.0, 11.0), 20.0)
    assert all(map(math.isnan, partly.position_variance_m2))  # one is missing: the parameter for all
    assert not setup.warnings


def test_odometry_has_a_velocity_in_the_bodys_frame(receiver):
    setup, client, samples = receiver
    send(setup, client, odometry(q=(2.0, 0.0, 0.0, 2.0)), odometry(frame=20), odometry(v=(NAN, 0.0, 0.0)))
    ned, frd, without = samples
    assert (ned.velocity_m_s, ned.velocity_in_body) == (pytest.approx((0.1, 0.2, 0.3)), True)
    assert ned.attitude == pytest.approx((HALF_ROOT, 0.0, 0.0, HALF_ROOT))  # of length 1
    assert ned.velocity_variance_m2_s2 == (0.0, 6.0, 11.0)
    assert (frd.position_m, without.velocity_m_s) == ((1.0, 2.0, -3.0), None)
    assert not setup.warnings


@pytest.mark.parametrize(
    ("message", "accepted", "sentence"),
    [
        (pose(xyz=(NAN, 0.0, 0.0)), 1, "VISION_POSITION_ESTIMATE has a position with NaN"),
        (pose(rpy=(NAN, 0.0, 0.0)), 1, "VISION_POSITION_ESTIMATE has no valid attitude"),
        (pose(us=2_000_000), 1, "VISION_POSITION_ESTIMATE is stamped 1.9 s ahead"),
        (odometry(q=(0.0,) * 4), 1, "ODOMETRY has no valid attitude"),
        (odometry(frame=8), 0, "ODOMETRY in the frame 8"),
        (odometry(child=8), 1, "ODOMETRY of the body frame 8"),
        (odometry(kind=4), 0, "ODOMETRY of the estimator type 4"),
        (
            mavlink.MAVLink_vision_speed_estimate_message(90_000, 1.0, 2.0, 3.0),
            0,
            "does not know VISION_SPEED_ESTIMATE",
        ),
    ],
)
def test_nonsense_gives_one_sentence(receiver, message, accepted, sentence):
    setup, client, samples = receiver
    send(setup, client, message, message, message)
    assert len(samples) == 3 * accepted
    assert [sentence in warning for warning in setup.warnings] == [True]


def test_what_is_too_old_gives_one_sentence(receiver):
    setup, client, samples = receiver
    setup.run(1.0)
    send(setup, client, pose(us=100_000), pose(us=110_000))
    assert len(samples) == 2
    assert ["VISION_POSITION_ESTIMATE is 1" in warning for warning in setup.warnings] == [True]


def distance(orientation=25, quality=100):
    return mavlink.MAVLink_distance_sensor_message(
        90, 10, 1000, 234, 0, 3, orientation, 1, signal_quality=quality
    )


def test_a_range_downwards_is_taken_and_told_with_px4s_own_id(setup):
    client = setup.client()
    client.heartbeat()
    setup.run(0.1)
    send(setup, client, distance(orientation=0))
    assert setup.flight.px4.newest_range is None
    send(setup, client, distance())
    taken = setup.flight.px4.newest_range
    assert (taken.time_us, taken.quality) == (90_000, 100)
    assert (taken.distance_m, taken.range_min_m, taken.range_max_m) == pytest.approx((2.34, 0.1, 10.0))
    setup.run(0.2)
    told = client.take("DISTANCE_SENSOR")[-1]
    assert (told.min_distance, told.max_distance, told.current_distance) == (10, 1000, 234)
    assert (told.id, told.orientation, told.time_boot_ms, told.signal_quality) == (0, 25, 90, 100)


def test_stamps_of_simulated_time_count_as_they_are():
    clock = ClockSync()
    assert clock.own_time_us(5_000_000, 5_040_000) == 5_000_000  # nobody has answered TIMESYNC yet
    clock.hear(mavlink.MAVLink_timesync_message(5_010_000_000, 5_000_000_000), 5_008_000)
    assert clock.own_time_us(5_000_000, 5_040_000) == 5_000_000


def test_stamps_of_another_clock_count_after_500_exchanges_as_in_px4():
    clock, ahead_us = ClockSync(), 1_600_000_000_000_000
    for i in range(500):
        assert i < 1 or clock.own_time_us(ahead_us, 7_000_000) == 7_000_000  # the time of arrival
        sent_us = 100_000 * i
        clock.hear(
            mavlink.MAVLink_timesync_message(1000 * (sent_us + 2000 + ahead_us), 1000 * sent_us),
            sent_us + 4000,
        )
    assert clock.own_time_us(7_000_000 + ahead_us, 7_050_000) == pytest.approx(7_000_000, abs=1000)
