"""What MAVROS's plugins share: the flight controller's clock, timers, topics that nobody wants."""

from __future__ import annotations

import pytest
from fake_uas import attitude
from pymavlink.dialects.v20 import common

from simulation_tools_ros.mavros.plugins.global_position import GlobalPositionPlugin
from simulation_tools_ros.mavros.plugins.imu import ImuPlugin
from simulation_tools_ros.mavros.uas import Topic, diagonal

pytestmark = pytest.mark.ros


def test_the_time_is_the_flight_controllers_once_it_is_known(uas):
    assert uas.now.to_sec() == 77.0  # ROS's
    uas.client.hear(attitude(ms=5250))
    assert uas.now.to_sec() == 5.25
    uas.client.hear(attitude(ms=5200))  # a message that was late
    assert uas.now.to_sec() == 5.25


def test_a_clock_that_jumps_back_makes_everybody_forget(uas):
    ImuPlugin(uas)
    GlobalPositionPlugin(uas)
    imu = (1.0, 2.0, -9.8, 0.1, 0.2, 0.3, 0.2, 0.1, 0.4, 95000.0, 0.0, 500.0, 20.0, 7167)
    uas.client.hear(common.MAVLink_highres_imu_message(90_000_000, *imu))
    uas.client.hear(
        common.MAVLink_gps_raw_int_message(90_000_000, 3, 1, 2, 3, 0, 0, 0, 0, 10, h_acc=299, v_acc=399)
    )
    position = (473977420, 85455940, 490500, 0, 0, 0, 0, 0)
    uas.client.hear(common.MAVLink_global_position_int_message(90_000, *position))
    assert uas.topics["global_position/global"].last.position_covariance_type == 2
    uas.client.hear(attitude(ms=3000))
    assert uas.now.to_sec() == 3.0
    assert uas.topics["imu/data"].last.linear_acceleration_covariance[0] == -1.0  # unknown again
    uas.client.hear(common.MAVLink_global_position_int_message(3000, *position))
    assert uas.topics["global_position/global"].last.position_covariance_type == 0


def test_timers_run_by_wall_time(uas, monkeypatch):
    now, calls = [100.0], []
    monkeypatch.setattr("time.monotonic", lambda: now[0])
    uas.every(1.0, calls.append)
    uas.every(0.25, lambda now_s: None)
    assert uas.run_timers() == pytest.approx(0.25)
    assert calls == [100.0]
    now[0] = 100.9
    uas.run_timers()
    assert calls == [100.0]
    now[0] = 101.0
    uas.run_timers()
    assert calls == [100.0, 101.0]


class Publisher:
    def __init__(self, listeners):
        self.listeners = listeners
        self.published = []

    def get_num_connections(self):
        return self.listeners

    def publish(self, message):
        self.published.append(message)


@pytest.mark.table(
    ("listeners", "latch", "published"), [(0, False, []), (1, False, ["made"]), (0, True, ["made"])]
)
def test_a_message_is_made_for_those_who_listen(listeners, latch, published):
    made, publisher = [], Publisher(listeners)
    Topic(publisher, latch).publish(lambda: made.append(1) or "made")
    assert publisher.published == published
    assert len(made) == len(published)


def test_a_diagonal_matrix():
    assert diagonal(1.0, 2.0) == [1.0, 0.0, 0.0, 2.0]
