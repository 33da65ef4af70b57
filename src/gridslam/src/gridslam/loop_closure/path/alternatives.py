"""Steps at which filter and odometry contradict each other, and no link of scans tells which one is right.

A scan that was matched with the map may have been matched wrongly, or wheels have slipped. Each happens as a
whole or not at all, so the mean of both steps is never right. The maps of both stretches, before and after
the step, decide if one step fits them clearly better. If not, closures may decide. Compare E. Olson and
P. Agarwal, "Inference on networks of mixtures for robust robot mapping" (IJRR 2013): edges hold by their
likeliest mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from typing import NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverse, inverses
from gridslam.loop_closure.edges import Edge, Edges, Match
from gridslam.loop_closure.links.scan_pairs import LEAST_COVARIANCE
from gridslam.loop_closure.local_maps.correlation import Correlation, Window
from gridslam.loop_closure.local_maps.local_map import LocalMap
from gridslam.loop_closure.local_maps.refinement import match_information, refine
from gridslam.loop_closure.local_maps.stretches import SCAN_SPACING_M, LocalMaps
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath, chained
from gridslam.loop_closure.path.step_uncertainty import (
    BY_FILTER,
    BY_ODOMETRY,
    UNDECIDED,
    StepUncertainty,
    odometry_share,
)
from gridslam.tracking.wrong_steps import MATCH_SIGMA, apart

APART_MIN = 1.0
"""Steps that differ by less than this, times APART_M or APART_RAD, are one."""
SCORE_MARGIN = 0.1
"""Scans decide for the step whose score is better by this."""
REACH_M, REACH_RAD = 0.15, 0.03
REACH = (REACH_M, REACH_M, REACH_RAD)
"""Each score is the best one so near to its step, as both stretches are slightly bent."""
GATE_M = 0.2
"""m: points of both stretches that are farther apart are no pair."""
DECIMALS = 4
"""Steps are compared to 0.1 mm, for rounding errors of corrections ask no new question."""
FLIPS_MAX = 6
"""Closures are asked about so many steps at most in a correction, those that differ most first."""


@dataclass(frozen=True, eq=False)
class Alternatives:
    """Steps that are either the filter's or odometry's, and which of them holds."""

    steps: np.ndarray
    """(n,) indices of the path's steps."""
    choices: np.ndarray
    """(n,) BY_FILTER, BY_ODOMETRY or UNDECIDED."""
    links: Edges = field(default_factory=lambda: Edges.of([]))
    """The steps that scans have decided, as these measure them."""

    def applied(self, uncertainty: StepUncertainty) -> StepUncertainty:
        """Return the steps' uncertainty as decided."""
        return uncertainty.decided(self.steps, self.choices)

    def with_choice(self, which: int, choice: int) -> Alternatives:
        """Return them with another choice for one of them."""
        choices = self.choices.copy()
        choices[which] = choice
        return replace(self, choices=choices)

    def moved(self, which: int, path: MeasuredPath, uncertainty: StepUncertainty) -> np.ndarray:
        """Return the path's poses (k, 3), with all after one of the steps moved to where its choice leads."""
        step, poses = self.steps[which], path.poses.copy()
        is_odometry = self.choices[which] == BY_ODOMETRY
        by = uncertainty.by_odometry[step] if is_odometry else path.steps[step]
        reached = se2.compose(poses[step], by)
        poses[step + 1 :] = se2.compose(reached, se2.between(poses[step + 1], poses[step + 1 :]))
        return poses

    def since(self, node: int) -> Alternatives:
        """Return those from a node on, without their links."""
        kept = self.steps >= node
        return Alternatives(self.steps[kept], self.choices[kept])

    def ends(self, path: MeasuredPath, uncertainty: StepUncertainty) -> list[np.ndarray]:
        """Return where (2,) each choice that is still possible puts the path's newest node."""
        found = []
        for which, chosen in enumerate(self.choices.tolist()):
            for choice in (BY_FILTER, BY_ODOMETRY) if chosen == UNDECIDED else (chosen,):
                found.append(self.with_choice(which, choice).moved(which, path, uncertainty)[-1, :2])
        return found

    def asked_of(self, closures: Sequence[Match]) -> list[int]:
        """Return which of them are undecided, and lie between both nodes of a closure."""
        inside = np.zeros(len(self.steps), bool)
        for closure in closures:
            inside |= (closure.older <= self.steps) & (self.steps < closure.newer)
        return np.flatnonzero(inside & (self.choices == UNDECIDED))[:FLIPS_MAX].tolist()


def contradicting_steps(
    path: MeasuredPath, uncertainty: StepUncertainty, is_linked: np.ndarray, chi_square_max: float
) -> np.ndarray:
    """Return the steps (n,) that no link measures, and whose two measurements exclude each other.

    They differ by APART_MIN, and by more than both uncertainties allow. Odometry counts as good as it is
    elsewhere on the path. The step that differs most comes first.

    Args:
        path: k nodes.
        uncertainty: of its steps.
        is_linked: (k - 1,) whether a link joins the step's newer node with one before it.
        chi_square_max: of two measurements that agree.
    """
    u = uncertainty
    differ = apart(path.steps, u.by_odometry)
    steps = np.flatnonzero(~u.is_spanned & ~is_linked & ~u.is_open & (differ > APART_MIN))
    if not len(steps):
        return steps
    error = se2.between(u.by_odometry[steps], path.steps[steps])
    of_odometry = odometry_share(u, path.poses) * u.odometry_covariances[steps]
    information = inverses(path.covariances[steps] + np.diag(MATCH_SIGMA**2) + of_odometry)
    steps = steps[np.einsum("ni,nij,nj->n", error, information, error) > chi_square_max]
    return steps[np.argsort(-differ[steps], kind="stable")]


class Answer(NamedTuple):
    """What the scans before and after a step say of it."""

    choice: int
    link: Edge | None
    """The step as they measure it; None: they do not decide."""


class ScansAround:
    """Compares the stretches before and after a step. It remembers its answers."""

    def __init__(self, maps: LocalMaps, parameters: LoopClosureParameters) -> None:
        self._maps, self._parameters = maps, parameters
        self._answers: dict[tuple, Answer] = {}

    def ask(self, path: MeasuredPath, steps: np.ndarray, by_odometry: np.ndarray) -> Alternatives:
        """Return steps (n,) with what the scans around them decide, beside odometry's (k - 1, 3).

        The maps of both stretches are made of the measured steps, which corrections leave as they are. A
        stretch ends at the next of these steps.
        """
        answers = []
        for step in steps.tolist():
            first, last = _stretch(path, step, steps.tolist(), self._parameters.stretch_m)
            stretch, odometry = path.steps[first:last].round(DECIMALS), by_odometry[step].round(DECIMALS)
            key = (step, first, stretch.tobytes(), odometry.tobytes())
            if key not in self._answers:
                self._answers[key] = self._compare(path, first, step, stretch, odometry)
            answers.append(self._answers[key])
        links = [answer.link for answer in answers if answer.link is not None]
        return Alternatives(steps, np.array([answer.choice for answer in answers], int), Edges.of(links))

    def _compare(
        self, path: MeasuredPath, first: int, step: int, stretch: np.ndarray, by_odometry: np.ndarray
    ) -> Answer:
        """Return what the scans along a stretch of steps (n, 3), from a first node on, say of one of them."""
        p, (before, after) = self._parameters, self._maps_of(path, first, step, stretch)
        windows = (Window(each, REACH_M, REACH_RAD) for each in (stretch[step - first], by_odometry))
        fits = [Correlation(before, after, window).best(0.0, p.overlap_min) for window in windows]
        scores = [0.0 if fit is None else fit.score for fit in fits]
        best = fits[int(scores[1] > scores[0])]
        if best is None or best.score < p.score_min or abs(scores[1] - scores[0]) < SCORE_MARGIN:
            return Answer(UNDECIDED, None)
        choice = BY_ODOMETRY if scores[1] > scores[0] else BY_FILTER
        return Answer(choice, self._link(step, before, after, best.query_in_reference))

    def _link(self, step: int, before: LocalMap, after: LocalMap, start: np.ndarray) -> Edge:
        """Return the step as both maps measure it. Where they do not, the reach of the score holds."""
        refined = refine(before.surface, after.surface, start, GATE_M)
        moved, reach = np.abs(se2.between(start, refined.query_in_reference)), np.array(REACH)
        pose, information = start, np.diag(1.0 / reach**2)
        if refined.pairs and (moved < reach).all():
            pose = refined.query_in_reference
            information += match_information(refined.normal_matrix, refined.pairs, self._parameters)
        return Edge(step, step + 1, pose, inverse(information) + LEAST_COVARIANCE)

    def _maps_of(
        self, path: MeasuredPath, first: int, step: int, stretch: np.ndarray
    ) -> tuple[LocalMap, LocalMap]:
        """Return the maps of the stretch's nodes up to the step, and after it."""
        p, last, poses = self._parameters, first + len(stretch), path.poses.copy()
        poses[first : last + 1] = chained(np.zeros(3), stretch)
        path = replace(path, poses=poses)
        stretches = (np.arange(first, step + 1), step), (np.arange(step + 1, last + 1), step + 1)
        before, after = (
            self._maps.of_nodes(path, nodes, anchor, SCAN_SPACING_M, p.resolution_m, p.blur_m)
            for nodes, anchor in stretches
        )
        return before, after


def _stretch(path: MeasuredPath, step: int, others: Sequence[int], reach_m: float) -> tuple[int, int]:
    """Return the first and the last node within some metres of a step, without another of these steps."""
    way_m = path.way_m
    first = int(np.searchsorted(way_m, way_m[step] - reach_m))
    last = int(np.searchsorted(way_m, way_m[step + 1] + reach_m, side="right")) - 1
    before, after = (other for other in others if other < step), (other for other in others if other > step)
    return max([first, *(other + 1 for other in before)]), min([last, *after])
