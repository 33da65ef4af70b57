"""Beams that stand out alone: tells what is seen now and then, as wires, from what is not there, as rain."""

from __future__ import annotations

import math

import numpy as np

from cepa.dynamic.constants.remembered import (
    SINGLE_FEWEST_MATCHES,
    SINGLE_FEWEST_SCANS,
    SINGLE_KEPT,
    SINGLE_SCANS,
    SINGLE_WITHIN_S,
)
from cepa.dynamic.remembered.kernels.single_beams import steady
from cepa.motion import Motion
from cepa.scan import Beams


class SingleBeams:
    """Compares the beams that stand out alone with those of earlier scans."""

    def __init__(self) -> None:
        self._earlier = np.empty((SINGLE_SCANS, SINGLE_KEPT, 2))
        self.reset()

    def reset(self) -> None:
        """Forget the earlier scans."""
        self._counts = np.zeros(SINGLE_SCANS, np.int64)
        self._newest = 0

    def confirmed(self, beams: Beams, motion: Motion, period_s: float) -> Beams:
        """Return the beams without those that stand out alone and that earlier scans do not confirm.

        Such a beam is put back to the nearer one beside it. period_s: between scans; 0 if it is not known.
        """
        if not beams.nearest < math.inf:
            self._counts[self._newest] = 0
            return beams
        scans = (
            SINGLE_SCANS
            if period_s == 0.0
            else min(SINGLE_SCANS, max(SINGLE_FEWEST_SCANS, 1 + round(SINGLE_WITHIN_S / period_s)))
        )
        self._newest = (self._newest + 1) % scans
        x, y, _ = motion.position_m
        ranges = beams.ranges
        geometry = beams.seen, beams.angle_0, beams.increment, motion.rotation()
        kept = self._earlier[:scans], self._counts[:scans], self._newest
        changed = steady(ranges, *geometry, x, y, *kept, min(SINGLE_FEWEST_MATCHES, scans - 2))
        return beams._replace(nearest=float(ranges.min())) if changed else beams
