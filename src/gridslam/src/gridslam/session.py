"""One run of SLAM: the filter, the optional loop closer, and odometry that may jump.

The node, the replay of bags and simulations without ROS all drive this.
"""

from __future__ import annotations

import dataclasses
import math
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Callable, Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import ParameterError, PoseError, StateError
from gridslam.files import session_file
from gridslam.filter.motion_model import is_told
from gridslam.filter.particle_filter import START_DEVIATION, GridSlam
from gridslam.filter.scan_update import ScanUpdate
from gridslam.inputs.continuous_odometry import ContinuousOdometry, Doubt
from gridslam.localisation.supervisor import Supervisor
from gridslam.maps.new_map import check
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.tracking.judgement import Judgement
from gridslam.trajectory import Trajectory

if TYPE_CHECKING:
    from gridslam.loop_closure import Closure, LoopCloser, LoopClosureParameters


class SlamSession:
    """A `GridSlam` with the scans and odometry of a run, and optional loop closure.

    Args:
        parameters: of the filter.
        loop_closure: whether loops are closed, or the parameters for it. Localisation alone closes none.
        starting_map: the first map; None: an empty one.
        starting_pose: of the base in the map at the first scan; None: that of odometry. Map and odometry
            then begin as one frame.
        localisation_only: the starting map stays as it is.
        say: is called with a sentence when something about the odometry is odd, or the vehicle is lost.

    Raises MapError when the starting map's cells are not of the filter's size.
    """

    def __init__(
        self,
        parameters: SlamParameters,
        loop_closure: LoopClosureParameters | bool | None = True,
        starting_map: OccupancyGrid | None = None,
        starting_pose: tuple[float, float, float] | None = None,
        localisation_only: bool = False,
        say: Callable[[str], None] = warnings.warn,
    ):
        if starting_map is not None:
            check(starting_map, parameters.delta)
        self.parameters = parameters
        self._starting_map, self.localisation_only = starting_map, localisation_only
        self._starting_pose = starting_pose
        self._say = say
        self._odometry = ContinuousOdometry(say)
        self._supervisor = Supervisor(say)
        self._is_resumed = False
        """Whether there was no scan yet since a state was loaded."""
        self._starting_covariance: np.ndarray | None = None
        self._closer = _closer(loop_closure) if loop_closure and not localisation_only else None
        self.slam: GridSlam | None = None
        """The filter; None before the first scan."""
        self._mapped: GridSlam | None = None  # its map is taken over at the first scan

    def process(
        self, scan: PlanarScan, base_in_odom: Sequence[float], covariance: np.ndarray | None = None
    ) -> ScanUpdate | None:
        """Take in one scan. Return None if it is not integrated, for lack of motion or of agreement.

        covariance: (3, 3) of the base in odom, m2, m rad and rad2, which grows with the way; None: odometry
        does not tell it. Then the parameters srr, srt, str and stt say how uncertain odometry is.

        Raises:
            ScanError: the scan or the odometry makes no sense.
        """
        last_s, before = self._odometry.last_s, self._odometry.odom_in_continuous
        base = self._odometry.follow(scan.stamp_s, base_in_odom)
        if self.slam is None:
            self.slam = self._begin(base)
        elif self._is_resumed and (scan.stamp_s < last_s or self._odometry.odom_in_continuous is not before):
            self._supervisor.doubt(self.slam, "a new flight begins on the saved map")
            self.slam.widen(START_DEVIATION)
        elif self._odometry.doubt is not None:
            self._doubt(self.slam, self._odometry.doubt)
        self._is_resumed = False
        if self._closer is not None and self._closer.take(self.slam, scan.stamp_s):
            self._supervisor.forget_map()
            self._join_if_recognised(self.slam)
        was_lost, was_apart = self.slam.judgement.is_lost, self.slam.earlier is not None
        if covariance is not None and not is_told(covariance):
            self._say("The odometry's covariance makes no sense; srr, srt, str and stt count instead.")
            covariance = None
        if covariance is not None:
            covariance = self._odometry.turned(covariance)
        update = self._supervisor.process(self.slam, scan, base, covariance)
        if self._closer is not None and was_lost and not self.slam.judgement.is_lost:
            self._closer.forget(is_contradicted=not self.slam.judgement.is_confirming)
        if self._closer is not None and was_apart and self.slam.earlier is None:
            self._closer.forget()
        if update is not None and self._closer is not None:
            self._closer.update(self.slam, base, self.slam.judgement.last)
        return update

    def _doubt(self, slam: GridSlam, doubt: Doubt) -> None:
        """Prove the place anew, because odometry may have missed a part of the way."""
        slam.widen(doubt.deviations)
        if slam.judgement.is_lost:
            return
        self._supervisor.doubt(slam, doubt.reason)
        if self._closer is not None:
            self._closer.forget(is_contradicted=True)

    def finish(self) -> None:
        """Correct the path by all closures. Call this after the last scan."""
        if self._closer is not None and self.slam is not None:
            self._closer.finish(self.slam)
            self._join_if_recognised(self.slam)

    def _join_if_recognised(self, slam: GridSlam) -> None:
        """Note that closures have joined the map with the earlier one."""
        if slam.judgement.is_apart and slam.earlier is None:
            slam.judgement.join()
            self._supervisor.forget_earlier()

    def _begin(self, base: np.ndarray) -> GridSlam:
        slam = GridSlam(
            self.parameters,
            self._starting_map,
            base.tolist() if self._starting_pose is None else self._starting_pose,
            self.localisation_only,
            keep_scans=self._closer is not None,
        )
        if self._mapped is not None:
            slam.take_over_map(self._mapped)
            self._mapped = None
        if self._starting_map is not None:
            self._supervisor.doubt(slam, "the start on the map was given")
        if self._starting_covariance is not None:
            slam.relocate(slam.base_in_map, self._starting_covariance, math.nan)
        return slam

    def place(self, pose: Sequence[float], covariance: np.ndarray) -> None:
        """Put the vehicle at a pose that somebody gives, as AMCL does. The particles are drawn around it.

        Args:
            pose: x, y in m and yaw in rad of the base in the map, now.
            covariance: (3, 3) of the pose, m2, m rad and rad2.

        Raises:
            PoseError: pose or covariance make no sense, or the pose is outside the map, or there is no map.
        """
        self._require_on_the_map(check_pose(pose, covariance))
        if self.slam is None:
            self._starting_pose = (float(pose[0]), float(pose[1]), float(pose[2]))
            self._starting_covariance = np.array(covariance, float)
            return
        self.slam.relocate(pose, np.array(covariance, float), self._odometry.last_s)
        if self._closer is not None:
            self._closer.forget()
        self._supervisor.doubt(self.slam, "the pose was given")

    def _require_on_the_map(self, pose: np.ndarray) -> None:
        source = self.slam or self._mapped
        grid = self._starting_map if source is None else source.grid()
        if grid is None:
            raise PoseError("There is no map yet on which a pose could be.")
        low, size = np.array(grid.origin_xy_m), np.array(grid.size_m)
        if not ((low <= pose[:2]) & (pose[:2] <= low + size)).all():
            high = low + size
            raise PoseError(
                f"The pose x {pose[0]:.2f} m, y {pose[1]:.2f} m is outside the map, which reaches from "
                f"x {low[0]:.2f} to {high[0]:.2f} m and from y {low[1]:.2f} to {high[1]:.2f} m."
            )

    # Results

    @property
    def loop_closure(self) -> LoopClosureParameters | None:
        """Parameters of the loop closer; None: there is none."""
        return None if self._closer is None else self._closer.parameters

    @property
    def odom_in_continuous(self) -> np.ndarray:
        """(3,) pose of the odometry's frame since its last jump, in its first frame."""
        return self._odometry.odom_in_continuous

    @property
    def map_to_odom(self) -> tuple[float, float, float] | None:
        """Pose of the odometry's frame in the map (x, y, yaw); None if the first scan must decide it."""
        if self.slam is None:
            return (0.0, 0.0, 0.0) if self._starting_pose is None else None
        odom = se2.compose(self.slam.map_to_odom, self._odometry.odom_in_continuous)
        return tuple(odom.tolist())

    @property
    def judgement(self) -> Judgement | None:
        """Whether the vehicle is tracked, and the numbers that say so; None before the first scan."""
        return None if self.slam is None else self.slam.judgement

    @property
    def search(self) -> str:
        """Describes how far the search for a lost vehicle is; empty if there is none."""
        return self._supervisor.search

    @property
    def closures(self) -> list[Closure]:
        """The loops closed so far."""
        return [] if self._closer is None else self._closer.closures

    @property
    def entropy(self) -> float:
        """Of the particles' weights; 0 before the first scan."""
        return 0.0 if self.slam is None else self.slam.entropy

    @property
    def particle_poses(self) -> np.ndarray:
        """(particles, 3) poses in the map; none before the first scan."""
        return np.zeros((0, 3)) if self.slam is None else self.slam.particle_poses

    def trajectory(self) -> Trajectory:
        """Return the best particle's present path, at the integrated scans."""
        if self.slam is None:
            return Trajectory(np.zeros(0), np.zeros((0, 3)))
        return self.slam.trajectory()

    def grid(self) -> OccupancyGrid:
        """Return the best particle's map; its cells are read-only.

        Raises:
            StateError: there is none before the first scan.
        """
        if self.slam is None:
            raise StateError("There is no map before the first scan.")
        return self.slam.grid()

    # Saved states

    def save(self, path: str | Path) -> None:
        """Write the complete state. A run from this state equals one that was never interrupted.

        Raises:
            StateError: there is nothing to save yet, or the file cannot be written.
        """
        if self.slam is None:
            raise StateError("There is nothing to save before the first scan.")
        supervisor = self._supervisor.to_arrays()
        session_file.write(path, self.slam, self._odometry.state(), supervisor, self._closer)

    @classmethod
    def load(
        cls,
        path: str | Path,
        say: Callable[[str], None] = warnings.warn,
        localisation_only: bool = False,
        starting_pose: tuple[float, float, float] | None = None,
        threads: int | None = None,
    ) -> SlamSession:
        """Return a saved session with its saved parameters.

        Args:
            path: of the state.
            say: as for a new session.
            localisation_only: use the saved map for localisation only and do not change it. The path begins
                anew.
            starting_pose: with localisation_only, the vehicle's pose at the first scan; None: the saved
                pose.
            threads: for this run; None: the saved number.

        Raises:
            StateError: the file cannot be read, or holds no state.
        """
        with session_file.opened(path) as saved:
            slam = saved.slam(threads)
            if localisation_only and not slam.localisation_only:
                return cls._localising_on(slam, starting_pose, say)
            closer = saved.closer_parameters()
            session = cls(slam.parameters, None if closer is None else closure_parameters(closer), say=say)
            session.slam, session._is_resumed = slam, True
            session.localisation_only = slam.localisation_only
            session._odometry.restore(saved.odometry())
            slam.judgement.restore(saved.judgement())
            session._supervisor.from_arrays(saved.supervisor())
            if session._closer is not None:
                session._closer.from_arrays(saved.closer(), slam.processed_scans())
        return session

    @classmethod
    def _localising_on(
        cls, mapped: GridSlam, starting_pose: tuple[float, float, float] | None, say: Callable[[str], None]
    ) -> SlamSession:
        pose = mapped.base_in_map if starting_pose is None else starting_pose
        session = cls(mapped.parameters, None, mapped.grid(), pose, localisation_only=True, say=say)
        session._mapped = mapped
        return session


def check_pose(pose: Sequence[float], covariance: np.ndarray) -> np.ndarray:
    """Return a pose (3,) that makes sense together with its covariance (3, 3).

    Raises:
        PoseError: it does not.
    """
    checked, spread = np.array(pose, float), np.array(covariance, float)
    if checked.shape != (3,) or not np.isfinite(checked).all():
        raise PoseError(f"A pose must be finite x, y and yaw, not {checked.tolist()}.")
    if spread.shape != (3, 3) or not np.isfinite(spread).all():
        raise PoseError("The pose's covariance must be finite numbers for x, y and yaw.")
    tolerance = 1e-9 * max(1.0, float(np.abs(spread).max()))
    if not np.allclose(spread, spread.T, atol=tolerance) or np.linalg.eigvalsh(spread)[0] < -tolerance:
        raise PoseError("The pose's covariance must be symmetric, without a negative variance.")
    return checked


def closure_parameters(given: dict) -> LoopClosureParameters:
    """Return the loop closer's parameters from given values by name and the defaults.

    Raises:
        ParameterError: one is unknown or makes no sense.
    """
    from gridslam.loop_closure import LoopClosureParameters

    unknown = set(given) - {field.name for field in dataclasses.fields(LoopClosureParameters)}
    if unknown:
        raise ParameterError(f"The loop closure has no parameter {', '.join(sorted(unknown))}.")
    return LoopClosureParameters(**given)


def _closer(parameters: LoopClosureParameters | bool) -> LoopCloser:
    from gridslam.loop_closure import LoopCloser  # only if it is used, because it slows the start

    return LoopCloser(None if isinstance(parameters, bool) else parameters)
