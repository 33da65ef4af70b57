"""The layers of the workspace: libraries know no ROS, tool packages not each other (thesis, 9.2.2).

A package's library is `src/<package>/`; what its nodes share stands in a package of its own, `<package>_ros`.
`node_tools` is the one leaf that all nodes may use, and it uses none of ours.
"""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from python_sources import dotted_imports, folder_of, imports, packages, python_nodes

ROOT = Path(__file__).resolve().parents[2]

PACKAGES = packages()
EDGE = "node_tools"
TOOLS = {"simulation_tools", "inspection_tools", "cepa", "gridslam"}
ROOMS = {
    "flights": (
        {"errors", "files"},
        {"baselines", "graph", "worlds"},
        {"flight", "photographing"},
        {"results"},
        {"launch_arguments", "trials"},
        {"exploring", "goal_flight", "mapping"},
        {"campaign", "inspecting"},
    ),
    "master_thesis": (
        {"report"},
        {"experiment_1", "experiment_2", "experiments_3_4", "exploring", "measurements"},
        {"chapter_8"},
    ),
}
"""By library: its floors, the lowest first."""
ROS = re.compile(
    r"(rospy|roslib|ros(bag|graph|launch|lib|master|msg|node|param|pkg|service|test|topic|unit)|tf|tf2_\w+"
    r"|\w+_msgs|std_srvs|genpy|genmsg|dynamic_reconfigure|message_filters|actionlib|cv_bridge|node_tools)$"
)


def test_libraries_import_no_ros():
    libraries = [package / "src" / package.name for package in PACKAGES if package.name != EDGE]
    files = [path for library in libraries for path in library.rglob("*.py")]
    assert len(files) > 500
    found = {(str(path), name) for path in files for name in imports(path) if ROS.match(name)}
    assert not found, "move that to nodes/ or ros/"


def test_tool_packages_do_not_import_each_other():
    for package in TOOLS:
        sources = [path for path in folder_of(package).rglob("*.py") if "test" not in path.parts]
        sources += python_nodes(folder_of(package))
        others = TOOLS - {package} | {"flights", "doctor", "master_thesis"}
        assert not {(path.name, name) for path in sources for name in imports(path) if name in others}


def test_the_edge_to_ros_knows_none_of_ours():
    ours = {path.name for path in PACKAGES} - {EDGE}
    found = {(path.name, name) for path in folder_of(EDGE).glob("src/**/*.py") for name in imports(path)}
    assert found
    assert not {
        (file, name) for file, name in found if name in ours or (name.endswith("_ros") and name != "tf2_ros")
    }


@pytest.mark.parametrize(
    ("package", "some"),
    [
        ("flights", {("flight", "worlds"), ("results", "flight")}),
        ("master_thesis", {("experiment_1", "report"), ("chapter_8", "measurements")}),
    ],
)
def test_no_room_imports_one_above_it_or_beside_it(package, some):
    """A room that is not in `ROOMS` yet needs a place there."""
    floor_of = {room: floor for floor, rooms in enumerate(ROOMS[package]) for room in rooms}
    library = folder_of(package) / "src" / package
    found = set()
    for path in library.rglob("*.py"):
        room = path.relative_to(library).with_suffix("").parts[0]
        used = {name.split(".")[1] for name in dotted_imports(path) if name.startswith(f"{package}.")}
        found |= {(room, other) for other in used - {room}}
    assert some <= found
    assert not {(room, other) for room, other in found if floor_of[other] >= floor_of[room]}


@pytest.mark.parametrize("package", sorted({*TOOLS, "exploration", "inspection", "doctor"}))
def test_no_rooms_of_a_library_import_each_other_in_a_circle(package):
    """A room is a folder or a file of the library. From the ground up, each needs only rooms below it."""
    library = folder_of(package) / "src" / package
    parts = {path: path.relative_to(library).with_suffix("").parts[0] for path in library.rglob("*.py")}
    needs = {room: set() for room in parts.values()}
    for path, room in parts.items():
        used = {name.split(".")[1] for name in dotted_imports(path) if name.startswith(f"{package}.")}
        needs[room] |= (used & needs.keys()) - {room}
    assert len(needs) > 3
    outside = {None}
    while outside:  # without rooms that need none, and rooms that none needs, only circles remain
        needs = {room: others & needs.keys() for room, others in needs.items()}
        needed = set().union(*needs.values())
        outside = {room for room, others in needs.items() if not others or room not in needed}
        needs = {room: others for room, others in needs.items() if room not in outside}
    assert not needs


def test_the_rule_finds_ros():
    """The tests above can fail: in each package there are nodes that import ROS."""
    for package in TOOLS:
        assert any(ROS.match(name) for node in python_nodes(folder_of(package)) for name in imports(node)), (
            package
        )
