"""What one scan says about the pose at which it was matched."""

from __future__ import annotations

from dataclasses import dataclass

COMPARED_SHARE_MIN, COMPARED_MIN = 0.3, 10
"""A scan with fewer comparable beams than this share, or number, neither agrees nor contradicts."""


@dataclass(frozen=True)
class Agreement:
    """Numbers of beams of one scan that agree with the map, contradict it, and end in unseen space."""

    agreeing: int
    clashing: int
    unseen: int

    def compared(self, unseen_weight: float = 0.0) -> float:
        """Return the number of comparable beams, plus those in unseen space times a weight."""
        return self.agreeing + self.clashing + unseen_weight * self.unseen

    def share(self, unseen_weight: float = 0.0) -> float:
        """Return the share of the compared beams that agree; 1 if there are none."""
        compared = self.compared(unseen_weight)
        return self.agreeing / compared if compared else 1.0

    @property
    def compared_share(self) -> float:
        """Share of the beams about which the map says something."""
        return self.compared() / max(1.0, self.compared(1.0))

    def is_meaningful(self, unseen_weight: float = 0.0) -> bool:
        """Return whether there are enough comparable beams to judge by."""
        beams, compared = self.compared(1.0), self.compared(unseen_weight)
        return compared >= max(COMPARED_MIN, COMPARED_SHARE_MIN * beams)


@dataclass(frozen=True)
class Evidence:
    """One scan at the best particle's pose, before the scan changes the map."""

    stamp_s: float
    agreement: Agreement
    spread_m: float = 0.0
    """Standard deviation of the particles' positions."""
    neff_share: float = 1.0
    """Effective number of particles, as a share of all."""
    correction: float = 0.0
    """Distance of the matched pose from odometry's, in standard deviations of the motion model."""
    typical_range_m: float = 0.0
    """Median range of the beams that hit something; 0 if none did."""
    blur_m: float = 0.0
    """How far odometry's error between two scans moves the ends of typical beams."""
    travelled_m: float = 0.0
    """By odometry, since the evidence before."""
    is_witness: bool = True
    """Whether the scan can tell that the pose is wrong. Beside an odometry in space that knows the way it
    cannot: where the height passes the edge of an opening, a level scan sees other walls."""
