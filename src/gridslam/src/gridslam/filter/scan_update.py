"""What the filter says of a processed scan."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class ScanUpdate:
    """The result of a processed scan."""

    stamp_s: float
    """s: the scan's."""
    base_in_map: tuple[float, float, float]
    """x, y in m and yaw in rad of the best particle."""
    neff: float
    """Effective number of particles, before resampling."""
    resampled: bool
    """Whether the particles were resampled."""
    matched: bool
    """Whether the scan fitted the best particle's map; if not, odometry alone has placed it."""
    entropy: float
    """Of the particles' weights, before resampling."""
    is_node: bool = True
    """Whether the path got a node, with the scan. In known places it does not; see `known_places`."""
