"""Ports and numbers that a user gives are checked in one place."""

from __future__ import annotations

import pytest

from simulation_tools.values import ParameterError, mavlink_ports, number, port


@pytest.mark.table("given", [0, 14540, "65535", 80.0])
def test_ports_are_taken_as_roslaunch_and_yaml_write_them(given):
    assert port("gcs_port", given) == int(given)


@pytest.mark.table("given", [65536, -1, "abc", 1.5, None, float("nan")])
def test_what_is_no_port_is_refused(given):
    with pytest.raises(ParameterError, match="The parameter gcs_port must be a port, 0 to 65535, not"):
        port("gcs_port", given)


def test_two_links_do_not_share_a_port():
    assert mavlink_ports("14540", 14550) == (14540, 14550)
    assert mavlink_ports(0, 0) == (0, 0)  # any two that are free
    with pytest.raises(ParameterError, match="offboard_port and gcs_port are both 14540"):
        mavlink_ports(14540, "14540")


def test_numbers_keep_their_limits():
    assert number("real_time_factor", "0.5", least=0.0) == 0.5
    with pytest.raises(ParameterError, match="must be a number from 0 to"):
        number("real_time_factor", -1, least=0.0)
