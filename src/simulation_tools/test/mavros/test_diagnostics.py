"""MAVROS's entries in /diagnostics."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from pymavlink.dialects.v20 import common

pytestmark = pytest.mark.ros


@pytest.fixture(scope="module")
def diagnose():
    return pytest.importorskip(
        "simulation_tools_ros.mavros.diagnostics", reason="needs ROS's message packages"
    )


def a_heartbeat():
    return common.MAVLink_heartbeat_message(2, 12, 157, 0x03040000, 4, 3)


def sys_status(health=0x2F, remaining=80):
    return common.MAVLink_sys_status_message(0x2F, 0x2F, health, 100, 16000, 250, remaining, 0, 0, 0, 0, 0, 0)


def values(status):
    return {value.key: value.value for value in status.values}


def test_connection(diagnose):
    client = SimpleNamespace(connected=False, packets=7, bad_packets=2)
    status = diagnose.connection(client)
    assert (status.level, status.message) == (diagnose.ERROR, "not connected")
    assert values(status) == {"Received packets": "7", "Parse errors": "2"}
    client.connected = True
    assert diagnose.connection(client).level == diagnose.OK


def test_heartbeats_are_counted_over_their_window(diagnose):
    status = diagnose.heartbeats(a_heartbeat(), 40, [10.0, 11.0, 12.0, 13.0], 14.0)
    assert (status.level, values(status)["Frequency (Hz)"], values(status)["Mode"]) == (
        diagnose.OK,
        "1.000",
        "AUTO.LOITER",
    )
    assert diagnose.heartbeats(a_heartbeat(), 40, [10.0], 30.0).level == diagnose.WARN
    assert diagnose.heartbeats(None, 0, [], 3.0).level == diagnose.ERROR


def test_an_ill_sensor_and_a_low_battery_are_told(diagnose):
    assert diagnose.system(sys_status()).level == diagnose.OK
    assert diagnose.system(sys_status(health=0x0F)).level == diagnose.ERROR
    assert diagnose.system(None).level == diagnose.WARN
    assert values(diagnose.battery(sys_status()))["Voltage"] == "16.00"
    assert diagnose.battery(sys_status(remaining=10)).message == "Low voltage"
    assert diagnose.battery(sys_status(remaining=-1)).message == "No data"
