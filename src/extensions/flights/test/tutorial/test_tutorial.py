"""The tutorial's files, taken from its page: they load, and its node answers a scan."""

from __future__ import annotations

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from simulation_tools.sdf.parser import load_world
from simulation_tools.vehicle.uav import load_uav

PAGES = [Path(__file__).parents[2] / f"doc/{name}.md" for name in ("tutorial", "own_tank")]
FILES = {
    name: text
    for page in PAGES
    for name, text in re.findall(
        r"^`(\S+)`\n\n```\w+\n(.*?)^```$", page.read_text(encoding="utf-8"), re.M | re.S
    )
}
MODELS = Path(__file__).parents[4] / "simulation_tools/models"
TANK = "~/tutorial/tank.world"
WORLD, LIDAR = "~/tutorial/yard.world", "~/tutorial/models/lidar_mine/model.sdf"
NODE = "src/my_avoidance/nodes/potential_field"
PATIENCE_S = 200.0


@pytest.fixture
def tutorial(tmp_path):
    """Save the files as the page says; returns the folder that stands for both home and workspace."""
    for name, content in FILES.items():
        path = tmp_path / name.replace("~/", "")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content, encoding="utf-8")
    return tmp_path


def saved(folder: Path, name: str) -> Path:
    return folder / name.replace("~/", "")


def test_the_page_has_all_its_files():
    assert set(FILES) >= {
        WORLD,
        LIDAR,
        NODE,
        "src/my_avoidance/package.xml",
        "src/my_avoidance/CMakeLists.txt",
    }


def test_the_world_is_one(tutorial):
    world = load_world(saved(tutorial, WORLD))
    assert {"walls", "container", "tank", "post"} <= {model.name for model in world.models}


@pytest.mark.skipif(not shutil.which("ign"), reason="needs ign sdf: ./bringup.sh setup")
@pytest.mark.parametrize("name", [WORLD, LIDAR, TANK])
def test_gazebos_own_checker_accepts_the_files(tutorial, name):
    environment = {"PATH": "/usr/bin:/bin", "SDF_PATH": str(MODELS)}
    command = ["ign", "sdf", "-k", str(saved(tutorial, name))]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert "Valid" in done.stdout, done.stdout + done.stderr


def test_the_lidar_fits_on_the_uav(tutorial, monkeypatch):
    monkeypatch.setenv("GAZEBO_MODEL_PATH", str(tutorial / "tutorial/models"))
    lidar = load_uav("iris", "mine").lidar
    assert lidar.frame == "hokuyo"
    assert lidar.sensor.horizontal.samples == 271
    assert (lidar.sensor.update_rate_hz, lidar.sensor.range_max_m) == (20, 6)


@pytest.mark.ros
def test_the_node_answers_a_scan(tutorial, ros_master):
    """A wall ahead turns the reference round by as much as the page's formula says."""
    probe = Path(__file__).parent / "tutorial_probe.py"
    ros_master.start(sys.executable, str(saved(tutorial, NODE)))
    done = ros_master.run(sys.executable, str(probe), timeout_s=PATIENCE_S)
    assert done.returncode == 0, done.stdout
    stamp, x, y = map(float, done.stdout.split()[-3:])
    assert stamp == pytest.approx(100.0)
    # one beam at 1 m ahead and one at 0.5 m to the left, 1.5708 rad apart; reach 2.5 m, gain 1.2
    assert x == pytest.approx(1.0 - 1.2 * 1.5708 * (1.0 - 0.4), abs=1e-3)
    assert y == pytest.approx(0.0 - 1.2 * 1.5708 * (2.0 - 0.4), abs=1e-3)
