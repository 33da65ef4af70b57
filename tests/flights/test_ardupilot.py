"""ArduPilot as its own users know it: positions, lost setpoints, RTL, fence, battery and LAND by MAVROS."""

from __future__ import annotations

import json
import math
import os
import signal
import sys
from pathlib import Path

import pytest

from flights.graph.free_ports import free_ports
from simulation_tools.ardupilot_sitl.program import ENVIRONMENT

SESSION = Path(__file__).with_name("copter_session.py")
RTL_HEIGHT_M, RTL_CONE = 15.0, 3.0
"""ArduPilot's RTL_ALT, and RTL_CONE_SLOPE: near home it climbs less."""
FENCE_M = 15.0

pytestmark = [
    pytest.mark.ros,
    pytest.mark.flight,
    pytest.mark.timeout(900),
    pytest.mark.skipif(
        not os.access(os.environ.get(ENVIRONMENT, ""), os.X_OK),
        reason=f"{ENVIRONMENT} does not name ArduPilot's program (simulation_tools/doc/ardupilot.md)",
    ),
]


@pytest.fixture(scope="module", params=["sim", "real"])
def seen(request, processes_of_module, tmp_path_factory):
    """What the script saw, by step."""
    processes = processes_of_module
    if request.param == "real" and processes.run("rospack", "find", "mavros", timeout_s=60.0).returncode != 0:
        pytest.skip("MAVROS itself is not installed")
    master, *ports = free_ports(4)
    processes.environment["ROS_MASTER_URI"] = f"http://localhost:{master}"
    names = ("simulator_port", "offboard_port", "gcs_port")
    words = [f"{name}:={port}" for name, port in zip(names, ports)]
    log = tmp_path_factory.mktemp("session") / "roslaunch.log"
    with log.open("w") as file:
        launch = processes.start(
            *("roslaunch", "-p", str(master), "simulation_tools", "sitl.launch", "autopilot:=ardupilot"),
            *(f"mavros:={request.param}", "real_time_factor:=2", *words),
            stdout=file,
            stderr=file,
        )
        run = processes.run(sys.executable, str(SESSION), timeout_s=800.0)
        launch.send_signal(signal.SIGINT)
        launch.wait(60.0)
    assert run.returncode == 0, run.stdout + log.read_text(errors="replace")
    print(run.stdout)
    steps = [json.loads(line) for line in run.stdout.splitlines() if line.startswith("{")]
    return {step.pop("step"): step for step in steps}


@pytest.mark.parametrize("step", ["take_off", "again", "third"])
def test_it_arms_in_guided_and_takes_off_by_command(seen, step):
    assert seen[step]["guided"]
    assert seen[step]["taken"]
    assert seen[step]["height_m"] == pytest.approx(3.0, abs=0.3)


def test_it_flies_to_a_position_in_mavros_frame(seen):
    assert math.isfinite(seen["position"]["came_s"])


def test_without_setpoints_it_brakes_after_guid_timeout_and_stays_in_guided(seen):
    assert seen["loss"]["speed_m_s"] == pytest.approx(2.0, abs=0.2)
    assert 1.0 < seen["loss"]["stopped_s"] < 4.0
    assert seen["loss"]["mode"] == "GUIDED"


def test_rtl_climbs_and_lands_at_home(seen):
    assert seen["rtl"]["is_in"]
    height_m = min(RTL_HEIGHT_M, RTL_CONE * seen["rtl"]["from_m"])
    assert seen["rtl"]["highest_m"] == pytest.approx(height_m, abs=1.0)
    assert seen["rtl"]["off_m"] < 0.5


def test_a_breached_fence_is_an_rtl(seen):
    assert seen["fence"]["set"]
    assert seen["fence"]["mode"] == "RTL"
    assert FENCE_M - 0.5 < seen["fence"]["breached_m"] < FENCE_M + 2.0
    assert seen["fence"]["farthest_m"] < FENCE_M + 5.0
    assert seen["fence_home"]["off_m"] < 0.5


def test_a_low_battery_is_an_rtl_after_ten_seconds(seen):
    assert seen["battery"]["set"]
    assert seen["battery"]["mode"] == "RTL"
    assert seen["battery"]["failsafe_s"] == pytest.approx(10.0, abs=2.0)


def test_land_lands(seen):
    assert seen["land"]["is_in"]
    assert math.isfinite(seen["land"]["landed_s"])
