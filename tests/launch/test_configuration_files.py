"""Every file that users hand to ROS is loaded once: launch files, SDF, YAML, RViz, dynamic_reconfigure."""

from __future__ import annotations

import ast
import importlib.util
import json
import math
import os
import re
import shutil
import subprocess
import sys
from fnmatch import fnmatch
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[2]


FILES = sorted(Path(folder, file) for folder, _, files in os.walk(ROOT / "src") for file in files)


def files(*patterns: str) -> list[Path]:
    return [path for path in FILES if any(fnmatch(str(path), f"*/{pattern}") for pattern in patterns)]


def name(path: Path) -> str:
    return str(path.relative_to(ROOT / "src" if ROOT / "src" in path.parents else ROOT))


LAUNCH = files("launch/*.launch")
STARTED = [path for path in LAUNCH if path.parent.name == "launch"]
"""Those in launch/include get their arguments from these."""
ROSTESTS = files("test/*.test")
# A test's data may be broken on purpose.
SDF = [path for path in files("*.sdf", "*.world") if "test" not in path.parts] + [ROOT / "my.world"]
YAML = files("config/*.yaml", "launch/*.yaml", "rviz/*.rviz")
RVIZ = files("rviz/*.rviz")
MAPPING_RVIZ, FLYING_RVIZ = ROOT / "src/master_thesis/rviz", ROOT / "src/extensions/flights/rviz"
CFG = files("cfg/*.cfg")
LONGEST_LIST = 7  # parameters in one frame of rqt_reconfigure


# For launch files that cannot be without: a value for each argument that has no default.
EXAMPLES = {
    "world": str(ROOT / "src/extensions/flights/worlds/empty.world"),
    "goal": "10 0 2",
    "bag": "some.bag",
}
OPTIONAL = {"mavros", "urg_node"}  # asked for by an argument only, and not in every distribution


FLIPPED = {"true": "false", "false": "true"}


def arguments(path: Path) -> list[ElementTree.Element]:
    return [arg for arg in ElementTree.parse(path).getroot().findall("arg") if arg.get("value") is None]


def test_there_is_something_to_load():
    """An empty list would make the tests below pass without looking at anything."""
    assert LAUNCH
    assert SDF
    assert RVIZ
    assert CFG
    assert YAML


def loaded(path, *given):
    """Return roslaunch's configuration of a launch file, with a value for each argument that needs one."""
    from launch_files import load

    required = [arg.get("name") for arg in arguments(path) if arg.get("default") is None]
    return load(path, *(f"{key}:={EXAMPLES[key]}" for key in required), *given)


def test_no_topic_is_remapped_twice():
    """rospy resolves a subscriber's topic twice: a topic that is remapped, too, would be another one."""
    for path in LAUNCH:
        for node in ElementTree.parse(path).getroot().iter("node"):
            remaps = [(each.get("from", ""), each.get("to", "")) for each in node.iter("remap")]
            sources = {"/" + source.lstrip("/") for source, _ in remaps}
            twice = [to for source, to in remaps if to in sources and to != "/" + source.lstrip("/")]
            assert not twice, name(path)


@pytest.mark.parametrize("path", STARTED + ROSTESTS, ids=name)
def test_launch_file_loads_and_its_nodes_exist(path):
    """As it is, and with each of its yes-or-no arguments turned over."""
    from launch_files import node_exists

    turned = [arg for arg in arguments(path) if arg.get("default") in FLIPPED] if path in STARTED else []
    for given in ((), *((f"{arg.get('name')}:={FLIPPED[arg.get('default')]}",) for arg in turned)):
        config = loaded(path, *given)
        nodes = {(node.package, node.type) for node in config.nodes + config.tests}
        assert not config.config_errors, given
        assert nodes
        assert not {node for node in nodes if not node_exists(*node)}, given


THESIS, OWN_WORLD = "improved", "dynamic"
MAPPING = "$(eval 'dynamic' if nod else 'improved')"
ALGORITHMS = (
    *((f"master_thesis/launch/experiment_{number}", THESIS) for number in (1, 2)),
    *((f"master_thesis/launch/experiment_{number}", MAPPING) for number in (3, 4)),
    ("extensions/flights/launch/fly_to_goal", OWN_WORLD),
    ("extensions/flights/launch/teleop", OWN_WORLD),
    ("extensions/flights/launch/real", OWN_WORLD),
    ("cepa/launch/cepa", OWN_WORLD),
)


@pytest.mark.parametrize(("file", "algorithm"), ALGORITHMS)
def test_own_worlds_are_flown_by_the_safe_algorithm_not_the_thesiss(file, algorithm):
    defaults = {arg.get("name"): arg.get("default") for arg in arguments(ROOT / f"src/{file}.launch")}
    assert defaults["algorithm"] == algorithm


FLYING = (
    *(f"master_thesis/launch/experiment_{number}" for number in (1, 2, 3, 4)),
    "extensions/flights/launch/fly_to_goal",
    "extensions/flights/launch/teleop",
    "simulation_tools/launch/sitl",
)


@pytest.mark.ros
@pytest.mark.parametrize("file", FLYING)
def test_every_launch_file_that_flies_can_hold_the_worlds_models(file):
    path = ROOT / "src" / f"{file}.launch"
    for value in (False, True):
        config = loaded(path, f"static_models:={str(value).lower()}")
        assert config.params["/gazebo/static_models"].value is value


def test_a_package_declares_what_its_launch_files_use():
    for path in LAUNCH + ROSTESTS:
        package = next(folder for folder in path.parents if (folder / "package.xml").is_file())
        text = path.read_text(encoding="utf-8")
        used = set(re.findall(r"""\bpkg="(\w+)"|\$\(find (\w+)\)|\bfind\('(\w+)'\)""", text))
        manifest = ElementTree.parse(package / "package.xml").getroot()
        declared = {entry.text for entry in manifest if entry.tag.endswith("depend")}
        assert {"".join(names) for names in used} <= declared | {package.name} | OPTIONAL, name(path)


def test_rostests_have_ports_of_their_own():
    """They run beside each other, and beside a user's flight on the usual ports."""
    given = [arg for path in ROSTESTS for arg in ElementTree.parse(path).iter("arg")]
    ports = [arg.get("value") for arg in given if arg.get("name").endswith("_port")]
    assert len(ports) == len({"14540", "14550", *ports}) - 2


def test_every_launch_argument_is_documented():
    bare = {
        (name(path), arg.get("name"))
        for path in LAUNCH
        for arg in arguments(path)
        if not (arg.get("doc") or "").strip()
    }
    assert bare == set()


@pytest.mark.long
def test_sdf_is_valid():
    """`ign sdf -k` knows the format better than we do. What it only warns of is a fault as well."""
    if not shutil.which("ign"):
        pytest.skip("needs `ign sdf`: packages ignition-tools and libsdformat-dev")
    models = os.pathsep.join(str(folder) for folder in ROOT.glob("src/**/models"))
    run = subprocess.run(
        [sys.executable, str(ROOT / "tests/launch/sdf_check.py"), *map(str, SDF)],
        env={**os.environ, "SDF_PATH": models},
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    complaints, said = {}, []
    for line in run.stderr.splitlines():
        path, _, code = line.rpartition(" ")
        if Path(path) in SDF:
            complaints[Path(path)], said = [*said, "not valid"] if int(code) else said, []
        else:
            said.append(line)
    assert complaints == {path: [] for path in SDF}


def test_yaml_loads():
    for path in YAML:
        assert yaml.load(path.read_text(encoding="utf-8"), yaml.CSafeLoader), f"{name(path)} is empty"


def test_every_launch_file_starts_rviz_where_there_is_a_display_only():
    nodes = [node for path in LAUNCH for node in ElementTree.parse(path).iter("node")]
    started = [(node.get("pkg"), node.get("type")) for node in nodes if node.get("name") == "rviz"]
    assert set(started) == {("node_tools", "rviz_if_display")}


def test_rviz_shows_the_same_of_both_mapping_experiments():
    """They differ in how much of the world the window holds, and in lines and arrows twice as thick."""
    room, hold = (yaml.safe_load((MAPPING_RVIZ / f"experiment_{n}.rviz").read_text()) for n in (3, 4))
    scales = [config["Visualization Manager"]["Views"]["Current"].pop("Scale") for config in (room, hold)]
    assert scales[0] > scales[1]
    thin, thick = sizes(room), sizes(hold)
    assert room == hold
    assert thick == pytest.approx([2.0 * size for size in thin], rel=0.1)


def test_exploring_and_inspecting_are_seen_from_the_uav_on():
    """A tank is as wide as the UAV's surroundings; a view and lines that suit a hold of 30 m hide it."""
    explore, inspection = (
        yaml.safe_load((FLYING_RVIZ / f"{name}.rviz").read_text()) for name in ("explore", "inspection")
    )
    views = [config["Visualization Manager"]["Views"] for config in (explore, inspection)]
    assert views[0] == views[1]
    assert views[0]["Current"]["Target Frame"] == "base_frame"
    assert views[0]["Current"]["Distance"] < 10.0
    assert sizes(explore) == sizes(inspection)


@pytest.mark.parametrize("name", ["experiment", "explore", "inspection", "volume"])
def test_a_roof_between_the_eye_and_the_uav_is_cut_away(name):
    """Where a roof hides a UAV 2 m below it, it is nearer to the eye than the cut."""
    views = yaml.safe_load((FLYING_RVIZ / f"{name}.rviz").read_text())["Visualization Manager"]["Views"]
    (view,) = [view for view in (views["Current"], *views["Saved"]) if view["Name"] == "Follow the UAV"]
    pitch, cut_m = view["Pitch"], view["Near Clip Distance"]
    uav_m = view["Distance"] - view["Focal Point"]["X"] * math.cos(pitch)
    assert uav_m - 2.0 / math.sin(pitch) < cut_m < uav_m - 0.5


def sizes(config):
    """Take the widths of lines and the sizes of arrows out of an RViz file, and return them."""
    taken = []
    for display in config["Visualization Manager"]["Displays"]:
        for name in ("Line Width", "Shaft Length", "Shaft Radius", "Head Length", "Head Radius"):
            if name in display:
                taken.append(display.pop(name))
    return taken


@pytest.mark.long
@pytest.mark.ros
def test_rviz_shows_every_display(ros_master):
    """RViz itself loads each file, knows each display, and reports no error when the frames are there."""
    for program in ("rviz", "xvfb-run"):
        if not shutil.which(program):
            pytest.skip(f"needs {program}")
    if not importlib.util.find_spec("python_qt_binding"):
        pytest.skip("needs RViz in Python: package python3-rviz, which does not load on Debian 13")
    ros_master.environment.update(LIBGL_ALWAYS_SOFTWARE="1", QT_QPA_PLATFORM="xcb")
    probe = str(ROOT / "tests/launch/rviz_displays.py")
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"]
    run = ros_master.run(*screen, sys.executable, probe, *map(str, RVIZ), timeout_s=200.0)
    assert run.returncode == 0, run.stdout
    assert "failed to load" not in run.stdout, run.stdout
    for path in RVIZ:
        assert f"\n{path}: 0 problems" in run.stdout, run.stdout


@pytest.mark.ros
@pytest.mark.parametrize("path", CFG, ids=name)
def test_dynamic_parameters_say_what_they_are_and_where_they_end(path):
    entries = list(parameters(generated(path).config_description))
    assert entries
    for entry in entries:
        assert len(entry["description"].split()) > 2, f"{entry['name']} has no sentence"
        if entry["type"] in ("int", "double"):
            assert entry["min"] <= entry["default"] <= entry["max"], entry["name"]
            assert entry["max"] < 1e9, f"{entry['name']} has no maximum of its own"
            assert entry["min"] > -1e9, f"{entry['name']} has no minimum of its own"
            assert entry["min"] != -1, f"{entry['name']}: no slider begins at -1"


@pytest.mark.ros
@pytest.mark.parametrize("path", CFG, ids=name)
def test_dynamic_parameters_stand_in_groups_that_are_seen_at_a_glance(path):
    """rqt_reconfigure draws a frame around each group; the names are what `dynparam` knows, group or not."""
    module = generated(path)
    description = module.config_description
    for group in (description, *description["groups"]):
        assert len(group["parameters"]) <= LONGEST_LIST, group["name"]
    names = [entry["name"] for entry in parameters(description)]
    assert sorted(names) == sorted(module.defaults)
    groups = {group["name"].lower() for group in description["groups"]}
    assert not groups & set(names), "a group and a parameter of one name do not compile in C++"


def generated(cfg):
    """Return what the build made of a .cfg file, whichever copy of its package was imported before."""
    module = Path(cfg.parts[-3], "cfg", f"{cfg.stem}Config.py")
    file = next(Path(folder, module) for folder in sys.path if Path(folder, module).is_file())
    spec = importlib.util.spec_from_file_location(cfg.stem, file)
    loaded = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(loaded)
    return loaded


def parameters(group):
    """Yield the parameters of a group and of the groups in it."""
    yield from group["parameters"]
    for inner in group["groups"]:
        yield from parameters(inner)


@pytest.mark.parametrize("path", files("rqt/*.perspective"), ids=name)
def test_the_perspective_publishes_what_the_launch_files_know(path):
    groups = json.loads(path.read_text())["groups"]
    assert {"geometry", "state"} <= groups["mainwindow"]["keys"].keys(), "Qt would share out the room"
    manager = groups["pluginmanager"]
    running = ast.literal_eval(manager["keys"]["running-plugins"]["repr"])
    publisher = manager["groups"]["plugin__rqt_publisher__Publisher__1"]["groups"]["plugin"]
    published = ast.literal_eval(ast.literal_eval(publisher["keys"]["publishers"]["repr"]))
    launched = "".join(launch.read_text() for launch in LAUNCH)
    assert {"rqt_publisher/Publisher", "rqt_reconfigure/Param"} <= set(running)
    assert published
    for entry in published:
        assert f'"{entry["topic_name"]}"' in launched
        assert not entry["enabled"], "nothing flies by opening a window"
        assert all(field.startswith(entry["topic_name"] + "/") for field in entry["expressions"])


def test_flights_with_clouds_map_with_the_miss_for_level_lidars():
    from gridslam.volume import FLAT_MISS

    for launch in ("master_thesis/launch/include/mapping", "extensions/flights/launch/include/mapped"):
        tree = ElementTree.parse(ROOT / f"src/{launch}.launch")
        told = [
            arg.get("value")
            for include in tree.iter("include")
            if include.get("file", "").endswith("volume.launch") and "not in" not in include.get("if", "")
            for arg in include.iter("arg")
            if arg.get("name") == "miss"
        ]
        assert [float(each) for each in told] == [FLAT_MISS], launch
