"""Refuses a launch that starts while another one starts the same master: roslaunch would give up half-way.

roslaunch asks the master for the run's name (/run_id) before it reads the launch file. A master that
comes later has another name. roslaunch then ends with "run_id on parameter server does not match".
"""

from __future__ import annotations

import contextlib
import os
from pathlib import Path
from urllib.parse import urlsplit

from node_tools.ros_servers import UNREACHABLE, server
from simulation_tools.launch_check.launch_files import LaunchError

PROCESSES = Path("/proc")
PROGRAMS = ("roslaunch", "roscore")
DEFAULT_URI = "http://localhost:11311"
HERE = ("localhost", "127.0.0.1", "::1")


def port_option(words: list[str]) -> int | None:
    """Return the port of the option -p of a roslaunch with this command line; None: it has none."""
    for option, value in zip(words, [*words[1:], ""]):
        if option in ("-p", "--port") and value.isdigit():
            return int(value)
        if option.startswith("--port=") and option[7:].isdigit():
            return int(option[7:])
    return None


def check_is_alone(pid: int, master_uri: str, processes: Path = PROCESSES) -> None:
    """Check that no other launch starts the master that a launch of this machine is about to use.

    Args:
        pid: of the roslaunch, or of a program that will become one.
        master_uri: of its master.
        processes: the folder /proc.

    Raises:
        LaunchError: one sentence.
    """
    name = _run_id(master_uri)
    if name is None:
        older = _older_launches(pid, master_uri, processes)
        if older:
            raise LaunchError(_sentence(f"Another launch (process {older[0]}) is starting", master_uri))
    elif _asked_too_early(pid, name, processes):
        raise LaunchError(_sentence("Another launch has just started", master_uri))


def _sentence(what: str, master_uri: str) -> str:
    return (
        f"{what} ROS's master at {master_uri}, and two launches that start together do not find each other. "
        "Start this one again when the first one's terminal shows lines of its nodes, or give both a master "
        "of their own (ROS_MASTER_URI)."
    )


def _run_id(master_uri: str) -> str | None:
    """Return the name of the master's run; None: no master answers, or it has no name yet."""
    try:
        code, _, name = server(master_uri).getParam("/two_launches", "/run_id")
    except (*UNREACHABLE, ValueError):
        return None
    return str(name) if code == 1 else None


def _asked_too_early(pid: int, name: str, processes: Path) -> bool:
    """Whether this roslaunch writes its log under the name of another run than the master's."""
    own = {
        file.parent.name
        for file in _open_files(processes / str(pid))
        if file.name.startswith("roslaunch-") and file.name.endswith(f"-{pid}.log")
    }
    return bool(own) and name not in own


def _open_files(process: Path) -> list[Path]:
    files = []
    with contextlib.suppress(OSError):
        for link in (process / "fd").iterdir():
            with contextlib.suppress(OSError):
                files.append(Path(os.readlink(link)))
    return files


def _older_launches(pid: int, master_uri: str, processes: Path) -> list[int]:
    """Return the other launches of this machine that started earlier and use the master, oldest first."""
    own_port, host = _port_of(master_uri), urlsplit(master_uri).hostname
    own = _age(processes / str(pid))
    if own is None or (host not in HERE and host != os.uname().nodename):
        return []
    network, found = _network(processes / str(pid)), []
    for process in processes.iterdir():
        if not process.name.isdigit():
            continue
        words = _words(process / "cmdline")
        if not any(Path(word).name in PROGRAMS for word in words[:2]):
            continue
        age = _age(process)
        if age is None or age >= own or "-c" in words or _network(process) != network:
            continue
        if _master_port(words, _words(process / "environ")) == own_port:
            found.append(age)
    return [number for _, number in sorted(found)]


def _master_port(words: list[str], environment: list[str]) -> int | None:
    """Return the port of a launch's master: of its option -p, else of its ROS_MASTER_URI."""
    port = port_option(words)
    if port:
        return port
    uris = [word.partition("=")[2] for word in environment if word.startswith("ROS_MASTER_URI=")]
    return _port_of(uris[-1] if uris else DEFAULT_URI)


def _port_of(uri: str) -> int | None:
    try:
        return urlsplit(uri).port or 11311
    except ValueError:
        return None


def _age(process: Path) -> tuple[int, int] | None:
    """Return when a process started, in ticks, and its number; None: it has ended."""
    try:
        after_name = (process / "stat").read_text().rpartition(")")[2].split()
        return int(after_name[19]), int(process.name)
    except (OSError, IndexError, ValueError):
        return None


def _network(process: Path) -> str:
    """Return the name of a process's network: a container has one of its own, with the same ports."""
    try:
        return os.readlink(process / "ns/net")
    except OSError:
        return ""


def _words(file: Path) -> list[str]:
    try:
        return file.read_bytes().decode(errors="replace").split("\0")[:-1]
    except OSError:
        return []
