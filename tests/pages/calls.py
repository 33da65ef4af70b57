"""What the pages' snippets call, and whether it could do what it is for; nothing of it is started."""

from __future__ import annotations

import importlib.util
import re
import subprocess
from functools import cache
from pathlib import Path
from xml.etree import ElementTree

import genpy
import roslib.message
import yaml
from launch_files import launch_file, load, node_exists, run
from snippets import ROOT, Call

FILE_ARGUMENTS = {"world", "bag", "mission"}
"""Arguments of launch files that name a file."""
WORLDS = {"hold_3d", "hold_3d_cargo", "ballast_tank"}
"""Names that explore.launch takes in place of a world file."""
SUBCOMMANDS = {"test", "bench", "report", "docs", "setup"}
UPSTREAM = {"rqt_reconfigure", "mavros"}
"""Packages that a reader builds from source."""
READERS_OWN = {"my_avoidance", "urg_node"}
"""The tutorial's package, and the driver of a lidar that only a real UAV has."""
UNRUN = {"rqt", "rviz", "rosparam", "rosservice", "rosnode"}
SERVERS = {"/cepa": ("cepa", "Cepa"), "/position_controller": ("inspection_tools", "PositionController")}
"""Packages and .cfg files of the nodes that pages tune."""
HELPFUL = {
    ("flights", "campaign"),
    ("doctor", "doctor"),
    ("doctor", "draw_graph"),
    ("gridslam", "gridslam_evaluate"),
    ("gridslam", "gridslam_replay"),
    ("gridslam", "map_saver"),
}
"""Programs that tell their options by --help."""


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
        if words[:2] == ["-m", "pytest"]:
            assert all(Path(call.folder, word).exists() for word in words[2:] if "/" in word), call
        else:
            script = Path(*words[1].split(".")).with_suffix(".py") if words[0] == "-m" else Path(words[0])
            assert (ROOT / script).is_file(), call
    elif program == "ign":
        done = subprocess.run(["which", "ign"], capture_output=True)
        assert done.returncode != 0 or Path(words[-1]).is_file(), call
    else:
        assert program in UNRUN, f"nobody knows how to check {call.words}"


def launches(call: Call) -> None:
    package, file, *given = call.words[1:]
    found = launch_file(package, file)
    assert found, f"{package} has no {file}"
    names = arguments_of(found)
    for word in given:
        name, given_as, value = word.partition(":=")
        assert given_as, f"{word} is not an argument"
        assert name in names, f"{file} knows no argument {name}"
        if name in FILE_ARGUMENTS and value not in WORLDS:
            assert Path(call.folder, value).is_file(), f"{value} is not there"
    if not is_there("mavros"):  # it is built from source; all else of the file is looked at
        given = [word for word in given if word != "mavros:=real" and not word.startswith("fcu_url:=")]
    config = load(found, *given)
    assert not config.config_errors
    nodes = {(node.package, node.type) for node in config.nodes if node.package not in READERS_OWN}
    assert not {node for node in nodes if not node_exists(*node)}


@cache
def arguments_of(file: str) -> frozenset[str]:
    return frozenset(arg.get("name") for arg in ElementTree.parse(file).getroot().findall("arg"))


def brings_up(call: Call) -> None:
    words = call.words[1:]
    if not words or words[0] in SUBCOMMANDS:
        assert not [word for word in words if word.startswith("tests/") and not (ROOT / word).exists()], call
        return
    package, _, file = words[0].rpartition("/")
    file = file.removesuffix(".launch") + ".launch"
    found = [path.parts[-3] for path in ROOT.glob(f"src/**/launch/{file}")]
    assert package in found or len(found) == 1, f"{words[0]} is in {found}"
    launches(Call(call.folder, ("roslaunch", package or found[0], file, *words[1:])))


def runs(call: Call) -> None:
    package, node, *given = call.words[1:]
    if (package, node) == ("dynamic_reconfigure", "dynparam"):
        tunes(given)
        return
    if package in UPSTREAM and not is_there(package):
        assert f"local-name: {package}" in (ROOT / "rosinstall").read_text()
        return
    assert node_exists(package, node), f"{package} has no {node}"
    if (package, node) in HELPFUL:
        knows_options((package, node, *given), [word for word in given if word.startswith("-")])


def knows_options(words, options) -> None:
    """words: package, program, and what it is given."""
    kinds = ("tune", "relations", "ate", "map", "volume")  # of `campaign` and `gridslam_evaluate`
    program = ROOT / "devel/lib" / words[0] / words[1]  # rosrun takes 0.4 s of CPU time to find it
    text = help_of(str(program), *(word for word in words[2:3] if word in kinds))
    for option in options:
        assert re.search(rf"(?<![\w-]){re.escape(option)}(?![\w-])", text), f"{words[1]} knows no {option}"


@cache
def is_there(package: str) -> bool:
    """Whether ROS finds a package."""
    return subprocess.run(["rospack", "find", package], capture_output=True).returncode == 0


@cache
def help_of(*words: str) -> str:
    done = run(*words, "--help")
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


@cache
def generated(package: str, config: str):
    """The module that a .cfg became; by its path, since other tests import the package from its source."""
    place = ROOT / "devel/lib/python3/dist-packages" / package / "cfg" / f"{config}Config.py"
    spec = importlib.util.spec_from_file_location(f"{config}Config", place)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def topic(call: Call) -> None:
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
