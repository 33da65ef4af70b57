"""slam_gmapping's own `slam_gmapping_replay` maps a bag, so that gridslam's errors and costs stand beside it.

It runs twice with one seed. The first run gives its CPU time and memory; it draws its map only once, as
`gridslam_replay` does. The second gives its path, which the program tells in its log's debug lines only.
"""

from __future__ import annotations

import contextlib
import math
import os
import re
import subprocess
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Iterator, Mapping, Sequence

import numpy as np
import rosbag

from benchmarks.peers.environments import PeerError
from flights.graph.free_ports import free_ports
from gridslam import se2
from gridslam.trajectory import Trajectory

PATIENCE_S = 3600.0
MASTER_PATIENCE_S = 60.0
ONCE_S, OFTEN_S = 1e6, 30.0
"""`map_update_interval`, in the bag's time. Each drawing tells the best particle's whole path."""
SAME_POSE = (0.002, 0.002, 0.002)
"""m, m, rad: poses are told with three decimals."""
_POSE = r"(-?\d+\.\d+) (-?\d+\.\d+) (-?\d+\.\d+)"
_BEST, _ODOMETRY = re.compile(rf"new best pose: {_POSE}"), re.compile(rf"odom pose: {_POSE}")
_TREE, _NODE = "Trajectory tree:", re.compile(rf"^\W*(?:\[\d+m)?  {_POSE}")
_ROOT = "Reading is NULL"


@dataclass(frozen=True)
class Told:
    """What the program says of its poses, (n, 3) x, y, yaw of the lidar, at the n scans that it processed."""

    online: np.ndarray
    """In its map, as it told them on the way."""
    final: np.ndarray
    """In its map, of the last best particle."""
    odometry: np.ndarray
    """In odometry's frame."""


@dataclass(frozen=True)
class Scans:
    """A bag's scans: stamps_s (n,), lidar_in_odom (n, 3), and lidar_in_base (3,)."""

    stamps_s: np.ndarray
    lidar_in_odom: np.ndarray
    lidar_in_base: np.ndarray


@dataclass(frozen=True)
class Mapped:
    """The outcome of a bag: paths of the base, CPU time and memory."""

    online: Trajectory
    final: Trajectory
    cpu_ms_per_scan: float
    peak_mb: float


def map_bag(program: Path, bag: Path, settings: Mapping[str, Any], seed: int) -> Mapped:
    """Let gmapping map a bag.

    settings: gmapping's parameters that are not its defaults.

    Raises:
        PeerError: there is no such program, or it fails, or says nothing of its poses.
    """
    if not os.access(program, os.X_OK) or program.is_dir():
        raise PeerError(
            f"gmapping is not there: {program} is no program; give the path of slam_gmapping_replay."
        )
    scans = scans_of(bag)
    with _master() as environment:
        call = [str(program), "--bag_filename", str(bag), "--scan_topic", "/scan", "--on_done", "true"]
        call += ["--seed", str(seed), *(f"_{name}:={value}" for name, value in settings.items())]
        cpu_s, peak_mb = _cost([*call, f"_map_update_interval:={ONCE_S}"], environment)
        told = parsed(_debug_lines([*call, f"_map_update_interval:={OFTEN_S}"], environment))
    stamps_s = scans.stamps_s[processed(told.odometry, scans.lidar_in_odom)]
    base_in_lidar = se2.inverse(scans.lidar_in_base)
    online, final = (
        Trajectory(stamps_s, se2.compose(path, base_in_lidar)) for path in (told.online, told.final)
    )
    return Mapped(online, final, 1e3 * cpu_s / len(stamps_s), peak_mb)


def parsed(lines: Sequence[str]) -> Told:
    """Return the poses in the program's debug lines.

    Raises:
        PeerError: there are none, or not as many of odometry.
    """
    online: list[tuple[str, ...]] = []
    odometry: list[tuple[str, ...]] = []
    tree: list[tuple[str, ...]] = []
    for line in lines:
        if found := _BEST.search(line):
            online.append(found.groups())
        elif found := _ODOMETRY.search(line):
            odometry.append(found.groups())
        elif _TREE in line:
            tree = []
        elif found := _NODE.search(line):
            tree.append(found.groups())
        elif _ROOT in line:
            tree.pop()  # the start, where no scan was taken
    if not online or len(online) != len(odometry) or len(tree) > len(online):
        raise PeerError(f"gmapping told {len(online)} poses and {len(odometry)} of odometry: not its log?")
    poses = np.array(online, float)
    newest_last = np.array(tree[::-1], float).reshape(-1, 3)
    return Told(poses, np.vstack((newest_last, poses[len(newest_last) :])), np.array(odometry, float))


def processed(told: np.ndarray, lidar_in_odom: np.ndarray) -> np.ndarray:
    """Return the indices (n,) of the scans whose poses in odometry were told, in their order.

    Raises:
        PeerError: a told pose is none of the scans'.
    """
    found, at = [], 0
    for pose in told:
        off = np.abs(lidar_in_odom[at:] - pose)
        off[:, 2] = np.abs(se2.wrap(off[:, 2]))
        same = np.flatnonzero((off <= SAME_POSE).all(axis=1))
        if not len(same):
            raise PeerError(f"gmapping told odometry at {pose.tolist()}, where the bag has no further scan.")
        found.append(at + int(same[0]))
        at = found[-1] + 1
    return np.array(found, int)


def scans_of(bag: Path) -> Scans:
    """Read a bag whose transforms have their scans' stamps.

    Raises:
        PeerError: none has.
    """
    base_in_odom: dict[int, np.ndarray] = {}
    lidar_in_base, scans = np.zeros(3), []
    with rosbag.Bag(str(bag)) as opened:
        for topic, message, _ in opened.read_messages(topics=["/tf", "/tf_static", "/scan"]):
            if topic == "/scan":
                middle_rad = 0.5 * (message.angle_min + message.angle_max)
                scans.append((message.header.stamp.to_nsec(), message.header.frame_id, middle_rad))
                continue
            for transform in message.transforms:
                if transform.header.frame_id.strip("/") == "odom":
                    base_in_odom[transform.header.stamp.to_nsec()] = _planar(transform.transform)
                elif scans and transform.child_frame_id.strip("/") == scans[0][1].strip("/"):
                    lidar_in_base = _planar(transform.transform)
    kept = [(stamp, middle) for stamp, _, middle in scans if stamp in base_in_odom]
    if not kept:
        raise PeerError(f"{bag.name} is not mapped by gmapping: no transform has a scan's stamp.")
    lidar = se2.compose(lidar_in_base, (0.0, 0.0, kept[0][1]))
    poses = se2.compose(np.array([base_in_odom[stamp] for stamp, _ in kept]), lidar)
    return Scans(np.array([stamp for stamp, _ in kept]) * 1e-9, poses, lidar)


def _planar(transform: Any) -> np.ndarray:
    q = transform.rotation
    yaw_rad = math.atan2(2.0 * (q.w * q.z + q.x * q.y), 1.0 - 2.0 * (q.y * q.y + q.z * q.z))
    return np.array([transform.translation.x, transform.translation.y, yaw_rad])


@contextlib.contextmanager
def _master() -> Iterator[Mapping[str, str]]:
    """Run a ROS master of its own; yield the environment of its nodes."""
    (port,) = free_ports(1)
    environment = {**os.environ, "ROS_MASTER_URI": f"http://127.0.0.1:{port}", "ROS_IP": "127.0.0.1"}
    environment.pop("ROS_HOSTNAME", None)
    quiet = subprocess.DEVNULL
    core = subprocess.Popen(
        ("rosmaster", "--core", "-p", str(port)), stdout=quiet, stderr=quiet, env=environment
    )
    try:
        until_s = time.monotonic() + MASTER_PATIENCE_S
        asked = ("rosparam", "list")
        while subprocess.run(asked, stdout=quiet, stderr=quiet, env=environment).returncode != 0:
            if core.poll() is not None or time.monotonic() > until_s:
                raise PeerError(
                    f"gmapping has no ROS master: none answers at {environment['ROS_MASTER_URI']}."
                )
        yield environment
    finally:
        core.terminate()
        core.wait()


def _cost(command: Sequence[str], environment: Mapping[str, str]) -> tuple[float, float]:
    """Run the program; return its CPU time in s and its greatest memory in MB."""
    with tempfile.TemporaryFile() as said:
        try:
            child = subprocess.Popen(command, stdout=said, stderr=said, env=environment)
        except OSError as error:
            raise PeerError(f"gmapping cannot be started: {error}.") from None
        _, status, used = os.wait4(child.pid, 0)
        child.returncode = os.waitstatus_to_exitcode(status)
        if child.returncode != 0:
            raise PeerError(f"gmapping ended with code {child.returncode}.")
    return used.ru_utime + used.ru_stime, used.ru_maxrss / 1024.0


def _debug_lines(command: Sequence[str], environment: Mapping[str, str]) -> list[str]:
    """Run the program with all that its log says."""
    with tempfile.TemporaryDirectory() as folder:
        levels = Path(folder, "rosconsole.config")
        levels.write_text("log4j.logger.ros.gmapping=DEBUG\n", encoding="utf-8")
        telling = {"ROSCONSOLE_CONFIG_FILE": str(levels), "ROSCONSOLE_FORMAT": "${message}"}
        done = subprocess.run(
            command,
            env={**environment, **telling},
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            errors="replace",
            timeout=PATIENCE_S,
        )
    if done.returncode != 0:
        raise PeerError(f"gmapping ended with code {done.returncode} when it told its path.")
    return done.stdout.splitlines()
