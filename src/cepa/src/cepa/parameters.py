"""Every parameter of CEPA, checked once."""

from __future__ import annotations

import numbers
from dataclasses import dataclass, fields

from cepa.errors import ParameterError
from cepa.identification.response import ResponseModel
from flight_basics.checks import check_limits, limited

SLOW_DETOURS = (0.8, 0.6, 0.4, 0.2)
"""Speed fractions for a UAV that follows slowly (PX4: 0.9 s); config/cepa.yaml uses them."""
STEADY_SIDE = 4.0
"""k_previous at which `improved` keeps its side of a trunk from scan to scan; config/cepa.yaml uses it."""
CLIMB_MAX_M_S = 0.8
"""A faster climb would leave the layers of heights that are looked at, within the horizon of the cost."""
BODY_HEIGHT_MAX_M = 5.0
"""A higher body would fill the layers of heights."""


@dataclass(frozen=True)
class CepaParameters:
    """The parameters of both algorithms; a thesis symbol stands beside each name.

    Raises ParameterError, in one sentence, for values that make no sense alone or together.
    How the weights were tuned is told in doc/how_it_works.md.
    """

    r_lb: float = limited(0.5, above=0.0, live=(0.05, 5.0))
    """Radius r_LB of the inner cushion, m. An obstacle within it is an emergency."""
    r_ub: float = limited(1.2, live=(0.1, 10.0))
    """Radius r_UB of the outer cushion, the comfort zone, m. Obstacles within it cost."""
    time_horizon: float = limited(1.5, above=0.0, live=(0.1, 10.0))
    """Time T, s: the cushions reach |v| T ahead."""
    k_filter: float = limited(50.0, above=0.0, live=(0.01, 1000.0))
    """Greatest slope K of the emergency avoidance's filtered scan, m/rad. If it is lower, near things count
    more.
    """
    k1: float = limited(8.0, 0.0, live=(0.0, 100.0))
    """Original only: weight k_1 of keeping v_ref's direction, s2/m2."""
    k2: float = limited(1.0, 0.0, live=(0.0, 100.0))
    """Weight k_2 of keeping v_ref's magnitude."""
    k3: float = limited(0.5, 0.0, live=(0.0, 100.0))
    """Weight k_3 of intrusions into the outer cushion, 1/m2."""
    k4: float = limited(1.0, 0.0, live=(0.0, 100.0))
    """Improved only: weight k_4, s3/m3, in k_1 = |v_UAV| k_4 + k_5."""
    k5: float = limited(6.0, 0.0, live=(0.0, 100.0))
    """Improved only: weight k_5 of v_ref's direction at a standstill, s2/m2. See k4."""
    k_previous: float = limited(0.0, 0.0, live=(0.0, 100.0))
    """Improved only: weight of leaving the last answer's direction, s2/m2. 0: the thesis."""
    speed_fractions: tuple[float, ...] = (1.0, 0.75, 0.5, 0.25)
    """Speeds tried in every direction, as fractions of |v_ref|, each in (0, 1]. v_ref itself is tried, too.
    """
    body_radius: float = limited(0.35, above=0.0, live=(0.01, 5.0))
    """Radius of the UAV, m, less than r_lb. The emergency avoidance flies only where a body of this radius
    fits.
    """
    emergency_lookahead: float = limited(1.2, above=0.0, live=(0.1, 10.0))
    """Distance over which an emergency's direction must be free, m."""
    emergency_gain: float = limited(10.0, above=0.0, live=(0.1, 1000.0))
    """Emergency speed for one metre radian of intrusion, 1/(s rad)."""
    v_min: float = limited(0.8, 0.0, live=(0.0, 10.0))
    """Least speed of an emergency's answer, m/s."""
    v_max: float = limited(1.0, above=0.0, live=(0.01, 10.0))
    """Greatest speed of an emergency's answer, m/s."""
    emergency_cancellation: float = limited(0.1, 0.0, below=1.0, live=(0.0, 0.99))
    """If the sum is less than this share of the intrusions, it counts as zero (0: opposed, 1: one side)."""
    emergency_tie_angle: float = limited(0.3, 0.0, live=(0.0, 3.2))
    """Open sections that differ by less are tied, rad. The one along the UAV's own velocity wins."""
    reference_speed_min: float = limited(0.05, above=0.0, live=(0.001, 1.0))
    """A slower v_ref means hover, m/s. It is never 0, because equation 6.5 divides by |v_ref|."""
    dropout_beams: int = limited(4, 0, live=(0, 100))
    """Invalid beams in a row that take the smaller range of their neighbours. A longer gap is unseen."""
    unseen_is_free: bool = False
    """Whether a direction that no beam covers may be chosen."""
    self_filter: bool = False
    """Whether returns of the UAV itself, such as its arms, are left out. What is behind them is unseen."""
    velocity_aware_emergency: bool = False
    """Whether what the UAV cannot brake for is an emergency, too. See emergency_edge in cushion.py."""
    braking_deceleration: float = limited(4.0, above=0.0, live=(0.1, 50.0))
    """Deceleration a of the UAV in an emergency, m/s2. The stopping distance is v^2 / 2a + v *
    braking_latency.
    """
    braking_latency: float = limited(0.25, 0.0, live=(0.0, 2.0))
    """Time from a scan until the UAV begins to brake, s."""
    margin: float = limited(0.05, 0.0, live=(0.0, 2.0))
    """Dynamic only: distance kept beyond body_radius and the response's error, m, for errors of the scan."""
    commit_s: float = limited(0.1, above=0.0, live=(0.01, 0.5))
    """Dynamic only: an answer is safe to fly for so long, s, or for two scans. It is more on a slow chain."""
    memory_s: float = limited(20.0, 0.0, live=(0.0, 600.0))
    """Dynamic only: time for which what was seen is remembered, s. 0: not at all."""
    window_m: float = limited(20.0, live=(0.0, 30.0))
    """Dynamic only: edge of the square around the UAV in which it looks for ways out, m, 5 to 30. 0: no
    search.
    """
    climb_max: float = limited(0.8, 0.0, CLIMB_MAX_M_S)
    """Dynamic only: greatest climb and descent to avoid something, m/s, by clouds only. 0: it stays level."""
    height_min: float = limited(0.3, live=(-1000.0, 1000.0))
    """Dynamic only: least z of the lidar in the odometry's frame that it descends to, m."""
    height_max: float = limited(1000.0, live=(-1000.0, 1000.0))
    """Dynamic only: greatest z of the lidar that it climbs to, m."""
    planar_speed_max: float = limited(1000.0, above=0.0, live=(0.1, 1000.0))
    """Dynamic only: greatest speed while no cloud shows what is over and under the scan's plane, m/s."""
    body_below: float = limited(0.3, above=0.0, live=(0.01, 5.0))
    """Dynamic only: how far the UAV reaches below the lidar, m, also when it leans."""
    body_above: float = limited(0.15, above=0.0, live=(0.01, 5.0))
    """Dynamic only: how far it reaches above the lidar, m."""
    response_p: float = limited(ResponseModel.p, live=(0.01, 100.0))
    """Dynamic only: acceleration per velocity error, 1/s. See response.py, as for all response_*."""
    response_i: float = limited(ResponseModel.i, live=(0.0, 100.0))
    """Dynamic only: growth of this acceleration per second, 1/s2."""
    response_d: float = limited(ResponseModel.d, live=(0.0, 10.0))
    """Dynamic only: damping, as a share of the UAV's own acceleration."""
    response_lag: float = limited(ResponseModel.lag_s, live=(0.001, 5.0))
    """Dynamic only: time constant from the wanted to the flown acceleration, s."""
    response_delay: float = limited(ResponseModel.delay_s, live=(0.0, 1.0))
    """Dynamic only: time from a command until the acceleration changes, s."""
    response_acceleration_max: float = limited(ResponseModel.acceleration_max_m_s2, live=(0.1, 50.0))
    """Dynamic only: greatest acceleration that is counted on, m/s2."""
    response_jerk_max: float = limited(ResponseModel.jerk_max_m_s3, live=(1.0, 1000.0))
    """Dynamic only: greatest change of the acceleration, m/s3."""
    response_error: float = limited(ResponseModel.error_m_s2, live=(0.0, 10.0))
    """Dynamic only: bound of the disturbing acceleration that it withstands, m/s2."""
    levelling: bool = False
    """Whether beams that end on floor or ceiling are dropped. Whoever steers does so, see levelling.py."""
    floor_height: float = limited(0.0, live=(-1000.0, 1000.0))
    """z of the floor in the frame of the odometry, m."""
    ceiling_height: float = limited(1000.0, live=(-1000.0, 1000.0))
    """z of the ceiling in the frame of the odometry, m."""
    floor_margin: float = limited(0.15, 0.0, live=(0.0, 2.0))
    """A beam that ends so near to the height of floor or ceiling has hit it, m."""

    @property
    def response(self) -> ResponseModel:
        """The UAV's velocity loop; raises ParameterError for one that makes no sense."""
        return ResponseModel(
            self.response_p,
            self.response_i,
            self.response_d,
            self.response_lag,
            self.response_delay,
            self.response_acceleration_max,
            self.response_jerk_max,
            self.response_error,
        )

    def __post_init__(self) -> None:
        self._take_numbers()
        check_limits(self, ParameterError)
        self._check_combinations()

    def _take_numbers(self) -> None:
        """Let numbers of numpy be Python's, and sort the fractions."""
        for field in fields(self):
            value = getattr(self, field.name)
            if isinstance(value, numbers.Real) and not isinstance(value, bool):
                number = int(value) if isinstance(value, numbers.Integral) else float(value)
                object.__setattr__(self, field.name, number)
        try:
            fractions = tuple(float(fraction) for fraction in self.speed_fractions)
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(f"speed_fractions must be numbers, not {self.speed_fractions!r}.") from None
        object.__setattr__(self, "speed_fractions", tuple(sorted(set(fractions), reverse=True)))

    def _check_combinations(self) -> None:
        if not self.r_lb < self.r_ub:
            raise ParameterError(f"r_lb must be less than r_ub, but {self.r_lb} >= {self.r_ub}.")
        if not self.body_radius < self.r_lb:
            raise ParameterError(
                f"body_radius must be less than r_lb, or an emergency starts after the collision, "
                f"but {self.body_radius} >= {self.r_lb}."
            )
        if not self.v_min <= self.v_max:
            raise ParameterError(f"v_min must be at most v_max, but {self.v_min} > {self.v_max}.")
        if self.window_m != 0.0 and not 5.0 <= self.window_m <= 30.0:
            raise ParameterError(
                f"window_m must be 0 (no search for ways out) or 5 to 30, not {self.window_m}."
            )
        if not self.height_min < self.height_max:
            raise ParameterError(
                f"height_min must be less than height_max, but {self.height_min} >= {self.height_max}."
            )
        if not self.body_below + self.body_above <= BODY_HEIGHT_MAX_M:
            raise ParameterError(
                f"body_below and body_above must be at most {BODY_HEIGHT_MAX_M:g} m together, "
                f"not {self.body_below} and {self.body_above}."
            )
        _ = self.response  # it raises what makes no sense
        if not self.floor_height < self.ceiling_height:
            raise ParameterError(
                f"floor_height must be less than ceiling_height, "
                f"but {self.floor_height} >= {self.ceiling_height}."
            )
        if not self.speed_fractions or not all(0.0 < fraction <= 1.0 for fraction in self.speed_fractions):
            raise ParameterError(
                f"speed_fractions must be one or more numbers in (0, 1], not {list(self.speed_fractions)}."
            )
