"""How the launch files start the real MAVROS. A package with MAVROS's launch file stands in for it."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
import yaml

pytest.importorskip("rosgraph", reason="needs ROS")
rospkg = pytest.importorskip("rospkg", reason="needs ROS")
request = pytest.importorskip("flights_ros.launch.request", reason="needs the workspace's environment")

ROOT = Path(__file__).resolve().parents[2]
TELEOP = ROOT / "src/extensions/flights/launch/teleop.launch"
PX4_LAUNCH = """
<launch>
  <arg name="fcu_url"/>
  <arg name="tgt_system"/>
  <node pkg="mavros" type="mavros_node" name="mavros" clear_params="true">
    <param name="fcu_url" value="$(arg fcu_url)"/>
    <rosparam>time: {timesync_mode: MAVLINK, timesync_avg_alpha: 0.6}</rosparam>
  </node>
</launch>
"""

pytestmark = pytest.mark.ros


@pytest.fixture
def environment(tmp_path):
    """Knows MAVROS, but not mavros_extras, even if the real one is installed."""
    package = tmp_path / "mavros"
    (package / "launch").mkdir(parents=True)
    (package / "launch/px4.launch").write_text(PX4_LAUNCH)
    (package / "package.xml").write_text(
        '<package format="2"><name>mavros</name><version>1.21.0</version><description>x</description>'
        '<maintainer email="a@b.org">x</maintainer><license>x</license></package>'
    )
    here = [path for path in os.environ["ROS_PACKAGE_PATH"].split(os.pathsep) if not holds_extras(path)]
    return {**os.environ, "ROS_PACKAGE_PATH": os.pathsep.join([str(tmp_path), *here])}


def holds_extras(path: str) -> bool:
    """Whether ROS would find the real mavros_extras below a path of ROS_PACKAGE_PATH."""
    return "mavros_extras" in rospkg.list_by_path("package.xml", path, {})


def test_clocks_that_begin_together_are_not_compared(environment):
    """MAVROS computes their difference unsigned, so a small negative one puts poses 292 years ahead."""
    done = subprocess.run(
        ["roslaunch", "--dump-params", "simulation_tools", "sitl.launch", "mavros:=real"],
        env=environment,
        stdout=subprocess.PIPE,
        text=True,
        check=True,
    )
    parameters = yaml.safe_load(done.stdout)
    assert parameters["/mavros/time/timesync_mode"] == "PASSTHROUGH"
    assert parameters["/mavros/time/timesync_avg_alpha"] == 0.6


MISSING = "needs, for external poses, the package mavros_extras, and ROS does not find it."


@pytest.mark.parametrize(
    "words",
    [
        pytest.param(["master_thesis", "experiment_4.launch"], marks=pytest.mark.long),
        ["simulation_tools", "sitl.launch"],
    ],
    ids=["experiment", "sitl"],
)
def test_without_gnss_the_missing_plugins_are_named(environment, words):
    done = subprocess.run(
        ["roslaunch", *words, "mavros:=real", "gnss:=false"],
        env=environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        check=False,
        timeout=200.0,
    )
    assert done.returncode == 1
    assert MISSING in done.stdout
    assert "Traceback" not in done.stdout


def test_without_gnss_bringup_names_them_too(monkeypatch, capsys):
    monkeypatch.setattr(request.launch_check, "find_package", {"mavros": "/opt/mavros"}.__getitem__)
    assert request.main([str(TELEOP), "mavros:=real", "gnss:=false"], request.FILES) == 1
    assert MISSING in capsys.readouterr().err
