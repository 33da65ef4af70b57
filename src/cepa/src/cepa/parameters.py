"""Every parameter of CEPA, checked once."""

from __future__ import annotations

import numbers
import sys
from dataclasses import dataclass, fields

from cepa.errors import ParameterError
from cepa.identification.response import ResponseModel

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

    r_lb: float = 0.5
    """r_LB, m: radius of the inner cushion; an obstacle within it is an emergency."""
    r_ub: float = 1.2
    """r_UB, m: radius of the outer cushion, the comfort zone."""
    time_horizon: float = 1.5
    """T, s: the cushions reach |v| T ahead."""
    k_filter: float = 50.0
    """K, m/rad: greatest slope of the emergency avoidance's filtered scan; lower: near things count more."""
    k1: float = 8.0
    """k_1, s2/m2, original only: weight of keeping v_ref's direction."""
    k2: float = 1.0
    """k_2: weight of keeping v_ref's magnitude."""
    k3: float = 0.5
    """k_3, 1/m2: weight of intrusions into the outer cushion."""
    k4: float = 1.0
    """k_4, s3/m3, improved only: k_1 = |v_UAV| k_4 + k_5."""
    k5: float = 6.0
    """k_5, s2/m2, improved only: see k4."""
    k_previous: float = 0.0
    """k_previous, s2/m2, improved only: weight of leaving the last answer's direction; 0: the thesis."""
    speed_fractions: tuple[float, ...] = (1.0, 0.75, 0.5, 0.25)
    """Speeds tried in every direction, as fractions of |v_ref|, each in (0, 1]; v_ref itself is tried too."""
    body_radius: float = 0.35
    """m: radius of the UAV; the emergency avoidance flies only where a body of this radius fits."""
    emergency_lookahead: float = 1.2
    """m: how far ahead an emergency's direction must be free."""
    emergency_gain: float = 10.0
    """1/(s rad): velocity for one metre radian of intrusion."""
    v_min: float = 0.8
    """m/s: least speed of an emergency's answer."""
    v_max: float = 1.0
    """m/s: greatest speed of an emergency's answer."""
    emergency_cancellation: float = 0.1
    """If the sum is less than this share of the intrusions, it counts as zero (0: opposed, 1: one side)."""
    emergency_tie_angle: float = 0.3
    """rad: open sections that differ by less are tied; the one along the UAV's own velocity wins."""
    reference_speed_min: float = 0.05
    """m/s: a slower v_ref means hover."""
    dropout_beams: int = 4
    """Invalid beams in a row that take the smaller range of their neighbours; a longer gap is unseen."""
    unseen_is_free: bool = False
    """Whether a direction that no beam covers may be chosen."""
    velocity_aware_emergency: bool = False
    """Whether what the UAV cannot brake for is an emergency too; see emergency_edge in cushion.py."""
    braking_deceleration: float = 4.0
    """a, m/s2: of the UAV in an emergency; the stopping distance is v^2 / 2a + v * braking_latency."""
    braking_latency: float = 0.25
    """s: from a scan until the UAV begins to brake."""
    margin: float = 0.05
    """m, dynamic only: kept beyond body_radius and the response's error, for errors of the scan."""
    commit_s: float = 0.1
    """s, dynamic only: an answer is safe to fly for so long, or for two scans; more on a slow chain."""
    memory_s: float = 20.0
    """s, dynamic only: how long what was seen is remembered; 0: not at all."""
    window_m: float = 20.0
    """m, dynamic only: edge of the square around the UAV in which it looks for ways out; 0: no search."""
    climb_max: float = 0.8
    """m/s, dynamic only: greatest climb and descent to avoid something, by clouds only; 0: it stays level."""
    height_min: float = 0.3
    """m, dynamic only: least z of the lidar in the odometry's frame that it descends to."""
    height_max: float = 1000.0
    """m, dynamic only: greatest z of the lidar that it climbs to."""
    planar_speed_max: float = 1000.0
    """m/s, dynamic only: greatest speed while no cloud shows what is over and under the scan's plane."""
    body_below: float = 0.3
    """m, dynamic only: how far the UAV reaches below the lidar, also when it leans."""
    body_above: float = 0.15
    """m, dynamic only: how far it reaches above the lidar."""
    response_p: float = 1.5
    """1/s, dynamic only: see response.py, as for all response_*."""
    response_i: float = 0.0
    """1/s2"""
    response_d: float = 0.0
    """Share of the own acceleration."""
    response_lag: float = 0.056
    """s"""
    response_delay: float = 0.048
    """s"""
    response_acceleration_max: float = 6.0
    """m/s2"""
    response_jerk_max: float = 36.0
    """m/s3"""
    response_error: float = 0.4
    """m/s2"""
    levelling: bool = False
    """Whether beams that end on floor or ceiling are dropped; whoever steers does so, see levelling.py."""
    floor_height: float = 0.0
    """m: z of the floor in the frame of the odometry."""
    ceiling_height: float = 1000.0
    """m: z of the ceiling in the frame of the odometry."""
    floor_margin: float = 0.15
    """m: a beam that ends so near to the height of floor or ceiling has hit it."""

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
        self._check_types()
        self._check_signs()
        self._check_combinations()

    def _check_types(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if field.name == "speed_fractions":
                continue
            if isinstance(field.default, bool):
                if not isinstance(value, bool):
                    raise ParameterError(f"{field.name} must be true or false, not {value!r}.")
                continue
            is_number = isinstance(value, numbers.Real) and not isinstance(value, bool)
            if not is_number or not abs(value) <= sys.float_info.max:  # NaN fails this test too
                raise ParameterError(f"{field.name} must be a finite number, not {value!r}.")
            number = int(value) if isinstance(value, numbers.Integral) else float(value)
            object.__setattr__(self, field.name, number)
        try:
            fractions = tuple(float(fraction) for fraction in self.speed_fractions)
        except (TypeError, ValueError, OverflowError):
            raise ParameterError(f"speed_fractions must be numbers, not {self.speed_fractions!r}.") from None
        object.__setattr__(self, "speed_fractions", tuple(sorted(set(fractions), reverse=True)))

    def _check_signs(self) -> None:
        positive = (
            "r_lb",
            "time_horizon",
            "k_filter",
            "body_radius",
            "emergency_lookahead",
            "emergency_gain",
            "braking_deceleration",
            "commit_s",
            "planar_speed_max",
            "body_below",
            "body_above",
        )
        for name in positive:
            if not getattr(self, name) > 0.0:
                raise ParameterError(f"{name} must be greater than 0, not {getattr(self, name)}.")
        at_least_zero = (
            "k1",
            "k2",
            "k3",
            "k4",
            "k5",
            "k_previous",
            "v_min",
            "emergency_cancellation",
            "emergency_tie_angle",
            "braking_latency",
            "margin",
            "memory_s",
            "floor_margin",
        )
        for name in (*at_least_zero, "dropout_beams"):
            if not getattr(self, name) >= 0:
                raise ParameterError(f"{name} must be at least 0, not {getattr(self, name)}.")
        if not self.reference_speed_min > 0.0:
            raise ParameterError(
                f"reference_speed_min must be greater than 0 (equation 6.5 divides by |v_ref|), "
                f"not {self.reference_speed_min}."
            )
        if int(self.dropout_beams) != self.dropout_beams:
            raise ParameterError(f"dropout_beams must be a whole number, not {self.dropout_beams}.")

    def _check_combinations(self) -> None:
        if not self.r_lb < self.r_ub:
            raise ParameterError(f"r_lb must be less than r_ub, but {self.r_lb} >= {self.r_ub}.")
        if not self.body_radius < self.r_lb:
            raise ParameterError(
                f"body_radius must be less than r_lb, or an emergency starts after the collision, "
                f"but {self.body_radius} >= {self.r_lb}."
            )
        if not self.v_min <= self.v_max or not self.v_max > 0.0:
            raise ParameterError(
                f"v_min must be at most v_max and v_max greater than 0, not {self.v_min} and {self.v_max}."
            )
        if self.emergency_cancellation >= 1.0:
            raise ParameterError(
                f"emergency_cancellation must be less than 1, not {self.emergency_cancellation}."
            )
        if self.window_m != 0.0 and not 5.0 <= self.window_m <= 30.0:
            raise ParameterError(
                f"window_m must be 0 (no search for ways out) or 5 to 30, not {self.window_m}."
            )
        if not 0.0 <= self.climb_max <= CLIMB_MAX_M_S:
            raise ParameterError(f"climb_max must be from 0 to {CLIMB_MAX_M_S} m/s, not {self.climb_max}.")
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
