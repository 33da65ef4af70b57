"""The set-up builds upon another workspace's MAVROS, whether that was there before or came later."""

from __future__ import annotations

import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
# catkin_make leaves what it has built before, and builds what it is not told to leave out
CATKIN = """
finish_venv() { :; }
run_step() {
  local package words="$*"
  local leave_out=${words#*BLACKLIST_PACKAGES=}
  leave_out=";${leave_out%% -D*};"
  echo "built upon ${CMAKE_PREFIX_PATH:-nothing}"
  mkdir -p build devel/share
  echo "$words" >build/command
  for package in mavros_msgs gazebo_msgs; do
    [[ $leave_out == *";$package;"* ]] || mkdir -p "devel/share/$package"
  done
  echo "            CMAKE_PREFIX_PATH = r'${CMAKE_PREFIX_PATH//:/;}'.split(';')" >devel/_setup_util.py
}
"""


class Workspace:
    """A folder as after a clone, and another workspace with MAVROS's messages."""

    def __init__(self, folder):
        self.root, self.underlay = folder / "ws", folder / "upstream_ws/devel"
        (self.root / "src").mkdir(parents=True)
        (self.root / "src/CMakeLists.txt").touch()
        for package in ("geographic_msgs", "gazebo_msgs", "mavros_msgs", "octomap_msgs", "trajectory_msgs"):
            (self.root / "src/interfaces" / package).mkdir(parents=True)
        (self.underlay / "share/mavros_msgs/cmake").mkdir(parents=True)

    def set_up(self, *sourced):
        """Call the set-up's last steps in a new shell that knows these workspaces; returns what is said."""
        script = f"""
set -euo pipefail
root={self.root} log_file=/dev/null
cd "$root"
source {ROOT}/scripts/console.sh
source {ROOT}/scripts/setup.sh
{CATKIN}
load_underlay
build_workspace
"""
        environment = {"PATH": "/usr/bin:/bin", "CMAKE_PREFIX_PATH": ":".join(map(str, sourced))}
        done = subprocess.run(
            ["bash", "-c", script], env=environment, stdout=subprocess.PIPE, text=True, check=True
        )
        return done.stdout

    @property
    def messages(self):
        """Those of its own that a node would find first."""
        return sorted(path.name for path in (self.root / "devel/share").iterdir())

    @property
    def hidden(self):
        """Subsets that rospack and rosmsg do not find."""
        return [path.parent.name for path in self.root.glob("src/interfaces/*/CATKIN_IGNORE")]


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path)


def test_without_an_underlay_the_subsets_are_built_once(workspace):
    assert "built upon" in workspace.set_up()
    assert workspace.messages == ["gazebo_msgs", "mavros_msgs"]
    assert workspace.set_up() == ""


def test_what_no_other_package_needs_is_built_alone(workspace):
    workspace.set_up()
    (workspace.root / "build/CMakeCache.txt").write_text(
        f"CMAKE_HOME_DIRECTORY:INTERNAL={workspace.root}/src\n"
    )
    mine = workspace.root / "src/mine"
    (mine / "nodes").mkdir(parents=True)
    (mine / "package.xml").write_text("<package><name>mine</name></package>")
    command = workspace.root / "build/command"
    workspace.set_up()
    assert command.read_text().endswith("build_alone src/mine\n")
    assert workspace.set_up() == ""
    (mine / "nodes/flyer").touch()
    command.unlink()
    workspace.set_up()
    assert command.read_text().endswith("build_alone src/mine\n")
    # Whoever depends on what has changed is built again, too
    other = workspace.root / "src/other"
    other.mkdir()
    (other / "package.xml").write_text("<package><name>other</name><depend>mine</depend></package>")
    workspace.set_up()
    assert command.read_text().endswith("build_alone src/other\n")
    (mine / "A.msg").touch()
    workspace.set_up()
    assert "catkin_make" in command.read_text()


def test_both_catkins_are_told_the_interpreter_of_the_nodes(workspace):
    """FindPythonInterp of Debian 12's catkin reads PYTHON_EXECUTABLE, FindPython of Debian 13's the other."""
    workspace.set_up()
    command = (workspace.root / "build/command").read_text().split()
    for name in ("PYTHON_EXECUTABLE", "Python_EXECUTABLE"):
        assert f"-D{name}={workspace.root}/devel/interpreter/python3" in command


def test_an_underlay_that_comes_later_takes_the_place_of_the_subset(workspace):
    workspace.set_up()
    assert "the machine's own mavros_msgs" in workspace.set_up(workspace.underlay)
    assert workspace.messages == ["gazebo_msgs"]
    assert workspace.hidden == ["mavros_msgs"]
    assert workspace.set_up(workspace.root / "devel", workspace.underlay) == ""


def test_a_new_shell_stays_upon_the_underlay(workspace):
    workspace.set_up(workspace.underlay)
    assert workspace.set_up() == ""
    (workspace.root / "src/package.xml").touch()  # something to build
    assert f"built upon {workspace.underlay}" in workspace.set_up()
    assert workspace.messages == ["gazebo_msgs"]


def test_when_the_underlay_is_deleted_the_subset_is_back(workspace):
    workspace.set_up(workspace.underlay)
    workspace.underlay.rename(workspace.underlay.with_name("gone"))
    assert workspace.hidden == ["mavros_msgs"]
    workspace.set_up()
    assert workspace.messages == ["gazebo_msgs", "mavros_msgs"]
    assert workspace.hidden == []
