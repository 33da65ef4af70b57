"""What the camera and its lamp are: numbers, checked."""

from __future__ import annotations

import math
from dataclasses import dataclass

from simulation_tools.camera.errors import PhotographError


@dataclass(frozen=True)
class CameraOptics:
    """A pinhole camera with square pixels, and a flash beside it. Optical frame: x right, y down, z ahead.

    width, height: px. field_of_view_deg: across the width, from edge to edge. lamp_cd: intensity along the
    lamp's axis, which is the camera's, while the shutter is open; it falls with the square of the cosine. By
    default its light is that of a flash with guide number 1.5 (m, ISO 100). lamp_offset_m: of the lamp in
    the optical frame. ambient: light that comes back from the walls, as a share of the picture's mean.
    exposure_s, f_number: of the picture. full_well_e: electrons of a white pixel at ISO 100. read_noise_e: of
    a pixel. vignetting: share of light that the corners lose.

    Raises:
        PhotographError: a value is not finite or out of range.
    """

    width: int = 5184
    height: int = 3888
    field_of_view_deg: float = 60.0
    lamp_cd: float = 24_000.0
    lamp_offset_m: tuple[float, float, float] = (0.15, -0.05, 0.0)
    ambient: float = 0.12
    exposure_s: float = 2.5e-4
    f_number: float = 2.8
    full_well_e: float = 15_000.0
    read_noise_e: float = 3.0
    vignetting: float = 0.3

    def __post_init__(self) -> None:
        limits = {
            "width": (16, 20_000),
            "height": (16, 20_000),
            "field_of_view_deg": (1.0, 150.0),
            "lamp_cd": (1.0, 1e7),
            "ambient": (0.0, 1.0),
            "exposure_s": (1e-6, 10.0),
            "f_number": (0.5, 64.0),
            "full_well_e": (100.0, 1e6),
            "read_noise_e": (0.0, 1000.0),
            "vignetting": (0.0, 0.9),
        }
        for name, (low, high) in limits.items():
            value = getattr(self, name)
            if not low <= value <= high:
                raise PhotographError(f"The camera's {name} is {value}; give {low:g} to {high:g}.")

    @property
    def focal_px(self) -> float:
        """Focal length, px."""
        return 0.5 * self.width / math.tan(0.5 * math.radians(self.field_of_view_deg))

    @property
    def centre_px(self) -> tuple[float, float]:
        """Where the optical axis meets the picture; whole numbers are the middles of pixels."""
        return 0.5 * (self.width - 1), 0.5 * (self.height - 1)
