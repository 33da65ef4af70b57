"""A real lens: OpenCV's model of focal lengths, principal point and distortion.

https://docs.opencv.org/4.x/d9/d0c/group__calib3d.html: distortion is radial, (1 + k1 r2 + k2 r4 + k3 r6) /
(1 + k4 r2 + k5 r4 + k6 r6), and tangential, p1 and p2. ROS calls it plumb_bob with 5 coefficients, and
rational_polynomial with 8.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Sequence

import numpy as np

from flight_basics.checks import check_number
from flight_basics.errors import ParameterError

ROUNDS, OFF_PX = 60, 0.02
"""Of the search for the ray of a pixel; it must get so near to the pixel."""
EDGE_POINTS = 25
"""Along each side of a picture, where a lens is checked."""
MIDDLE = 0.1
"""A principal point lies so near to the picture's middle, as a share of its sides.

The cameras of public data sets have 0.04 at most (KITTI's; EuRoC's 0.02, TUM's 0.03). The calibration of
pictures that are a quarter larger has 0.125.
"""
ASIDE = 0.05
"""One that is farther to the right and down, or to the left and up, is of larger or smaller pictures."""
SQUARE = 0.1
"""Both focal lengths differ by less, as a share."""
MODELS = ("plumb_bob", "rational_polynomial", "")


@dataclass(frozen=True)
class Lens:
    """What draws a picture.

    focal_px: fx, fy. centre_px: cx, cy; whole numbers are the middles of pixels. distortion: k1, k2, p1, p2,
    k3, k4, k5, k6.

    Raises:
        ParameterError: a value out of range.
    """

    focal_px: tuple[float, float]
    centre_px: tuple[float, float]
    distortion: tuple[float, ...] = (0.0,) * 8

    def __post_init__(self) -> None:
        for name, values in (("focal_px", self.focal_px), ("centre_px", self.centre_px)):
            if len(values) != 2:
                raise ParameterError(f"{name} is {values!r}; it must be two numbers.")
        for value in self.focal_px:
            check_number("focal_px", value, 1.0, 1e6)
        for value in self.centre_px:
            check_number("centre_px", value, -1e5, 1e5)
        if len(self.distortion) != 8:
            raise ParameterError(f"distortion is {self.distortion!r}; it must be eight numbers.")
        for value in self.distortion:
            check_number("distortion", value, -1e3, 1e3)

    def pixels(self, aside: np.ndarray) -> np.ndarray:
        """Return the pixels (n, 2) of rays with tangents (n, 2), x and y at depth 1."""
        return self._distorted(aside) * self.focal_px + self.centre_px

    def asides(self, pixels: np.ndarray) -> np.ndarray:
        """Return the tangents (n, 2) of the rays of pixels (n, 2)."""
        observed = (np.asarray(pixels, float) - self.centre_px) / self.focal_px
        aside = observed.copy()
        if any(self.distortion):
            for _ in range(ROUNDS):
                aside += observed - self._distorted(aside)
        return aside

    def scaled(self, share: float) -> Lens:
        """Return the lens of a copy whose sides are a share of the picture's; both begin at one corner."""
        (fx, fy), (cx, cy) = self.focal_px, self.centre_px
        centre_px = (cx + 0.5) * share - 0.5, (cy + 0.5) * share - 0.5
        return replace(self, focal_px=(share * fx, share * fy), centre_px=centre_px)

    def check(self, width: int, height: int) -> None:
        """Raise ParameterError if no camera draws such a picture, or a pixel of it has no ray.

        Without a ray, the model folds there.
        """
        right, down = ((at + 0.5) / side for at, side in zip(self.centre_px, (width, height)))
        off = sorted((right - 0.5, down - 0.5))
        if max(-off[0], off[1]) > MIDDLE or off[0] > ASIDE or off[1] < -ASIDE:
            raise ParameterError(
                f"its principal point (cx, cy) lies at {100 * right:.0f} % of the width, {100 * down:.0f} % "
                f"of the height, and a camera's lies near the middle; is it of "
                "pictures of another size than it tells, or of ones that were cut out"
            )
        if abs(self.focal_px[0] / self.focal_px[1] - 1.0) > SQUARE:
            raise ParameterError(
                f"its focal lengths {self.focal_px[0]:g} and {self.focal_px[1]:g} px differ by more than "
                f"{100 * SQUARE:.0f} %; is it of pictures of another shape"
            )
        x, y = np.linspace(-0.5, width - 0.5, EDGE_POINTS), np.linspace(-0.5, height - 0.5, EDGE_POINTS)
        pixels = np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)
        with np.errstate(over="ignore", invalid="ignore"):
            off_px = np.abs(self.pixels(self.asides(pixels)) - pixels).max()
        if not off_px <= OFF_PX:
            raise ParameterError("its distortion cannot be undone in all of the picture")

    def _distorted(self, aside: np.ndarray) -> np.ndarray:
        k1, k2, p1, p2, k3, k4, k5, k6 = self.distortion
        x, y = aside[:, 0], aside[:, 1]
        r2 = x**2 + y**2
        radial = (1.0 + r2 * (k1 + r2 * (k2 + r2 * k3))) / (1.0 + r2 * (k4 + r2 * (k5 + r2 * k6)))
        return np.column_stack(
            (
                x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x**2),
                y * radial + p1 * (r2 + 2.0 * y**2) + 2.0 * p2 * x * y,
            )
        )


def lens_of(matrix: Sequence[float], model: str, distortion: Sequence[float]) -> Lens:
    """Return the lens of a calibration: CameraInfo's K, row by row, distortion_model and D.

    Raises:
        ParameterError: another model, or numbers that make no sense.
    """
    if model not in MODELS:
        raise ParameterError(
            f'its distortion_model is "{model}"; plumb_bob and rational_polynomial are read. Undistort the '
            "photographs, and give the calibration of the undistorted ones"
        )
    if len(distortion) == 4 and not model and any(distortion):
        raise ParameterError(
            "it has four distortion coefficients and no distortion_model, so they may be plumb_bob's or a "
            "fisheye's; write the model into it"
        )
    if len(matrix) != 9:
        raise ParameterError("its camera_matrix needs nine numbers")
    if len(distortion) not in (0, 4, 5, 8):
        raise ParameterError(f"it has {len(distortion)} distortion coefficients; 0, 4, 5 or 8 are read")
    fx, skew, cx, low, fy, cy, *last = (float(each) for each in matrix)
    if abs(skew) > 1e-6 * abs(fx) or low != 0.0 or last != [0.0, 0.0, 1.0]:
        raise ParameterError("its camera_matrix is not that of a camera: fx 0 cx, 0 fy cy, 0 0 1")
    coefficients = [float(each) for each in distortion]
    return Lens((fx, fy), (cx, cy), tuple(coefficients + [0.0] * (8 - len(coefficients))))
