"""The state of an installation, gathered without ROS, because ROS itself may be broken."""

from __future__ import annotations

import os
import re
import shutil
import socket
import subprocess
import sys
from dataclasses import dataclass, field
from importlib import metadata
from pathlib import Path
from typing import Mapping, Sequence

from packaging.requirements import Requirement

from kernel_cache.folders import has_code

UPSTREAM = {
    "rqt_reconfigure": "rqt_reconfigure",
    "mavros": "mavros_node",
    "mavros_extras": "visualization",
}
"""Packages that the distribution may lack, with a program of each."""

INTERFACES = ("gazebo_msgs", "geographic_msgs", "mavros_msgs", "octomap_msgs", "trajectory_msgs")
"""Packages of upstream's messages that this workspace builds where nobody else has them."""
DEFAULT_PORT = 11311
ONLY_FOR_TESTS = "# Only for the tests"
"""Begins the part of a list of the distribution's packages that `./bringup.sh test` alone installs."""
_BUILT_OVER = re.compile(r"CMAKE_PREFIX_PATH = r'([^']*)'\.split")


@dataclass(frozen=True)
class Machine:
    """An installation, in plain values.

    python_wanted: requirements.txt for this Python, package to version. python_found: package to version of
    the installed ones. debian_missing: of the platform's list; only_tests_miss: of its part for the tests.
    md5_wanted, md5_found: of the message types. kernels_missing: libraries without compiled kernels.
    hosts: name to whether it resolves. ros: the ROS_* environment variables. upstream: installed programs of
    `UPSTREAM`, by the package's name. geoid: MAVROS's path of the table of the geoid.
    underlays_gone: workspaces that this one was built over, or that the shell names, and that do not exist.
    underlays_new: those that the shell has below this one, and that it was not built over. messages_twice:
    packages of `INTERFACES` that are built here although an underlay has them. masters: ports of the ROS
    masters on this machine. shadowed: folders of PYTHONPATH to the packages in them that .venv has, too.
    ros_ip_is_here: whether ROS_IP is an address of this machine. ros_home: where ROS writes its logs, and
    ros_home_free_mb the room there. models_gone: folders of GAZEBO_MODEL_PATH that do not exist.
    """

    root: str
    python: str = ""
    platform_known: bool = True
    built: bool = True
    sourced: bool = True
    python_wanted: dict[str, str] = field(default_factory=dict)
    python_found: dict[str, str] = field(default_factory=dict)
    debian_missing: tuple[str, ...] = ()
    only_tests_miss: tuple[str, ...] = ()
    md5_wanted: dict[str, str] = field(default_factory=dict)
    md5_found: dict[str, str] = field(default_factory=dict)
    kernels_missing: tuple[str, ...] = ()
    free_disk_mb: int = 1_000_000
    free_memory_mb: int = 1_000_000
    hosts: dict[str, bool] = field(default_factory=dict)
    ros: dict[str, str] = field(default_factory=dict)
    upstream: tuple[str, ...] = tuple(UPSTREAM)
    geoid: str = ""
    geoid_found: bool = True
    underlays_gone: tuple[str, ...] = ()
    underlays_new: tuple[str, ...] = ()
    messages_twice: tuple[str, ...] = ()
    masters: tuple[int, ...] = ()
    shadowed: dict[str, tuple[str, ...]] = field(default_factory=dict)
    ros_ip_is_here: bool = True
    ros_home: str = ""
    ros_home_free_mb: int = 1_000_000
    ros_home_blocked_by: str = ""
    """What stands where ROS needs a folder for its logs: a file, or a folder that nobody may write in."""
    models_gone: tuple[str, ...] = ()


def look_at(root: Path, md5_wanted: dict[str, str], md5_found: dict[str, str]) -> Machine:
    """Return this machine's state; root: of the workspace."""
    wanted = requirements((root / "requirements.txt").read_text(encoding="utf-8"))
    packages = root / "scripts/packages" / f"{_platform()}.txt"
    hosts = {"localhost", socket.gethostname()} | {
        os.environ[name] for name in ("ROS_HOSTNAME",) if name in os.environ
    }
    geoid = geoid_path(os.environ)
    listed = packages.read_text(encoding="utf-8") if packages.exists() else ""
    needed, _, for_tests = listed.partition(ONLY_FOR_TESTS)
    logs = ros_logs(os.environ)
    return Machine(
        root=str(root),
        python=sys.prefix,
        platform_known=packages.exists(),
        built=(root / "devel/setup.bash").exists() and (root / "build/CMakeCache.txt").exists(),
        sourced=any(path in _spaces(root) for path in os.environ.get("CMAKE_PREFIX_PATH", "").split(":")),
        python_wanted=wanted,
        python_found=_installed(wanted),
        debian_missing=_missing(needed),
        only_tests_miss=_missing(for_tests.partition("\n")[2]),
        md5_wanted=md5_wanted,
        md5_found=md5_found,
        kernels_missing=kernels_missing(root),
        free_disk_mb=shutil.disk_usage(root).free // 2**20,
        free_memory_mb=_available_memory_mb(),
        hosts={name: _resolves(name) for name in sorted(hosts)},
        ros={name: value for name, value in os.environ.items() if name.startswith("ROS_")},
        upstream=tuple(name for name in UPSTREAM if _has_program(name)),
        geoid=str(geoid),
        geoid_found=geoid.exists(),
        masters=masters(),
        shadowed=shadowed(_folders("PYTHONPATH"), wanted),
        ros_ip_is_here=is_address_here(os.environ.get("ROS_IP", "")),
        ros_home=str(logs),
        ros_home_free_mb=_free_mb(logs),
        ros_home_blocked_by=blocked_by(logs),
        models_gone=tuple(path for path in _folders("GAZEBO_MODEL_PATH") if not Path(path).is_dir()),
        **_underlays(root, _folders("CMAKE_PREFIX_PATH")),
    )


def _folders(variable: str) -> list[str]:
    return [path for path in os.environ.get(variable, "").split(":") if path]


def shadowed(folders: Sequence[str], wanted: Mapping[str, str]) -> dict[str, tuple[str, ...]]:
    """Return the folders of PYTHONPATH that hold packages of .venv, and which: Python takes theirs first."""
    found = {}
    for folder in folders:
        there = [
            name for name in wanted if Path(folder, name).is_dir() or Path(folder, f"{name}.py").exists()
        ]
        if there:
            found[folder] = tuple(sorted(there))
    return found


def is_address_here(address: str) -> bool:
    """Return whether a node can bind a port of an address. What is no address at all counts as here."""
    try:
        family, kind, protocol, _, place = socket.getaddrinfo(
            address, 0, type=socket.SOCK_STREAM, flags=socket.AI_NUMERICHOST
        )[0]
    except OSError:
        return True
    try:
        with socket.socket(family, kind, protocol) as probe:
            probe.bind(place)
    except OSError:
        return False
    return True


def ros_logs(environment: Mapping[str, str]) -> Path:
    """Return the folder in which ROS writes its logs: ROS_LOG_DIR, or log in ROS_HOME, or in ~/.ros."""
    home = environment.get("ROS_HOME") or "~/.ros"
    return Path(environment.get("ROS_LOG_DIR") or f"{home}/log").expanduser()


def blocked_by(folder: Path) -> str:
    """Return what keeps a folder from being made or written in; empty: nothing does."""
    there = _nearest_there(folder)
    return "" if there.is_dir() and os.access(there, os.W_OK | os.X_OK) else str(there)


def _free_mb(folder: Path) -> int:
    """Return the room on the disk that holds a folder, or would hold it."""
    return shutil.disk_usage(_nearest_there(folder)).free // 2**20


def _nearest_there(folder: Path) -> Path:
    """Return the folder if it exists, else the nearest of its parents that does."""
    return next(path for path in (folder, *folder.absolute().parents) if path.exists())


def _spaces(root: Path) -> tuple[str, str]:
    """Return the folders of a workspace that a shell may know it by: what is built, and what is installed."""
    return str(root / "devel"), str(root / "install")


def _underlays(root: Path, prefixes: Sequence[str]) -> dict[str, tuple[str, ...]]:
    """Return the fields about underlays. prefixes: the shell's CMAKE_PREFIX_PATH, the topmost first."""
    devel, own = root / "devel", _spaces(root)
    script = devel / "_setup_util.py"
    match = _BUILT_OVER.search(script.read_text(encoding="utf-8")) if script.exists() else None
    built_over = [path for path in match.group(1).split(";") if path] if match else []
    topmost = min((prefixes.index(path) for path in own if path in prefixes), default=len(prefixes))
    below = [path for path in prefixes[topmost:] if path not in own]
    named = [path for path in dict.fromkeys((*built_over, *prefixes)) if path not in own]
    there = [path for path in (*named, "/usr") if Path(path).is_dir()]
    return {
        "underlays_gone": tuple(path for path in named if path not in there),
        "underlays_new": tuple(path for path in below if path in there and path not in built_over),
        "messages_twice": tuple(
            name
            for name in INTERFACES
            if (devel / "share" / name).is_dir() and any(Path(path, "share", name).is_dir() for path in there)
        ),
    }


def masters() -> tuple[int, ...]:
    """Return the ports of the ROS masters that run on this machine."""
    found = set()
    for path in Path("/proc").glob("[0-9]*/cmdline"):
        try:
            words = path.read_bytes().decode(errors="replace").split("\0")[:-1]
        except OSError:  # it has ended
            continue
        if any(Path(word).name == "rosmaster" for word in words[:2]):
            port = words[words.index("-p") + 1] if "-p" in words[:-1] else ""
            found.add(int(port) if port.isdigit() else DEFAULT_PORT)
    return tuple(sorted(found))


def geoid_path(environment: Mapping[str, str]) -> Path:
    """Return the only path where MAVROS's GeographicLib looks for the table of the geoid."""
    folder = environment.get("GEOGRAPHICLIB_GEOID_PATH", "")
    data = environment.get("GEOGRAPHICLIB_DATA") or "/usr/share/GeographicLib"
    return Path(folder or f"{data}/geoids") / "egm96-5.pgm"


def _has_program(package: str) -> bool:
    prefixes = [*os.environ.get("CMAKE_PREFIX_PATH", "").split(":"), "/usr"]
    return any(Path(prefix, "lib", package, UPSTREAM[package]).exists() for prefix in prefixes if prefix)


def requirements(text: str, python: str = "") -> dict[str, str]:
    """Return package to pinned version of a requirements.txt.

    Lines whose marker is for another Python are left out. python: its version, for example 3.13; this one's
    by default.
    """
    environment = {"python_version": python} if python else {}
    lines = (line.split(" #")[0].strip() for line in text.splitlines())
    asked = [Requirement(line) for line in lines if line and not line.startswith(("#", "-"))]
    return {
        one.name: spec.version
        for one in asked
        if one.marker is None or one.marker.evaluate(environment)
        for spec in one.specifier
        if spec.operator == "=="
    }


def _installed(names: dict[str, str]) -> dict[str, str]:
    found = {}
    for name in names:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return found


def _platform() -> str:
    """Return e.g. debian-12, as the lists in scripts/packages are called."""
    try:
        lines = Path("/etc/os-release").read_text(encoding="utf-8").splitlines()
    except OSError:
        return "unknown"
    values = dict(line.split("=", 1) for line in lines if "=" in line)
    return f"{values.get('ID', '').strip(chr(34))}-{values.get('VERSION_ID', '').strip(chr(34))}"


def _missing(package_list: str) -> tuple[str, ...]:
    """Return the packages of a list that are not installed, by dpkg."""
    wanted = [line.strip() for line in package_list.splitlines() if line.strip() and not line.startswith("#")]
    command = ["dpkg-query", "-W", "-f", "${db:Status-Status} ${Package}\n", *wanted]
    try:
        said = subprocess.run(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True, check=False, timeout=60.0
        ).stdout
    except subprocess.TimeoutExpired:
        return ()  # another program holds the database; what is missing is not known
    installed = {line.split()[1] for line in said.splitlines() if line.startswith("installed ")}
    return tuple(name for name in wanted if name not in installed)


def kernels_missing(root: Path) -> tuple[str, ...]:
    """Return the libraries with kernels of which none was compiled from the present sources yet."""
    libraries = {
        path.parent.name: [file for file in path.parent.rglob("*.py") if _jitted(file)]
        for pattern in ("src/*/src/*/warm_up.py", "src/*/*/src/*/warm_up.py")
        for path in root.glob(pattern)
    }
    return tuple(name for name, files in sorted(libraries.items()) if files and not any(map(has_code, files)))


def _jitted(path: Path) -> bool:
    return "cache=True" in path.read_text(encoding="utf-8")


def _available_memory_mb() -> int:
    for line in Path("/proc/meminfo").read_text(encoding="ascii").splitlines():
        if line.startswith("MemAvailable:"):
            return int(line.split()[1]) // 1024
    return 1_000_000


def _resolves(name: str) -> bool:
    try:
        socket.getaddrinfo(name, None)
    except OSError:
        return False
    return True
