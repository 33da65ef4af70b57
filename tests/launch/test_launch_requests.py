"""What cannot be flown is refused in one sentence, before bringup.sh or roslaunch starts anything."""

from __future__ import annotations

import os
import socket
import subprocess
from pathlib import Path

import pytest
import yaml

from flights.graph.free_ports import free_ports
from flights.launch_arguments import machine_pace
from simulation_tools.launch_check.launch_files import arguments_of

rosgraph = pytest.importorskip("rosgraph", reason="needs ROS")
request = pytest.importorskip("flights_ros.launch.request", reason="needs the workspace's environment")
experiments = pytest.importorskip("master_thesis_ros.launch.request")

ROOT = Path(__file__).resolve().parents[2]
LAUNCH = {
    path.stem: path
    for package in ("extensions/flights", "master_thesis")
    for path in ROOT.glob(f"src/{package}/launch/*.launch")
}
FOREST = f"world:={ROOT / 'src/extensions/flights/worlds/forest.world'}"
TREE = "14.29 15.59"  # of the forest's first tree, radius 0.24 m

pytestmark = pytest.mark.ros


def checked(words):
    """Check a launch as bringup.sh does, with the checks of the file's package; returns the exit code."""
    of = experiments if "master_thesis" in Path(words[0]).parts else request
    return request.main(words, of.FILES)


REFUSED = {
    "argument": ("experiment_1", ["lidr:=urg"], "has no argument 'lidr'; did you mean lidar:=?"),
    "no value": ("experiment_1", ["speed=1"], "'speed=1' is not an argument; write NAME:=VALUE, for example"),
    "lidar": ("experiment_1", ["lidar:=sonar"], "There is no lidar 'sonar'; choose lidar:=urg|ust|"),
    "scenario": (
        "experiment_1",
        ["scenario:=jungle"],
        "There is no scenario 'jungle'; choose scenario:=empty|",
    ),
    "algorithm": ("experiment_4", ["algorithm:=best"], "There is no algorithm 'best'; choose algorithm:="),
    "seed": ("experiment_3", ["seed:=1.5"], "'1.5' is no seed; give a whole number from 0 to"),
    "speed": ("experiment_1", ["speed:=-1"], "'-1' is no speed; give a number from 0.05 to 15."),
    "port": ("experiment_2", ["gcs_port:=65536"], "gcs_port must be a port, 0 to 65535, not '65536'."),
    "same port": ("teleop", ["gcs_port:=14540"], "offboard_port and gcs_port are both 14540;"),
    "factor": ("experiment_1", ["real_time_factor:=-1"], "real_time_factor must be a number from 0 to"),
    "switch": ("experiment_1", ["lockstep:=yes"], "'yes' is no lockstep; give lockstep:=true or"),
    "resolved switch": (
        "experiment_3",
        ["return_to_start:=nonsense"],
        "'nonsense' is no return_to_start; give return_to_start:=true or",
    ),
    "lookahead": ("experiment_4", ["lookahead:=11"], "'11' is no lookahead; give a number from 0 to 10."),
    "resolved number": ("experiment_4", ["lookahead:=far"], "'far' is no lookahead; give a number, for"),
    "mavros": ("experiment_1", ["mavros:=fake"], "There is no mavros 'fake'; choose mavros:=sim|real."),
    "autopilot": (
        "experiment_1",
        ["autopilot:=betaflight"],
        'There is no autopilot "betaflight"; choose one of',
    ),
    "arducopter": (
        "explore",
        ["autopilot:=ardupilot", "ardupilot:=/no/arducopter"],
        "ArduPilot's program /no/arducopter is not there;",
    ),
    "arducopter without ArduPilot": (
        "experiment_1",
        ["ardupilot:=/opt/arducopter"],
        "of no use with autopilot:=standin; add autopilot:=ardupilot, or leave ardupilot out.",
    ),
    "battery of ours": (
        "fly_to_goal",
        [FOREST, "goal:=40 0 2", "autopilot:=px4", "battery:=0.3"],
        "is of no use with autopilot:=px4: PX4",
    ),
    "sensors": ("experiment_1", ["sensors:=nose"], "nose"),
    "survey plan": ("inspection", ["plan:=/no/plan.yaml"], "The plan /no/plan.yaml cannot be read: No such"),
    "settings": (
        "inspection",
        ["settings:=/no.yaml"],
        "The settings of an inspection /no.yaml cannot be read:",
    ),
    "a setting": ("inspection", ["width:=640"], "inspection.launch has no argument 'width'; it takes world"),
    "one name for two times": ("inspection", ["time:=60"], "inspection.launch has no argument 'time'; "),
    "time": ("inspection", ["photograph_time:=0"], "'0' is no photograph_time; give a number from 1 to"),
    "two maps": ("inspection", ["explore:=true", "drawing:=/map.bt"], "leave out plan:= and drawing:=."),
    "package": (
        "experiment_1",
        ["avoidance:=nopkg nonode"],
        "There is no package 'nopkg' for the avoidance;",
    ),
    "node": ("experiment_1", ["avoidance:=cepa nonode"], "The package cepa has no node 'nonode'"),
    "one word": (
        "experiment_1",
        ["avoidance:=nopkg"],
        "'nopkg' is not an avoidance; give avoidance:=cepa or",
    ),
    "goal": ("fly_to_goal", [FOREST, f"goal:={TREE} 2"], "lies inside of tree_000; choose another place."),
    "start": (
        "fly_to_goal",
        [FOREST, f"start:={TREE} 0 0", "goal:=0 0 2"],
        "would start inside of tree_000;",
    ),
    "missing": ("fly_to_goal", [FOREST], "fly_to_goal.launch needs goal:=..."),
    "world": ("fly_to_goal", ["world:=/no.world", "goal:=9 0 2"], "There is no world file /no.world;"),
    "home": ("fly_to_goal", ["world:=~/a.world", "goal:=9 0 2"], "for example world:=$HOME/a.world."),
    "no scenario": ("experiment_1", ["scenario:="], "There is no scenario ''; choose scenario:=empty|"),
    "mission": ("experiment_3", ["mission:=/no.yaml"], "/no.yaml cannot be read"),
    "truth": (
        "experiment_4",
        ["gnss:=false", "pose_source:=ground_truth"],
        "Without GNSS the UAV cannot fly by the ground truth; give pose_source:=odometry or",
    ),
    "cushions": ("experiment_3", ["r_ub:=0.4"], "r_lb must be less than r_ub"),
    "filter": ("experiment_2", ["K:=-3"], "k_filter must be greater than 0, not -3"),
    "look": ("experiment_2", ["look:=9"], "'9' is no look; give a number from 0 to 8."),
    "device": ("teleop", ["device:=mouse"], "There is no device 'mouse'; choose device:=keyboard|joy."),
    "instance": ("experiment_1", ["px4_instance:=abc"], "'abc' is no px4_instance; give a number, for"),
    "part of an instance": ("teleop", ["px4_instance:=1.5"], "'1.5' is no px4_instance; give a whole number"),
    "simulator's port": ("experiment_2", ["simulator_port:=-1"], "simulator_port must be a port, 0 to 65535"),
    "part of a scan": ("experiment_3", ["throttle_scans:=1.5"], "'1.5' is no throttle_scans; give a whole"),
    "SLAM's file": (
        "experiment_4",
        ["slam_config:=/no.yaml"],
        "SLAM's parameters /no.yaml cannot be read: No such file or directory; give a YAML file",
    ),
    "SLAM's form": (
        "experiment_3",
        [f"slam_config:={__file__}"],
        "test_launch_requests.py cannot be read: line",
    ),
    "map": (
        "experiment_3",
        ["starting_map:=/no.yaml"],
        "/no.yaml cannot be read: No such file or directory;",
    ),
    "map's place": (
        "experiment_3",
        ["starting_map:=map.yaml"],
        "give one, for example starting_map:=$PWD/map",
    ),
    "real algorithm": ("real", ["algorithm:=best"], "There is no algorithm 'best'; choose algorithm:="),
    "real height": ("real", ["hover_height:=-1"], "'-1' is no hover_height; give a number from 0.3 to 20."),
    "explore height": ("explore", ["hover_height:=0.1"], "'0.1' is no hover_height; give a number from 0.3"),
    "real clearance": ("real", ["ground_clearance:=-1"], "'-1' is no ground_clearance; give a number from"),
    "real hover": (
        "real",
        ["hover_height:=1", "ground_clearance:=1.2"],
        "would hover at 1 m, and its origin is at 1.2 m on the ground; give a greater hover_height.",
    ),
    "real speed": ("real", ["speed:=20"], "'20' is no speed; give a number from 0.05 to 15."),
    "real system": ("real", ["tgt_system:=0"], "'0' is no tgt_system; give a whole number from 1 to 255."),
    "real address": ("real", ["lidar_ip:=10.0.0.300"], "'10.0.0.300' is no lidar_ip; give the Hokuyo's"),
    "real port": ("real", ["lidar_ip:=/dev/ttyACM0"], "'/dev/ttyACM0' is no lidar_ip; give the Hokuyo's"),
    "real topic": ("real", ["range_finder:=two words"], "'two words' is no range_finder; give a topic,"),
    "real model": ("real", ["model:=/no.sdf"], "/no.sdf"),
    "real lidar": ("real", ["lidar:=sonar"], 'There is no lidar "sonar"; choose one of'),
    "real switch": ("real", ["fly:=yes"], "'yes' is no fly; give fly:=true or fly:=false."),
    "real CEPA": (
        "real",
        ["cepa_config:=/no.yaml"],
        "CEPA's parameters /no.yaml cannot be read: No such file or directory; give a YAML file of CEPA's",
    ),
    "real SLAM": (
        "real",
        ["slam:=true", "slam_config:=/no.yaml"],
        "SLAM's parameters /no.yaml cannot be read",
    ),
    "results": ("experiment_1", [f"results:={__file__}"], "is a file; choose a folder for the results"),
    "closed": ("experiment_1", ["results:=/proc/results"], "/proc may not be written to; choose another"),
}


@pytest.fixture(autouse=True)
def machine_is_fast(monkeypatch):
    """It would count for 0.3 s on each core, how fast it is."""
    monkeypatch.setattr(machine_pace, "_spin", lambda lasts_s: 1e9)


@pytest.mark.parametrize("case", REFUSED)
def test_what_cannot_be_flown_is_refused_in_one_sentence(case, capsys):
    if case == "closed" and os.access("/proc", os.W_OK):
        pytest.skip("root may write anywhere, as far as the file's mode tells")
    file, words, sentence = REFUSED[case]
    assert checked([str(LAUNCH[file]), *words]) == 1
    said = capsys.readouterr().err
    assert sentence in said
    assert said.count("\n") == 1


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("particles: many", "particles must be a finite number, not 'many'."),
        ("particels: 30", "There is no parameter particels; did you mean particles?"),
        (
            "maxUrange: 1e1",
            "maxUrange must be a finite number, not '1e1'. YAML reads 1e1 as text: write maxUrange: 1.0e+1, "
            "with a point",
        ),
        ("closure_x: 1", "The loop closure has no parameter x."),
        ("- particles", "it must be a mapping; give a YAML file"),
    ],
)
def test_parameters_that_gridslam_refuses_are_refused_before_the_flight(tmp_path, capsys, content, sentence):
    path = tmp_path / "slam.yaml"
    path.write_text(content)
    assert checked([str(LAUNCH["experiment_3"]), f"slam_config:={path}"]) == 1
    said = capsys.readouterr().err
    assert str(path) in said
    assert sentence in said


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        ("r_ubb: 1.5", "There is no parameter r_ubb; did you mean r_ub?"),
        ("r_lb: -1", "r_lb must be"),
        ("r_lb: 1e-1", "write r_lb: 1.0e-1, with a point"),
        ("r_lb: 2.0", "r_lb must be less than r_ub"),
    ],
)
def test_a_real_uavs_parameters_that_cepa_refuses_are_refused(tmp_path, capsys, content, sentence):
    path = tmp_path / "own.yaml"
    path.write_text(content)
    assert checked([str(LAUNCH["real"]), f"cepa_config:={path}"]) == 1
    said = capsys.readouterr().err
    assert f"CEPA cannot fly with cepa_config:={path}: " in said
    assert sentence in said


@pytest.mark.parametrize(
    "words",
    [
        ["lidar_ip:=192.168.0.10"],
        ["lidar_ip:=hokuyo.local", "slam:=true"],
        ["fcu_url:=/dev/ttyTHS1:921600", "gnss:=false", "battery:=endless", "joy:=/pilot/joy"],
        ["autopilot:=ardupilot", "fly:=true"],
        ["explore:=true", "gnss:=false", "lidar:=puck", "record:=true"],
        ["inspection:=true", "explore:=true", "gnss:=false", "lidar:=m8", "radius:=0.2"],
    ],
)
def test_a_real_uav_with_parts_of_its_own_is_flown(words, capsys, monkeypatch):
    monkeypatch.setattr(request.launch_check, "find_package", lambda name: f"/opt/{name}")
    assert checked([str(LAUNCH["real"]), *words]) == 0, capsys.readouterr().err


INSPECTS = ("inspection:=true", "gnss:=false", "lidar:=puck")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["explore:=true", "lidar:=puck"], "explore:=true flies without satellites; add gnss:=false."),
        (["inspection:=true", "gnss:=false", "lidar:=ust"], "needs clouds, which lidar:=ust does not give"),
        (["explore:=true", "gnss:=false", "lidar:=puck", "resolution:=0"], "resolution"),
        ([*INSPECTS, "plan:=/no/plan.yaml"], "The plan /no/plan.yaml cannot be read: No such"),
        ([*INSPECTS, "plan:=plan.yaml"], "give plan:=$PWD/plan.yaml."),
    ],
)
def test_a_real_uav_that_cannot_explore_is_refused(words, sentence, capsys):
    assert checked([str(LAUNCH["real"]), *words]) == 1
    assert sentence in capsys.readouterr().err


EXPLORES = ("explore:=true", "gnss:=false", "lidar:=puck")


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["fcu_url:=/dev/ttyTHS1:921600"], "fcu_url:=/dev/ttyTHS1:921600 needs the package mavros, and"),
        (["lidar_ip:=192.168.0.10"], "lidar_ip:=192.168.0.10 needs the package urg_node, and ROS"),
        (["autopilot:=standin"], "There is no autopilot 'standin'; choose autopilot:=px4|ardupilot."),
        (["battery:=0.3"], "battery:=0.3 is for a simulated battery"),
        (["joy:=a b"], "'a b' is no joy; give a topic, for example joy:=/joy."),
        (["record:=true", "bags:=/no/folder"], "/no/folder: there is no such folder for the recording"),
        (["record:=true", "bags:=flights"], "give one, for example bags:=$PWD/flights."),
        ([*EXPLORES, "limits:=/no/limits.yaml"], "/no/limits.yaml"),
        ([*EXPLORES, "limits:=limits.yaml"], "give one, for example limits:=$PWD/limits.yaml."),
        (["limits:=/no/limits.yaml"], "limits:=/no/limits.yaml counts in the map of SLAM; add slam:=true."),
        (["limits:=/a.yaml", "slam:=true", "algorithm:=improved"], "algorithm:=improved keeps no limits"),
        (["limits:=/no/limits.yaml", "slam:=true"], "/no/limits.yaml"),
        ([*EXPLORES, "slam_config:=/no/slam.yaml"], "/no/slam.yaml"),
        ([*INSPECTS, "drawing:=/no/hold.stl"], "/no/hold.stl: there is no such drawing. Give a mesh."),
        ([*INSPECTS, "drawing_home:=1 2"], "'1 2' is no drawing_home; give 3 numbers"),
    ],
)
def test_what_a_real_uav_cannot_use_is_refused_before_anything_starts(words, sentence, capsys, monkeypatch):
    monkeypatch.setattr(request.launch_check, "find_package", {}.__getitem__)
    assert checked([str(LAUNCH["real"]), *words]) == 1
    assert sentence in capsys.readouterr().err


@pytest.mark.parametrize("path", sorted(LAUNCH.values()), ids=lambda path: path.stem)
def test_every_launch_file_can_be_flown_as_it_is(path, capsys):
    needed = [FOREST, "goal:=9 0 2"] if path.stem == "fly_to_goal" else []
    if path.stem != "real":  # it has no simulated flight controller
        needed += free_mavlink_ports()
    assert checked([str(path), *needed]) == 0, capsys.readouterr().err


@pytest.mark.parametrize("name", ["experiment_1", "experiment_2", "experiment_4", "explore", "teleop"])
def test_cepa_knows_how_ardupilot_follows(name):
    found = dumped(name, "ardupilot")
    told = yaml.safe_load((ROOT / "src/cepa/config/ardupilot.yaml").read_text())
    assert {key: found[f"/cepa/{key}"] for key in told} == told


@pytest.mark.parametrize("name", ["explore", "inspection"])
def test_lockstep_is_not_asked_of_a_flight_controller_that_has_none(name):
    """gazebo refuses it: such a launch would end at once."""
    assert dumped(name, "standin")["/gazebo/lockstep"] is True
    assert dumped(name, "ardupilot")["/gazebo/lockstep"] is False
    assert dumped(name, "px4")["/gazebo/lockstep"] is False


def dumped(name: str, autopilot: str) -> dict:
    """Return the parameters that a launch file sets for an autopilot; such a flight is not refused."""
    from launch_files import load

    path = str(LAUNCH[name])
    words = [f"autopilot:={autopilot}", *free_mavlink_ports()]
    if autopilot == "ardupilot":
        words.append(f"ardupilot:={ROOT}/src/simulation_tools/test/ardupilot_sitl/fake_arducopter.py")
    words.append(f"simulator_port:={free_ports(1)[0]}")
    assert checked([path, *words]) == 0
    found = load(path, *words).params
    return {key: parameter.value for key, parameter in found.items()}


def free_mavlink_ports() -> list[str]:
    """Arguments of ports that a flight beside this test does not use."""
    return [f"{name}:={port}" for name, port in zip(("offboard_port", "gcs_port"), free_ports(2))]


@pytest.mark.parametrize(
    ("file", "steps"),
    [
        ("experiment_1", {"offboard_port": 0}),
        ("teleop", {"offboard_port": 40}),
        ("experiment_3", {"gcs_port": 4020}),
    ],
)
def test_a_launch_whose_port_is_taken_is_refused(file, steps, capsys):
    """MAVROS's port, and those of the flight controller beside 14540 and 14550."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        words = free_mavlink_ports() + [f"{name}:={port - step}" for name, step in steps.items()]
        assert checked([str(LAUNCH[file]), *words]) == 1
    assert f"Cannot bind UDP 127.0.0.1:{port} for " in capsys.readouterr().err


def test_the_simulator_alone_is_not_launched_either_when_a_port_is_taken(processes):
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as other:
        other.bind(("127.0.0.1", 0))
        port = other.getsockname()[1]
        run = processes.run(
            "roslaunch", "simulation_tools", "sitl.launch", f"offboard_port:={port}", timeout_s=200.0
        )
    assert run.returncode == 1
    assert f"Cannot bind UDP 127.0.0.1:{port} for MAVROS: Address already in use;" in run.stdout
    assert "process[" not in run.stdout


def test_roslaunch_alone_refuses_before_it_starts_anything(processes):
    # A default below, $(eval 4560 + px4_instance), would fail in roslaunch's own words.
    run = processes.run(
        "roslaunch", "master_thesis", "experiment_1.launch", "px4_instance:=abc", timeout_s=200.0
    )
    assert run.returncode == 1
    assert "'abc' is no px4_instance; give a number, for example px4_instance:=0." in run.stdout
    for word in ("unsupported operand", "process[", "Traceback"):
        assert word not in run.stdout


@pytest.mark.long
def test_what_a_launch_would_start_is_listed(processes):
    listed = processes.run("roslaunch", "--nodes", "master_thesis", "experiment_1.launch", timeout_s=200.0)
    assert "/cepa" in listed.stdout


def test_a_launch_over_a_running_graph_is_refused_and_the_graph_goes_on(ros_master):
    """Of the flight's nodes one is enough, from any launch: ROS would end it and start it anew."""
    first = ros_master.start_node(
        "inspection_tools", "lidar_padding", "__name:=lidar_padding", stderr=subprocess.DEVNULL
    )
    master = rosgraph.Master("/test", ros_master.environment["ROS_MASTER_URI"])
    wait_until_registered(master, "/lidar_padding")
    run = ros_master.run("roslaunch", "master_thesis", "experiment_1.launch", timeout_s=200.0)
    assert run.returncode == 1
    assert "/lidar_padding runs already at" in run.stdout
    assert "offboard_port:=" in run.stdout
    assert "process[" not in run.stdout
    assert first.poll() is None


def wait_until_registered(master, node: str) -> None:
    import time

    end_s = time.monotonic() + 60.0
    while not any(node in nodes for part in master.getSystemState() for _, nodes in part):
        assert time.monotonic() < end_s, f"{node} does not come"
        time.sleep(0.1)


def test_a_node_that_is_dead_but_registered_is_no_graph_that_runs(ros_master, monkeypatch, capsys):
    uri = ros_master.environment["ROS_MASTER_URI"]
    monkeypatch.setenv("ROS_MASTER_URI", uri)
    with socket.socket() as nobody:
        nobody.bind(("127.0.0.1", 0))
        address = f"http://127.0.0.1:{nobody.getsockname()[1]}/"
        rosgraph.Master("/gazebo", uri).handle.registerPublisher(
            "/gazebo", "/clock", "rosgraph_msgs/Clock", address
        )
        words = [str(LAUNCH["experiment_1"]), *free_mavlink_ports()]
        assert checked(words) == 0, capsys.readouterr().err


@pytest.mark.parametrize(
    "path",
    sorted((ROOT / "src").glob("**/launch/*.launch")),
    ids=lambda path: f"{path.parts[-3]}/{path.stem}",
)
def test_roslaunch_calls_an_argument_required_only_if_it_is(path):
    """`roslaunch --ros-args` calls arguments required whose default is empty."""
    from roslaunch.arg_dump import get_args

    has_default = {argument.name: argument.text is not None for argument in arguments_of(path)}
    for name, (_, default) in get_args([str(path)]).items():
        assert bool(default) is has_default[name], name
