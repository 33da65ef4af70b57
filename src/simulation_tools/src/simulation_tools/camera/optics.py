"""What the camera and its lamp are: numbers, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

from flight_basics.checks import check_limits, limited
from simulation_tools.camera.errors import PhotographError


@dataclass(frozen=True)
class CameraOptics:
    """A pinhole camera with square pixels, and a flash beside it. Optical frame: x right, y down, z ahead.

    Raises:
        PhotographError: a value is not finite or out of range.
    """

    width: int = limited(5184, 16, 20_000)
    """Of a picture, px."""
    height: int = limited(3888, 16, 20_000)
    """Of a picture, px."""
    field_of_view_deg: float = limited(60.0, 1.0, 150.0)
    """Across the width, from edge to edge, deg."""
    lamp_cd: float = limited(24_000.0, 1.0, 1e7)
    """Intensity along the lamp's axis, which is the camera's, while the shutter is open, cd. It falls with
    the square of the cosine. By default its light is that of a flash with guide number 1.5 (m, ISO 100).
    """
    lamp_offset_m: tuple[float, float, float] = (0.15, -0.05, 0.0)
    """Of the lamp in the optical frame, m."""
    ambient: float = limited(0.12, 0.0, 1.0)
    """Light that comes back from the walls, as a share of the picture's mean."""
    exposure_s: float = limited(2.5e-4, 1e-6, 10.0)
    """Of a picture, s."""
    f_number: float = limited(2.8, 0.5, 64.0)
    """Focal length over the width of the aperture."""
    full_well_e: float = limited(15_000.0, 100.0, 1e6)
    """Electrons of a white pixel at ISO 100."""
    read_noise_e: float = limited(3.0, 0.0, 1000.0)
    """Electrons of noise of a pixel, standard deviation."""
    vignetting: float = limited(0.3, 0.0, 0.9)
    """Share of light that the corners lose."""

    def __post_init__(self) -> None:
        check_limits(self, PhotographError, "The camera's {}")

    @property
    def focal_px(self) -> float:
        """Focal length, px."""
        return 0.5 * self.width / math.tan(0.5 * math.radians(self.field_of_view_deg))

    @property
    def centre_px(self) -> tuple[float, float]:
        """Where the optical axis meets the picture; whole numbers are the middles of pixels."""
        return 0.5 * (self.width - 1), 0.5 * (self.height - 1)
