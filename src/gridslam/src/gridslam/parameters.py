"""Every parameter of the filter, under gmapping's names and with its defaults, checked once."""

from __future__ import annotations

import builtins  # for `str`, which here is a parameter of gmapping
import math
import sys
from dataclasses import dataclass, fields

from gridslam.errors import ParameterError
from gridslam.kernels.tiles import SIDE
from gridslam.occupancy_grid import CELLS_MAX

KERNEL_SIZE_MAX = 10
PARTICLES_MAX = 10_000
OPTIONAL = ("maxUrange", "maxRange", "xmin", "ymin", "xmax", "ymax")
WHOLE = ("kernelSize", "iterations", "lskip", "particles", "seed", "threads")
POSITIVE = ("sigma", "lstep", "astep", "lsigma", "ogain", "delta", "maxUrange", "maxRange")
NOT_NEGATIVE = ("srr", "srt", "str", "stt", "linearUpdate", "angularUpdate")
BOX = {"xmin": -100.0, "ymin": -100.0, "xmax": 100.0, "ymax": 100.0}
"""m: slam_gmapping's defaults. If the user gives any side, they are the defaults of the others."""


@dataclass(frozen=True)
class SlamParameters:
    """The parameters of the particle filter. They have the same meaning as in slam_gmapping.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    """

    maxUrange: float | None = None
    """m: beams are used up to here, maxRange at most. A longer beam up to maxRange only frees cells."""
    maxRange: float | None = None
    """m: a longer reading counts as no return and has no effect. None: the scan's range_max."""
    sigma: float = 0.05
    """m2: a beam d from the map scores exp(-d^2 / sigma) in scan matching."""
    kernelSize: int = 1
    """Cells on every side of a beam's end that are searched for the map's nearest point."""
    lstep: float = 0.05
    """m: first step of the scan matcher's search."""
    astep: float = 0.05
    """rad: first step of the scan matcher's search."""
    iterations: int = 5
    """Number of times that the scan matcher halves its steps. Beyond 2, Gauss-Newton replaces them."""
    lsigma: float = 0.075
    """m2: a beam d from the map has the log-likelihood -d^2 / lsigma."""
    ogain: float = 3.0
    """Smooths the weights: log-likelihoods are divided by 15 times this (see doc/how_it_works.md)."""
    lskip: int = 0
    """Beams skipped after each one that scan matching uses."""
    minimumScore: float = 0.0
    """Least score of a match, up to the number of beams. With a lower score odometry alone gives the pose."""
    srr: float = 0.1
    """Odometry: deviation of a translation, m per m."""
    srt: float = 0.2
    """Odometry: deviation of a rotation by translation, rad per m."""
    str: float = 0.1
    """Odometry: deviation of a translation by rotation, m per rad."""
    stt: float = 0.2
    """Odometry: deviation of a rotation, rad per rad."""
    linearUpdate: float = 1.0
    """m: a scan is processed after this much travel ..."""
    angularUpdate: float = 0.5
    """rad: ... or this much turning ..."""
    temporalUpdate: float = -1.0
    """s: ... or this much time; negative: never by time."""
    resampleThreshold: float = 0.5
    """Resampling happens when N_eff is below this share of the particles."""
    particles: int = 30
    """Number of particles."""
    xmin: float | None = None
    """m: the published map covers at least xmin to xmax, ymin to ymax. All None: only what was seen."""
    ymin: float | None = None
    """m"""
    xmax: float | None = None
    """m"""
    ymax: float | None = None
    """m"""
    delta: float = 0.05
    """m: size of a cell."""
    occ_thresh: float = 0.25
    """A cell is occupied if more than this share of the beams that met it ended there."""
    llsamplerange: float = 0.01
    """m. Without effect, like the next three and as in gmapping; see doc/how_it_works.md."""
    llsamplestep: float = 0.01
    """m"""
    lasamplerange: float = 0.005
    """rad"""
    lasamplestep: float = 0.005
    """rad"""
    seed: int = 0
    """Seed of everything random: the same seed and scans give the same map."""
    threads: int = 0
    """Threads that share the particles; 0: as many as cores are free. The result does not depend on it."""

    def __post_init__(self) -> None:
        for field in fields(self):
            self._check_number(field.name)
        self._check_signs()
        self._check_combinations()

    def _check_number(self, name: builtins.str) -> None:
        value = getattr(self, name)
        if value is None and name in OPTIONAL:
            return
        is_number = isinstance(value, (int, float)) and not isinstance(value, bool)
        infinite = name == "maxRange" and value == math.inf
        if not is_number or not (infinite or abs(value) <= sys.float_info.max):  # NaN fails this test too
            raise ParameterError(f"{name} must be a finite number, not {value!r}.")
        if name in WHOLE:
            if int(value) != value:
                raise ParameterError(f"{name} must be a whole number, not {value!r}.")
            object.__setattr__(self, name, int(value))
        else:
            object.__setattr__(self, name, float(value))

    def _check_signs(self) -> None:
        for name in POSITIVE:
            value = getattr(self, name)
            if value is not None and not value > 0.0:
                raise ParameterError(f"{name} must be greater than 0, not {value}.")
        for name in (*NOT_NEGATIVE, "iterations", "lskip", "seed", "threads"):
            if getattr(self, name) < 0:
                raise ParameterError(f"{name} must be at least 0, not {getattr(self, name)}.")
        for name in ("particles", "kernelSize"):
            if getattr(self, name) < 1:
                raise ParameterError(f"{name} must be at least 1, not {getattr(self, name)}.")
        for name, most in (("kernelSize", KERNEL_SIZE_MAX), ("particles", PARTICLES_MAX)):
            if getattr(self, name) > most:
                raise ParameterError(f"{name} must be at most {most}, not {getattr(self, name):g}.")
        for name in ("resampleThreshold", "occ_thresh"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise ParameterError(f"{name} must be between 0 and 1, not {getattr(self, name)}.")

    def _check_combinations(self) -> None:
        if all(getattr(self, side) is None for side in BOX):
            return
        for side, default_m in BOX.items():
            if getattr(self, side) is None:
                object.__setattr__(self, side, default_m)
        box = {side: float(getattr(self, side)) for side in BOX}
        width, height = box["xmax"] - box["xmin"], box["ymax"] - box["ymin"]
        if not (width > 0.0 and height > 0.0):
            raise ParameterError(f"{', '.join(BOX)} must span an area, not {tuple(box.values())}.")
        edges = 2 * SIDE  # maps are made of whole tiles
        cells = (width / self.delta + edges) * (height / self.delta + edges)
        if cells > CELLS_MAX:
            raise ParameterError(
                f"{', '.join(BOX)} span {cells:.2g} cells of {self.delta} m, of which a map may have "
                f"{CELLS_MAX:.2g}; choose a smaller box, or a larger delta."
            )

    @property
    def box(self) -> tuple[float, float, float, float] | None:
        """(xmin, ymin, xmax, ymax), m: least extent of the map; None: only what was seen."""
        if self.xmin is None or self.ymin is None or self.xmax is None or self.ymax is None:
            return None
        return self.xmin, self.ymin, self.xmax, self.ymax

    def ranges_for(self, range_max_m: float) -> tuple[float, float]:
        """Return (usable, greatest) range in metres for a lidar with the range ``range_max_m``."""
        greatest = range_max_m - 0.01 if self.maxRange is None else self.maxRange
        usable = greatest if self.maxUrange is None else self.maxUrange
        return min(usable, greatest), greatest
