"""Every file that users hand to ROS is loaded once: launch files, SDF, YAML, RViz, dynamic_reconfigure."""

from __future__ import annotations

import importlib
import os
import shutil
import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest
import yaml

ROOT = Path(__file__).resolve().parents[1]


def files(*patterns: str) -> list[Path]:
    return sorted(path for pattern in patterns for path in ROOT.glob(f"src/{pattern}"))


def name(path: Path) -> str:
    return str(path.relative_to(ROOT / "src"))


LAUNCH = files("*/launch/**/*.launch")
ROSTESTS = files("*/test/**/*.test")
# A test's data may be broken on purpose.
SDF = [path for path in files("**/*.sdf", "**/*.world") if "test" not in path.parts]
YAML = files("*/config/**/*.yaml", "*/launch/**/*.yaml", "*/rviz/*.rviz")
RVIZ = files("*/rviz/*.rviz")
CFG = files("*/cfg/*.cfg")


def switches() -> list[tuple[Path, str, str]]:
    """Return each launch file with each of its yes-or-no arguments turned over."""
    flipped = {"true": "false", "false": "true"}
    return [
        (path, arg.get("name"), flipped[arg.get("default")])
        for path in LAUNCH
        for arg in ElementTree.parse(path).getroot().findall("arg")
        if arg.get("default") in flipped
    ]


def test_there_is_something_to_load():
    """An empty list would make the tests below pass without looking at anything."""
    assert LAUNCH
    assert SDF
    assert RVIZ
    assert CFG
    assert YAML


@pytest.mark.ros
@pytest.mark.parametrize("path", LAUNCH + ROSTESTS, ids=name)
def test_launch_file_is_complete(path):
    """It parses, its packages are declared in package.xml, and the nodes that it starts exist."""
    import roslaunch.rlutil

    problem = roslaunch.rlutil.check_roslaunch(str(path), use_test_depends=path in ROSTESTS)
    assert problem is None, problem


@pytest.mark.ros
@pytest.mark.parametrize(
    ("path", "arg", "value"), switches(), ids=lambda item: name(item) if isinstance(item, Path) else item
)
def test_launch_file_is_complete_with_a_switch_turned_over(path, arg, value):
    import roslaunch.config
    import roslib.packages

    config = roslaunch.config.load_config_default([(str(path), [f"{arg}:={value}"])], None, verbose=False)
    missing = [f"{node.package}/{node.type}" for node in config.nodes if not find_node(roslib.packages, node)]
    assert not missing
    assert not config.config_errors


def find_node(packages, node):
    return packages.find_node(node.package, node.type)


@pytest.mark.parametrize("path", LAUNCH, ids=name)
def test_every_launch_argument_is_documented(path):
    args = ElementTree.parse(path).getroot().findall("arg")
    assert not [arg.get("name") for arg in args if not (arg.get("doc") or "").strip()]


@pytest.mark.parametrize("path", SDF, ids=name)
def test_sdf_is_valid(path):
    """`ign sdf -k` knows the format better than we do; what it only warns of is a fault as well."""
    if not shutil.which("ign"):
        pytest.skip("needs `ign sdf`: packages ignition-tools and libsdformat-dev")
    models = os.pathsep.join(str(folder) for folder in files("*/models"))
    run = subprocess.run(
        ["ign", "sdf", "-k", str(path)],
        env={**os.environ, "SDF_PATH": models},
        capture_output=True,
        text=True,
        timeout=60,
    )
    harmless = "libignition-tools-backward"  # a part for prettier stack traces, which Debian leaves out
    complaints = [line for line in run.stderr.splitlines() if line and harmless not in line]
    assert run.returncode == 0, complaints
    assert run.stdout.strip() == "Valid."
    assert not complaints


@pytest.mark.parametrize("path", YAML, ids=name)
def test_yaml_loads(path):
    assert yaml.safe_load(path.read_text(encoding="utf-8")), "the file is empty"


@pytest.mark.ros
@pytest.mark.parametrize("path", RVIZ, ids=name)
def test_rviz_shows_every_display(path, ros_master):
    """RViz itself loads the file, knows each display, and reports no error when the frames are there."""
    for program in ("rviz", "xvfb-run"):
        if not shutil.which(program):
            pytest.skip(f"needs {program}")
    ros_master.environment.update(LIBGL_ALWAYS_SOFTWARE="1", QT_QPA_PLATFORM="xcb")
    probe = str(ROOT / "tests/rviz_displays.py")
    screen = ["xvfb-run", "-a", "-s", "-screen 0 1280x1024x24"]
    run = ros_master.run(*screen, sys.executable, probe, str(path), timeout_s=90.0)
    assert run.returncode == 0, run.stdout
    assert "failed to load" not in run.stdout, run.stdout


@pytest.mark.ros
@pytest.mark.parametrize("path", CFG, ids=name)
def test_dynamic_parameters_say_what_they_are_and_where_they_end(path):
    package = path.parts[-3]
    description = importlib.import_module(f"{package}.cfg.{path.stem}Config").config_description
    entries = list(parameters(description))
    assert entries
    for entry in entries:
        assert len(entry["description"].split()) > 2, f"{entry['name']} has no sentence"
        if entry["type"] in ("int", "double"):
            assert entry["min"] <= entry["default"] <= entry["max"], entry["name"]
            assert entry["max"] < 1e9, f"{entry['name']} has no maximum of its own"
            assert entry["min"] > -1e9, f"{entry['name']} has no minimum of its own"


def parameters(group):
    """Yield the parameters of a group and of the groups in it."""
    yield from group["parameters"]
    for inner in group["groups"]:
        yield from parameters(inner)
