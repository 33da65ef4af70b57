"""How uncertain each step of the path is: measured by scans, by odometry alone, or contradicted by scans."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from gridslam import se2
from gridslam.kernels.least_squares import inverses
from gridslam.loop_closure.edges import Edges
from gridslam.loop_closure.parameters import LoopClosureParameters
from gridslam.loop_closure.path.measured_path import MeasuredPath, odometry_covariances
from gridslam.loop_closure.path.odometry_scale import UNKNOWN_SCALE, Scale
from gridslam.tracking.evidence import Agreement
from gridslam.tracking.wrong_steps import MATCH_SIGMA

STEPS_MIN, CHI_SQUARE_75, SHARE_MIN = 20, 4.108, 0.04
"""To learn how good odometry is: least number of steps, the chi-square (3 degrees of freedom) that three
quarters of them stay below, and the least share of the assumed covariance.
"""
UNDECIDED, BY_FILTER, BY_ODOMETRY = 0, 1, 2
"""Which of a step's two measurements holds alone."""
BOTH = 3
"""Both hold: they do not exclude each other, or a link tells."""


@dataclass(frozen=True)
class DoubtfulNodes:
    """Nodes whose scan does not measure the step to them."""

    unmatched: tuple[int, ...] = ()
    """The scan could not be compared with the map, or the vehicle was found at the node."""
    guessed: tuple[int, ...] = ()
    """The step to the node begins or ends at a guessed pose."""
    contradicted: tuple[int, ...] = ()
    """The vehicle was lost before the node, and was not found on the map."""
    proved: int = 0
    """The newest node before which scans have proved a doubtful place on the map; 0: none."""

    def with_scan(self, node: int, agreement: Agreement) -> DoubtfulNodes:
        """Return them with what the scan at the newest node leaves unmeasured.

        Where scans are far apart, the filter may use one of which most beams contradict the map. Its pose is
        a guess then.
        """
        if not agreement.is_meaningful():
            return replace(self, unmatched=(*self.unmatched, node))
        if agreement.agreeing < agreement.clashing:
            return replace(self, guessed=(*self.guessed, node, node + 1))
        return self

    def with_proof(self, node: int) -> DoubtfulNodes:
        """Return them with a node before which scans have proved the place on the map."""
        return replace(self, proved=node)

    def with_new_place(self, node: int, is_contradicted: bool) -> DoubtfulNodes:
        """Return them with a node at which the vehicle was put elsewhere.

        ``is_contradicted``: scans contradicted odometry, and no other place was found.
        """
        if is_contradicted:
            return replace(self, contradicted=(*self.contradicted, node))
        return replace(self, unmatched=(*self.unmatched, node))


@dataclass(frozen=True, eq=False)
class StepUncertainty:
    """The covariances of a path's steps, and the same steps by odometry."""

    covariances: np.ndarray
    """(k - 1, 3, 3) of the filter's steps, where a step that no scan has measured is as bad as odometry."""
    by_odometry: np.ndarray
    """(k - 1, 3) the steps as odometry measured them, with its scale corrected."""
    odometry_covariances: np.ndarray
    """(k - 1, 3, 3) of these."""
    open_covariances: np.ndarray
    """(k - 1, 3, 3) of the filter's steps if no scan has measured them."""
    is_open: np.ndarray
    """(k - 1,) whether no scan has measured the step."""
    scale: float
    """Odometry's ways were multiplied by this; see `odometry_scale`."""
    share_off: float
    """How much of its way odometry may err by, without that; see `Scale`."""
    is_spanned: np.ndarray
    """(k - 1,) whether a link that measures every direction spans the step."""
    choices: np.ndarray
    """(k - 1,) BOTH, UNDECIDED, BY_FILTER or BY_ODOMETRY; see `alternatives`."""

    def decided(self, steps: np.ndarray, choices: np.ndarray) -> StepUncertainty:
        """Return it with choices (n,) for steps (n,)."""
        all_choices = self.choices.copy()
        all_choices[steps] = choices
        return replace(self, choices=all_choices)

    def if_either(self, steps: np.ndarray) -> StepUncertainty:
        """Return it with covariances of steps (n,) so large that each may be the filter's or odometry's."""
        covariances = self.covariances.copy()
        covariances[steps] = self.open_covariances[steps]
        return replace(self, covariances=covariances)


def step_uncertainty(
    path: MeasuredPath,
    is_spanned: np.ndarray,
    doubtful: DoubtfulNodes,
    parameters: LoopClosureParameters,
    scale: Scale = UNKNOWN_SCALE,
) -> StepUncertainty:
    """Return the uncertainty of each step. Those that no scan has measured are as uncertain as odometry is.

    Odometry's error is at least its difference from the filter's step, for example where the vehicle has been
    found elsewhere on the map. It is of unknown size where scans contradicted odometry, as when wheels
    slip. A step that a link spans is measured, whatever is known of its node.

    The steps to and from a guessed pose are known together, because the scan after it was matched again.
    So they are uncertain in the pose graph (`step_edges`) only.

    Args:
        path: k nodes.
        is_spanned: (k - 1,) whether a link that measures every direction spans the step.
        doubtful: nodes whose scan does not measure their step.
        parameters: of odometry, and of slip.
        scale: odometry's ways are multiplied by its mean; see `odometry_scale`.
    """
    p, nodes = parameters, np.arange(1, len(path))
    by_odometry = se2.between(path.odometry[:-1], path.odometry[1:]) * (scale.mean, scale.mean, 1.0)
    has_slipped = ~is_spanned & np.isin(nodes, doubtful.contradicted)
    is_unknown = has_slipped | ~is_spanned & np.isin(nodes, doubtful.unmatched)
    of_odometry = odometry_covariances(by_odometry, p)
    of_odometry[has_slipped] += np.diag([p.slip_m, p.slip_m, p.slip_rad]) ** 2
    off = se2.between(by_odometry, path.steps)
    if_open = of_odometry + off[:, :, None] * off[:, None, :]
    return StepUncertainty(
        np.where(is_unknown[:, None, None], if_open, path.covariances),
        by_odometry,
        of_odometry,
        if_open,
        is_unknown | ~is_spanned & np.isin(nodes, doubtful.guessed),
        scale.mean,
        scale.share_off,
        is_spanned,
        np.full(len(path.steps), BOTH),
    )


def step_edges(
    path: MeasuredPath,
    uncertainty: StepUncertainty,
    link_information: np.ndarray,
    poses: np.ndarray,
    parameters: LoopClosureParameters,
) -> Edges:
    """Return each step twice, for the pose graph: as the filter has it, and as odometry measured it.

    A filter's step is as firm as all links of its scan with those before it together:
    ``link_information`` (k - 1, 3, 3). These scans are the map that it was matched with, and show how much
    of it the scan has met. Matches against one map have similar errors; `step_share` tells how firmly
    the steps hold. Where links say nothing, it is trusted like odometry.

    Where one of both was chosen (`alternatives`), it is as firm as the scan's match, or as odometry. The
    other one counts as if it had erred by the difference.

    Odometry may be better than assumed. How good it is, the present path ``poses`` (k, 3) tells. Where no
    link joins a step's scan, both are as good as odometry is at the steps that links measure. If wheels have
    slipped there, closures contradict these edges only, and they lose their weight (`optimise`). Where filter
    and odometry exclude each other, both stay as odometry was assumed, until one of them is chosen.
    """
    u, of_odometry = uncertainty, uncertainty.odometry_covariances
    is_linked = link_information.any(axis=(1, 2))
    learned, where_linked = odometry_share(u, poses), odometry_share(u, poses, is_linked)
    share = np.where(is_linked, learned, where_linked)
    share[u.is_open | (u.choices == UNDECIDED)] = 1.0
    share[u.choices == BY_ODOMETRY] = learned
    by_odometry = share[:, None, None] * of_odometry
    held = by_odometry.copy()
    held[is_linked] = parameters.step_share**2 * inverses(
        link_information[is_linked] + inverses(of_odometry[is_linked])
    )
    held[u.is_open] = u.open_covariances[u.is_open]
    _choose(path, u, held, by_odometry)
    older = np.tile(np.arange(len(u.by_odometry)), 2)
    from_odometry = np.where((is_linked | (u.choices != BOTH))[:, None, None], held, of_odometry)
    steps = np.concatenate([_scaled_steps(path, u, from_odometry), u.by_odometry])
    return Edges(older, older + 1, steps, np.concatenate([held, by_odometry]))


def _choose(
    path: MeasuredPath, uncertainty: StepUncertainty, held: np.ndarray, by_odometry: np.ndarray
) -> None:
    """Write the covariances of the steps of which one measurement was chosen."""
    u = uncertainty
    is_filters, is_odometrys = u.choices == BY_FILTER, u.choices == BY_ODOMETRY
    held[is_filters] = path.covariances[is_filters] + np.diag(MATCH_SIGMA**2)
    by_odometry[is_filters] = u.open_covariances[is_filters]
    held[is_odometrys] = u.open_covariances[is_odometrys]


def _scaled_steps(path: MeasuredPath, uncertainty: StepUncertainty, held: np.ndarray) -> np.ndarray:
    """Return the filter's steps (k - 1, 3) as if its odometry had had the right scale.

    Where scans measured nothing, the filter took a step as odometry had it. ``held``: the covariances of
    its steps, from scans and odometry together, as odometry was assumed.
    """
    u = uncertainty
    wrong = u.by_odometry * (1.0 - 1.0 / u.scale) * (1.0, 1.0, 0.0)
    wrong[:, :2] = se2.transform_each(path.steps * (0.0, 0.0, -1.0), wrong[:, :2])
    taken = np.einsum("nij,njk,nk->ni", held, inverses(u.odometry_covariances), wrong)
    taken[:, :2] = se2.transform_each(path.steps * (0.0, 0.0, 1.0), taken[:, :2])
    return path.steps + np.where(u.is_open[:, None], 0.0, taken)


def odometry_share(
    uncertainty: StepUncertainty, poses: np.ndarray, is_linked: np.ndarray | None = None
) -> float:
    """Return by how much odometry's covariance is too large, from its differences to a path (k, 3).

    Three quarters of them must be as expected. So the few great ones do not count, which the robust
    kernel takes care of. ``is_linked`` (k - 1,): the steps that count; None: all that scans measured.
    """
    u = uncertainty
    counts = ~u.is_open if is_linked is None else ~u.is_open & is_linked
    error = se2.between(u.by_odometry, se2.between(poses[:-1], poses[1:]))[counts]
    if len(error) < STEPS_MIN:
        return 1.0
    spread = np.diagonal(u.odometry_covariances[counts], axis1=1, axis2=2)
    return float(np.clip(np.quantile((error**2 / spread).sum(axis=1), 0.75) / CHI_SQUARE_75, SHARE_MIN, 1.0))
