"""Loop closure: finds and tests revisited places, and corrects the path."""

from __future__ import annotations

import math
from concurrent.futures import ThreadPoolExecutor
from typing import Mapping, NamedTuple

import numpy as np

from gridslam import se2
from gridslam.filter.earlier_map import Usable
from gridslam.filter.particle_filter import GridSlam
from gridslam.loop_closure.chain import Chain
from gridslam.loop_closure.consistency import MeasuredPath, contradictions, largest_consistent, supported
from gridslam.loop_closure.edge import Closure, Edges, Match
from gridslam.loop_closure.job import Correction, Job
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.pose_graph import optimise
from gridslam.loop_closure.recognition import Recognition
from gridslam.loop_closure.scan_links import ScanLinks
from gridslam.maps.tile_pool import require_indices
from gridslam.scan import PlanarScan
from gridslam.tracking.evidence import Agreement, Evidence
from gridslam.trajectory import Trajectory

CHAIN, LINKS = "chain_", "links_"
"""Prefixes of the chain's and the links' arrays in a saved state."""
BENT_M = 0.1
"""m: a closure may fit the path at both its nodes, and tell that it is bent by more than this in between."""
SETTLED_M = 0.01
"""m: a correction ends when no pose has moved by more in a round of linking passes and optimising."""


class Effort(NamedTuple):
    """Limits of a correction."""

    rounds: int
    """It ends after this many rounds at the latest."""
    tolerance: float
    """See `optimise`."""


ON_THE_WAY, AT_THE_END = Effort(2, 1e-3), Effort(5, 1e-5)
"""The next correction mends what one on the way leaves."""


class LoopCloser:
    """Watches a filter that keeps its scans, and corrects it.

    The work is done in one thread beside the filter. Its result is taken at a fixed stamp, so the same scans
    give the same map.
    """

    def __init__(self, parameters: LoopClosureParameters | None = None) -> None:
        self.parameters = parameters or LoopClosureParameters()
        self._chain, self._links = Chain(self.parameters), ScanLinks(self.parameters)
        self._odometry: list[list[float]] = []
        self._way_m = 0.0
        """Length of odometry's way so far."""
        self._thread = ThreadPoolExecutor(1, "loop_closure")
        self._job: Job | None = None
        self._matches: list[Match] = []
        self._consistent = np.zeros((0, 0), dtype=bool)
        self._counted: list[Match] = []
        self._searched_m = self._searched_far_m = 0.0
        self._unmatched: list[int] = []
        self._guessed: list[int] = []
        self._contradicted: list[int] = []
        """Nodes as `Chain.loosen` takes them."""
        self._agreed = False
        """Whether the last search found a place again, and the path and another match agreed with it."""
        self.closures: list[Closure] = []
        """The closures that count at present. A closure stops counting when later ones contradict it."""

    def update(self, slam: GridSlam, base_in_odom: np.ndarray, evidence: Evidence | None = None) -> None:
        """Begin to search for a revisited place, unless the last search is still to be taken.

        Call this after each scan that the filter has processed, with the odometry (3,) at the scan, and
        what the scan said about the map.
        """
        if evidence is not None:
            self._note_unmatched(evidence.agreement)
        p, base = self.parameters, np.array(base_in_odom, float)
        self._way_m += math.dist(base[:2], self._odometry[-1][:2]) if self._odometry else 0.0
        self._odometry.append(base.tolist())
        every_m = p.search_agreed_m if self._agreed else p.search_every_m
        if self._job is None and self._way_m - self._searched_m >= every_m:
            self._searched_m = self._way_m
            path, scans, odometry = slam.trajectory(), slam.processed_scans(), np.array(self._odometry)
            begun_s, pieces = float(path.stamps_s[-1]), slam.pieces.snapshot(len(scans))
            due_s = begun_s + p.answer_s
            self._job = Job(
                self._thread, begun_s, due_s, lambda: self._work(slam, path, scans, odometry, pieces)
            )

    def _note_unmatched(self, agreement: Agreement) -> None:
        """Note which steps the scan at the newest node leaves unmeasured.

        Where scans are far apart, the filter may use one of which most beams contradict the map. Its pose is
        a guess then.
        """
        node = len(self._odometry)
        if not agreement.is_meaningful():
            self._unmatched.append(node)
        elif agreement.agreeing < agreement.clashing:
            self._guessed += [node, node + 1]

    def take(self, slam: GridSlam, stamp_s: float) -> bool:
        """Take over the result that is due at a scan's stamp. Return whether the path was corrected.

        Call this before each scan that the filter gets. It waits for the result if need be.
        """
        if self._job is None or not self._job.is_due(stamp_s):
            return False
        corrected, self._job = self._job.result(), None
        self.closures = [self._closure(match) for match in self._counted]
        if corrected is None:
            return False
        path, poses = slam.trajectory().poses_in_map, corrected.poses
        since = se2.between(path[len(poses) - 1], path[len(poses) :])
        draft = corrected.draft or slam.draft(corrected.begun)
        slam.adopt(np.vstack([poses, se2.compose(poses[-1], since)]), draft)
        return True

    def _apart(self, pieces: Usable) -> int:
        """Return the node at which the present map begins; 0 if closures join it with the earlier one."""
        begun = pieces.begun
        return 0 if any(match.older < begun <= match.newer for match in self._counted) else begun

    def forget(self, is_contradicted: bool = False) -> None:
        """Drop the result at hand, because the vehicle has been put elsewhere since its scan, or was lost.

        ``is_contradicted``: the scans contradicted odometry, and no other place was found.
        """
        (self._contradicted if is_contradicted else self._unmatched).append(len(self._odometry))
        if self._job is not None:
            self._job.result()
            self._job = None

    def finish(self, slam: GridSlam) -> None:
        """Give the filter the path corrected by all links and closures. Call this at the end of the log."""
        self.take(slam, math.inf)
        scans = slam.processed_scans()
        self._follow(slam.trajectory(), scans, np.array(self._odometry))
        pieces = slam.pieces.snapshot(len(scans))
        if self._way_m > self._searched_m and self._search(pieces):
            self._counted = self._choose()
        self._decide_pending(pieces)
        if self._counted:
            poses = self._corrected(AT_THE_END)
            self._chain.settle(poses)
            slam.adopt(poses, slam.draft(self._apart(pieces)))
            self.closures = [self._closure(match) for match in self._counted]

    def _work(
        self,
        slam: GridSlam,
        path: Trajectory,
        scans: list[PlanarScan],
        odometry: np.ndarray,
        pieces: Usable,
    ) -> Correction | None:
        """Follow the path, search for a place seen before. Return the corrected path, or None.

        The filter goes on meanwhile. Only its `draft` is used.
        """
        self._follow(path, scans, odometry)
        within_m = self.parameters.correction_min_m
        if (
            pieces.begun == 0
            and self._counted
            and self._links.agrees(self._chain.poses, self._chain.way_m, within_m)
        ):
            self._agreed = True
            return None
        found = self._search(pieces)
        if not found:
            return None
        before, self._counted = set(self._counted), self._choose()
        is_counted = any(match in self._counted for match in found)
        self._agreed = is_counted and not any(self._is_off(match) for match in found)
        begun = self._apart(pieces)
        if before == set(self._counted) and begun == pieces.begun:
            return None
        is_off = any(self._is_off(match) for match in before.symmetric_difference(self._counted))
        poses = self._corrected(ON_THE_WAY)
        moved_m = np.hypot(*(poses - self._chain.poses)[:, :2].T)
        if not is_off and moved_m.max() <= BENT_M and begun == pieces.begun:
            return None
        self._chain.settle(poses)
        draft = slam.draft(begun)
        draft.add(poses[begun:])
        return Correction(poses, draft, begun)

    def to_arrays(self) -> dict[str, np.ndarray]:
        """Return the closer's complete state without parameters, for `from_arrays`.

        It waits for the work at hand. Its result is taken when it is due.
        """
        job = self._job
        pending = None if job is None else job.result()
        matches, index = self._matches, {id(match): i for i, match in enumerate(self._matches)}
        return {
            **{CHAIN + name: values for name, values in self._chain.to_arrays().items()},
            **{LINKS + name: values for name, values in self._links.to_arrays().items()},
            "odometry": np.reshape(self._odometry, (-1, 3)),
            "due_s": np.array([] if job is None else [job.begun_s, job.due_s]),
            "closures": np.array(
                [(c.stamp_from_s, c.stamp_to_s, *c.pose_difference, c.score) for c in self.closures]
            ).reshape(-1, 6),
            "pending": np.empty((0, 3)) if pending is None else pending.poses,
            "pending_begun": np.array(0 if pending is None else pending.begun),
            "match_nodes": np.array([(match.older, match.newer) for match in matches], int).reshape(-1, 2),
            "match_poses": np.array([match.newer_in_older for match in matches]).reshape(-1, 3),
            "match_covariances": np.array([match.covariance for match in matches]).reshape(-1, 3, 3),
            "match_scores": np.array([match.score for match in matches]),
            "consistent": self._consistent,
            "counted": np.array([index[id(match)] for match in self._counted], int),
            "searched_m": np.array([self._way_m, self._searched_m, self._searched_far_m]),
            "unmatched": np.array(self._unmatched, int),
            "guessed": np.array(self._guessed, int),
            "contradicted": np.array(self._contradicted, int),
            "agreed": np.array(self._agreed),
        }

    def from_arrays(self, arrays: Mapping[str, np.ndarray], scans: list[PlanarScan]) -> None:
        """Go on from the output of `to_arrays`, on a filter that has processed these scans.

        Raises:
            KeyError: something lacks in it.
            ValueError: it points at what is not there.
        """
        chain, links = (
            {name[len(prefix) :]: arrays[name] for name in arrays if name.startswith(prefix)}
            for prefix in (CHAIN, LINKS)
        )
        self._chain.from_arrays(**chain)
        nodes = len(self._chain)
        if nodes > len(scans) or arrays["odometry"].shape != (len(scans), 3):
            raise ValueError(
                f"the chain has {nodes} nodes, the odometry {len(arrays['odometry'])}, the path {len(scans)}"
            )
        self._links.from_arrays(links, scans[:nodes])
        self._odometry = arrays["odometry"].tolist()
        require_indices(arrays["match_nodes"], nodes - 1, "the matches' nodes")
        require_indices(arrays["counted"], len(arrays["match_nodes"]) - 1, "the matches that count")
        columns = (arrays[f"match_{name}"] for name in ("nodes", "poses", "covariances", "scores"))
        self._matches = [
            Match(int(older), int(newer), pose, covariance, float(score))
            for (older, newer), pose, covariance, score in zip(*columns)
        ]
        self._consistent = arrays["consistent"]
        self._counted = [self._matches[i] for i in arrays["counted"]]
        self.closures = [
            Closure(since_s, to_s, (x, y, yaw), score)
            for since_s, to_s, x, y, yaw, score in arrays["closures"].reshape(-1, 6).tolist()
        ]
        self._way_m, self._searched_m, self._searched_far_m = arrays["searched_m"].tolist()
        self._agreed = bool(arrays["agreed"])
        noted = ("unmatched", "guessed", "contradicted")
        for name in noted:
            require_indices(arrays[name], len(scans), f"the {name} nodes")
        self._unmatched, self._guessed, self._contradicted = (arrays[n].ravel().tolist() for n in noted)
        pending = arrays["pending"] if len(arrays["pending"]) else None
        if pending is not None and pending.shape != (nodes, 3):
            raise ValueError(f"the correction at hand has the shape {pending.shape}")
        if arrays["due_s"].size:
            begun_s, due_s = arrays["due_s"].tolist()
            require_indices(arrays["pending_begun"], nodes - 1, "the first node of the correction's map")
            begun = int(arrays["pending_begun"])
            correction = None if pending is None else Correction(pending, begun=begun)
            self._job = Job(self._thread, begun_s, due_s, lambda: correction)

    def _follow(self, path: Trajectory, scans: list[PlanarScan], odometry: np.ndarray) -> None:
        self._chain.follow(path.stamps_s, path.poses_in_map, scans, odometry)
        self._links.extend(scans, self._chain.poses, odometry, self._chain.way_m)

    def _loosen(self) -> None:
        scale = self._links.odometry_scale(self._chain.odometry)
        is_seen = self._links.is_seen()
        self._chain.loosen(is_seen, self._unmatched, self._contradicted, scale, self._guessed)

    def _search(self, pieces: Usable) -> list[Match]:
        """Compare the newest local map with earlier ones. Return the matches that were found."""
        search, way_m = (
            Recognition(self._chain, self._counted, self.parameters, pieces),
            self._chain.way_m[-1],
        )
        found = search.near()
        self._agreed = False
        is_far_due = way_m - self._searched_far_m >= self.parameters.search_far_m
        if found or is_far_due:
            self._loosen()
        if not found and is_far_due:
            self._searched_far_m = way_m
            found = search.far()
        for match in found:
            self._remember(match)
        return found

    def _decide_pending(self, pieces: Usable) -> None:
        """Search for the last nodes once more, if one of them was recognised and no other match agrees yet.

        At the end of a log there is no more way on which others could be found. But all that was seen after
        a node is known.
        """
        p, way_m = self.parameters, self._chain.way_m
        first_m = way_m[-1] - p.stretch_m
        last = [match for match in self._matches if way_m[match.newer] > first_m]
        if not last or any(match in self._counted for match in last):
            return
        searched = {match.newer for match in last}
        for node in reversed(np.flatnonzero(way_m > first_m).tolist()):
            is_near = any(abs(way_m[node] - way_m[other]) < p.search_every_m for other in searched)
            if node not in searched and not is_near:
                searched.add(node)
                for match in Recognition(self._chain, self._counted, p, pieces, node).near():
                    self._remember(match)
        self._counted = self._choose()

    def _remember(self, match: Match) -> None:
        contradicted = contradictions(MeasuredPath(self._chain), match, self._matches)
        agrees = contradicted <= self.parameters.chi_square_max
        count = len(self._matches)
        grown = np.ones((count + 1, count + 1), dtype=bool)
        grown[:count, :count] = self._consistent
        grown[count, :count] = grown[:count, count] = agrees
        self._consistent = grown
        self._matches.append(match)

    def _choose(self) -> list[Match]:
        chosen = largest_consistent(self._consistent)
        kept = supported(self._matches, chosen, self._chain.way_m, self.parameters.support_m)
        return [self._matches[i] for i in kept]

    def _is_off(self, match: Match) -> bool:
        """Return whether the present path differs from a match's measurement."""
        here = se2.between(self._chain.poses[match.older], self._chain.poses[match.newer])
        return math.dist(here[:2], match.newer_in_older[:2]) > self.parameters.correction_min_m

    def _corrected(self, effort: Effort) -> np.ndarray:
        """Return the path (k, 3) that fits all measurements.

        The better the path, the more scans of different passes can be linked, and the other way round.
        """
        poses, links = self._chain.poses, self._links
        self._loosen()
        for round_ in range(effort.rounds):
            if round_ > 0 and not links.link_passes(poses, self._chain.way_m):
                break
            before = poses
            steps = self._chain.edges(links.information(), poses)
            edges = Edges.joined([steps, links.stacked(), Edges.of(self._counted)])
            poses = optimise(before, edges, effort.tolerance, is_far=round_ == 0)
            if round_ > 0 and np.abs(poses - before)[:, :2].max() < SETTLED_M:
                break
        return poses

    def _closure(self, match: Match) -> Closure:
        stamps = self._chain.stamps_s
        return Closure(
            float(stamps[match.older]),
            float(stamps[match.newer]),
            tuple(match.newer_in_older.tolist()),
            match.score,
        )
