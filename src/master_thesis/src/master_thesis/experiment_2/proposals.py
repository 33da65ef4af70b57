"""Both algorithms' proposals for the same scan, for several K of the emergency avoidance's filter."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

from cepa import CepaParameters, Improved, LaserScan2D, Original

K_SWEEP = (0.5, 1.0, 2.0, 5.0, 10.0, 20.0, 50.0, 100.0)
"""m/rad: figures 8.4 and 8.5."""


@dataclass(frozen=True)
class Proposals:
    """Velocities in m/s in the scan's frame, for a UAV at rest with a reference of zero.

    reason: of the improved algorithm's proposal. emergency: whether an obstacle is within r_LB.
    """

    k_filter: float
    original_xy: tuple[float, float]
    improved_xy: tuple[float, float]
    reason: str
    emergency: bool


def propose(scan: LaserScan2D, parameters: CepaParameters) -> Proposals:
    """Ask both algorithms."""
    original, improved = (
        algorithm(parameters).steer(scan, (0.0, 0.0), (0.0, 0.0)) for algorithm in (Original, Improved)
    )
    return Proposals(
        parameters.k_filter,
        original.velocity_xy,
        improved.velocity_xy,
        improved.reason.value,
        improved.emergency,
    )


def sweep(
    scan: LaserScan2D, parameters: CepaParameters, ks: Sequence[float] = K_SWEEP
) -> tuple[Proposals, ...]:
    """Ask both algorithms with each K (m/rad). v_min is 0, so that K's effect on the speed is visible."""
    return tuple(propose(scan, replace(parameters, k_filter=k, v_min=0.0)) for k in ks)
