"""Steps that no link spans: the filter's step and odometry's are alternatives. One holds, never their mean.

A scan that was matched with the map may have been matched wrongly, and wheels may have slipped. If both
happened in part, the mean would be right; but each happens as a whole or not at all. So the scans around the
step decide, then the closures, and last how far odometry may err. Compare E. Olson and P. Agarwal, "Inference
on networks of mixtures for robust robot mapping" (IJRR 2013), whose edges hold by their likeliest mode, too.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverse
from gridslam.loop_closure.edges import Edge, Edges, Match
from gridslam.loop_closure.links.scan_pairs import LEAST_COVARIANCE
from gridslam.loop_closure.local_maps.correlation import Correlation, Optimum, Window
from gridslam.loop_closure.local_maps.refinement import match_information, refine
from gridslam.loop_closure.local_maps.stretches import SCAN_SPACING_M, LocalMaps
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath, chained
from gridslam.loop_closure.path.step_uncertainty import StepUncertainty
from gridslam.tracking.wrong_steps import apart

APART_MIN, UNSEEN_APART_MIN = 0.5, 1.0
"""Steps that differ by less than this, times APART_M or APART_RAD, are one. The second counts if scans do not
tell.
"""
SCORE_MARGIN = 0.1
"""Scans decide for the step whose score is better by this."""
REACH = np.array((0.15, 0.15, 0.03))
"""m, m, rad: each score is the best one so near to its step, as both stretches are slightly bent."""
GATE_M = 0.2
"""m: points of both stretches that are farther apart are no pair."""
FLIPS_MAX = 6
"""Closures are asked about so many steps at most in a correction, those that differ most first."""
COST_MARGIN = 4.0
"""Closures decide for the other step if the graph's cost falls by more than this."""


@dataclass(frozen=True, eq=False)
class Alternatives:
    """Steps that are either the filter's or odometry's, and which of them holds so far."""

    steps: np.ndarray
    """(n,) indices of the path's steps."""
    is_by_odometry: np.ndarray
    """(n,) whether odometry's holds."""
    is_seen: np.ndarray
    """(n,) whether scans have decided that."""
    links: Edges
    """The steps that scans have decided, as these measure them."""

    def applied(self, uncertainty: StepUncertainty) -> StepUncertainty:
        """Return the steps' uncertainty as decided."""
        return uncertainty.decided(self.steps[~self.is_by_odometry], self.steps[self.is_by_odometry])

    def flipped(self, which: int) -> Alternatives:
        """Return them with another choice for one of them."""
        is_by_odometry = self.is_by_odometry.copy()
        is_by_odometry[which] = not is_by_odometry[which]
        return replace(self, is_by_odometry=is_by_odometry)

    def moved(self, which: int, path: MeasuredPath, uncertainty: StepUncertainty) -> np.ndarray:
        """Return the path's poses (k, 3), with all after one of the steps moved to where it leads."""
        step = self.steps[which]
        by = uncertainty.by_odometry[step] if self.is_by_odometry[which] else path.steps[step]
        poses = path.poses.copy()
        reached = se2.compose(poses[step], by)
        poses[step + 1 :] = se2.compose(reached, se2.between(poses[step + 1], poses[step + 1 :]))
        return poses


def alternatives(path: MeasuredPath, uncertainty: StepUncertainty, scans: ScansAround) -> Alternatives:
    """Return the steps that no link spans, and at which the filter's and odometry's differ.

    Where the scans around a step do not tell which one holds, they did not measure it either, so odometry's
    does. If both differ by little then, they are no alternatives: each may err.
    """
    u = uncertainty
    differ = apart(path.steps, u.by_odometry)
    steps = np.flatnonzero(~u.is_spanned & ~u.is_open & (differ > APART_MIN))
    answers = scans.ask(path, steps.tolist())
    better = np.array([answer.for_odometry for answer in answers])
    is_seen = np.abs(better) > SCORE_MARGIN
    kept = np.flatnonzero(is_seen | (differ[steps] > UNSEEN_APART_MIN))
    links = [answers[k].link for k in kept if is_seen[k]]
    is_by_odometry = ~is_seen | (better > 0.0)
    return Alternatives(steps[kept], is_by_odometry[kept], is_seen[kept], Edges.of(links))


def asked_of_closures(
    found: Alternatives, path: MeasuredPath, uncertainty: StepUncertainty, closures: Sequence[Match]
) -> list[int]:
    """Return which of the alternatives lie between both nodes of a closure, and were not seen by scans."""
    inside = np.zeros(len(found.steps), bool)
    for closure in closures:
        inside |= (closure.older <= found.steps) & (found.steps < closure.newer)
    asked = np.flatnonzero(inside & ~found.is_seen)
    differ = apart(path.steps[found.steps[asked]], uncertainty.by_odometry[found.steps[asked]])
    return asked[np.argsort(-differ, kind="stable")][:FLIPS_MAX].tolist()


class Answer(NamedTuple):
    """What the scans before and after a step say of it."""

    for_odometry: float
    """By how much odometry's step fits them better than the filter's: a difference of scores."""
    link: Edge
    """The step as they measure it, near the one that fits better."""


class ScansAround:
    """Compares the stretches before and after a step. It remembers its answers."""

    def __init__(self, maps: LocalMaps, parameters: LoopClosureParameters) -> None:
        self._maps, self._parameters = maps, parameters
        self._answers: dict[tuple, Answer] = {}

    def ask(self, path: MeasuredPath, steps: Sequence[int]) -> list[Answer]:
        """Return what the scans around each step say.

        The maps of both stretches are made of the measured steps, which corrections leave as they are. A
        stretch ends at the next of these steps.
        """
        found = []
        for step in steps:
            first, last = _stretch(path, step, steps, self._parameters.stretch_m)
            by_odometry = se2.between(path.odometry[step], path.odometry[step + 1])
            key = (step, first, last, path.steps[first:last].tobytes(), by_odometry.tobytes())
            if key not in self._answers:
                self._answers[key] = self._compare(path, step, (first, last), by_odometry)
            found.append(self._answers[key])
        return found

    def _compare(
        self, path: MeasuredPath, step: int, ends: tuple[int, int], by_odometry: np.ndarray
    ) -> Answer:
        p, (first, last), poses = self._parameters, ends, path.poses.copy()
        poses[first : last + 1] = chained(np.zeros(3), path.steps[first:last])
        path = replace(path, poses=poses)
        before, after = (
            self._maps.of_nodes(path, nodes, anchor, SCAN_SPACING_M, p.resolution_m, p.blur_m)
            for nodes, anchor in (
                (np.arange(first, step + 1), step),
                (np.arange(step + 1, last + 1), step + 1),
            )
        )
        fits = []
        for predicted in (path.steps[step], by_odometry):
            search = Correlation(before, after, Window(predicted, *REACH[1:]))
            fits.append(search.best(0.0, p.overlap_min) or Optimum(predicted, 0.0))
        better = fits[1].score - fits[0].score
        start = fits[int(better > 0.0)].query_in_reference
        refined = refine(before.surface, after.surface, start, GATE_M)
        if not refined.pairs or (np.abs(se2.between(start, refined.query_in_reference)) > 2.0 * REACH).any():
            refined = replace(refined, query_in_reference=start, normal_matrix=np.zeros((3, 3)))
        information = match_information(refined.normal_matrix, refined.pairs, p) + np.diag(1.0 / REACH**2)
        link = Edge(step, step + 1, refined.query_in_reference, inverse(information) + LEAST_COVARIANCE)
        return Answer(better, link)


def _stretch(path: MeasuredPath, step: int, others: Sequence[int], reach_m: float) -> tuple[int, int]:
    """Return the first and the last node within some metres of a step, without another of these steps."""
    way_m = path.way_m
    first = int(np.searchsorted(way_m, way_m[step] - reach_m))
    last = int(np.searchsorted(way_m, way_m[step + 1] + reach_m, side="right")) - 1
    before, after = (other for other in others if other < step), (other for other in others if other > step)
    return max([first, *(other + 1 for other in before)]), min([last, *after])
