"""Stage 5, the correction: the path that fits steps, links and closures best, and its map."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple, Sequence

import numpy as np

from gridslam.loop_closure.edges import Edges, Match
from gridslam.loop_closure.links.scan_links import ScanLinks
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath
from gridslam.loop_closure.path.pose_graph import optimise
from gridslam.loop_closure.path.step_uncertainty import StepUncertainty, step_edges
from gridslam.maps.new_map import MapDraft

SETTLED_M = 0.01
"""m: a correction ends when no pose has moved by more in a round of linking passes and optimising."""


@dataclass(frozen=True, eq=False)
class Correction:
    """What the filter takes over, with `GridSlam.correct`."""

    poses: np.ndarray
    """(k, 3) corrected poses of the path's first nodes: x, y in m and yaw in rad."""
    first_in_map: int = 0
    """Number of the first nodes whose scans stay in the earlier map; see `MapPieces`."""
    draft: MapDraft | None = None
    """The map of the scans at these poses; None: the filter makes it."""
    heights_m: np.ndarray | None = None
    """(k,) corrected heights of these nodes in the map; None: they stay."""


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
    links: ScanLinks,
    closures: Sequence[Match],
    effort: Effort,
    parameters: LoopClosureParameters,
) -> np.ndarray:
    """Return the poses (k, 3) that fit all measurements.

    The better the path, the more scans of different passes can be linked, and the other way round.
    """
    poses = path.poses
    for round_ in range(effort.rounds):
        if round_ > 0 and not links.link_passes(poses, path.way_m):
            break
        before = poses
        steps = step_edges(path, uncertainty, links.information(), poses, parameters)
        edges = Edges.joined([steps, links.stacked(), Edges.of(closures)])
        poses = optimise(before, edges, effort.tolerance, is_far=round_ == 0)
        if round_ > 0 and np.abs(poses - before)[:, :2].max() < SETTLED_M:
            break
    return poses
