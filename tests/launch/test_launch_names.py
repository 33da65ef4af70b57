"""`./bringup.sh NAME` finds a launch file in whatever package it is."""

import os
import re
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]


def found(asked):
    script = 'source scripts/console.sh && source scripts/launch.sh && find_launch_file "$1"'
    return subprocess.run(["bash", "-c", script, "-", asked], cwd=ROOT, capture_output=True, text=True)


@pytest.mark.parametrize(
    ("asked", "file"),
    [
        ("explore", "src/extensions/flights/launch/explore.launch"),
        ("sitl.launch", "src/simulation_tools/launch/sitl.launch"),
        ("gridslam/volume", "src/gridslam/launch/volume.launch"),
        ("inspection_tools/tools.launch", "src/inspection_tools/launch/tools.launch"),
    ],
)
def test_a_name_is_enough_where_one_package_has_it(asked, file):
    assert found(asked).stdout == f"{file}\n"


def test_where_two_packages_have_the_name_both_calls_are_told():
    said = found("tools.launch")
    assert said.returncode == 1
    assert said.stderr == (
        "bringup: Several packages have a launch file 'tools.launch'. Call one of them:\n"
        "  ./bringup.sh inspection_tools/tools.launch\n"
        "  ./bringup.sh simulation_tools/tools.launch\n"
    )


@pytest.mark.parametrize("asked", ["nothing", "gridslam/explore", "flight", "*", "xplore", "gridslam/"])
def test_what_no_user_starts_is_one_sentence(asked):
    """Also parts that launch files include, patterns, and parts of a name."""
    said = found(asked)
    assert (said.returncode, said.stdout) == (1, "")
    assert said.stderr.startswith(f"bringup: There is no launch file '{asked}.launch' in a package of src")
    assert said.stderr.count("\n") == 1


def test_logs_that_cannot_be_written_are_one_sentence(tmp_path):
    (tmp_path / "file").touch()
    script = "source scripts/console.sh && source scripts/launch.sh && check_logs"
    for home, code in ((tmp_path / "file", 1), (tmp_path / "new", 0)):
        told = {"PATH": os.environ["PATH"], "HOME": str(tmp_path), "ROS_HOME": str(home)}
        checked = subprocess.run(["bash", "-c", script], cwd=ROOT, env=told, capture_output=True, text=True)
        remedy = "set ROS_HOME or ROS_LOG_DIR to a folder of yours"
        said = f"bringup: ROS cannot write its logs to {home}/log; {remedy}.\n"
        assert (checked.returncode, checked.stderr) == (code, said if code else "")
    assert (tmp_path / "new/log").is_dir()


def test_the_help_of_bringup_says_what_each_launch_file_does():
    told = subprocess.run([ROOT / "bringup.sh", "--help"], capture_output=True, text=True, check=True).stdout
    files = sorted(f"{path.parts[-3]}/{path.name}" for path in ROOT.glob("src/**/launch/*.launch"))
    sentences = dict(re.findall(r"^  (\w+/\w+\.launch) +(\S.*\.)$", told, flags=re.M))
    assert sorted(sentences) == files
    assert sentences["flights/explore.launch"].startswith("A UAV explores a place")
    assert not any("<" in sentence or "--" in sentence for sentence in sentences.values())


MOVED = ("explore", "fly_to_goal", "inspection", "real", "teleop")


def test_only_what_users_typed_leads_to_its_new_place():
    assert sorted(path.stem for path in ROOT.glob("src/**/launch/moved/*")) == sorted(MOVED)


@pytest.mark.ros
@pytest.mark.parametrize("name", MOVED)
def test_a_launch_file_that_moved_is_found_by_its_old_package_and_names_the_new_one(name):
    launch_files = pytest.importorskip("launch_files", reason="needs the workspace's environment")
    import roslib.packages

    (old,) = roslib.packages.find_resource("master_thesis", f"{name}.launch")
    words = ("world:=/a.world", "goal:=9 0 2", "seed:=7") if name == "fly_to_goal" else ()
    there = launch_files.load(ROOT / f"src/extensions/flights/launch/{name}.launch", *words)
    led = launch_files.load(old, *words)
    (said,) = led.config_errors
    assert f"roslaunch flights {name}.launch" in said
    assert {node.name for node in led.nodes} == {node.name for node in there.nodes}
    assert {key: one.value for key, one in led.params.items()} == {
        key: one.value for key, one in there.params.items()
    }
