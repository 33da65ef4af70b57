"""One run of SLAM: the filter, the optional loop closer, and odometry that may jump.

The node, the replay of bags and simulations without ROS all drive this.
"""

from __future__ import annotations

import math
import warnings
from typing import TYPE_CHECKING, Callable, Sequence

import numpy as np

from gridslam import se2
from gridslam.errors import SlamError, StateError
from gridslam.filter.grid_slam import GridSlam
from gridslam.filter.motion_model import is_told
from gridslam.filter.particle_filter import START_DEVIATION
from gridslam.filter.scan_update import ScanUpdate
from gridslam.inputs.continuous_odometry import LEEWAY_M, NEAR_M, ContinuousOdometry, Doubt
from gridslam.inputs.slice_watch import SliceWatch
from gridslam.level_cloud import LevelCloud
from gridslam.localisation.given_pose import check_given_pose
from gridslam.localisation.sight import Sight, sees
from gridslam.localisation.supervisor import Supervisor
from gridslam.loop_closure import Closure, LoopClosureParameters
from gridslam.loop_closure.parameters import closure_parameters
from gridslam.maps.new_map import Band, check
from gridslam.occupancy_grid import OccupancyGrid
from gridslam.parameters import SlamParameters
from gridslam.scan import PlanarScan
from gridslam.session_state import SessionState
from gridslam.tracking.monitor import APART, LOST, UNCERTAIN, TrackingMonitor
from gridslam.tracking.self_check import drift_of
from gridslam.trajectory import Trajectory

if TYPE_CHECKING:
    from gridslam.loop_closure.closer import LoopCloser
    from gridslam.loop_closure.correction import Correction

__all__ = ["SlamSession", "closure_parameters"]


class SlamSession:
    """A `GridSlam` with the scans and odometry of a run, and optional loop closure.

    Args:
        parameters: of the filter.
        loop_closure: whether loops are closed, or the parameters for it. Localisation alone closes none.
        starting_map: the first map; None: an empty one. A filter: its map, which this session goes on to use.
        starting_pose: of the base in the map at the first scan; None: that of odometry. Map and odometry
            then begin as one frame.
        localisation_only: the starting map stays as it is.
        say: is called with a sentence when something about the odometry is odd, or the vehicle is lost.
        odometry_in_space: see `GridSlam.odometry_in_space`. It has no effect without loop closure, for
            nothing else would correct odometry then.

    Raises MapError when the starting map's cells are not of the filter's size.
    """

    def __init__(
        self,
        parameters: SlamParameters,
        loop_closure: LoopClosureParameters | bool | None = True,
        starting_map: OccupancyGrid | GridSlam | None = None,
        starting_pose: tuple[float, float, float] | None = None,
        localisation_only: bool = False,
        say: Callable[[str], None] = warnings.warn,
        odometry_in_space: bool = False,
    ):
        self._mapped = starting_map if isinstance(starting_map, GridSlam) else None
        """Its map is taken over at the first scan."""
        if isinstance(starting_map, GridSlam):
            starting_map = starting_map.grid()
        if starting_map is not None:
            check(starting_map, parameters.delta)
        self.parameters = parameters
        self._starting_map, self.localisation_only = starting_map, localisation_only
        self._starting_pose = starting_pose
        self._say = say
        self._odometry, self._is_in_space = ContinuousOdometry(say), odometry_in_space
        self._supervisor = Supervisor(say)
        self.sight = Sight(parameters)
        """What the state rests on."""
        self._is_resumed = False
        """Whether there was no scan yet since a state was loaded."""
        self._slices, self._has_said_bands = SliceWatch(), False
        self._starting_covariance: np.ndarray | None = None
        self._former: tuple[np.ndarray, np.ndarray] | None = None
        self._closer: LoopCloser | None = None
        if loop_closure and not localisation_only:
            self._closer = _closer_class()(None if isinstance(loop_closure, bool) else loop_closure)
            self._slices = SliceWatch(self._closer.parameters.height_band_m)
        self.slam: GridSlam | None = None
        """The filter; None before the first scan."""

    def process(
        self,
        scan: PlanarScan,
        base_in_odom: Sequence[float],
        covariance: np.ndarray | None = None,
        cloud: Callable[[], LevelCloud | None] = lambda: None,
        in_doubt: str = "",
    ) -> ScanUpdate | None:
        """Take in one scan. Return None if it is not integrated, for lack of motion or of agreement.

        covariance: (3, 3) of the base in odom, m2, m rad and rad2, which grows with the way; None: odometry
        does not tell it. Then the parameters srr, srt, str and stt say how uncertain odometry is.
        cloud: returns what the lidar saw in space with the scan; it is asked for scans that are kept only.
        in_doubt: why odometry is not to be trusted now; empty: it is. The state is uncertain meanwhile.

        Raises:
            ScanError: the scan or the odometry makes no sense.
        """
        last_s = self._odometry.last_s
        base = self._odometry.follow(scan.stamp_s, base_in_odom)
        if self.slam is None:
            self.slam = self._begin(base)
        elif self._is_resumed and (scan.stamp_s < last_s or self._odometry.has_jumped):
            self._supervisor.doubt(self.slam, "a new flight begins on the saved map")
            self.slam.widen(START_DEVIATION)
        elif self._odometry.doubt is not None:
            self._doubt(self.slam, self._odometry.doubt)
        self._is_resumed = False
        if covariance is not None and not is_told(covariance):
            self._say("The odometry's covariance makes no sense; srr, srt, str and stt count instead.")
            covariance = None
        if covariance is not None:
            covariance = self._odometry.turned(covariance)
        self._watch_sight(self.slam, scan, base, covariance)
        update = self._use(self.slam, scan, base, covariance, cloud)
        self._end_without_sight(self.slam)
        if in_doubt:
            self.slam.tracking.bridge(in_doubt)
        return update

    def _use(
        self,
        slam: GridSlam,
        scan: PlanarScan,
        base: np.ndarray,
        covariance: np.ndarray | None,
        cloud: Callable[[], LevelCloud | None],
    ) -> ScanUpdate | None:
        """Give a scan to the filter and the loop closer."""
        is_between = self._watch_slices(slam, base, scan.height_m)
        if self._closer is not None:
            self._take(self._closer, slam, scan.stamp_s)
        was_lost, was_apart = slam.tracking.is_lost, slam.earlier is not None
        was_open = slam.tracking.is_confirming or slam.tracking.is_bridging
        if is_between and not slam.tracking.is_lost:
            if slam.follow(base, scan.stamp_s, covariance):
                slam.refuse(scan.stamp_s)
            return None
        slam.skips_known = self._closer is not None and self._closer.has_agreed
        update = self._supervisor.process(slam, scan, base, covariance)
        if self._closer is not None and was_lost and not slam.tracking.is_lost:
            self._closer.drop(is_contradicted=not slam.tracking.is_confirming)
        if self._closer is not None and was_apart and slam.earlier is None:
            self._closer.drop()
        is_proved = slam.tracking.is_on_the_map and not slam.tracking.self_check.is_bridged
        if self._closer is not None and was_open and is_proved:
            self._closer.prove()
        if self._closer is not None:
            is_node = update is not None and update.is_node
            if is_node:
                self._keep_cloud(slam, cloud)
            elif update is not None:  # in a place that is known
                slam.tracking.check(slam.tracking.self_check.recognised())
            self._look_for_loops(self._closer, slam, scan.stamp_s, is_node)
        return update

    def _watch_sight(
        self, slam: GridSlam, scan: PlanarScan, base: np.ndarray, covariance: np.ndarray | None
    ) -> None:
        """Note whether a scan sees anything. If none did for long, odometry has erred as it may have."""
        if not sees(scan):
            self.sight.follow(scan.stamp_s, base, covariance)
            return
        if self.sight.is_poor:
            slam.widen(self.sight.deviations.tolist())
        self.sight.see(scan.stamp_s, base, covariance)

    def go_on(self, stamp_s: float, base_in_odom: Sequence[float] | None = None) -> None:
        """Take in that time has passed without a scan that can be used, so that the state ends in time.

        base_in_odom: x, y in m and yaw in rad now; None: nobody knows it.
        """
        if self.slam is None:
            return
        base = None if base_in_odom is None else np.asarray(base_in_odom, float)
        if base is not None:
            base = se2.compose(self._odometry.odom_in_continuous, base)
        self.sight.follow(stamp_s, base)
        self._end_without_sight(self.slam)

    def _end_without_sight(self, slam: GridSlam) -> None:
        """End the state if what it rests on is too old."""
        is_old = self.sight.is_poor or self._odometry.is_silence(self.sight.age_s)
        if is_old and not slam.tracking.is_lost:
            slam.tracking.bridge(self.sight.reason)

    def _keep_cloud(self, slam: GridSlam, cloud: Callable[[], LevelCloud | None]) -> None:
        try:
            seen = cloud()
        except SlamError as error:
            self._say(f"{error} Loop closure does without the cloud.")
            return
        if seen is not None:
            slam.add_cloud(seen)

    def _watch_slices(self, slam: GridSlam, base: np.ndarray, height_m: float) -> bool:
        """Go on with another map when the vehicle has come to another height.

        Return whether it is on the way there, so that a scan fits no map and odometry counts alone.
        """
        has_bands = slam.has_bands and self._closer is not None
        changed = self._slices.follow(float(base[0]), float(base[1]), height_m)
        if changed is None:
            return has_bands and self._slices.is_between(height_m)
        before_m, now_m = changed
        words = f"The vehicle flies at {now_m:.1f} m; level scans see another slice than at {before_m:.1f} m."
        if has_bands and self._closer is not None and not slam.tracking.is_lost:
            if not self._has_said_bands:
                self._say(f"{words} Each height has its own map now; only clouds close loops between them.")
            self._has_said_bands = True
            slam.change_band(Band(now_m, self._closer.parameters.height_band_m))
            self._supervisor.forget_map()
        else:
            self._say(f"{words} The map is of both and may be wrong; no loops are closed between them.")
        return False

    def _look_for_loops(self, closer: LoopCloser, slam: GridSlam, stamp_s: float, is_node: bool) -> None:
        """Let the closer search, if that is due. ``is_node``: the scan was kept."""
        if is_node:
            closer.add_node(
                stamp_s, slam.newest_odometry, None if slam.evidence is None else slam.evidence.agreement
            )
            if closer.is_search_due:
                closer.search(slam.snapshot())
        elif not slam.tracking.is_lost and closer.is_decision_due(stamp_s):
            closer.decide(slam.snapshot(), stamp_s)

    def _take(self, closer: LoopCloser, slam: GridSlam, stamp_s: float) -> None:
        """Take over what the closer has found, if that is due: a correction, and what it says of the pose."""
        correction = closer.take(stamp_s)
        self._correct(correction)
        if closer.found is not None:
            checked = slam.tracking.self_check
            if closer.found.agreed and correction is None:
                checked = checked.recognised()
            checked = checked.left_open(closer.found.open_m)
            told = closer.found.spread
            checked = checked.spread_over(told.since_recognised_m, told.in_map_m, told.error_share)
            slam.tracking.check(checked)

    def _correct(self, correction: Correction | None) -> None:
        """Let the filter take over a correction, if there is one."""
        if correction is None or self.slam is None:
            return
        before = self.slam.node_poses()[: len(correction.poses)]
        drift = drift_of(before, correction.poses)
        self.slam.correct(correction)
        self.slam.tracking.check(self.slam.tracking.self_check.recognised(drift))
        self._supervisor.forget_map()
        if self.slam.tracking.is_apart and self.slam.earlier is None:
            self.slam.tracking.join()
            self._supervisor.forget_earlier()

    def _doubt(self, slam: GridSlam, doubt: Doubt) -> None:
        """Prove the place anew, because odometry may have missed a part of the way."""
        slam.widen(doubt.deviations)
        if slam.tracking.is_lost:
            return
        if doubt.is_way_known and not slam.tracking.is_confirming:
            slam.tracking.bridge(f"{doubt.reason}; odometry alone tells the way")
            if self._closer is not None:
                self._closer.drop()
            return
        self._supervisor.doubt(slam, doubt.reason)
        if self._closer is not None:
            self._closer.drop(is_contradicted=True)

    def decide_pending(self) -> None:
        """Decide whether a place that was recognised last closes a loop, with all that is known.

        Call this before the map or the state is saved. Scans may follow.
        """
        if self._closer is None or self.slam is None:
            return
        if self._closer.is_pending and not self.slam.tracking.is_lost:
            self._take(self._closer, self.slam, math.inf)
            self._closer.decide(self.slam.snapshot(), self._odometry.last_s)
            self._take(self._closer, self.slam, math.inf)

    def draw_in_place(self) -> None:
        """Let corrections draw their map when they are taken, in the place of the old one.

        So memory holds one of both only, but a scan waits for the drawing. The results are the same.
        """
        if self._closer is not None:
            self._closer.draws_beside = False

    def forget_maps(self) -> None:
        """Drop the filter with its maps and its path, of which the caller has what it needs."""
        self.slam = None

    def finish(self) -> None:
        """Correct the path by all closures. Call this after the last scan."""
        if self._closer is not None and self.slam is not None:
            self._correct(self._closer.take(math.inf))
            self._correct(self._closer.finish(self.slam.snapshot()))

    def follow_former(self, odom_in_map: Sequence[float], base_in_odom: Sequence[float]) -> None:
        """Begin in the frame of a map that is gone, as that of a node that died in flight.

        Odometry tells the way since then. If it has begun anew meanwhile, the vehicle counts as at rest.

        Args:
            odom_in_map: x, y in m and yaw in rad of odometry's frame in that map, when it was lost.
            base_in_odom: the same of the base in odometry's frame.
        """
        self._former = np.asarray(odom_in_map, float), np.asarray(base_in_odom, float)

    def _start_after(self, former: tuple[np.ndarray, np.ndarray], base: np.ndarray) -> np.ndarray:
        odom_in_map, last = former
        has_begun_anew = math.hypot(*base[:2]) < NEAR_M and math.hypot(*last[:2]) > LEEWAY_M
        return se2.compose(odom_in_map, last if has_begun_anew else base)

    def _begin(self, base: np.ndarray) -> GridSlam:
        if self._former is not None:
            self._starting_pose = tuple(self._start_after(self._former, base).tolist())
        slam = GridSlam(
            self.parameters,
            self._starting_map,
            base.tolist() if self._starting_pose is None else self._starting_pose,
            self.localisation_only,
            keep_scans=self._closer is not None,
        )
        slam.odometry_in_space = self._is_in_space and self._closer is not None
        if self._mapped is not None:
            slam.take_over_map(self._mapped)
            self._mapped = None
        if self._former is not None:
            slam.tracking.begin_apart(APART)
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
        grid = self._starting_map if self.slam is None else self.slam.grid()
        check_given_pose(pose, covariance, grid)
        if self.slam is None:
            self._starting_pose = (float(pose[0]), float(pose[1]), float(pose[2]))
            self._starting_covariance = np.array(covariance, float)
            return
        self.slam.relocate(pose, np.array(covariance, float), self._odometry.last_s)
        if self._closer is not None:
            self._closer.drop()
        self._supervisor.doubt(self.slam, "the pose was given")

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
    def odometry_has_jumped(self) -> bool:
        """Whether odometry has jumped before the newest scan. It does not tell the way of that step."""
        return self._odometry.has_jumped

    @property
    def map_to_odom(self) -> tuple[float, float, float] | None:
        """Pose of the odometry's frame in the map (x, y, yaw); None if the first scan must decide it."""
        if self.slam is None:
            return (0.0, 0.0, 0.0) if self._starting_pose is None else None
        odom = se2.compose(self.slam.map_to_odom, self._odometry.odom_in_continuous)
        return tuple(odom.tolist())

    @property
    def rise_m(self) -> float:
        """How much higher the odometry's frame is in the map than at the start, by closed loops."""
        return 0.0 if self.slam is None else self.slam.rise_m

    @property
    def tracking(self) -> TrackingMonitor | None:
        """Whether the vehicle is tracked, and the numbers that say so; None before the first scan."""
        return None if self.slam is None else self.slam.tracking

    @property
    def told_state(self) -> str:
        """The state as others are told it: without sight for too long, it is lost, though nothing searches.

        Before the first scan it is uncertain.
        """
        if self.slam is None:
            return UNCERTAIN
        return LOST if self.sight.is_lost else self.slam.tracking.state

    @property
    def covariance(self) -> np.ndarray:
        """(3, 3) of the base in the map: x, y in m and yaw in rad. It grows until a loop is closed.

        It is what all steps and closures together tell, from where the map began on. Without loop closure it
        is 0.
        """
        return np.zeros((3, 3)) if self._closer is None else self._closer.spread.in_map

    @property
    def search(self) -> str:
        """Describes how far the search for a lost vehicle is; empty if there is none."""
        return self._supervisor.search

    @property
    def closures(self) -> list[Closure]:
        """The loops closed so far."""
        return [] if self._closer is None else self._closer.closures

    @property
    def loose_parts_s(self) -> list[float]:
        """Stamps at which parts of the map begin that no scan and no closure joins with others.

        Odometry alone tells where they are. This is as of the last search for loops, or of `finish`. Without
        loop closure it is not known.
        """
        return [] if self._closer is None else self._closer.loose_parts_s

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

    def state(self) -> SessionState:
        """Return the complete state. A session that is made from it goes on exactly as this one.

        Raises:
            StateError: there is none before the first scan.
        """
        if self.slam is None:
            raise StateError("There is nothing to save before the first scan.")
        return SessionState(
            self.slam.state(),
            self._odometry.state(),
            self.slam.tracking.state_to_save(),
            self._supervisor.state(),
            self._slices.state(),
            None if self._closer is None else self._closer.state(),
        )

    @classmethod
    def from_state(
        cls,
        state: SessionState,
        say: Callable[[str], None] = warnings.warn,
        threads: int | None = None,
        odometry_in_space: bool = False,
    ) -> SlamSession:
        """Return the session that goes on from a state. See `GridSlam.from_state` and the class."""
        slam = GridSlam.from_state(state.filter, threads)
        session = cls(slam.parameters, None, localisation_only=slam.localisation_only, say=say)
        session.slam, session._is_resumed = slam, True
        session._odometry.restore(state.odometry)
        slam.tracking.restore(state.tracking)
        session._supervisor.restore(state.supervisor)
        if state.closer is not None:
            session._closer = _closer_class().from_state(state.closer, slam.snapshot().odometry)
            session._slices = SliceWatch(session._closer.parameters.height_band_m)
        session._slices.restore(state.slices)
        slam.odometry_in_space = odometry_in_space and session._closer is not None
        return session


def _closer_class() -> type[LoopCloser]:
    from gridslam.loop_closure.closer import LoopCloser  # only if it is used, because it slows the start

    return LoopCloser
