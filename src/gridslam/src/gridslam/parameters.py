"""Every parameter of the filter, under gmapping's names and with its defaults, checked once."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields

from flight_basics.checks import check_limits, limited
from gridslam.errors import ParameterError
from gridslam.kernels.tiles import SIDE
from gridslam.occupancy_grid import CELLS_MAX

KERNEL_SIZE_MAX = 10
PARTICLES_MAX = 10_000
BOX = {"xmin": -100.0, "ymin": -100.0, "xmax": 100.0, "ymax": 100.0}
"""m: slam_gmapping's defaults. If the user gives any side, they are the defaults of the others."""


@dataclass(frozen=True)
class SlamParameters:
    """The parameters of the particle filter. They have the same meaning as in slam_gmapping.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    """

    maxUrange: float | None = limited(None, above=0.0)
    """m: beams are used up to here, maxRange at most. A longer beam up to maxRange only frees cells."""
    maxRange: float | None = limited(None, above=0.0, most=math.inf)
    """m: a longer reading counts as no return and has no effect. None: the scan's range_max."""
    sigma: float = limited(0.05, above=0.0)
    """m2: a beam d from the map scores exp(-d^2 / sigma) in scan matching."""
    kernelSize: int = limited(1, 1, KERNEL_SIZE_MAX)
    """Cells on every side of a beam's end that are searched for the map's nearest point."""
    lstep: float = limited(0.05, above=0.0)
    """m: first step of the scan matcher's search."""
    astep: float = limited(0.05, above=0.0)
    """rad: first step of the scan matcher's search."""
    iterations: int = limited(5, 0)
    """Number of times that the scan matcher halves its steps. Beyond 2, Gauss-Newton replaces them."""
    lsigma: float = limited(0.075, above=0.0)
    """m2: a beam d from the map has the log-likelihood -d^2 / lsigma."""
    ogain: float = limited(3.0, above=0.0)
    """Smooths the weights: log-likelihoods are divided by 15 times this (see doc/how_it_works.md)."""
    lskip: int = limited(0, 0)
    """Beams skipped after each one that scan matching uses."""
    minimumScore: float = limited(0.0)
    """Least score of a match, up to the number of beams. With a lower score odometry alone gives the pose."""
    srr: float = limited(0.1, 0.0)
    """Odometry: deviation of a translation, m per m."""
    srt: float = limited(0.2, 0.0)
    """Odometry: deviation of a rotation by translation, rad per m."""
    str: float = limited(0.1, 0.0)
    """Odometry: deviation of a translation by rotation, m per rad."""
    stt: float = limited(0.2, 0.0)
    """Odometry: deviation of a rotation, rad per rad."""
    linearUpdate: float = limited(1.0, 0.0)
    """m: a scan is processed after this much travel."""
    angularUpdate: float = limited(0.5, 0.0)
    """rad: a scan is processed after this much turning, too."""
    temporalUpdate: float = limited(-1.0)
    """s: a scan is processed after this much time, too. Negative: never by time."""
    resampleThreshold: float = limited(0.5, 0.0, 1.0)
    """Resampling happens when N_eff is below this share of the particles."""
    particles: int = limited(30, 1, PARTICLES_MAX)
    """Number of particles."""
    xmin: float | None = limited(None)
    """m: the published map covers at least xmin to xmax, ymin to ymax. All None: only what was seen."""
    ymin: float | None = limited(None)
    """m: see xmin."""
    xmax: float | None = limited(None)
    """m: see xmin."""
    ymax: float | None = limited(None)
    """m: see xmin."""
    delta: float = limited(0.05, above=0.0)
    """m: size of a cell."""
    occ_thresh: float = limited(0.25, 0.0, 1.0)
    """A cell is occupied if more than this share of the beams that met it ended there."""
    llsamplerange: float = limited(0.01)
    """m: without effect, like the next three and as in gmapping; see doc/how_it_works.md."""
    llsamplestep: float = limited(0.01)
    """m: without effect, see llsamplerange."""
    lasamplerange: float = limited(0.005)
    """rad: without effect, see llsamplerange."""
    lasamplestep: float = limited(0.005)
    """rad: without effect, see llsamplerange."""
    seed: int = limited(0, 0)
    """Seed of everything random: the same seed and scans give the same map."""
    threads: int = limited(0, 0)
    """Threads that share the particles; 0: as many as cores are free. The result does not depend on it."""

    def __post_init__(self) -> None:
        check_limits(self, ParameterError)
        for each in fields(self):
            value = getattr(self, each.name)
            if value is not None:
                object.__setattr__(self, each.name, int(value) if each.type == "int" else float(value))
        self._check_combinations()

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
