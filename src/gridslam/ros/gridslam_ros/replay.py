"""The command gridslam_replay: maps a bag as fast as possible and writes all results."""

from __future__ import annotations

import argparse
import contextlib
import dataclasses
import json
import math
import os
import platform
import resource
import sys
import tempfile
import time
from functools import partial
from pathlib import Path
from typing import Any, Iterator, NamedTuple

import numpy as np
import yaml
from sensor_msgs.msg import LaserScan
from tqdm import tqdm

from gridslam import ParameterError, SlamError, se2
from gridslam.errors import MountingError, reason_of
from gridslam.files.map_file import write_map, write_picture
from gridslam.files.replacing import replace_file
from gridslam.files.tum import write_tum
from gridslam.trajectory import Trajectory
from gridslam.volume.clouds import Pose
from gridslam.volume.path_poses import OdometryHistory, PathCorrections
from gridslam.warm_up import warm_up
from gridslam_ros.bag_checks import BagChecks
from gridslam_ros.bags import (
    LASER_SCAN,
    ODOMETRY,
    POINT_CLOUD,
    BagCount,
    BagError,
    BagScans,
    first_of,
    open_bag,
    topic_of,
    topics_of,
)
from gridslam_ros.beside.beside_scans import BesideScans
from gridslam_ros.beside.clouds import CloudSource
from gridslam_ros.beside.covariances import OdometryCovariances
from gridslam_ros.frames.odometry_frames import FrameError, OdometryFrames
from gridslam_ros.parameters import clamped, sort_parameters, without_effect
from gridslam_ros.remarks import Remarks
from gridslam_ros.scan_source import ScanSource
from gridslam_ros.sessions import Sessions
from gridslam_ros.verdict import Verdict
from gridslam_ros.volume.bag_volume import BagVolume, VolumeRequest, add_volume_arguments, volume_request
from kernel_cache.compiler_memory import release_compiler

SIDE = (
    "base_frame",
    "odom_frame",
    "throttle_scans",
    "levelling",
    "floor_z",
    "odometry_covariance",
    "odometry_in_space",
    "clouds",
)


def main(argv: list[str] | None = None) -> int:
    """Run the command; returns the exit code."""
    try:
        given, rest = split_parameters(sys.argv[1:] if argv is None else argv)
    except SlamError as error:
        print(f"gridslam_replay: {error}", file=sys.stderr)
        return 1
    parser = argparse.ArgumentParser(
        prog="gridslam_replay",
        description="Maps a bag as fast as it can be read. Writes map, trajectories (TUM) and timing.",
        epilog="name:=value sets any parameter of slam_gridslam: particles:=60 loop_closure:=true",
        usage="gridslam_replay BAG [--scan TOPIC] [--odometry TOPIC] [--output FOLDER] [--volume MAP.bt] "
        "[--cloud TOPIC] [--resolution M] [--max-range M] [--sensor-frame FRAME] [name:=value ...]",
    )
    parser.add_argument("bag", metavar="BAG", help="bag with scans and TF odom -> base -> lidar")
    parser.add_argument(
        "--scan", default="/scan", metavar="TOPIC", help="topic of the scans (default: %(default)s)"
    )
    parser.add_argument(
        "--odometry",
        default="/odometry",
        metavar="TOPIC",
        help="topic of the odometry, for odometry_covariance:=true (default: %(default)s)",
    )
    parser.add_argument("--output", metavar="FOLDER", help="folder to write (default: BAG's name + _slam)")
    add_volume_arguments(parser)
    arguments = parser.parse_args(rest)
    output = Path(arguments.output or str(Path(arguments.bag).with_suffix("")) + "_slam")
    try:
        topics = Topics(arguments.scan, arguments.odometry, arguments.cloud)
        replay = Replay(arguments.bag, topics, given, volume_request(arguments))
        with writable(output):
            replay.run(output)
    except SlamError as error:
        print(f"gridslam_replay: {error}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("gridslam_replay: interrupted; nothing is written.", file=sys.stderr)
        return 130
    return 0


def split_parameters(argv: list[str]) -> tuple[dict, list[str]]:
    """Return (parameters by name, the other words). A parameter is ``name:=value``, with or without --."""
    given, rest = {}, []
    for word in argv:
        name, is_parameter, value = word.partition(":=")
        if is_parameter:
            given[name.lstrip("-_")] = _value(word, value) if value else ""
        else:
            rest.append(word)
    return given, rest


def _value(word: str, value: str) -> Any:
    try:
        return yaml.safe_load(value)
    except yaml.YAMLError:
        raise ParameterError(f"{word} cannot be read: what comes after := must be a YAML value.") from None


@contextlib.contextmanager
def writable(folder: Path) -> Iterator[None]:
    """Check that files can be written into a folder. Remove a new folder again.

    Raises:
        BagError: they cannot.
    """
    is_new = not folder.exists()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise BagError(f"The results cannot be written to {folder}: {error.strerror}.") from None
    try:
        yield
    finally:
        if is_new:
            with contextlib.suppress(OSError):  # there are results in it
                folder.rmdir()


class Topics(NamedTuple):
    """Names of a bag's topics. Those of odometry and clouds count if the parameters say so."""

    scan: str = "/scan"
    odometry: str = "/odometry"
    cloud: str = "/cloud"


class Replay:
    """One run over one bag. Raises SlamError with one sentence."""

    def __init__(self, bag: str, topics: Topics, given: dict, volume: VolumeRequest | None = None):
        """volume: the map of voxels to make of the clouds."""
        settings, parameters, _, unknown = sort_parameters(given)
        if unknown:
            raise ParameterError(
                f"There is no parameter {', '.join(unknown)}; doc/reference.md has the list."
            )
        self._remarks = Remarks(lambda sentence: tqdm.write(f"gridslam_replay: {sentence}", file=sys.stderr))
        for sentence in filter(None, (clamped(parameters), without_effect(given))):
            self._remarks.say(sentence)
        self._bag, self._topics, self._settings, self._volume = bag, topics, settings, volume
        self._sessions = Sessions(given, self._remarks.say)
        self._frames = OdometryFrames(settings.odom_frame, settings.base_frame, self._remarks.say)
        self._beside = BesideScans(
            self._frames,
            OdometryCovariances(self._remarks.say) if settings.odometry_covariance else None,
            CloudSource(self._frames, self._remarks.say) if settings.clouds else None,
        )
        self._source = ScanSource(
            self._frames, self._remarks.say, bool(settings.levelling), settings.floor_z_m
        )
        self._count = BagCount()
        self._checks = BagChecks(topics.scan, self._count, self._frames)
        self._begin()

    def _begin(self) -> None:
        self._session = self._sessions.first()
        self._session.draw_in_place()  # nobody waits for a scan of a bag
        self._unusable = 0
        self._stamps_s: list[float] = []
        self._odometry: list[np.ndarray] = []
        self._has_jumped: list[bool] = []
        self._history = OdometryHistory()
        self._online: list[np.ndarray] = []
        self._cpu_s: list[float] = []
        self._first_closure_s: float | None = None
        self._verdict = Verdict()

    def run(self, output: Path) -> None:
        """Map the bag, and write the results into a folder."""
        warm_up()
        if self._session.loop_closure is not None:
            # imported here, because it takes a while
            from gridslam.loop_closure.warm_up import warm_up_loop_closure

            warm_up_loop_closure()
        release_compiler()
        start_s = time.perf_counter()
        with open_bag(self._bag) as bag:
            topic, odometry, cloud = topic_of(bag, self._topics.scan), "", ""
            self._checks.odometry_topics = topics_of(bag, ODOMETRY)
            if self._volume is not None:
                topic_of(bag, self._volume.cloud, POINT_CLOUD)
            if self._beside.covariances is not None:
                odometry = topic_of(bag, self._topics.odometry, ODOMETRY)
            if self._beside.clouds is not None:
                cloud = topic_of(bag, self._topics.cloud, POINT_CLOUD)
            self._source.look_ahead(first_of(bag, topic, LASER_SCAN))
            scans = BagScans(
                topic,
                self._frames,
                self._count,
                self._remarks.say,
                self._begin_again,
                self._settings.throttle_scans,
                self._beside,
                (odometry, cloud),
            )
            total = bag.get_message_count(topic)
            with tqdm(total=total, unit="scan", desc=Path(self._bag).name, mininterval=0.2) as bar:
                for scan in scans.of(bag):
                    bar.update(self._count.read - bar.n)
                    self._process(scan)
                    bar.set_postfix(integrated=len(self._cpu_s), refresh=False)
                bar.update(self._count.read - bar.n)
        self._remarks.sum_up()
        self._checks.check(len(self._cpu_s), len(self._has_jumped), sum(self._has_jumped))
        if left_out := self._checks.what_is_left_out():
            self._remarks.say(left_out)
        self._session.finish()
        wall_s = time.perf_counter() - start_s
        self._write(output, wall_s)

    def _begin_again(self, seconds: float) -> None:
        again = f"{self._sessions.again}, and the results are of what follows"
        self._remarks.say(f"The clock jumped back by {seconds:.3f} s; {again}.")
        self._begin()

    def _process(self, scan: LaserScan) -> None:
        begun_s = time.process_time()
        try:
            planar, base_in_odom = self._source.planar(scan)
            covariance, cloud = self._beside.covariance_of(scan), partial(self._beside.cloud_of, scan)
            self._checks.add(planar, base_in_odom)
            update = self._session.process(planar, base_in_odom, covariance, cloud, self._frames.in_doubt)
        except FrameError:
            self._count.without_tf += 1
            return
        except MountingError as error:  # what was mapped before it was found out is wrong, too
            raise BagError(f"{error} No map is written.") from None
        except SlamError as error:
            self._unusable += 1
            self._session.go_on(scan.header.stamp.to_sec(), self._source.base_of(scan))
            self._remarks.say(f"{error} The scan at {scan.header.stamp.to_sec():.3f} s is left out.")
            return
        if update is not None:
            self._cpu_s.append(time.process_time() - begun_s)
        self._stamps_s.append(planar.stamp_s)
        height_m = planar.height_m if math.isfinite(planar.height_m) else 0.0
        self._history.add(planar.stamp_s, Pose.level(*base_in_odom, height_m))
        self._odometry.append(se2.compose(self._session.odom_in_continuous, base_in_odom))
        self._has_jumped.append(self._session.odometry_has_jumped)
        map_to_odom = self._session.map_to_odom
        assert map_to_odom is not None  # since the first scan
        self._online.append(se2.compose(map_to_odom, base_in_odom))
        if self._session.tracking is not None:
            self._verdict.add(self._session.told_state)
        if self._first_closure_s is None and self._session.closures:
            self._first_closure_s = planar.stamp_s

    def _write(self, output: Path, wall_s: float) -> None:
        begun_s = time.process_time()
        grid = self._session.grid()
        render_s = time.process_time() - begun_s
        stamps_s = np.array(self._stamps_s)
        online, final = Trajectory(stamps_s, np.array(self._online)), self._final(stamps_s)
        self._session.forget_maps()  # pictures of the map need as much memory
        try:
            write_tum(output / "trajectory_online.tum", online)
            write_tum(output / "trajectory_final.tum", final)
            write_map(output / "map", grid)
            write_picture(output / "map.png", grid)
            volume = self._make_volume(final)
            figures = {**self._figures(wall_s, render_s), **volume}  # last, as what is written needs memory
            replace_file(output / "timing.json", json.dumps(figures, indent=2) + "\n")
        except OSError as error:
            raise BagError(f"The results cannot be written to {output}: {reason_of(error)}.") from None
        for sentence in self._verdict.sentences(figures["loose_parts_s"], self._stamps_s[0]):
            self._remarks.say(sentence)
        print(
            f"{figures['scans_integrated']} of {figures['scans_read']} scans integrated in {wall_s:.1f} s, "
            f"{figures['cpu_ms_per_integrated_scan']:.2f} ms of CPU each; "
            f"{len(self._session.closures)} loops closed.\n"
            f"Map, trajectories and timing are in {output}"
        )

    def _make_volume(self, path: Trajectory) -> dict:
        """Map the clouds along the final path, if asked for; return the figures."""
        if self._volume is None:
            return {}
        corrections = PathCorrections(path.stamps_s, path.poses_in_map, self._history, path.heights_m)
        frames = self._settings.odom_frame, self._settings.base_frame
        figures = BagVolume(self._volume, frames, corrections, self._remarks.say).make(self._bag)
        print(f"{figures['clouds_integrated']} of {figures['clouds_read']} clouds are in {figures['file']}")
        return {"volume": figures}

    def _final(self, stamps_s: np.ndarray) -> Trajectory:
        """Return the best particle's path at every scan. Between integrated scans it follows the odometry."""
        path, ours = self._session.trajectory(), len(self._cpu_s)
        heights_m = None
        if path.heights_m is not None and np.isfinite(path.heights_m).all():
            told_m = self._history.arrays()[1][:, 3]
            rises_m = path.heights_m[-ours:] - np.interp(path.stamps_s[-ours:], stamps_s, told_m)
            heights_m = told_m + np.interp(stamps_s, path.stamps_s[-ours:], rises_m)
        path = Trajectory(path.stamps_s[-ours:], path.poses_in_map[-ours:])  # not those of a saved state
        return Trajectory(stamps_s, self._filled(path, stamps_s), heights_m)

    def _filled(self, path: Trajectory, stamps_s: np.ndarray) -> np.ndarray:
        return path.filled(stamps_s, np.array(self._odometry), np.array(self._has_jumped))

    def _figures(self, wall_s: float, render_s: float) -> dict:
        return {
            "bag": os.path.abspath(self._bag),
            "scans_read": self._count.read,
            "scans_without_tf": self._count.without_tf,
            "scans_unusable": self._unusable,
            "scans_skipped": self._count.skipped,
            "begun_anew": self._count.begun_anew,
            "scans_integrated": len(self._cpu_s),
            "cpu_ms_per_integrated_scan": 1e3 * float(np.mean(self._cpu_s)),
            "cpu_ms_per_integrated_scan_p95": 1e3 * float(np.percentile(self._cpu_s, 95)),
            "render_ms": 1e3 * render_s,
            "wall_s": wall_s,
            "cpu_s": time.process_time(),
            "peak_mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0,
            "loops_closed": len(self._session.closures),
            "first_closure_s": self._first_closure_s,
            "states": self._verdict.shares,
            "loose_parts_s": self._session.loose_parts_s,
            "parameters": dataclasses.asdict(self._session.parameters),
            "node_parameters": {name: getattr(self._settings, name) for name in SIDE},
            "machine": f"{platform.machine()}, {os.cpu_count()} cores, Python {platform.python_version()}",
        }
