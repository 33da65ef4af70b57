"""Every snippet of the pages runs as pasted from where its page says.

Bash runs all shell blocks, in a copy of the workspace made of links. It only writes down the programs in
`snippets.CALLED`. Then each of these calls is checked:
- roslaunch, and bringup.sh with a launch file: roslaunch's own loader loads the file with these arguments;
  every argument, node and file exists. rosinstall names the packages that a reader builds from source.
- rosrun: the program exists, and our own commands know the options given.
- dynparam, rostopic, rosbag: parameter and value, type and message, subcommand and options exist.
- bringup.sh setup, test, bench and report take long and are not run; files that they name must exist.
Blocks with one of `snippets.ELSEWHERE` (apt-get, catkin_make, ...) need root, the network or foreign sources.
Bash only parses them; their lines that call ROS are checked as above. Python blocks run, with values for the
names that the page leaves to its reader.
"""

from __future__ import annotations

import importlib.util
import re
import subprocess
from functools import lru_cache
from pathlib import Path

import pytest
import snippets
import yaml
from snippets import ROOT, Call, Snippet, fenced, pages, shell_snippets, workspace

pytestmark = pytest.mark.ros

PAGES = pages()
FILE_ARGUMENTS = {"world", "bag", "mission"}
"""Arguments of launch files that name a file."""
SUBCOMMANDS = {"test", "bench", "report", "setup"}
UPSTREAM = {"rqt_reconfigure", "mavros"}
"""Packages that a reader builds from source."""
UNRUN = {"rqt", "rviz", "rosparam", "rosservice", "rosnode"}
SERVERS = {"/cepa": ("cepa", "Cepa"), "/position_controller": ("inspection_tools", "PositionController")}
"""Packages and .cfg files of the nodes that pages tune."""
HELPFUL = {
    ("master_thesis", "campaign"),
    ("master_thesis", "doctor"),
    ("master_thesis", "draw_graph"),
    ("gridslam", "gridslam_evaluate"),
    ("gridslam", "gridslam_replay"),
    ("gridslam", "map_saver"),
}
"""Programs that tell their options by --help."""


@pytest.fixture(scope="module")
def place(tmp_path_factory):
    """A workspace to paste into, with what a reader would have made before: results, a map, a recording."""
    folder = tmp_path_factory.mktemp("pasted")
    made, home = workspace(folder), folder / "home"
    before = {
        made / "results/experiment_1/now/flight.bag": "",
        made / "results/campaigns/cepa_tuning_tuning/cepa_tuned.yaml": "",
        made / "flight.bag": "",
        made / "mission.yaml": fenced("src/inspection_tools/doc/reference.md", "yaml")[0],
        made / "src/my_avoidance/nodes/potential_field": "#!/usr/bin/env python3\n",
        home / "tutorial/yard.world": (ROOT / "my.world").read_text(),
        home / "tutorial/models/lidar_mine/model.sdf": "",
    }
    for path, content in before.items():
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(content)
    return made, home


def of_pages(found) -> list:
    return [pytest.param(one, id=f"{one.page}-{one.number}") for page in PAGES for one in found(page)]


def test_there_are_snippets_on_the_pages():
    """Empty lists would make the tests below pass without looking at anything."""
    assert {"README.md", "src/cepa/README.md", "src/master_thesis/doc/tutorial.md"} <= set(PAGES)
    assert sum(len(shell_snippets(page)) for page in PAGES) > 20


@pytest.mark.parametrize(
    "text",
    [
        "roslaunch master_thesis experiment_1.launch lidr:=urg",
        "roslaunch master_thesis fly_to_goal.launch world:=$PWD/no.world goal:='1 2 3'",
        "roslaunch master_thesis experiment_9.launch",
        "rosrun master_thesis docto",
        "rosrun master_thesis doctor --alive",
        "rosrun master_thesis doctor [--alive]",
        "rosrun dynamic_reconfigure dynparam set /cepa r_up 1.5",
        "rosrun dynamic_reconfigure dynparam set /cepa r_ub 1e9",
        "rostopic pub -1 /a geometry_msgs/Pose '{position: {q: 1.0}}'",
        "rosbag play --clok some.bag",
        "./bringup.sh experiment_1.launch scenaro:=forest",
        "./bringup.sh bensh",
        "cd no_such_folder",
        "roslaunch master_thesis 'experiment_1.launch",
        "sudo make 'install",
    ],
)
def test_a_snippet_that_is_wrong_is_noticed(text, place):
    """The checks can fail: each of these has one fault."""
    with pytest.raises(AssertionError):
        check(Snippet("none", 0, text), place)


@pytest.mark.parametrize("snippet", of_pages(shell_snippets))
def test_a_shell_snippet_runs_as_pasted(snippet, place):
    check(snippet, place)


def check(snippet: Snippet, place) -> None:
    """Let bash run a snippet, and look at every call of it."""
    made, home = place
    for text in snippet.runnable:
        for call in snippets.run(text, made, home):
            look_at(call)
    for line in snippet.text.splitlines():  # what stands in [brackets] is an option too
        words = line.split()
        if words[:1] == ["rosrun"] and tuple(words[1:3]) in HELPFUL:
            knows_options(tuple(words[1:]), re.findall(r"(?<=\[)--[\w-]+", line))


def look_at(call: Call) -> None:
    """Look at one call; raises AssertionError when it could not do what it is for."""
    program, *words = call.words
    checks = {
        "roslaunch": launches,
        "rosrun": runs,
        "rostopic": topic,
        "rosbag": bag,
    }
    if program in checks:
        checks[program](call)
    elif program == "./bringup.sh":
        brings_up(call)
    elif program == ".venv/bin/python":
        assert words[:2] == ["-m", "pytest"], call
        assert not [word for word in words[2:] if "/" in word and not Path(call.folder, word).exists()], call
    elif program == "ign":
        done = subprocess.run(["which", "ign"], capture_output=True)
        assert done.returncode != 0 or Path(words[-1]).is_file(), call
    else:
        assert program in UNRUN, f"nobody knows how to check {call.words}"


# -- roslaunch ----------------------------------------------------------------------------------------------


def launches(call: Call) -> None:
    import roslib.packages

    package, file, *given = call.words[1:]
    found = [path for path in roslib.packages.find_resource(package, file) if path.endswith(".launch")]
    assert found, f"{package} has no {file}"
    names = arguments_of(found[0])
    for word in given:
        name, given_as, value = word.partition(":=")
        assert given_as, f"{word} is no argument"
        assert name in names, f"{file} knows no argument {name}"
        if name in FILE_ARGUMENTS:
            assert Path(call.folder, value).is_file(), f"{value} is not there"
    if not is_there("mavros"):  # it is built from source; all else of the file is looked at
        given = [word for word in given if word != "mavros:=real"]
    loads(found[0], *given)


@lru_cache(maxsize=None)
def loads(file: str, *given: str) -> None:
    """Let roslaunch load a file; raises AssertionError when it cannot, or when a node does not exist."""
    import roslaunch.config
    import roslib.packages

    try:
        config = roslaunch.config.load_config_default([(file, given)], None, verbose=False)
    except roslaunch.RLException as error:
        raise AssertionError(f"{file} {given}: {error}") from None
    assert not config.config_errors
    # Nodes of one's own (the tutorial's) are made on the page
    nodes = {(node.package, node.type) for node in config.nodes if node.package != "my_avoidance"}
    assert not {node for node in nodes if not roslib.packages.find_node(*node)}


@lru_cache(maxsize=None)
def arguments_of(file: str) -> frozenset[str]:
    from xml.etree import ElementTree

    return frozenset(arg.get("name") for arg in ElementTree.parse(file).getroot().findall("arg"))


def brings_up(call: Call) -> None:
    words = call.words[1:]
    if not words or words[0] in SUBCOMMANDS:
        assert not [word for word in words if word.startswith("tests/") and not (ROOT / word).exists()], call
        return
    launches(Call(call.folder, ("roslaunch", "master_thesis", *call.words[1:])))


# -- programs -----------------------------------------------------------------------------------------------


def runs(call: Call) -> None:
    import roslib.packages

    package, node, *given = call.words[1:]
    if (package, node) == ("dynamic_reconfigure", "dynparam"):
        tunes(given)
        return
    if package in UPSTREAM and not is_there(package):
        assert f"local-name: {package}" in (ROOT / "rosinstall").read_text()
        return
    assert roslib.packages.find_node(package, node), f"{package} has no {node}"
    if (package, node) in HELPFUL:
        knows_options((package, node, *given), [word for word in given if word.startswith("-")])


def knows_options(words, options) -> None:
    """words: package, program, and what it is given."""
    kinds = ("tune", "relations", "ate", "map")  # of `campaign` and `gridslam_evaluate`
    text = help_of("rosrun", *words[:2], *(word for word in words[2:3] if word in kinds))
    for option in options:
        assert re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", text), f"{words[1]} knows no {option}"


@lru_cache(maxsize=None)
def is_there(package: str) -> bool:
    """Whether ROS finds a package."""
    return subprocess.run(["rospack", "find", package], capture_output=True).returncode == 0


@lru_cache(maxsize=None)
def help_of(*words: str) -> str:
    done = subprocess.run([*words, "--help"], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0, done.stderr
    return done.stdout


def tunes(words) -> None:
    verb, server, *rest = words
    assert verb in ("set", "load", "get"), words
    module = generated(*SERVERS[server])
    if verb == "set":
        name, value = rest
        assert name in module.defaults, f"{server} has no parameter {name}"
        default = module.defaults[name]
        if isinstance(default, (int, float)) and not isinstance(default, bool):
            assert module.min[name] <= float(value) <= module.max[name], f"{name} {value}"


@lru_cache(maxsize=None)
def generated(package: str, config: str):
    """The module that a .cfg became; by its path, since other tests import the package from its source."""
    place = ROOT / "devel/lib/python3/dist-packages" / package / "cfg" / f"{config}Config.py"
    spec = importlib.util.spec_from_file_location(f"{config}Config", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def topic(call: Call) -> None:
    import genpy
    import roslib.message

    verb, *words = call.words[1:]
    assert verb in ("pub", "echo", "hz", "list"), call
    if verb == "pub":
        kind, text = words[-2:]
        message = roslib.message.get_message_class(kind)
        assert message, f"there is no message {kind}"
        try:
            genpy.message.fill_message_args(message(), [yaml.safe_load(text)])
        except genpy.MessageException as error:
            raise AssertionError(str(error)) from None


def bag(call: Call) -> None:
    """Its subcommand knows every option."""
    text = help_of("rosbag", call.words[1])
    for word in call.words[2:]:
        assert not word.startswith("--") or re.search(rf"{word}(?![\w-])", text), f"rosbag knows no {word}"


# -- for real -----------------------------------------------------------------------------------------------


def test_the_doctor_of_the_page_runs():
    """`rosrun master_thesis doctor`: this installation. 1: it found something; 2: it could not look."""
    done = subprocess.run(
        ["rosrun", "master_thesis", "doctor"], capture_output=True, text=True, timeout=120, cwd=ROOT
    )
    assert done.returncode in (0, 1), done.stdout + done.stderr
    assert "Traceback" not in done.stderr
    assert "Examined" in done.stdout


@pytest.mark.flight
def test_the_world_of_the_page_is_flown_to_its_goal():
    """The README's fly_to_goal.launch with my.world, here without ROS."""
    from master_thesis.flight.closed_loop import ClosedLoop, ClosedLoopParameters
    from simulation_tools.geometry import Pose
    from simulation_tools.simulation import SimulationParameters

    assert 'world:=$PWD/my.world start:="0 0 0 1.57" goal:="3 20 2"' in (ROOT / "README.md").read_text()
    start = Pose.from_xyz_rpy(0.0, 0.0, 0.0, yaw=1.57)
    flown = SimulationParameters(str(ROOT / "my.world"), spawn_pose=start)
    with ClosedLoop(ClosedLoopParameters(flown, goal_xyz_m=(3.0, 20.0, 2.0))) as loop:
        outcome = loop.run()
        aside = max(row[1] for row in loop.log.truth.rows)
    assert outcome.success, outcome.failure
    assert aside > 3.3, "there is nothing to fly around"


# -- python -------------------------------------------------------------------------------------------------

GIVEN = """
import math
import numpy as np
ranges = np.full(1081, 4.0)
angle_min, angle_increment, range_min, range_max = -math.radians(135), math.radians(0.25), 0.06, 10.0
"""
POSE = """
x, y, yaw, roll, pitch, height, stamp = 0.0, 0.0, 0.0, 0.0, 0.0, 2.0, 1.0
lidar_in_base = ((0.0, 0.0, 0.1), (0.0, 0.0, 0.0, 1.0))
"""
PYTHON = {
    "src/cepa/README.md": (GIVEN, "decision.velocity_xy != (0.0, 0.0)"),
    "src/gridslam/README.md": (GIVEN + POSE, "update is not None"),
    "src/inspection_tools/README.md": (
        GIVEN + "stamp_s, position_m, yaw_rad = 1.0, (0.0, 0.0, 2.0), 0.0\n",
        "yaw_rate > 0.0 and not command.goal_reached",
    ),
    "src/simulation_tools/README.md": (
        "",
        "abs(simulation.world.get_state('iris').pose.position_m[2] - 2.0) < 0.3 and not simulation.close()",
    ),
}
"""By page: what its reader has before the page's python, and what is true afterwards."""
SKELETONS = {
    "src/gridslam/doc/loop_closure.md": "lines of a caller's loop; test_loop_closure.py runs the same calls",
    "src/node_tools/README.md": "the frame of a node, with dots where its imports stand",
    "src/master_thesis/doc/tutorial.md": "a node; test_tutorial.py runs it against a scan",
}


def test_a_python_snippet_has_a_place_here():
    of_python = {page for page in PAGES if fenced(page, "python")}
    assert of_python == PYTHON.keys() | SKELETONS.keys()


@pytest.mark.parametrize("page", PYTHON)
def test_a_python_snippet_runs(page, monkeypatch, place):
    monkeypatch.chdir((ROOT / page).parent)
    (block,) = fenced(page, "python")
    given, afterwards = PYTHON[page]
    names: dict = {}
    exec(given + block.replace('"mission.yaml"', repr(str(place[0] / "mission.yaml"))), names)
    assert eval(afterwards, names)


@pytest.mark.parametrize("page", SKELETONS)
def test_a_python_skeleton_is_python(page):
    for block in fenced(page, "python"):
        compile(block, page, "exec")
