"""The doctor's judgement of installations made up by hand, and what it reads of this one."""

from __future__ import annotations

import json
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from doctor import installation
from doctor import machine as machine_module
from doctor.diagnosis import BROKEN, ERROR, FINE, NOTE, WARNING, Diagnosis, as_json, as_text, exit_code
from doctor.machine import (
    Machine,
    blocked_by,
    geoid_path,
    is_address_here,
    kernels_missing,
    look_at,
    masters,
    requirements,
)
from kernel_cache.folders import folder_for

ROOT = Path(__file__).resolve().parents[4]
ROS = {"ROS_MASTER_URI": "http://localhost:11311"}
WELL = Machine(
    root="/ws",
    python="/ws/.venv",
    python_wanted={"numpy": "1.26.4"},
    python_found={"numpy": "1.26.4"},
    md5_wanted={"mavros_msgs/State": "65cd"},
    md5_found={"mavros_msgs/State": "65cd"},
    hosts={"localhost": True, "box": True},
    ros=ROS,
)


def test_an_installation_that_is_well_has_no_finding():
    assert installation.check(WELL) == []


def with_ros(**variables):
    return {"ros": {**ROS, **variables}}


CASES = {
    "another python": ({"python": "/usr"}, WARNING, "python", "not the workspace's"),
    "package missing": ({"python_found": {}}, ERROR, "python package numpy", "is not installed"),
    "another version": ({"python_found": {"numpy": "2.0"}}, WARNING, "python package numpy", "is 2.0"),
    "debian package missing": ({"debian_missing": ("rviz",)}, ERROR, "package rviz", "is not installed"),
    "package of the tests missing": (
        {"only_tests_miss": ("chromium-headless-shell",)},
        NOTE,
        "package chromium-headless-shell",
        "only the tests need it",
    ),
    "foreign numpy": (
        {"shadowed": {"/opt/tool": ("numpy",)}},
        ERROR,
        "/opt/tool",
        "Python takes its numpy in place of .venv's",
    ),
    "ROS_IP of another machine": (
        {**with_ros(ROS_IP="192.0.2.7"), "ros_ip_is_here": False},
        ERROR,
        "ROS_IP",
        "192.0.2.7 is no address of this machine",
    ),
    "no room for logs": ({"ros_home": "/small/log", "ros_home_free_mb": 3}, ERROR, "/small/log", "only 3 MB"),
    "no folder for logs": (
        {"ros_home": "/a/file/log", "ros_home_blocked_by": "/a/file", "ros_home_free_mb": 0},
        ERROR,
        "/a/file/log",
        "no folder that ROS can write its logs in, because of /a/file",
    ),
    "no models": ({"models_gone": ("/models",)}, WARNING, "/models", "does not exist"),
    "another platform": ({"platform_known": False}, WARNING, "platform", "neither Debian 12 nor 13"),
    "not built": ({"built": False}, ERROR, "/ws", "is not built"),
    "not sourced": ({"sourced": False}, ERROR, "CMAKE_PREFIX_PATH", "does not know"),
    "message not built": ({"md5_found": {}}, ERROR, "message mavros_msgs/State", "is not built"),
    "no rqt": ({"upstream": ("mavros", "mavros_extras")}, NOTE, "rqt_reconfigure", "not in this environment"),
    "no real MAVROS": ({"upstream": ("rqt_reconfigure",), "geoid_found": False}, NOTE, "mavros", "stand-in"),
    "MAVROS without mavros_extras": (
        {"upstream": ("rqt_reconfigure", "mavros")},
        NOTE,
        "mavros_extras",
        "takes no external poses",
    ),
    "MAVROS without geoid": (
        {"geoid": "/usr/share/GeographicLib/geoids/egm96-5.pgm", "geoid_found": False},
        ERROR,
        "/usr/share/GeographicLib/geoids/egm96-5.pgm",
        "ends at once",
    ),
    "message differs": (
        {"md5_found": {"mavros_msgs/State": "0000"}},
        ERROR,
        "message mavros_msgs/State",
        "0000",
    ),
    "no kernels": ({"kernels_missing": ("cepa",)}, NOTE, "library cepa", "first launch with them does it"),
    "disk full": ({"free_disk_mb": 20}, WARNING, "/ws", "20 MB of disk"),
    "memory full": ({"free_memory_mb": 200}, WARNING, "memory", "200 MB"),
    "no localhost": ({"hosts": {"localhost": False}}, ERROR, "localhost", "does not resolve"),
    "no own name": ({"hosts": {"localhost": True, "box": False}}, ERROR, "box", "does not resolve"),
    "no master": ({"ros": {}}, ERROR, "ROS_MASTER_URI", '"" is not of the form'),
    "bad master": (with_ros(ROS_MASTER_URI="localhost:11311"), ERROR, "ROS_MASTER_URI", "not of the form"),
    "bad port": (with_ros(ROS_MASTER_URI="http://localhost:x/"), ERROR, "ROS_MASTER_URI", "not of the form"),
    "ROS_IP is a name": (with_ros(ROS_IP="box"), ERROR, "ROS_IP", '"box" is not an address'),
    "ROS_IP and ROS_HOSTNAME": (
        with_ros(ROS_IP="10.0.0.2", ROS_HOSTNAME="box"),
        NOTE,
        "ROS_IP",
        "set as well",
    ),
    "unreachable": (
        with_ros(ROS_MASTER_URI="http://uav:11311", ROS_IP="127.0.0.1"),
        ERROR,
        "ROS_IP",
        "nobody there finds",
    ),
    "underlay gone": ({"underlays_gone": ("/old/devel",)}, WARNING, "underlay /old/devel", "does not exist"),
    "underlay new": (
        {"underlays_new": ("/mavros/devel",)},
        WARNING,
        "underlay /mavros/devel",
        "was not when",
    ),
    "messages twice": (
        {"messages_twice": ("mavros_msgs",)},
        WARNING,
        "package mavros_msgs",
        "in an underlay",
    ),
    "second master": (
        {"masters": (11311, 11411)},
        NOTE,
        "ROS_MASTER_URI",
        "another ROS master runs at http://localhost:11411",
    ),
    "master on another port": (
        {"masters": (11411,)},
        WARNING,
        "ROS_MASTER_URI",
        "no ROS master runs at http://localhost:11311, but one at http://localhost:11411",
    ),
}


@pytest.mark.table("case", CASES)
def test_what_is_broken_is_found(case):
    changes, severity, where, what = CASES[case]
    found = installation.check(replace(WELL, **changes))
    assert [(one.severity, one.where) for one in found] == [(severity, where)]
    assert what in found[0].what
    assert found[0].remedy


@pytest.mark.table("case", ["foreign numpy", "not built", "not sourced"])
def test_what_hides_all_messages_is_told_alone(case):
    """With a foreign numpy 67 messages were "not built", and a set-up would not have helped."""
    changes, _, where, _ = CASES[case]
    found = installation.check(replace(WELL, **changes, md5_found={}))
    assert [one.where for one in found] == [where]


def test_ros_ip_makes_up_for_a_name_that_does_not_resolve():
    hosts = {"localhost": True, "box": False}
    assert installation.check(replace(WELL, hosts=hosts, **with_ros(ROS_IP="127.0.0.1"))) == []


def test_requirements_are_read_without_comments():
    text = "# why ruff==1\nnumpy==1.26.4\nembreex==4.4.0.post1  # rays\n\ntqdm==4.67.1\n"
    assert requirements(text) == {"numpy": "1.26.4", "embreex": "4.4.0.post1", "tqdm": "4.67.1"}


MARKED = """numpy==1.26.4; python_version < "3.13"  # of the distribution's series
numpy==2.2.6; python_version >= "3.13"
pybullet==3.2.7; python_version < "3.12"
pybullet-arm64==3.2.8; python_version >= "3.12"
tqdm==4.67.1
"""


@pytest.mark.table(
    ("python", "wanted"),
    [
        ("3.11", {"numpy": "1.26.4", "pybullet": "3.2.7", "tqdm": "4.67.1"}),
        ("3.12", {"numpy": "1.26.4", "pybullet-arm64": "3.2.8", "tqdm": "4.67.1"}),
        ("3.13", {"numpy": "2.2.6", "pybullet-arm64": "3.2.8", "tqdm": "4.67.1"}),
    ],
)
def test_requirements_are_those_of_the_python(python, wanted):
    assert requirements(MARKED, python) == wanted


def test_this_machine_can_be_looked_at(monkeypatch):
    monkeypatch.setenv("ROS_MASTER_URI", "http://nowhere:1")
    machine = look_at(ROOT, {}, {})
    assert machine.root == str(ROOT)
    assert machine.ros["ROS_MASTER_URI"] == "http://nowhere:1"
    pinned = (ROOT / "requirements.txt").read_text(encoding="utf-8")
    assert all(f"{name}=={version}" in pinned for name, version in machine.python_wanted.items())
    assert {"numpy", "scipy", "numba"} <= set(machine.python_wanted)
    assert machine.python_found["pytest"]
    assert machine.free_disk_mb > 0


def test_folders_that_the_environment_names_are_looked_at(monkeypatch, tmp_path):
    (tmp_path / "numpy").mkdir()
    monkeypatch.setenv("PYTHONPATH", f"{tmp_path}:{tmp_path}/none")
    monkeypatch.setenv("GAZEBO_MODEL_PATH", f"{tmp_path}:{tmp_path}/none")
    monkeypatch.setenv("ROS_HOME", f"{tmp_path}/not/made/yet")
    monkeypatch.delenv("ROS_LOG_DIR", raising=False)
    machine = look_at(ROOT, {}, {})
    assert machine.shadowed == {str(tmp_path): ("numpy",)}
    assert machine.models_gone == (f"{tmp_path}/none",)
    assert machine.ros_home == f"{tmp_path}/not/made/yet/log"
    assert 0 < machine.ros_home_free_mb < 1_000_000_000
    assert not machine.ros_home_blocked_by


def test_a_file_is_no_folder_for_logs(tmp_path):
    (tmp_path / "file").touch()
    assert blocked_by(tmp_path / "file" / "log") == f"{tmp_path}/file"
    assert blocked_by(tmp_path / "not/made/yet") == ""


@pytest.mark.table(
    ("address", "here"),
    [("127.0.0.1", True), ("192.0.2.7", False), ("", True), ("box", True)],
)
def test_an_address_is_here_if_a_node_can_bind_it(address, here):
    # RFC 5737: 192.0.2.0/24 is nobody's
    assert is_address_here(address) == here


def test_a_package_of_the_tests_alone_is_no_error(monkeypatch, tmp_path):
    (tmp_path / "scripts/packages").mkdir(parents=True)
    (tmp_path / "requirements.txt").touch()
    listed = "no-such-a\n\n# Only for the tests: `./bringup.sh test` installs it.\nno-such-b\n"
    (tmp_path / "scripts/packages/some-1.txt").write_text(listed)
    monkeypatch.setattr(machine_module, "_platform", lambda: "some-1")
    machine = look_at(tmp_path, {}, {})
    assert (machine.debian_missing, machine.only_tests_miss) == (("no-such-a",), ("no-such-b",))


FINDINGS = [
    Diagnosis(NOTE, "/c", "is odd", "Look"),
    Diagnosis(ERROR, "/a", "is dead", "rosrun it"),
    Diagnosis(WARNING, "/b", "is slow", "Wait"),
]


def test_a_line_per_finding_the_worst_first():
    assert as_text(FINDINGS, "3 nodes").splitlines() == [
        "error   /a: is dead. -> rosrun it",
        "warning /b: is slow. -> Wait",
        "note    /c: is odd. -> Look",
        "Examined: 3 nodes. 1 error, 1 warning, 1 note.",
    ]
    assert as_text([], "3 nodes") == "Examined: 3 nodes. Nothing is wrong."


def test_machines_read_the_same():
    content = json.loads(as_json(FINDINGS, "3 nodes"))
    assert content["exit_code"] == exit_code(FINDINGS) == BROKEN
    assert content["findings"][0] == {
        "severity": "error",
        "where": "/a",
        "what": "is dead",
        "remedy": "rosrun it",
    }
    assert exit_code(FINDINGS[2:]) == FINE


@pytest.mark.table(
    ("environment", "folder"),
    [
        ({}, "/usr/share/GeographicLib/geoids"),
        ({"GEOGRAPHICLIB_DATA": "/data"}, "/data/geoids"),
        ({"GEOGRAPHICLIB_DATA": "/data", "GEOGRAPHICLIB_GEOID_PATH": "/own"}, "/own"),
    ],
)
def test_the_geoid_is_looked_for_where_geographiclib_looks(environment, folder):
    assert str(geoid_path(environment)) == f"{folder}/egm96-5.pgm"


def test_programs_of_an_underlay_are_found(monkeypatch, tmp_path):
    program = tmp_path / "lib/mavros/mavros_node"
    program.parent.mkdir(parents=True)
    program.touch()
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"/nowhere:{tmp_path}")
    monkeypatch.setenv("GEOGRAPHICLIB_GEOID_PATH", str(tmp_path))
    seen = look_at(ROOT, {}, {})
    assert seen.upstream == ("mavros",)
    assert not seen.geoid_found
    (tmp_path / "egm96-5.pgm").touch()
    assert look_at(ROOT, {}, {}).geoid_found


def test_underlays_are_compared_with_those_of_the_build(monkeypatch, tmp_path):
    root, old, new = (tmp_path / name for name in ("ws", "old/devel", "new/devel"))
    (root / "devel/share/mavros_msgs").mkdir(parents=True)
    (new / "share/mavros_msgs").mkdir(parents=True)
    (root / "requirements.txt").touch()
    # As catkin writes it
    (root / "devel/_setup_util.py").write_text(f"            CMAKE_PREFIX_PATH = r'{old};/usr'.split(';')\n")
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{root}/devel:{new}")
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:11311")
    machine = look_at(root, {}, {})
    assert machine.underlays_gone == (str(old),)
    assert machine.underlays_new == (str(new),)
    assert machine.messages_twice == ("mavros_msgs",)
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{new}:{root}/devel:/usr")  # a workspace over this one is fine
    assert look_at(root, {}, {}).underlays_new == ()


def test_a_shell_that_knows_the_installed_workspace_knows_it_and_has_no_underlay(monkeypatch, tmp_path):
    for space in ("devel", "install"):
        (tmp_path / space / "share/mavros_msgs").mkdir(parents=True)
    (tmp_path / "requirements.txt").touch()
    monkeypatch.setenv("CMAKE_PREFIX_PATH", f"{tmp_path}/install:/usr")
    monkeypatch.setenv("ROS_MASTER_URI", "http://localhost:11311")
    machine = look_at(tmp_path, {}, {})
    assert machine.sourced
    assert machine.underlays_gone == machine.messages_twice == ()


def test_masters_of_this_machine_are_found(processes, tmp_path):
    """A process whose command line is that of a master, as roscore starts it."""
    program = tmp_path / "rosmaster"
    program.write_text("import time; print('up', flush=True); time.sleep(60)")
    started = processes.start(
        "/usr/bin/python3", str(program), "--core", "-p", "54321", stdout=subprocess.PIPE
    )
    started.stdout.readline()
    assert 54321 in masters()


@pytest.mark.table("is_given", [True, False])
def test_each_librarys_own_kernels_are_looked_for(is_given, tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "users"))
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    if is_given:
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path / "given"))
    for name, folder in (("one", "src"), ("other", "src/extensions")):
        library = tmp_path / folder / name / "src" / name
        library.mkdir(parents=True)
        (library / "__init__.py").touch()
        (library / "warm_up.py").touch()
        (library / "kernel.py").write_text("@njit(cache=True)\ndef kernel(): ...\n")
    assert kernels_missing(tmp_path) == ("one", "other")
    folder = folder_for(library / "kernel.py")
    (folder / "kernel.nbi").touch()
    assert kernels_missing(tmp_path) == ("one",)
