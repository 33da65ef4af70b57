"""A launch that needs a missing part of MAVROS is refused, and the part is named."""

from __future__ import annotations

import pytest

from simulation_tools.launch_check.launch_files import LaunchError
from simulation_tools.launch_check.launch_packages import check_mavros_is_there


def finding(*packages):
    """Finds these, as ROS would."""
    return {package: f"/opt/{package}" for package in packages}.__getitem__


@pytest.mark.table(
    ("gnss", "there", "missing"),
    [
        (True, (), "mavros"),
        (False, (), "mavros"),
        (False, ("mavros",), "mavros_extras"),
        (True, ("mavros",), None),
        (False, ("mavros", "mavros_extras"), None),
    ],
)
def test_the_missing_package_is_named(gnss, there, missing):
    if missing is None:
        check_mavros_is_there("real", gnss, finding(*there))
        return
    with pytest.raises(
        LaunchError, match=f" the package {missing}, and ROS does not find it.*from_source.md"
    ):
        check_mavros_is_there("real", gnss, finding(*there))


@pytest.mark.table("mavros", ["sim", "none"])
def test_without_the_real_mavros_nothing_is_needed(mavros):
    check_mavros_is_there(mavros, False, finding())
