"""The quality of a photograph: whether it is sharp, bright and well placed, or must be taken again."""

from __future__ import annotations

import math
from dataclasses import dataclass

from inspection.flight.parameters import InspectionParameters


@dataclass(frozen=True)
class PhotographQuality:
    """What decides it. All of it is known as soon as the photograph is taken.

    blur_px: the longest in it. lux: in its middle.
    deviation_m: standard deviation of the place, along the axis that is known least. shift_m, turn_rad: of
    the camera during the exposure; None: only blur_px is known.
    """

    blur_px: float
    lux: float
    iso: float
    deviation_m: float = 0.0
    shift_m: float | None = None
    turn_rad: float | None = None

    def fault(self, parameters: InspectionParameters, is_closer: bool = False) -> str:
        """Return why the photograph must be taken again; empty: it is good."""
        p = parameters
        most_mm = p.most_blur_mm(is_closer)
        if self.shift_m is None or self.turn_rad is None:
            if not self.blur_px <= p.blur_max:
                return f"it was blurred by {self.blur_px:.1f} px; {p.blur_max:g} px are allowed"
        elif not (blur_mm := p.blur_mm(self.shift_m, self.turn_rad, is_closer)) <= most_mm:
            return f"it was blurred by {blur_mm:.2f} mm on the surface; {most_mm:.2g} mm are allowed"
        if not (self.lux >= p.lux_min and self.iso <= p.iso_max):
            return f"it was dark: {self.lux:.1f} lux, ISO {self.iso:.0f}"
        if not self.deviation_m <= p.deviation_max:
            return f"its place was known to {self.deviation_m:.2f} m only"
        told = (self.blur_px, self.lux, self.iso, self.deviation_m, self.shift_m or 0.0, self.turn_rad or 0.0)
        if not all(map(math.isfinite, told)):
            return "the camera told a number that is none"
        return ""
