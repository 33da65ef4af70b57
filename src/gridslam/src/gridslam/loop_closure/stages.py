"""Runs the stages on a snapshot, and remembers what the next snapshot needs: links, matches and closures."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from gridslam import se2
from gridslam.loop_closure.candidates import Candidate, Revisit, far_candidates, near_candidates
from gridslam.loop_closure.consistent_set import MatchSet, UncorrectedPath
from gridslam.loop_closure.correction import AT_THE_END, ON_THE_WAY, Correction, Effort, corrected_poses
from gridslam.loop_closure.edges import Closure, Match
from gridslam.loop_closure.links.scan_links import ScanLinks, ScanLinksState
from gridslam.loop_closure.local_maps.local_map import LocalMap
from gridslam.loop_closure.local_maps.stretches import LocalMaps
from gridslam.loop_closure.matches import match
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.alternatives import Alternatives, ScansAround, contradicting_steps
from gridslam.loop_closure.path.contradiction import contradicted_m
from gridslam.loop_closure.path.error_share import error_shares
from gridslam.loop_closure.path.loose_parts import loose_parts
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.pose_spread import (
    NO_SPREAD,
    PoseSpread,
    pose_spread,
    systematic_errors,
    with_usual_errors,
)
from gridslam.loop_closure.path.step_uncertainty import (
    BY_ODOMETRY,
    DoubtfulNodes,
    StepUncertainty,
    step_uncertainty,
)
from gridslam.loop_closure.snapshot import Snapshot
from gridslam.loop_closure.space.heights import climb_sigmas_m, fitted_heights, step_variances_m2
from gridslam.loop_closure.space.path_clouds import PathClouds
from gridslam.loop_closure.space.space_match import match_in_space
from gridslam.maps.tile_pool import require_indices

BENT_M = 0.1
"""m: a closure may fit the path at both its nodes, and tell that it is bent by more than this in between."""
CLIMB_SIGMAS = 2.0
"""A climb that differs from the path's by so many standard deviations is off."""


@dataclass(frozen=True, eq=False)
class StagesState:
    """What is remembered between snapshots, to save it and go on."""

    path: MeasuredPath
    links: ScanLinksState
    matches: MatchSet
    counted: tuple[int, ...]
    """Indices of the matches that count."""
    searched_far_m: float
    agreed: bool
    open_m: float
    recognised: int
    """Newest node at which a place was found again, and the path was right; 0: none."""
    spread_since_m: float
    spread_in_map: np.ndarray
    """(3, 3) see `PoseSpread`."""
    error_share: float


class Stages:
    """Snapshot -> candidates -> matches -> consistent set -> correction.

    `on_the_way`, `at_rest` and `at_the_end` run them. Each takes the snapshot, and the nodes whose steps are
    in doubt. A closure is a match that counts: an index in ``_counted``.
    """

    def __init__(self, parameters: LoopClosureParameters) -> None:
        self._parameters = parameters
        self._path, self._maps = MeasuredPath.empty(), LocalMaps(parameters)
        self._clouds = PathClouds(parameters)
        self._links = ScanLinks(parameters)
        self._scans_around = ScansAround(self._maps, parameters)
        self._matches = MatchSet()
        self._counted: tuple[int, ...] = ()
        """Indices of the matches that count."""
        self._searched_far_m = 0.0
        self.agreed = False
        """Whether the last search found a place again, and the path and another match agreed with it."""
        self.open_m = 0.0
        """How far the newest pose may be off by what is not decided: a single match, an open step, or a
        closure that the path contradicts."""
        self._recognised = 0
        self.spread: PoseSpread = NO_SPREAD
        """How uncertain the newest pose is."""
        self.loose_parts_s: list[float] = []
        """Stamps at which parts of the path begin that odometry alone joins with all others."""

    def on_the_way(self, snapshot: Snapshot, doubtful: DoubtfulNodes) -> Correction | None:
        """Search for the newest node's place. Return a correction if other closures count than before."""
        self._follow(snapshot)
        correction = self._searched(snapshot, doubtful)
        self.open_m = 0.0 if self.agreed else self._open_m(doubtful)
        self._measure_spread(doubtful, self.agreed or correction is not None)
        self.find_loose_parts(doubtful)
        return correction

    def _searched(self, snapshot: Snapshot, doubtful: DoubtfulNodes) -> Correction | None:
        """Return the correction that a search for the newest node leads to."""
        is_one_map = snapshot.first_in_map == 0
        if is_one_map and self._counted and self._newest_scan_agrees():
            self.agreed = True
            return None
        found = self._search(snapshot, doubtful)
        if not found:
            return None
        before, self._counted = set(self._counted), self._chosen()
        changed = before ^ set(self._counted)
        self.agreed = not set(self._counted).isdisjoint(found) and not any(map(self._is_off, found))
        is_joined = self._first_in_map(snapshot) != snapshot.first_in_map
        if not changed and not is_joined:
            return None
        is_off = any(map(self._is_off, changed))
        corrected = self._corrected(ON_THE_WAY, doubtful)
        if not is_off and self._moved_m(corrected) <= BENT_M and not is_joined:
            return None
        return self._correction(snapshot, corrected)

    def at_the_end(self, snapshot: Snapshot, doubtful: DoubtfulNodes, is_searched: bool) -> Correction | None:
        """Return the correction by all links and closures, or None if there is no closure.

        ``is_searched``: the newest node's place was searched for already.
        """
        self._decide(snapshot, doubtful, is_searched)
        if not self._counted:
            return None
        return self._correction(snapshot, self._corrected(AT_THE_END, doubtful))

    def at_rest(self, snapshot: Snapshot, doubtful: DoubtfulNodes, is_searched: bool) -> Correction | None:
        """Decide what is pending. Return the correction, or None if the same closures count as before.

        ``is_searched``: the newest node's place was searched for already.
        """
        before = self._counted
        self._decide(snapshot, doubtful, is_searched)
        corrected = None if self._counted == before else self._corrected(AT_THE_END, doubtful)
        correction = None if corrected is None else self._correction(snapshot, corrected)
        self.open_m = self._open_m(doubtful)
        self._measure_spread(doubtful, correction is not None)
        self.find_loose_parts(doubtful)
        return correction

    @property
    def is_pending(self) -> bool:
        """Whether one of the last nodes was recognised, and no other match agrees yet."""
        return bool(self._undecided())

    def closures(self) -> list[Closure]:
        """Return the closures that count. Later matches may outvote one."""
        return [self._closure(self._matches.matches[index]) for index in self._counted]

    def find_loose_parts(self, doubtful: DoubtfulNodes) -> None:
        """Note where parts of the path begin that odometry alone joins with all others."""
        path, self.loose_parts_s = self._path, []
        is_open = step_uncertainty(path, self._links.is_spanned(), doubtful, self._parameters).is_open
        if is_open.any():
            nodes = np.arange(1, len(path))[is_open].tolist()
            closures = [self._matches.matches[index] for index in self._counted]
            begins = loose_parts(nodes, [*self._links.edges, *closures], len(path))
            self.loose_parts_s = path.stamps_s[begins].tolist()

    def state(self) -> StagesState:
        """Return what is remembered."""
        return StagesState(
            self._path,
            self._links.state(),
            self._matches,
            self._counted,
            self._searched_far_m,
            self.agreed,
            self.open_m,
            self._recognised,
            self.spread.since_recognised_m,
            self.spread.in_map,
            self.spread.error_share,
        )

    def restore(self, state: StagesState, scans: int) -> None:
        """Go on from a state, on a path of at least so many scans.

        Raises:
            ValueError: it points at what is not there.
        """
        nodes, matches = len(state.path), state.matches.matches
        if nodes > scans:
            raise ValueError(f"the path of the loop closure has {nodes} nodes, the filter's {scans}")
        ends = np.array([(match.older, match.newer) for match in matches], int)
        require_indices(ends, nodes - 1, "the matches' nodes")
        require_indices(np.array(state.counted, int), len(matches) - 1, "the matches that count")
        self._links.restore(state.links, nodes)
        self._path, self._matches, self._counted = state.path, state.matches, state.counted
        self._searched_far_m, self.agreed = state.searched_far_m, state.agreed
        self.open_m = float(state.open_m)
        self._recognised = int(state.recognised)
        require_indices(np.array(self._recognised), max(nodes, 1) - 1, "the node that was recognised")
        in_map = np.array(state.spread_in_map, float)
        self.spread = PoseSpread(float(state.spread_since_m), in_map, float(state.error_share))

    def _follow(self, snapshot: Snapshot) -> None:
        """Measure the path's new steps, and link its new scans."""
        self._clouds.extend(snapshot.clouds)
        self._maps.extend(snapshot.scans)
        self._path = self._path.followed(snapshot, self._maps.informations, self._parameters)
        self._links.extend(snapshot.scans, self._path)

    def _newest_scan_agrees(self) -> bool:
        """Return whether the newest scan's links agree with the path. They do not tell what a cloud would."""
        path = self._path
        return not self._clouds.known(path)[-1] and self._links.agrees(
            path.poses, path.way_m, self._parameters.correction_min_m
        )

    def _search(self, snapshot: Snapshot, doubtful: DoubtfulNodes) -> list[int]:
        """Look for the newest node's place, near and then far. Return the indices of the new matches."""
        p, way_m = self._parameters, self._path.way_m[-1]
        revisit, maps = self._revisit(snapshot, len(self._path) - 1), self._maps
        self.agreed = False
        candidates, recent = near_candidates(revisit, p), None
        if candidates:
            recent = maps.around(self._path, revisit.newer)
            found = self._matched(candidates, recent)
            if found:
                return self._remember(found, doubtful)
        found = self._matched_in_space(self._revisit_in_space(snapshot, revisit.newer))
        if found:
            return self._remember(found, doubtful)
        if way_m - self._searched_far_m < p.search_far_m:
            return []
        self._searched_far_m = way_m
        steps = self._way_uncertainty(doubtful).covariances
        recent = recent or maps.around(self._path, revisit.newer)
        candidates = far_candidates(revisit, steps, recent, maps, p)
        return self._remember(self._matched(candidates, recent), doubtful)

    def _decide(self, snapshot: Snapshot, doubtful: DoubtfulNodes, is_searched: bool) -> None:
        """Search for the newest node, and for the last ones if a match there is pending."""
        self._follow(snapshot)
        if not is_searched and self._search(snapshot, doubtful):
            self._counted = self._chosen()
        self._search_last_nodes(snapshot, doubtful)

    def _undecided(self) -> list[int]:
        """Return the matches of the last nodes, if none of them counts yet."""
        way_m, matches = self._path.way_m, self._matches.matches
        first_m = way_m[-1] - self._parameters.stretch_m if len(way_m) else 0.0
        last = [index for index, match in enumerate(matches) if way_m[match.newer] > first_m]
        return last if set(last).isdisjoint(self._counted) else []

    def _search_last_nodes(self, snapshot: Snapshot, doubtful: DoubtfulNodes) -> None:
        """Search for the last nodes once more, if one of them was recognised and no other match agrees yet.

        Where the way ends, others cannot be found any more. But all that was seen after a node is known.
        """
        p, way_m, last = self._parameters, self._path.way_m, self._undecided()
        if not last:
            return
        searched = {self._matches.matches[index].newer for index in last}
        for node in reversed(np.flatnonzero(way_m > way_m[-1] - p.stretch_m).tolist()):
            is_near = any(abs(way_m[node] - way_m[other]) < p.search_every_m for other in searched)
            if node not in searched and not is_near:
                searched.add(node)
                candidates = near_candidates(self._revisit(snapshot, node), p)
                found = self._matched(candidates, self._maps.around(self._path, node)) if candidates else []
                found = found or self._matched_in_space(self._revisit_in_space(snapshot, node))
                self._remember(found, doubtful)
        self._counted = self._chosen()

    def _revisit(self, snapshot: Snapshot, node: int) -> Revisit:
        counted = [self._matches.matches[index] for index in self._counted]
        is_usable = snapshot.is_usable & snapshot.in_band(node, self._parameters.height_band_m)
        return Revisit(self._path, node, counted, is_usable, snapshot.first_in_map)

    def _revisit_in_space(self, snapshot: Snapshot, node: int) -> Revisit:
        is_usable = snapshot.is_usable & self._clouds.known(self._path)
        return self._revisit(snapshot, node)._replace(is_usable=is_usable)

    def _matched(self, candidates: list[Candidate], recent: LocalMap) -> list[Match]:
        """Return the candidates whose level scans agree, and whose clouds do if there are any."""
        tried = (match(each, self._path, recent, self._maps, self._parameters) for each in candidates)
        known = self._clouds.known(self._path)
        checked = [
            self._in_space(each, planar) if known[each.older] and known[each.newer] else planar
            for each, planar in zip(candidates, tried)
            if planar is not None
        ]
        return [found for found in checked if found is not None]

    def _matched_in_space(self, revisit: Revisit) -> list[Match]:
        """Return the near candidates whose clouds agree, from whatever height."""
        if not self._clouds.known(self._path)[revisit.newer]:
            return []
        tried = (self._in_space(each, None) for each in near_candidates(revisit, self._parameters))
        return [found for found in tried if found is not None]

    def _in_space(self, candidate: Candidate, planar: Match | None) -> Match | None:
        counted = [self._matches.matches[index] for index in self._counted]
        sigmas_m = climb_sigmas_m(self._path, counted, candidate.newer, self._parameters)
        return match_in_space(candidate, planar, self._path, self._clouds, sigmas_m, self._parameters)

    def _remember(self, found: list[Match], doubtful: DoubtfulNodes) -> list[int]:
        """Add matches to those known. Return their indices."""
        first = len(self._matches.matches)
        if found:
            covariances = self._way_uncertainty(doubtful).covariances
            climbs = step_variances_m2(self._path, self._parameters)
            path = UncorrectedPath(self._path, covariances, climbs)
            for each in found:
                self._matches = self._matches.with_match(each, path, self._parameters)
        return list(range(first, first + len(found)))

    def _chosen(self) -> tuple[int, ...]:
        return self._matches.closures(self._path.way_m, self._parameters)

    def _step_uncertainty(self, doubtful: DoubtfulNodes) -> StepUncertainty:
        """Return how uncertain the steps are. Wrong ones, by link and odometry, count as not measured."""
        scale = self._links.odometry_scale(self._path.odometry)
        is_spanned, wrong = self._links.is_spanned().copy(), self._links.wrong_steps(self._path)
        is_spanned[wrong - 1] = False
        doubtful = replace(doubtful, unmatched=(*doubtful.unmatched, *wrong.tolist()))
        return step_uncertainty(self._path, is_spanned, doubtful, self._parameters, scale)

    def _alternatives(self, uncertainty: StepUncertainty) -> Alternatives:
        """Return the steps of which either the filter's or odometry's holds, as scans decide them."""
        is_linked = self._links.information().any(axis=(1, 2))
        steps = contradicting_steps(self._path, uncertainty, is_linked, self._parameters.chi_square_max)
        return self._scans_around.ask(self._path, steps, uncertainty.by_odometry)

    def _way_uncertainty(self, doubtful: DoubtfulNodes) -> StepUncertainty:
        """Return how uncertain the steps are. Where scans decide for odometry, the filter erred."""
        uncertainty = self._step_uncertainty(doubtful)
        found = self._alternatives(uncertainty)
        return uncertainty.if_either(found.steps[found.choices == BY_ODOMETRY])

    def _is_off(self, index: int) -> bool:
        """Return whether the present path differs from a match's measurement."""
        match, path, least_m = self._matches.matches[index], self._path, self._parameters.correction_min_m
        here = se2.between(path.poses[match.older], path.poses[match.newer])
        climb_m = path.heights_m[match.newer] - path.heights_m[match.older]
        is_higher = abs(climb_m - match.climb_m) > max(least_m, CLIMB_SIGMAS * match.climb_sigma_m)
        return bool(is_higher or math.dist(here[:2], match.newer_in_older[:2]) > least_m)

    def _first_in_map(self, snapshot: Snapshot) -> int:
        """Return the node at which the present map begins; 0 if closures join it with the earlier one."""
        first = snapshot.first_in_map
        counted = (self._matches.matches[index] for index in self._counted)
        return 0 if any(match.older < first <= match.newer for match in counted) else first

    def _corrected(self, effort: Effort, doubtful: DoubtfulNodes) -> MeasuredPath:
        closures = [self._matches.matches[index] for index in self._counted]
        uncertainty, path, p = self._step_uncertainty(doubtful), self._path, self._parameters
        found = self._alternatives(uncertainty)
        poses = corrected_poses(path, uncertainty, found, self._links, closures, effort, p)
        return path.corrected_to(poses, fitted_heights(path, closures, p))

    def _open_m(self, doubtful: DoubtfulNodes) -> float:
        """Return how far the newest pose is from where undecided matches, or open steps, would put it.

        So far it may also be off if the newest closure contradicts the corrected path.
        """
        path, newest = self._path, self._path.poses[-1, :2]
        found_m = [contradicted_m(path.poses, [self._matches.matches[index] for index in self._counted])]
        for index in self._undecided():
            match = self._matches.matches[index]
            here = se2.between(path.poses[match.older], path.poses[match.newer])
            found_m.append(math.dist(here[:2], match.newer_in_older[:2]))
        uncertainty = self._step_uncertainty(doubtful)
        last = max((self._matches.matches[index].newer for index in self._counted), default=0)
        open_steps = self._alternatives(uncertainty).since(last)
        found_m += [math.dist(end, newest) for end in open_steps.ends(path, uncertainty)]
        return max(found_m)

    def _measure_spread(self, doubtful: DoubtfulNodes, is_recognised: bool) -> None:
        """Note how uncertain the newest pose is. is_recognised: its place was found again, and is right."""
        newest = len(self._path) - 1
        proved = min(max(doubtful.proved, self._recognised), newest)
        self._recognised = newest if is_recognised else proved
        way = self._way_uncertainty(doubtful)
        steps = way.covariances
        closures = [self._matches.matches[index] for index in self._counted]
        path, links, p = self._path, self._links.stacked_back(), self._parameters
        systematic_m = systematic_errors(path, steps, way.odometry_covariances, way.share_off)
        spread = pose_spread(path, steps, closures, self._recognised, systematic_m)
        spread_m2 = float(spread.in_map[0, 0] + spread.in_map[1, 1])
        shares = error_shares(path, steps, links, closures, p.support_m, spread_m2)
        self.spread = with_usual_errors(spread, path, steps, closures, shares, p)

    def _moved_m(self, corrected: MeasuredPath) -> float:
        """Return by how much a pose of the path moves at most, or a height."""
        level_m = np.hypot(*(corrected.poses - self._path.poses)[:, :2].T).max()
        climbed_m = np.abs(np.nan_to_num(corrected.heights_m - self._path.heights_m)).max()
        return float(max(level_m, climbed_m))

    def _correction(self, snapshot: Snapshot, corrected: MeasuredPath) -> Correction:
        """Return a correction to a path. Its map is not drawn yet."""
        self._path = corrected
        first = self._first_in_map(snapshot)
        heights_m = corrected.heights_m if np.isfinite(corrected.heights_m).all() else None
        draw = partial(snapshot.map_of, corrected.poses, first)
        return Correction(corrected.poses, first, None, heights_m, draw)

    def _closure(self, match: Match) -> Closure:
        stamps = self._path.stamps_s
        x, y, yaw = match.newer_in_older.tolist()
        return Closure(float(stamps[match.older]), float(stamps[match.newer]), (x, y, yaw), match.score)
