"""Stage 5, the correction: the path that fits steps, links and closures best, and its map."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Callable, NamedTuple, Sequence

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverse
from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.links.scan_links import ScanLinks
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.alternatives import Alternatives
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.pose_graph import optimise, robust_cost
from gridslam.loop_closure.path.step_uncertainty import BY_FILTER, BY_ODOMETRY, StepUncertainty, step_edges
from gridslam.maps.new_map import MapDraft

SETTLED_M = 0.01
"""m: a correction ends when no pose has moved by more in a round of linking passes and optimising."""

COST_MARGIN = 3.0
"""Closures decide for a step if the graph's cost is lower by more than this: odds of 20."""
TRIAL_TOLERANCE = 1e-3
"""See `optimise`: enough to tell which of two steps fits."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What the filter takes over, with `GridSlam.correct`."""

    poses: np.ndarray
    """(k, 3) corrected poses of the path's first nodes: x, y in m and yaw in rad."""
    first_in_map: int = 0
    """Number of the first nodes whose scans stay in the earlier map; see `MapPieces`."""
    draft: MapDraft | None = None
    """The map of the scans at these poses; None: it is not drawn yet."""
    heights_m: np.ndarray | None = None
    """(k,) corrected heights of these nodes in the map; None: they stay."""
    draw: Callable[[], MapDraft] | None = None
    """Draws this map; None: the filter makes it of the scans that it has kept."""

    def drawn(self) -> Correction:
        """Return it with its map."""
        return self if self.draw is None else replace(self, draft=self.draw(), draw=None)


class Effort(NamedTuple):
    """Limits of a correction."""

    rounds: int
    """It ends after this many rounds at the latest."""
    tolerance: float
    """See `optimise`."""


ON_THE_WAY, AT_THE_END = Effort(2, 1e-3), Effort(5, 1e-5)
"""The next correction mends what one on the way leaves."""


def corrected_poses(
    path: MeasuredPath,
    uncertainty: StepUncertainty,
    found: Alternatives,
    links: ScanLinks,
    closures: Sequence[Match],
    effort: Effort,
    parameters: LoopClosureParameters,
) -> np.ndarray:
    """Return the poses (k, 3) that fit all measurements.

    The better the path, the more scans of different passes can be linked, and the other way round.
    """
    poses = path.poses
    found = decided_by_closures(path, uncertainty, found, links, closures, parameters)
    uncertainty = found.applied(uncertainty)
    for round_ in range(effort.rounds):
        if round_ > 0 and not links.link_passes(poses, path.way_m):
            break
        before = poses
        steps = step_edges(path, uncertainty, links.information(), poses, parameters)
        edges = Edges.joined([steps, links.stacked(), found.links, Edges.of(closures)])
        poses = optimise(before, edges, effort.tolerance, is_far=round_ == 0)
        if round_ > 0 and np.abs(poses - before)[:, :2].max() < SETTLED_M:
            break
    return poses


def decided_by_closures(
    path: MeasuredPath,
    uncertainty: StepUncertainty,
    found: Alternatives,
    links: ScanLinks,
    closures: Sequence[Match],
    parameters: LoopClosureParameters,
) -> Alternatives:
    """Return the alternatives with those decided of which closures fit one clearly better, and well.

    Both may be wrong. Then the closures fit neither, and the step stays undecided.
    """

    def trial(tried: Alternatives, which: int) -> tuple[float, bool]:
        """Return the graph's cost with a choice, and whether its step fits by its own uncertainty."""
        of_steps = step_edges(path, tried.applied(uncertainty), links.information(), path.poses, parameters)
        edges = Edges.joined([of_steps, links.stacked(), found.links, Edges.of(closures)])
        start = tried.moved(which, path, uncertainty)
        poses = optimise(start, edges, TRIAL_TOLERANCE, is_far=True)
        step, by_odometry = int(tried.steps[which]), tried.choices[which] == BY_ODOMETRY
        row = step + len(path.steps) * int(by_odometry)
        error = se2.between(of_steps.newer_in_older[row], se2.between(poses[step], poses[step + 1]))
        chi_square = float(error @ inverse(of_steps.covariance[row]) @ error)
        return robust_cost(poses, edges), chi_square < parameters.chi_square_max

    for which in found.asked_of(closures):
        tried = [found.with_choice(which, choice) for choice in (BY_FILTER, BY_ODOMETRY)]
        costs, fits = zip(*(trial(each, which) for each in tried))
        best = int(costs[1] < costs[0])
        if fits[best] and costs[1 - best] - costs[best] > COST_MARGIN:
            found = tried[best]
    return found
