"""Checks an installation: is everything there that `bringup.sh` installs, and do nodes find each other?"""

from __future__ import annotations

import os.path
import re
from typing import Iterator
from urllib.parse import urlparse

from doctor.diagnosis import ERROR, NOTE, WARNING, Diagnosis
from doctor.machine import Machine

SETUP = "Call ./bringup.sh setup"
DISK_FOR_LOGS_MB = 50
DISK_FOR_A_RUN_MB, MEMORY_FOR_A_RUN_MB = 500, 800
"""A recorded experiment leaves up to 200 MB; the graph of Experiment 1 takes 540 MB."""


def check(machine: Machine) -> list[Diagnosis]:
    """Return all diagnoses about an installation."""
    checks = (
        *(python_packages, python_path, debian_packages, build, underlays, messages, kernels),
        *(room, models, names, address, master, other_masters, upstream),
    )
    return [diagnosis for one in checks for diagnosis in one(machine)]


def python_packages(machine: Machine) -> Iterator[Diagnosis]:
    """Check .venv against requirements.txt."""
    if os.path.realpath(machine.python) != os.path.realpath(f"{machine.root}/.venv"):
        yield Diagnosis(
            WARNING,
            "python",
            f"this is the interpreter of {machine.python}, not the workspace's .venv",
            SETUP,
        )
    for name, version in machine.python_wanted.items():
        found = machine.python_found.get(name)
        if found is None:
            yield Diagnosis(ERROR, f"python package {name}", "is not installed", SETUP)
        elif found.split("+")[0] != version:
            what = f"is {found}, and requirements.txt says {version}"
            yield Diagnosis(WARNING, f"python package {name}", what, f"Delete .venv/.bringup. {SETUP}")


def python_path(machine: Machine) -> Iterator[Diagnosis]:
    """Check PYTHONPATH for packages that Python takes in place of those of .venv."""
    for folder, packages in machine.shadowed.items():
        what = f"PYTHONPATH names it, and Python takes its {' and '.join(packages)} in place of .venv's"
        yield Diagnosis(ERROR, folder, what, "Open a shell whose PYTHONPATH lacks this folder")


def debian_packages(machine: Machine) -> Iterator[Diagnosis]:
    """Check the distribution's packages against scripts/packages."""
    if not machine.platform_known:
        yield Diagnosis(WARNING, "platform", "is neither Debian 12 nor 13", "Use a container of debian:13")
    for name in machine.debian_missing:
        yield Diagnosis(
            ERROR,
            f"package {name}",
            "is not installed",
            f"sudo apt-get install --no-install-recommends {name}",
        )
    for name in machine.only_tests_miss:
        what = "is not installed; only the tests need it"
        yield Diagnosis(NOTE, f"package {name}", what, "./bringup.sh test installs it")


def build(machine: Machine) -> Iterator[Diagnosis]:
    """Check whether the workspace is built and in the environment."""
    if not machine.built:
        yield Diagnosis(ERROR, machine.root, "is not built", SETUP)
    elif not machine.sourced:
        remedy = f"source {machine.root}/devel/setup.bash"
        yield Diagnosis(ERROR, "CMAKE_PREFIX_PATH", "this shell does not know the workspace", remedy)


def underlays(machine: Machine) -> Iterator[Diagnosis]:
    """Check the workspaces below this one: is it built over those that are there?"""
    for path in machine.underlays_gone:
        what = "does not exist, and this workspace was built over it, or this shell names it"
        remedy = f"Open a new shell without it, delete {machine.root}/build and devel. {SETUP}"
        yield Diagnosis(WARNING, f"underlay {path}", what, remedy)
    for path in machine.underlays_new:
        what = "is below this workspace in this shell, but was not when it was built"
        yield Diagnosis(WARNING, f"underlay {path}", what, f"{SETUP} in this shell")
    for name in machine.messages_twice:
        what = "is built here and is in an underlay, too: nodes of both may have different messages"
        remedy = f"Delete {machine.root}/build and devel. {SETUP}"
        yield Diagnosis(WARNING, f"package {name}", what, remedy)


def messages(machine: Machine) -> Iterator[Diagnosis]:
    """Check the message types' md5sums. Only with upstream's can nodes talk to MAVROS and Gazebo.

    What keeps all messages from being read is a diagnosis of its own. Each of them would only hide it.
    """
    explained = bool(machine.shadowed) or not (machine.built and machine.sourced)
    for name, wanted in machine.md5_wanted.items():
        found = machine.md5_found.get(name)
        if found is None and explained:
            continue
        if found is None:
            yield Diagnosis(ERROR, f"message {name}", "is not built, or not in PYTHONPATH", SETUP)
        elif found != wanted:
            what = f"has the md5sum {found}, upstream's has {wanted}: clients of the other refuse to connect"
            yield Diagnosis(
                ERROR, f"message {name}", what, "Look in ROS_PACKAGE_PATH for another version of its package"
            )


def kernels(machine: Machine) -> Iterator[Diagnosis]:
    """Check numba's cache. A launch compiles what is missing, before it takes off."""
    for name in machine.kernels_missing:
        what = "its kernels are not compiled yet; the first launch with them does it, in up to a minute"
        yield Diagnosis(NOTE, f"library {name}", what, f"{SETUP}, to have it done now")


def room(machine: Machine) -> Iterator[Diagnosis]:
    """Check whether disk and memory suffice for a run and its bag."""
    if machine.free_disk_mb < DISK_FOR_A_RUN_MB:
        what = f"only {machine.free_disk_mb} MB of disk are free; a run with its bag takes up to 200"
        yield Diagnosis(WARNING, machine.root, what, "Delete old folders in results/")
    if machine.ros_home_blocked_by:
        what = f"is no folder that ROS can write its logs in, because of {machine.ros_home_blocked_by}"
        yield Diagnosis(ERROR, machine.ros_home, what, "Set ROS_HOME or ROS_LOG_DIR to a folder of yours")
    elif machine.ros_home_free_mb < DISK_FOR_LOGS_MB:
        what = f"only {machine.ros_home_free_mb} MB of disk are free, and roslaunch and all nodes log there"
        yield Diagnosis(
            ERROR, machine.ros_home, what, "rosclean purge, or set ROS_HOME to a folder with room"
        )
    if machine.free_memory_mb < MEMORY_FOR_A_RUN_MB:
        what = f"only {machine.free_memory_mb} MB are free, and the graph of an experiment takes 540"
        yield Diagnosis(WARNING, "memory", what, "End other programs")


def models(machine: Machine) -> Iterator[Diagnosis]:
    """Check the folders in which worlds look for their models."""
    for folder in machine.models_gone:
        what = "GAZEBO_MODEL_PATH names it, and it does not exist: models in it are not found"
        yield Diagnosis(WARNING, folder, what, "Correct GAZEBO_MODEL_PATH in this shell, or in ~/.bashrc")


def names(machine: Machine) -> Iterator[Diagnosis]:
    """Check whether the host names resolve that ROS nodes use as their addresses."""
    told = machine.ros.get("ROS_HOSTNAME") or machine.ros.get("ROS_IP")
    for name, resolves in machine.hosts.items():
        if resolves or (told and name not in ("localhost", told)):
            continue
        if name == "localhost":
            yield Diagnosis(
                ERROR, name, "does not resolve", 'echo "127.0.0.1 localhost" | sudo tee -a /etc/hosts'
            )
        else:
            what = "this machine's name does not resolve, and nodes give it as their address"
            yield Diagnosis(ERROR, name, what, "export ROS_IP=127.0.0.1")
    if machine.ros.get("ROS_HOSTNAME") and machine.ros.get("ROS_IP"):
        yield Diagnosis(NOTE, "ROS_IP", "ROS_HOSTNAME is set as well, and wins", "Unset one of them")
    ip = machine.ros.get("ROS_IP", "")
    if ip and not re.fullmatch(r"[0-9a-fA-F:.]+", ip):
        yield Diagnosis(
            ERROR,
            "ROS_IP",
            f'"{ip}" is not an address',
            "export ROS_IP=127.0.0.1, or set ROS_HOSTNAME instead",
        )


def address(machine: Machine) -> Iterator[Diagnosis]:
    """Check whether ROS_IP is this machine's: nodes give it to each other as their address."""
    told = machine.ros.get("ROS_IP", "")
    if told and not machine.ros.get("ROS_HOSTNAME") and not machine.ros_ip_is_here:
        what = f"{told} is no address of this machine: no node reaches another one"
        yield Diagnosis(ERROR, "ROS_IP", what, "export ROS_IP=127.0.0.1, or one of `ip -brief address`")


def master(machine: Machine) -> Iterator[Diagnosis]:
    """Check ROS_MASTER_URI, and whether a master elsewhere could reach the nodes here."""
    text = machine.ros.get("ROS_MASTER_URI", "")
    try:
        uri = urlparse(text)
        port, host = uri.port, uri.hostname
    except ValueError:
        uri, port, host = urlparse(""), None, None
    if uri.scheme != "http" or not host or not port:
        remedy = "export ROS_MASTER_URI=http://localhost:11311"
        yield Diagnosis(ERROR, "ROS_MASTER_URI", f'"{text}" is not of the form http://HOST:PORT/', remedy)
        return
    here = {"localhost", "127.0.0.1", "::1"}
    told = machine.ros.get("ROS_HOSTNAME") or machine.ros.get("ROS_IP", "")
    if host not in here and host not in machine.hosts and told in here:
        what = (
            f"the master is on {host}, and nodes here give {told} as their address: nobody there finds them"
        )
        yield Diagnosis(ERROR, "ROS_IP", what, f"Set it to this machine's address as seen from {host}")


def other_masters(machine: Machine) -> Iterator[Diagnosis]:
    """Check for masters on other ports of this machine: their nodes do not hear those of this shell."""
    address = machine.ros.get("ROS_MASTER_URI", "")
    here = re.fullmatch(r"http://(?:localhost|127\.0\.0\.1|\[::1\]):(\d+)/?", address)
    others = [port for port in machine.masters if here and port != int(here.group(1))]
    if not here or not others:
        return
    told = " and ".join(f"http://localhost:{port}" for port in others)
    if int(here.group(1)) in machine.masters:
        what = f"another ROS master runs at {told}: its nodes do not hear those of this one"
        yield Diagnosis(NOTE, "ROS_MASTER_URI", what, "Right for two flights at a time; else end one of both")
    else:
        what = f"no ROS master runs at {address}, but one at {told}"
        remedy = f"export ROS_MASTER_URI=http://localhost:{others[0]}"
        yield Diagnosis(WARNING, "ROS_MASTER_URI", what, remedy)


def upstream(machine: Machine) -> Iterator[Diagnosis]:
    """Note which optional programs, built from source, are installed. No flight needs them."""
    page = "See src/extensions/flights/doc/from_source.md"
    if "rqt_reconfigure" not in machine.upstream:
        what = "is not in this environment: tune by `rosrun dynamic_reconfigure dynparam` instead"
        yield Diagnosis(NOTE, "rqt_reconfigure", what, page)
    if "mavros" not in machine.upstream:
        what = "the real MAVROS is not in this environment: only the stand-in flies (mavros:=sim)"
        yield Diagnosis(NOTE, "mavros", what, page)
        return
    if "mavros_extras" not in machine.upstream:
        what = "is not in this environment: without GNSS the real MAVROS takes no external poses"
        yield Diagnosis(NOTE, "mavros_extras", what, page)
    if not machine.geoid_found:
        what = "is missing, and the real MAVROS ends at once without it"
        yield Diagnosis(ERROR, machine.geoid, what, "sudo geographiclib-get-geoids egm96-5")
