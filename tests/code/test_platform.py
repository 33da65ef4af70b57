"""Where the set-up runs: what cannot work ends with one sentence, before anything is changed."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
SCRIPT = """
set -euo pipefail
cd "$root"
log_file=/dev/null
source "$repository/scripts/console.sh"
source "$repository/scripts/setup.sh"
uname() { echo "${chip:-x86_64}"; }
df() { printf 'Filesystem 1M-blocks Used Available\\ndisk 9 9 %s\\n' "${free_mb:-99999}"; }
apt-cache() { [[ $1 == pkgnames ]] && echo "$known" | tr ' ' '\\n' || [[ " ${known:-} " == *" $2 "* ]]; }
missing_packages() { echo g++; }
wanted_until=
"""
PYTHON = """#!/bin/sh
case $1 in
  --version) echo "Python {version}" ;;
  -c) exit {rospy} ;;
esac
"""


class Workspace:
    """A folder as after a clone, on a machine that is told by a few values."""

    def __init__(self, folder: Path) -> None:
        self.root, self._machine = folder / "ws", folder
        (self.root / "scripts").mkdir(parents=True)
        (self.root / "scripts/packages").symlink_to(ROOT / "scripts/packages")
        (self.root / "requirements.txt").symlink_to(ROOT / "requirements.txt")
        (folder / "bin").mkdir()
        self.runs("debian", "13", "3.13.5")

    def runs(self, name: str, release: str, python: str | None, like: str = "", rospy: bool = False) -> None:
        """Say what system this is. python: None on a bare one. rospy: its interpreter finds one of /opt."""
        text = f'ID={name}\nVERSION_ID="{release}"\nID_LIKE="{like}"\n'
        (self._machine / "os-release").write_text(text)
        interpreter = self._machine / "bin/python3"
        interpreter.unlink(missing_ok=True)
        if python:
            interpreter.write_text(PYTHON.format(version=python, rospy=int(not rospy)))
            interpreter.chmod(0o755)

    def has_venv(self, version: str, numpy: str = "own", home: str | None = None) -> None:
        """Put a .venv into the folder, as a finished set-up leaves it."""
        packages = self.root / f".venv/lib/python{'.'.join(version.split('.')[:2])}/site-packages"
        packages.mkdir(parents=True)
        home = home or str(self._machine / "bin")
        (self.root / ".venv/pyvenv.cfg").write_text(f"home = {home}\nversion = {version}\n")
        (self.root / ".venv/.bringup").touch()
        (self.root / "devel").mkdir()
        if numpy == "own":
            (packages / "numpy").mkdir()
        elif numpy == "linked":
            (packages / "numpy").symlink_to("/usr/lib/python3/dist-packages/numpy")

    def call(self, command: str, **machine: str) -> subprocess.CompletedProcess:
        environment = {
            "PATH": "/usr/bin:/bin",
            "root": str(self.root),
            "repository": str(ROOT),
            "os_release": str(self._machine / "os-release"),
            "system_python": str(self._machine / "bin/python3"),
            **machine,
        }
        before = self._files()
        done = subprocess.run(
            ["bash", "-c", SCRIPT + command], env=environment, capture_output=True, text=True, check=False
        )
        if done.returncode:
            assert self._files() == before, "it changed something before it gave up"
        return done

    def _files(self) -> list[str]:
        return sorted(str(Path(at, name)) for at, _, names in os.walk(self.root) for name in names)


@pytest.fixture
def workspace(tmp_path):
    return Workspace(tmp_path)


def refusal(done: subprocess.CompletedProcess) -> str:
    """Return the sentence with which the set-up ended."""
    assert done.returncode == 1, done.stdout + done.stderr
    first, *more = done.stderr.splitlines()
    assert first.startswith("bringup: ")
    assert first.endswith(".")
    assert all("docker run" in line for line in more), more
    return first


@pytest.mark.parametrize(("release", "python"), [("12", "3.11.2"), ("13", "3.13.5"), ("13", None)])
def test_the_tested_systems_go_on_silently(workspace, release, python):
    workspace.runs("debian", release, python)
    done = workspace.call('detect_platform; echo "$platform of $package_list"')
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == f"debian-{release} of scripts/packages/debian-{release}.txt\n"


@pytest.mark.parametrize("processor", ["aarch64", "armv7l", "riscv64"])
def test_another_processor_is_refused(workspace, processor):
    sentence = refusal(workspace.call("detect_platform", chip=processor))
    for word in (processor, "pybullet, embreex and pyoctomap", "doc/platforms.md"):
        assert word in sentence


@pytest.mark.parametrize(("release", "python", "needed"), [("12", "3.9.2", "3.11"), ("13", "3.11.2", "3.13")])
def test_an_interpreter_that_is_not_the_distributions_is_refused(workspace, release, python, needed):
    workspace.runs("debian", release, python)
    sentence = refusal(workspace.call("detect_platform"))
    for words in (
        f"python3 is Python {python[:-2]}, and",
        f"the ROS of debian-{release} needs Python {needed}",
    ):
        assert words in sentence


def test_another_interpreter_on_the_path_is_named_and_not_taken(workspace, tmp_path):
    first = tmp_path / "pyenv"
    first.mkdir()
    (first / "python3").write_text(PYTHON.format(version="3.9.1", rospy=1))
    (first / "python3").chmod(0o755)
    done = workspace.call("name_other_python", caller_path=f"{first}:/usr/bin:/bin")
    assert f"{first}/python3, Python 3.9" in done.stdout
    assert "Python 3.13, which knows ROS" in done.stdout
    same = workspace.call("name_other_python", caller_path=f"{tmp_path}/bin:/usr/bin:/bin")
    assert same.stdout == ""


def test_a_full_disk_is_refused(workspace):
    sentence = refusal(workspace.call("detect_platform; check_disk; remove_bad_venv", free_mb="900"))
    assert "Not enough disk" in sentence
    assert "900 MB left" in sentence


# -- .venv -------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("venv", "why"),
    [
        (("3.11.2",), "was made by Python 3.11 of"),
        (("3.13.5", "own", "/root/.pyenv/versions/3.13.5/bin"), "of /root/.pyenv/versions/3.13.5/bin, and"),
        (("3.13.5", "none"), "has no numpy of its own"),
        (("3.13.5", "linked"), "has no numpy of its own"),
    ],
)
def test_a_venv_that_cannot_be_kept_is_named_then_made_anew(workspace, venv, why):
    workspace.has_venv(*venv)
    done = workspace.call("detect_platform; remove_bad_venv")
    assert done.stdout.startswith("bringup: .venv ")
    assert why in done.stdout
    assert done.stdout.count("\n") == 1
    assert not (workspace.root / ".venv").exists()
    assert not (workspace.root / "devel").exists()


def test_a_good_venv_stays(workspace):
    workspace.has_venv("3.13.5")
    done = workspace.call("detect_platform; remove_bad_venv")
    assert (done.returncode, done.stdout + done.stderr) == (0, "")
    assert (workspace.root / "devel").exists()


def test_a_disk_without_room_for_a_new_venv_leaves_the_old_one(workspace):
    workspace.has_venv("3.11.2")
    refusal(workspace.call("detect_platform; check_disk; remove_bad_venv", free_mb="900"))


# -- systems that nobody has tested ------------------------------------------------------------------------


def test_an_untested_system_with_rospy_is_tried_with_a_warning(workspace):
    workspace.runs("ubuntu", "24.04", "3.12.3", like="debian")
    tell = 'detect_platform; listed_packages | tr "\\n" " "'
    done = workspace.call(tell, known="python3-rospy g++ make rviz chromium")
    assert done.returncode == 0, done.stderr
    warning, packages = done.stdout.split("\n")
    assert "warning: this is ubuntu 24.04, which is not tested" in warning
    assert packages.split() == ["g++", "make", "python3-rospy", "rviz"]


def test_ros_from_elsewhere_stays_alone(workspace):
    workspace.runs("ubuntu", "24.04", "3.12.3", like="debian", rospy=True)
    known = "python3-rospy python3-tf2-ros libstd-msgs-dev ros-std-msgs catkin rviz g++ python3-venv xvfb"
    done = workspace.call('detect_platform; listed_packages | tr "\\n" " "', known=known)
    assert done.stdout.split("\n")[1].split() == ["g++", "python3-venv", "xvfb"]


@pytest.mark.parametrize(
    ("system", "known", "why"),
    [
        (("fedora", "43", "3.13.1"), "python3-rospy", "needs Debian's packages"),
        (("ubuntu", "24.04", "3.12.3", "debian"), "g++", "finds no rospy"),
        (("ubuntu", "22.04", "3.10.12", "debian"), "python3-rospy", "with Python 3.10"),
        (("debian", "14", "3.14.1"), "python3-rospy", "with Python 3.14"),
    ],
)
def test_an_untested_system_that_cannot_work_is_refused(workspace, system, known, why):
    workspace.runs(*system)
    sentence = refusal(workspace.call("detect_platform", known=known))
    assert why in sentence
    assert "doc/platforms.md" in sentence


# -- the lists ---------------------------------------------------------------------------------------------


def test_the_lists_of_both_releases_differ_only_where_debian_does():
    lists = [(ROOT / f"scripts/packages/debian-{n}.txt").read_text().splitlines() for n in (12, 13)]
    twelve, thirteen = ({line for line in lines if not line.startswith("#")} for lines in lists)
    assert twelve - thirteen == {"ignition-tools", "libsdformat-dev", "sdformat-sdf", "python3-rviz"}
    assert thirteen - twelve == {"ros-environment"}
