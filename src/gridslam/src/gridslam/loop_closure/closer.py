"""Loop closure beside the filter: decides when the stages run, and when the filter gets their correction."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Callable, NamedTuple

import numpy as np

from gridslam.loop_closure.background import BackgroundWork
from gridslam.loop_closure.correction import Correction
from gridslam.loop_closure.edges import Closure
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.pose_spread import NO_SPREAD, PoseSpread
from gridslam.loop_closure.path.step_uncertainty import DoubtfulNodes
from gridslam.loop_closure.snapshot import Snapshot
from gridslam.loop_closure.stages import Stages, StagesState
from gridslam.maps.tile_pool import require_indices
from gridslam.tracking.evidence import Agreement


@dataclass(frozen=True, eq=False)
class PendingState:
    """A correction that is not due yet."""

    begun_s: float
    due_s: float
    poses: np.ndarray | None
    """(k, 3) see `Correction`; None: the path stays as it is."""
    first_in_map: int
    heights_m: np.ndarray | None
    """(k,)"""


class Found(NamedTuple):
    """What a search tells of the pose, beside a correction."""

    agreed: bool
    """See `Stages`."""
    open_m: float
    """How far the newest node may be off by what is not decided."""
    spread: PoseSpread
    """How uncertain the newest node's pose is."""


@dataclass(frozen=True, eq=False)
class CloserState:
    """The complete state of a `LoopCloser`."""

    parameters: LoopClosureParameters
    stages: StagesState
    doubtful: DoubtfulNodes
    closures: tuple[Closure, ...]
    pending: PendingState | None
    way_m: float
    searched_m: float
    newest_s: float
    decided_nodes: int
    has_agreed: bool
    spread_since_m: float
    spread_in_map: np.ndarray
    """(3, 3) see `PoseSpread`."""
    error_share: float


class LoopCloser:
    """Gets snapshots of a filter that keeps its scans, and returns corrections.

        correction = closer.take(scan.stamp_s)  # before each scan
        if correction is not None:
            slam.correct(correction)
        if slam.process(scan, base_in_odom):
            closer.add_node(scan.stamp_s, base_in_odom)
            if closer.is_search_due:
                closer.search(slam.snapshot())  # in another thread

    The stages run in one thread beside the filter. Their result is taken at a fixed stamp, so the same scans
    give the same map.
    """

    def __init__(self, parameters: LoopClosureParameters | None = None) -> None:
        self.parameters = parameters or LoopClosureParameters()
        self._stages = Stages(self.parameters)
        self._thread = ThreadPoolExecutor(1, "loop_closure")
        self._work: BackgroundWork | None = None
        self.draws_beside = True
        """Whether the map of a correction is drawn in the thread, too, so that no scan waits for it."""
        self._base_in_odom: np.ndarray | None = None
        self._nodes = self._decided_nodes = 0
        """Number of nodes so far, and when what was pending was decided last."""
        self._newest_s = math.nan
        """Stamp of the newest node."""
        self._way_m = self._searched_m = 0.0
        """Lengths of odometry's way so far, and up to the last search."""
        self._doubtful = DoubtfulNodes()
        self.closures: list[Closure] = []
        """The closures that count at present. A closure stops counting when later ones contradict it."""
        self.found: Found | None = None
        """What the last `take` has found of the pose; None: nothing was due."""
        self.has_agreed = False
        """Whether the last search that was taken found a place again, and the path was right there."""
        self.spread = NO_SPREAD
        """How uncertain the newest node of the last search was that was taken."""
        self.loose_parts_s: list[float] = []
        """Stamps at which parts of the path begin whose places odometry alone tells, by that search, or by
        `finish`."""

    def add_node(self, stamp_s: float, base_in_odom: np.ndarray, agreement: Agreement | None = None) -> None:
        """Take notice of a scan that the filter has processed.

        Args:
            stamp_s: of the scan.
            base_in_odom: (3,) odometry at the scan.
            agreement: of the scan with the map; None: it was not compared.
        """
        if agreement is not None:
            self._doubtful = self._doubtful.with_scan(self._nodes, agreement)
        base = np.array(base_in_odom, float)
        if self._base_in_odom is not None:
            self._way_m += math.dist(base[:2], self._base_in_odom[:2])
        self._base_in_odom, self._nodes, self._newest_s = base, self._nodes + 1, stamp_s

    @property
    def is_search_due(self) -> bool:
        """Whether a search is to begin at the newest node: no other one is at work, and the way is enough."""
        if self._work is not None:
            return False
        p = self.parameters
        every_m = p.search_agreed_m if self._stages.agreed else p.search_every_m
        return self._way_m - self._searched_m >= every_m

    def search(self, snapshot: Snapshot) -> None:
        """Begin to run the stages on a snapshot. `take` returns their correction later."""
        self._searched_m, doubtful = self._way_m, self._doubtful
        self._begin(float(snapshot.stamps_s[-1]), lambda: self._stages.on_the_way(snapshot, doubtful))

    @property
    def is_pending(self) -> bool:
        """Whether a place was recognised, and too little way has followed to find a second match.

        It waits for the work at hand.
        """
        if self._work is not None:
            self._work.result()
        return self._decided_nodes != self._nodes and self._stages.is_pending

    def is_decision_due(self, stamp_s: float) -> bool:
        """Return whether what is pending is to be decided, because there was no new node for `rest_s`.

        That is so after a landing, for example.
        """
        is_at_rest = stamp_s - self._newest_s >= self.parameters.rest_s
        return is_at_rest and self._work is None and self.is_pending

    def decide(self, snapshot: Snapshot, stamp_s: float) -> None:
        """Begin to decide what is pending, with all that is known at a stamp. `take` returns the result."""
        doubtful, is_searched = self._doubtful, self._way_m <= self._searched_m
        self._searched_m, self._decided_nodes = self._way_m, self._nodes
        self._begin(stamp_s, lambda: self._stages.at_rest(snapshot, doubtful, is_searched))

    def _begin(self, begun_s: float, work: Callable[[], Correction | None]) -> None:
        def drawn() -> Correction | None:
            correction = work()
            return correction if correction is None or not self.draws_beside else correction.drawn()

        self._work = BackgroundWork(self._thread, begun_s, begun_s + self.parameters.answer_s, drawn)

    def take(self, stamp_s: float) -> Correction | None:
        """Return the correction that is due at a scan's stamp, for the filter; None: the path is right.

        Call this before each scan that the filter gets. It waits for the result if need be.
        """
        self.found = None
        if self._work is None or not self._work.is_due(stamp_s):
            return None
        correction, self._work = self._work.result(), None
        self.closures = self._stages.closures()
        self.found = Found(self._stages.agreed, self._stages.open_m, self._stages.spread)
        self.spread = self.found.spread
        self.has_agreed = self.found.agreed
        self.loose_parts_s = self._stages.loose_parts_s
        return correction

    def drop(self, is_contradicted: bool = False) -> None:
        """Drop the correction at hand, because the vehicle has been put elsewhere since, or was lost.

        ``is_contradicted``: the scans contradicted odometry, and no other place was found.
        """
        self._doubtful = self._doubtful.with_new_place(self._nodes, is_contradicted)
        self.has_agreed = False
        if self._work is not None:
            self._work.result()
            self._work = None

    def prove(self) -> None:
        """Note that scans have proved the place on the map, after it was in doubt."""
        self._doubtful = self._doubtful.with_proof(self._nodes)

    def finish(self, snapshot: Snapshot) -> Correction | None:
        """Return the correction by all links and closures, with what is pending decided.

        Call this at the end of the log, after ``take(math.inf)``. Its map is not drawn yet.
        """
        if not len(snapshot):
            return None
        correction = self._stages.at_the_end(snapshot, self._doubtful, self._way_m <= self._searched_m)
        if correction is not None:
            self.closures = self._stages.closures()
        self._find_loose_parts()
        return correction

    def _find_loose_parts(self) -> None:
        self._stages.find_loose_parts(self._doubtful)
        self.loose_parts_s = self._stages.loose_parts_s

    def state(self) -> CloserState:
        """Return the complete state. It waits for the work at hand, whose result is taken when it is due."""
        pending, work = None, self._work
        if work is not None:
            found = work.result()
            taken = (None, 0, None) if found is None else (found.poses, found.first_in_map, found.heights_m)
            pending = PendingState(work.begun_s, work.due_s, *taken)
        return CloserState(
            self.parameters,
            self._stages.state(),
            self._doubtful,
            tuple(self.closures),
            pending,
            self._way_m,
            self._searched_m,
            self._newest_s,
            self._decided_nodes,
            self.has_agreed,
            self.spread.since_recognised_m,
            self.spread.in_map,
            self.spread.error_share,
        )

    @classmethod
    def from_state(cls, state: CloserState, odometry: np.ndarray) -> LoopCloser:
        """Return the closer that goes on from a state, beside a filter with odometry (k, 3) at its nodes.

        Raises:
            ValueError: the state points at what is not there.
        """
        closer, nodes = cls(state.parameters), len(odometry)
        closer._stages.restore(state.stages, nodes)
        closer._nodes, closer._base_in_odom = nodes, odometry[-1] if nodes else None
        closer._way_m, closer._searched_m = float(state.way_m), float(state.searched_m)
        closer.has_agreed = bool(state.has_agreed)
        in_map = np.array(state.spread_in_map, float)
        closer.spread = PoseSpread(float(state.spread_since_m), in_map, float(state.error_share))
        closer._newest_s, closer._decided_nodes = float(state.newest_s), int(state.decided_nodes)
        for doubtful in (state.doubtful.unmatched, state.doubtful.guessed, state.doubtful.contradicted):
            require_indices(np.array(doubtful, int), nodes, "the doubtful nodes")
        closer._doubtful, closer.closures = state.doubtful, list(state.closures)
        closer._find_loose_parts()
        if state.pending is not None:
            closer._work = closer._pending(state.pending, len(state.stages.path))
        return closer

    def _pending(self, state: PendingState, nodes: int) -> BackgroundWork:
        correction = None
        if state.poses is not None:
            if state.poses.shape != (nodes, 3):
                raise ValueError(f"the correction at hand has the shape {state.poses.shape}")
            require_indices(np.array(state.first_in_map), nodes - 1, "the first node of the correction's map")
            if state.heights_m is not None and state.heights_m.shape != (nodes,):
                raise ValueError(
                    f"the heights of the correction at hand have the shape {state.heights_m.shape}"
                )
            correction = Correction(state.poses, state.first_in_map, heights_m=state.heights_m)
        return BackgroundWork(self._thread, state.begun_s, state.due_s, lambda: correction)
