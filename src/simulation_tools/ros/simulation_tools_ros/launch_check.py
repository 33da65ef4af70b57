"""Refuses launches with unknown arguments, and launches that would end running nodes.

A launch file can set a parameter from a command's output. If the command fails, roslaunch gives up and
starts nothing. So a launch file with `check_launch` as such a command is checked in every launch.
"""

from __future__ import annotations

import contextlib
import os
import sys
from dataclasses import dataclass, field, replace
from functools import cache
from pathlib import Path
from types import ModuleType
from typing import Any, Callable, Mapping, Sequence

import rosgraph
import rospkg

from node_tools.ros_servers import UNREACHABLE, server
from simulation_tools.errors import SimulationToolsError
from simulation_tools.launch_check.launch_files import (
    LaunchError,
    arguments_of,
    check_arguments,
    followed,
    has_own_check,
    nodes_of,
)
from simulation_tools_ros.two_launches import check_is_alone, port_option

# roslaunch imports it to measure its logs. It would load setuptools, which takes half of roslaunch's time.
sys.modules.setdefault("rosclean", ModuleType("rosclean"))

_ROSLAUNCH_GOES_ON = "(What follows is roslaunch's own report of this. It says no more.)"


@dataclass(frozen=True)
class Launch:
    """A call of roslaunch.

    files: launch files. given: arguments. starts: whether it starts nodes. master_uri: its master.
    pid: the process that is roslaunch, or calls it.
    """

    files: tuple[Path, ...]
    given: Mapping[str, str]
    starts: bool = True
    master_uri: str = field(default_factory=rosgraph.get_master_uri)
    pid: int = field(default_factory=os.getpid)


def launch_of(words: Sequence[str]) -> Launch | None:
    """Return the launch of a process with this command line; None if it is no roslaunch or is not clear."""
    program = next((index for index, word in enumerate(words[:2]) if Path(word).name == "roslaunch"), None)
    if program is None:
        return None
    import roslaunch  # takes a third of a second
    from roslaunch.rlutil import resolve_launch_arguments

    try:
        options, rest = roslaunch._get_optparse().parse_args(list(words[program + 1 :]))
        names = resolve_launch_arguments([word for word in rest if ":=" not in word])
    except (SystemExit, roslaunch.RLException):
        return None
    given = dict(word.split(":=", 1) for word in rest if ":=" in word and not word.startswith("_"))
    looks = (options.node_args, options.node_list, options.find_node, options.dump_params)
    starts = not any((*looks, options.file_list, options.ros_args, options.child_name))
    files = tuple(_told(Path(name).resolve()) for name in names if Path(name).is_file())
    uri = f"http://localhost:{options.port}" if options.port else rosgraph.get_master_uri()
    return Launch(files, given, starts, uri) if files else None


def _told(file: Path) -> Path:
    """Return the file that this one stands for, see `followed`; itself if it cannot be read."""
    with contextlib.suppress(LaunchError):
        return followed(file, find_package)
    return file


def command_line(pid: int) -> list[str]:
    """Return the command line of a process of this machine, as a list of words."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_bytes().decode(errors="replace").split("\0")[:-1]
    except OSError:
        return []


def is_checked_by_its_file(words: Sequence[str]) -> bool:
    """Whether the one file of a roslaunch with this command line checks itself, see `has_own_check`.

    False if the file is not clear. roslaunch itself would tell, but takes a third of a second.
    """
    names = [word for word in words[1:] if ":=" not in word and not word.startswith("-")]
    places = [place for place, name in enumerate(names) if name.endswith(".launch")]
    if len(places) != 1:
        return False
    file = Path(names[places[0]])
    with contextlib.suppress(LookupError, LaunchError):
        if not file.is_file():
            file = Path(find_package(names[places[0] - 1]), "launch", file)
        return has_own_check(file)
    return False


def check(launch: Launch) -> None:
    """Check a launch's arguments, and that it would not end nodes that run already.

    Raises:
        LaunchError: one sentence.
    """
    if len(launch.files) == 1:  # roslaunch gives each of several files the arguments of all
        check_arguments(launch.files[0], launch.given, defaults_of(launch.files[0]))
    if launch.starts:
        check_is_alone(launch.pid, launch.master_uri)
        check_nothing_runs(launch.files, launch.master_uri)


def defaults_of(file: Path) -> dict[str, str]:
    """Return a launch file's defaults by name, resolved; without those that need a missing argument."""
    values: dict[str, str] = {}
    for argument in arguments_of(file):
        with contextlib.suppress(Exception):  # $(eval) may raise anything
            if argument.text is not None:
                values[argument.name] = resolved(argument.text, values, file)
    return values


def resolved(text: str, values: Mapping[str, str], file: Path) -> str:
    """Return a text of a launch file with its $(arg ...), $(find ...) and $(eval ...) filled in.

    values: of the arguments, by name.

    Raises:
        SubstitutionException: of roslaunch; and $(eval) may raise anything.
    """
    from roslaunch.substitution_args import resolve_args  # takes a third of a second

    return str(resolve_args(text, context={"arg": dict(values)}, filename=str(file)))


def check_nothing_runs(files: Sequence[Path], master_uri: str) -> None:
    """Raise LaunchError if a node of these files runs already, because ROS would end the running one."""
    master = server(master_uri)
    try:
        code, _, state = master.getSystemState("/check_launch")
    except (*UNREACHABLE, ValueError):
        return  # no master, so nothing runs
    if code != 1:
        return
    registered = {node for part in state for _, nodes in part for node in nodes}
    namespace = os.environ.get("ROS_NAMESPACE", "/")
    for file in files:
        for node in sorted(nodes_of(file, find_package, namespace) & registered):
            if _answers(master, node):
                raise LaunchError(_occupied(node, file, master_uri))


def find_package(package: str) -> str:
    """Return a package's folder; LookupError if ROS does not find it."""
    try:
        return str(_packages().get_path(package))
    except rospkg.ResourceNotFound as error:
        raise LookupError(package) from error


@cache
def _packages() -> rospkg.RosPack:
    return rospkg.RosPack()


def _occupied(node: str, file: Path, master_uri: str) -> str:
    port = (rosgraph.network.parse_http_host_and_port(master_uri)[1] or 11311) + 1
    ports = "offboard_port:=14640 gcs_port:=14650"
    return (
        f"{node} runs already at {master_uri}, and this launch would end it. End that first "
        "(Ctrl-C), or fly beside it on a master and ports of its own: "
        f"ROS_MASTER_URI=http://localhost:{port} roslaunch ... {file.name} {ports}"
    )


def _answers(master: Any, node: str) -> bool:
    try:
        code, _, uri = master.lookupNode("/check_launch", node)
        return code == 1 and server(uri).getPid("/check_launch")[0] == 1
    except (*UNREACHABLE, ValueError):
        return False


def run(
    checks: Callable[[Launch], None], expected: tuple[type[Exception], ...] = (SimulationToolsError,)
) -> int:
    """Check the roslaunch that called this process; returns an exit code.

    checks: called with the `Launch`; raises an error of one sentence if something is wrong.
    """
    launch = launch_of(command_line(os.getppid()))
    if launch is None:
        return 0  # rostest, or a program that calls roslaunch's API: no command line of roslaunch exists
    return _exit_code(lambda: checks(replace(launch, pid=os.getppid())), expected)


def run_once_more() -> int:
    """Check what bringup.sh cannot know: that no other launch has started meanwhile; returns an exit code."""
    pid = os.getppid()
    words = command_line(pid)
    if not any(Path(word).name == "roslaunch" for word in words[:2]):
        return 0
    port = port_option(words)
    uri = f"http://localhost:{port}" if port else rosgraph.get_master_uri()
    return _exit_code(lambda: check_is_alone(pid, uri), (LaunchError,))


def _exit_code(check_it: Callable[[], None], expected: tuple[type[Exception], ...]) -> int:
    try:
        check_it()
    except expected as error:
        print(f"{error}\n{_ROSLAUNCH_GOES_ON}", file=sys.stderr, flush=True)
        return 1
    return 0
